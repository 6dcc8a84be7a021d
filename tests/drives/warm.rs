//! Motors behind a bridge, behind a rectifier and at a current that would become too warm by what is played, against the simulation of what is felt, which knows nothing of
//! who holds back.

use super::common::scenes::MOVES;
use super::common::{patch, run};
use super::{CLICK, SPIN, STOP, SWELL, SWITCH, THUMP, play};
use pacinian::actuator::driver::book::Book;
use pacinian::actuator::driver::order::Order;
use pacinian::actuator::driver::turner::Turner;
use pacinian::actuator::link::effective::Effective;
use pacinian::actuator::protect::budget::Bears;
use pacinian::actuator::thermal::Cooling;
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Source};
use pacinian::engine::exchange::exchange;
use pacinian::feel::{Feel, Wish};
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::rig::{Bridge, Rig, Terminals};
use pacinian::schedule::Instant;
use std::cell::Cell;

const RATE: f64 = 48_000.0;
const CHANNELS: usize = 2;

/// What stands before the motor: of pulses, a carrier, a current.
const BRIDGE: &str = "drive = \"bridge\"\nmax_volts = 5.0\n";
const CARRIER: &str = "drive = \"carrier\"\ngain = 4.0\nmax_volts = 18.0\ndiode_drop = 1.4\n";
const CURRENT: &str = "drive = \"current\"\ngain = 0.1\nmax_volts = 9.0\ncoupling = \"dc\"\n";
const KINDS: [&str; 3] = [BRIDGE, CARRIER, CURRENT];

/// It bears 35 mA for ever, and takes 51 mA to its speed. What its rotor has in it when it is braked warms the winding by 0.3 K.
const HEAT: &str = "max_heating = 30\nwinding_to_housing = 137\nhousing_to_air = 594\nwinding_time = 1.0\nhousing_time = 4.0\n";
const MOST: f64 = 30.0;

fn text(amplifier: &str, bears: &str, inductance: f64) -> String {
    let direction = if amplifier == BRIDGE { "direction = 2\n" } else { "" };
    format!(
        r#"
format = "pacinian-rig/1"
title = "A motor that becomes warm"
[device]
channels = {CHANNELS}
full_scale_volts = 5.0
coupling = "dc"
[amplifier.before]
{amplifier}
[actuator.coin]
model = "rumble-motor"
rated_volts = 3.0
resistance = 30.0
inductance = {inductance}
torque_constant = 0.955e-3
inertia = 1.8e-9
viscous_friction = 2.15e-8
coulomb_friction = 1.5e-5
static_friction = 2e-5
eccentric_moment = 7.3e-7
mass = 0.1
{bears}
[[output]]
kind = "drive"
name = "coin"
channel = 1
{direction}
actuator = "coin"
amplifier = "before"
"#
    )
}

fn rig(text: &str) -> Rig {
    Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
}

