//! Any estimator, chosen when a knob is made.

use super::Estimator;
use super::difference::Difference;
use super::filtered::Filtered;
use super::kalman::Kalman;
use super::transfer::Transfer;
use super::window::{Window, looks};
use crate::actuator::fault::Fault;
use crate::knob::low_pass::LowPass;
use std::fmt;

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

/// An estimator at work, with a tag of its own for the sake of [`push`](Estimator::push).
#[derive(Debug, Clone, PartialEq)]
#[repr(u8)]
pub(crate) enum Any {
    Difference(Difference),
    Filtered(Filtered),
    Adaptive(Window),
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
            Self::Adaptive(seconds) => Any::Adaptive(Window::new(seconds, count, period)?),
            Self::Kalman(acceleration) => Any::Kalman(Kalman::new(acceleration, count, period)?),
        })
    }

    /// What it does to small motions; of a window, for lengths from the shortest to the longest, each half as long again as the one before.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn transfers(self, count: f64, period: f64) -> Result<Vec<Transfer>, Fault> {
        Ok(match self {
            Self::Difference => vec![Transfer::difference(1)],
            Self::Filtered(hertz) => vec![Transfer::filtered(&LowPass::new(hertz, period)?)],
            Self::Adaptive(seconds) => {
                let (every, longest) = looks(seconds, period)?;
                let mut lengths = vec![longest];
                while let Some(&length) = lengths.last().filter(|length| **length > 1) {
                    lengths.push((length * 2 / 3).max(1));
                }
                lengths.iter().rev().map(|length| Transfer::difference(every * length)).collect()
            }
            Self::Kalman(acceleration) => {
                let (alpha, beta) = Kalman::new(acceleration, count, period)?.gains();
                vec![Transfer::tracking(alpha, beta)]
            }
        })
    }

    /// The same, twice as quick; `None` of what cannot be quicker.
    pub(crate) fn quicker(self) -> Option<Self> {
        match self {
            Self::Difference => None,
            Self::Filtered(hertz) => Some(Self::Filtered(2.0 * hertz)),
            Self::Adaptive(seconds) => Some(Self::Adaptive(0.5 * seconds)),
            // The filter's own frequency goes with the root of it.
            Self::Kalman(acceleration) => Some(Self::Kalman(4.0 * acceleration)),
        }
    }
}

impl fmt::Display for Choice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Difference => f.write_str("a plain difference"),
            Self::Filtered(hertz) => write!(f, "a velocity corner of {hertz:.0} Hz"),
            Self::Adaptive(seconds) => {
                write!(f, "a velocity window of {} ms", (1e5 * seconds).round() * 1e-2)
            }
            Self::Kalman(acceleration) => write!(f, "a Kalman filter for {acceleration:.0} rad/s²"),
        }
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
