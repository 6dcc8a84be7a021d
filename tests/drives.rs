//! Motors of a rig, turned by what a patch plays: what leaves the device, and what a real motor makes of it.

mod common;

#[path = "drives/carrier.rs"]
mod carrier;
#[path = "drives/coupled.rs"]
mod coupled;
#[path = "drives/crowd.rs"]
mod crowd;
#[cfg(feature = "live")]
#[path = "drives/halt.rs"]
mod halt;
#[path = "drives/home.rs"]
mod home;
#[path = "drives/staged.rs"]
mod staged;
#[path = "drives/swell.rs"]
mod swell;
#[path = "drives/warm.rs"]
mod warm;

use common::scenes::{MOTORS, MOVES};
use common::{channel, patch, run};
use pacinian::actuator::motor::{Drive, Level, Motor, Parameters, Plan};
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::graph::plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::graph::start::FIELDS;
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;
use pacinian::space::spot::Spot;

const RATE: f64 = 48_000.0;

const CLICK: u32 = 0;
const THUMP: u32 = 1;
const SPIN: u32 = 2;
const SWITCH: u32 = 3;
const STOP: u32 = 4;
const SWELL: u32 = 5;

/// Outputs of the rig, tactors first.
const SKIN: u32 = 0;
const COIN: u32 = 1;
const PAD: u32 = 2;

fn compiled(rig: &str) -> plan::Plan {
    compiled_of(MOVES, rig)
}

