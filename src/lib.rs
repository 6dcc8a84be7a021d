//! pacinian plays the skin the way a synthesizer plays the ear.

#![warn(missing_docs)]

pub mod dsp;
pub mod engine;
pub mod graph;
#[cfg(feature = "io")]
pub mod io;
pub mod node;
pub mod patch;
pub mod player;
#[cfg(feature = "report")]
pub mod report;
pub mod rig;
pub mod schedule;
pub mod score;
pub mod text;
