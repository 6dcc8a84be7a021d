mod limits;
mod memory;
mod program;
mod sampled;
mod torque;

use super::Reading;

const T: f64 = 1e-4;

fn at(angle: f64) -> Reading {
    Reading { angle, velocity: 0.0, dt: T }
}
