//! Speeds that a motor can follow, planned on what is known ahead.
//!
//! Forward, no speed rises faster than the motor can; backward, none falls faster than it can be braked. The backward pass needs what
//! comes after, as far as braking from the full speed takes. It is made every few samples for the next few, counted from the
//! beginning of time, so that what comes out does not depend on how a run is cut.
//!
//! A motor that nothing brakes is not slowed down beforehand, which would take it as long as it rolls: it does what is played until that falls,
//! and rolls then. One pass forward keeps to both, and needs to know nothing ahead.

use super::coast::{Coast, STANDS};
use super::setup::{Setup, Shaping};

/// Samples between two backward passes.
const GRID: usize = 16;

/// Share of the drive that plans keep to: the rest is for what they do not know of, inductance and gravity.
const KEPT: f64 = 0.98;

/// The most samples that are looked ahead.
const MOST: usize = 1 << 16;

/// Plans speeds, a sample at a time.
#[derive(Debug, Clone)]
pub struct Ahead {
    rates: Rates,
    keeps: Keeps,
    /// Speeds that can be reached, by their sample modulo the length.
    reached: Vec<f64>,
    /// Speeds that were wished, likewise; the one for which was planned last, and by how much that falls short.
    wished: Vec<f64>,
    short: [f64; 2],
    /// The same as are reached, left in time; the next few.
    planned: [f64; GRID + 2],
    /// The sample that comes in next.
    next: usize,
    /// By how many samples what is planned is late.
    late: usize,
    /// Samples for which all that came in was 0.
    still: usize,
}

/// What is done to speeds beside being late.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Keeps {
    /// Nothing.
    None,
    /// None is taken beyond reach, and each is left in time.
    Plans,
    /// None rises faster than the motor can, and none falls faster than it rolls out.
    Rolls,
}

/// What the motor can do to its speed in a sample.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rates {
    /// In a sample: at the full drive, for each rad/s, by friction.
    full: f64,
    drag: f64,
    friction: f64,
    /// The share of the full speed below which a motor that rolls stands, rad/s, and how it rolls.
    stands: f64,
    coast: Coast,
    step: f64,
}

impl Rates {
    pub(super) fn new(setup: &Setup) -> Self {
        let p = &setup.parameters;
        let share = 1.0 / (setup.rate * p.effective_inertia());
        Self {
            full: KEPT * setup.full_torque() * share,
            drag: setup.damping() * share,
            friction: p.coulomb * share,
            stands: STANDS * setup.full_speed(),
            coast: Coast::new(p),
            step: 1.0 / setup.rate,
        }
    }

    fn rise(&self, speed: f64) -> f64 {
        (self.full - self.drag * speed - self.friction).max(0.0)
    }

    fn fall(&self, speed: f64) -> f64 {
        self.full + self.drag * speed + self.friction
    }

    /// A speed that is wished of a motor that nothing brakes, after another, both forward.
    fn roll(&self, wished: f64, from: f64) -> f64 {
        let next = wished.min(from + self.rise(from)).max(self.coast.after(from, self.step));
        if wished == 0.0 && next < self.stands { 0.0 } else { next }
    }

    /// What is wished from rest to rest, so that no speed rises faster than the motor can, nor falls faster than it can be braked; or than it rolls, where
    /// nothing brakes it.
    pub(super) fn make_feasible(&self, speeds: &mut [f64], rolls: bool) {
        let mut from = 0.0;
        for speed in speeds.iter_mut() {
            *speed = match rolls {
                true => self.roll(*speed, from),
                false => Self::reach(*speed, from, |speed| self.rise(speed)),
            };
            from = *speed;
        }
        let mut to = 0.0;
        for speed in speeds.iter_mut().rev().filter(|_| !rolls) {
            *speed = Self::reach(*speed, to, |speed| self.fall(speed));
            to = *speed;
        }
    }

    /// A speed, or the most that can be had a sample away from another. From the one to the next the motor may pass through rest, and then
    /// it begins there.
    fn reach(speed: f64, from: f64, by: impl Fn(f64) -> f64) -> f64 {
        let from = if from * speed > 0.0 { from.abs() } else { 0.0 };
        speed.abs().min(from + by(from)).copysign(speed)
    }
}

