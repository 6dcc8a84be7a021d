//! Spring: −K (θ − θ₀).

use super::events::Events;
use super::{Bound, Effect, Modulation, Reading};
use crate::actuator::fault::{Fault, Limit, check, not_negative};

/// A spring to an angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spring {
    /// K, N m/rad.
    pub stiffness: f64,
    /// θ₀, radians.
    pub centre: f64,
}

impl Effect for Spring {
    type State = ();

    fn check(&self) -> Result<(), Fault> {
        not_negative("stiffness", self.stiffness)?;
        check("centre", self.centre, Limit::Least(f64::MIN))
    }

    fn bound(&self) -> Bound {
        Bound { stiffness: self.stiffness, damping: 0.0 }
    }

    #[inline(always)]
    fn torque(&self, _: &mut (), r: &Reading, m: &Modulation, _: &mut Events) -> f64 {
        -m.gain * m.stiffness * self.stiffness * (r.angle - self.centre)
    }

    fn energy(&self, angle: f64) -> Option<f64> {
        Some(0.5 * self.stiffness * (angle - self.centre).powi(2))
    }
}
