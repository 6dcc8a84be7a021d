//! What the thread of a knob's line makes of the servo's newest profile: the torque of each angle as it is read.
//!
//! Nothing here has a clock or a thread. What stands between a profile and the motor: an angle or a torque that is no number, a speed that no
//! hand turns, and a torque that is too old are none; beyond a profile's range torque stays what it is at its end, and that is counted; no
//! torque changes faster than the knob's own slew allows. Size was limited where the profile was made, by what the servo knows: what was
//! really given between its blocks is booked here, heat and energy, and no torque is more than the winding's budget has left of that.

#![deny(clippy::disallowed_methods)]

#[cfg(test)]
mod tests;

use std::f64::consts::TAU;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::knob::local_model::profile::Profile;
use crate::knob::passivity::Observer;
use crate::knob::safety::budget::Budget;

/// What the line's thread keeps to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Fastest change of torque, N m/s.
    pub slew: f64,
    /// Speed at which there is no torque, rad/s.
    pub over_speed: f64,
    /// Whether the angle falls on the line where the servo's rises.
    pub inverted: bool,
    /// What the winding may spend, as it is at the beginning.
    pub budget: Budget,
}

/// A profile on its way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Told {
    /// How many were sent with this one; 0: none yet.
    pub number: u64,
    /// When the angle was read of which it was made, nanoseconds; 0: it was made of none.
    pub stamp: u64,
    /// That angle, as the line says it, radians.
    pub heard: f64,
    /// The profile, by angles of the servo, which are whole turns off.
    pub profile: Profile,
}

impl Told {
    /// Nothing yet.
    pub const NOTHING: Self = Self { number: 0, stamp: 0, heard: 0.0, profile: Profile::flat(0.0) };

    /// Numbers that hold all of it.
    pub(super) const WORDS: usize = 3 + Profile::NUMBERS;

    pub(super) fn words(&self) -> [u64; Self::WORDS] {
        let mut words = [0; Self::WORDS];
        words[..3].copy_from_slice(&[self.number, self.stamp, self.heard.to_bits()]);
        let numbers = self.profile.numbers();
        words[3..].iter_mut().zip(numbers).for_each(|(word, number)| *word = number.to_bits());
        words
    }

    pub(super) fn of_words(words: &[u64; Self::WORDS]) -> Self {
        let mut numbers = [0.0; Profile::NUMBERS];
        numbers.iter_mut().zip(&words[3..]).for_each(|(number, word)| *number = f64::from_bits(*word));
        let profile = Profile::of_numbers(&numbers);
        Self { number: words[0], stamp: words[1], heard: f64::from_bits(words[2]), profile }
    }
}

/// What became of profiles. Whoever keeps it may read it at any time.
#[derive(Debug, Default)]
pub struct Counts {
    taken: AtomicU64,
    replaced: AtomicU64,
    beyond: AtomicU64,
    too_fast: AtomicU64,
    slewed: AtomicU64,
    cut: AtomicU64,
    booked: AtomicU64,
    absorbed: AtomicU64,
    load: AtomicU64,
}

/// The same at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Count {
    /// Profiles that torque was made of.
    pub taken: u64,
    /// Profiles that a newer one had replaced before they were looked at: these and those taken are all that were sent, but for one that waits.
    pub replaced: u64,
    /// Torques of angles beyond their profile's range.
    pub beyond: u64,
    /// Torques that were 0 for the knob's speed.
    pub too_fast: u64,
    /// Torques that changed as fast as they may.
    pub slewed: u64,
    /// Torques that were held to what the winding's budget had left.
    pub cut: u64,
    /// Energy that changes of profiles put in, joules.
    pub booked: f64,
    /// Energy that went from the hand into what is felt, by the torques that were given and the angles that were read, joules.
    pub absorbed: f64,
    /// The winding's load by the torques that were given: 0 cold, 1 where the continuous torque ends.
    pub load: f64,
}

impl Counts {
    /// As they are now.
    pub fn now(&self) -> Count {
        let of = |count: &AtomicU64| count.load(Ordering::Relaxed);
        Count {
            taken: of(&self.taken),
            replaced: of(&self.replaced),
            beyond: of(&self.beyond),
            too_fast: of(&self.too_fast),
            slewed: of(&self.slewed),
            cut: of(&self.cut),
            booked: f64::from_bits(of(&self.booked)),
            absorbed: f64::from_bits(of(&self.absorbed)),
            load: f64::from_bits(of(&self.load)),
        }
    }
}

fn count(count: &AtomicU64, more: u64) {
    count.fetch_add(more, Ordering::Relaxed);
}

