//! What a force-feedback knob bears and feels like, as pictures.

pub mod curve;
pub mod map;
