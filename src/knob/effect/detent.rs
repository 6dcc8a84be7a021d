//! Detents: so many places a turn that hold the knob.

use super::events::{Events, What};
use super::wave::{cosine, sine};
use super::{Bound, Effect, Modulation, Reading, nearest};
use crate::actuator::fault::{Fault, Limit, check, not_negative};
use crate::knob::order::smaller;
use std::f64::consts::{FRAC_PI_2, TAU};

/// How torque runs from one detent to the next, as a multiple of the amplitude. u is the way from the detent in pitches, ±½.
#[derive(Debug, Clone, PartialEq)]
pub enum Shape {
    /// −sin 2πu.
    Sine,
    /// Straight: −4u up to a quarter of the pitch, and back to 0 at the crest.
    Triangle,
    /// Values at equal steps over a pitch, the first at the detent's left crest (u = −½), read with straight lines and from the last to the
    /// first again. Two or more, each within ±1.
    Table(Box<[f64]>),
}

/// Detents all around.
#[derive(Debug, Clone, PartialEq)]
pub struct Detent {
    /// How many a turn: above 0, and not necessarily whole.
    pub count: f64,
    /// The largest torque, N m.
    pub amplitude: f64,
    /// Where one of them is, radians.
    pub centre: f64,
    /// From one to the next.
    pub shape: Shape,
    /// By how much of a pitch the knob must pass a crest until it counts as passed: 0 to 0.4, so that it does not tremble there.
    pub hysteresis: f64,
}

/// In which detent the knob is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct State {
    index: Option<f64>,
}

impl Detent {
    /// Torque over amplitude and its potential over amplitude and pitch, u pitches from a detent.
    #[inline(always)]
    fn value(&self, u: f64) -> f64 {
        match &self.shape {
            Shape::Sine => -sine(u),
            Shape::Triangle => {
                let away = u.abs();
                let size = 4.0 * smaller(away, 0.5 - away);
                if u > 0.0 { -size } else { size }
            }
            Shape::Table(values) => {
                let n = values.len();
                let at = (u + 0.5) * n as f64;
                let k = (at as usize).min(n - 1);
                let next = if k + 1 == n { 0 } else { k + 1 };
                values[k] + (values[next] - values[k]) * (at - k as f64)
            }
        }
    }
}

impl Effect for Detent {
    type State = State;

    fn check(&self) -> Result<(), Fault> {
        check("count", self.count, Limit::Within(1e-3, 1e5, "a turn"))?;
        not_negative("amplitude", self.amplitude)?;
        check("centre", self.centre, Limit::Least(f64::MIN))?;
        check("hysteresis", self.hysteresis, Limit::Within(0.0, 0.4, "pitches"))?;
        if let Shape::Table(values) = &self.shape {
            check("table", values.len() as f64, Limit::Within(2.0, 65_536.0, "values"))?;
            values.iter().try_for_each(|v| check("table", *v, Limit::Within(-1.0, 1.0, "amplitudes")))?;
        }
        Ok(())
    }

    fn bound(&self) -> Bound {
        let pitches = self.count / TAU;
        let steepest = match &self.shape {
            Shape::Sine => TAU,
            Shape::Triangle => 4.0,
            Shape::Table(values) => {
                let n = values.len();
                (0..n).map(|k| (values[(k + 1) % n] - values[k]).abs()).fold(0.0, f64::max) * n as f64
            }
        };
        Bound { stiffness: self.amplitude * steepest * pitches, damping: 0.0 }
    }

    #[inline(always)]
    fn torque(&self, state: &mut State, r: &Reading, m: &Modulation, events: &mut Events) -> f64 {
        let turns = (r.angle - self.centre) * (self.count * (1.0 / TAU));
        let index = nearest(turns);
        match state.index {
            None => state.index = Some(index),
            Some(old) => {
                if (turns - old).abs() > 0.5 + self.hysteresis && index != old {
                    state.index = Some(index);
                    events.push(What::Detent { index: index as i64, passed: (index - old) as i64 });
                }
            }
        }
        m.gain * m.stiffness * self.amplitude * self.value(turns - index)
    }

    fn energy(&self, angle: f64) -> Option<f64> {
        let turns = (angle - self.centre) * (self.count / TAU);
        let u = turns - nearest(turns);
        let height = match &self.shape {
            Shape::Sine => (1.0 - cosine(u)) / TAU,
            Shape::Triangle if u.abs() <= 0.25 => 2.0 * u * u,
            Shape::Triangle => 0.25 - 2.0 * (0.5 - u.abs()).powi(2),
            Shape::Table(_) => return None,
        };
        Some(self.amplitude * height * TAU / self.count)
    }
}

impl Detent {
    /// Detents whose stiffness at rest is K (N m/rad): sine-shaped, so A = K / N.
    pub fn with_stiffness(count: f64, stiffness: f64) -> Self {
        Self { count, amplitude: stiffness / count, centre: 0.0, shape: Shape::Sine, hysteresis: 0.05 }
    }

    /// The stiffness at rest of its shape, N m/rad.
    pub fn stiffness(&self) -> f64 {
        match self.shape {
            Shape::Sine => self.amplitude * self.count,
            Shape::Triangle => self.amplitude * self.count / FRAC_PI_2,
            Shape::Table(_) => self.bound().stiffness,
        }
    }
}
