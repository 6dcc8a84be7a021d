//! Large motion: a coil that leaves its magnet, a suspension that stiffens.
//!
//! Bl(y) = Bl (1 − y² / y_B²) and k(y) = k (1 + y² / y_k²), as parabolas are fitted to measured drivers (Klippel, 2006). What differs
//! from the linear plant acts while y stands still, half of it before each linear step and half behind (Strang, 1968). With y frozen it is solved
//! by itself: between coil and motion it only exchanges energy. So the error is of second order, the linear part stays exact, contacts
//! with it, and where nothing is large nothing is changed. Steps are cut so that neither part turns by more than half a radian in one,
//! for all displacements: beyond `reach`, the coil holds what it has there and the spring goes on straight.

use super::bounds::Bounds;
use super::model::{Model, State};
use super::parameters::Spring;
use super::plant::{Kind, Plant, Touch};
use super::readout::Outputs;
use crate::actuator::drive::Drive;
use crate::actuator::elementary::exp_m1;
use crate::actuator::fault::{Fault, Limit, positive};

/// How an actuator departs from the linear one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shape {
    /// Metres at which the parabola of the force factor would reach 0; `None`: it does not fall.
    pub force_falls: Option<f64>,
    /// Metres at which the suspension is twice as stiff; `None`: it stays as it is.
    pub stiffens: Option<f64>,
    /// Metres up to which this is known; no more than `force_falls`.
    pub reach: f64,
}

/// Cuts of a step, at most; and radians that a cut may turn by.
const MOST_CUTS: f64 = 64.0;
const TURN: f64 = 0.5;

/// A coil actuator in large motion.
#[derive(Debug, Clone)]
pub struct Large {
    model: Model,
    /// What a newton on y does at once: to its acceleration, to that of the other coordinate.
    push: [f64; 2],
    /// And to force on the load and casing acceleration.
    felt: [f64; 2],
    reach: f64,
    /// 1 / y_B² and k / y_k².
    falls: f64,
    cubic: f64,
    cuts: u32,
    last: f64,
}

impl Large {
    /// At rest, `rate` samples a second.
    ///
    /// # Errors
    /// A rate, bound or shape that cannot be; a rate so low that a step would have to be cut into more than 64.
    pub fn new(
        plant: &Plant,
        rate: f64,
        drive: Drive,
        bounds: &Bounds,
        shape: &Shape,
    ) -> Result<Self, Fault> {
        positive("rate", rate)?;
        positive("reach", shape.reach)?;
        let falls = inverse_square("force_falls", shape.force_falls)?;
        let cubic = plant.suspension().stiffness * inverse_square("stiffens", shape.stiffens)?;
        if let Some(most) = shape.force_falls.filter(|most| shape.reach > *most) {
            return Err(Fault::because(
                "reach",
                shape.reach,
                Limit::Most(most),
                "the force factor is 0 there",
            ));
        }
        let reach = shape.reach;
        let lost = plant.coil.force_factor * falls * reach * reach;
        let Pace { linear, cubic: stiff, coil } = Pace::of(plant, drive, cubic * reach * reach, lost);
        let pace = if falls == 0.0 && cubic == 0.0 { 0.0 } else { linear.max(stiff).max(coil) };
        let cuts = (pace / (rate * TURN)).ceil().max(1.0);
        if cuts > MOST_CUTS {
            let least = pace / (MOST_CUTS * TURN);
            return Err(Fault::because(
                "rate",
                rate,
                Limit::Least(least),
                "a step would take more than 64 parts",
            ));
        }
        let model = Model::bounded(plant, rate * cuts, drive, bounds)?;
        let (push, felt) = plant.at_once();
        Ok(Self { model, push, felt, reach, falls, cubic, cuts: cuts as u32, last: 0.0 })
    }

    /// Holds a drive (volts or amperes) for a sample. One that is not a number, or beyond 1e9, counts as 0.
    pub fn step(&mut self, drive: f64) -> Outputs {
        let held = if drive.abs() < 1e9 { drive } else { 0.0 };
        let half = 0.5 * self.model.period();
        for part in 0..self.cuts {
            self.kick(held, half);
            // Counted as masked once.
            self.model.advance(if part == 0 { drive } else { held });
            self.kick(held, half);
        }
        self.last = held;
        self.outputs()
    }

    /// What it does at the end of the last sample.
    pub fn outputs(&self) -> Outputs {
        let mut o = self.model.outputs();
        let coil = self.model.plant().coil();
        let factor = self.force_factor(o.displacement);
        let linear = o.current;
        if self.model.drive() == Drive::Voltage && coil.inductance == 0.0 {
            o.current = (self.last - factor * o.velocity) / coil.resistance;
        }
        if self.model.drive() == Drive::Current {
            o.voltage = coil.resistance * o.current + factor * o.velocity;
        }
        let more = factor * o.current - coil.force_factor * linear + self.spring(o.displacement);
        o.acceleration += self.push[0] * more;
        o.force += self.felt[0] * more;
        o.casing += self.felt[1] * more;
        o
    }

