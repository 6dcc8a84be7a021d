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
        }
    }
}

impl std::error::Error for Unreachable {}
