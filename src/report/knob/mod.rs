//! What a force-feedback knob bears, does, and costs: figures, comma-separated values, pictures.
//!
//! | file | holds |
//! |---|---|
//! | [`map`] | which stiffness beside which computed damping a device bears, what was asked of it and what is left of that |
//! | [`course`] | what a run recorded, in a bounded size however long it is |
//! | [`curve`] | torque and potential energy over angle |
//! | [`mod@race`] | error against run time of the plant, other integrators and other models of friction |
//! | [`mod@estimators`] | error, noise and lag against run time of velocity estimators |
//!
//! Each is figures first; its CSV and its SVG are written from those.

pub mod course;
pub mod curve;
pub mod estimators;
pub mod map;
pub mod race;

pub use estimators::estimators;
pub use race::race;
