//! Constant torque.

use super::events::Events;
use super::{Bound, Effect, Modulation, Reading};
use crate::actuator::fault::{Fault, Limit, check};

/// A torque that depends on nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Constant {
    /// N m; positive turns the knob to larger angles.
    pub torque: f64,
}

impl Effect for Constant {
    type State = ();

    fn check(&self) -> Result<(), Fault> {
        check("torque", self.torque, Limit::Least(f64::MIN))
    }

    fn bound(&self) -> Bound {
        Bound::default()
    }

    #[inline(always)]
    fn torque(&self, _: &mut (), _: &Reading, m: &Modulation, _: &mut Events) -> f64 {
        m.gain * self.torque
    }

    fn energy(&self, angle: f64) -> Option<f64> {
        Some(-self.torque * angle)
    }
}