/// The end of profiles.
#[derive(Debug)]
pub struct Local {
    bounds: Bounds,
    told: Told,
    /// What is added to angles of the line: whole turns.
    turns: f64,
    /// What acts, and since when it is a new one, whose way the servo has seen to.
    acts: Profile,
    granted: f64,
    /// What was given last, and when, nanoseconds.
    given: f64,
    last: Option<u64>,
    /// What that heated, and what work it did.
    budget: Budget,
    observer: Observer,
}

impl Local {
    /// Nothing is there yet.
    pub fn new(bounds: Bounds) -> Self {
        let acts = Profile::flat(0.0);
        Self {
            bounds,
            told: Told::NOTHING,
            turns: 0.0,
            acts,
            granted: 0.0,
            given: 0.0,
            last: None,
            budget: bounds.budget,
            observer: Observer::default(),
        }
    }

    /// The newest that was told.
    pub fn told(&self) -> &Told {
        &self.told
    }

    /// Takes the newest, which may be the one before.
    pub fn take(&mut self, told: &Told, counts: &Counts) {
        let Some(since) = told.number.checked_sub(self.told.number).filter(|since| *since > 0) else {
            return;
        };
        count(&counts.taken, 1);
        count(&counts.replaced, since - 1);
        // Between two profiles the servo has kept to the slew.
        self.granted += (told.profile.time - self.told.profile.time).abs();
        self.told = *told;
        let away = told.profile.centre - self.turned(told.heard);
        self.turns = if away.is_finite() { (away / TAU).round() * TAU } else { 0.0 };
    }

    fn turned(&self, angle: f64) -> f64 {
        if self.bounds.inverted { -angle } else { angle }
    }

    /// The torque of an angle (radians) and a speed (rad/s) as the line says them, in the servo's direction, N m.
    pub fn torque(&mut self, now: u64, angle: f64, speed: f64, counts: &Counts) -> f64 {
        self.book(now, angle, counts);
        let place = self.turned(angle) + self.turns;
        let fast = speed.is_nan() || speed.abs() > self.bounds.over_speed;
        let (torque, beyond) = self.told.profile.at(place);
        if fast || !place.is_finite() || !torque.is_finite() {
            count(&counts.too_fast, u64::from(fast));
            return self.none(now, angle, counts);
        }
        count(&counts.beyond, u64::from(beyond));
        self.change(self.told.profile, place, counts);
        let passed = self.last.replace(now).map_or(0.0, |last| now.saturating_sub(last) as f64 * 1e-9);
        let most = self.bounds.slew * (passed + std::mem::take(&mut self.granted));
        let change = torque - self.given;
        // What does not depend on the angle has been within the slew where it was made.
        self.given = if self.acts.is_flat() || change.abs() <= most {
            torque
        } else {
            count(&counts.slewed, 1);
            self.given + most.copysign(change)
        };
        if !self.budget.allows(self.given) {
            count(&counts.cut, 1);
            self.given = self.budget.allowed().copysign(self.given);
        }
        self.given
    }

    /// No torque, at an angle as the line says it.
    pub fn nothing(&mut self, now: u64, angle: f64, counts: &Counts) -> f64 {
        self.book(now, angle, counts);
        self.none(now, angle, counts)
    }

    fn none(&mut self, now: u64, angle: f64, counts: &Counts) -> f64 {
        let place = self.turned(angle) + self.turns;
        self.change(Profile::flat(0.0), place, counts);
        (self.given, self.last) = (0.0, Some(now));
        0.0
    }

    /// Books what the torque before has done until now, at an angle as the line says it.
    fn book(&mut self, now: u64, angle: f64, counts: &Counts) {
        let passed = self.last.map_or(0.0, |last| now.saturating_sub(last) as f64 * 1e-9);
        self.budget.spend_over(self.given, passed);
        self.observer.observe(self.turned(angle), self.given);
        counts.load.store(self.budget.load().to_bits(), Ordering::Relaxed);
        counts.absorbed.store(self.observer.absorbed().to_bits(), Ordering::Relaxed);
    }

    /// Books what a change at an angle puts in.
    fn change(&mut self, next: Profile, place: f64, counts: &Counts) {
        if next == self.acts {
            return;
        }
        let more = next.energy(place) - self.acts.energy(place);
        if more.is_finite() {
            let sum = f64::from_bits(counts.booked.load(Ordering::Relaxed)) + more;
            counts.booked.store(sum.to_bits(), Ordering::Relaxed);
        }
        self.acts = next;
    }
}
