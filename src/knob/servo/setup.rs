//! What a servo is made of.

use crate::actuator::fault::Fault;
use crate::knob::effect::program::Any;
use crate::knob::governor::MARGIN;
use crate::knob::governor::device::Device;
use crate::knob::passivity::Cap;
use crate::knob::plant::wave::Wave;
use crate::knob::safety::chain::Limits;
use std::fmt;

/// Everything that a servo needs to know.
#[derive(Debug, Clone, PartialEq)]
pub struct Setup {
    /// What the knob feels like, in the order in which it adds up.
    pub effects: Vec<Any>,
    /// What carries it; its period is that of the ticks.
    pub device: Device,
    /// The share of the edge of stability that the governor grants: above 0, at most 1.
    pub margin: f64,
    /// What the chain of safety keeps to; its period is the device's.
    pub limits: Limits,
    /// The passivity controller's cap; `None`: energy is booked and nothing brakes.
    pub passivity: Option<Cap>,
    /// Torque over the angle that the motor makes by itself, N m, to be taken back; flat where nothing is.
    pub cogging: Wave,
    /// By what share the motor's torque constant is larger than on the mean, over the angle, to be made up for.
    pub ripple: Wave,
}

impl Setup {
    /// Of effects on a device that keeps to limits, and all else as usual.
    pub fn new(effects: Vec<Any>, device: Device, limits: Limits) -> Self {
        Self {
            effects,
            device,
            margin: MARGIN,
            limits,
            passivity: None,
            cogging: Wave::default(),
            ripple: Wave::default(),
        }
    }

    /// Seconds from tick to tick.
    pub fn period(&self) -> f64 {
        self.device.period
    }

    /// Ticks from a reading to its torque, to the nearest whole one.
    pub fn late(&self) -> usize {
        self.device.delay.total().round().clamp(0.0, 1e6) as usize
    }
}

/// What of a [`Setup`] cannot be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unfit {
    /// The effect, by its place; `None`: the device, or what it keeps to.
    pub effect: Option<usize>,
    /// The figure.
    pub fault: Fault,
}

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.effect {
            Some(effect) => write!(f, "effect {}: {}", effect + 1, self.fault),
            None => write!(f, "{}", self.fault),
        }
    }
}

impl std::error::Error for Unfit {}

impl From<Fault> for Unfit {
    fn from(fault: Fault) -> Self {
        Self { effect: None, fault }
    }
}
