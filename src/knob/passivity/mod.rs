//! Energy that goes into the knob's virtual world, and damping for what comes out in excess.
//!
//! B. Hannaford, J.-H. Ryu: "Time-domain passivity control of haptic interfaces", IEEE Transactions on Robotics and Automation, 2002. A torque that is held
//! over a tick does exactly torque times angle of work, so the observer's sum is exact and needs no speed. Where more has come out
//! than went in, the controller adds damping that would take the difference back within a tick. It repairs what the hold creates, wholly so only if it
//! may go on braking once the knob has left a wall. Its gain must have a cap: beyond J / T the knob turns back within the tick.
//!
//! Torque that acts ticks after it was given must be reckoned with, or the same excess is braked once for every tick of the delay, and the knob
//! sticks or is driven back. What was asked for and is not yet seen in the sum therefore counts as taken back. Delays of one tick are made good so; of more, in part.
//!
//! Energy that is left of 1 after a bounce off a sampled wall (6e-6 kg m², 1 kHz, no damping), for a cap of half of J / T: without delay, braking until the
//! tick after the wall is left, 1.009 at 0.4 N m/rad and 1.064 at 4, as was published. With one tick of delay 1.018, 1.23 and 1.73 were published at
//! 0.4, 2 and 4 N m/rad; those are of a controller that does not reckon so, and are not reproduced here: left to brake until the books are even, this one leaves
//! less, 1.000, 1.000 and 1.10.

#[cfg(test)]
mod tests;

use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};

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

/// The longest delay that is reckoned with, ticks.
const MOST_LATE: f64 = (1 << 20) as f64;

/// An observer that brakes.
#[derive(Debug, Clone, PartialEq)]
pub struct Controller {
    observer: Observer,
    period: f64,
    most: f64,
    least: f64,
    acted: u64,
    /// Joules that will be taken back by what was asked for and has not acted yet, a place a tick of the delay.
    way: Box<[f64]>,
    place: usize,
    /// Their sum, and how many of them are not 0.
    under_way: f64,
    braking: usize,
}

impl Controller {
    /// At ticks of `period` seconds, of torque that acts `late` ticks after it was given. An infinite share is no cap.
    ///
    /// # Errors
    /// A figure that cannot be; more than 2²⁰ ticks.
    pub fn new(cap: &Cap, period: f64, late: usize) -> Result<Self, Fault> {
        check("late", late as f64, Limit::Most(MOST_LATE))?;
        positive("period", period)?;
        positive("inertia", cap.inertia)?;
        not_negative("least_speed", cap.least_speed)?;
        if cap.share != f64::INFINITY {
            not_negative("share", cap.share)?;
        }
        let most = cap.share * cap.inertia / period;
        Ok(Self {
            observer: Observer::default(),
            period,
            most,
            least: cap.least_speed,
            acted: 0,
            way: vec![0.0; late].into_boxed_slice(),
            place: 0,
            under_way: 0.0,
            braking: 0,
        })
    }

    /// One tick: a reading, its speed (rad/s), the torque that was held since the one before and the torque wanted now (N m). Returns the
    /// torque with the damping it needs.
    #[inline(always)]
    pub fn tick(&mut self, angle: f64, speed: f64, held: f64, wanted: f64) -> f64 {
        let balance = self.observer.observe(angle, held) + self.under_way;
        let brakes = balance < 0.0 && speed.abs() > self.least && speed.is_finite();
        let alpha = if brakes { f64::min(-balance / (self.period * speed * speed), self.most) } else { 0.0 };
        if !self.way.is_empty() {
            self.send(if brakes { alpha * speed * speed * self.period } else { 0.0 });
        }
        if !brakes {
            return wanted;
        }
        self.acted += 1;
        wanted - alpha * speed
    }

    /// What is asked for now is under way; what was asked for a delay ago acts from here on, and is seen with the next reading.
    #[inline(always)]
    fn send(&mut self, energy: f64) {
        let Some(place) = self.way.get_mut(self.place) else { return };
        let acts = std::mem::replace(place, energy);
        self.place = if self.place + 1 == self.way.len() { 0 } else { self.place + 1 };
        self.braking = self.braking + usize::from(energy != 0.0) - usize::from(acts != 0.0);
        // What rounding left of a sum of nothing is nothing.
        self.under_way = if self.braking == 0 { 0.0 } else { self.under_way + energy - acts };
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
