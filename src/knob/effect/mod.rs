//! What a knob feels like: effects that add up.
//!
//! One file an effect: its figures with units, what it refuses, its torque, how stiff and how viscous it is at most (which the
//! governor must know), its potential energy where it has one. All take a [`Reading`] and a [`Modulation`], and report what happened
//! to [`events`]. [`program`] runs those that were named, and no others.
//!
//! | effect | torque |
//! |---|---|
//! | [`spring`], [`damper`] | −K (θ − θ₀), −B ω |
//! | [`wall`] | a wall or two end stops, which push and never pull |
//! | [`detent`] | −A times a shape, so many times a turn |
//! | [`snap`] | a spring to the nearest of equal places, which changes over with hysteresis |
//! | [`magnet`] | an attractor with a reach |
//! | [`friction`] | of displacement alone: no speed, no drift |
//! | [`inertia`] | a flywheel behind a spring |
//! | [`constant`], [`spin`] | a torque; a pull to a speed |
//! | [`texture`] | a ripple over the angle, or a signal from elsewhere |
//! | [`table`] | torque over angle, point by point |
//! | [`hertz`] | a round body's contact, p^{3/2} |
//! | [`transient`] | a burst at contact, as strong as it was fast |
//!
//! No effect allocates, panics or loops without a bound; none calls the platform's `sin` or `exp`.

pub mod constant;
pub mod damper;
pub mod detent;
pub mod events;
pub mod friction;
pub mod hertz;
pub mod inertia;
pub mod magnet;
pub mod program;
pub mod snap;
pub mod spin;
pub mod spring;
pub mod table;
pub mod texture;
pub mod transient;
pub mod wall;
mod wave;

use crate::actuator::fault::Fault;
use events::Events;

/// What the servo knows at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Radians.
    pub angle: f64,
    /// Radians a second, as estimated.
    pub velocity: f64,
    /// Seconds since the reading before.
    pub dt: f64,
}

/// What scales an effect at a tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Modulation {
    /// Factor of all of the effect's torque.
    pub gain: f64,
    /// A signal from elsewhere, for those that take one.
    pub fed: f64,
    /// What the governor leaves of stiffness, 0 to 1.
    pub stiffness: f64,
    /// What the governor leaves of damping, 0 to 1.
    pub damping: f64,
}

impl Modulation {
    /// As the figures say.
    pub const PLAIN: Self = Self { gain: 1.0, fed: 0.0, stiffness: 1.0, damping: 1.0 };
}

/// How stiff and how viscous an effect is anywhere, at a gain of 1.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Bound {
    /// N m/rad.
    pub stiffness: f64,
    /// N m s/rad.
    pub damping: f64,
}

/// An effect.
pub trait Effect {
    /// What it remembers from tick to tick; the default has not been read yet.
    type State: Copy + Default;

    /// Refuses what cannot be.
    ///
    /// # Errors
    /// The first figure that breaks its limit.
    fn check(&self) -> Result<(), Fault>;

    /// How stiff and how viscous it is at most.
    fn bound(&self) -> Bound;

    /// Its torque on the knob, N m.
    fn torque(&self, state: &mut Self::State, r: &Reading, m: &Modulation, events: &mut Events) -> f64;

    /// Potential energy at an angle (joules) where it depends on nothing else.
    fn energy(&self, _angle: f64) -> Option<f64> {
        None
    }
}

/// Added and taken away, it rounds to a whole number: 1.5 × 2^52.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// To the nearest whole number, for up to ±2^50; beyond, the number itself.
#[inline(always)]
fn nearest(x: f64) -> f64 {
    if x.abs() < 1.1e15 { (x + ROUNDING) - ROUNDING } else { x }
}

#[cfg(test)]
mod tests;
