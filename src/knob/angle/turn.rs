//! The angle of a pair of sine and cosine, and its difference from another.

use crate::actuator::elementary::{cosine, sine};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// The angle of a point, −π to π, of any length that is not 0: within 1e-15. 0 for what has none, and for what is no number.
///
/// A rational guess within 0.005, and twice the sine of what it is off.
pub fn angle(sin: f64, cos: f64) -> f64 {
    let size = sin.abs().max(cos.abs());
    if size <= 0.0 || !size.is_finite() || sin.is_nan() || cos.is_nan() {
        return 0.0;
    }
    let (y, x) = (sin / size, cos / size);
    let length = (x * x + y * y).sqrt();
    let (y, x) = (y / length, x / length);
    let mut at = if x.abs() > y.abs() {
        let z = y / x;
        let near = z / (1.0 + 0.28 * z * z);
        if x > 0.0 { near } else { near + PI.copysign(y) }
    } else {
        let z = x / y;
        FRAC_PI_2.copysign(y) - z / (1.0 + 0.28 * z * z)
    };
    for _ in 0..2 {
        let turns = at / TAU;
        let off = y * cosine(turns) - x * sine(turns);
        at += off + off * off * off / 6.0;
    }
    at
}

/// The shortest way to an angle from another, both within −π to π.
pub fn shortest(to: f64, from: f64) -> f64 {
    let step = to - from;
    if step > PI {
        step - TAU
    } else if step < -PI {
        step + TAU
    } else {
        step
    }
}
