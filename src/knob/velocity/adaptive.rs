//! First-order adaptive windowing: the longest line that explains the last readings.
//!
//! F. Janabi-Sharifi, V. Hayward, C.-S. J. Chen: "Discrete-time adaptive windowing for velocity estimation", IEEE Transactions on Control Systems
//! Technology, 2000. The window grows while a line through the newest reading stays within one tolerance of every reading in it;
//! the tolerance of an encoder that rounds down is one count. Each older reading allows a range of slopes, and those ranges only
//! shrink, so that one pass over the window decides, not one for each length of it.

use super::Estimator;
use crate::actuator::fault::{Fault, Limit, check, positive};

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
    /// One over the ages.
    inverse: Box<[f64]>,
    ring: Box<[f64]>,
    newest: usize,
    filled: usize,
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
        let inverse = (0..=longest).map(|n| if n == 0 { 0.0 } else { 1.0 / n as f64 }).collect();
        Ok(Self {
            fit,
            // What rounding does to an angle of many turns must not count as a deviation.
            tolerance: count * (1.0 + 1e-6),
            rate: 1.0 / period,
            inverse,
            ring: vec![0.0; longest + 1].into_boxed_slice(),
            newest: 0,
            filled: 0,
            length: 0,
            speed: 0.0,
        })
    }

    /// Ticks of the window that was used last.
    pub fn window(&self) -> usize {
        self.length
    }
}

impl Estimator for Adaptive {
    fn push(&mut self, angle: f64) -> f64 {
        if !angle.is_finite() {
            return self.speed;
        }
        let size = self.ring.len();
        self.newest = if self.newest + 1 == size { 0 } else { self.newest + 1 };
        self.ring[self.newest] = angle;
        self.filled = (self.filled + 1).min(size);
        // Slopes a tick that every reading so far allows.
        let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
        let (mut sum, mut moment, mut best_sum, mut best_moment) = (0.0, 0.0, 0.0, 0.0);
        let (mut slope, mut length, mut at) = (0.0, 0, self.newest);
        for age in 1..self.filled {
            at = if at == 0 { size - 1 } else { at - 1 };
            let (rise, n, inverse) = (angle - self.ring[at], age as f64, self.inverse[age]);
            least = f64::max(least, (rise - self.tolerance) * inverse);
            most = f64::min(most, (rise + self.tolerance) * inverse);
            sum += rise;
            moment += n * rise;
            let end = rise * inverse;
            if !(least <= end && end <= most) {
                break;
            }
            (slope, length) = (end, age);
            (best_sum, best_moment) = (sum, moment);
        }
        if self.fit == Fit::Best && length > 0 {
            let n = length as f64;
            slope = (2.0 * best_moment - n * best_sum) * 6.0 / (n * (n + 1.0) * (n + 2.0));
        }
        self.length = length;
        self.speed = slope * self.rate;
        self.speed
    }

    fn reset(&mut self, angle: f64) {
        self.ring.fill(angle);
        (self.filled, self.length, self.speed) = (self.ring.len(), 0, 0.0);
    }
}
