//! The rig: what people write about their hardware. Device, amplifiers, actuators, and where on the body each tactor sits.

pub(crate) mod actuator;
mod amplifier;
mod bounds;
pub(crate) mod calibration;
mod check;
mod coil;
mod contradiction;
pub(crate) mod device;
mod even;
mod finder;
pub(crate) mod group;
pub mod knob;
mod motor;
pub(crate) mod output;
pub mod part;
pub(crate) mod quantity;
pub mod reference;
mod resolve;
pub mod rise;
mod schema;
pub(crate) mod terminals;
mod way;

pub use crate::actuator::driver::setup::Shaping;
pub use actuator::{Actuator, Model, Peak};
pub use amplifier::{Amplifier, Drive};
pub use calibration::Calibration;
pub use device::{Coupling, Device, RATES, usual_ratio};
pub use even::Even;
pub use finder::Finder;
pub use group::Group;
pub use knob::Knob;
pub use motor::{Lack, Wiring};
pub use output::{Output, OutputKind, Turning};
pub use schema::schema;
pub use terminals::{Bridge, Terminals};

/// The most channels a device may have.
pub use crate::patch::place::MAX_CHANNELS;

use crate::text::document;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;
use crate::text::{Checked, Problems};

/// A rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Rig {
    /// What it is called.
    pub title: String,
    /// What it is about; may be empty.
    pub description: String,
    /// The sound card.
    pub device: Device,
    /// Amplifiers, in the order of the file.
    pub amplifiers: Vec<Amplifier>,
    /// Actuators, in the order of the file.
    pub actuators: Vec<Actuator>,
    /// Outputs, tactors among them: tactors first, then `[[output]]`s, each in the order of the file.
    pub outputs: Vec<Output>,
    /// Groups of tactors, in the order of the file.
    pub groups: Vec<Group>,
    /// Calibrations of tactors, in the order of the file.
    pub calibrations: Vec<Calibration>,
    /// The force-feedback knob; `None`: a patch that wants one is given a small one, simulated.
    pub knob: Option<Knob>,
}

/// The format that this version reads.
pub const FORMAT: &str = "pacinian-rig/1";

/// Its keys.
pub(crate) static TABLE: Table = Table {
    name: "rig",
    doc: "Hardware: a device, amplifiers, actuators, and where on the body each tactor sits.",
    fields: &[
        Field::new("format", Form::Defined("format"), "", "The format and its version.").required(),
        Field::new("title", Form::Text, "", "What it is called."),
        Field::new("description", Form::Text, "", "What it is about."),
        Field::new("device", Form::One(&device::TABLE), "", "The sound card.").required(),
        Field::new("amplifier", Form::Named(&amplifier::TABLE), "", "Amplifiers, by name."),
        Field::new("actuator", Form::Named(&actuator::TABLE), "", "Actuators, by name."),
        Field::new(
            "tactor",
            Form::Many(&output::TACTOR),
            "",
            "Tactors. With neither tactors nor outputs, there is a line of them, one on each channel.",
        ),
        Field::new("output", Form::Many(&output::TABLE), "", "Outputs of any kind."),
        Field::new("group", Form::Named(&group::TABLE), "", "Tactors that go by one name, by that name."),
        Field::new(
            "calibration",
            Form::Named(&calibration::TABLE),
            "",
            "What tactors were measured to give, by name.",
        ),
        Field::new("knob", Form::One(&knob::table::TABLE), "", "The force-feedback knob."),
    ],
    others: None,
};

impl Rig {
    /// Reads a rig from the bytes of a file called `name`. A rig with no outputs gets those of [`Rig::default_for`].
    ///
    /// # Errors
    /// Every problem of the file at once, each with its place.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Checked<Self>, Problems> {
        Self::parsed(name, bytes, false)
    }

    /// As [`Rig::parse`], but figures of a motor may be missing that its output of kind drive needs: for those who are about to measure them.
    ///
    /// # Errors
    /// As [`Rig::parse`], for everything else.
    pub fn draft(name: &str, bytes: &[u8]) -> Result<Checked<Self>, Problems> {
        Self::parsed(name, bytes, true)
    }

    fn parsed(name: &str, bytes: &[u8], is_draft: bool) -> Result<Checked<Self>, Problems> {
        document::read(name, bytes, FORMAT, |document, sink| {
            let reader = Reader::new(&TABLE, document, 0..0, "the rig", sink);
            let mut rig = Self::read(&reader);
            for problem in rig.checked(is_draft) {
                sink.push(problem);
            }
            if !reader.has("tactor") && !reader.has("output") {
                rig.outputs = line(rig.device.channels);
            }
            rig
        })
    }

    /// A rig for those who have none: `channels` tactors `t1`, `t2`, ... in a line, 40 mm apart, on channels 1, 2, ... There are
    /// at most [`MAX_CHANNELS`].
    pub fn default_for(channels: u32) -> Self {
        let channels = channels.min(MAX_CHANNELS);
        Self {
            title: "A line of tactors".into(),
            description: String::new(),
            device: Device::of(channels),
            amplifiers: Vec::new(),
            actuators: Vec::new(),
            outputs: line(channels),
            groups: Vec::new(),
            calibrations: Vec::new(),
            knob: None,
        }
    }

    /// The actuator of that name.
    pub fn actuator(&self, name: &str) -> Option<&Actuator> {
        self.actuators.iter().find(|a| a.name == name)
    }
    /// The amplifier of that name.
    pub fn amplifier(&self, name: &str) -> Option<&Amplifier> {
        self.amplifiers.iter().find(|a| a.name == name)
    }

    /// The most that leaves an output, as a share of full scale: the lower of the device's and its own.
    pub fn max_level(&self, output: &Output) -> f64 {
        self.device.max_level.min(output.max_level)
    }

    /// Whether a steady voltage that is played on an output leaves the device; `None` where the device is not known to let any through,
    /// so that it takes care of that itself.
    pub fn lets_dc(&self, output: &Output) -> Option<bool> {
        self.device.passes_steady(false).then(|| output.is_for_dc())
    }

    fn read(reader: &Reader) -> Self {
        let device = reader.one("device", "the device").map(|r| device::read(&r));
        let amplifiers = reader.named("amplifier", "amplifier");
        let actuators = reader.named("actuator", "actuator");
        let tactors = reader.many("tactor", |n| format!("tactor {n}"));
        let outputs = reader.many("output", |n| format!("output {n}"));
        let groups = reader.named("group", "group");
        let calibrations = reader.named("calibration", "calibration");
        Self {
            title: reader.text("title").unwrap_or("").into(),
            description: reader.text("description").unwrap_or("").into(),
            device: device.unwrap_or(Device::of(MAX_CHANNELS)),
            amplifiers: amplifiers.iter().map(|(name, r)| amplifier::read(name, r)).collect(),
            actuators: actuators.iter().map(|(name, r)| actuator::read(name, r)).collect(),
            outputs: tactors
                .iter()
                .map(|r| output::read(r, true))
                .chain(outputs.iter().map(|r| output::read(r, false)))
                .collect(),
            groups: groups.iter().map(|(name, r)| group::read(name, r)).collect(),
            calibrations: calibrations.iter().map(|(name, r)| calibration::read(name, r)).collect(),
            knob: reader.one("knob", "the knob").map(|r| knob::read(&r)),
        }
    }
}

fn line(channels: u32) -> Vec<Output> {
    (1..=channels).map(|n| Output::tactor(&format!("t{n}"), n, [0.04 * f64::from(n - 1), 0.0, 0.0])).collect()
}
