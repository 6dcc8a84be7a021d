//! Magnet: an attractor with a reach.

use super::events::Events;
use super::{Bound, Effect, Modulation, Reading};
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};
use crate::knob::order::larger;

/// −K x (1 − (x / r)²)² of the way x from the centre, and 0 beyond the reach r: smooth everywhere.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Magnet {
    /// Where it is, radians.
    pub centre: f64,
    /// K at the centre, N m/rad; nowhere is it stiffer. The strongest pull is 0.286 K r, at 0.447 r.
    pub stiffness: f64,
    /// r, radians.
    pub reach: f64,
}

impl Effect for Magnet {
    type State = ();

    fn check(&self) -> Result<(), Fault> {
        check("centre", self.centre, Limit::Least(f64::MIN))?;
        not_negative("stiffness", self.stiffness)?;
        positive("reach", self.reach)
    }

    fn bound(&self) -> Bound {
        Bound { stiffness: self.stiffness, damping: 0.0 }
    }

    #[inline(always)]
    fn torque(&self, _: &mut (), r: &Reading, m: &Modulation, _: &mut Events) -> f64 {
        let away = r.angle - self.centre;
        let share = away / self.reach;
        let rest = larger(0.0, 1.0 - share * share);
        -m.gain * m.stiffness * self.stiffness * away * rest * rest
    }

    fn energy(&self, angle: f64) -> Option<f64> {
        let share = (angle - self.centre) / self.reach;
        let rest = (1.0 - share * share).max(0.0);
        Some(self.stiffness * self.reach * self.reach / 6.0 * (1.0 - rest * rest * rest))
    }
}
