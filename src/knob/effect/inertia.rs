//! Inertia: a flywheel behind a spring and a damper.
//!
//! An acceleration that was differentiated twice would let the knob swing by itself as soon as the rendered inertia is of the order of its
//! own. A flywheel that the knob turns through a coupling has no such limit: between readings the knob turns steadily, so what
//! the coupling does is linear and its step is exact (e^{AT}), stable for every inertia, stiffness and rate. What the knob feels is the
//! coupling, which the governor knows.

use super::events::Events;
use super::{Bound, Effect, Modulation, Reading};
use crate::actuator::exponential::{Square, exponential};
use crate::actuator::fault::{Fault, not_negative, positive};
use crate::knob::order::smaller;

/// A virtual flywheel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// Of the flywheel, kg m².
    pub inertia: f64,
    /// K of the coupling, N m/rad.
    pub stiffness: f64,
    /// B of the coupling, N m s/rad: above 0, or rounding alone would keep it swinging.
    pub damping: f64,
}

/// The flywheel's motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    last: Option<f64>,
    /// Its lead over the knob, radians.
    lead: f64,
    /// Its speed, rad/s.
    speed: f64,
    /// The time for which `step` holds, and the step of lead and relative speed.
    dt: f64,
    rate: f64,
    step: [[f64; 2]; 2],
}

impl State {
    /// The flywheel's speed, rad/s.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// Energy of flywheel and coupling, joules.
    pub fn energy(&self, of: &Inertia) -> f64 {
        0.5 * (of.inertia * self.speed * self.speed + of.stiffness * self.lead * self.lead)
    }
}

impl Inertia {
    fn step(&self, dt: f64) -> [[f64; 2]; 2] {
        let mut a = Square::default();
        a[0][1] = 1.0;
        a[1][0] = -self.stiffness / self.inertia;
        a[1][1] = -self.damping / self.inertia;
        let e = exponential(&a, 2, dt);
        [[1.0 + e[0][0], e[0][1]], [e[1][0], 1.0 + e[1][1]]]
    }
}

impl Effect for Inertia {
    type State = State;

    fn check(&self) -> Result<(), Fault> {
        positive("inertia", self.inertia)?;
        not_negative("stiffness", self.stiffness)?;
        positive("damping", self.damping)
    }

    fn bound(&self) -> Bound {
        Bound { stiffness: self.stiffness, damping: self.damping }
    }

    #[inline(always)]
    fn torque(&self, state: &mut State, r: &Reading, m: &Modulation, _: &mut Events) -> f64 {
        if r.dt != state.dt {
            (state.dt, state.rate, state.step) = (r.dt, 1.0 / r.dt, self.step(r.dt));
        }
        let Some(last) = state.last else {
            state.last = Some(r.angle);
            return 0.0;
        };
        let turned = (r.angle - last) * state.rate;
        state.last = Some(r.angle);
        let (lead, apart) = (state.lead, state.speed - turned);
        let s = &state.step;
        state.lead = s[0][0] * lead + s[0][1] * apart;
        state.speed = s[1][0] * lead + s[1][1] * apart + turned;
        // One share for both, so that what the knob feels is a lighter flywheel on the same coupling.
        let share = smaller(m.stiffness, m.damping);
        m.gain * share * (self.stiffness * state.lead + self.damping * (state.speed - r.velocity))
    }
}
