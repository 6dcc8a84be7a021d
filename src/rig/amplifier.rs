//! What stands between sound card and actuator.

use super::device::{Coupling, read_coupling};
use crate::actuator::link::carrier::{Carrier, Rectifier};
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
    /// What it gives beside that, volts, whatever comes in: for piezos.
    pub bias: f64,
    /// What it lets through; `None`: unknown.
    pub coupling: Option<Coupling>,
    /// Where it stands.
    pub span: Span,
}

/// What an amplifier imposes on the actuator.
#[derive(Debug, Clone, Copy, PartialEq)]
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
    /// The voltage of a carrier through diodes: what it is on average, one way. It passes where nothing steady does.
    Carrier(Carrier),
}

/// Samples from pulse to pulse where nothing is said.
const PERIOD: u64 = 16;

/// Hertz of a carrier where nothing is said, and the least and the most there may be: no motor and no skin follows so fast.
const CARRIER: [f64; 3] = [4000.0, 2000.0, 40_000.0];

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
            Form::Word(&["voltage", "current", "bridge", "carrier"]),
            "",
            "What it imposes on the actuator: a voltage, a current, pulses of its supply (`max_volts`) that are as wide as the volts wanted, or what a rectifier behind it makes of a carrier that is as large as it takes.",
        ),
        Field::new(
            "period",
            Form::count(PERIOD, 2, 4096),
            "samples",
            "Of a bridge: from pulse to pulse. It switches at the device's rate over this, in as many steps of voltage.",
        ),
        Field::new(
            "carrier",
            Form::number(CARRIER[0], CARRIER[1], CARRIER[2]),
            "Hz",
            "Of a carrier: its frequency, at most 0.45 of the device's rate. The filter behind a card's converter makes the same of any; where there is none, 3700 Hz at 48 kHz comes nearer than 4000 Hz does, and nothing above comes near.",
        ),
        Field::new(
            "rectifier",
            Form::Word(&["full-wave", "half-wave"]),
            "",
            "Of a carrier: what stands between amplifier and motor. Full-wave: four diodes, of which two are in the path; half-wave: one.",
        ),
        Field::new(
            "diode_drop",
            Form::any_number(0.0, 10.0),
            "V",
            "Of a carrier: what the diodes in the path take together; required there. A silicon diode takes 0.7 V, a Schottky diode 0.3 V.",
        ),
        Field::new(
            "max_amperes",
            Form::any_number(1e-6, 1e3),
            "A",
            "The most it can give. A motor at a voltage gets no more than that leaves for its brake from full speed.",
        ),
        Field::new(
            "bias",
            Form::number(0.0, -1e4, 1e4),
            "V",
            "What it gives beside that, whatever comes in. Amplifiers for piezos have one that give no voltage below 0; nothing else bears it.",
        ),
        Field::new(
            "coupling",
            Form::Defined("coupling"),
            "",
            "What it lets through: \"dc\", or { high_pass = 8.0 } for a first-order high-pass (Hz). A motor needs \"dc\", or a carrier; clicks alone pass any that is known.",
        ),
    ],
    others: None,
};

pub(crate) fn read(name: &str, reader: &Reader) -> Amplifier {
    let drive = match reader.word("drive") {
        0 => Drive::Voltage,
        1 => Drive::Current,
        3 => Drive::Carrier(Carrier {
            hertz: reader.number_or_default("carrier"),
            rectifier: Rectifier {
                full_wave: reader.word("rectifier") == 0,
                drop: reader.number("diode_drop").unwrap_or(0.0),
            },
        }),
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
    let is_carrier = matches!(drive, Drive::Carrier(_));
    for (key, of, has) in [
        ("gain", "no bridge", !is_bridge),
        ("period", "a bridge", is_bridge),
        ("carrier", "a carrier", is_carrier),
        ("rectifier", "a carrier", is_carrier),
        ("diode_drop", "a carrier", is_carrier),
    ] {
        if reader.has(key) && !has {
            let what = format!("{} has `{key}`, which is for what is {of}", reader.who);
            reader.sink.push(Problem::error(&reader.span_of(key), what).help("leave it out".to_string()));
        }
    }
    if is_bridge && !reader.has("max_volts") {
        let what = format!("{} is a bridge and lacks `max_volts`, its supply", reader.who);
        let help = "hold a meter to it and write, say, max_volts = 5.0".to_string();
        reader.sink.push(Problem::error(&reader.span, what).help(help));
    }
    if is_carrier && !reader.has("diode_drop") {
        let what = format!("{} has a rectifier and lacks `diode_drop`, what its diodes take", reader.who);
        let help =
            "two silicon diodes, as in a bridge: diode_drop = 1.4; a Schottky diode takes 0.3 V".to_string();
        reader.sink.push(Problem::error(&reader.span, what).help(help));
    }
    Amplifier {
        name: name.into(),
        gain: reader.number("gain").unwrap_or(1.0),
        max_volts: reader.number("max_volts"),
        drive,
        max_amperes: reader.number("max_amperes"),
        bias: reader.number_or_default("bias"),
        coupling: read_coupling(reader),
        span: reader.span.clone(),
    }
}
