//! What moves.

use crate::text::Span;

/// An actuator, `[actuator.NAME]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Actuator {
    /// Its name.
    pub name: String,
    /// What it is.
    pub model: Model,
    /// Resonance, Hz; `None`: unknown.
    pub resonance: Option<f64>,
    /// Quality of the resonance; `None`: unknown.
    pub q: Option<f64>,
    /// What it is made for, volts (peak); `None`: unknown.
    pub rated_volts: Option<f64>,
    /// Peaking filters that even it out, in order.
    pub equaliser: Vec<Peak>,
    /// Where it stands.
    pub span: Span,
}

/// What an actuator is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Nothing is known of it.
    Generic,
    /// A voice coil that pushes the skin itself.
    VoiceCoil,
    /// A mass on a spring, moved by a coil: the exciter.
    InertialMotor,
    /// A motor with an eccentric mass.
    RumbleMotor,
    /// A linear resonant actuator.
    Lra,
}

/// A peaking filter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Hz.
    pub frequency: f64,
    /// Gain at that frequency, dB.
    pub gain_db: f64,
    /// Frequency over bandwidth.
    pub q: f64,
}
