//! The sound card.

use super::MAX_CHANNELS;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;

/// The sound card, `[device]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Device {
    /// As the system calls it; `None`: the default one.
    pub name: Option<String>,
    /// The device that is listened to, as the system calls it; `None`: none.
    pub input: Option<String>,
    /// How many channels it has.
    pub channels: u32,
    /// Samples a second; `None`: whatever is asked for.
    pub rate: Option<f64>,
    /// Volts at a sample of 1.0; `None`: unknown, and then no figure in volts is given.
    pub full_scale_volts: Option<f64>,
    /// What its outputs let through; `None`: nothing is known, and it is taken to let no steady voltage through.
    pub coupling: Option<Coupling>,
    /// The most that leaves any of its outputs, as a share of full scale.
    pub max_level: f64,
    /// Seconds that pass beyond what the system says from an output through what hangs on it back to an input; `None`: not measured.
    pub loop_latency: Option<f64>,
}

impl Device {
    /// The default one, of so many channels, of which nothing more is known.
    pub(crate) fn of(channels: u32) -> Self {
        Self {
            name: None,
            input: None,
            channels,
            rate: None,
            full_scale_volts: None,
            coupling: None,
            max_level: 1.0,
            loop_latency: None,
        }
    }

    /// Whether its outputs let steady voltages through; `unsaid` where the rig does not say.
    pub(crate) fn passes_steady(&self, unsaid: bool) -> bool {
        self.coupling.map_or(unsaid, |coupling| coupling == Coupling::Dc)
    }
}

/// The least and the most samples a second that a device may have.
pub const RATES: [f64; 2] = [6_000.0, 768_000.0];

/// Device frames for each engine sample at a device rate (Hz), where nothing says another number: the engine runs at about 8 kHz.
pub fn usual_ratio(rate: f64) -> usize {
    (rate / 8000.0).round().max(1.0) as usize
}

/// The least and the most that `max_level` may be.
pub(crate) const LEVELS: [f64; 2] = [1e-4, 1.0];

/// What an output lets through.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Coupling {
    /// Everything down to steady voltages.
    Dc,
    /// A first-order high-pass at so many hertz.
    HighPass(f64),
}

/// The key of the device and of each output.
pub(super) const MAX_LEVEL: Field = Field::new(
    "max_level",
    Form::number(1.0, LEVELS[0], LEVELS[1]),
    "",
    "The most that leaves, as a share of full scale; of the device's and the output's own the lower one holds.",
);

/// Its keys.
pub static TABLE: Table = Table {
    name: "device",
    doc: "The sound card.",
    fields: &[
        Field::new(
            "name",
            Form::Text,
            "",
            "What the system calls it; the default one where nothing is said.",
        ),
        Field::new(
            "input",
            Form::Text,
            "",
            "The device that nodes `input` hear when it is played live, as the system calls it, or \"default\"; silence where nothing is said.",
        ),
        Field::new("channels", Form::any_count(1, MAX_CHANNELS as u64), "", "How many channels it has.")
            .required(),
        Field::new(
            "rate",
            Form::any_number(RATES[0], RATES[1]),
            "Hz",
            "Samples a second; whatever is asked for where nothing is said.",
        ),
        Field::new(
            "full_scale_volts",
            Form::any_number(1e-6, 1e4),
            "V",
            "Voltage (peak) at a sample of 1.0; figures in volts are given only where it is known.",
        ),
        Field::new(
            "coupling",
            Form::Defined("coupling"),
            "",
            "What its outputs let through: \"dc\", or { high_pass = 8.0 } for a first-order high-pass (Hz). With \"dc\", a steady voltage leaves only on outputs that are declared for it.",
        ),
        MAX_LEVEL,
        Field::new(
            "loop_latency",
            Form::any_number(-0.1, 10.0),
            "s",
            "From an output through what hangs on it back to an input, beyond what the system says: `pacinian latency` measures it.",
        ),
    ],
    others: None,
};

/// The keys of a coupling that is not DC.
pub static COUPLING: Table = Table {
    name: "high-pass",
    doc: "A first-order high-pass.",
    fields: &[Field::new("high_pass", Form::any_number(1e-3, 1000.0), "Hz", "Its corner.").required()],
    others: None,
};

/// What the key `coupling` says.
pub(super) fn read_coupling(reader: &Reader) -> Option<Coupling> {
    reader.at("coupling").and_then(|value| match (value.text(), value.table()) {
        (Some("dc"), _) => Some(Coupling::Dc),
        (_, Some(entries)) => {
            let who = format!("`coupling` of {}", reader.who);
            Reader::new(&COUPLING, entries, value.span(), who, reader.sink)
                .number("high_pass")
                .map(Coupling::HighPass)
        }
        _ => {
            reader.mistaken("coupling", &value, "\"dc\" or { high_pass = 8.0 }");
            None
        }
    })
}

pub(crate) fn read(reader: &Reader) -> Device {
    Device {
        name: reader.text("name").map(Into::into),
        input: reader.text("input").map(Into::into),
        channels: reader.count("channels").and_then(|n| u32::try_from(n).ok()).unwrap_or(MAX_CHANNELS),
        rate: reader.number("rate"),
        full_scale_volts: reader.number("full_scale_volts"),
        coupling: read_coupling(reader),
        max_level: reader.number_or_default("max_level"),
        loop_latency: reader.number("loop_latency"),
    }
}
