//! What stands between sound card and actuator.

use super::device::{Coupling, read_coupling};
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;
use crate::text::{Problem, Span};

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
    /// The voltage of its supply one way or the other, or a short circuit: a full bridge with one line that switches it on and one that says
    /// which way. Means in between are made by the width of pulses that begin every so many samples of the device.
    Bridge {
        /// Samples from pulse to pulse, 2 to 4096.
        period: u32,
    },
}

/// Samples from pulse to pulse where nothing is said.
const PERIOD: u64 = 16;

/// Its keys.
pub static TABLE: Table = Table {
    name: "amplifier",
    doc: "What stands between sound card and actuator.",
    fields: &[
        Field::new(
            "gain",
            Form::any_number(-1e4, 1e4),
            "V/V or A/V",
            "Output over input; required but of a bridge, which has none.",
        ),
        Field::new("max_volts", Form::any_number(1e-3, 1e4), "V", "The most it can give."),
        Field::new(
            "drive",
            Form::Word(&["voltage", "current", "bridge"]),
            "",
            "What it imposes on the actuator: a voltage, a current, or pulses of its supply (`max_volts`) that are as wide as the volts wanted.",
        ),
        Field::new(
            "period",
            Form::count(PERIOD, 2, 4096),
            "samples",
            "Of a bridge: from pulse to pulse. It switches at the device's rate over this, in as many steps of voltage.",
        ),
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
    let drive = match reader.word("drive") {
        0 => Drive::Voltage,
        1 => Drive::Current,
        _ => Drive::Bridge {
            period: u32::try_from(reader.count("period").unwrap_or(PERIOD)).unwrap_or(u32::MAX),
        },
    };
    let is_bridge = matches!(drive, Drive::Bridge { .. });
    if !is_bridge && !reader.has("gain") {
        let what = format!("{} lacks `gain`", reader.who);
        let help = "add gain = 1.0: output over input, V/V or A/V".to_string();
        reader.sink.push(Problem::error(&reader.span, what).help(help));
    }
    for (key, of) in [("gain", "no bridge"), ("period", "a bridge")] {
        if reader.has(key) && is_bridge == (key == "gain") {
            let what = format!("{} has `{key}`, which is for what is {of}", reader.who);
            reader.sink.push(Problem::error(&reader.span_of(key), what).help("leave it out".to_string()));
        }
    }
    if is_bridge && !reader.has("max_volts") {
        let what = format!("{} is a bridge and lacks `max_volts`, its supply", reader.who);
        let help = "hold a meter to it and write, say, max_volts = 5.0".to_string();
        reader.sink.push(Problem::error(&reader.span, what).help(help));
    }
    Amplifier {
        name: name.into(),
        gain: reader.number("gain").unwrap_or(1.0),
        max_volts: reader.number("max_volts"),
        drive,
        max_amperes: reader.number("max_amperes"),
        coupling: read_coupling(reader),
        span: reader.span.clone(),
    }
}
