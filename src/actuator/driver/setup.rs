//! A motor that is to be turned, and how.

use super::order::{After, By};
use crate::actuator::drive::Drive;
use crate::actuator::fault::{Fault, Limit, within};
use crate::actuator::link::compensator::Compensator;
use crate::actuator::link::coupling::Corners;
use crate::actuator::motor::{self, Parameters};

/// Of the limit: where nothing holds a motor at rest, no more than this turns it when it should stand.
const LITTLE: f64 = 0.005;

/// From the level that is played to what reaches the terminals. A level is the share of the rated vibration, and backward where it is
/// negative.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shaping {
    /// Inverse dynamics: the motor does what is played, as far as it can, and is braked in time.
    #[default]
    Inverse,
    /// As much as there may be until the motor is as fast as what is played, and as much backward until it is as slow.
    Overdrive,
    /// As much as there may be one way or the other, at every sample whichever brings the motor nearer.
    Switching,
    /// What holds the speed, and nothing behind it: a short circuit, or open terminals where the drive is a current; or as [`Stage`] has it.
    Plain,
    /// Nothing: clicks alone are played, which is all that gets through AC coupling.
    Clicks,
    /// The most there may be while the level is up, and what follows when it is down: see [`Stage`].
    OnOff,
}

/// How a drive is held and what follows it, of [`Shaping::Plain`] and [`Shaping::OnOff`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stage {
    /// What is held.
    pub by: By,
    /// What is done while the motor is to be slower than it is, or off.
    pub after: After,
    /// Where it is on, the share of the most that there may be: above 0 to 1. At a voltage, a current takes more volts as the motor becomes faster, for which
    /// a share below 1 leaves room.
    pub share: f64,
    /// Levels from which on it is on, and from which down it is off again: 0 to 1, the second no more than the first.
    pub on_at: f64,
    /// See `on_at`.
    pub off_at: f64,
}

impl Default for Stage {
    fn default() -> Self {
        Self { by: By::Amplifier, after: After::Nothing, share: 1.0, on_at: 0.5, off_at: 0.25 }
    }
}

impl Shaping {
    /// All.
    pub const ALL: [Self; 6] =
        [Self::Inverse, Self::Overdrive, Self::Switching, Self::Plain, Self::Clicks, Self::OnOff];

    /// The words for them in a rig.
    pub const WORDS: &[&str] = &["inverse", "overdrive", "switching", "plain", "clicks", "on-off"];

    /// The word for it.
    pub fn word(self) -> &'static str {
        Self::WORDS[self as usize]
    }
}

impl std::str::FromStr for Shaping {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|shaping| shaping.word() == word);
        found.ok_or_else(|| format!("`{word}` is no shaping: there are {}", Self::WORDS.join(", ")))
    }
}

/// A motor and how it is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// The motor.
    pub parameters: Parameters,
    /// What the amplifier imposes.
    pub imposes: Drive,
    /// Whether diodes let current in and none out: nothing backward can be given, nothing brakes, and a motor that is faster than the voltage
    /// holds runs on with open terminals. Of a voltage alone.
    pub one_way: bool,
    /// What those diodes take, V, 0 to 1e6: the coil's current goes on against that when nothing is given any more. Of no account without them.
    pub diode_drop: f64,
    /// Whether those are one diode, which lets every other half-wave through alone. Of no account without them.
    pub half_wave: bool,
    /// The most it gives, volts or amperes: 1e-6 to 1e6.
    pub limit: f64,
    /// The most voltage with which it holds a current, 1e-6 to 1e6 V; of no account where it imposes a voltage.
    pub compliance: f64,
    /// What is done with levels.
    pub shaping: Shaping,
    /// How drives are held, and what follows them; of [`Shaping::Plain`] and [`Shaping::OnOff`] alone.
    pub stage: Stage,
    /// Seconds of rest after which the mass is brought home again, once it was, 0.01 to 60; `None`: it is left where it is.
    pub park: Option<f64>,
    /// Seconds by which what is played is known ahead, 0 to 1; `None`: as long as braking from the full speed takes. For
    /// [`Shaping::Inverse`] alone.
    pub look_ahead: Option<f64>,
    /// Whether orders may come: if not, what only they need is left out.
    pub ordered: bool,
    /// Samples a second, 100 to 1e6.
    pub rate: f64,
}

