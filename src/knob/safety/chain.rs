//! The stages, in order.

use super::budget::Budget;
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};
use crate::knob::low_pass::LowPass;
use crate::knob::order::smaller;

/// What the chain keeps to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Seconds from tick to tick.
    pub period: f64,
    /// Fastest change of torque, N m/s.
    pub slew: f64,
    /// Corner of the reconstruction low-pass, hertz, if there is one.
    pub low_pass: Option<f64>,
    /// Continuous torque, N m.
    pub continuous: f64,
    /// The winding's time constant, seconds.
    pub winding: f64,
    /// Peak torque, N m.
    pub peak: f64,
    /// Seconds over which torque rises once armed.
    pub soft_start: f64,
    /// Ticks without a new reading that pass before torque falls.
    pub stale: u32,
    /// Seconds over which it falls then; 0 for at once.
    pub release: f64,
    /// Speed that no hand turns, rad/s; 60 is common.
    pub over_speed: f64,
}

impl Limits {
    /// What its winding may spend, cold.
    ///
    /// # Errors
    /// A figure that is not above 0.
    pub fn budget(&self) -> Result<Budget, Fault> {
        // The peak is there until half of the load is reached, and falls from then on.
        let over = 2.0 * ((self.peak / self.continuous).powi(2) - 1.0);
        let release = (self.winding / f64::max(over, 1.0)).max(2.0 * self.period);
        Budget::new(self.continuous, self.winding, release, self.period)
    }
}

/// A stage, as its place in the counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// What was not a number became 0.
    NonFinite,
    /// The governor granted less than was asked.
    Governor,
    /// Torque changed as fast as it may.
    Slew,
    /// Torque was held to the budget.
    Budget,
    /// Torque was held to the peak.
    Peak,
    /// Torque was still rising after arming.
    SoftStart,
    /// No new reading, or a missed deadline: torque was falling or gone.
    Stale,
    /// The knob was too fast.
    OverSpeed,
    /// A fault kept torque at 0.
    Latch,
}

impl Stage {
    /// Its bit in [`Output::acted`].
    pub const fn bit(self) -> u16 {
        1 << self as u16
    }
}

/// What is left of a torque that has ended, N m: below it, nothing.
const SILENCE: f64 = 1e-12;

/// Stages that are counted.
pub const STAGES: usize = 9;

/// Why torque is latched at 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trip {
    /// The angle or the speed was not a number.
    Reading,
    /// Readings or deadlines failed for longer than torque takes to fall.
    Lost,
    /// The knob was too fast.
    OverSpeed,
    /// Somebody asked for it.
    Panic,
}

/// What a tick brings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Input {
    /// Sum of the effects, N m.
    pub torque: f64,
    /// Radians.
    pub angle: f64,
    /// Radians a second.
    pub velocity: f64,
    /// Whether the reading is new.
    pub fresh: bool,
    /// Whether the tick came in time.
    pub in_time: bool,
    /// Whether the governor granted less than was asked.
    pub governed: bool,
}

/// What a tick gives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Output {
    /// N m.
    pub torque: f64,
    /// A bit for each [`Stage`] that acted.
    pub acted: u16,
}

impl Output {
    /// Whether a stage acted.
    pub fn acted(&self, stage: Stage) -> bool {
        self.acted & stage.bit() != 0
    }
}

/// The chain and its state: disarmed, armed or tripped.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    limits: Limits,
    low_pass: Option<LowPass>,
    budget: Budget,
    /// The largest change a tick.
    step: f64,
    /// What the slew stage gave last.
    slewed: f64,
    armed: bool,
    /// How far torque has risen since it was armed, 0 to 1, and by how much a tick.
    risen: f64,
    rise: f64,
    /// How far it has fallen for want of readings, 1 to 0, and by how much a tick.
    held: f64,
    fall: f64,
    missing: u32,
    trip: Option<Trip>,
    counts: [u64; STAGES],
}

impl Chain {
    /// Disarmed, cold.
    ///
    /// # Errors
    /// A limit that cannot be.
    pub fn new(limits: &Limits) -> Result<Self, Fault> {
        let l = limits;
        positive("period", l.period)?;
        positive("slew", l.slew)?;
        positive("peak", l.peak)?;
        check("continuous", l.continuous, Limit::Most(l.peak))?;
        not_negative("soft_start", l.soft_start)?;
        not_negative("release", l.release)?;
        positive("over_speed", l.over_speed)?;
        check("winding", l.winding, Limit::Least(100.0 * l.period))?;
        let low_pass = l.low_pass.map(|hertz| LowPass::new(hertz, l.period)).transpose()?;
        let per_tick = |time: f64| if time > l.period { l.period / time } else { 1.0 };
        positive("continuous", l.continuous)?;
        let budget = l.budget()?;
        Ok(Self {
            limits: *l,
            low_pass,
            budget,
            step: l.slew * l.period,
            slewed: 0.0,
            armed: false,
            risen: 0.0,
            rise: per_tick(l.soft_start),
            held: 1.0,
            fall: per_tick(l.release),
            missing: 0,
            trip: None,
            counts: [0; STAGES],
        })
    }

    /// Goes on behind another chain: as warm, with what it latched, and counting on.
    pub fn continue_from(&mut self, before: &Self) {
        self.budget.continue_from(&before.budget);
        self.counts = before.counts;
        if let Some(trip) = before.trip {
            self.latch(trip);
        }
    }

    /// Lets torque rise from 0. `false` while a fault is latched.
    pub fn arm(&mut self) -> bool {
        if self.trip.is_none() && !self.armed {
            self.rest();
            self.armed = true;
        }
        self.armed
    }

