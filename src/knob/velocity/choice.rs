//! Any estimator, chosen when a knob is made.

use super::adaptive::{Adaptive, Fit};
use super::decimated::Decimated;
use super::difference::Difference;
use super::filtered::Filtered;
use super::kalman::Kalman;
use super::{Estimator, adaptive};
use crate::actuator::fault::Fault;

/// Which estimator, and its figure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Choice {
    /// The last step over its time.
    Difference,
    /// That behind a low-pass with its corner at so many hertz.
    Filtered(f64),
    /// The longest line that explains the readings of at most so many seconds.
    Adaptive(f64),
    /// For accelerations of so many rad/s², root-mean-square.
    Kalman(f64),
}

/// The most readings that a window looks at: it takes every so-manieth of more.
const LOOKS: f64 = 32.0;

/// An estimator at work.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Any {
    Difference(Difference),
    Filtered(Filtered),
    Adaptive(Box<Decimated<Adaptive>>),
    Kalman(Kalman),
}

impl Choice {
    /// For readings in counts of `count` radians every `period` seconds.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub(crate) fn started(self, count: f64, period: f64) -> Result<Any, Fault> {
        Ok(match self {
            Self::Difference => Any::Difference(Difference::new(period)?),
            Self::Filtered(hertz) => Any::Filtered(Filtered::new(hertz, period)?),
            Self::Adaptive(seconds) => {
                crate::actuator::fault::positive("window", seconds)?;
                let ticks = (seconds / period).round().clamp(1.0, 1e9);
                let every = (ticks / LOOKS).ceil().max(1.0);
                let longest = (ticks / every).round().clamp(1.0, adaptive::MOST_WINDOW as f64);
                let inner = Adaptive::new(Fit::Best, longest as usize, count, period * every)?;
                Any::Adaptive(Box::new(Decimated::new(inner, every as u32)?))
            }
            Self::Kalman(acceleration) => Any::Kalman(Kalman::new(acceleration, count, period)?),
        })
    }
}

impl Estimator for Any {
    #[inline(always)]
    fn push(&mut self, angle: f64) -> f64 {
        match self {
            Self::Difference(e) => e.push(angle),
            Self::Filtered(e) => e.push(angle),
            Self::Adaptive(e) => e.push(angle),
            Self::Kalman(e) => e.push(angle),
        }
    }

    fn reset(&mut self, angle: f64) {
        match self {
            Self::Difference(e) => e.reset(angle),
            Self::Filtered(e) => e.reset(angle),
            Self::Adaptive(e) => e.reset(angle),
            Self::Kalman(e) => e.reset(angle),
        }
    }
}
