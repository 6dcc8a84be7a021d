//! The audio thread neither allocates nor frees.

mod common;

use pacinian::space::spot::Spot;
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

#[cfg(feature = "fundsp-nodes")]
use common::scenes::leaves;
use common::scenes::{busy, every};
use common::storm::{due, event};
use common::{compiled, patch, play};
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

thread_local! {
    static COUNT: Cell<Option<u64>> = const { Cell::new(None) };
    /// Bytes taken by this thread and not given back.
    static HELD: Cell<i64> = const { Cell::new(0) };
}

struct Counting;

fn hold(bytes: i64) {
    let _ = HELD.try_with(|held| held.set(held.get() + bytes));
}

fn count() {
    // A thread that is ending has no counter any more, and is not counted.
    let _ = COUNT.try_with(|c| c.set(c.get().map(|n| n + 1)));
}

// SAFETY: every call goes to the system's allocator unchanged; counting touches a thread-local number only.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count();
        hold(layout.size() as i64);
        // SAFETY: the caller's promise, handed on.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count();
        hold(-(layout.size() as i64));
        // SAFETY: the caller's promise, handed on.
        unsafe { System.dealloc(pointer, layout) }
    }
    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        count();
        hold(size as i64 - layout.size() as i64);
        // SAFETY: the caller's promise, handed on.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Allocations and frees of this thread while `work` runs.
