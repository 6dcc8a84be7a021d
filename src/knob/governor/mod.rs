//! How stiff and how viscous effects may be on a device.
//!
//! | file | holds |
//! |---|---|
//! | [`device`] | what must be known of a knob |
//! | [`loops`] | its loops, one for each length of an adaptive window |
//! | [`limit`] | which limit binds, and what would lift it |
//!
//! [`Governor::new`] computes, off the servo, the exact edge of stability over the computed damping, with the states of the estimator that
//! the damping is computed from; [`Governor::allow`] looks up at every
//! tick what is left of what the effects ask. Half of the edge is the default: at nine tenths the encoder's steps already make most loops
//! tremble.

pub mod device;
pub mod limit;
pub mod loops;
#[cfg(test)]
mod tests;

use crate::actuator::fault::{Fault, Limit as Must, check};
use crate::knob::effect::Bound;
use crate::knob::velocity::choice::Choice;
use device::Device;
use limit::{Explanation, Limit, explain};

/// The share of the edge of stability that is granted by default.
pub const MARGIN: f64 = 0.5;
/// Points of the table over damping.
const POINTS: usize = 33;

/// What a governor grants of what was asked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Allowed {
    /// Share of the stiffness, 0 to 1.
    pub stiffness: f64,
    /// Share of the damping, 0 to 1.
    pub damping: f64,
}

impl Default for Allowed {
    fn default() -> Self {
        Self { stiffness: 1.0, damping: 1.0 }
    }
}

impl Allowed {
    /// Whether less was granted than asked.
    pub fn acted(&self) -> bool {
        self.stiffness < 1.0 || self.damping < 1.0
    }
}

/// Clamps stiffness and damping to what a device bears.
#[derive(Debug, Clone, PartialEq)]
pub struct Governor {
    device: Device,
    margin: f64,
    /// N m s/rad.
    most_damping: f64,
    /// Steps of the table for a damping of 1.
    steps: f64,
    /// Largest stiffness at equal steps of damping up to that, as far as the loop goes.
    stiffness: [f64; POINTS],
    /// Largest stiffness by counts, friction and peak torque, N m/rad: no part of the table, which is straight between its points.
    still: f64,
}

impl Governor {
    /// For a device, granting a share `margin` (above 0, at most 1) of its edge of stability.
    ///
    /// # Errors
    /// A figure of the device that cannot be; `margin`.
    pub fn new(device: &Device, margin: f64) -> Result<Self, Fault> {
        check("margin", margin, Must::Above(0.0))?;
        check("margin", margin, Must::Most(1.0))?;
        let sampled = device.sampled()?;
        let most_damping = margin * sampled.damping_edge().gain;
        let still = device.still();
        let mut stiffness = [0.0; POINTS];
        for (k, entry) in stiffness.iter_mut().enumerate() {
            let edge = sampled.edge_within(most_damping * k as f64 / (POINTS - 1) as f64).gain;
            // A loop without any damping of its own has no edge but 0.
            let edge = if k == 0 { sampled.edge(0.0).gain } else { edge };
            // So that differences stay numbers where every stiffness is stable.
            *entry = f64::min(margin * edge, 1e300);
        }
        if most_damping == 0.0 {
            stiffness = [stiffness[0]; POINTS];
        }
        let steps = if most_damping > 0.0 { (POINTS - 1) as f64 / most_damping } else { 0.0 };
        Ok(Self { device: device.clone(), margin, most_damping, steps, stiffness, still })
    }

    /// The largest stiffness (N m/rad) beside a computed damping (N m s/rad).
    #[inline(always)]
    pub fn most_stiffness(&self, damping: f64) -> f64 {
        let at = (damping * self.steps).clamp(0.0, (POINTS - 1) as f64);
        let k = (at as usize).min(POINTS - 2);
        let stiffness = self.stiffness[k] + (self.stiffness[k + 1] - self.stiffness[k]) * (at - k as f64);
        f64::min(stiffness, self.still)
    }

    /// The largest computed damping, N m s/rad.
    pub fn most_damping(&self) -> f64 {
        self.most_damping
    }

    /// What is granted of what all effects ask together. What is not a number is granted nothing.
    #[inline(always)]
    pub fn allow(&self, ask: &Bound) -> Allowed {
        let share = |limit: f64, asked: f64| {
            if asked <= limit {
                1.0
            } else if asked > limit && asked < f64::INFINITY {
                limit / asked
            } else {
                0.0
            }
        };
        let damping = share(self.most_damping, ask.damping);
        let granted = f64::min(ask.damping, self.most_damping);
        Allowed { stiffness: share(self.most_stiffness(granted), ask.stiffness), damping }
    }

    /// What binds beside a computed damping, and what would lift it.
    ///
    /// # Errors
    /// None for a device that [`Governor::new`] took.
    pub fn explain(&self, damping: f64) -> Result<Explanation, Fault> {
        explain(&self.device, self.margin, damping.clamp(0.0, self.most_damping))
    }

    /// Which limit binds damping: what gives most where it alone is taken away. Where none of them gives more it is the damping itself.
    pub fn binds_damping(&self) -> Limit {
        let most = |device: &Device| device.sampled().map_or(0.0, |all| all.damping_edge().gain);
        let rigid = Device { resonance: None, ..self.device.clone() };
        let quick = Device { velocity: Choice::Difference, ..self.device.clone() };
        let own = (Limit::ComputedDamping, most(&self.device) * 1.000_1);
        let others = [(Limit::Resonance, most(&rigid)), (Limit::Estimator, most(&quick))];
        others.into_iter().fold(own, |best, next| if next.1 > best.1 { next } else { best }).0
    }
}
