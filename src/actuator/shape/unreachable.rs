//! Why a wish cannot be granted.

use std::fmt;

use crate::actuator::fault::Fault;

/// What a motor cannot do, or what is no wish.
#[derive(Debug, Clone, PartialEq)]
pub enum Unreachable {
    /// A number of the motor or of the wish is beyond its limits.
    Fault(Fault),
    /// The voltage (V) does not start the motor from where it hangs; this one (V) starts it from anywhere.
    Start(f64, f64),
    /// At this voltage (V) it never gets that far, or that fast: it would take more than so many seconds.
    Slow(f64, f64),
    /// Gravity does not bring its mass to rest within so many seconds, however slowly it creeps.
    Adrift(f64),
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
            Self::Start(volts, needed) => {
                write!(f, "{volts} V do not start the motor; from wherever its mass hangs, {needed:.3} V do")
            }
            Self::Slow(volts, seconds) => {
                write!(
                    f,
                    "at {volts} V the motor does not get there within {seconds} s: wish for less, or give it more"
                )
            }
            Self::Adrift(seconds) => {
                write!(
                    f,
                    "gravity does not catch its mass within {seconds} s: upright (tilt = 0.0) it is heaviest"
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
