mod edges;
mod eigenvalues;
mod estimators;
mod rules;
mod shafts;
mod simulated;
mod sooner;

use super::sampled::{Loop, Rotor, Shaft};
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::parts::{self, Build};

const J: f64 = 6e-6;

fn rigid(damping: f64, rate: f64, delay: f64) -> Loop {
    Loop::rigid(&Rotor { inertia: J, damping }, 1.0 / rate, delay).unwrap()
}

/// What is to be simulated of a motor, a shaft and a knob on it.
fn of_shaft(shaft: &Shaft) -> Build {
    Build {
        parameters: Parameters { inertia: shaft.motor, viscous: shaft.damping, ..Parameters::default() },
        shaft: Some(parts::Shaft {
            inertia: shaft.knob,
            viscous: 0.0,
            stiffness: shaft.stiffness(),
            damping: shaft.loss,
        }),
        ..Build::default()
    }
}
