//! pacinian plays the skin the way a synthesizer plays the ear.

#![warn(missing_docs)]

pub mod dsp;
pub mod node;
pub mod patch;
pub mod rig;
pub mod score;
pub mod text;
