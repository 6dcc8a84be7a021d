//! What of a motor a scene computes, and how well.

use std::fmt;

use super::parameters::{Casing, Parameters};

/// How well a motor is computed. Without gravity all but [`Level::Economy`] are exact, but for rounding.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// No inductance, and gravity as in [`Level::Default`].
    Economy,
    /// Gravity as it is in the middle of a step (exponential midpoint rule): order 2.
    Default,
    /// Gravity by a parabola through beginning, middle and end of a step: order 4 where it turns smoothly.
    Fine,
}

/// What of a motor is computed. All parts by default: [`Plan::whole`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plan {
    /// How well.
    pub level: Level,
    /// Whether gravity acts on the eccentric mass.
    pub gravity: bool,
    /// Whether the coil has its inductance; never at [`Level::Economy`].
    pub inductance: bool,
    /// Whether somebody wants to know what the casing does.
    pub casing: bool,
    /// What was left out, and why, in the order gravity, inductance, casing.
    pub left_out: [Option<LeftOut>; 3],
}

/// A part that was left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeftOut {
    /// Which.
    pub part: Part,
    /// Why.
    pub why: Why,
}

/// A part of the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Gravity on the eccentric mass.
    Gravity,
    /// The inductance of the coil.
    Inductance,
    /// What the casing does.
    Casing,
}

/// Why a part was left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Why {
    /// The motor has none.
    None,
    /// The posture of the device is unknown.
    Posture,
    /// What the mass weighs is unknown: see [`Plan::of_unknown_weight`].
    Weight,
    /// It changes the speed by less than the wish: by this share of the rated speed.
    Small(f64),
    /// Nobody asked.
    Unasked,
}

/// What a scene wants of a motor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wish {
    /// The largest error of the speed as a share of the rated speed.
    pub error: f64,
    /// Whether it is known how the device is held.
    pub posture: bool,
    /// Whether somebody wants to know what the casing does.
    pub casing: bool,
}

/// Errors of the speed are at most this times its ripple and the angle of a step to the power of the order. On nine trajectories of three motors
/// at 8 to 192 kHz it is 0.035 to 0.043 and 4e-5 to 1.3e-3.
const MIDPOINT: f64 = 0.05;
const PARABOLA: f64 = 2e-3;

impl Plan {
    /// All parts, at a level. A motor without inductance, gravity or a casing that moves has those parts all the same: they are nothing.
    pub const fn whole(level: Level) -> Self {
        let inductance = !matches!(level, Level::Economy);
        Self { level, gravity: true, inductance, casing: true, left_out: [None; 3] }
    }

    /// The least that grants a wish at `rate` steps a second.
    ///
    /// Gravity is left out where posture is unknown, or where its torque is below the wish as a share of the stall torque and below half a per
    /// cent; inductance where L/R is below 0.02 of the mechanical time constant, turns the mass by less than 0.1 rad at rated speed, and the
    /// error it makes in a full reversal is below the wish.
    pub fn choose(parameters: &Parameters, rate: f64, wish: &Wish) -> Self {
        let p = parameters;
        let heavy = p.weight() / p.stall_torque(p.rated_volts);
        let gravity = if heavy == 0.0 {
            Err(Why::None)
        } else if !wish.posture {
            Err(Why::Posture)
        } else if heavy < 0.005 && heavy < wish.error {
            Err(Why::Small(heavy))
        } else {
            Ok(())
        };
        let late = Self::lateness(p);
        let inductance = if late == 0.0 {
            Err(Why::None)
        } else if late < 0.04 && late < wish.error && p.electrical_time() * p.rated_speed() < 0.1 {
            Err(Why::Small(late))
        } else {
            Ok(())
        };
        let casing = match p.casing {
            Casing::Held => Err(Why::None),
            _ if !wish.casing => Err(Why::Unasked),
            _ => Ok(()),
        };
        let level = if gravity.is_ok() && Self::midpoint_error(p, rate) > wish.error {
            Level::Fine
        } else if inductance.is_err() {
            Level::Economy
        } else {
            Level::Default
        };
        let out = |part, of: Result<(), Why>| of.err().map(|why| LeftOut { part, why });
        Self {
            level,
            gravity: gravity.is_ok(),
            inductance: inductance.is_ok(),
            casing: casing.is_ok(),
            left_out: [
                out(Part::Gravity, gravity),
                out(Part::Inductance, inductance),
                out(Part::Casing, casing),
            ],
        }
    }

    /// The same, where gravity was left out for want of a posture, and it is the weight of the mass beside the motor's torques that nobody knows,
    /// as of a motor that is known from outside.
    #[must_use]
    pub fn of_unknown_weight(self) -> Self {
        let why = |why| if why == Why::Posture { Why::Weight } else { why };
        let left_out = self.left_out.map(|left| left.map(|left| LeftOut { why: why(left.why), ..left }));
        Self { left_out, ..self }
    }

    /// About the error of the speed that gravity leaves at this level, as a share of the rated speed.
    pub fn error(&self, parameters: &Parameters, rate: f64) -> f64 {
        match self.level {
            _ if !self.gravity => 0.0,
            Level::Fine => {
                let turned = parameters.rated_speed() / rate;
                PARABOLA * Self::ripple(parameters) * turned * turned * turned * turned
            }
            _ => Self::midpoint_error(parameters, rate),
        }
    }

    /// The error of the speed in a full reversal without inductance, as a share of the rated speed: what the torque jumps by, L/R late. That is
    /// twice L/R over the mechanical constant, more by what friction takes, and by a tenth for
    /// what gravity adds.
    fn lateness(p: &Parameters) -> f64 {
        let jump = 2.2 * p.stall_torque(p.rated_volts) / p.effective_inertia();
        p.electrical_time() * jump / p.rated_speed().max(1e-9)
    }

    fn midpoint_error(parameters: &Parameters, rate: f64) -> f64 {
        let turned = parameters.rated_speed() / rate;
        MIDPOINT * Self::ripple(parameters) * turned * turned
    }

    /// By how much gravity ripples the rated speed, as a share of it: m_e g r/(J ω²).
    fn ripple(parameters: &Parameters) -> f64 {
        let speed = parameters.rated_speed().max(1e-9);
        parameters.weight() / (parameters.effective_inertia() * speed * speed)
    }
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let part = match self.part {
            Part::Gravity => "gravity",
            Part::Inductance => "inductance",
            Part::Casing => "casing",
        };
        match self.why {
            Why::None => write!(f, "{part}: there is none"),
            Why::Posture => write!(f, "{part}: nobody said how the device is held"),
            Why::Weight => {
                write!(f, "{part}: what the mass weighs beside the motor's torques is not known from outside")
            }
            Why::Small(share) => write!(f, "{part}: it changes the speed by {:.2e} of the rated", share),
            Why::Unasked => write!(f, "{part}: nobody asked"),
        }
    }
}
