//! pacinian plays the skin the way a synthesizer plays the ear.

#![warn(missing_docs)]

pub mod dsp;
pub mod graph;
pub mod node;
pub mod schedule;