fn compiled(text: &str) -> Plan {
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    let moves = if text.contains("carrier") { MOVES.replace("-1.5", "1.5") } else { MOVES.to_string() };
    scene(&patch(&moves), &rig(text), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

/// What was sent, by what was played when (s), and the engine that sent it.
fn sent(plan: &Plan, events: &[(f64, Event)], seconds: f64, calls: &[usize]) -> (Vec<f32>, Engine) {
    let mut engine = Engine::new(plan).unwrap();
    let mut frames = Vec::new();
    let (mut events, mut begin) = (events.iter().peekable(), 0.0);
    // There is no room for all at once.
    while begin < seconds {
        while let Some((at, event)) = events.next_if(|(at, _)| *at < begin + 1.0) {
            assert!(engine.schedule(Instant::of_samples(at * plan.engine_rate()), Source::Program, *event));
        }
        let part = (seconds - begin).min(1.0);
        frames.extend(run(&mut engine, (part * RATE) as usize, calls));
        begin += 1.0;
    }
    (frames, engine)
}

/// How warm the winding became, K above the air, by the simulation.
fn warmest(text: &str, frames: &[f32]) -> f64 {
    let text = if text.contains("max_heating") {
        text.into()
    } else {
        text.replace("mass = 0.1", &format!("mass = 0.1\n{HEAT}"))
    };
    let mut feel = Feel::new(&rig(&text), CHANNELS, RATE, &Wish::default()).unwrap();
    let mut felt = Vec::new();
    frames.chunks(CHANNELS * 4800).for_each(|frames| feel.process(frames, &mut felt));
    feel.finish(&mut felt);
    feel.felt()[0].figures().warmest.unwrap()
}

/// An endless level; spins up and down; clicks; and all of it mixed.
fn scenes(seconds: f64) -> [(&'static str, Vec<(f64, Event)>); 4] {
    let at = |begin: f64, instrument, level, lasts| (begin, Event::Play(play(instrument, 0, level, lasts)));
    let count = |every: f64| (0..(seconds / every) as usize).map(move |n| every * n as f64);
    let spins = count(0.24).map(|t| at(t, SPIN, 1.0, 0.12)).collect();
    let clicks = count(0.06).map(|t| at(t, CLICK, 1.0, 0.01)).collect();
    let mixed = count(0.09).enumerate().map(|(n, t)| match n % 9 {
        0 | 5 => at(t, SPIN, 1.0, 0.1),
        1 => at(t, SWITCH, -1.0, 0.05),
        2 => at(t, SWITCH, 1.0, 0.05),
        3 => at(t, THUMP, 1.0, 0.01),
        4 => at(t, STOP, 1.0, 0.01),
        6 => at(t, SWELL, 1.0, 0.3),
        _ => at(t, CLICK, 0.9, 0.01),
    });
    [
        ("level", vec![at(0.0, SPIN, 1.0, seconds)]),
        ("spins", spins),
        ("clicks", clicks),
        ("mixed", mixed.collect()),
    ]
}

/// Whatever is played, by the simulation the winding stays within 2 % of what it bears; a level that lasts is brought to it and kept there; and what does that is
/// counted.
#[test]
fn the_winding_stays_as_cool_as_it_must() {
    let kinds = [(BRIDGE, 0.0), (CARRIER, 3e-3), (CURRENT, 0.0)];
    for (amplifier, inductance) in kinds {
        let (held, free) = (text(amplifier, HEAT, inductance), text(amplifier, "", inductance));
        for (name, events) in scenes(10.0) {
            let seconds = if name == "level" { 10.0 } else { 6.0 };
            let (frames, engine) = sent(&compiled(&held), &events, seconds, &[4800]);
            let is = warmest(&held, &frames);
            let drives = engine.stage().drives();
            let (counts, motor) = (drives.held_back(0).unwrap(), drives.counts_of(0).unwrap());
            let what = format!("{amplifier}{inductance} {name}: {is} {counts:?} {motor:?}");
            assert!(is < 1.02 * MOST, "{what}");
            // What it is taken to be is what it is.
            assert!((counts.warmest / is - 1.0).abs() < 0.03, "{what}");
            let would = warmest(&free, &sent(&compiled(&free), &events, seconds, &[4800]).0);
            if would < MOST {
                assert!(
                    is == would && counts.changed == 0 && motor.weakened + motor.refused == 0,
                    "{what}: {would}"
                );
                continue;
            }
            assert!(
                counts.heat.samples > 1000 && counts.heat.most > 0.0 && counts.rms.samples == 0,
                "{what}"
            );
            assert!(drives.changed() == counts.changed && counts.changed >= counts.heat.samples, "{what}");
            let clicks = name == "clicks" || name == "mixed";
            assert!(!clicks || motor.weakened + motor.refused > 0, "{what}");
            if name == "level" {
                let now = drives.temperature(0).unwrap();
                assert!(would > 1.1 * MOST && (now / MOST - 1.0).abs() < 0.03, "{what}: {would} {now}");
            }
        }
    }
}

/// Of a current through a high-pass, clicks alone, what flows is what arrives, also between them: by the simulation it is as warm as it is taken to be.
#[test]
fn what_coupling_gives_back_warms_too() {
    let text = text(CURRENT, HEAT, 0.0)
        .replacen("coupling = \"dc\"", "coupling = { high_pass = 20.0 }", 1)
        .replace("gain = 0.1", "gain = 0.03")
        .replace("kind = \"drive\"", "kind = \"drive\"\nshaping = \"clicks\"");
    let [_, _, (_, clicks), _] = scenes(6.0);
    let (frames, engine) = sent(&compiled(&text), &clicks, 6.0, &[4800]);
    let is = warmest(&text, &frames);
    let (counts, motor) =
        (engine.stage().drives().held_back(0).unwrap(), engine.stage().drives().counts_of(0).unwrap());
    assert!(is > 5.0 && is < 1.02 * MOST, "{is} {counts:?} {motor:?}");
    assert!((counts.warmest / is - 1.0).abs() < 0.02, "{is} {counts:?} {motor:?}");
}

/// A level that heat holds back ends as any does: braked, at rest, and never backward.
#[test]
fn a_level_that_is_held_back_ends_at_rest() {
    let heat = compiled(&text(CURRENT, HEAT, 0.0)).drives[0].bears.unwrap().heat.unwrap();
    for amplifier in KINDS {
        let heat = Cooling { most: 25.0, ..heat };
        let (mut turner, _) = turner(amplifier, &Bears { heat: Some(heat), rms: None }, 3e-3);
        let (setup, mut parts) = (*turner.setup(), [0.0; 6]);
        let slowest = Cell::new(0.0_f64);
        let mut run = |turner: &mut Turner, level: f64, seconds: f64| {
            for _ in 0..(seconds * setup.rate) as usize {
                turner.step(level, &mut parts);
                slowest.set(slowest.get().min(turner.motor().unwrap().speed()));
            }
            turner.motor().unwrap().speed() / setup.full_speed()
        };
        let held = run(&mut turner, 1.0, 6.0);
        assert!(held < 0.8 && held > 0.1, "{amplifier}: {held}");
        run(&mut turner, 0.0, 0.5);
        assert!(turner.rests() && slowest.get() > -0.01 * setup.full_speed(), "{amplifier}: {slowest:?}");
        // Cooled down again, it is as fast as ever.
        run(&mut turner, 0.0, 20.0);
        let speed = run(&mut turner, 0.5, 0.4);
        assert!((speed / 0.5_f64.sqrt() - 1.0).abs() < 0.01, "{amplifier}: {speed}");
    }
}

/// What a motor bears leaves as if nobody knew what it bears, to the bit.
#[test]
fn what_is_borne_leaves_to_the_bit() {
    let cool = "max_heating = 60\nwinding_to_housing = 2\nhousing_to_air = 3\nwinding_time = 1.0\nhousing_time = 40.0\nmax_rms_volts = 9.0\n";
    let [.., (_, events)] = scenes(2.0);
    for amplifier in KINDS {
        let (known, unknown) = (compiled(&text(amplifier, cool, 3e-3)), compiled(&text(amplifier, "", 3e-3)));
        assert!(known.drives[0].bears.is_some() && unknown.drives[0].bears.is_none());
        let (frames, engine) = sent(&known, &events, 2.0, &[4800]);
        let others = sent(&unknown, &events, 2.0, &[4800]).0;
        assert!(frames.iter().map(|x| x.to_bits()).eq(others.iter().map(|x| x.to_bits())), "{amplifier}");
        let counts = engine.stage().drives().held_back(0).unwrap();
        assert!(counts.warmest > 0.05 && counts.changed == 0, "{amplifier}: {counts:?}");
    }
}

#[test]
fn any_cut_gives_the_same_bits() {
    let heat = HEAT.replace("max_heating = 30", "max_heating = 4").replace("= 1.0", "= 0.2");
    let [.., (_, events)] = scenes(2.0);
    for amplifier in KINDS {
        let plan = compiled(&text(amplifier, &format!("{heat}max_rms_volts = 1.8\n"), 3e-3));
        let bits = |calls: &[usize]| -> Vec<u32> {
            sent(&plan, &events, 2.0, calls).0.iter().map(|x| x.to_bits()).collect()
        };
        let whole = bits(&[48_000]);
        for calls in [&[1][..], &[7], &[3, 1000, 1, 17, 250, 64]] {
            assert!(bits(calls) == whole, "{amplifier} {calls:?}");
        }
    }
}

/// A winding does not become cold by what is played next: another patch takes over, and the temperature goes on.
#[test]
fn another_patch_finds_it_as_warm_as_it_is() {
    for amplifier in KINDS {
        let text = text(amplifier, HEAT, 0.0);
        let plan = compiled(&text);
        let options = Options { rate: Some(RATE), live: true, ..Options::default() };
        let other = MOVES.replace("attack = 0.2", "attack = 0.3").replace("-1.5", "2.0");
        let other =
            scene(&patch(&other), &rig(&text), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan;
        let (mut director, mut stagehand) = exchange(&plan).unwrap();
        let spin = Event::Play(play(SPIN, 0, 1.0, 60.0));
        assert!(stagehand.engine().schedule(Instant::default(), Source::Program, spin));
        let mut frames = vec![0.0; 480 * CHANNELS];
        let mut warm = [0.0; 2];
        for (n, plan) in [None, Some(&other)].into_iter().enumerate() {
            if let Some(plan) = plan {
                assert!(director.send(plan).unwrap());
            }
            for _ in 0..if n == 0 { 200 } else { 10 } {
                stagehand.process(&[], &mut frames);
            }
            warm[n] = stagehand.engine().stage().drives().temperature(0).unwrap();
        }
        // The old engine has come back.
        assert_eq!(director.collect(), 0);
        assert!(warm[0] > 5.0 && (warm[1] / warm[0] - 1.0).abs() < 0.1, "{amplifier}: {warm:?}");
    }
}

/// What turns a motor of the rig, alone; and what its drives amount to.
fn turner(amplifier: &str, bears: &Bears, inductance: f64) -> (Turner, Effective) {
    let plan = compiled(&text(amplifier, "", inductance));
    let drive = &plan.drives[0];
    let effective = match &drive.terminals {
        Terminals::Bridge(Bridge { switching, .. }) => {
            Effective::pulses(switching, RATE, inductance / 30.0).unwrap()
        }
        Terminals::Carrier(carrier) => Effective::carrier(carrier, inductance / 30.0).unwrap(),
        Terminals::Straight | Terminals::Coupled(_) => Effective::steady(),
    };
    let turner = Turner::new(&drive.setup, 0).unwrap().bearing(bears, effective.clone()).unwrap();
    (turner, effective)
}

/// Of a mean square it takes the volts that are given, ripple and all, and at a current those on the winding: over a second no more than 1.5 V of them, and as much.
#[test]
fn the_mean_square_stays_within_what_is_borne() {
    let bears = Bears { heat: None, rms: Some([1.5, 1.0]) };
    for amplifier in KINDS {
        let (mut turner, effective) = turner(amplifier, &bears, 0.0);
        let (setup, mut parts) = (*turner.setup(), [0.0; 6]);
        let (mut mean, mut most) = (0.0, 0.0_f64);
        for n in 0..(8.0 * setup.rate) as usize {
            let level =
                if n < (4.0 * setup.rate) as usize { 1.0 } else { f64::from(u32::from(n % 3000 < 1500)) };
            turner.step(level, &mut parts);
            let given = match amplifier {
                CURRENT => 30.0 * parts[0],
                CARRIER if parts[0] == 0.0 => 0.0,
                CARRIER => effective.of(parts[0] + turner.emf()),
                _ => effective.of(parts[0].abs()),
            };
            mean += (given * given - mean) / setup.rate;
            most = most.max(mean.sqrt());
            if n == (4.0 * setup.rate) as usize - 1 {
                assert!((mean.sqrt() / 1.5 - 1.0).abs() < 0.02, "{amplifier}: {}", mean.sqrt());
            }
        }
        let counts = turner.held_back().unwrap();
        assert!(
            most < 1.02 * 1.5 && counts.rms.samples > 100_000 && counts.heat.samples == 0,
            "{amplifier}: {most} {counts:?}"
        );
        assert_eq!((counts.warmest, turner.temperature()), (0.0, None));
    }
}

/// A click of a warm motor is weaker from its beginning on and is braked as it would be: it never loses its brake alone, and turns the mass forward.
#[test]
fn a_warm_motor_clicks_less_and_stops_as_soon() {
    let heat = compiled(&text(CURRENT, HEAT, 0.0)).drives[0].bears.unwrap().heat.unwrap();
    for amplifier in [BRIDGE, CURRENT] {
        // As slow as a housing of its size, and so small that two clicks are enough.
        for most in [0.3, 3.0, 12.0] {
            let heat = Cooling { most, ..heat };
            let (mut turner, _) = turner(amplifier, &Bears { heat: Some(heat), rms: None }, 3e-4);
            let click = Book::new(turner.setup(), 0.25).unwrap().strongest();
            let (rate, mut parts) = (turner.setup().rate, [0.0; 6]);
            let (mut turned, mut turns) = (0.0, Vec::new());
            for n in 0..200 {
                let every = (0.05 * rate) as usize;
                turner.order((n * every) as f64, 0, Order::Click(click));
                let (mut peak, mut peaks_at, mut stands_at) = (0.0, 0, 0);
                for k in 0..every {
                    turner.step(0.0, &mut parts);
                    let speed = turner.motor().unwrap().speed();
                    if speed.abs() > peak {
                        (peak, peaks_at) = (speed.abs(), k);
                    }
                    stands_at = if speed.abs() > 0.02 * peak { k } else { stands_at };
                    assert!(
                        turner.temperature().unwrap() < 1.02 * most * 1.02,
                        "{amplifier} {most}: {:?}",
                        turner.temperature()
                    );
                }
                let now = turner.motor().unwrap().turned();
                let is = (now - turned) / std::f64::consts::TAU;
                turned = now;
                assert!(is > -1e-3 && is < 0.26, "{amplifier} {most} {n}: {is}");
                assert!(
                    is < 1e-3 || stands_at <= 2 * peaks_at + 4,
                    "{amplifier} {most} {n}: {is} {peaks_at} {stands_at}"
                );
                turns.push(is);
            }
            let counts = turner.counts();
            assert!(counts.weakened + counts.refused > 0 || most > 10.0, "{amplifier} {most}: {counts:?}");
            assert_eq!(
                turns.iter().filter(|is| is.abs() < 1e-6).count() as u64,
                counts.refused,
                "{amplifier} {most}"
            );
            assert!(most < 1.0 || (turns[0] / 0.25 - 1.0).abs() < 0.02, "{amplifier} {most}: {}", turns[0]);
        }
    }
}

/// Budgets that make no sense are refused, those that are next to nothing are kept to, and of nothing that is played anything becomes no number.
#[test]
fn hostile_budgets_are_refused_or_kept_to() {
    let heat = compiled(&text(CURRENT, HEAT, 0.0)).drives[0].bears.unwrap().heat.unwrap();
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let refused = |bears: Bears| {
            let setup = compiled(&text(CURRENT, "", 0.0)).drives[0].setup;
            Turner::new(&setup, 0).unwrap().bearing(&bears, Effective::steady()).unwrap_err().field
        };
        let of_heat = |heat: Cooling| refused(Bears { heat: Some(heat), rms: None });
        assert_eq!(of_heat(Cooling { most: bad, ..heat }), "most");
        assert_eq!(of_heat(Cooling { resistance: bad, ..heat }), "resistance");
        assert_eq!(of_heat(Cooling { winding_time: bad, ..heat }), "winding_time");
        assert_eq!(refused(Bears { heat: None, rms: Some([bad, 1.0]) }), "rms.most");
        assert_eq!(refused(Bears { heat: None, rms: Some([1.0, bad]) }), "rms.seconds");
    }
    for amplifier in KINDS {
        for (most, time, volts) in
            [(1e-6, 1.0, 1e-6), (1.0, 1e-3, 3.0), (5.0, 0.02, 3.0), (40.0, 1.0, 0.1), (1e6, 1e6, 1e6)]
        {
            let heat = Cooling { most, winding_time: time, housing_time: 4.0 * time, ..heat };
            let (mut turner, _) =
                turner(amplifier, &Bears { heat: Some(heat), rms: Some([volts, 0.01]) }, 3e-4);
            let click = Book::new(turner.setup(), 0.25).unwrap().strongest();
            let (limit, mut parts) = (turner.setup().limit, [0.0; 6]);
            let mut seed = 7_u64;
            let mut warmest = 0.0_f64;
            for n in 0..20_000_u32 {
                seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                let draw = (seed >> 40) as u32;
                let at = f64::from(n) + f64::from(draw % 97) / 97.0;
                match draw % 211 {
                    0 => turner.order(at, 1, Order::Click(click)),
                    1 => turner.order(at, 2, Order::Spin(f64::from(draw % 2000) - 500.0)),
                    2 => turner.order(at, 2, Order::Release),
                    3 => turner.order(at, 3, Order::On(f64::NAN.into())),
                    4 => turner.order(at, 3, Order::On((f64::from(draw % 9) - 4.0).into())),
                    5 => turner.order(at, 3, Order::Brake),
                    _ => {}
                }
                let level = [0.0, 1.0, -1.0, f64::NAN, 0.3, f64::INFINITY][(n / 700) as usize % 6];
                turner.step(level, &mut parts);
                assert!(parts.iter().all(|part| part.abs() <= limit), "{amplifier} {most} {n}: {parts:?}");
                warmest = warmest.max(turner.temperature().unwrap());
            }
            // Half a tick in a time of eight samples, and what the rotor had in it when it was braked.
            let stored =
                0.5 * 1.8e-9 * turner.setup().full_speed().powi(2) * heat.to_housing / heat.winding_time;
            assert!(warmest <= 1.1 * most + 1.2 * stored, "{amplifier} {most} {time}: {warmest} {stored}");
        }
    }
}
