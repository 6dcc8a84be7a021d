//! The servo's side: the newest model, with torque that never jumps.
//!
//! When a model comes, what its torque differs by from the last one's at that angle is carried along and taken away in equal steps. So the
//! force is continuous however often models come, and its slope is bounded; the stiffness is the new one's at once. Potential
//! energy of model and remainder is known at every tick, so what a change injects is known too: of a spring stiffened in place
//! ½ ΔK p² once the remainder is gone.

use super::model::LocalModel;
use crate::actuator::fault::{Fault, Limit, check};

/// Follows models.
#[derive(Debug, Clone, PartialEq)]
pub struct Follower {
    model: LocalModel,
    /// Torque carried along, what is taken from it a tick, and the angle at which it does no work.
    rest: f64,
    step: f64,
    pivot: f64,
    left: u32,
    over: u32,
    /// Ticks after which a model is too old.
    longest: u64,
    /// Nothing is there, and nothing is carried along.
    idle: bool,
    refused: u64,
    outside: u64,
    expired: u64,
}

/// What a tick gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Followed {
    /// N m.
    pub torque: f64,
    /// Energy that a change of model put in during this tick, joules: for the observer's books.
    pub injected: f64,
}

impl Followed {
    /// Where nothing is.
    pub const NOTHING: Self = Self { torque: 0.0, injected: 0.0 };
}

impl Follower {
    /// Takes a difference away over `over` ticks (one of the slow thread's periods or more); lets go of a model that is older than `longest`
    /// ticks in the same way.
    ///
    /// # Errors
    /// `over` is 0.
    pub fn new(over: u32, longest: u64) -> Result<Self, Fault> {
        check("over", f64::from(over), Limit::Least(1.0))?;
        let model = LocalModel::FREE;
        let (rest, step, pivot, left) = (0.0, 0.0, 0.0, 0);
        let idle = true;
        Ok(Self { model, rest, step, pivot, left, over, longest, idle, refused: 0, outside: 0, expired: 0 })
    }

    /// One tick at an angle (radians): with a new model, or without one. A model that cannot be is refused and counted.
    #[inline]
    pub fn tick(&mut self, now: u64, angle: f64, new: Option<&LocalModel>) -> Followed {
        if !angle.is_finite() {
            return Followed::NOTHING;
        }
        let mut injected = 0.0;
        if self.left > 0 {
            let before = self.rest;
            self.left -= 1;
            self.rest = self.step * f64::from(self.left);
            injected = (before - self.rest) * (angle - self.pivot);
            self.idle = self.left == 0 && self.model == LocalModel::FREE;
        }
        match new {
            Some(model) if model.check().is_ok() => injected += self.change(model, angle),
            Some(_) => self.refused += 1,
            None if now.saturating_sub(self.model.stamp) > self.longest && self.model != LocalModel::FREE => {
                self.expired += 1;
                injected += self.change(&LocalModel::FREE, angle);
            }
            None => {}
        }
        self.outside += u64::from(self.model.within(angle).1);
        Followed { torque: self.model.torque(angle) + self.rest, injected }
    }

    fn change(&mut self, model: &LocalModel, angle: f64) -> f64 {
        let before = self.model.energy(angle) - self.rest * (angle - self.pivot);
        let rest = self.model.torque(angle) + self.rest - model.torque(angle);
        (self.model, self.idle) = (*model, false);
        (self.rest, self.step, self.pivot, self.left) = (rest, rest / f64::from(self.over), angle, self.over);
        model.energy(angle) - before
    }

    /// Whether nothing is there and nothing is left of what was: every tick without a new model gives [`Followed::NOTHING`].
    #[inline(always)]
    pub fn is_idle(&self) -> bool {
        self.idle
    }

    /// The model that is followed.
    pub fn model(&self) -> &LocalModel {
        &self.model
    }

    /// Models that could not be, ever.
    pub fn refused(&self) -> u64 {
        self.refused
    }

    /// Ticks outside a model's range, ever.
    pub fn outside(&self) -> u64 {
        self.outside
    }

    /// Models let go because they were too old, ever.
    pub fn expired(&self) -> u64 {
        self.expired
    }
}
