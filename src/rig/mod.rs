//! The rig: what people write about their hardware. Device, amplifiers, actuators, and where on the body each tactor sits.

pub(crate) mod actuator;
mod amplifier;
mod bounds;
pub(crate) mod calibration;
mod coil;
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

use std::collections::{HashMap, HashSet};

use crate::text::document;
use crate::text::field::{Field, Form, Table};
use crate::text::nearest::suggest;
use crate::text::reader::Reader;
use crate::text::sink::Sink;
use crate::text::{Checked, Problem, Problems};

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

    /// That no body is so large, where positions were written in millimetres, say: once for the whole rig.
    fn too_large(&self) -> Option<Problem> {
        let far = |o: &Output| o.position.and_then(|p| p.into_iter().find(|x| x.abs() > BODY));
        let (output, x) = self.outputs.iter().find_map(|o| Some((o, far(o)?)))?;
        let what = format!(
            "output `{}` has {x} in its position: positions are metres, so that is {} m away",
            output.name,
            x.abs()
        );
        let help = format!("if {x} is millimetres, write {}", x / 1000.0);
        Some(Problem::warning(&output.span, what).help(help))
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
        let coupled = self.device.coupling == Some(Coupling::Dc);
        coupled.then(|| output.kind != OutputKind::Vibration || output.dc)
    }

    /// That a card with capacitors lets nothing steady through, whatever is said of an output.
    fn contradiction(&self) -> Option<Problem> {
        let Some(Coupling::HighPass(corner)) = self.device.coupling else { return None };
        let output = self.outputs.iter().find(|output| output.dc)?;
        let what = format!(
            "output `{}` has dc = true, but the device lets nothing steady through: its coupling is a high-pass at {corner} Hz",
            output.name
        );
        let help =
            "leave `dc` out, or say coupling = \"dc\" if the device lets steady voltages through".to_string();
        Some(Problem::warning(&output.span, what).help(help))
    }

    /// Amplifiers that make of full scale what none does.
    fn out_of_scale(&self) -> impl Iterator<Item = Problem> {
        let device = self.device.full_scale_volts;
        let told = move |amplifier: &Amplifier| {
            let amount = (device? * amplifier.gain).abs();
            if amplifier.drive == Drive::Current || amount == 0.0 || (SCALE[0]..=SCALE[1]).contains(&amount) {
                return None;
            }
            let what = format!(
                "amplifier `{}` makes {amount:.1e} V of `full_scale_volts`, but must make within {:.0e} and {:.0e} V of it",
                amplifier.name, SCALE[0], SCALE[1]
            );
            let help = "`gain` is its output over its input: 10 for 20 dB".to_string();
            Some(Problem::error(&amplifier.span, what).help(help))
        };
        self.amplifiers.iter().filter_map(told).take(Sink::MOST)
    }

    /// What is wrong with it as a whole: channels that the device lacks or that are taken twice, names that nothing has.
    pub fn check(&self) -> Vec<Problem> {
        self.checked(false)
    }

    fn checked(&self, is_draft: bool) -> Vec<Problem> {
        let mut problems = Vec::new();
        if self.device.channels == 0 || self.device.channels > MAX_CHANNELS {
            let what = format!(
                "the device has {} channels; it may have from 1 to {MAX_CHANNELS}",
                self.device.channels
            );
            problems.push(Problem::of_file(what));
        }
        problems.extend(self.too_large());
        problems.extend(self.contradiction());
        problems.extend(self.rectified());
        problems.extend(self.out_of_scale());
        problems.extend(self.check_groups());
        problems.extend(self.torque_way());
        let told = |output: &&Output| !(is_draft && self.is_unfinished(output));
        let wired = self.outputs.iter().filter(told).filter_map(|output| self.wiring(output)?.err());
        problems.extend(wired.take(Sink::MOST));
        let measured = self.outputs.iter().filter_map(|output| self.calibrated(output));
        problems.extend(measured.take(Sink::MOST));
        let (mut names, mut channels) = (HashMap::new(), HashMap::new());
        let actuators: HashSet<&str> = self.actuators.iter().map(|a| a.name.as_str()).collect();
        let amplifiers: HashSet<&str> = self.amplifiers.iter().map(|a| a.name.as_str()).collect();
        for output in &self.outputs {
            if problems.len() >= Sink::MOST {
                break;
            }
            let name = output.name.as_str();
            if !name.is_empty() && names.insert(name, ()).is_some() {
                let help = "every output has its own name".to_string();
                problems.push(
                    Problem::error(&output.span, format!("there are two outputs called `{name}`")).help(help),
                );
            }
            // 0 stands for a channel that cannot be read, which has been said.
            if output.channel > self.device.channels {
                let what = format!(
                    "output `{name}` is on channel {}, the device has {}",
                    output.channel, self.device.channels
                );
                let help =
                    "channels count from 1; `channels` of the device says how many there are".to_string();
                problems.push(Problem::error(&output.channel_span, what).help(help));
            } else if let OutputKind::Drive(Turning { direction: Some(line), .. }) = output.kind
                && line > self.device.channels
            {
                let what = format!(
                    "output `{name}` has its direction on channel {line}, the device has {}",
                    self.device.channels
                );
                problems.push(Problem::error(&output.span, what));
            } else if output.channel > 0
                && let Some(other) = channels.insert(output.channel, name)
            {
                let what = format!("outputs `{other}` and `{name}` are both on channel {}", output.channel);
                problems.push(Problem::error(&output.channel_span, what));
            } else if output.channel == 0 && output.span.is_empty() {
                problems.push(Problem::error(
                    &output.span,
                    format!("output `{name}` is on channel 0; channels count from 1"),
                ));
            }
            if let OutputKind::Drive(Turning { direction: Some(line), .. }) = output.kind
                && line <= self.device.channels
                && let Some(other) = channels.insert(line, name)
            {
                let what =
                    format!("output `{name}` has its direction on channel {line}, on which is `{other}`");
                problems.push(Problem::error(&output.span, what));
            }
            if let Some(wanted) = output.actuator.as_deref().filter(|n| !actuators.contains(n)) {
                let what = format!("output `{name}` has an actuator `{wanted}`, which is not there");
                problems
                    .push(Problem::error(&output.span, what).help(missing(wanted, "actuator", &actuators)));
            }
            if let Some(wanted) = output.amplifier.as_deref().filter(|n| !amplifiers.contains(n)) {
                let what = format!("output `{name}` has an amplifier `{wanted}`, which is not there");
                problems.push(Problem::error(&output.span, what).help(missing(
                    wanted,
                    "amplifier",
                    &amplifiers,
                )));
            }
        }
        problems
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

/// What an amplifier makes of full scale, V.
const SCALE: [f64; 2] = [1e-6, 1e6];

/// Metres from the origin within which all of a body lies.
const BODY: f64 = 3.0;

fn line(channels: u32) -> Vec<Output> {
    (1..=channels).map(|n| Output::tactor(&format!("t{n}"), n, [0.04 * f64::from(n - 1), 0.0, 0.0])).collect()
}

fn missing(word: &str, kind: &str, names: &HashSet<&str>) -> String {
    suggest(word, names.iter().copied()).unwrap_or_else(|| format!("describe it under [{kind}.{word}]"))
}

#[cfg(test)]
mod tests {
    use super::Rig;

    #[test]
    fn an_amplifier_out_of_scale_is_told_where_it_stands() {
        let of = |volts: f64, gain: f64, drive: &str| {
            let rig = format!(
                "format = \"pacinian-rig/1\"\ntitle = \"T\"\n[device]\nchannels = 1\nfull_scale_volts = {volts:?}\n[amplifier.big]\n\
                 gain = {gain:?}\n{drive}\n[[tactor]]\nname = \"a\"\nchannel = 1\namplifier = \"big\"\n"
            );
            Rig::parse("r.toml", rig.as_bytes()).map(|_| ()).map_err(|problems| problems.to_string())
        };
        for (volts, gain) in [(1000.0, 1001.0), (1000.0, -1001.0), (1e-3, 0.9e-3)] {
            let told = of(volts, gain, "").unwrap_err();
            assert!(told.starts_with("r.toml:6") && told.contains("amplifier `big` makes"), "{told}");
        }
        assert_eq!(of(1000.0, -1000.0, ""), Ok(()));
        assert_eq!(of(1000.0, 1001.0, "drive = \"current\""), Ok(()));
    }
}
