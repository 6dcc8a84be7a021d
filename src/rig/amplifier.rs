//! What stands between sound card and actuator.

use super::device::{Coupling, read_coupling};
use crate::text::Span;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;

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
    /// What it lets through; `None`: unknown.
    pub coupling: Option<Coupling>,
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

/// Its keys.
pub static TABLE: Table = Table {
    name: "amplifier",
    doc: "What stands between sound card and actuator.",
    fields: &[
        Field::new("gain", Form::any_number(-1e4, 1e4), "V/V or A/V", "Output over input.").required(),
        Field::new("max_volts", Form::any_number(1e-3, 1e4), "V", "The most it can give."),
        Field::new("drive", Form::Word(&["voltage", "current"]), "", "What it imposes on the actuator."),
        Field::new("max_amperes", Form::any_number(1e-6, 1e3), "A", "The most it can give."),
        Field::new(
            "coupling",
            Form::Defined("coupling"),
            "",
            "What it lets through: \"dc\", or { high_pass = 8.0 } for a first-order high-pass (Hz). A motor needs \"dc\".",
        ),
    ],
    others: None,
};

pub(crate) fn read(name: &str, reader: &Reader) -> Amplifier {
    Amplifier {
        name: name.into(),
        gain: reader.number_or_default("gain"),
        max_volts: reader.number("max_volts"),
        drive: if reader.word("drive") == 0 { Drive::Voltage } else { Drive::Current },
        max_amperes: reader.number("max_amperes"),
        coupling: read_coupling(reader),
        span: reader.span.clone(),
    }
}
