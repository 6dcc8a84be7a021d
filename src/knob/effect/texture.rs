//! Texture: a ripple over the angle, or a signal from elsewhere.

use super::events::Events;
use super::wave::{cosine, sine};
use super::{Bound, Effect, Modulation, Reading, nearest};
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};
use crate::knob::order::between;
use std::f64::consts::TAU;

/// The share of the servo's rate at which a ripple has faded; it begins to fade at half of that.
pub const MOST_SHARE: f64 = 0.1;

/// A sin(2π θ / λ). Passed fast, it would fold back about the servo's rate, so it fades as its frequency |ω| / λ nears [`MOST_SHARE`] of that.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ripple {
    /// A, N m.
    pub amplitude: f64,
    /// λ, radians.
    pub wavelength: f64,
}

impl Effect for Ripple {
    type State = ();

    fn check(&self) -> Result<(), Fault> {
        not_negative("amplitude", self.amplitude)?;
        positive("wavelength", self.wavelength)
    }

    fn bound(&self) -> Bound {
        Bound { stiffness: self.amplitude * TAU / self.wavelength, damping: 0.0 }
    }

    #[inline(always)]
    fn torque(&self, _: &mut (), r: &Reading, m: &Modulation, _: &mut Events) -> f64 {
        let inverse = 1.0 / self.wavelength;
        let waves = r.angle * inverse;
        let share = r.velocity.abs() * r.dt * inverse * (1.0 / MOST_SHARE);
        let weight = between(2.0 - 2.0 * share, 0.0, 1.0);
        m.gain * m.stiffness * self.amplitude * weight * sine(waves - nearest(waves))
    }

    fn energy(&self, angle: f64) -> Option<f64> {
        let waves = angle / self.wavelength;
        Some(self.amplitude * self.wavelength / TAU * cosine(waves - nearest(waves)))
    }
}

/// A signal from elsewhere, scaled: what is fed at a tick times a torque. What feeds it sets its band.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fed {
    /// N m for a signal of 1.
    pub scale: f64,
}

impl Effect for Fed {
    type State = ();

    fn check(&self) -> Result<(), Fault> {
        check("scale", self.scale, Limit::Least(f64::MIN))
    }

    fn bound(&self) -> Bound {
        Bound::default()
    }

    #[inline(always)]
    fn torque(&self, _: &mut (), _: &Reading, m: &Modulation, _: &mut Events) -> f64 {
        m.gain * self.scale * m.fed
    }
}
