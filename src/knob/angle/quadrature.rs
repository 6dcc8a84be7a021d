//! The two lines of an encoder, sampled, into counts: four a line.
//!
//! A line is high above the threshold by the hysteresis, low below it by that, and what it was in between. From frame to frame one line
//! may change, which says the direction: ... 00 10 11 01 ... upwards. Two that change at once say nothing: the knob was faster than an edge a
//! frame. At 48 kHz and 4000 counts a turn that is at 12 turns a second.

use crate::actuator::fault::{Fault, Limit, check, not_negative, within};
use std::f64::consts::TAU;

/// Once both lines have changed at once, so many frames without an edge must pass before counts are believed again.
pub const QUIET: u32 = 4;

/// How lines are read.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lines {
    /// Counts a turn, four a line: 1 or more.
    pub counts: u32,
    /// Above this a line is high.
    pub threshold: f64,
    /// By how much a line must pass that, 0 or more.
    pub hysteresis: f64,
}

/// Counts edges.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quadrature {
    high: f64,
    low: f64,
    quantum: f64,
    lines: Option<[bool; 2]>,
    count: i64,
    /// Frames without an edge that are still to pass.
    waits: u32,
    illegal: u64,
    lost: u64,
}

impl Quadrature {
    /// At 0 counts.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn new(lines: &Lines) -> Result<Self, Fault> {
        check("counts", f64::from(lines.counts), Limit::Least(1.0))?;
        within("threshold", lines.threshold, (-1e6, 1e6), "")?;
        not_negative("hysteresis", lines.hysteresis)?;
        Ok(Self {
            high: lines.threshold + lines.hysteresis,
            low: lines.threshold - lines.hysteresis,
            quantum: TAU / f64::from(lines.counts),
            lines: None,
            count: 0,
            waits: 0,
            illegal: 0,
            lost: 0,
        })
    }

    /// The lines A and B in this frame; the angle, rad, counted from where it began. `None` where it is lost: a line is not a number, or both
    /// have changed at once and the knob is not slower yet. What was missed then is not made up for: whoever has an index resets it.
    #[inline]
    pub fn push(&mut self, a: f64, b: f64) -> Option<f64> {
        if !(a.is_finite() && b.is_finite()) {
            self.lost += 1;
            return None;
        }
        let was = self.lines.unwrap_or([a > 0.5 * (self.high + self.low), b > 0.5 * (self.high + self.low)]);
        let level = |x: f64, was: bool| if was { x > self.low } else { x > self.high };
        let now = [level(a, was[0]), level(b, was[1])];
        self.lines = Some(now);
        match place(now).wrapping_sub(place(was)) & 3 {
            0 => self.waits = self.waits.saturating_sub(1),
            1 => self.edge(1),
            3 => self.edge(-1),
            _ => {
                self.illegal += 1;
                self.waits = QUIET;
            }
        }
        if self.waits > 0 {
            self.lost += 1;
            return None;
        }
        Some(self.quantum * self.count as f64)
    }

    fn edge(&mut self, step: i64) {
        self.count = self.count.saturating_add(step);
        // Still fast: what is quiet begins anew.
        self.waits = if self.waits > 0 { QUIET } else { 0 };
    }

    /// Counts since it began.
    pub fn count(&self) -> i64 {
        self.count
    }

    /// How often both lines changed at once.
    pub fn illegal(&self) -> u64 {
        self.illegal
    }

    /// In how many frames it was lost.
    pub fn lost(&self) -> u64 {
        self.lost
    }

    /// Puts it at a count.
    pub fn reset(&mut self, count: i64) {
        (self.count, self.waits) = (count, 0);
    }
}

/// The place of a state among the four, in the order in which they come upwards.
fn place([a, b]: [bool; 2]) -> u8 {
    match (a, b) {
        (false, false) => 0,
        (true, false) => 1,
        (true, true) => 2,
        (false, true) => 3,
    }
}
