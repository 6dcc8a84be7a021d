//! What must be known of a knob to say what it bears.

use super::loops::Loops;
use crate::actuator::fault::{Fault, Limit, check, not_negative, positive};
use crate::knob::low_pass::LowPass;
use crate::knob::stability::rules::quantisation;
use crate::knob::stability::sampled::{Loop, MOST_DELAY, Rotor, Shaft};
use crate::knob::velocity::choice::Choice;

/// Delay from reading to torque, beside the hold's half tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delay {
    /// What does not depend on the block, ticks; measured, so it may have a fraction.
    pub fixed: f64,
    /// Frames of a block; 0 where there are none.
    pub block: u32,
    /// Frames of a tick.
    pub frames: f64,
    /// How many blocks a reading waits for its torque: 2 at least, one in and one out.
    pub blocks: f64,
    /// From reading to the torque of what depends on the angle alone, ticks, where that is worked out anew without waiting for blocks.
    pub local: Option<f64>,
}

impl Delay {
    /// A delay without blocks, ticks.
    pub const fn ticks(fixed: f64) -> Self {
        Self { fixed, block: 0, frames: 1.0, blocks: 0.0, local: None }
    }

    /// All of it, ticks.
    pub fn total(&self) -> f64 {
        self.fixed + f64::from(self.block) * self.blocks / self.frames
    }

    /// That of a spring: as much as all of it, or less.
    pub fn spring(&self) -> f64 {
        self.local.map_or(self.total(), |local| f64::min(local, self.total()))
    }

    /// Whole ticks by which a spring's torque is sooner than that of the damping.
    pub fn sooner(&self) -> usize {
        (self.total() - self.spring()).clamp(0.0, MOST_DELAY) as usize
    }

    /// So many times as long, in one piece.
    pub(super) fn times(&self, times: f64) -> Self {
        Self { local: self.local.map(|local| local * times), ..Self::ticks(self.total() * times) }
    }
}

/// A shaft that twists.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resonance {
    /// Frequency with the knob clamped, hertz.
    pub clamped: f64,
    /// What of the inertia is the knob's, kg m².
    pub knob: f64,
    /// The shaft's own damping, N m s/rad.
    pub loss: f64,
}

/// A device.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// Of motor and knob together, kg m².
    pub inertia: f64,
    /// Under the drive that is used, N m s/rad. The damping of a shorted motor is there under voltage drive only.
    pub damping: f64,
    /// Dry friction, N m, if it is known: it alone keeps the encoder's steps from making the knob tremble by a part of a count.
    pub friction: Option<f64>,
    /// A count of the encoder, radians.
    pub count: f64,
    /// Seconds from tick to tick.
    pub period: f64,
    /// From reading to torque.
    pub delay: Delay,
    /// The shaft, if it matters.
    pub resonance: Option<Resonance>,
    /// Corner of the reconstruction low-pass, hertz, if there is one.
    pub low_pass: Option<f64>,
    /// What makes a speed of its angles: the computed damping is as late as that.
    pub velocity: Choice,
    /// The largest torque, N m.
    pub peak: f64,
}

/// So many delays make a window whose shorter forms may be less stable than itself.
const FEW: f64 = 8.0;

impl Device {
    /// Its loops, for the edge of stability.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn sampled(&self) -> Result<Loops, Fault> {
        positive("inertia", self.inertia)?;
        not_negative("damping", self.damping)?;
        not_negative("friction", self.friction.unwrap_or(0.0))?;
        positive("count", self.count)?;
        positive("period", self.period)?;
        positive("peak", self.peak)?;
        not_negative("fixed", self.delay.fixed)?;
        not_negative("blocks", self.delay.blocks)?;
        not_negative("local", self.delay.local.unwrap_or(0.0))?;
        positive("frames", self.delay.frames)?;
        let delay = self.delay.total();
        let all = match &self.resonance {
            None => Loop::rigid(&Rotor { inertia: self.inertia, damping: self.damping }, self.period, delay)?,
            Some(r) => {
                positive("knob", r.knob)?;
                check("knob", r.knob, Limit::Below(self.inertia))?;
                let motor = self.inertia - r.knob;
                let (knob, clamped, loss) = (r.knob, r.clamped, r.loss);
                Loop::shaft(&Shaft { motor, knob, clamped, loss, damping: self.damping }, self.period, delay)?
            }
        };
        let all = all.sooner(self.delay.sooner());
        let all = match self.low_pass {
            None => all,
            Some(hertz) => all.filtered(&LowPass::new(hertz, self.period)?),
        };
        let mut estimators = self.velocity.transfers(self.count, self.period)?;
        // Behind a delay that is no small part of it the longest window is the least stable, and shorter ones cost seconds.
        if estimators.last().is_some_and(|longest| FEW * delay >= longest.ticks as f64) {
            estimators = estimators.split_off(estimators.len() - 1);
        }
        Ok(Loops::new(estimators.into_iter().map(|one| all.clone().estimated(one)).collect()))
    }

    /// The stiffness up to which nothing but the loop moves the knob: dry friction covers a count's torque, and a count does not ask
    /// for more than the peak torque, N m/rad.
    pub fn still(&self) -> f64 {
        f64::min(self.covered(), self.peak / self.count)
    }

    /// The stiffness up to which dry friction covers a count, N m/rad; infinite where friction is not known.
    pub fn covered(&self) -> f64 {
        self.friction.map_or(f64::INFINITY, |friction| quantisation(friction, self.count))
    }

    /// Peak torque over dry friction: the range of torques that can be felt, if friction is known.
    pub fn dynamic_range(&self) -> Option<f64> {
        self.friction.filter(|f| *f > 0.0).map(|f| self.peak / f)
    }
}
