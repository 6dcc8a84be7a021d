//! Motors behind a card that lets nothing steady through: a carrier, diodes, and what a real motor makes of it.

use super::common::scenes::MOVES;
use super::common::{channel, patch, run};
use super::{CLICK, SPIN, STOP, SWELL, SWITCH, largest, play};
use pacinian::actuator::drive::Drive;
use pacinian::actuator::driver::coast::Coast;
use pacinian::actuator::driver::reach::Way;
use pacinian::actuator::link::amplifier::Amplifier;
use pacinian::actuator::link::carrier::{Carrier, Rectifier};
use pacinian::actuator::link::converter::{Converter, LATE};
use pacinian::actuator::link::coupling::Corners;
use pacinian::actuator::link::diodes::Diodes;
use pacinian::actuator::link::{Chain, Link};
use pacinian::actuator::motor::{self, Level, Motor, Plan};
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Source};
use pacinian::feel::{Feel, Wish};
use pacinian::graph::plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::rig::{Rig, Terminals};
use pacinian::schedule::Instant;
use std::f64::consts::TAU;

/// The outputs of the rigs below, and their channels.
const COIN: u32 = 0;
const PAD: u32 = 1;
const CHANNELS: usize = 2;

/// Two motors, of which the second keeps its current for 0.4 ms, behind capacitors at 8 Hz and 20 Hz and diodes.
const RIG: &str = r#"
format = "pacinian-rig/1"
title = "Two motors behind diodes"
[device]
channels = 2
full_scale_volts = 5.0
coupling = { high_pass = 8.0 }
[amplifier.rectified]
drive = "carrier"
gain = 4.0
max_volts = 18.0
diode_drop = 1.4
coupling = { high_pass = 20.0 }
[actuator.coin]
part = "coin-10mm"
max_volts = 3.0
[actuator.pad]
model = "rumble-motor"
rated_volts = 6.0
resistance = 10.42
inductance = 4.2e-3
torque_constant = 0.011
inertia = 1.15e-7
viscous_friction = 1e-6
coulomb_friction = 6e-4
static_friction = 8e-4
eccentric_moment = 1.38e-5
mass = 0.25
[[output]]
kind = "drive"
name = "coin"
channel = 1
actuator = "coin"
amplifier = "rectified"
[[output]]
kind = "drive"
name = "pad"
channel = 2
actuator = "pad"
amplifier = "rectified"
"#;

/// The same motors as far as what reaches them is the same, on a card that lets everything through.
fn straight() -> String {
    RIG.replace("{ high_pass = 8.0 }", "\"dc\"")
        .replace("{ high_pass = 20.0 }", "\"dc\"")
        .replace("drive = \"carrier\"\n", "")
        .replace("diode_drop = 1.4\n", "")
}

fn planned(rig: &str, moves: &str, rate: f64) -> Result<plan::Plan, String> {
    let rig = Rig::parse("rig.toml", rig.as_bytes()).map_err(|p| p.to_string())?.value;
    let options = Options { rate: Some(rate), live: true, ..Options::default() };
    Ok(scene(&patch(moves), &rig, &options, &NoAssets).map_err(|p| p.to_string())?.plan)
}

fn compiled(rig: &str, rate: f64) -> plan::Plan {
    planned(rig, &MOVES.replace("turns = -1.5", "turns = 1.5"), rate).unwrap_or_else(|p| panic!("{p}"))
}

/// Frames of what leaves, and how often a motor was asked to go backward.
fn frames(plan: &plan::Plan, events: &[(f64, Event)], seconds: f64, calls: &[usize]) -> (Vec<f32>, [u64; 2]) {
    let mut engine = Engine::new(plan).unwrap();
    for (at, event) in events {
        assert!(engine.schedule(Instant::of_samples(at * plan.engine_rate()), Source::Program, *event));
    }
    let frames = run(&mut engine, (seconds * plan.device_rate) as usize, calls);
    let backward = [0, 1].map(|n| engine.stage().drives().counts_of(n).unwrap().backward);
    (frames, backward)
}

