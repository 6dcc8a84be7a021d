//! Torque-squared budget: a winding may be overloaded for as long as it stays cool.
//!
//! First-order: the load h follows (τ / τ_c)² with the winding's time constant, and 1 is what the continuous torque ends at. From cold, a
//! torque m times the continuous one reaches that after −t_w ln(1 − 1 / m²). The allowed torque falls towards the continuous one as the load
//! nears 1, τ² ≤ τ_c² (1 + (1 − h) t_w / t_r), so that it never jumps and h never exceeds 1.

use crate::actuator::elementary::exp_m1;
use crate::actuator::fault::{Fault, Limit, check, positive};

/// A winding's load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Budget {
    continuous: f64,
    /// 1 / τ_c².
    per_square: f64,
    time: f64,
    /// t_w / t_r.
    reach: f64,
    /// 1 − e^{−T / t_w}.
    step: f64,
    load: f64,
}

impl Budget {
    /// For a continuous torque (N m), a winding's time constant and a time `release` over which what is left may be spent (seconds), at ticks
    /// of `period` seconds.
    ///
    /// # Errors
    /// A figure that is not above 0; `release` beyond `time`, or shorter than two ticks.
    pub fn new(continuous: f64, time: f64, release: f64, period: f64) -> Result<Self, Fault> {
        positive("continuous", continuous)?;
        positive("time", time)?;
        positive("period", period)?;
        check("release", release, Limit::Least(2.0 * period))?;
        check("release", release, Limit::Most(time))?;
        let per_square = 1.0 / (continuous * continuous);
        let step = -exp_m1(-period / time);
        Ok(Self { continuous, per_square, time, reach: time / release, step, load: 0.0 })
    }

    /// As warm as another's winding is, up to what its continuous torque ends at.
    pub fn continue_from(&mut self, before: &Self) {
        self.load = f64::min(before.load * before.continuous * before.continuous * self.per_square, 1.0);
    }

    /// The largest torque now, N m; none where a torque that acted for long without a tick has spent far more than there was.
    pub fn allowed(&self) -> f64 {
        self.continuous * (1.0 + (1.0 - self.load) * self.reach).max(0.0).sqrt()
    }

    /// Whether a torque is within it.
    #[inline(always)]
    pub fn allows(&self, torque: f64) -> bool {
        torque * torque * self.per_square <= 1.0 + (1.0 - self.load) * self.reach
    }

    /// Books a tick of a torque.
    #[inline(always)]
    pub fn spend(&mut self, torque: f64) {
        self.load += (torque * torque * self.per_square - self.load) * self.step;
    }

    /// Books a torque that acted for so many seconds; no time or a torque that is no number is nothing.
    pub fn spend_over(&mut self, torque: f64, seconds: f64) {
        let more = (torque * torque * self.per_square - self.load) * -exp_m1(-seconds.max(0.0) / self.time);
        if more.is_finite() {
            self.load += more;
        }
    }

    /// 0 cold, 1 where the continuous torque ends.
    pub fn load(&self) -> f64 {
        self.load
    }

    /// Seconds from cold until a steady torque has used the budget; infinite at the continuous torque and below.
    pub fn time_to_limit(&self, torque: f64) -> f64 {
        let square = torque * torque * self.per_square;
        if square <= 1.0 { f64::INFINITY } else { -self.time * (-1.0 / square).ln_1p() }
    }
}
