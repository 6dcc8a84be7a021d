//! A finite difference through a second-order low-pass.

use super::Estimator;
use super::difference::Difference;
use crate::actuator::fault::Fault;
use crate::knob::low_pass::LowPass;

/// A finite difference, smoothed: late by half a tick and √2 / ω of its corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Filtered {
    difference: Difference,
    low_pass: LowPass,
}

impl Filtered {
    /// With a corner at `hertz` for readings every `period` seconds; 100 Hz is common.
    ///
    /// # Errors
    /// `period` is not above 0; the corner is not below [`MOST_SHARE`](crate::knob::low_pass::MOST_SHARE) of the rate.
    pub fn new(hertz: f64, period: f64) -> Result<Self, Fault> {
        Ok(Self { low_pass: LowPass::new(hertz, period)?, difference: Difference::new(period)? })
    }
}

impl Estimator for Filtered {
    #[inline(always)]
    fn push(&mut self, angle: f64) -> f64 {
        self.low_pass.step(self.difference.push(angle))
    }

    fn reset(&mut self, angle: f64) {
        self.difference.reset(angle);
        self.low_pass.reset(0.0);
    }
}
