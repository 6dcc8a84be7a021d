//! The audio thread neither allocates nor frees.

#[path = "../common/mod.rs"]
mod common;
mod counter;
mod knob;
mod motors;

use pacinian::space::spot::Spot;

#[cfg(feature = "fundsp-nodes")]
use common::scenes::leaves;
use common::scenes::{busy, every};
use common::storm::{due, event};
use common::{compiled, patch, play};
use counter::{counted, held};
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::engine::exchange::exchange;
use pacinian::engine::meter::Meter;
use pacinian::engine::task::{Task, Values};
use pacinian::graph::budget::Need;
use pacinian::graph::plan::{Plan, Precision};
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::{Asset, Assets, NoAssets};
use pacinian::rig::Rig;
use pacinian::schedule::{Beat, Instant};

#[cfg(feature = "fundsp-nodes")]
#[test]
fn units_of_fundsp_have_all_memory_from_the_beginning() {
    let plan = compiled(&leaves(24, 8), 16, 48_000.0).plan;
    let (_director, mut stagehand) = exchange(&plan).unwrap();
    let mut frames = vec![0.0; 480 * 16];
    let mut total = 0;
    for begin in (0..10_000_u32).step_by(20) {
        total += counted(|| {
            for i in begin..begin + 20 {
                let at = Instant { sample: stagehand.engine().clock() + u64::from(i % 80), fraction: 7 };
                // From below the lowest string to above the highest, up and down.
                let frequency = f64::from(i.wrapping_mul(613) % 1200);
                stagehand.engine().schedule(
                    at,
                    Source::Program,
                    Event::Play(play(0, i % 16, frequency, 0.003, u64::from(i))),
                );
            }
            stagehand.process(&[], &mut frames);
        });
        assert!(frames.iter().all(|x| x.is_finite()) && frames.iter().any(|x| *x != 0.0));
    }
    assert_eq!(total, 0, "allocations and frees");
    assert!(stagehand.engine().counters().started > 9_000);
}

#[test]
fn a_hundred_thousand_events_and_a_hundred_plans() {
    let first = compiled(&busy(24, 8), 16, 48_000.0).plan;
    let second = compiled(&busy(24, 8).replace("time = 0.01", "time = 0.02"), 16, 48_000.0).plan;
    let (mut director, mut stagehand) = exchange(&first).unwrap();
    let mut frames = vec![0.0; 480 * 16];
    let (mut total, mut sent, mut events) = (0, 0_u32, 0_u32);
    while events < 100_000 || sent < 100 {
        if events.is_multiple_of(1000)
            && director.send(if sent.is_multiple_of(2) { &second } else { &first }).unwrap()
        {
            sent += 1;
        }
        let begin = events;
        total += counted(|| {
            for i in begin..begin + 100 {
                let at = due(stagehand.engine().clock(), i);
                stagehand.engine().schedule(at, Source::Program, event(i));
            }
            stagehand.process(&[], &mut frames);
        });
        events += 100;
    }
    assert_eq!(total, 0, "allocations and frees in {events} events and {sent} plans");
    assert!(stagehand.engine().counters().started > 50_000);
}

/// States of every node are copied where a plan takes over, recordings of both plans included.
#[test]
fn every_node_is_copied_in_place() {
    struct Hum;
    impl Assets for Hum {
        fn load(&self, _path: &str, _channel: usize) -> Result<std::sync::Arc<Asset>, String> {
            let samples = (0..4_800).map(|n| (n as f32 * 0.02).sin()).collect();
            Ok(std::sync::Arc::new(Asset { samples, rate: 48_000.0 }))
        }
    }
    let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
    let texts = [
        [0.1, 0.2].map(every),
        // What that delay remembers is copied ahead.
        [0.1, 0.2].map(|level| every(level).replace("longest = 0.05", "longest = 60")),
        #[cfg(feature = "fundsp-nodes")]
        ["180", "200"].map(|hertz| leaves(12, 8).replace("180", hertz)),
    ];
    for texts in texts {
        let plan = |text: &String| {
            scene(&patch(text), &Rig::default_for(2), &options, &Hum).unwrap_or_else(|p| panic!("{p}")).plan
        };
        let plans = [plan(&texts[0]), plan(&texts[1])];
        let (mut director, mut stagehand) = exchange(&plans[0]).unwrap();
        let mut frames = vec![0.0; 480 * 2];
        let (mut total, mut sent) = (0, 0);
        for n in 0..900_u32 {
            if n % 7 == 3 {
                // The one that went back is freed, and one of its own is made; the audio thread has no part in it.
                sent += usize::from(director.send(&plan(&texts[(sent + 1) % 2])).unwrap());
            }
            total += counted(|| {
                let at = Instant { sample: stagehand.engine().clock() + 3, fraction: 7 };
                let play = play(0, n % 2, 60.0, 0.05, u64::from(n));
                stagehand.engine().schedule(at, Source::Program, Event::Play(play));
                stagehand.process(&[], &mut frames);
            });
            assert!(frames.iter().all(|x| x.is_finite()));
        }
        assert!(frames.iter().any(|x| x.abs() > 1e-3));
        assert!(sent > 90, "{sent}");
        assert_eq!(total, 0, "allocations and frees");
    }
}

