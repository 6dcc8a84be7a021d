//! What a channel of what is felt holds.

use std::fmt;

/// What is felt is told in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Acceleration, m/s².
    Acceleration,
    /// Force on what holds it, N: of a motor of which is not known how much moves with it.
    Force,
}

impl Unit {
    /// As it is printed: "m/s2", "N".
    pub fn word(self) -> &'static str {
        match self {
            Self::Acceleration => "m/s2",
            Self::Force => "N",
        }
    }
}

/// What moves, and along what.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Axis {
    /// The contactor of a voice coil, along its axis, towards what a positive sample moves it to.
    Contactor,
    /// The casing of an inertial motor or a linear resonant actuator, along its axis; it goes against its slug.
    Casing,
    /// The casing of a rumble motor, across: level, in the plane in which its mass spins.
    Across,
    /// The same, upright: upwards in that plane.
    Upright,
}

impl Axis {
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Contactor => "contactor",
            Self::Casing => "casing",
            Self::Across => "across",
            Self::Upright => "upright",
        }
    }
}

/// A channel of what is felt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trace {
    /// Name of the output.
    pub output: String,
    /// What moves there.
    pub axis: Axis,
    /// Of its samples.
    pub unit: Unit,
}

impl fmt::Display for Trace {
    /// "wrist, across, m/s2".
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {}, {}", self.output, self.axis.word(), self.unit.word())
    }
}