    /// Torque is 0 from the next tick on.
    pub fn disarm(&mut self) {
        self.armed = false;
        self.rest();
    }

    /// Latches torque at 0.
    pub fn panic(&mut self) {
        self.latch(Trip::Panic);
    }

    /// Forgets a latched fault. The chain stays disarmed.
    pub fn acknowledge(&mut self) {
        self.trip = None;
    }

    /// Whether torque may flow.
    pub fn armed(&self) -> bool {
        self.armed
    }

    /// The fault that is latched.
    pub fn trip(&self) -> Option<Trip> {
        self.trip
    }

    /// In how many ticks a stage acted.
    pub fn count(&self, stage: Stage) -> u64 {
        self.counts[stage as usize]
    }

    /// In how many ticks each stage acted, in their order.
    pub fn counts(&self) -> &[u64; STAGES] {
        &self.counts
    }

    /// What of a torque passes beside the limits on its size and its change, 0 to 1. With a low-pass nothing does at once.
    pub fn passes(&self) -> f64 {
        if self.armed && self.low_pass.is_none() { self.risen * self.held } else { 0.0 }
    }

    /// The largest torque now, N m.
    pub fn most(&self) -> f64 {
        f64::min(self.budget.allowed(), self.limits.peak)
    }

    /// The winding's load, 0 to 1.
    pub fn load(&self) -> f64 {
        self.budget.load()
    }

    fn rest(&mut self) {
        (self.slewed, self.risen, self.held, self.missing) = (0.0, 0.0, 1.0, 0);
        if let Some(low_pass) = &mut self.low_pass {
            low_pass.reset(0.0);
        }
    }

    #[cold]
    fn latch(&mut self, trip: Trip) {
        // The first fault is the one to know.
        self.trip = self.trip.or(Some(trip));
        self.armed = false;
        self.rest();
    }

    /// One tick: what the amplifier gets. Call it even if there is nothing to read, with `fresh` false.
    #[inline(always)]
    pub fn tick(&mut self, input: &Input) -> Output {
        let mut acted = if input.governed { Stage::Governor.bit() } else { 0 };
        let mut asked = input.torque;
        if !asked.is_finite() {
            acted |= Stage::NonFinite.bit();
            asked = 0.0;
        }
        let mut torque = 0.0;
        // What is not a number is not within the speed either.
        if !(input.angle.is_finite() && input.velocity.abs() <= self.limits.over_speed) {
            acted |= self.refuse(input.angle, input.velocity);
        } else if self.armed {
            let change = asked - self.slewed;
            if change.abs() <= self.step {
                // Landed on exactly, so that rounding leaves nothing behind.
                self.slewed = asked;
            } else {
                acted |= self.slew(change);
            }
            torque = self.slewed;
            if let Some(low_pass) = &mut self.low_pass {
                torque = low_pass.step(torque);
                if self.slewed == 0.0 && low_pass.faded(SILENCE) {
                    low_pass.reset(0.0);
                    torque = 0.0;
                }
            }
            // The root is taken only where the budget acts.
            if !self.budget.allows(torque) {
                acted |= Stage::Budget.bit();
                torque = cut(self.budget.allowed(), torque);
            }
            if torque.abs() > self.limits.peak {
                acted |= Stage::Peak.bit();
                torque = cut(self.limits.peak, torque);
            }
            let whole = self.risen == 1.0 && self.held == 1.0 && self.missing == 0;
            if !(whole && input.fresh && input.in_time) {
                let stage;
                (torque, stage) = self.share(torque, input.fresh, input.in_time);
                acted |= stage;
            }
        }
        if self.trip.is_some() {
            acted |= Stage::Latch.bit();
        }
        self.budget.spend(torque);
        let mut left = acted;
        while left != 0 {
            self.counts[left.trailing_zeros() as usize] += 1;
            left &= left - 1;
        }
        Output { torque, acted }
    }

    /// Goes as far towards a torque as it may in a tick. Returns the stage.
    #[cold]
    fn slew(&mut self, change: f64) -> u16 {
        self.slewed += self.step.copysign(change);
        Stage::Slew.bit()
    }

    /// Latches for a reading that cannot be. Returns the stage.
    #[cold]
    fn refuse(&mut self, angle: f64, velocity: f64) -> u16 {
        if angle.is_finite() && velocity.is_finite() {
            self.latch(Trip::OverSpeed);
            Stage::OverSpeed.bit()
        } else {
            self.latch(Trip::Reading);
            Stage::NonFinite.bit()
        }
    }

    /// What is left of a torque while it rises, or for want of readings; and the stages that took the rest.
    #[inline(never)]
    fn share(&mut self, torque: f64, fresh: bool, in_time: bool) -> (f64, u16) {
        self.risen = smaller(self.risen + self.rise, 1.0);
        let mut acted = if self.risen < 1.0 { Stage::SoftStart.bit() } else { 0 };
        self.missing = if fresh && in_time { 0 } else { self.missing.saturating_add(1) };
        // A missed deadline counts at once; a reading may be late by a few ticks.
        let falls = !in_time || self.missing > self.limits.stale;
        self.held = if falls { self.held - self.fall } else { smaller(self.held + self.rise, 1.0) };
        if self.held < 1.0 {
            acted |= Stage::Stale.bit();
        }
        if self.held > 0.0 {
            (torque * (self.risen * self.held), acted)
        } else {
            self.latch(Trip::Lost);
            (0.0, acted)
        }
    }
}

/// The largest torque of its sign. Out of the way, so that a tick within all limits waits for no choice between the two.
#[cold]
fn cut(most: f64, torque: f64) -> f64 {
    most.copysign(torque)
}
