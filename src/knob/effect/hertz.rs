//! Contact of a round body: −k p^{3/2}.
//!
//! H. Hertz (1882): k = (4/3) E* √R, for a depth p. The local stiffness 3 F / 2 p rises without end, so the torque has an end, from which
//! follows the largest stiffness: (3/2) k^{2/3} F^{1/3}.

use super::events::{Events, What};
use super::{Bound, Effect, Modulation, Reading};
use crate::actuator::elementary::{exp, ln};
use crate::actuator::fault::{Fault, Limit, check, positive};
use crate::knob::order::smaller;

/// A round body in the way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hertz {
    /// Where contact begins, radians.
    pub angle: f64,
    /// Whether it stands in the way of smaller angles rather than larger ones.
    pub below: bool,
    /// k, N m/rad^{3/2}.
    pub factor: f64,
    /// The largest torque, N m: beyond it the body gives way.
    pub most: f64,
}

/// Whether the knob is in contact.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    inside: bool,
}

impl Hertz {
    fn depth(&self, angle: f64) -> f64 {
        if self.below { self.angle - angle } else { angle - self.angle }
    }
}

impl Effect for Hertz {
    type State = State;

    fn check(&self) -> Result<(), Fault> {
        check("angle", self.angle, Limit::Least(f64::MIN))?;
        positive("factor", self.factor)?;
        positive("most", self.most)
    }

    fn bound(&self) -> Bound {
        let stiffness = 1.5 * exp((2.0 * ln(self.factor) + ln(self.most)) / 3.0);
        Bound { stiffness, damping: 0.0 }
    }

    #[inline(always)]
    fn torque(&self, state: &mut State, r: &Reading, m: &Modulation, events: &mut Events) -> f64 {
        let depth = self.depth(r.angle);
        let inside = depth > 0.0;
        if inside && !state.inside {
            events.push(What::Wall { speed: r.velocity.abs(), side: if self.below { -1 } else { 1 } });
        }
        state.inside = inside;
        if !inside {
            return 0.0;
        }
        let push = m.gain * m.stiffness * smaller(self.most, self.factor * depth * depth.sqrt());
        if self.below { push } else { -push }
    }

    fn energy(&self, angle: f64) -> Option<f64> {
        let depth = self.depth(angle).max(0.0);
        let last = exp((ln(self.most) - ln(self.factor)) * (2.0 / 3.0));
        let within = depth.min(last);
        Some(0.4 * self.factor * within * within * within.sqrt() + self.most * (depth - within))
    }
}
