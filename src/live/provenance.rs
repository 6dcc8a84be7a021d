//! What a scene was made of: enough to make it again.

use serde::{Deserialize, Serialize};

use crate::graph::plan::Precision;
use crate::graph::scene::Options;

/// What a scene was made of. A journal writes it down, and a replay makes the scene again from it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The patch.
    pub patch: Text,
    /// The rig.
    pub rig: RigText,
    /// The files with tables of calibrations that the rig names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub tables: Vec<Text>,
    /// The folder that paths of the patch count from.
    pub folder: String,
    /// Whether they may leave it.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub allow_outside: bool,
    /// The files that the patch names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<FileDigest>,
    /// The Standard MIDI File that played it, by its path as the person wrote it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub song: Option<FileDigest>,
    /// Controls that stood elsewhere than at their `default` from the beginning.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub set: Vec<(String, f64)>,
    /// The voice that notes of MIDI played, whatever the patch's triggers do: see [`crate::patch::Patch::key`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub notes: Option<String>,
    /// How the two were compiled.
    pub options: Choices,
}

/// A document.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Text {
    /// The name of its file, as the person wrote it.
    pub name: String,
    /// SHA-256 of `text`, in hexadecimal.
    pub sha256: String,
    /// What stands in it.
    pub text: String,
}

/// A rig.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum RigText {
    /// That of a document.
    Text(Text),
    /// [`crate::rig::Rig::default_for`] so many channels.
    Line {
        /// How many.
        line: u32,
    },
}

/// A file that is not written down, and by which it can be known again.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct FileDigest {
    /// As it was named.
    pub path: String,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

/// [`Options`], as a file says them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Choices {
    rate: Option<f64>,
    ratio: Option<usize>,
    double: bool,
    taps: usize,
    seed: Option<u64>,
    pattern: Option<String>,
    live: bool,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    attached: bool,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    block: Option<u32>,
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    on_card: bool,
    #[serde(default, skip_serializing_if = "is_0")]
    knob_channel: usize,
}

fn is_0(count: &usize) -> bool {
    *count == 0
}

impl From<&Options> for Choices {
    fn from(options: &Options) -> Self {
        let Options {
            rate,
            ratio,
            precision,
            taps,
            seed,
            pattern,
            live,
            attached,
            block,
            on_card,
            knob_channel,
        } = options.clone();
        Self {
            rate,
            ratio,
            double: precision == Precision::Double,
            taps,
            seed,
            pattern,
            live,
            attached,
            block,
            on_card,
            knob_channel,
        }
    }
}

impl From<&Choices> for Options {
    fn from(choices: &Choices) -> Self {
        let Choices {
            rate,
            ratio,
            double,
            taps,
            seed,
            pattern,
            live,
            attached,
            block,
            on_card,
            knob_channel,
        } = choices.clone();
        let precision = if double { Precision::Double } else { Precision::Single };
        Self { rate, ratio, precision, taps, seed, pattern, live, attached, block, on_card, knob_channel }
    }
}
