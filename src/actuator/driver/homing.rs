//! The way home: where the mass hangs made known, whatever was before.

use std::f64::consts::{PI, TAU};

use super::order::Pieces;
use super::setup::Setup;
use crate::actuator::drive;
use crate::actuator::fault::{Fault, Limit};
use crate::actuator::motor::Drive;
use crate::actuator::shape::{Home, Unreachable};

/// Of what starts a motor from anywhere, what is given so that it starts for certain.
const STARTS: f64 = 1.5;

/// What is farther apart is no home, rad.
const NEAR: f64 = std::f64::consts::FRAC_PI_4;

/// A spin, a creep after which gravity has caught the mass, and what follows, worked out ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Homing {
    /// The drives.
    pub pieces: Pieces,
    /// Where the mass hangs then, rad from straight down: -π to π.
    pub angle: f64,
    /// The most by which it may hang elsewhere, rad; and where one of the motor's figures is 5 % off.
    pub spread: f64,
    /// See `spread`.
    pub astray: f64,
}

impl Homing {
    /// That of a motor: as [`Home`] solves it, with no more voltage than starts it for certain.
    ///
    /// # Errors
    /// A number beyond its limits; no gravity, an amplifier that imposes a current; a limit that does not start the motor from everywhere; a motor
    /// that nothing catches.
    pub fn new(setup: &Setup) -> Result<Self, Unreachable> {
        setup.check()?;
        if setup.imposes == drive::Drive::Current {
            let because = "the way home is a matter of voltages, and the amplifier imposes a current";
            return Err(Fault::because("home", 1.0, Limit::Absent, because).into());
        }
        if setup.one_way {
            let because = "the carrier behind diodes shakes loose what gravity caught";
            return Err(Fault::because("home", 1.0, Limit::Absent, because).into());
        }
        let volts = (STARTS * setup.parameters.start_volts()).min(setup.limit);
        let homed = Home { volts }.solve(&setup.parameters)?;
        if homed.spread > NEAR {
            return Err(Unreachable::Loose(homed.spread));
        }
        let (mut pieces, mut begin) = (Pieces::default(), 0.0);
        for (piece, (end, drive)) in pieces.list.iter_mut().zip(homed.course.pieces()) {
            let Drive::Voltage(volts) = drive else { continue };
            *piece = (end - begin, *volts);
            begin = *end;
        }
        let angle = (homed.angle + PI).rem_euclid(TAU) - PI;
        Ok(Self { pieces, angle, spread: homed.spread, astray: homed.astray })
    }

    /// How long it takes, s.
    pub fn seconds(&self) -> f64 {
        self.pieces.list.iter().map(|piece| piece.0).sum()
    }
}