/// Seconds from an event to what it sends.
fn late(plan: &plan::Plan, channel: u32) -> f64 {
    let engine = Engine::new(plan).unwrap();
    engine.stage().drives().late(channel as usize).unwrap() as f64 / plan.engine_rate() + engine.delay().lead
}

/// What a real motor does behind a real converter, chain and diodes, at the end of each frame: speeds, rad/s; its turned angle, rad; and the volts before the diodes, on
/// average over it.
fn behind_diodes(plan: &plan::Plan, samples: &[f64], place: u32) -> (Vec<f64>, f64, Vec<f64>) {
    let drive = &plan.drives[place as usize];
    let Terminals::Carrier(carrier) = drive.terminals else { panic!("no carrier") };
    let amplifier =
        Amplifier { gain: 4.0, inverted: false, drive: Drive::Voltage, volts: Some(18.0), amperes: None };
    let chain = Chain { full_scale: 5.0, corners: Corners::two(8.0, 20.0), amplifier };
    let parts = if plan.device_rate > 1e5 { 4 } else { 16 };
    let rate = plan.device_rate * f64::from(parts);
    let mut converter = Converter::new(parts).unwrap();
    let mut link = Link::new(&chain, rate).unwrap();
    let diodes = Diodes::new(carrier.rectifier, rate);
    let mut motor = Motor::<false>::new(&drive.setup.parameters, &Plan::whole(Level::Fine), rate).unwrap();
    let (mut speeds, mut volts, mut parts) = (Vec::new(), Vec::new(), vec![0.0; parts as usize]);
    for (n, sample) in samples.iter().chain(&[0.0; LATE]).enumerate() {
        converter.step(link.cut(*sample), &mut parts);
        if n >= LATE {
            link.parts(&mut parts);
            parts.iter().for_each(|source| diodes.step(&mut motor, *source, |_, _, _| {}));
            speeds.push(motor.speed());
            volts.push(parts.iter().sum::<f64>() / parts.len() as f64);
        }
    }
    (speeds, motor.turned(), volts)
}

fn at_volts(plan: &plan::Plan, samples: &[f64], place: u32) -> Vec<f64> {
    let drive = &plan.drives[place as usize];
    let mut motor =
        Motor::<false>::new(&drive.setup.parameters, &Plan::whole(Level::Fine), plan.device_rate).unwrap();
    let step = |sample: &f64| {
        motor.drive(motor::Drive::Voltage(sample * drive.per_sample));
        motor.step();
        motor.speed()
    };
    samples.iter().map(step).collect()
}

