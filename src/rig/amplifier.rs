//! What stands between sound card and actuator.

use crate::text::Span;

/// An amplifier, `[amplifier.NAME]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Amplifier {
    /// Its name.
    pub name: String,
    /// Output over input: a ratio for voltage drive, amperes per volt for current drive.
    pub gain: f64,
    /// Most it can give, volts; `None`: unknown.
    pub max_volts: Option<f64>,
    /// What it imposes on the actuator.
    pub drive: Drive,
    /// Most it can give, amperes; `None`: unknown.
    pub max_amperes: Option<f64>,
    /// Where it stands.
    pub span: Span,
}

/// What an amplifier imposes on the actuator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Drive {
    /// A voltage.
    Voltage,
    /// A current.
    Current,
}
