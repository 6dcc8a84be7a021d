//! Error against run time: what a scene should have been, and how far off it is; what actuators do under drives; what
//! a knob bears and does; pictures.

pub mod actuators;
pub mod align;
mod compare;
pub mod cost;
pub mod decimate;
mod hearing;
pub mod knob;
pub mod measure;
pub mod motion;
mod moved;
pub mod plot;
mod reference;

pub use compare::{Comparison, compare};
pub use measure::{Measured, Take, measure};
pub use reference::{Played, Reference, reference, reference_watched};
