mod contact;
mod drive;
mod energy;
mod limits;
mod steps;

use super::{Build, Chain, Drive, Hand};
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::parts::{Grasp, Shaft, Winding};
use crate::knob::plant::stops::Stops;
use crate::knob::plant::wave::{Harmonic, Wave};

const FREE: Hand = Hand { torque: 0.0, target: 0.0, target_speed: 0.0 };

/// A small motor: 19 V, 577 µs, 19.7 mN m/A.
fn winding() -> Winding {
    Winding { resistance: 2.6, inductance: 1.5e-3, gain: 19.7e-3, supply: 19.0 }
}

fn shaft() -> Shaft {
    Shaft { inertia: 5e-6, viscous: 1e-6, stiffness: Shaft::stiffness_of(1e-6, 600.0), damping: 6e-5 }
}

/// Everything at once.
fn full() -> Build {
    Build {
        parameters: Parameters {
            inertia: 1e-6,
            viscous: 2e-6,
            coulomb: 1e-3,
            stiction: 1.3e-3,
            stops: Some(Stops { low: -0.4, high: 0.3, stiffness: 40.0, damping: 1e-3 }),
        },
        shaft: Some(shaft()),
        drive: Drive::Current { winding: winding(), bandwidth: 6e3, peak: 7.0 },
        grasp: Some(Grasp { stiffness: 0.3, damping: 2e-3 }),
        cogging: Wave::new(&[
            Harmonic { periods: 12.0, sine: 4e-4, cosine: 1e-4 },
            Harmonic { periods: 36.0, sine: 0.0, cosine: 2e-4 },
        ])
        .unwrap(),
        ripple: Wave::new(&[Harmonic { periods: 6.0, sine: 0.03, cosine: 0.0 }]).unwrap(),
    }
}

fn state(chain: &Chain) -> [f64; 5] {
    [chain.angle(), chain.knob_angle(), chain.speed(), chain.knob_speed(), chain.current()]
}

/// What looks random, within ±1.
fn mixed(n: u64) -> f64 {
    let n = (n ^ 0x5851_f42d_4c95_7f2d).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let n = (n ^ (n >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((n ^ (n >> 32)) as i64) as f64 / 9_223_372_036_854_775_808.0
}
