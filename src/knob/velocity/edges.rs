//! Time between an encoder's edges: for rates at which most ticks bring no count.
//!
//! At an edge the speed is the counts passed over the ticks since the edge before, so its error is a tick in those, not a count. Between edges
//! the speed can be no more than one count over the time since the last one, and falls with it.

use super::Estimator;
use crate::actuator::fault::{Fault, positive};

/// The period method.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Edges {
    count: f64,
    period: f64,
    longest: f64,
    last: Option<f64>,
    /// Ticks since the last edge.
    since: f64,
    direction: f64,
    measured: f64,
    speed: f64,
}

impl Edges {
    /// For readings every `period` seconds in counts of `count` radians; after `longest` seconds without an edge the knob stands.
    ///
    /// # Errors
    /// A figure that is not above 0.
    pub fn new(count: f64, longest: f64, period: f64) -> Result<Self, Fault> {
        positive("count", count)?;
        positive("longest", longest)?;
        positive("period", period)?;
        let longest = longest / period;
        Ok(Self {
            count,
            period,
            longest,
            last: None,
            since: longest,
            direction: 0.0,
            measured: 0.0,
            speed: 0.0,
        })
    }
}

impl Estimator for Edges {
    #[inline(always)]
    fn push(&mut self, angle: f64) -> f64 {
        if !angle.is_finite() {
            return self.speed;
        }
        let moved = angle - self.last.unwrap_or(angle);
        self.last = Some(angle);
        self.since += 1.0;
        // Half a count, because rounding moves an angle of many turns by more than nothing.
        if moved.abs() > 0.5 * self.count {
            let direction = moved.signum();
            // The first edge after a turn passes the one before it: it says nothing of the speed.
            let known = direction == self.direction && self.since <= self.longest;
            self.measured = if known { moved / (self.since * self.period) } else { 0.0 };
            (self.direction, self.since) = (direction, 0.0);
            self.speed = self.measured;
        } else if self.since > self.longest {
            self.speed = 0.0;
        } else {
            let most = self.count / (self.since * self.period);
            self.speed = self.measured.clamp(-most, most);
        }
        self.speed
    }

    fn reset(&mut self, angle: f64) {
        let longest = self.longest;
        *self =
            Self { last: Some(angle), since: longest, direction: 0.0, measured: 0.0, speed: 0.0, ..*self };
    }
}
