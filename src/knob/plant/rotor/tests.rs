mod friction;
mod limits;
mod walls;

use super::{Parameters, Stops};

const J: f64 = 6e-6;

fn wall(stiffness: f64, ratio: f64, at: f64) -> Parameters {
    let stops = Stops::of_ratio(f64::NEG_INFINITY, at, stiffness, ratio, J);
    Parameters { inertia: J, viscous: 0.0, stops: Some(stops), ..Parameters::default() }
}