impl Setup {
    /// Whether it can be.
    ///
    /// # Errors
    /// The first number beyond its limits.
    pub fn check(&self) -> Result<(), Fault> {
        self.parameters.check()?;
        within("limit", self.limit, (1e-6, 1e6), "V or A")?;
        if self.one_way && self.imposes == Drive::Current {
            let because = "behind diodes a current would have nowhere to go while they block";
            return Err(Fault::because("one_way", 1.0, Limit::Absent, because));
        }
        within("diode_drop", self.diode_drop, (0.0, 1e6), "V")?;
        within("share", self.stage.share, (1e-3, 1.0), "of the most that there may be")?;
        within("on_at", self.stage.on_at, (0.001, 1.0), "of a level")?;
        within("off_at", self.stage.off_at, (0.0, self.stage.on_at), "of a level")?;
        within("park", self.park.unwrap_or(1.0), (0.01, 60.0), "s")?;
        within("compliance", self.compliance, (1e-6, 1e6), "V")?;
        within("rate", self.rate, (100.0, 1e6), "samples a second")?;
        within("look_ahead", self.look_ahead.unwrap_or(0.0), (0.0, 1.0), "s")
    }

    /// What it is to whom the means of a carrier alone are known. Through one diode the current begins anew with every half-wave, as it ceases before
    /// the next: what the coil holds back and gives back is part of the mean of each, and nothing of it is carried on from one to the next. So on average
    /// there is no inductance. Through a bridge there is one, as half-waves follow one another.
    pub fn on_average(&self) -> Self {
        let mut setup = *self;
        if self.one_way && self.half_wave {
            setup.parameters.inductance = 0.0;
        }
        setup
    }

    /// So many volts, or amperes, at its terminals.
    pub fn drive(&self, amount: f64) -> motor::Drive {
        match self.imposes {
            Drive::Voltage => motor::Drive::Voltage(amount),
            Drive::Current => motor::Drive::Current { amperes: amount, limit: self.compliance },
        }
    }

    /// What makes up for coupling between a device, of `rate` samples a second and so many volts or amperes for each sample of 1, and the motor:
    /// in samples. What moves the motor from nowhere, gravity helping, does not matter; where nothing is that little, half a per cent of the limit.
    ///
    /// # Errors
    /// A corner, a rate or a scale that cannot be.
    pub fn through(&self, corners: &Corners, rate: f64, per_sample: f64) -> Result<Compensator, Fault> {
        let p = &self.parameters;
        // What its mass weighs may pull the same way; and what still turns a little must not be kept turning.
        let held = (0.5 * (p.stiction - p.weight())).min(0.9 * p.coulomb) / p.gain;
        let held = held * if self.imposes == Drive::Voltage { p.resistance } else { 1.0 };
        let quiet = held.max(LITTLE * self.limit);
        Compensator::new(corners, rate, quiet / per_sample.abs())
    }

    /// The least that can be given, volts or amperes.
    pub fn least(&self) -> f64 {
        if self.one_way { 0.0 } else { -self.limit }
    }

    /// The speed of a level of 1, rad/s: the rated one.
    pub fn full_speed(&self) -> f64 {
        self.parameters.rated_speed()
    }

    /// The speed of a level: casing acceleration goes with its square. What is no number is at rest; a level beyond 1 counts as 1.
    pub fn speed_of(&self, level: f64) -> f64 {
        if level.is_nan() {
            return 0.0;
        }
        self.full_speed() * level.abs().min(1.0).sqrt().copysign(level)
    }

    /// The torque at the limit with the rotor held, N m.
    pub fn full_torque(&self) -> f64 {
        match self.imposes {
            Drive::Voltage => self.parameters.stall_torque(self.limit),
            Drive::Current => self.parameters.gain * self.limit,
        }
    }

    /// What takes speed away as speed does, N m s: back-EMF has no part in it under a current.
    pub fn damping(&self) -> f64 {
        match self.imposes {
            Drive::Voltage => self.parameters.damping(),
            Drive::Current => self.parameters.viscous,
        }
    }

    /// Volts or amperes that hold a speed (rad/s), gravity aside: of a voltage, what spins hold theirs with.
    pub fn held_by(&self, speed: f64) -> f64 {
        let p = &self.parameters;
        let friction = if speed == 0.0 { 0.0 } else { p.coulomb.copysign(speed) };
        let torque = self.damping() * speed + friction;
        match self.imposes {
            Drive::Voltage => torque * p.resistance / p.gain,
            Drive::Current => torque / p.gain,
        }
    }
}
