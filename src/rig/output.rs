//! A channel of the device and what hangs on it.

use crate::text::Span;

/// An output, `[[output]]`; `[[tactor]]` is the short form for one of kind vibration.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Its name; every output has its own.
    pub name: String,
    /// What goes out of it.
    pub kind: OutputKind,
    /// Channel of the device, from 1, as printed on the card.
    pub channel: u32,
    /// Where on the body, metres; `None`: nowhere in particular, so that no position finds it.
    pub position: Option<[f64; 3]>,
    /// Name of the actuator.
    pub actuator: Option<String>,
    /// Name of the amplifier.
    pub amplifier: Option<String>,
    /// Multiplies what goes out.
    pub gain: f64,
    /// Whether what goes out is turned upside down.
    pub inverted: bool,
    /// Where it stands.
    pub span: Span,
}

/// What goes out of an output.
#[derive(Debug, Clone, PartialEq)]
pub enum OutputKind {
    /// Vibration for the skin, band-limited to 1 kHz.
    Vibration,
    /// A motor's voltage.
    Drive,
    /// A knob's torque.
    Torque,
    /// Pulses at markers: all of them, or those of one name.
    Trigger {
        /// Name of the marker; `None`: all.
        marker: Option<String>,
        /// Length of the pulse, seconds.
        pulse: f64,
    },
    /// Samples as they come, past the band limit.
    Raw,
}
