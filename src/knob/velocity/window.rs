//! An adaptive window for rates far above those of counts.
//!
//! How long a line explains the readings is found out of every so-manieth of them, which costs little; the speed is the slope between the ends
//! of that window at every tick. For a window that does not change this is a plain difference over its ticks, so that the loop's
//! eigenvalues with it are known ([`transfer`](super::transfer)).

use super::Estimator;
use super::adaptive::{Adaptive, Fit, MOST_WINDOW};
use super::ring::Ring;
use crate::actuator::fault::{Fault, Limit, check, positive};

/// The most readings that are looked at for the length of the window.
const LOOKS: f64 = 32.0;
/// The longest window, ticks.
const MOST_TICKS: f64 = LOOKS * 4096.0;

/// An adaptive window, looked at every so many ticks.
#[derive(Debug, Clone, PartialEq)]
pub struct Window {
    /// What finds the length.
    looks: Adaptive,
    every: usize,
    until: usize,
    rate: f64,
    ring: Ring,
    /// Ticks of the window.
    ticks: usize,
    /// One over their time.
    inverse: f64,
    speed: f64,
}

/// Ticks from look to look, and looks in the longest window.
pub(crate) fn looks(seconds: f64, period: f64) -> Result<(usize, usize), Fault> {
    positive("window", seconds)?;
    positive("period", period)?;
    let ticks = (seconds / period).round();
    check("window", ticks, Limit::Most(MOST_TICKS))?;
    let every = (ticks / LOOKS).ceil().max(1.0);
    let longest = (ticks / every).round().clamp(1.0, MOST_WINDOW as f64);
    Ok((every as usize, longest as usize))
}

impl Window {
    /// Of at most `seconds`, for readings every `period` seconds in counts of `count` radians.
    ///
    /// # Errors
    /// A figure that is not above 0; a window of more than 131,072 ticks.
    pub fn new(seconds: f64, count: f64, period: f64) -> Result<Self, Fault> {
        let (every, longest) = looks(seconds, period)?;
        Ok(Self {
            looks: Adaptive::new(Fit::End, longest, count, period * every as f64)?,
            every,
            until: 1,
            rate: 1.0 / period,
            ring: Ring::new(every * longest),
            ticks: 0,
            inverse: 0.0,
            speed: 0.0,
        })
    }

    /// Ticks of the window that was used last.
    pub fn ticks(&self) -> usize {
        self.ticks
    }
}

impl Estimator for Window {
    #[inline(always)]
    fn push(&mut self, angle: f64) -> f64 {
        if !angle.is_finite() {
            return self.speed;
        }
        self.ring.push(angle);
        self.until -= 1;
        if self.until == 0 {
            self.until = self.every;
            self.looks.push(angle);
            let ticks = (self.looks.window() * self.every).min(self.ring.before());
            if ticks != self.ticks {
                self.ticks = ticks;
                self.inverse = if ticks > 0 { self.rate / ticks as f64 } else { 0.0 };
            }
        }
        self.speed = (angle - self.ring.at(self.ticks)) * self.inverse;
        self.speed
    }

    fn reset(&mut self, angle: f64) {
        self.looks.reset(angle);
        self.ring.fill(angle);
        (self.until, self.speed) = (1, 0.0);
    }
}
