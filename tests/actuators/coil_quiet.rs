//! What an audio callback asks of the actuators: no allocation, and results that do not depend on how time is cut.

use pacinian::actuator::coil::bounds::{Bounds, EndStop};
use pacinian::actuator::coil::model::{Model, State};
use pacinian::actuator::coil::parameters::{Coil, Inertial, Skin, Spring, Tissue, VoiceCoil};
use pacinian::actuator::coil::plant::Plant;
use pacinian::actuator::coil::supply::Supply;
use pacinian::actuator::drive::Drive;
use pacinian::actuator::link::amplifier::Amplifier;
use pacinian::actuator::link::coupling::Corners;
use pacinian::actuator::link::pwm::{Modulator, Switching};
use pacinian::actuator::link::{Chain, Link};
use pacinian::actuator::piezo::{Charge, Piezo};
use pacinian::actuator::thermal::{COPPER, Cooling, Thermal};

fn plants() -> [Plant; 2] {
    let skin = Tissue { mass: 1e-4, spring: Spring { stiffness: 1200.0, damping: 1.5 } };
    let tactor = VoiceCoil {
        coil: Coil { resistance: 7.0, inductance: 2.5e-4, force_factor: 1.2 },
        mass: 1.5e-3,
        suspension: Spring { stiffness: 3132.7, damping: 0.6 },
        skin: Skin::One(skin),
    };
    let motor = Inertial {
        coil: Coil { resistance: 6.0, inductance: 0.0, force_factor: 1.5 },
        slug_mass: 5.5e-3,
        casing_mass: 0.10,
        suspension: Spring { stiffness: 741.0, damping: 0.983 },
        hand: Tissue { mass: 0.05, spring: Spring { stiffness: 900.0, damping: 4.0 } },
    };
    [Plant::voice_coil(&tactor).expect("sound"), Plant::inertial(&motor).expect("sound")]
}

fn models() -> Vec<Model> {
    let stop = EndStop { stroke: 1e-4, spring: Spring { stiffness: 1e6, damping: 0.5 } };
    let mut all = Vec::new();
    for (plant, preload) in plants().iter().zip([Some(0.05), None]) {
        for drive in [Drive::Voltage, Drive::Current] {
            all.push(Model::new(plant, 48_000.0, drive).expect("sound"));
            let bounds = Bounds { end_stop: Some(stop), preload };
            all.push(Model::bounded(plant, 48_000.0, drive, &bounds).expect("sound"));
        }
    }
    // One that meets the cap on events.
    let hard = EndStop { stroke: 1e-5, spring: Spring { stiffness: 1e8, damping: 0.0 } };
    let bounds = Bounds { end_stop: Some(hard), preload: None };
    let mut capped = Model::bounded(&plants()[1], 1000.0, Drive::Current, &bounds).expect("sound");
    capped.set_state(&State { velocity: 3.0, ..State::default() });
    all.push(capped);
    all
}

fn drive(n: usize) -> f64 {
    5.0 * (n as f64 * 0.02).sin() + if n % 97 < 30 { 4.0 } else { -3.0 }
}

#[test]
fn nothing_is_allocated_in_a_step() {
    let mut models = models();
    let amplifier =
        Amplifier { gain: 6.0, inverted: true, drive: Drive::Voltage, volts: Some(5.0), amperes: None };
    let chain = Chain { full_scale: 1.4, corners: Corners::two(8.0, 3.0), amplifier };
    let mut link = Link::new(&chain, 48_000.0).expect("sound");
    let mut supply = Supply::new(Drive::Current, Some(6.0), Some(0.5)).expect("sound");
    let mut behind = Model::new(&plants()[0], 48_000.0, Drive::Voltage).expect("sound");
    let mut modulator = Modulator::new(&Switching { period: 16, supply: 5.0 }).expect("sound");
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
    let piezo = Piezo {
        capacitance: 1e-6,
        series: 100.0,
        parallel: Some(1e6),
        loss: 0.02,
        volts: [-30.0, 150.0],
        amperes: 0.02,
        slew: Some(1e5),
    };
    let mut charge = Charge::new(&piezo).expect("sound");
    let before = crate::silent::allocations();
    let mut sum = 0.0;
    for n in 0..20_000 {
        for model in &mut models {
            sum += model.step(drive(n)).acceleration;
        }
        sum += supply.step(&mut behind, link.step(drive(n))).current;
        let bridge = modulator.step(drive(n));
        sum += modulator.volts(bridge) + charge.step(20.0 * drive(n), 1.0 / 48_000.0);
        heat.step(0.3, 0.01);
    }
    assert_eq!(crate::silent::allocations(), before);
    assert!(sum.is_finite() && heat.winding() > 1.0);
    let counts: Vec<_> = models.iter().map(Model::contacts).collect();
    assert!(counts.iter().any(|c| c.events > 100) && counts.iter().any(|c| c.capped > 0), "{counts:?}");
}

/// Runs of any length are the same steps, to the bit.
#[test]
fn it_does_not_matter_how_a_run_is_cut() {
    let drives: Vec<f64> = (0..5000).map(drive).collect();
    for (mut single, mut whole) in models().into_iter().zip(models()) {
        let mut cut = whole.clone();
        let (mut a, mut b) = (Vec::new(), Vec::new());
        whole.run(&drives, |outputs| a.push(outputs));
        let (mut rest, mut length) = (&drives[..], 1);
        while !rest.is_empty() {
            let (now, later) = rest.split_at(length.min(rest.len()));
            cut.run(now, |outputs| b.push(outputs));
            (rest, length) = (later, (length * 7 + 3) % 301);
        }
        let c: Vec<_> = drives.iter().map(|&u| single.step(u)).collect();
        assert_eq!(a, b);
        assert_eq!(a, c);
        assert_eq!(single.contacts(), whole.contacts());
    }
}
