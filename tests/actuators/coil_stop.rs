//! A coil actuator's end stop against reference data of a wall: bodies that fly at it, bounce and fly off.

#![allow(clippy::excessive_precision, reason = "the digits of the reference")]

use pacinian::actuator::coil::bounds::{Bounds, EndStop};
use pacinian::actuator::coil::model::{Model, State};
use pacinian::actuator::coil::parameters::{Coil, Skin, Spring, VoiceCoil};
use pacinian::actuator::coil::plant::Plant;
use pacinian::actuator::drive::Drive;

/// A bounce: what flies, the wall, when it hits and leaves it, and how fast it leaves; from `knob_manifest.json`. All fly at 20 from −0.0503.
struct Bounce {
    rows: &'static str,
    damping: f64,
    wall: Spring,
    contact: f64,
    release: f64,
    rebound: f64,
}

const BOUNCES: [Bounce; 8] = [
    Bounce {
        rows: include_str!("reference/knob_k3_wall_K1e3_z0.csv"),
        damping: 0.0,
        wall: Spring { stiffness: 0.4, damping: 0.0 },
        contact: 0.002515,
        release: 0.014682336027920835691,
        rebound: -20.0,
    },
    Bounce {
        rows: include_str!("reference/knob_k3_wall_K1e3_z0.05.csv"),
        damping: 2e-5,
        wall: Spring { stiffness: 0.4, damping: 0.000154919333848296675 },
        contact: 0.0025256013329169711905,
        release: 0.014324177301988558181,
        rebound: -16.709480661514192915,
    },
    Bounce {
        rows: include_str!("reference/knob_k3_wall_K1e4_z0.csv"),
        damping: 0.0,
        wall: Spring { stiffness: 4.0, damping: 0.0 },
        contact: 0.002515,
        release: 0.0063626494904855922866,
        rebound: -20.0,
    },
    Bounce {
        rows: include_str!("reference/knob_k3_wall_K1e4_z0.05.csv"),
        damping: 2e-5,
        wall: Spring { stiffness: 4.0, damping: 0.00048989794855663562 },
        contact: 0.0025256013329169711905,
        release: 0.006255767596604175117,
        rebound: -16.928818806665449091,
    },
    Bounce {
        rows: include_str!("reference/knob_k3_wall_K1e5_z0.csv"),
        damping: 0.0,
        wall: Spring { stiffness: 40.0, damping: 0.0 },
        contact: 0.002515,
        release: 0.0037317336027920835691,
        rebound: -20.0,
    },
    Bounce {
        rows: include_str!("reference/knob_k3_wall_K1e5_z0.05.csv"),
        damping: 2e-5,
        wall: Spring { stiffness: 40.0, damping: 0.00154919333848296675 },
        contact: 0.0025256013329169711905,
        release: 0.0037051013632598052477,
        rebound: -16.998745102034633608,
    },
    Bounce {
        rows: include_str!("reference/knob_k3_wall_K1e6_z0.csv"),
        damping: 0.0,
        wall: Spring { stiffness: 400.0, damping: 0.0 },
        contact: 0.002515,
        release: 0.0028997649490485592287,
        rebound: -20.0,
    },
    Bounce {
        rows: include_str!("reference/knob_k3_wall_K1e6_z0.05.csv"),
        damping: 2e-5,
        wall: Spring { stiffness: 400.0, damping: 0.0048989794855663562 },
        contact: 0.0025256013329169711905,
        release: 0.0028985839388139463982,
        rebound: -17.020914734244967996,
    },
];

/// Where the wall stands in the model, whose stops lie on both sides of its rest.
const STROKE: f64 = 1.0;
const MASS: f64 = 6e-6;

impl Bounce {
    fn model(&self, rate: f64) -> Model {
        let plant = Plant::voice_coil(&VoiceCoil {
            coil: Coil { resistance: 1.0, inductance: 0.0, force_factor: 1.0 },
            mass: MASS,
            suspension: Spring { stiffness: 0.0, damping: self.damping },
            skin: Skin::None,
        })
        .expect("sound");
        let bounds =
            Bounds { end_stop: Some(EndStop { stroke: STROKE, spring: self.wall }), ..Bounds::default() };
        let mut model = Model::bounded(&plant, rate, Drive::Current, &bounds).expect("sound");
        model.set_state(&State { displacement: STROKE - 0.0503, velocity: 20.0, ..State::default() });
        model
    }
}

#[test]
fn every_point_of_the_trajectories_is_met() {
    for (n, bounce) in BOUNCES.iter().enumerate() {
        let mut rows = bounce.rows.lines().skip(1).map(|line| {
            let mut cells = line.split(',').map(|cell| cell.parse::<f64>().expect("a number"));
            [0; 3].map(|_| cells.next().expect("three columns"))
        });
        let _begin = rows.next();
        let mut model = bounce.model(48_000.0);
        let (mut at, mut worst) = (0, [0.0f64; 2]);
        for [time, angle, speed] in rows {
            let sample = (time * 48_000.0).round() as i32;
            assert!((time * 48_000.0 - f64::from(sample)).abs() < 1e-6, "on the grid");
            while at < sample {
                model.advance(0.0);
                at += 1;
            }
            let state = model.state();
            worst[0] = worst[0].max((state.displacement - STROKE - angle).abs() / 0.08);
            worst[1] = worst[1].max((state.velocity - speed).abs() / 20.0);
        }
        assert!(worst[0] < 1e-11 && worst[1] < 1e-11, "{n}: {worst:?}");
        assert_eq!(model.contacts().events, 2);
    }
}

/// At rates so low that a bounce begins and ends within a sample, it leaves as fast all the same.
#[test]
fn a_bounce_within_a_sample_is_the_same_bounce() {
    for (n, bounce) in BOUNCES.iter().enumerate() {
        for rate in [100.0, 1000.0, 3333.0, 192_000.0] {
            let mut model = bounce.model(rate);
            let steps = (0.02 * rate).ceil();
            (0..steps as u32).for_each(|_| model.advance(0.0));
            // Since the release it has flown, braked by its own damping alone.
            let flown = steps / rate - bounce.release;
            let expected = bounce.rebound * (-bounce.damping / MASS * flown).exp();
            let speed = model.state().velocity;
            assert!((speed / expected - 1.0).abs() < 1e-11, "{n} at {rate}: {speed} {expected}");
            assert_eq!(model.contacts().events, 2, "{n} at {rate}");
            assert!(bounce.contact < bounce.release);
        }
    }
}
