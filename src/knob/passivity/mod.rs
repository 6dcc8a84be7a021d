//! Energy that goes into the knob's virtual world, and damping for what comes out in excess.
//!
//! B. Hannaford, J.-H. Ryu: "Time-domain passivity control of haptic interfaces", IEEE Transactions on Robotics and Automation, 2002. A torque that is held
//! over a tick does exactly torque times angle of work, so the observer's sum is exact and needs no speed. Where more has come out
//! than went in, the controller adds damping that would take the difference back within a tick. It repairs what the hold creates, wholly so only if it
//! may go on braking once the knob has left a wall; a delay of two ticks and more it does not repair. Its gain must have a cap: beyond J / T
//! the knob turns back within the tick.

#[cfg(test)]
mod tests;

use crate::actuator::fault::{Fault, not_negative, positive};

/// Books energy.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Observer {
    last: Option<f64>,
    absorbed: f64,
    booked: f64,
}

impl Observer {
    /// A reading (radians) and the torque that acted on the knob since the one before (N m; with a delay that is not the last command).
    /// Returns what may still come out, joules: negative once the world has given more than it was given.
    #[inline(always)]
    pub fn observe(&mut self, angle: f64, held: f64) -> f64 {
        let work = held * (angle - self.last.unwrap_or(angle));
        if work.is_finite() {
            self.absorbed -= work;
        }
        if angle.is_finite() {
            self.last = Some(angle);
        }
        self.balance()
    }

    /// Books energy that a change of model put into the world at the angle where the knob is, joules; it may come out again.
    pub fn book(&mut self, injected: f64) {
        if injected.is_finite() {
            self.booked += injected;
        }
    }

    /// What the hand has put in so far, joules.
    pub fn absorbed(&self) -> f64 {
        self.absorbed
    }

    /// What changes of model have put in so far, joules.
    pub fn booked(&self) -> f64 {
        self.booked
    }

    /// Both together.
    pub fn balance(&self) -> f64 {
        self.absorbed + self.booked
    }

    /// Forgets all. At separation from a wall it is a choice: a balance that is kept lets one contact spend what another saved, one that is
    /// forgotten forgives what a contact created.
    pub fn reset(&mut self) {
        *self = Self { last: self.last, ..Self::default() };
    }
}

/// What a controller keeps to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cap {
    /// The device's inertia, kg m².
    pub inertia: f64,
    /// c: damping stays within c J / T, which takes a share c of the speed in a tick; 0.5 is a good one.
    pub share: f64,
    /// Below this speed there is no damping, rad/s: α = −E / (T ω²) has no meaning there.
    pub least_speed: f64,
}

/// An observer that brakes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    observer: Observer,
    period: f64,
    most: f64,
    least: f64,
    acted: u64,
}

impl Controller {
    /// At ticks of `period` seconds. An infinite share is no cap.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn new(cap: &Cap, period: f64) -> Result<Self, Fault> {
        positive("period", period)?;
        positive("inertia", cap.inertia)?;
        not_negative("least_speed", cap.least_speed)?;
        if cap.share != f64::INFINITY {
            not_negative("share", cap.share)?;
        }
        let most = cap.share * cap.inertia / period;
        Ok(Self { observer: Observer::default(), period, most, least: cap.least_speed, acted: 0 })
    }

    /// One tick: a reading, its speed (rad/s), the torque that was held since the one before and the torque wanted now (N m). Returns the
    /// torque with the damping it needs.
    #[inline(always)]
    pub fn tick(&mut self, angle: f64, speed: f64, held: f64, wanted: f64) -> f64 {
        let balance = self.observer.observe(angle, held);
        if balance < 0.0 && speed.abs() > self.least && speed.is_finite() {
            self.acted += 1;
            let alpha = f64::min(-balance / (self.period * speed * speed), self.most);
            wanted - alpha * speed
        } else {
            wanted
        }
    }

    /// The books.
    pub fn observer(&mut self) -> &mut Observer {
        &mut self.observer
    }

    /// The books, to read.
    pub fn books(&self) -> &Observer {
        &self.observer
    }

    /// In how many ticks it braked.
    pub fn acted(&self) -> u64 {
        self.acted
    }
}