/// Points anywhere, also where there is no number, on lines, surfaces and clouds of tactors, with and without a width.
#[test]
fn points_anywhere() {
    let line = Rig::default_for(16);
    let mut sheet = line.clone();
    let mut cloud = line.clone();
    for (n, (flat, deep)) in sheet.outputs.iter_mut().zip(&mut cloud.outputs).enumerate() {
        let [x, y] = [(n % 4) as f64 * 0.05, (n / 4) as f64 * 0.03];
        flat.position = Some([x, y, 0.0]);
        deep.position = Some([x, y, ((n * 7) % 5) as f64 * 0.04]);
    }
    for rig in [line, sheet, cloud] {
        for keys in ["", "width = 0.01", "width = 0.2\nlaw = \"logarithmic\"", "law = \"nearest\""] {
            let text = format!(
                "[voice.v]\noutput = \"s\"\nvoices = 16\n{keys}\n[voice.v.nodes]\ns = {{ type = \"sine\", frequency = 150 }}\n"
            );
            let options = Options { live: true, ..Options::default() };
            let plan = scene(&patch(&text), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan;
            let mut engine = Engine::new(&plan).unwrap();
            let mut frames = vec![0.0; 480 * 16];
            let mut total = 0;
            for round in 0..40_u32 {
                total += counted(|| {
                    for i in 20 * round..20 * round + 20 {
                        let wild = |n: u32| match i.wrapping_mul(n) % 29 {
                            0 => f64::NAN,
                            1 => f64::INFINITY,
                            2 => -1e300,
                            far => f64::from(far) * 0.02 - 0.2,
                        };
                        let place = Spot::Point([wild(7), wild(11), wild(13)]);
                        let at = Instant { sample: engine.clock() + u64::from(i % 80), fraction: 7 };
                        let one = Play { place, ..play(0, 0, 150.0, 0.003, u64::from(i)) };
                        engine.schedule(at, Source::Program, Event::Play(one));
                    }
                    engine.process(&mut frames);
                });
                assert!(frames.iter().all(|x| x.is_finite()) && frames.iter().any(|x| *x != 0.0));
            }
            assert_eq!(total, 0, "allocations and frees: {keys}");
            assert!(engine.counters().started > 790);
        }
    }
}

/// Voices on paths, quick and slow, and such as noise throws about, by every law.
#[test]
fn voices_that_move() {
    for law in ["energy", "logarithmic", "linear", "nearest"] {
        for width in [0.0, 0.01] {
            let text = moving(law, width, 16);
            let plan = compiled(&text, 16, 48_000.0).plan;
            let mut engine = Engine::new(&plan).unwrap();
            let mut frames = vec![0.0; 480 * 16];
            let mut total = 0;
            for round in 0..40_u32 {
                total += counted(|| {
                    for i in 8 * round..8 * round + 8 {
                        let own = plan.play(if i.is_multiple_of(2) { "path" } else { "noise" }, &[]).unwrap();
                        let at = Instant { sample: engine.clock() + u64::from(i % 80), fraction: 7 };
                        let one = Play { duration: 0.01, id: u64::from(i), ..own };
                        engine.schedule(at, Source::Program, Event::Play(one));
                    }
                    engine.process(&mut frames);
                });
                assert!(frames.iter().all(|x| x.is_finite()) && frames.iter().any(|x| *x != 0.0));
            }
            assert_eq!(total, 0, "allocations and frees: {law} {width}");
            assert!(engine.counters().started > 310);
        }
    }
}

/// A voice on a path, and one that noise throws about.
fn moving(law: &str, width: f64, voices: usize) -> String {
    format!(
        "[voice.path]\noutput = \"s\"\nvoices = {voices}\nlaw = \"{law}\"\nwidth = {width}\n\
         place = {{ path = [[-0.1, 0], [0.5, 0.1], [0, 0]], times = [0, 0.005, 1] }}\n[voice.path.nodes]\n\
         s = {{ type = \"sine\", frequency = 150 }}\n\
         [voice.noise]\noutput = \"s\"\nvoices = {voices}\nlaw = \"{law}\"\nwidth = {width}\n[voice.noise.nodes]\n\
         s = {{ type = \"sine\", frequency = 150 }}\nn = {{ type = \"white\" }}\n\
         here = {{ type = \"place\", x = \"0.3 + n\", y = \"n / 0\", width = \"0.1 * n\" }}\n"
    )
}

/// Voices that say how strongly they are felt, on groups, points and motors, with numbers that cannot be.
#[test]
fn what_is_felt() {
    let rig = "format = \"pacinian-rig/1\"\n[device]\nchannels = 12\nfull_scale_volts = 1\n[calibration.c]\ndate = 2026-03-14\nmethod = \"m\"\n\
        area = 1e-5\nunit = \"um/V\"\ntable = [[40, 30], [100, 28], [250, 22], [400, 6]]\n";
    let tactor = |n: u32| {
        let calibration = if n.is_multiple_of(3) { "" } else { "calibration = \"c\"\n" };
        format!(
            "[[tactor]]\nname = \"t{n}\"\nchannel = {n}\nposition = [{}, {}]\n{calibration}",
            n % 4,
            n / 4
        )
    };
    let tactors: String = (1..=12).map(tactor).collect();
    let group = "[group.all]\ntactors = [\"t1\", \"t2\", \"t3\", \"t4\", \"t5\", \"t12\"]\n";
    let rig = Rig::parse("r.toml", format!("{rig}{tactors}{group}").as_bytes())
        .unwrap_or_else(|p| panic!("{p}"))
        .value;
    let text = "[voice.v]\nvoices = 16\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = \"event.frequency\" }\n";
    let options = Options { live: true, ..Options::default() };
    let plan = scene(&patch(text), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan;
    let mut engine = Engine::new(&plan).unwrap();
    let mut frames = vec![0.0; 480 * 12];
    let mut total = 0;
    for round in 0..40_u32 {
        total += counted(|| {
            for i in 20 * round..20 * round + 20 {
                let felt = [20.0, f64::NAN, f64::INFINITY, -1e300, 1e300, 3.0][i as usize % 6];
                let hertz = [100.0, 0.0, f64::NAN, -5.0, 1e9, 250.0, 77.7][i as usize % 7];
                let place = if i % 2 == 0 {
                    Spot::Row(i % 14)
                } else {
                    Spot::Point([0.3 * f64::from(i % 9), 0.7, 0.0])
                };
                let at = Instant { sample: engine.clock() + u64::from(i % 80), fraction: 7 };
                let level = if i.is_multiple_of(5) { 0.0 } else { 0.5 };
                let one = Play { place, felt: Some(felt), level, ..play(0, 0, hertz, 0.003, u64::from(i)) };
                engine.schedule(at, Source::Program, Event::Play(one));
            }
            engine.process(&mut frames);
        });
        assert!(frames.iter().all(|x| x.is_finite()) && frames.iter().any(|x| *x != 0.0));
    }
    assert_eq!(total, 0, "allocations and frees");
    assert!(engine.counters().started > 790);
}

/// Sends a control to where a shared node is, at every sample.
struct Servo(usize);

impl Task for Servo {
    fn beat(&self) -> Beat {
        Beat::every(1)
    }
    fn run(&mut self, board: &mut dyn Values) {
        let value = board.signal(self.0);
        board.send(0, value);
    }
}

#[test]
fn periodic_tasks() {
    let plan = compiled(&busy(24, 8), 16, 48_000.0).plan;
    let mut engine = Engine::new(&plan).unwrap();
    let (meter, level) = Meter::new(plan.signal("wobble").unwrap(), Beat::every(1));
    engine.add_task(Box::new(meter));
    engine.add_task(Box::new(Servo(plan.signal("wobble").unwrap())));
    engine.schedule(Instant::default(), Source::Program, Event::Play(play(0, 3, 80.0, 10.0, 1)));
    let mut frames = vec![0.0; 480 * 16];
    let total = counted(|| {
        for _ in 0..200 {
            engine.process(&mut frames);
            std::hint::black_box(level.take_peak());
        }
    });
    assert_eq!(total, 0);
    assert_ne!(level.latest(), 0.0);
}

/// Nodes of many kinds in few and in many voices.
#[test]
fn memory_is_what_was_foreseen() {
    let delay = "[voice.v]\nvoices = 40\noutput = \"d\"\n[voice.v.nodes]\ns = { type = \"white\" }\n\
        d = { type = \"delay\", input = \"s\", time = 0.1, longest = 0.5 }\n";
    let wide = busy(2000, 8);
    #[allow(unused_mut)]
    let mut scenes = vec![(delay.to_string(), 2), (busy(24, 8), 16), (wide.clone(), 16), (wide, 256)];
    scenes.push((moving("energy", 0.0, 1000), 256));
    #[cfg(feature = "fundsp-nodes")]
    scenes.push((leaves(500, 8), 4));
    for (text, channels) in scenes {
        let plan = compiled(&text, channels, 48_000.0).plan;
        for plan in [plan.clone(), Plan { precision: Precision::Double, ..plan }] {
            let foreseen = Need::of(&plan).bytes as f64;
            // Tables that all engines share are made with the first.
            drop(Engine::new(&plan).unwrap());
            let (taken, engine) = held(|| Engine::new(&plan).unwrap());
            let taken = taken as f64;
            drop(engine);
            // A little is always there.
            let (least, most) = (0.75 * taken, 1.25 * taken + f64::from(4 << 20));
            assert!(
                (least..most).contains(&foreseen),
                "{channels} channels: {foreseen} foreseen, {taken} taken"
            );
        }
    }
}

/// What a session's callback does besides, as a device calls it: cues from rings, orders to the gate, reports, meters, the recording, clocks.
#[cfg(feature = "live")]
#[test]
fn a_callback_in_a_storm_of_events_orders_and_plans() {
    use common::storm::pull;
    use pacinian::live::board::Board;
    use pacinian::live::callback::{Callback, Cue};
    use pacinian::live::driver::Driver;
    use pacinian::live::gate::{Gate, Order};
    use pacinian::live::stamp::Epoch;
    use ringbuf::HeapRb;
    use ringbuf::traits::{Consumer, Producer, Split};

    let first = compiled(&busy(24, 8), 16, 48_000.0).plan;
    let second = compiled(&busy(24, 8).replace("time = 0.01", "time = 0.02"), 16, 48_000.0).plan;
    let (mut director, stagehand) = exchange(&first).unwrap();
    let board = std::sync::Arc::new(Board::new(16));
    let gate = Gate::new(48_000.0, 1.0);
    let (mut callback, mut rings) = Callback::new(stagehand, gate, std::sync::Arc::clone(&board));
    let (out, mut back) = HeapRb::new(16 * 960).split();
    callback.record(out);
    callback.time(|| 0);
    let (mut driver, _clock) =
        Driver::new(callback, 48_000.0, 128, Epoch::begin(), std::sync::Arc::clone(&board));
    let mut frames = vec![0.0; 128 * 16];
    let (mut total, mut sent, mut events, mut reports) = (0, 0_u32, 0_u32, 0);
    while events < 100_000 || sent < 100 {
        let plan = if sent.is_multiple_of(2) { &second } else { &first };
        if events.is_multiple_of(1000) && director.send(plan).unwrap() {
            sent += 1;
        }
        for i in events..events + 50 {
            let cue = Cue { plan: u64::from(sent), at: due(board.clock.get(), i), event: event(i), cause: 0 };
            assert!(rings.cues[(i % 2) as usize].try_push(cue).is_ok());
        }
        events += 50;
        match events % 5000 {
            1000 => board.panic(),
            2000 => board.calm(),
            _ => {}
        }
        pull(&board, events / 50);
        total += counted(|| driver.move_to(128, Order::Return));
        total += counted(|| driver.fill(&mut frames));
        assert!(frames.iter().all(|x| x.is_finite()));
        reports += std::iter::from_fn(|| rings.reports.try_pop()).count();
        // What is not fetched finds no room one day, and is counted.
        if events.is_multiple_of(500) {
            back.clear();
        }
    }
    assert_eq!(total, 0, "allocations and frees in {events} events, {reports} reports and {sent} plans");
    assert!(board.started.get() > 50_000 && reports > 100_000);
    assert!(board.unrecorded.get() > 0 && board.untold.get() == 0);
    assert_eq!(board.load.count(), u64::from(events / 50));
}

#[cfg(feature = "live")]
#[test]
fn what_a_device_hears_comes_to_another_without_memory() {
    use common::storm::listen;
    use pacinian::live::board::Board;
    use pacinian::live::intake::{Ears, bridge};
    use pacinian::live::stamp::Epoch;

    let board = std::sync::Arc::new(Board::new(1));
    let ears = Ears { rate: 44_100.0, channels: 2, block: 128 };
    let (mut intake, mut feed) = bridge(ears, 48_000.0, 64, Epoch::begin(), &board);
    let mut heard = 0.0;
    let total = counted(|| heard = listen(&mut intake, &mut feed, &board));
    assert_eq!(total, 0);
    assert!(
        heard > 0.24 && board.input.lost.get() > 0 && board.input.dry.get() > 0,
        "{heard} {:?}",
        board.input
    );
}
