//! Finite difference: the last step over its time.

use super::Estimator;
use crate::actuator::fault::{Fault, positive};

/// (θ_k − θ_{k−1}) / T.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Difference {
    rate: f64,
    last: Option<f64>,
    speed: f64,
}

impl Difference {
    /// For readings every `period` seconds.
    ///
    /// # Errors
    /// `period` is not above 0.
    pub fn new(period: f64) -> Result<Self, Fault> {
        positive("period", period)?;
        Ok(Self { rate: 1.0 / period, last: None, speed: 0.0 })
    }

    /// Root-mean-square error (rad/s) of a steady speed, for counts of `count` radians: a step is one count more or less than the mean,
    /// with the frequency that its fraction says, so (δ / T) √(p (1 − p)).
    pub fn steady_error(count: f64, period: f64, speed: f64) -> f64 {
        let counts = speed.abs() * period / count;
        let p = counts - counts.floor();
        count / period * (p * (1.0 - p)).sqrt()
    }
}

impl Estimator for Difference {
    #[inline(always)]
    fn push(&mut self, angle: f64) -> f64 {
        if angle.is_finite() {
            self.speed = (angle - self.last.unwrap_or(angle)) * self.rate;
            self.last = Some(angle);
        }
        self.speed
    }

    fn reset(&mut self, angle: f64) {
        (self.last, self.speed) = (Some(angle), 0.0);
    }
}
