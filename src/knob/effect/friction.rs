//! Dry friction of displacement: no speed is needed, and nothing creeps.
//!
//! V. Hayward, B. S. R. Armstrong: "A new computational model of friction applied to haptic rendering", Experimental Robotics VI, 2000. The
//! knob drags a point of adhesion behind it on a spring of length z: while |z| is below its largest the point stays, so that what returns to
//! its angle returns to its torque, however often; beyond it the point follows. Time does not enter: a path gives the same torques
//! at any speed and rate. P. R. Dahl's model (1968), dz = dx (1 − sgn(dx) z / z_max), here integrated exactly over each step, is rounder
//! at the turn but creeps under a load that trembles.

use super::events::Events;
use super::{Bound, Effect, Modulation, Reading};
use crate::actuator::elementary::exp;
use crate::actuator::fault::{Fault, not_negative, positive};
use crate::knob::order::{larger, smaller};

/// How the point of adhesion follows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// Not at all up to the largest length, wholly beyond it.
    Adhesion,
    /// More and more.
    Dahl,
}

/// Dry friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Friction {
    /// Of sliding, N m.
    pub torque: f64,
    /// z_max, radians: how far the knob gives before it slides. Several counts of the encoder, or it will be felt as steps.
    pub stretch: f64,
    /// How the point follows.
    pub law: Law,
}

/// Where the point of adhesion is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    last: Option<f64>,
    /// z.
    length: f64,
}

impl State {
    /// Energy that the spring holds, joules.
    pub fn energy(&self, friction: &Friction) -> f64 {
        0.5 * friction.torque / friction.stretch * self.length * self.length
    }
}

impl Effect for Friction {
    type State = State;

    fn check(&self) -> Result<(), Fault> {
        not_negative("torque", self.torque)?;
        positive("stretch", self.stretch)
    }

    fn bound(&self) -> Bound {
        Bound { stiffness: self.torque / self.stretch, damping: 0.0 }
    }

    #[inline(always)]
    fn torque(&self, state: &mut State, r: &Reading, m: &Modulation, _: &mut Events) -> f64 {
        let moved = r.angle - state.last.unwrap_or(r.angle);
        state.last = Some(r.angle);
        let (z, most) = (state.length, self.stretch);
        state.length = match self.law {
            Law::Adhesion => smaller(most, larger(-most, z + moved)),
            Law::Dahl if moved == 0.0 => z,
            Law::Dahl => {
                let end = if moved > 0.0 { most } else { -most };
                end + (z - end) * exp(-moved.abs() / most)
            }
        };
        -m.gain * m.stiffness * self.torque * (state.length / most)
    }
}
