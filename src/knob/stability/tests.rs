mod edges;
mod eigenvalues;
mod estimators;
mod rules;
mod shafts;
mod simulated;

use super::sampled::{Loop, Rotor};

const J: f64 = 6e-6;

fn rigid(damping: f64, rate: f64, delay: f64) -> Loop {
    Loop::rigid(&Rotor { inertia: J, damping }, 1.0 / rate, delay).unwrap()
}
