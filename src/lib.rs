//! pacinian plays the skin the way a synthesizer plays the ear.

#![warn(missing_docs)]

pub mod dsp;
pub mod engine;
pub mod node;
