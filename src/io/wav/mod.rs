//! WAV files: a writer for arrays of tactors, and a reader that trusts no header.

mod chunks;
mod encode;
mod header;
mod reader;
mod writer;

use crate::io::error::FileError;

pub use encode::{Encoding, UnknownEncoding};
pub use reader::{WavInfo, WavReader};
pub use writer::{REFRESH, WavWriter, Written};

/// What is to be written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct WavSpec {
    /// Channels, at least one.
    pub channels: usize,
    /// Frames a second.
    pub rate: u32,
    /// How a sample is stored.
    pub encoding: Encoding,
    /// Of the dither.
    pub seed: u64,
    /// Of the piece (`INAM`); none if empty. What is behind its first 1,024 bytes is left out.
    pub title: String,
    /// Names of the tactors in the order of the channels, kept as the file's comment (`ICMT`): a line for each, such as
    /// `3: wrist`. None if empty. Of each, 128 bytes at most are kept.
    pub tactors: Vec<String>,
    /// Whether floats beyond ±1 stay as they are: figures in a unit rather than sound. Integers are clamped all the same.
    pub unbounded: bool,
}

impl WavSpec {
    /// A nameless file.
    pub fn new(channels: usize, rate: u32, encoding: Encoding) -> Self {
        Self {
            channels,
            rate,
            encoding,
            seed: 0,
            title: String::new(),
            tactors: Vec::new(),
            unbounded: false,
        }
    }

    /// Whether a WAV file can be like this.
    ///
    /// # Errors
    /// No rate, no channels, or more of them than a header has room for: a frame has less than 64 KiB, a second less than 4 GiB.
    pub fn check(&self) -> Result<(), FileError> {
        header::check(self)
    }
}