    /// Newtons an ampere at a displacement.
    pub fn force_factor(&self, y: f64) -> f64 {
        let y = y.abs().min(self.reach);
        self.model.plant().coil().force_factor * (1.0 - self.falls * y * y)
    }

    /// What the suspension pulls with beyond its linear part, newtons.
    fn spring(&self, y: f64) -> f64 {
        let (within, beyond) = (y.abs().min(self.reach), (y.abs() - self.reach).max(0.0));
        -self.cubic.copysign(y) * within * within * (within + 3.0 * beyond)
    }

    /// Energy in masses, springs, bounds and coil, joules.
    pub fn energy(&self) -> f64 {
        let y = self.model.state().displacement.abs();
        let (r, beyond) = (y.min(self.reach), (y - self.reach).max(0.0));
        self.model.energy() + self.cubic * r * r * (0.25 * r * r + beyond * (r + 1.5 * beyond))
    }

    /// The linear model inside, its state and its counts.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Puts everything elsewhere.
    pub fn set_state(&mut self, state: &State) {
        self.model.set_state(state);
    }

    /// What differs from the linear plant, for a time, y standing still.
    fn kick(&mut self, drive: f64, time: f64) {
        let mut state = self.model.state();
        let coil = self.model.plant().coil();
        let (y, v) = (state.displacement, state.velocity);
        let factor = self.force_factor(y);
        let (lost, spring) = (factor - coil.force_factor, self.spring(y));
        if lost == 0.0 && spring == 0.0 {
            return;
        }
        let push = self.push[0];
        let after = match self.model.drive() {
            Drive::Current => v + time * push * (lost * drive + spring),
            Drive::Voltage if coil.inductance > 0.0 => {
                // m dv/dt = ΔB i + f and L di/dt = −ΔB v by the midpoint rule, which keeps what both hold together.
                let (a, b) = (0.5 * time * push * lost, 0.5 * time * lost / coil.inductance);
                let middle = (v + a * state.current + 0.5 * time * push * spring) / (1.0 + a * b);
                state.current -= 2.0 * b * middle;
                2.0 * middle - v
            }
            Drive::Voltage => {
                // The current follows at once: less force, and less braking than the linear part has taken.
                let slack =
                    (coil.force_factor - factor) * (coil.force_factor + factor) * push / coil.resistance;
                let force = push * (lost * drive / coil.resistance + spring);
                let z = slack * time;
                v + (force + slack * v) * time * if z == 0.0 { 1.0 } else { exp_m1(z) / z }
            }
        };
        state.other_velocity += (after - v) * self.push[1] / push;
        state.velocity = after;
        self.model.set_state(&state);
    }
}

/// How fast each part goes, radians a second.
struct Pace {
    linear: f64,
    cubic: f64,
    coil: f64,
}

impl Pace {
    fn of(plant: &Plant, drive: Drive, stiffness: f64, lost: f64) -> Self {
        let linear = plant.pace(drive, &Touch::default());
        let stiff = Touch { spring: Spring { stiffness: 3.0 * stiffness, damping: 0.0 }, force: 0.0 };
        let (coil, full) = (plant.coil(), plant.coil().force_factor);
        let coil = match drive {
            Drive::Current => 0.0,
            Drive::Voltage if coil.inductance > 0.0 => (full * lost * plant.push() / coil.inductance).sqrt(),
            Drive::Voltage => 2.0 * full * lost * plant.push() / coil.resistance,
        };
        Self { linear, cubic: plant.pace(drive, &stiff), coil }
    }
}

impl Plant {
    /// What a newton on y does at once: acceleration of both coordinates; force on the load, and acceleration of the casing.
    fn at_once(&self) -> ([f64; 2], [f64; 2]) {
        let push = self.push();
        match &self.kind {
            Kind::Tactor(v) => ([push, 0.0], [push * (1.0 / push - v.mass).max(0.0), 0.0]),
            Kind::Inertial(m) => {
                let casing = -1.0 / (m.casing_mass + m.hand.mass);
                ([push, casing], [casing * m.hand.mass, casing])
            }
        }
    }

    /// What holds the contactor in its housing, or the slug in its casing.
    fn suspension(&self) -> Spring {
        match &self.kind {
            Kind::Tactor(v) => v.suspension,
            Kind::Inertial(m) => m.suspension,
        }
    }
}

fn inverse_square(field: &'static str, distance: Option<f64>) -> Result<f64, Fault> {
    distance.map_or(Ok(0.0), |distance| positive(field, distance).map(|()| 1.0 / (distance * distance)))
}

#[cfg(test)]
mod tests;
