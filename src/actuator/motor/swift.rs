//! A step in which nothing switches: numbers times numbers.

use super::flow::{Motion, Push};
use super::model::NOTHING;
use super::table::{Row, Table, all};
use crate::actuator::elementary::{cosine, sine, wrapped};

/// How gravity enters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Method {
    /// Not at all.
    None = 0,
    /// As it is in the middle of the step.
    Midpoint = 1,
    /// By a parabola through beginning, middle and end.
    Parabola = 2,
}

pub(super) const NONE: u8 = Method::None as u8;
pub(super) const MIDPOINT: u8 = Method::Midpoint as u8;
pub(super) const PARABOLA: u8 = Method::Parabola as u8;

/// Where a motor is. The order keeps apart what a step changes, and would else load together what was stored one by one, which waits for the stores.
#[derive(Debug, Clone, Copy, Default)]
#[repr(C)]
pub(super) struct State {
    pub current: f64,
    /// Whole turns beside the phase.
    pub turns: f64,
    pub speed: f64,
    /// The torque of gravity that acted last, N m.
    pub pull: f64,
    /// In turns, within ±½.
    pub phase: f64,
}

impl State {
    #[inline(always)]
    pub fn motion(&self) -> Motion {
        Motion { current: self.current, speed: self.speed }
    }
}

/// What a step must keep to so that nothing can have happened in it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    /// Times this the speed must end above the other, so that it still turns the same way.
    pub sense: (f64, f64),
    /// Whether there is a current source with its limits.
    pub limited: bool,
    /// Between these the speed must end.
    pub speed: (f64, f64),
    /// Between these the current must end.
    pub current: (f64, f64),
    /// Shares of the current and the speed at the beginning that must come to this, or friction could bring it to rest.
    pub dip: [f64; 3],
}

impl Bounds {
    /// Anything goes.
    pub const FREE: Self = Self {
        sense: (0.0, -1.0),
        limited: false,
        speed: (f64::NEG_INFINITY, f64::INFINITY),
        current: (f64::NEG_INFINITY, f64::INFINITY),
        dip: [0.0; 3],
    };
}

/// What stays the same from step to step.
#[derive(Debug, Clone, Copy)]
pub(super) struct Swift {
    pub table: Table,
    pub bounds: Bounds,
    pub friction: f64,
    pub weight: f64,
    /// k, b and J.
    pub gain: f64,
    pub viscous: f64,
    pub inertia: f64,
    pub period: f64,
}

/// Takes off whole turns. It is apart so that the many steps that have none do not wait for it.
#[cold]
#[inline(never)]
fn turned(phase: f64, turns: f64) -> (f64, f64) {
    let (rest, whole) = wrapped(phase);
    (rest, turns + whole)
}

/// Whether a number is next to nothing, but not nothing.
#[inline(always)]
fn is_tiny(x: f64) -> bool {
    x.abs() < NOTHING && x != 0.0
}

impl Swift {
    /// Where a step ends and what acted; `None` where something may happen in it. `FULL`: with the bounds of a
    /// current source, and with whole turns taken off, which else end it too. `DRY`: with dry friction; where
    /// it is `FULL`, with or without.
    #[inline(always)]
    pub fn step<const METHOD: u8, const FULL: bool, const DRY: bool>(
        &self,
        state: &State,
        volts: f64,
    ) -> Option<(State, Push)> {
        let (table, bounds, x) = (&self.table, &self.bounds, state.motion());
        let mut pull = 0.0;
        let mut push = Push { volts, torque: self.friction, slope: 0.0, curve: 0.0 };
        if METHOD == MIDPOINT {
            let half = &table.half;
            let known = state.phase + (half[2] * volts + half[3] * (self.friction + state.pull));
            pull = -self.weight * sine(known + (half[0] * x.current + half[1] * x.speed));
            push.torque += pull;
        } else if METHOD == PARABOLA {
            let torque = self.gain * x.current - self.viscous * x.speed + self.friction;
            let begins =
                begins(self.weight, torque / self.inertia, self.inertia, x.speed, state.phase, &push);
            let middle = -self.weight * sine(state.phase + all(&table.half, x, &begins));
            pull = -self.weight * sine(state.phase + all(&table.turns, x, &begins));
            push = parabola(begins, self.friction, [middle, pull], self.period);
        }
        let known = |row: &Row| row[2] * volts + row[3] * self.friction;
        // In the order in which things come from the step before. What is large is added to once: there, roundings would add up.
        let go = |from: f64, row: &Row| match METHOD {
            NONE => from + ((row[0] * x.current + known(row)) + row[1] * x.speed),
            MIDPOINT => (from + ((row[0] * x.current + row[1] * x.speed) + known(row))) + row[3] * pull,
            _ => from + all(row, x, &push),
        };
        let motion = if METHOD == NONE {
            // So that the way of a current through itself is short, and one by way of the speed too. A current forgets what is rounded.
            let row = &table.current;
            let current = ((x.current + known(row)) + row[0] * x.current) + row[1] * x.speed;
            Motion { current, speed: go(x.speed, &table.speed) }
        } else {
            Motion { current: go(x.current, &table.current), speed: go(x.speed, &table.speed) }
        };
        let (mut phase, mut whole) = (go(state.phase, &table.turns), state.turns);
        let between = |x: f64, (low, high): (f64, f64)| x > low && x < high;
        if FULL
            && bounds.limited
            && !(between(motion.speed, bounds.speed) && between(motion.current, bounds.current))
        {
            return None;
        }
        if FULL || DRY {
            let dips = bounds.dip[0] * x.current + bounds.dip[1] * x.speed < bounds.dip[2];
            let turns_on = bounds.sense.0 * motion.speed > bounds.sense.1;
            if dips || !turns_on {
                return None;
            }
        }
        // With the speed, the current comes to nothing. Where there is friction, the bound on the speed has seen to it.
        if (FULL || !DRY) && is_tiny(motion.speed) {
            return None;
        }
        if phase.abs() > 0.5 {
            if !FULL {
                return None;
            }
            (phase, whole) = turned(phase, whole);
        }
        Some((State { current: motion.current, phase, speed: motion.speed, turns: whole, pull }, push))
    }
}

/// The torque of gravity as it begins to change, added to what else acts; `others` is the acceleration that makes without it.
#[inline(always)]
pub(super) fn begins(weight: f64, others: f64, inertia: f64, speed: f64, phase: f64, push: &Push) -> Push {
    let (pull, lever) = (-weight * sine(phase), -weight * cosine(phase));
    let acceleration = others + pull / inertia;
    Push {
        torque: push.torque + pull,
        slope: lever * speed,
        curve: lever * acceleration - pull * speed * speed,
        ..*push
    }
}

/// A parabola through the torque of gravity at beginning, middle and end of a time, and what else acts.
#[inline(always)]
pub(super) fn parabola(begins: Push, others: f64, [middle, end]: [f64; 2], time: f64) -> Push {
    let begin = begins.torque - others;
    Push {
        slope: (4.0 * middle - 3.0 * begin - end) / time,
        curve: 4.0 * ((begin - middle) + (end - middle)) / (time * time),
        ..begins
    }
}