/// What is played is what the motor does, as it is behind a steady voltage, for as long as it needs no brake: with next to no inductance, and with one
/// that keeps the current for longer than a turn of the carrier; through a bridge of diodes and through one.
#[test]
fn a_motor_behind_diodes_does_what_one_at_a_voltage_does() {
    for (rate, rectifier, hertz, within) in [
        (48_000.0, "full-wave", 4000.0, 0.01),
        (48_000.0, "full-wave", 3700.0, 0.01),
        (48_000.0, "full-wave", 16_000.0, 0.01),
        (192_000.0, "full-wave", 4000.0, 0.01),
        (192_000.0, "half-wave", 4000.0, 0.015),
        (44_100.0, "half-wave", 3000.0, 0.015),
    ] {
        let keys = format!("drive = \"carrier\"\ncarrier = {hertz}\nrectifier = \"{rectifier}\"\n");
        let rig = RIG.replace("drive = \"carrier\"\n", &keys);
        let plan = compiled(&rig, rate);
        for place in [COIN, PAD] {
            let (mut worst, mut held) = (0.0_f64, 0.0_f64);
            let drive = &plan.drives[place as usize];
            let (full, limit) = (drive.setup.full_speed(), drive.setup.limit);
            // The same limit for both.
            let other = straight().replace("max_volts = 3.0", &format!("max_volts = {limit}"));
            let other =
                other.replace("channel = 2\n", &format!("channel = 2\nmax_level = {}\n", limit / 20.0));
            let other = compiled(&other, rate);
            for (instrument, level, until) in [(SWELL, 0.8, 0.4), (SPIN, 0.4, 0.4), (SWITCH, 0.7, 0.4)] {
                if limit < 0.9 * drive.setup.parameters.rated_volts && instrument == SWELL {
                    continue;
                }
                let events = [(0.02, Event::Play(play(instrument, place, level, 0.4)))];
                let (carried, backward) = frames(&plan, &events, 1.0, &[480]);
                let (steady, _) = frames(&other, &events, 1.0, &[480]);
                assert_eq!(backward, [0; 2]);
                let (carried, steady) =
                    (channel(&carried, CHANNELS, place as usize), channel(&steady, CHANNELS, place as usize));
                let (turned, _, _) = behind_diodes(&plan, &carried, place);
                let wanted = at_volts(&other, &steady, place);
                let peak = largest(&wanted);
                let begin = |of| ((0.02 + late(of, place)) * rate).round() as usize;
                let frames = (until * rate) as usize;
                let pairs = turned[begin(&plan)..].iter().zip(&wanted[begin(&other)..]).take(frames);
                let off = pairs.map(|(is, wanted)| (is - wanted).abs() / full).fold(0.0, f64::max);
                assert!(peak > 0.02 * full, "{peak}");
                let end = turned[begin(&plan) + frames] / wanted[begin(&other) + frames] - 1.0;
                assert!(end.abs() < within, "{rate} {rectifier} {hertz} {place} {instrument}: {end}");
                (worst, held) = (worst.max(off), held.max(end.abs()));
                assert!(off < within, "{rate} {rectifier} {hertz} {place} {instrument}: {off}");
                // Then nothing is sent but what holds it, and it rolls to rest and never back.
                assert!(turned.iter().all(|speed| *speed >= -1e-6 * full));
            }
            println!(
                "{rate} {hertz} {rectifier} {place}: {limit:.3} V, off by {:.2} % of full speed, in the end by {:.2} % of its own",
                100.0 * worst,
                100.0 * held
            );
        }
    }
}

/// Going down, a motor rolls: nothing is sent, exactly, and it takes as long as its friction does.
#[test]
fn what_is_let_go_rolls_out() {
    let plan = compiled(RIG, 48_000.0);
    for place in [COIN, PAD] {
        let drive = &plan.drives[place as usize];
        let coast = Coast::new(&drive.setup.parameters);
        for (instrument, stop) in [(SPIN, None), (SWITCH, None), (SPIN, Some(STOP)), (SPIN, Some(u32::MAX))] {
            let mut events = vec![(0.02, Event::Play(play(instrument, place, 0.5, 0.4)))];
            let mut end = 0.42 + late(&plan, place);
            match stop {
                Some(u32::MAX) => {
                    events.push((0.3, Event::Silence(0, 64)));
                    end = 0.3 + plan.engine_rate().recip();
                }
                Some(stop) => {
                    events.push((0.3, Event::Play(play(stop, place, 1.0, 0.01))));
                    end = 0.3 + late(&plan, place);
                }
                None => {}
            }
            let (sent, _) = frames(&plan, &events, 1.2, &[480]);
            let samples = channel(&sent, CHANNELS, place as usize);
            let end = (end * 48_000.0).ceil() as usize + 6;
            let (speeds, _, _) = behind_diodes(&plan, &samples, place);
            assert!(samples[end..].iter().all(|x| *x == 0.0), "{place} {instrument} {stop:?}");
            assert!(largest(&samples[end - 480..end - 48]) > 0.0);
            let rest = (
                0.1 * speeds[end],
                speeds[end..].iter().position(|speed| *speed < 0.1 * speeds[end]).unwrap(),
            );
            let took = rest.1 as f64 / 48_000.0;
            let wanted = coast.seconds(speeds[end], rest.0);
            assert!((took / wanted - 1.0).abs() < 0.02, "{place} {instrument}: {took} {wanted}");
        }
    }
}

