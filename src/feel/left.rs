//! What of a model was left out, and why.

use std::fmt;

use crate::actuator::motor;

/// What of a model was left out, and why.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Left {
    /// A part of a motor.
    Motor(motor::LeftOut),
    /// The inductance of a coil: within the band of its output it changes what is felt by no more than this share.
    Small(f64),
    /// The inductance of a coil: a source imposes the current, whatever voltage that takes.
    Imposed,
}

impl fmt::Display for Left {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Motor(left) => left.fmt(f),
            Self::Small(share) => write!(f, "inductance: it changes what is felt by {share:.2e} at most"),
            Self::Imposed => write!(f, "inductance: the amplifier imposes the current, whatever that takes"),
        }
    }
}
