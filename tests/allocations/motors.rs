//! Motors: orders, the way home, other rigs, and what is felt of them.

use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::engine::exchange::exchange;
use pacinian::graph::scene::{Options, scene};
use pacinian::rig::Rig;
use pacinian::schedule::Instant;

use crate::common::{self, play};
use crate::counter::counted;

/// Motors: levels and orders of all kinds, on all of them, more than there is room for; and the same behind rectifiers.
#[test]
fn motors_that_are_ordered_about() {
    use crate::common::scenes::{MOTORS, MOVES};

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
    use crate::common::scenes::MOTORS;

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
    assert!(moved > 0.5 && counts.dropped + counts.backward > 0, "{moved} {counts:?}");
}

/// Rigs that follow one another: outputs that come and go, other motors, another word on steady voltages.
#[test]
fn another_rig_takes_no_memory() {
    use crate::common::scenes::{MOTORS, MOVES};

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
    use crate::common::scenes::MOTORS;
    use pacinian::feel::{Feel, Wish};

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