/// What is ordered of a motor that still rolls waits until it is as slow as that: what sends knows that nothing brakes it.
#[test]
fn what_still_rolls_is_known_to_roll() {
    let plan = compiled(RIG, 192_000.0);
    for place in [COIN, PAD] {
        let full = plan.drives[place as usize].setup.full_speed();
        let events = [(0.02, 0.8, 0.3), (0.32, 0.2, 0.4)]
            .map(|(at, level, lasts)| (at, Event::Play(play(SPIN, place, level, lasts))));
        let (sent, _) = frames(&plan, &events, 0.7, &[480]);
        let samples = channel(&sent, CHANNELS, place as usize);
        let (speeds, _, _) = behind_diodes(&plan, &samples, place);
        let begin = ((0.32 + late(&plan, place)) * 192_000.0).ceil() as usize + 24;
        let wish = 0.2_f64.sqrt() * full;
        assert!(speeds[begin] > 1.8 * wish);
        let there = begin + speeds[begin..].iter().position(|speed| *speed < 1.03 * wish).unwrap();
        assert!(samples[begin..there].iter().all(|x| *x == 0.0), "{place}");
        let held = &speeds[there..(0.7 * 192_000.0) as usize];
        let off = held.iter().map(|speed| (speed / wish - 1.0).abs()).fold(0.0, f64::max);
        assert!(off < 0.035 && largest(&samples[there + 960..]) > 0.0, "{place}: {off}");
    }
}

/// A click is a push: where it has rolled out, the mass has turned as far as it was to turn, and its strength goes with the level.
#[test]
fn a_click_is_a_push_that_rolls_to_its_end() {
    for rig in [RIG.into(), RIG.replace("inductance = 4.2e-3", "inductance = 2e-2")] {
        let plan = compiled(&rig, 48_000.0);
        for place in [COIN, PAD] {
            let mut fastest = Vec::new();
            for level in [1.0, 0.3, 0.1, 0.01] {
                let (turns, speeds) = clicked(&plan, place, level, 0.013);
                assert!((turns / 0.25 - 1.0).abs() < 0.03, "{place} {level}: {turns}");
                assert_eq!(speeds.last(), Some(&0.0));
                fastest.push(largest(&speeds));
            }
            assert!(fastest[0] > 1.15 * fastest[1] && fastest[1] > 1.05 * fastest[2], "{fastest:?}");
        }
    }
}

/// How far a click of a quarter of a turn turns the mass, and how fast.
fn clicked(plan: &plan::Plan, place: u32, level: f64, at: f64) -> (f64, Vec<f64>) {
    let events = [(at, Event::Play(play(CLICK, place, level, 0.01)))];
    let (sent, _) = frames(plan, &events, 1.0, &[480]);
    let samples = channel(&sent, CHANNELS, place as usize);
    let (speeds, turned, _) = behind_diodes(plan, &samples, place);
    (turned / TAU, speeds)
}

