//! An estimator at a fraction of the rate.

use super::Estimator;
use crate::actuator::fault::{Fault, Limit, check};

/// Hands every `every`-th reading on, and holds the speed in between. Its estimator is made for `every` times the period.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Decimated<E> {
    inner: E,
    every: u32,
    until: u32,
    speed: f64,
}

impl<E: Estimator> Decimated<E> {
    /// Around an estimator.
    ///
    /// # Errors
    /// `every` is 0.
    pub fn new(inner: E, every: u32) -> Result<Self, Fault> {
        check("every", f64::from(every), Limit::Least(1.0))?;
        Ok(Self { inner, every, until: 1, speed: 0.0 })
    }
}

impl<E: Estimator> Estimator for Decimated<E> {
    #[inline(always)]
    fn push(&mut self, angle: f64) -> f64 {
        self.until -= 1;
        if self.until == 0 {
            self.until = self.every;
            self.speed = self.inner.push(angle);
        }
        self.speed
    }

    fn reset(&mut self, angle: f64) {
        self.inner.reset(angle);
        (self.until, self.speed) = (1, 0.0);
    }
}
