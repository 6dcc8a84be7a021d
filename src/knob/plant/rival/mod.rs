//! Other ways to step a knob, to be compared with the exact one, and other models of friction.
//!
//! None of them is for use: they show what exactness is worth. All of them hold the torque over a step and judge friction and
//! contact where they look, not at their instants.

pub mod bristle;
pub mod implicit_coulomb;
pub mod integrator;
