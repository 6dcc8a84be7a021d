//! Damper: −B ω.

use super::events::Events;
use super::{Bound, Effect, Modulation, Reading};
use crate::actuator::fault::{Fault, not_negative};

/// A torque against the estimated speed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Damper {
    /// B, N m s/rad.
    pub damping: f64,
}

impl Effect for Damper {
    type State = ();

    fn check(&self) -> Result<(), Fault> {
        not_negative("damping", self.damping)
    }

    fn bound(&self) -> Bound {
        Bound { stiffness: 0.0, damping: self.damping }
    }

    #[inline(always)]
    fn torque(&self, _: &mut (), r: &Reading, m: &Modulation, _: &mut Events) -> f64 {
        -m.gain * m.damping * self.damping * r.velocity
    }
}
