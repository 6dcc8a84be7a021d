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
    /// What stands behind it, to make a steady voltage of a carrier; `None`: nothing.
    pub rectifier: Option<Rectifier>,
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

/// Diodes behind an amplifier, for motors on cards and amplifiers that let nothing steady through: what is meant for the motor
/// leaves the card as the amplitude of a carrier.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rectifier {
    /// The carrier, Hz.
    pub carrier: f64,
    /// Volts that the diodes in the path take together.
    pub drop: f64,
    /// Whether both half-waves pass: four diodes instead of one.
    pub bridge: bool,
}

/// The keys of a rectifier.
pub static RECTIFIER: Table = Table {
    name: "rectifier",
    doc: "Diodes behind an amplifier: they make a steady voltage, of one sign, of a carrier.",
    fields: &[
        Field::new(
            "carrier",
            Form::any_number(200.0, 96_000.0),
            "Hz",
            "The carrier; below half the device's rate.",
        )
        .required(),
        Field::new("drop", Form::number(1.4, 0.0, 10.0), "V", "What the diodes in the path take together."),
        Field::new(
            "bridge",
            Form::Flag(true),
            "",
            "Whether both half-waves pass: four diodes instead of one.",
        ),
    ],
    others: None,
};

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
        Field::new(
            "rectifier",
            Form::One(&RECTIFIER),
            "",
            "Diodes behind it, for a motor that it could not turn otherwise.",
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
        rectifier: reader.one("rectifier", format!("the rectifier of {}", reader.who)).and_then(|r| {
            Some(Rectifier {
                carrier: r.number("carrier")?,
                drop: r.number_or_default("drop"),
                bridge: r.flag("bridge"),
            })
        }),
        span: reader.span.clone(),
    }
}