fn counted(work: impl FnOnce()) -> u64 {
    COUNT.with(|c| c.set(Some(0)));
    work();
    COUNT.with(|c| c.replace(None)).unwrap_or(0)
}

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
fn the_counter_counts() {
    assert!(counted(|| drop(std::hint::black_box(vec![0_u8; 10]))) >= 2);
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
        #[cfg(feature = "fundsp-nodes")]
        ["180", "200"].map(|hertz| {
            let bodies = leaves(12, 8).replace("180", hertz);
            // A string cannot be copied, and then nothing is.
            let strings = bodies.find("[voice.string]").unwrap_or(bodies.len());
            bodies[..strings].replace("pluck\", frequency = \"event.frequency\"", "white\"")
        }),
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
            HELD.with(|held| held.set(0));
            let engine = Engine::new(&plan).unwrap();
            let taken = HELD.with(Cell::get) as f64;
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

/// What a session's callback does besides: cues from rings, orders to the gate, reports, meters, the recording.
#[cfg(feature = "live")]
#[test]
fn a_callback_in_a_storm_of_events_orders_and_plans() {
    use common::storm::pull;
    use pacinian::live::board::Board;
    use pacinian::live::callback::{Callback, Cue};
    use pacinian::live::gate::{Gate, Order};
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
        total += counted(|| callback.order(Order::Return));
        total += counted(|| callback.process(&[], &mut frames));
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

/// Motors: levels and orders of all kinds, on all of them, more than there is room for; and the same behind rectifiers.
#[test]
fn motors_that_are_ordered_about() {
    use common::scenes::{MOTORS, MOVES};

    motors_are_ordered_about(MOTORS, MOVES);
    let mut carried = MOTORS.to_string();
    for gain in ["gain = 3.0\n", "gain = -3.0\n"] {
        carried = carried.replace(gain, &format!("drive = \"carrier\"\ndiode_drop = 1.4\n{gain}"));
    }
    motors_are_ordered_about(&carried, &MOVES.replace("turns = -1.5", "turns = 1.5"));
    // And so warm that much of it is held back.
    let warm = "max_heating = 5\nwinding_to_housing = 137\nhousing_to_air = 594\nwinding_time = 0.1\nhousing_time = 4\nmax_rms_volts = 2\n";
    let carried = carried.replace("part = \"coin-10mm\"\n", &format!("part = \"coin-10mm\"\n{warm}"));
    motors_are_ordered_about(&carried, &MOVES.replace("turns = -1.5", "turns = 1.5"));
}

/// Clicks that the motor's model ends, as it is known where the mass hangs.
#[test]
fn clicks_after_the_way_home() {
    use common::scenes::MOTORS;

    let rig = MOTORS.replace("amplifier = \"bridge\"\n", "amplifier = \"bridge\"\ntilt = 0.0\n");
    let moves = "[voice.home]\noutput = \"go\"\n[voice.home.nodes]\ngo = { type = \"drive-home\" }\n[voice.click]\noutput = \"tap\"\n\
         [voice.click.nodes]\ntap = { type = \"drive-click\" }\n";
    let mut engine = with_motors(&rig, moves);
    let mut frames = vec![0.0; 480 * 3];
    let (mut total, mut moved) = (0, 0.0_f32);
    for n in 0..400_u32 {
        let ordered = |instrument: u32, level: f64| {
            Event::Play(Play { level, ..play(instrument, 1, 0.0, 0.01, u64::from(n)) })
        };
        total += counted(|| {
            let at = Instant { sample: engine.clock() + 3, fraction: 1 << 30 };
            if n == 2 {
                engine.schedule(at, Source::Program, ordered(0, 1.0));
            } else if n > 120 && n % 10 == 0 {
                let level = if n % 20 == 0 { 1.0 } else { -0.5 };
                engine.schedule(at, Source::Program, ordered(1, level));
            }
            engine.process(&mut frames);
        });
        moved = frames.iter().fold(moved, |most, x| most.max(x.abs()));
        if n == 120 || n == 170 {
            assert!(engine.stage().drives().hangs(0).is_some(), "it is home");
        }
    }
    assert_eq!(total, 0, "allocations and frees");
    assert!(moved > 0.1, "{moved}");
}

/// An engine that plays a patch on a rig.
fn with_motors(rig: &str, moves: &str) -> Engine {
    let rig = Rig::parse("rig.toml", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
    let none = pacinian::node::asset::NoAssets;
    let plan = scene(&common::patch(moves), &rig, &options, &none).unwrap_or_else(|p| panic!("{p}")).plan;
    Engine::new(&plan).unwrap()
}

fn motors_are_ordered_about(rig: &str, moves: &str) {
    let mut engine = with_motors(rig, moves);
    let mut frames = vec![0.0; 480 * 3];
    let (mut total, mut moved) = (0, 0.0_f32);
    for n in 0..400_u32 {
        total += counted(|| {
            for i in 0..n % 90 {
                let (instrument, place) = ((n + i) % 6, i % 3);
                let at = Instant { sample: engine.clock() + u64::from(i % 80), fraction: 1 << 30 };
                let (level, duration) = (f64::from(i % 7) / 3.0 - 1.0, 0.001 * f64::from(i));
                let play = Play { level, ..play(instrument, place, 0.0, duration, u64::from(i)) };
                engine.schedule(at, Source::Program, Event::Play(play));
            }
            if n % 50 == 49 {
                engine.schedule(Instant::default(), Source::Program, Event::Silence(0, 64));
            }
            engine.process(&mut frames);
        });
        moved = frames.iter().fold(moved, |most, x| most.max(x.abs()));
    }
    assert_eq!(total, 0, "allocations and frees");
    // Behind a rectifier nothing waits to be braked in time, but half of it is for the way that there is not.
    let counts = engine.stage().drives().counts_of(0).unwrap();
    assert!(moved > 0.5 && counts.dropped + counts.backward > 1000, "{moved} {counts:?}");
}

/// Rigs that follow one another: outputs that come and go, other motors, another word on steady voltages.
#[test]
fn another_rig_takes_no_memory() {
    use common::scenes::{MOTORS, MOVES};

    let none = pacinian::node::asset::NoAssets;
    let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
    let extra = "[[output]]\nkind = \"raw\"\nname = \"more\"\nchannel = 4\n[[output]]\nkind = \"trigger\"\nname = \"go\"\nchannel = 5\n";
    let wide = MOTORS.replace("channels = 3", "channels = 5");
    let other = wide.replace("resistance = 10.42", "resistance = 9.0").replace("gain = 3.0", "gain = 2.5");
    let plans = [wide, other + extra].map(|text| {
        let rig = Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        scene(&common::patch(MOVES), &rig, &options, &none).unwrap_or_else(|p| panic!("{p}")).plan
    });
    let (mut director, mut stagehand) = exchange(&plans[0]).unwrap();
    let mut frames = vec![0.0; 480 * 5];
    let (mut total, mut moved) = (0, 0.0_f32);
    for n in 0..600_u32 {
        // A motor is braked for a second at most before another is driven.
        if n % 20 == 19 {
            director.collect();
            director.send(&plans[(n / 20 % 2) as usize]).unwrap();
        }
        total += counted(|| {
            stagehand.take_over();
            for i in 0..n % 5 {
                let at = Instant { sample: stagehand.engine().clock() + u64::from(i % 80), fraction: 7 };
                let play = Play { level: 0.9, ..play((n + i) % 6, i % 3, 0.0, 0.05, u64::from(i)) };
                stagehand.engine().schedule(at, Source::Program, Event::Play(play));
            }
            stagehand.process(&[], &mut frames);
        });
        moved = frames.iter().fold(moved, |most, x| most.max(x.abs()));
    }
    assert_eq!(total, 0, "allocations and frees");
    assert!(moved > 0.3 && director.collect() <= 1, "{moved}");
}

/// What is felt: motors and a coil, however it is cut, once there is room for what comes out.
#[test]
fn what_is_felt_takes_no_memory() {
    use common::scenes::MOTORS;
    use pacinian::feel::{Feel, Wish};
    use pacinian::rig::Rig;

    let mut rig = Rig::parse("rig.toml", MOTORS.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let part = pacinian::rig::part::find("eai-c-mf").unwrap();
    rig.actuators.push(pacinian::rig::Actuator::of_part(part));
    rig.outputs[0].actuator = Some("eai-c-mf".into());
    let mut feel = Feel::new(&rig, 3, 48_000.0, &Wish::default()).unwrap();
    assert_eq!(feel.felt().len(), 3);
    let frames: Vec<f32> = (0..30_000_u32).map(|n| (n as f32 * 0.013).sin()).collect();
    let mut felt = Vec::with_capacity(frames.len() * 2);
    let total = counted(|| {
        for length in [1, 2, 3, 100, 3000, 7] {
            frames.chunks(length).for_each(|part| feel.process(part, &mut felt));
        }
    });
    assert_eq!(total, 0, "allocations and frees");
    assert!(feel.felt().iter().all(|felt| felt.figures().peak > 1.0));
}

/// A knob of every build and its servo, with readings and torques that are no numbers among them.
#[test]
fn a_knob_and_its_servo_take_no_memory() {
    use pacinian::knob::effect::events::Events;
    use pacinian::knob::effect::program::Program;
    use pacinian::knob::effect::{Reading, detent, friction, inertia, transient, wall};
    use pacinian::knob::governor::device::{Delay, Device};
    use pacinian::knob::governor::{Governor, MARGIN};
    use pacinian::knob::plant::Plant;
    use pacinian::knob::plant::encoder::Encoder;
    use pacinian::knob::plant::parameters::Parameters;
    use pacinian::knob::plant::parts::{Build, Drive, Grasp, Hand, Shaft, Winding};
    use pacinian::knob::plant::stops::Stops;
    use pacinian::knob::plant::wave::Wave;
    use pacinian::knob::safety::chain::{Chain, Input, Limits};
    use pacinian::knob::velocity::{Estimator, adaptive, kalman};

    let (rate, encoder) = (10_000.0, Encoder::new(1000.0).unwrap());
    let (dt, count) = (1.0 / rate, encoder.quantum());
    let stops = Some(Stops { low: -1.0, high: 1.0, stiffness: 40.0, damping: 1e-3 });
    let plain = Parameters { coulomb: 1e-3, stiction: 1.3e-3, stops, ..Parameters::default() };
    let winding = Winding { resistance: 1.26, inductance: 0.15e-3, gain: 16.3e-3, supply: 18.0 };
    let whole = Build {
        parameters: plain,
        shaft: Some(Shaft { inertia: 5e-6, viscous: 1e-6, stiffness: 13.5, damping: 6e-5 }),
        drive: Drive::Current { winding, bandwidth: 6e3, peak: 7.0 },
        grasp: Some(Grasp { stiffness: 0.3, damping: 2e-3 }),
        cogging: Wave::detent(1e-3, 7.0).unwrap(),
        ..Build::default()
    };
    let device = Device {
        inertia: 6e-6,
        damping: 2e-5,
        friction: Some(1e-3),
        count,
        period: dt,
        delay: Delay::ticks(1.0),
        resonance: None,
        low_pass: None,
        velocity: pacinian::knob::velocity::choice::Choice::Adaptive(0.01),
        peak: 0.175,
    };
    let governor = Governor::new(&device, MARGIN).unwrap();
    let limits = Limits {
        period: dt,
        slew: 100.0,
        low_pass: Some(2000.0),
        continuous: 0.023,
        winding: 12.0,
        peak: 0.175,
        soft_start: 0.1,
        stale: 3,
        release: 0.02,
        over_speed: 60.0,
    };
    for build in [Build { parameters: plain, ..Build::default() }, whole] {
        let mut plant = Plant::new(&build, rate).unwrap();
        let mut program = Program::new(vec![
            wall::Stops { low: -0.8, high: 0.8, stiffness: 1.0, damping: 1e-3 }.into(),
            detent::Detent::with_stiffness(24.0, 0.1).into(),
            friction::Friction { torque: 2e-3, stretch: 0.01, law: friction::Law::Dahl }.into(),
            inertia::Inertia { inertia: 1e-4, stiffness: 1.0, damping: 1e-3 }.into(),
            transient::Transient { strength: 1e-3, hertz: 120.0, decay: 0.02, least: 0.01, most: 0.05 }
                .into(),
        ])
        .unwrap();
        let mut chain = Chain::new(&limits).unwrap();
        let mut estimators: [Box<dyn Estimator>; 2] = [
            Box::new(kalman::Kalman::new(50.0, count, dt).unwrap()),
            Box::new(adaptive::Adaptive::new(adaptive::Fit::Best, 32, count, dt).unwrap()),
        ];
        let (mut events, mut happened) = (Events::default(), 0);
        let total = counted(|| {
            for tick in 0..20_000_u32 {
                if tick % 3000 == 0 {
                    chain.acknowledge();
                    chain.arm();
                }
                let angle = if tick % 2999 == 2998 { f64::NAN } else { encoder.read(plant.angle()) };
                let velocity = estimators[tick as usize / 10_000].push(angle);
                let allowed = governor.allow(&program.demand());
                let reading = Reading { angle, velocity, dt };
                let torque = program.tick(&reading, allowed.stiffness, allowed.damping, &mut events);
                happened += events.list().len();
                let governed = allowed.acted();
                let input = Input {
                    torque,
                    angle,
                    velocity,
                    fresh: tick % 7 != 0,
                    in_time: tick % 5000 != 4999,
                    governed,
                };
                let command = chain.tick(&input).torque;
                let push =
                    if tick % 1013 == 1012 { f64::INFINITY } else { 0.01 * (f64::from(tick) * 1e-3).sin() };
                let (target, target_speed) =
                    (1.1 * (f64::from(tick) * 2e-3).sin(), 22.0 * (f64::from(tick) * 2e-3).cos());
                plant.step(command, &Hand { torque: push, target, target_speed });
            }
        });
        assert_eq!(total, 0, "allocations and frees");
        assert!(happened > 10 && plant.counts().masked > 10 && plant.angle().is_finite(), "{happened}");
    }
}

/// What a servo leaves to the thread of a line, with effects that remember, and what that makes of it.
#[cfg(feature = "live")]
#[test]
fn a_profile_takes_no_memory() {
    use pacinian::knob::effect::{detent, friction, inertia, transient, wall};
    use pacinian::knob::governor::device::{Delay, Device};
    use pacinian::knob::safety::chain::Limits;
    use pacinian::knob::servo::setup::Setup;
    use pacinian::knob::servo::tick::Servo;
    use pacinian::live::local::{Bounds, Counts, Local, Told};

    let device = Device {
        inertia: 2e-5,
        damping: 4e-4,
        friction: None,
        count: 1e-4,
        period: 1.0 / 8000.0,
        delay: Delay { local: Some(12.0), ..Delay::ticks(40.0) },
        resonance: None,
        low_pass: None,
        velocity: pacinian::knob::velocity::choice::Choice::Adaptive(0.01),
        peak: 0.05,
    };
    let limits = Limits {
        period: device.period,
        slew: 100.0,
        low_pass: None,
        continuous: 0.02,
        winding: 12.0,
        peak: 0.05,
        soft_start: 0.1,
        stale: 3,
        release: 0.02,
        over_speed: 60.0,
    };
    let effects = vec![
        wall::Stops { low: -0.3, high: 0.3, stiffness: 0.05, damping: 1e-4 }.into(),
        detent::Detent::with_stiffness(24.0, 0.01).into(),
        friction::Friction { torque: 1e-3, stretch: 0.01, law: friction::Law::Dahl }.into(),
        inertia::Inertia { inertia: 1e-4, stiffness: 0.01, damping: 1e-4 }.into(),
        transient::Transient { strength: 1e-3, hertz: 120.0, decay: 0.02, least: 0.01, most: 0.05 }.into(),
    ];
    let mut servo = Servo::new(&Setup::new(effects, device, limits)).unwrap();
    servo.arm();
    let budget = limits.budget().unwrap();
    let bounds = Bounds { slew: 100.0, over_speed: 60.0, inverted: false, budget };
    let (mut local, counts, mut most) = (Local::new(bounds), Counts::default(), 0.0_f64);
    let total = counted(|| {
        for n in 0..4000_u64 {
            let angle = 0.4 * (n as f64 * 2e-3).sin();
            servo.tick((n % 9 != 0).then_some(angle), true);
            let told = Told { number: n + 1, stamp: n + 1, heard: angle, profile: servo.profile() };
            local.take(&told, &counts);
            let read = if n % 501 == 500 { f64::NAN } else { angle + 0.02 };
            most = most.max(local.torque(n * 125_000, read, 1.0, &counts).abs());
        }
    });
    assert_eq!(total, 0, "allocations and frees");
    assert!(most > 1e-3 && counts.now().taken == 4000);
}

/// A scene with a knob: turned, pushed by what is no number, silenced, armed, sent worlds, and swapped for another while it turns.
#[test]
fn a_knob_in_the_engine_takes_no_memory() {
    use pacinian::knob::local_model::model::LocalModel;
    use pacinian::knob::local_model::pending::Message;

    let text = |torque: f64| {
        format!(
            "[knob.effects]\n\
             notches = {{ type = \"detents\", count = 24, torque = {torque}, gain = \"1 + 0.2 * slow\" }}\n\
             ends = {{ type = \"end-stops\", low = -1, high = 1, stiffness = 0.3 }}\n\
             [shared.nodes]\nslow = {{ type = \"lfo\", rate = 3 }}\n\
             [voice.v]\nvoices = 4\noutput = \"o\"\nnodes.o = {{ type = \"sine\", frequency = \"200 + knob.angle\" }}\n\
             [[trigger]]\non = \"knob.detent\"\nplay = \"v\"\nset = {{ level = \"min(1, speed / 9)\" }}\n\
             [[trigger]]\non = \"knob.wall ends\"\nplay = \"v\"\n"
        )
    };
    let plans = [0.01, 0.02].map(|torque| compiled(&text(torque), 4, 48_000.0).plan);
    let hand = plans[0].control("hand").unwrap();
    let (mut director, mut stagehand) = exchange(&plans[0]).unwrap();
    let mut slow = stagehand.engine().link_knob().unwrap();
    let mut frames = vec![0.0; 480 * 4];
    let (mut total, mut started) = (0, 0);
    for n in 0..300_u64 {
        let model = LocalModel { stamp: n, stiffness: 0.05, ..LocalModel::FREE };
        slow.send(Message::new(model, 1e-6));
        if n % 40 == 39 {
            assert!(director.send(&plans[(n / 40 % 2) as usize]).unwrap());
        }
        total += counted(|| {
            stagehand.take_over();
            let engine = stagehand.engine();
            let now = Instant { sample: engine.clock(), fraction: 0 };
            let angle = 1.4 * (n as f64 * 0.2).sin();
            engine.schedule(now, Source::Program, Event::Glide(hand, angle, 0.01));
            match n % 50 {
                17 => drop(engine.schedule(now, Source::Program, Event::Push(f64::NAN))),
                23 => drop(engine.schedule(now, Source::Program, Event::Silence(0, 64))),
                31 => drop(engine.schedule(now, Source::Program, Event::Arm(true))),
                _ => {}
            }
            stagehand.process(&[], &mut frames);
        });
        started = stagehand.engine().counters().started;
        director.collect();
    }
    assert_eq!(total, 0, "allocations and frees");
    assert!(started > 100 && slow.look().tick > 20_000, "{started} {:?}", slow.look());
}

/// A knob that is there: read by every sensor, in blocks of all lengths, lost, armed, late, and swapped for another while it turns.
#[test]
fn a_knob_that_is_there_takes_no_memory() {
    use pacinian::knob::angle::decoder::NOT_HEARD;

    for sensor in [
        "rate = 48000\nsensor = { type = \"sine-cosine\", sine_channel = 1, cosine_channel = 2 }",
        "counts = 400\nsensor = { type = \"quadrature\", a_channel = 1, b_channel = 2 }",
        "sensor = { type = \"voltage\", channel = 2, full_scale_volts = 5, radians_per_volt = 1 }",
    ] {
        let rig = format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nrate = 48000\ncoupling = \"dc\"\n[[tactor]]\nname = \"a\"\nchannel = 1\n\
             [[output]]\nkind = \"torque\"\nname = \"k\"\nchannel = 2\n[knob]\ninertia = 1e-5\nviscous = 1e-3\ndelay = 0\npeak_torque = 0.1\n{sensor}\n"
        );
        let rig = Rig::parse("r", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let plans = [0.01, 0.02].map(|torque| {
            let text = format!(
                "[knob.effects]\nnotches = {{ type = \"detents\", count = 24, torque = {torque} }}\n\
                 [voice.v]\noutput = \"o\"\nnodes.o = {{ type = \"sine\", frequency = \"200 + knob.angle\" }}\n\
                 [[trigger]]\non = \"knob.detent\"\nplay = \"v\"\n"
            );
            let options = Options { live: true, attached: true, ..Options::default() };
            scene(&patch(&text), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
        });
        let (mut director, mut stagehand) = exchange(&plans[0]).unwrap();
        let ears = stagehand.engine().input_channels();
        let (mut heard, mut frames) = (vec![0.0; 480 * ears], vec![0.0; 480 * 2]);
        let (mut total, mut most, mut at) = (0, 0.0_f32, 0.0_f32);
        for n in 0..400_usize {
            if n % 40 == 39 {
                assert!(director.send(&plans[n / 40 % 2]).unwrap());
            }
            let length = 1 + (n * 7919) % 480;
            for frame in heard.chunks_mut(ears).take(length) {
                at += 1e-3;
                let (angle, gone) = ((at * 0.2).sin(), n % 90 > 80);
                let values = if gone { [NOT_HEARD; 2] } else { [0.5 * angle.sin(), 0.5 * angle.cos()] };
                frame.copy_from_slice(&values[..ears]);
            }
            total += counted(|| {
                stagehand.take_over();
                let engine = stagehand.engine();
                let now = Instant { sample: engine.clock(), fraction: 0 };
                match n % 50 {
                    2 | 31 => drop(engine.schedule(now, Source::Program, Event::Arm(true))),
                    17 => drop(engine.schedule(now, Source::Program, Event::Deadline(false))),
                    19 => drop(engine.schedule(now, Source::Program, Event::Deadline(true))),
                    _ => {}
                }
                stagehand.process(&heard[..length * ears], &mut frames[..length * 2]);
            });
            most = frames[..length * 2].iter().skip(1).step_by(2).fold(most, |most, x| most.max(x.abs()));
            director.collect();
        }
        assert_eq!(total, 0, "allocations and frees, {sensor}");
        assert!(most > 0.0, "no torque, {sensor}");
    }
}
