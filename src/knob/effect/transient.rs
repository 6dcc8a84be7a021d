//! A burst at contact: what a stiff body says when it is struck, open loop.
//!
//! A sine that decays, as strong as the impact was fast (after Kuchenbecker, Fiene & Niemeyer 2006): it makes a wall hard that the rate
//! does not allow to be stiff. It follows any wall of its program, in the same tick.

use super::events::Events;
use super::{Bound, Effect, Modulation, Reading};
use crate::actuator::elementary::exp;
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};
use crate::dsp::elementary::phase_of;
use crate::dsp::sine::sine64;

/// A ringing at contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transient {
    /// Amplitude for an impact at 1 rad/s, N m s/rad.
    pub strength: f64,
    /// 20 to 300 Hz.
    pub hertz: f64,
    /// Seconds in which it falls to 1/e.
    pub decay: f64,
    /// Impacts below this speed pass unheard, rad/s.
    pub least: f64,
    /// The largest amplitude, N m.
    pub most: f64,
}

/// Below this it has ended, N m.
const SILENCE: f64 = 1e-9;

/// The ringing as a turning, shrinking pointer.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    pointer: [f64; 2],
    turn: [f64; 2],
    sounds: bool,
}

impl Effect for Transient {
    type State = State;

    fn check(&self) -> Result<(), Fault> {
        not_negative("strength", self.strength)?;
        check("hertz", self.hertz, Limit::Within(20.0, 300.0, "Hz"))?;
        positive("decay", self.decay)?;
        not_negative("least", self.least)?;
        positive("most", self.most)
    }

    fn bound(&self) -> Bound {
        Bound::default()
    }

    #[inline(always)]
    fn torque(&self, state: &mut State, r: &Reading, m: &Modulation, events: &mut Events) -> f64 {
        let impact = events.impact();
        if impact > self.least {
            self.strike(state, impact, r.velocity > 0.0, r.dt);
        }
        if !state.sounds {
            return 0.0;
        }
        let ([x, y], [c, s]) = (state.pointer, state.turn);
        state.pointer = [c * x - s * y, s * x + c * y];
        state.sounds = x.abs() + y.abs() > SILENCE;
        m.gain * y
    }
}

impl Transient {
    #[cold]
    fn strike(&self, state: &mut State, speed: f64, rises: bool, dt: f64) {
        // Against the motion first: a wall pushes back.
        let size = f64::min(self.strength * speed, self.most) * if rises { -1.0 } else { 1.0 };
        let (phase, shrunk) = (phase_of(self.hertz * dt), exp(-dt / self.decay));
        state.turn = [shrunk * sine64(phase.wrapping_add(1 << 62)), shrunk * sine64(phase)];
        state.pointer = [size, 0.0];
        state.sounds = true;
    }
}
