//! Steady-state Kalman filter of angle and speed.
//!
//! The acceleration is white from tick to tick with the deviation given, the reading's error that of a count, δ / √12. The gains at which
//! the filter settles are a closed form of the tracking index σ_a T² / σ_θ (P. R. Kalata: "The tracking index", IEEE Transactions on Aerospace
//! and Electronic Systems, 1984).

use super::Estimator;
use crate::actuator::fault::{Fault, positive};

/// An α-β filter with Kalman's gains.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Kalman {
    period: f64,
    alpha: f64,
    /// β / T.
    beta: f64,
    angle: Option<f64>,
    speed: f64,
}

impl Kalman {
    /// For readings every `period` seconds in counts of `count` radians, of a knob whose acceleration stays within `acceleration`
    /// (rad/s²), most of the time.
    ///
    /// # Errors
    /// A figure that is not above 0.
    pub fn new(acceleration: f64, count: f64, period: f64) -> Result<Self, Fault> {
        positive("acceleration", acceleration)?;
        positive("count", count)?;
        positive("period", period)?;
        let index = acceleration * period * period / (count / 12f64.sqrt());
        // r is the root of the innovation's poles' product; both differences from 1 are formed without loss for a small index.
        let reach = (index * (8.0 + index)).sqrt();
        let less = 0.25 * (reach - index);
        let alpha = less * (2.0 - less);
        // β = 2 (2 − α) − 4 √(1 − α) with √(1 − α) = 1 − less.
        let beta = 2.0 * less * less;
        Ok(Self { period, alpha, beta: beta / period, angle: None, speed: 0.0 })
    }

    /// α and β.
    pub fn gains(&self) -> (f64, f64) {
        (self.alpha, self.beta * self.period)
    }
}

impl Estimator for Kalman {
    #[inline(always)]
    fn push(&mut self, angle: f64) -> f64 {
        if angle.is_finite() {
            let predicted = self.angle.unwrap_or(angle) + self.speed * self.period;
            let off = angle - predicted;
            self.angle = Some(predicted + self.alpha * off);
            self.speed += self.beta * off;
        }
        self.speed
    }

    fn reset(&mut self, angle: f64) {
        (self.angle, self.speed) = (Some(angle), 0.0);
    }
}