/// What is told beforehand of a click is what it comes to when it is played, be it near what was ordered or far from it: with few half-waves in a push,
/// through one diode, with a large coil, with an amplifier that gives little.
#[test]
fn what_a_click_comes_to_is_known_beforehand() {
    let (mut farthest, mut count) = (0.0_f64, 0);
    for (hertz, rectifier, peak, inductance) in [
        (4000.0, "full-wave", 18.0, 4.2e-3),
        (4000.0, "full-wave", 3.5, 1e-4),
        (2000.0, "half-wave", 18.0, 1e-4),
        (16_000.0, "full-wave", 18.0, 2e-2),
        (4000.0, "half-wave", 18.0, 4.2e-3),
    ] {
        let keys = format!("drive = \"carrier\"\ncarrier = {hertz}\nrectifier = \"{rectifier}\"\n");
        let rig = RIG
            .replace("drive = \"carrier\"\n", &keys)
            .replace("max_volts = 18.0", &format!("max_volts = {peak:?}"))
            .replace("inductance = 4.2e-3", &format!("inductance = {inductance:e}"));
        let plan = compiled(&rig, 48_000.0);
        for place in [COIN, PAD] {
            let drive = &plan.drives[place as usize];
            let Terminals::Carrier(carrier) = drive.terminals else { panic!("no carrier") };
            let way = Way {
                carrier,
                rate: plan.device_rate,
                per_sample: drive.per_sample,
                most: 1.0,
                peak: Some(peak),
            };
            let clicks = plan.clicks.iter().find(|clicks| clicks.drive == place as usize).unwrap();
            for (level, at) in [(1.0, 0.0125), (0.2, 0.012_55)] {
                let click = clicks.book.at(level).unwrap();
                let told = way.turns(&drive.setup, &click, (at * plan.engine_rate()).fract()).unwrap();
                let (is, _) = clicked(&plan, place, level, at);
                println!("{hertz} {rectifier} {peak} {inductance} {place} {level}: {is:.4}, told {told:.4}");
                assert!((told / is - 1.0).abs() < 0.01, "{hertz} {rectifier} {place} {level}: {is} {told}");
                (farthest, count) = (farthest.max((is / 0.25 - 1.0).abs()), count + 1);
            }
        }
    }
    assert!(farthest > 0.03 && count == 20, "{farthest}: some of them are far off");
}

/// What leaves is a tone alone: behind the capacitors, each of its turns stands about nothing from the first one on.
#[test]
fn capacitors_keep_nothing_of_it() {
    let plan = compiled(RIG, 48_000.0);
    let events =
        [(0.02, Event::Play(play(SWELL, COIN, 0.8, 0.4))), (0.1, Event::Play(play(SPIN, PAD, 0.8, 0.2)))];
    let (sent, _) = frames(&plan, &events, 1.2, &[480]);
    for place in [COIN, PAD] {
        let samples = channel(&sent, CHANNELS, place as usize);
        let (_, _, volts) = behind_diodes(&plan, &samples, place);
        let first = samples.iter().position(|x| *x != 0.0).unwrap();
        let end = samples.iter().rposition(|x| *x != 0.0).unwrap();
        let most = largest(&volts);
        assert!(most > 4.0 && largest(&samples) <= 1.0);
        let means = volts[first..end].chunks_exact(12).map(|turn| turn.iter().sum::<f64>() / 12.0);
        let sum: Vec<f64> = means.collect();
        // A turn in which the amplitude jumps is not about nothing itself; what matters stays for longer than a turn.
        let offset = sum.windows(10).map(|turns| turns.iter().sum::<f64>() / 10.0);
        let offset = offset.fold(0.0_f64, |most, mean| most.max(mean.abs()));
        assert!(offset < 0.02 * most, "{offset} of {most}");
    }
}

#[test]
fn any_cut_gives_the_same_carrier() {
    let plan = compiled(&RIG.replace("gain = 4.0", "gain = 4.0\ncarrier = 3700"), 48_000.0);
    let mut events = Vec::new();
    for n in 0..60_u32 {
        let play = play(n % 6, n % 2, 0.2 + 0.013 * f64::from(n), 0.004 * f64::from(n % 30));
        events.push((f64::from(n) * 0.013_71, Event::Play(play)));
    }
    let bits = |calls: &[usize]| -> Vec<u32> {
        frames(&plan, &events, 1.2, calls).0.iter().map(|x| x.to_bits()).collect()
    };
    let whole = bits(&[57_600]);
    assert!(whole.iter().any(|bits| *bits != 0));
    for calls in [&[1][..], &[7], &[64], &[480], &[3, 1000, 1, 17, 250, 64]] {
        assert!(bits(calls) == whole, "{calls:?}");
    }
}

