//! How wrong an estimator is at its rate: measured on a known motion through a floor encoder.

use super::Estimator;
use std::f64::consts::TAU;

/// A motion whose speed is known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// A steady speed, rad/s.
    Steady(f64),
    /// A swing: its peak speed (rad/s) and frequency (hertz).
    Swing(f64, f64),
}

impl Motion {
    /// Angle (radians) and speed (rad/s) at a time (seconds).
    pub fn at(&self, time: f64) -> (f64, f64) {
        match *self {
            Self::Steady(speed) => (speed * time, speed),
            Self::Swing(peak, hertz) => {
                let (sin, cos) = (TAU * hertz * time).sin_cos();
                // Somewhere between two counts, so that the turning points favour none.
                (0.123 - peak / (TAU * hertz) * cos, peak * sin)
            }
        }
    }
}

/// What an estimate differs by, rad/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Error {
    /// Root mean square.
    pub rms: f64,
    /// The largest.
    pub worst: f64,
}

/// The error of an estimator over `seconds` of a motion, after as long a start (half a second at most), with counts of `count` radians and
/// readings every `period` seconds.
pub fn measure<E: Estimator>(
    estimator: &mut E,
    motion: Motion,
    count: f64,
    period: f64,
    seconds: f64,
) -> Error {
    let start = (seconds.min(0.5) / period) as u64;
    let end = start + (seconds / period) as u64;
    let (mut square, mut worst) = (0.0, 0.0f64);
    for k in 0..end {
        let (angle, speed) = motion.at(k as f64 * period);
        let off = estimator.push(count * (angle / count).floor()) - speed;
        if k >= start {
            square += off * off;
            worst = worst.max(off.abs());
        }
    }
    Error { rms: (square / (end - start).max(1) as f64).sqrt(), worst }
}
