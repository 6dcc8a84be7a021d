//! pacinian plays the skin the way a synthesizer plays the ear.

#![warn(missing_docs)]

pub mod dsp;
#[cfg(feature = "io")]
pub mod io;
pub mod node;
