//! Parking: the mass goes back to where it hung, so that the next click kicks the same way.

use std::f64::consts::{PI, TAU};

use super::click::{Click, Clicked, Ending};
use super::unreachable::Unreachable;
use crate::actuator::motor::{Drive, Parameters};

/// Turns that are not worth a drive.
const NEAR: f64 = 1e-3;

/// A slow turn of the mass from where it hangs to where it shall hang, the shorter way.
///
/// Which way a click kicks depends on where the mass hangs, and a click leaves it elsewhere. Friction keeps it wherever it stops in most motors,
/// so it is turned back, at a voltage just above what starts it: what is felt goes with the square of the speed. It goes by figures alone: by how much
/// the mass hangs elsewhere than they say, it is off afterwards as well, and several times as much where the way leads near the top. A row of
/// clicks is to go home again ([`super::Home`]) now and then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Park {
    /// Where it hangs, rad from straight down.
    pub from: f64,
    /// Where it shall hang, rad from straight down.
    pub to: f64,
    /// The voltage, V; it must start the motor: [`Parameters::start_volts`].
    pub volts: f64,
}

impl Park {
    /// Works it out; `None` where it hangs there already, within a third of a degree.
    ///
    /// # Errors
    /// As [`Click::solve`].
    pub fn solve(&self, parameters: &Parameters) -> Result<Option<Clicked>, Unreachable> {
        let turns = ((self.to - self.from + PI).rem_euclid(TAU) - PI) / TAU;
        if turns.abs() < NEAR {
            return Ok(None);
        }
        let click =
            Click { turns, drive: Drive::Voltage(self.volts), angle: self.from, ending: Ending::Settled };
        click.solve(parameters).map(Some)
    }
}
