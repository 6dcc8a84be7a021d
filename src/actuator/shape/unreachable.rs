//! Why a wish cannot be granted.

use std::fmt;

use crate::actuator::fault::Fault;
use crate::actuator::motor::Drive;

/// What a motor cannot do, or what is no wish.
#[derive(Debug, Clone, PartialEq)]
pub enum Unreachable {
    /// A number of the motor or of the wish is beyond its limits.
    Fault(Fault),
    /// The drive does not start the motor from where it hangs; the other one starts it from anywhere.
    Start(Drive, Drive),
    /// By this drive it never gets that far, or that fast: it would take more than so many seconds.
    Slow(Drive, f64),
    /// Gravity does not bring its mass to rest within so many seconds, however slowly it creeps.
    Adrift(f64),
    /// Let go, its mass swings for more than so many seconds.
    Swings(f64),
    /// Gravity brings its mass to rest, but anywhere within so much of a place, rad.
    Loose(f64),
}

impl From<Fault> for Unreachable {
    fn from(fault: Fault) -> Self {
        Self::Fault(fault)
    }
}

impl fmt::Display for Unreachable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fault(fault) => fault.fmt(f),
            Self::Start(drive, needed) => {
                write!(f, "{drive} do not start the motor; from wherever its mass hangs, {needed} do")
            }
            Self::Slow(drive, seconds) => {
                write!(
                    f,
                    "at {drive} the motor does not get there within {seconds} s: wish for less, or give it more"
                )
            }
            Self::Adrift(seconds) => {
                write!(
                    f,
                    "gravity does not catch its mass within {seconds} s: upright (tilt = 0.0) it is heaviest"
                )
            }
            Self::Swings(seconds) => {
                write!(
                    f,
                    "let go, its mass swings for more than {seconds} s: hardly any friction or back-EMF damps it"
                )
            }
            Self::Loose(spread) => {
                write!(
                    f,
                    "its mass would come to rest anywhere within {:.0} degrees of a place: it is too light for gravity to catch it; \
                     upright (tilt = 0.0) it is heaviest",
                    spread.to_degrees()
                )
            }
        }
    }
}

impl std::error::Error for Unreachable {}
