//! Spin: a pull to a speed.

use super::events::Events;
use super::{Bound, Effect, Modulation, Reading};
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};
use crate::knob::order::{larger, smaller};

/// B (ω₀ − ω), within a largest torque: a knob that turns by itself and can be held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spin {
    /// ω₀, rad/s.
    pub speed: f64,
    /// B, N m s/rad.
    pub damping: f64,
    /// The largest torque, N m.
    pub most: f64,
}

impl Effect for Spin {
    type State = ();

    fn check(&self) -> Result<(), Fault> {
        check("speed", self.speed, Limit::Least(f64::MIN))?;
        not_negative("damping", self.damping)?;
        positive("most", self.most)
    }

    fn bound(&self) -> Bound {
        Bound { stiffness: 0.0, damping: self.damping }
    }

    #[inline(always)]
    fn torque(&self, _: &mut (), r: &Reading, m: &Modulation, _: &mut Events) -> f64 {
        let pull = m.damping * self.damping * (self.speed - r.velocity);
        m.gain * smaller(self.most, larger(-self.most, pull))
    }
}
