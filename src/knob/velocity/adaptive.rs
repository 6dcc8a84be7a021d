//! First-order adaptive windowing: the longest line that explains the last readings.
//!
//! F. Janabi-Sharifi, V. Hayward, C.-S. J. Chen: "Discrete-time adaptive windowing for velocity estimation", IEEE Transactions on Control Systems
//! Technology, 2000. The window grows while a line through the newest reading stays within one tolerance of every reading in it;
//! the tolerance of an encoder that rounds down is one count. Each older reading allows a range of slopes, and those ranges only
//! shrink, so that one pass over the window decides, not one for each length of it. It goes by eight readings at a time: where all of them lie
//! within what all eight leave of the range, none of them ends the window.

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

    /// How many readings a line through each of them and the newest explains, all before the first that it does not.
    #[inline(always)]
    fn longest_line(&self, angle: f64) -> usize {
        let past = self.ring.past();
        let (mut least, mut most, mut length) = (f64::NEG_INFINITY, f64::INFINITY, 0);
        for (past, inverse) in past.chunks_exact(TOGETHER).zip(self.inverse.chunks_exact(TOGETHER)) {
            let (mut ends, mut lows, mut highs) = ([0.0; TOGETHER], [0.0; TOGETHER], [0.0; TOGETHER]);
            for k in 0..TOGETHER {
                (ends[k], lows[k], highs[k]) = self.slopes(angle - past[k], inverse[k]);
            }
            let left = (larger(least, fold(&lows, larger)), smaller(most, fold(&highs, smaller)));
            if left.0 <= fold(&ends, smaller) && fold(&ends, larger) <= left.1 {
                (least, most) = left;
                length += TOGETHER;
                continue;
            }
            for k in 0..TOGETHER {
                if !(least <= ends[k] && ends[k] <= most) {
                    return length;
                }
                (least, most) = (larger(least, lows[k]), smaller(most, highs[k]));
                length += 1;
            }
        }
        for (past, inverse) in past.iter().zip(&self.inverse).skip(length) {
            let (end, low, high) = self.slopes(angle - past, *inverse);
            if !(least <= end && end <= most) {
                break;
            }
            (least, most) = (larger(least, low), smaller(most, high));
            length += 1;
        }
        length
    }

    /// The slope a tick to a reading, and the least and the most that it allows; its own lies between them.
    #[inline(always)]
    fn slopes(&self, rise: f64, inverse: f64) -> (f64, f64, f64) {
        (rise * inverse, (rise - self.tolerance) * inverse, (rise + self.tolerance) * inverse)
    }

    /// The slope a tick of least squares over a window.
    fn best(&self, angle: f64, length: usize) -> f64 {
        let (mut sum, mut moment, mut age) = (0.0, 0.0, 0.0);
        for past in self.ring.past().iter().take(length) {
            age += 1.0;
            let rise = angle - past;
            sum += rise;
            moment += age * rise;
        }
        (2.0 * moment - age * sum) * 6.0 / (age * (age + 1.0) * (age + 2.0))
    }
}

/// Readings that are looked at together.
const TOGETHER: usize = 8;

/// The extreme one, in two lanes that do not wait for each other.
#[inline(always)]
fn fold(values: &[f64; TOGETHER], extreme: impl Fn(f64, f64) -> f64) -> f64 {
    let mut lanes = [values[0], values[1]];
    for pair in values.chunks_exact(2).skip(1) {
        lanes = [extreme(lanes[0], pair[0]), extreme(lanes[1], pair[1])];
    }
    extreme(lanes[0], lanes[1])
}

impl Estimator for Adaptive {
    fn push(&mut self, angle: f64) -> f64 {
        if !angle.is_finite() {
            return self.speed;
        }
        self.ring.push(angle);
        let length = self.longest_line(angle);
        let past = self.ring.past();
        let mut slope = match length {
            0 => 0.0,
            _ => (angle - past[length - 1]) * self.inverse[length - 1],
        };
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