/// What is for the other way is nothing, and is counted.
#[test]
fn nothing_goes_backward() {
    let plan = compiled(RIG, 48_000.0);
    for (instrument, least) in [(CLICK, 1), (SPIN, 1), (SWITCH, 1), (SWELL, 1000)] {
        let events = [(0.02, Event::Play(play(instrument, COIN, -0.5, 0.3)))];
        let (sent, backward) = frames(&plan, &events, 0.6, &[480]);
        let samples = channel(&sent, CHANNELS, COIN as usize);
        // The corners of an envelope swing about its ends for a sample; no motor turns of that.
        let given = samples.iter().filter(|x| **x != 0.0).count();
        let (speeds, _, _) = behind_diodes(&plan, &samples, COIN);
        assert!(given == 0 || instrument == SWELL && given <= 96, "{instrument}: {given}");
        let fastest = largest(&speeds) / plan.drives[0].setup.full_speed();
        assert!(fastest < 0.02, "{instrument}: {fastest}");
        assert!(backward[0] >= least && backward[1] == 0, "{instrument}: {backward:?}");
    }
}

/// What is felt is worked out behind the diodes too: the motor is as fast as what is played.
#[test]
fn it_is_felt_as_it_is_played() {
    for rate in [48_000.0, 192_000.0] {
        let plan = compiled(RIG, rate);
        let rig = Rig::parse("rig.toml", RIG.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let mut feel = Feel::new(&rig, CHANNELS, rate, &Wish::default()).unwrap();
        let events = [COIN, PAD].map(|place| (0.02, Event::Play(play(SWELL, place, 0.5, 0.4))));
        let (sent, _) = frames(&plan, &events, 1.2, &[480]);
        let mut felt = Vec::new();
        feel.process(&sent, &mut felt);
        assert!(feel.unfelt().is_empty());
        for (place, of) in feel.felt().iter().enumerate() {
            let parameters = &plan.drives[place].setup.parameters;
            let figures = of.figures();
            let wanted = 0.5_f64.sqrt() * plan.drives[place].setup.full_speed();
            let off = figures.fastest.unwrap() / wanted - 1.0;
            assert!(off.abs() < 0.01, "{place} {rate}: {off}");
            // In m/s²: the mass on its circle, from a free casing.
            let peak = parameters.rated_acceleration().unwrap() * 0.5;
            assert!((figures.peak / peak - 1.0).abs() < 0.1, "{place} {rate}: {} {peak}", figures.peak);
            let (_, energy) = (figures.warmest, figures.energy.unwrap());
            assert!(energy > 0.0 && of.assumed.is_empty(), "{:?}", of.assumed);
        }
    }
}

#[test]
fn what_a_carrier_cannot_do_is_said() {
    let moves = MOVES.replace("turns = -1.5", "turns = 1.5");
    let home = "[voice.home]\noutput = \"go\"\n[voice.home.nodes]\ngo = { type = \"drive-home\" }\n";
    for (from, to, words) in [
        ("diode_drop = 1.4\n", "", ["lacks `diode_drop`", "diode_drop = 1.4"]),
        ("diode_drop = 1.4", "diode_drop = -1.0", ["`diode_drop`", "0"]),
        ("diode_drop = 1.4", "diode_drop = 1.4\nperiod = 8", ["`period`", "a bridge"]),
        ("drive = \"carrier\"\n", "carrier = 4000\n", ["`carrier`", "which is for what is a carrier"]),
        ("diode_drop = 1.4", "diode_drop = 1.4\ncarrier = 900", ["`carrier`", "2000"]),
        ("diode_drop = 1.4", "diode_drop = 1.4\ncarrier = 22000", ["22000 Hz", "21600 Hz"]),
        ("channels = 2", "channels = 2\nrate = 8000", ["4000 Hz", "3600 Hz"]),
        ("gain = 4.0", "gain = 0.05", ["0.000 V", "turns it at all"]),
        ("channel = 1\n", "channel = 1\nlook_ahead = 0.1\n", ["`look_ahead`", "nothing brakes"]),
        ("channel = 1\n", "channel = 1\npolarity = -1\n", ["upside down", "one way"]),
        (
            "coulomb_friction = 6e-4",
            "coulomb_friction = 1e-12",
            ["would not stand within 10 s", "`coulomb_friction`"],
        ),
        (
            "drive = \"carrier\"\ngain = 4.0\nmax_volts = 18.0\ndiode_drop = 1.4",
            "gain = 4.0",
            ["high-pass at 8 Hz", "drive = \"carrier\""],
        ),
        (
            "kind = \"drive\"\nname = \"pad\"",
            "kind = \"vibration\"\nname = \"pad\"",
            ["for vibration", "rectifier"],
        ),
    ] {
        assert!(RIG.contains(from), "{from}");
        let mut rig = RIG.replacen(from, to, 1);
        if from.starts_with("coulomb") {
            rig = rig
                .replace("viscous_friction = 1e-6", "viscous_friction = 1e-12")
                .replace("static_friction = 8e-4", "static_friction = 1e-9");
        }
        let said = planned(&rig, &moves, 48_000.0).map(|_| ()).unwrap_err();
        assert!(words.iter().all(|word| said.contains(word)), "{words:?}: {said}");
    }
    let said = planned(RIG, MOVES, 48_000.0).map(|_| ()).unwrap_err();
    assert!(
        ["-1.5 turns", "`coin`", "one way", "`turns` above 0"].iter().all(|word| said.contains(word)),
        "{said}"
    );
    let said = planned(&RIG.replace("channel = 1\n", "channel = 1\ntilt = 0.0\n"), home, 48_000.0)
        .map(|_| ())
        .unwrap_err();
    assert!(["home", "`coin`", "carrier"].iter().all(|word| said.contains(word)), "{said}");
    // The rate comes from elsewhere.
    assert!(planned(RIG, &moves, 8000.0).map(|_| ()).unwrap_err().contains("3600 Hz"));
}

/// What is said to reach the motor is what the largest carrier makes of itself, by the closed form.
#[test]
fn the_most_is_that_of_the_largest_carrier() {
    let plan = compiled(&RIG.replace("max_volts = 18.0", "max_volts = 4.0"), 48_000.0);
    let rectifier = Rectifier { full_wave: true, drop: 1.4 };
    let [coin, pad] = [0, 1].map(|n| plan.drives[n].setup);
    // Of next to no inductance (0.25 rad of the carrier), within 1 % of none.
    let most = rectifier.mean(4.0);
    assert!(coin.limit < most && coin.limit > 0.97 * most, "{} {most}", coin.limit);
    // With 10 rad the current never ceases: 2 A/π − d.
    let most = 8.0 / std::f64::consts::PI - 1.4;
    assert!(pad.limit >= most * (1.0 - 1e-9) && pad.limit < rectifier.mean(4.0), "{} {most}", pad.limit);
    assert!(coin.one_way && pad.one_way);
    assert_eq!(plan.drives[0].terminals, Terminals::Carrier(Carrier { hertz: 4000.0, rectifier }));
}

/// A tactor behind diodes or a bridge would get something else than what is played.
#[test]
fn nothing_vibrates_behind_a_rectifier_or_a_bridge() {
    let tactor = "[[tactor]]\nname = \"skin\"\nchannel = 1\namplifier = \"rectified\"\n";
    let (head, _) = RIG.split_once("[[output]]").unwrap();
    let of = |rig: &str| Rig::parse("rig.toml", rig.as_bytes()).map(|_| ()).map_err(|told| told.to_string());
    let rig = format!("{head}{tactor}[[tactor]]\nname = \"other\"\nchannel = 2\n");
    let told = of(&rig).unwrap_err();
    assert!(told.contains("`skin` is for vibration") && told.contains("a rectifier behind it"), "{told}");
    let (before, behind) = rig.split_once("[amplifier.rectified]").unwrap();
    let (_, behind) = behind.split_once("[actuator.coin]").unwrap();
    let with =
        |amplifier: &str| of(&format!("{before}[amplifier.rectified]\n{amplifier}\n[actuator.coin]{behind}"));
    let told = with("drive = \"bridge\"\nmax_volts = 6.0").unwrap_err();
    assert!(told.contains("`skin` is for vibration") && told.contains("is a bridge"), "{told}");
    assert_eq!(with("gain = 4.0"), Ok(()));
}
