//! Run time of the coil actuators, as CPU time of this thread: the median of many windows, in nanoseconds a step.

use std::hint::black_box;

use cpu_time::ThreadTime;
use pacinian::actuator::coil::bounds::{Bounds, EndStop};
use pacinian::actuator::coil::large::{Large, Shape};
use pacinian::actuator::coil::model::{Model, State};
use pacinian::actuator::coil::parameters::{Coil, Inertial, Layer, Skin, Spring, Tissue, VoiceCoil};
use pacinian::actuator::coil::plant::Plant;
use pacinian::actuator::coil::supply::Supply;
use pacinian::actuator::drive::Drive;
use pacinian::actuator::link::amplifier::Amplifier;
use pacinian::actuator::link::coupling::Corners;
use pacinian::actuator::link::{Chain, Link};
use pacinian::actuator::thermal::{COPPER, Cooling, Thermal};

const RATE: f64 = 48_000.0;
const WINDOWS: usize = 41;

/// Median CPU nanoseconds that each of `steps` takes.
fn median(steps: usize, mut work: impl FnMut(usize)) -> f64 {
    let mut times: Vec<f64> = (0..WINDOWS)
        .map(|_| {
            let begin = ThreadTime::now();
            (0..steps).for_each(&mut work);
            begin.elapsed().as_nanos() as f64 / steps as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[WINDOWS / 2]
}

fn tactor(inductance: f64) -> VoiceCoil {
    let skin = Tissue { mass: 1e-4, spring: Spring { stiffness: 1200.0, damping: 1.5 } };
    VoiceCoil {
        coil: Coil { resistance: 7.0, inductance, force_factor: 1.2 },
        mass: 1.5e-3,
        suspension: Spring { stiffness: 3132.7, damping: 0.6 },
        skin: Skin::One(skin),
    }
}

fn run(name: &str, model: &mut Model, drive: &[f64]) {
    let count = drive.len() as f64;
    let single = median(1000, |_| drive.iter().for_each(|&u| model.advance(u))) / count;
    let bare = median(1000, |_| model.run(drive, |_| ())) / count;
    let mut sum = 0.0;
    let casing = median(1000, |_| model.run(drive, |o| sum += o.casing + o.acceleration)) / count;
    let step = median(1000, |_| {
        for &u in drive {
            let o = model.step(u);
            sum += o.acceleration + o.force + o.casing + o.current + o.voltage;
        }
    }) / count;
    black_box((sum, model));
    println!("{name:<58} {bare:>9.1} {casing:>9.1} {single:>9.1} {step:>9.1}");
}

fn main() {
    println!("{:<58} {:>9} {:>9} {:>9} {:>9}", "ns a step", "run", "run, acc.", "single", "all out");
    let sine: Vec<f64> = (0..256).map(|n| (std::f64::consts::TAU * f64::from(n) / 256.0).sin()).collect();
    let plant = Plant::voice_coil(&tactor(2.5e-4)).expect("sound");
    let stop = EndStop { stroke: 1e-4, spring: Spring { stiffness: 1e6, damping: 1.0 } };
    let model =
        |plant: &Plant, bounds: &Bounds| Model::bounded(plant, RATE, Drive::Voltage, bounds).expect("sound");
    let free = Bounds::default();
    run("tactor on skin, 3 states", &mut model(&plant, &free), &sine);
    run(
        "the same, L = 0, 2 states",
        &mut model(&Plant::voice_coil(&tactor(0.0)).expect("sound"), &free),
        &sine,
    );
    let layer = Layer {
        mass: 4e-4,
        coupling: Spring { stiffness: 700.0, damping: 0.4 },
        anchor: Spring { stiffness: 300.0, damping: 0.9 },
    };
    let Skin::One(tissue) = tactor(0.0).skin else { unreachable!() };
    let layered = VoiceCoil { skin: Skin::Two(tissue, layer), ..tactor(2.5e-4) };
    run(
        "the same, skin of two branches, 5 states",
        &mut model(&Plant::voice_coil(&layered).expect("sound"), &free),
        &sine,
    );
    let inertial = Inertial {
        coil: Coil { resistance: 6.0, inductance: 2e-4, force_factor: 1.5 },
        slug_mass: 5.5e-3,
        casing_mass: 0.10,
        suspension: Spring { stiffness: 741.0, damping: 0.983 },
        hand: Tissue::default(),
    };
    run("inertial motor, 3 states", &mut model(&Plant::inertial(&inertial).expect("sound"), &free), &sine);

    let bounded = Bounds { end_stop: Some(stop), preload: Some(0.5) };
    run("tactor with stop and preload, neither near", &mut model(&plant, &bounded), &sine);
    let loud: Vec<f64> = sine.iter().map(|x| 10.0 * x).collect();
    run("the same, driven into the stops and off the skin", &mut model(&plant, &bounded), &loud);

    let shape = Shape { force_falls: Some(1e-3), stiffens: Some(5e-4), reach: 8e-4 };
    let mut large = Large::new(&plant, RATE, Drive::Voltage, &free, &shape).expect("sound");
    let mut sum = 0.0;
    let time =
        median(1000, |_| loud.iter().for_each(|&u| sum += large.step(u).acceleration)) / loud.len() as f64;
    println!("{:<58} {:>39.1}", "tactor in large motion, Bl(y) and k(y)", time);
    let mut supply = Supply::new(Drive::Current, Some(6.0), Some(0.5)).expect("sound");
    let mut driven = model(&plant, &free);
    let time = median(1000, |_| sine.iter().for_each(|&u| sum += supply.step(&mut driven, u).acceleration))
        / sine.len() as f64;
    println!("{:<58} {:>39.1}", "tactor behind a current source with both limits", time);
    let amplifier =
        Amplifier { gain: 6.0, inverted: false, drive: Drive::Voltage, volts: Some(5.0), amperes: None };
    let chain = Chain { full_scale: 1.4, corners: Corners::two(8.0, 2.0), amplifier };
    let mut link = Link::new(&chain, RATE).expect("sound");
    let time = median(1000, |_| sine.iter().for_each(|&u| sum += link.step(u))) / sine.len() as f64;
    println!("{:<58} {:>39.1}", "a sample through a link with two corners", time);
    let cooling = Cooling {
        resistance: 7.0,
        rise: COPPER,
        to_housing: 20.0,
        to_air: 40.0,
        winding_time: 5.0,
        housing_time: 200.0,
        most: 80.0,
    };
    let mut heat = Thermal::new(&cooling).expect("sound");
    let time = median(100_000, |_| heat.step(black_box(0.1), 0.01));
    println!("{:<58} {:>39.1}", "a step of heat, at 100 Hz", time);
    black_box((sum, heat));

    // One step that begins or ends a contact.
    let mut at_stop = model(&plant, &Bounds { preload: None, ..bounded });
    let edge = State { displacement: 1e-4 - 1e-7, velocity: 0.1, ..State::default() };
    let with = median(20_000, |_| {
        at_stop.set_state(black_box(&edge));
        at_stop.advance(1.0);
    });
    println!("{:<58} {with:>7.1}", "a step with one contact begun, set up afresh each time");
    let bare = VoiceCoil { suspension: Spring::default(), skin: Skin::None, ..tactor(2.5e-4) };
    let hard = EndStop { stroke: 1e-5, spring: Spring { stiffness: 1e8, damping: 0.0 } };
    let bounds = Bounds { end_stop: Some(hard), preload: None };
    let bare = Plant::voice_coil(&bare).expect("sound");
    let mut capped = Model::bounded(&bare, 1000.0, Drive::Voltage, &bounds).expect("sound");
    let fast = State { velocity: 2.0, ..State::default() };
    let worst = median(2_000, |_| {
        capped.set_state(black_box(&fast));
        capped.advance(1.0);
    });
    println!("{:<58} {worst:>7.1}   capped {}", "a step at the cap on events", capped.contacts().capped > 0);
    // What rounding does in half an hour: an undamped oscillation against the cosine that it is.
    let undamped =
        VoiceCoil { suspension: Spring { stiffness: 3000.0, damping: 0.0 }, skin: Skin::None, ..tactor(0.0) };
    let undamped = Plant::voice_coil(&undamped).expect("sound");
    let mut long = Model::new(&undamped, RATE, Drive::Current).expect("sound");
    long.set_state(&State { displacement: 1e-4, ..State::default() });
    let steps = 100_000_000u32;
    let block = [0.0; 1000];
    (0..steps / 1000).for_each(|_| long.run(&block, |_| ()));
    let turn = (3000.0f64 / 1.5e-3).sqrt() * f64::from(steps) / RATE;
    let apart = (long.state().displacement / 1e-4 - turn.cos()).abs();
    println!("{:<58} {apart:>9.1e}", "error of 1e8 steps of an undamped oscillation, of 1");
    let setup = median(20, |_| {
        black_box(model(&plant, black_box(&bounded)));
    });
    println!("{:<58} {:>7.0} us", "making a model with all bounds", setup / 1e3);
}
