//! First-order adaptive windowing: the longest line that explains the last readings.
//!
//! F. Janabi-Sharifi, V. Hayward, C.-S. J. Chen: "Discrete-time adaptive windowing for velocity estimation", IEEE Transactions on Control Systems
//! Technology, 2000. The window grows while a line through the newest reading stays within one tolerance of every reading in it;
//! the tolerance of an encoder that rounds down is one count. Each older reading allows a range of slopes, and those ranges only
//! shrink, so that one pass over the window decides, not one for each length of it.

use super::Estimator;
use super::ring::Ring;
use crate::actuator::fault::{Fault, Limit, check, positive};
use crate::knob::order::{larger, smaller};

/// Which line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fit {
    /// Through the newest and the oldest reading.
    End,
    /// The slope of least squares.
    Best,
}

/// The longest window, ticks.
pub const MOST_WINDOW: usize = 4096;

/// An adaptive window.
#[derive(Debug, Clone, PartialEq)]
pub struct Adaptive {
    fit: Fit,
    tolerance: f64,
    rate: f64,
    /// One over the ages from 1 on.
    inverse: Box<[f64]>,
    ring: Ring,
    length: usize,
    speed: f64,
}

impl Adaptive {
    /// A window of up to `longest` ticks for readings every `period` seconds in counts of `count` radians.
    ///
    /// # Errors
    /// `period` or `count` is not above 0; `longest` is not within 1 and [`MOST_WINDOW`].
    pub fn new(fit: Fit, longest: usize, count: f64, period: f64) -> Result<Self, Fault> {
        positive("period", period)?;
        positive("count", count)?;
        check("window", longest as f64, Limit::Within(1.0, MOST_WINDOW as f64, "ticks"))?;
        let inverse = (1..=longest).map(|n| 1.0 / n as f64).collect();
        Ok(Self {
            fit,
            // What rounding does to an angle of many turns must not count as a deviation.
            tolerance: count * (1.0 + 1e-6),
            rate: 1.0 / period,
            inverse,
            ring: Ring::new(longest),
            length: 0,
            speed: 0.0,
        })
    }

    /// Ticks of the window that was used last.
    pub fn window(&self) -> usize {
        self.length
    }

    /// The slope a tick of least squares over a window.
    fn best(&self, angle: f64, length: usize) -> f64 {
        let (mut sum, mut moment, mut age) = (0.0, 0.0, 0.0);
        for past in self.ring.past().iter().rev().take(length) {
            age += 1.0;
            let rise = angle - past;
            sum += rise;
            moment += age * rise;
        }
        (2.0 * moment - age * sum) * 6.0 / (age * (age + 1.0) * (age + 2.0))
    }
}

impl Estimator for Adaptive {
    fn push(&mut self, angle: f64) -> f64 {
        if !angle.is_finite() {
            return self.speed;
        }
        self.ring.push(angle);
        // Slopes a tick that every reading so far allows.
        let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut slope, mut length) = (0.0, 0);
        for (past, inverse) in self.ring.past().iter().rev().zip(&self.inverse) {
            let rise = angle - past;
            let end = rise * inverse;
            // A reading's own range holds its slope.
            if !(least <= end && end <= most) {
                break;
            }
            least = larger(least, (rise - self.tolerance) * inverse);
            most = smaller(most, (rise + self.tolerance) * inverse);
            slope = end;
            length += 1;
        }
        if self.fit == Fit::Best && length > 0 {
            slope = self.best(angle, length);
        }
        self.length = length;
        self.speed = slope * self.rate;
        self.speed
    }

    fn reset(&mut self, angle: f64) {
        self.ring.fill(angle);
        (self.length, self.speed) = (0, 0.0);
    }
}
