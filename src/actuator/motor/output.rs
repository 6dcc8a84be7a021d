//! What comes out of a motor.

use super::elementary::{cosine, sine};
use super::model::{Counts, Grip, Motor};
use super::parameters::{Casing, Parameters};
use super::plan::Plan;

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
        let mut reading = Reading {
            current: x.current,
            voltage: self.terminal(),
            speed: x.speed,
            angle: std::f64::consts::TAU * phase,
            turns: self.state.turns,
            angular_acceleration: alpha,
            reaction: self.gravity(phase) - self.rotor.inertia * alpha,
            ..Reading::default()
        };
        if self.plan.casing {
            let (s, c, square) = (sine(phase), cosine(phase), x.speed * x.speed);
            let lever = self.parameters.eccentric;
            reading.force = [lever * (square * s - alpha * c), lever * (-square * c - alpha * s)];
            match self.parameters.casing {
                Casing::Held => {}
                Casing::Free { mass } => reading.acceleration = reading.force.map(|f| f / mass),
                Casing::Suspended { mass, .. } => {
                    if let Some(mount) = &self.mount {
                        reading.displacement = mount.displacement();
                        reading.acceleration = mount.acceleration(reading.force.map(|f| f / mass));
                    }
                }
            }
        }
        reading
    }

    /// rad/s².
    pub fn angular_acceleration(&self) -> f64 {
        if self.grip == Grip::Sticks {
            return 0.0;
        }
        let x = self.state.motion();
        let torque = self.rotor.gain * x.current - self.rotor.viscous * x.speed + self.swift.friction;
        (torque + self.gravity(self.state.phase)) / self.rotor.inertia
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