impl Ahead {
    /// At rest, with plans at least `late` samples after what is wished.
    pub fn new(setup: &Setup, late: usize) -> Self {
        let rates = Rates::new(setup);
        let wanted = match setup.look_ahead {
            Some(seconds) => (seconds * setup.rate).round() as usize,
            None => braking(&rates, setup.full_speed()),
        };
        let keeps = match setup.shaping {
            Shaping::Inverse if setup.one_way => Keeps::Rolls,
            Shaping::Inverse => Keeps::Plans,
            _ => Keeps::None,
        };
        let late = if keeps == Keeps::Plans { late.max(wanted.min(MOST) + GRID + 2) } else { late.max(2) };
        let ring = vec![0.0; (late + 3).next_power_of_two()];
        Self {
            rates,
            keeps,
            wished: if keeps == Keeps::None { Vec::new() } else { ring.clone() },
            short: [0.0; 2],
            reached: ring,
            planned: [0.0; GRID + 2],
            next: 0,
            late,
            still: usize::MAX,
        }
    }

    /// By how many samples a plan is later than the wish.
    pub fn late(&self) -> usize {
        self.late
    }

    /// Whether all that is known is rest: nothing else is left in the ring, nor in what was planned.
    pub fn is_still(&self) -> bool {
        self.still > self.reached.len() + GRID
    }

    /// Forgets all wishes: rest is all that is known.
    pub fn forget(&mut self) {
        self.reached.fill(0.0);
        self.wished.fill(0.0);
        (self.planned, self.short, self.still) = ([0.0; GRID + 2], [0.0; 2], usize::MAX);
    }

    /// The speed that was wished where was planned last, and by how much the plan falls short of it as the motor cannot do it, rad/s; 0 where no
    /// plans are made.
    pub fn short(&self) -> [f64; 2] {
        self.short
    }

    /// Takes the speed that is wished at this sample (rad/s, a finite number), and gives those planned for the sample that is `late` before: at it,
    /// after it, and after that.
    pub fn step(&mut self, wished: f64) -> [f64; 3] {
        if wished == 0.0 && self.is_still() {
            self.next = self.next.wrapping_add(1);
            self.short = [0.0; 2];
            return [0.0; 3];
        }
        let mask = self.reached.len() - 1;
        if let Some(kept) = self.wished.get_mut(self.next & mask) {
            *kept = wished;
        }
        let before = self.reached[self.next.wrapping_sub(1) & mask];
        let wished = if self.keeps == Keeps::Rolls { self.rates.roll(wished, before) } else { wished };
        self.still = if wished == 0.0 { self.still.saturating_add(1) } else { 0 };
        let now = self.next.wrapping_sub(self.late);
        if self.keeps != Keeps::Plans {
            self.reached[self.next & mask] = wished;
            self.next = self.next.wrapping_add(1);
            let speeds = [0, 1, 2].map(|ahead| self.reached[now.wrapping_add(ahead) & mask]);
            self.note_short(now, speeds[0]);
            return speeds;
        }
        self.reached[self.next & mask] = Rates::reach(wished, before, |speed| self.rates.rise(speed));
        if now.is_multiple_of(GRID) {
            self.look_back(now, mask);
        }
        self.next = self.next.wrapping_add(1);
        let at = now % GRID;
        self.note_short(now, self.planned[at]);
        [self.planned[at], self.planned[at + 1], self.planned[at + 2]]
    }

    fn note_short(&mut self, now: usize, planned: f64) {
        let mask = self.reached.len() - 1;
        let wished = self.wished.get(now & mask).map_or(0.0, |wished| wished.abs());
        self.short = [wished, (wished - planned.abs()).max(0.0)];
    }

    /// Plans the next few samples from `now` on.
    fn look_back(&mut self, now: usize, mask: usize) {
        let mut speed = self.reached[self.next & mask];
        for back in (0..self.late).rev() {
            let here = self.reached[now.wrapping_add(back) & mask];
            speed = Rates::reach(here, speed, |speed| self.rates.fall(speed));
            if let Some(planned) = self.planned.get_mut(back) {
                *planned = speed;
            }
        }
    }
}

/// Samples in which a motor is braked from a speed.
fn braking(rates: &Rates, speed: f64) -> usize {
    let (mut reached, mut count) = (0.0, 0);
    while reached < speed && count < MOST {
        reached += rates.fall(reached);
        count += 1;
    }
    count
}