fn compiled_of(voices: &str, rig: &str) -> plan::Plan {
    let rig = Rig::parse("rig.toml", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    scene(&patch(voices), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

fn play(instrument: u32, place: u32, level: f64, duration: f64) -> Play {
    Play {
        instrument,
        place: Spot::Row(place),
        level,
        felt: None,
        duration,
        own: [0.0; FIELDS],
        id: u64::from(instrument),
    }
}

/// Volts at the terminals of a motor, a frame each, by what is played when (s).
fn sent(plan: &plan::Plan, events: &[(f64, Event)], seconds: f64, calls: &[usize]) -> [Vec<f64>; 2] {
    let mut engine = Engine::new(plan).unwrap();
    for (at, event) in events {
        let at = Instant::of_samples(at * plan.engine_rate());
        assert!(engine.schedule(at, Source::Program, *event));
    }
    let frames = run(&mut engine, (seconds * RATE) as usize, calls);
    let volts = |drive: &plan::Drive| {
        let samples = channel(&frames, 3, drive.channel as usize);
        samples.iter().map(|x| x * drive.per_sample).collect()
    };
    [volts(&plan.drives[0]), volts(&plan.drives[1])]
}

/// Speeds of a real motor under volts, at the end of each frame.
fn speeds(parameters: &Parameters, volts: &[f64]) -> Vec<f64> {
    let mut motor = Motor::<false>::new(parameters, &Plan::whole(Level::Fine), RATE).unwrap();
    let step = |volts: &f64| {
        motor.drive(Drive::Voltage(*volts));
        motor.step();
        motor.speed()
    };
    volts.iter().map(step).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0_f64, |most, value| most.max(value.abs()))
}

/// Seconds from an event to what it sends.
fn late(plan: &plan::Plan, channel: usize) -> f64 {
    let engine = Engine::new(plan).unwrap();
    engine.stage().drives().late(channel).unwrap() as f64 / plan.engine_rate() + engine.delay().lead
}

#[test]
fn clicks_begin_on_time_and_stop_the_rotor() {
    let plan = compiled(MOTORS);
    for (place, instrument, level, sign) in [
        (COIN, CLICK, 1.0, 1.0),
        (COIN, CLICK, 0.6, 1.0),
        (COIN, THUMP, 1.0, -1.0),
        (PAD, CLICK, 0.5, 1.0),
        (PAD, CLICK, -0.5, -1.0),
        (PAD, THUMP, 0.8, -1.0),
    ] {
        let n = (place - COIN) as usize;
        let drive = &plan.drives[n];
        let at = 0.012_34;
        let volts = &sent(&plan, &[(at, Event::Play(play(instrument, place, level, 0.01)))], 0.4, &[480])[n];
        let parameters = &drive.setup.parameters;
        let speeds = speeds(parameters, volts);
        // To the frame, and within it by the share that is sent.
        let begin = (at + late(&plan, drive.channel as usize)) * RATE;
        let first = volts.iter().position(|volts| *volts != 0.0).unwrap();
        assert_eq!(first, begin as usize);
        let whole = volts[first + 1];
        assert!(
            (volts[first] / whole - (1.0 - begin.fract())).abs() < 1e-4,
            "{} {whole} {begin}",
            volts[first]
        );
        assert!(whole * sign > 0.0 && largest(volts) <= drive.setup.limit * (1.0 + 1e-6));
        if level == 1.0 {
            assert!((whole.abs() / drive.setup.limit - 1.0).abs() < 1e-6);
        }
        // Over when the drive is, by half a per cent of its own peak, and nothing after.
        let end = volts.iter().rposition(|volts| *volts != 0.0).unwrap();
        assert!(speeds[end].abs() < 0.005 * largest(&speeds), "{instrument} {level}: {}", speeds[end]);
        assert!(end < volts.len() - 4800);
        // The other motor has no part in it.
        let other =
            &sent(&plan, &[(at, Event::Play(play(instrument, place, level, 0.01)))], 0.4, &[480])[1 - n];
        assert_eq!(largest(other), 0.0);
    }
}

#[test]
fn spins_and_switches_last_as_long_as_their_events() {
    let plan = compiled(MOTORS);
    for place in [COIN, PAD] {
        let n = (place - COIN) as usize;
        let drive = &plan.drives[n];
        let (setup, parameters) = (&drive.setup, &drive.setup.parameters);
        let from = (0.1 + late(&plan, drive.channel as usize)) * RATE;
        let frame = |seconds: f64| (from + seconds * RATE) as usize;
        let one = |instrument, level| {
            sent(&plan, &[(0.1, Event::Play(play(instrument, place, level, 0.2)))], 1.0, &[480])[n].clone()
        };
        // A quarter of the acceleration is half the speed; braked at the end.
        let volts = one(SPIN, 0.25);
        let turned = speeds(parameters, &volts);
        let wanted = 0.5 * setup.full_speed();
        assert!((turned[frame(0.19)] / wanted - 1.0).abs() < 1e-3, "{}", turned[frame(0.19)] / wanted);
        assert!((volts[frame(0.001)] / setup.limit - 1.0).abs() < 1e-6);
        assert!((volts[frame(0.201)] / setup.limit + 1.0).abs() < 1e-6);
        assert!(turned[frame(0.23)].abs() < 0.01 * wanted && volts.last() == Some(&0.0));
        // Switched on, it gets there by itself, and rolls on.
        let volts = one(SWITCH, 0.5);
        assert!((volts[frame(0.001)] / setup.limit - 0.5).abs() < 1e-6 && volts[frame(0.201)] == 0.0);
        let turned = speeds(parameters, &volts);
        let speed =
            parameters.steady_speed(0.5 * setup.limit) * (1.0 - (-0.1 / parameters.mechanical_time()).exp());
        assert!((turned[frame(0.1)] / speed - 1.0).abs() < 0.01, "{}", turned[frame(0.1)] / speed);
    }
}

/// Levels of a voice: what is played is what the motor does. The output that plans ahead follows it, and is late by what it says.
#[test]
fn an_envelope_is_followed() {
    let plan = compiled(MOTORS);
    let drive = &plan.drives[0];
    let parameters = &drive.setup.parameters;
    let turned =
        speeds(parameters, &sent(&plan, &[(0.1, Event::Play(play(SWELL, COIN, 0.8, 0.5)))], 1.0, &[480])[0]);
    let begin = 0.1 + late(&plan, 0);
    let (mut sum, count) = (0.0, (0.6 * RATE) as usize);
    for n in 0..count {
        let t = n as f64 / RATE;
        // Attack from 0 to 1, decay to 0.6, release from there: straight lines in acceleration.
        let envelope = if t < 0.2 {
            t / 0.2
        } else if t < 0.3 {
            1.0 - 0.4 * (t - 0.2) / 0.1
        } else {
            0.6 * ((0.6 - t) / 0.1).clamp(0.0, 1.0)
        };
        let speed = turned[(begin * RATE) as usize + n] / drive.setup.full_speed();
        sum += (speed * speed - 0.8 * envelope).powi(2);
    }
    let miss = (sum / count as f64).sqrt() / 0.8;
    assert!(miss < 0.01, "{miss}");
    let held = turned[((begin + 0.45) * RATE) as usize] / drive.setup.full_speed();
    assert!((held * held - 0.48).abs() < 1e-3, "{}", held * held);
}

/// The newest order holds: a click on a motor that spins brakes it first. A brake stops all.
#[test]
fn what_is_under_way_is_braked() {
    let plan = compiled(MOTORS);
    for place in [COIN, PAD] {
        let n = (place - COIN) as usize;
        let drive = &plan.drives[n];
        let (parameters, limit) = (&drive.setup.parameters, drive.setup.limit);
        let spin = (0.0, Event::Play(play(SPIN, place, 1.0, 10.0)));
        for (event, again) in [
            (Event::Play(play(CLICK, place, 1.0, 0.01)), true),
            (Event::Play(play(STOP, place, 1.0, 0.01)), false),
            (Event::ReleaseAll, false),
        ] {
            let waits = late(&plan, drive.channel as usize);
            let frame = |seconds: f64| ((0.3 + waits + seconds) * RATE) as usize;
            let volts = &sent(&plan, &[spin, (0.3, event)], 1.0, &[480])[n];
            let turned = speeds(parameters, volts);
            let now = turned[frame(0.0) - 480];
            assert!((now / drive.setup.full_speed() - 1.0).abs() < 0.01);
            assert!((volts[frame(0.001)] / limit + 1.0).abs() < 1e-6, "{event:?}: {}", volts[frame(0.001)]);
            let stopped =
                turned.iter().skip(frame(0.0)).position(|now| now.abs() < 0.01 * drive.setup.full_speed());
            let in_time = parameters.mechanical_time() * 0.9 + 4.0 * parameters.electrical_time();
            assert!((stopped.unwrap() as f64) < in_time * RATE, "{event:?}: {stopped:?}");
            let later = largest(&turned[frame(0.0) + stopped.unwrap() + 48..]);
            assert_eq!(later > 0.05 * drive.setup.full_speed(), again, "{event:?}: {later}");
            assert_eq!(volts.last(), Some(&0.0));
        }
    }
}

#[test]
fn any_cut_gives_the_same_bits() {
    let plan = compiled(MOTORS);
    let mut events = Vec::new();
    for n in 0..60_u32 {
        let (instrument, place) = (n % 6, [COIN, PAD, COIN, SKIN][n as usize % 4]);
        let play = play(instrument, place, 0.2 + 0.013 * f64::from(n), 0.004 * f64::from(n % 30));
        events.push((f64::from(n) * 0.013_71, Event::Play(play)));
    }
    let bits = |calls: &[usize]| -> Vec<u64> {
        sent(&plan, &events, 1.2, calls).iter().flatten().map(|x| x.to_bits()).collect()
    };
    let whole = bits(&[57_600]);
    for calls in [&[1][..], &[7], &[64], &[480], &[3, 1000, 1, 17, 250, 64]] {
        assert!(bits(calls) == whole, "{calls:?}");
    }
}

/// What is ordered of a place without a motor is nothing there, and what is a motor's does not reach the skin.
#[test]
fn orders_are_for_motors_alone() {
    let plan = compiled(MOTORS);
    let mut engine = Engine::new(&plan).unwrap();
    for (n, instrument) in [CLICK, SPIN, SWITCH, STOP].into_iter().enumerate() {
        let at = Instant::of_samples(800.0 * n as f64);
        engine.schedule(at, Source::Program, Event::Play(play(instrument, SKIN, 1.0, 0.05)));
    }
    let frames = run(&mut engine, 48_000, &[480]);
    assert!(frames.iter().all(|x| *x == 0.0));
    assert!(engine.is_silent());
}

#[test]
fn orders_that_nobody_hears_are_told() {
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    let plan = scene(&patch(MOVES), &Rig::default_for(2), &options, &NoAssets)
        .unwrap_or_else(|p| panic!("{p}"))
        .plan;
    let told: Vec<String> = plan.left_out.iter().map(|left| format!("{}: {}", left.what, left.why)).collect();
    for order in [
        "order `tap` of `click`",
        "order `buzz` of `spin`",
        "order `on` of `switch`",
        "order `stop` of `stop`",
    ] {
        assert!(
            told.contains(&format!("{order}: the rig has no motor: no output of kind drive")),
            "{told:?}"
        );
    }
    assert!(!compiled(MOTORS).left_out.iter().any(|left| left.what.starts_with("order")));
}

/// A motor that cannot make what is ordered is told of before anything plays.
#[test]
fn clicks_beyond_a_motor_are_refused() {
    let weak = MOTORS.replace("gain = -3.0", "gain = -0.15");
    let rig = Rig::parse("rig.toml", weak.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    let told = scene(&patch(MOVES), &rig, &options, &NoAssets).unwrap_err().to_string();
    assert!(told.contains("click of 0.25 turns, which the motor of `pad` cannot make"), "{told}");
    assert!(told.contains("more volts"), "{told}");
    // No volts help to no turn at all.
    let rig = Rig::parse("rig.toml", MOTORS.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let none = patch(&MOVES.replace("turns = -1.5", "turns = 0"));
    let told = scene(&none, &rig, &options, &NoAssets).unwrap_err().to_string();
    assert!(
        told.contains("`turns` is 0") && told.contains("other `turns`") && !told.contains("volts"),
        "{told}"
    );
}

/// The same rig with the coin motor behind a full bridge that is switched by two lines.
fn bridged(period: u32) -> String {
    MOTORS
        .replace("channels = 3", "channels = 4")
        .replace(
            "[amplifier.bridge]\ngain = 3.0\nmax_volts = 12.0\ncoupling = \"dc\"\n",
            &format!("[amplifier.bridge]\ndrive = \"bridge\"\nmax_volts = 6.0\nperiod = {period}\n"),
        )
        .replace("amplifier = \"bridge\"\n", "amplifier = \"bridge\"\ndirection = 4\nmax_level = 0.7\n")
}

/// Volts that a bridge makes of its two lines, and both lines.
fn switched(rig: &str, events: &[(f64, Event)], seconds: f64, calls: &[usize]) -> (Vec<f64>, [Vec<f64>; 2]) {
    let plan = compiled(rig);
    let mut engine = Engine::new(&plan).unwrap();
    for (at, event) in events {
        assert!(engine.schedule(Instant::of_samples(at * plan.engine_rate()), Source::Program, *event));
    }
    let frames = run(&mut engine, (seconds * RATE) as usize, calls);
    let lines = [0, 3].map(|c| channel(&frames, 4, c));
    let volts = lines[0].iter().zip(&lines[1]).map(|(on, back)| match (*on > 0.0, *back > 0.0) {
        (false, _) => 0.0,
        (true, back) => {
            if back {
                -6.0
            } else {
                6.0
            }
        }
    });
    (volts.collect(), lines)
}

#[test]
fn a_bridge_gets_pulses_that_do_to_the_motor_what_a_steady_voltage_does() {
    for (period, instrument, level, within) in
        [(16_u32, SWELL, 0.8, 2e-3), (8, SWELL, -0.6, 1e-3), (16, CLICK, 1.0, 4e-3), (32, SPIN, 0.7, 4e-3)]
    {
        let events = [(0.02, Event::Play(play(instrument, COIN, level, 0.25)))];
        let plan = compiled(MOTORS);
        let [wanted, _] = sent(&plan, &events, 0.6, &[480]);
        let (volts, lines) = switched(&bridged(period), &events, 0.6, &[480]);
        let (_, again) = switched(&bridged(period), &events, 0.6, &[1, 7, 64, 333]);
        assert!(lines == again, "cut otherwise, other pulses");
        // Nothing but on and off, at the level that may leave, and the way changes only while it is off.
        assert!(lines.iter().flatten().all(|x| *x == 0.0 || *x == f64::from(0.7_f32)));
        for n in 1..volts.len() {
            assert!(lines[1][n] == lines[1][n - 1] || lines[0][n - 1] == 0.0 || n % period as usize == 0);
        }
        // All volt-seconds arrive, to half a step.
        let sum = |volts: &[f64]| volts.iter().sum::<f64>();
        assert!((sum(&volts) - sum(&wanted)).abs() <= 3.0 + 1e-6, "{} {}", sum(&volts), sum(&wanted));
        // And the motor does the same, as much later as `check` says: a period.
        let parameters = &plan.drives[0].setup.parameters;
        let (here, there) = (speeds(parameters, &wanted), speeds(parameters, &volts));
        let peak = largest(&here);
        let error = |later: usize| {
            let off = there[later..].iter().zip(&here).map(|(a, b)| (a - b) * (a - b));
            (off.sum::<f64>() / here.len() as f64).sqrt() / peak
        };
        let at = |later: u32| error(later as usize);
        assert!(at(period) < within, "{period} {instrument}: {}", at(period));
        assert!(at(period) < at(0) && at(period) < at(2 * period));
        assert!(largest(&there[there.len() - 480..]) < 0.01 * peak);
    }
}

#[test]
fn what_a_bridge_lacks_is_said() {
    let of = |rig: String| Rig::parse("rig.toml", rig.as_bytes()).map(|_| ()).unwrap_err().to_string();
    for (from, to, words) in [
        ("direction = 4\n", "", ["direction = 2", "`bridge`"]),
        ("direction = 4", "direction = 2", ["channel 2", "`skin`"]),
        ("direction = 4", "direction = 5", ["channel 5", "device has 4"]),
        ("max_volts = 6.0\n", "", ["`max_volts`", "supply"]),
        ("max_volts = 6.0", "max_volts = 6.0\ngain = 2.0", ["`gain`", "no bridge"]),
        ("period = 16", "period = 1", ["`period`", "2"]),
        ("coupling = \"dc\"\n[amp", "coupling = { high_pass = 8.0 }\n[amp", ["device", "steady"]),
        ("max_volts = 6.0", "max_volts = 0.1", ["0.100 V", "turns it at all"]),
        ("gain = -3.0\n", "", ["`turned`", "`gain`"]),
        ("gain = -3.0\n", "gain = -3.0\nperiod = 8\n", ["`period`", "a bridge"]),
    ] {
        let rig = bridged(16);
        assert!(rig.contains(from), "{from}");
        let said = of(rig.replace(from, to));
        assert!(words.iter().all(|word| said.contains(word)), "{words:?}: {said}");
    }
}

#[test]
fn a_mass_is_brought_home_from_wherever_it_hangs() {
    use std::f64::consts::{PI, TAU};
    let rig = MOTORS.replace("amplifier = \"bridge\"\n", "amplifier = \"bridge\"\ntilt = 0.0\n");
    let moves = "[voice.home]\noutput = \"go\"\n[voice.home.nodes]\ngo = { type = \"drive-home\" }\n[voice.click]\noutput = \"tap\"\n\
         [voice.click.nodes]\ntap = { type = \"drive-click\" }\n";
    let planned = |rig: &str| {
        let rig = Rig::parse("rig.toml", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let options = Options { rate: Some(RATE), live: true, ..Options::default() };
        scene(&patch(moves), &rig, &options, &NoAssets)
    };
    // None of the motors has a tilt: that is said; where one has, the other is left alone.
    let said = planned(MOTORS).unwrap_err().to_string();
    assert!(["`home`", "`coin`", "`gravity`", "tilt"].iter().all(|word| said.contains(word)), "{said}");
    assert_eq!(planned(&rig).unwrap_or_else(|p| panic!("{p}")).plan.homes.len(), 1);
    // Nor is it home where it may hang anywhere.
    let level = planned(&rig.replace("tilt = 0.0", "tilt = 1.5707963")).unwrap_err().to_string();
    assert!(["anywhere within", "degrees", "tilt = 0.0"].iter().all(|word| level.contains(word)), "{level}");
    // Nor can one be that is turned by pulses.
    let pulsed = planned(&bridged(16).replace("direction = 4\n", "direction = 4\ntilt = 0.0\n"));
    let said = pulsed.unwrap_err().to_string();
    assert!(["`home`", "`coin`", "pulses"].iter().all(|word| said.contains(word)), "{said}");
    let pad = rig.find("[[output]]\nkind = \"drive\"\nname = \"pad\"").unwrap();
    let alone = format!("{}{}", &rig[..pad], &rig[rig.find("[[tactor]]").unwrap()..]);
    let plan = planned(&alone).unwrap_or_else(|p| panic!("{p}")).plan;
    let (_, home) = plan.homes[0];
    assert!(home.spread < 0.2 && home.seconds() < 1.0, "{home:?}");
    // A click first, so that the mass hangs anywhere; then home.
    let mut engine = Engine::new(&plan).unwrap();
    for (at, instrument) in [(0.01, 1), (0.3, 0)] {
        let at = Instant::of_samples(at * plan.engine_rate());
        assert!(engine.schedule(at, Source::Program, Event::Play(play(instrument, COIN, 1.0, 0.01))));
    }
    let frames = run(&mut engine, (1.6 * RATE) as usize, &[480]);
    let parameters = &plan.drives[0].setup.parameters;
    for first in 0..12 {
        let mut motor = Motor::<false>::new(parameters, &Plan::whole(Level::Fine), RATE).unwrap();
        motor.place(TAU * (f64::from(first) + 0.21) / 12.0, 0.0);
        for sample in channel(&frames, 3, 0) {
            motor.drive(Drive::Voltage(sample * plan.drives[0].per_sample));
            motor.step();
        }
        let off = (motor.reading().angle - home.angle + PI).rem_euclid(TAU) - PI;
        assert!(motor.is_stuck() && off.abs() < home.spread + 0.05, "{first}: {off} {home:?}");
    }
}

#[test]
fn of_a_rig_of_motors_alone_the_first_is_meant() {
    let end = MOTORS.find("[[tactor]]").unwrap();
    let rig = MOTORS[..end].to_string();
    let text = "[voice.click]\noutput = \"tap\"\n[voice.click.nodes]\ntap = { type = \"drive-click\" }\n\
                [pattern.p]\ntime = \"seconds\"\nevents = [{ at = 0.0, voice = \"click\" }]\n";
    let rig = Rig::parse("rig.toml", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(RATE), ..Options::default() };
    let plan = scene(&patch(text), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan;
    assert!(plan.clicks.len() == 2 && plan.drives.len() == 2);
    // Nor is a motor whose speed would follow at once one at all.
    let quick = MOTORS.replace("torque_constant = 0.011", "torque_constant = 2.0");
    let said = Rig::parse("rig.toml", quick.as_bytes()).map(|_| ()).unwrap_err().to_string();
    assert!(said.contains("`pad`") && said.contains("`torque_constant`"), "{said}");
}
