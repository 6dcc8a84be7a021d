//! What comes out of a motor.

use super::model::{Counts, Grip, Motor};
use super::mount::Mount;
use super::parameters::{Casing, Parameters};
use super::plan::Plan;
use crate::actuator::elementary::{cosine, sine};

/// What a motor does at an instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Reading {
    /// Of the coil, A.
    pub current: f64,
    /// At the terminals, V.
    pub voltage: f64,
    /// rad/s.
    pub speed: f64,
    /// Within ±π, 0 where the mass hangs, rad.
    pub angle: f64,
    /// Whole turns beside the angle.
    pub turns: f64,
    /// Of the rotor, rad/s².
    pub angular_acceleration: f64,
    /// What the mass does to the casing, sideways and upward, N, without its weight: m_e r (ω² sin θ − α cos θ, −ω² cos θ − α sin θ).
    pub force: [f64; 2],
    /// Of the casing, m/s².
    pub acceleration: [f64; 2],
    /// Of a casing on springs, m.
    pub displacement: [f64; 2],
    /// What coil and friction do to the casing about the shaft, N m: the negative of what they do to the rotor.
    pub reaction: f64,
}

impl<const BOOKED: bool> Motor<BOOKED> {
    /// What it does now. Force, acceleration and displacement are 0 where the plan leaves the casing out.
    pub fn reading(&self) -> Reading {
        let (x, phase) = (self.state.motion(), self.state.phase);
        let alpha = self.angular_acceleration();
        Reading {
            current: x.current,
            voltage: self.terminal(),
            speed: x.speed,
            angle: std::f64::consts::TAU * phase,
            turns: self.state.turns,
            angular_acceleration: alpha,
            force: self.force(),
            acceleration: self.acceleration(),
            displacement: self.mount.as_ref().map_or([0.0; 2], Mount::displacement),
            reaction: self.reaction(),
        }
    }

    /// [`Reading::force`].
    #[inline]
    pub fn force(&self) -> [f64; 2] {
        if !self.plan.casing {
            return [0.0; 2];
        }
        let (phase, speed) = (self.state.phase, self.state.speed);
        let (s, c, square, lever) = (sine(phase), cosine(phase), speed * speed, self.parameters.eccentric);
        let alpha = if self.grip == Grip::Sticks { 0.0 } else { self.turns_by(-self.weight * s) };
        [lever * (square * s - alpha * c), lever * (-square * c - alpha * s)]
    }

    /// [`Reading::acceleration`].
    #[inline]
    pub fn acceleration(&self) -> [f64; 2] {
        match (self.parameters.casing, &self.mount) {
            (Casing::Free { mass }, _) => self.force().map(|f| f / mass),
            (Casing::Suspended { mass, .. }, Some(mount)) => {
                mount.acceleration(self.force().map(|f| f / mass))
            }
            _ => [0.0; 2],
        }
    }

    /// What the mass has given the casing so far, sideways and upward, N s, without its weight: the integral of [`Reading::force`] from rest
    /// on, −m_e r (ω cos θ, ω sin θ). Whatever the plan leaves out.
    #[inline]
    pub fn impulse(&self) -> [f64; 2] {
        let (phase, lever) = (self.state.phase, self.parameters.eccentric * self.state.speed);
        [-lever * cosine(phase), -lever * sine(phase)]
    }

    /// Velocity of the casing, m/s: the integral of [`Reading::acceleration`]. 0 where the plan leaves the casing out.
    #[inline]
    pub fn casing_velocity(&self) -> [f64; 2] {
        match (self.parameters.casing, &self.mount) {
            (Casing::Free { mass }, _) if self.plan.casing => self.impulse().map(|given| given / mass),
            (Casing::Suspended { .. }, Some(mount)) => mount.velocity(),
            _ => [0.0; 2],
        }
    }

    /// By how much the mass has turned since it hung straight down, whole turns included, rad.
    #[inline]
    pub fn turned(&self) -> f64 {
        std::f64::consts::TAU * (self.state.turns + self.state.phase)
    }

    /// [`Reading::reaction`].
    pub fn reaction(&self) -> f64 {
        self.gravity(self.state.phase) - self.rotor.inertia * self.angular_acceleration()
    }

    /// At the terminals, V.
    #[inline]
    pub fn voltage(&self) -> f64 {
        self.terminal()
    }

    /// rad/s².
    pub fn angular_acceleration(&self) -> f64 {
        if self.grip == Grip::Sticks { 0.0 } else { self.turns_by(self.gravity(self.state.phase)) }
    }

    /// The same while it turns, given the torque of gravity.
    #[inline]
    fn turns_by(&self, pull: f64) -> f64 {
        let x = self.state.motion();
        let torque = self.rotor.gain * x.current - self.rotor.viscous * x.speed + self.swift.friction;
        (torque + pull) / self.rotor.inertia
    }

    /// Of the coil, A.
    #[inline]
    pub fn current(&self) -> f64 {
        self.state.current
    }

    /// rad/s.
    #[inline]
    pub fn speed(&self) -> f64 {
        self.state.speed
    }

    /// Whether friction holds it.
    pub fn is_stuck(&self) -> bool {
        self.grip == Grip::Sticks
    }

    /// What happened so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// What it is made of.
    pub fn parameters(&self) -> &Parameters {
        &self.parameters
    }

    /// What of it is computed.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }
}
