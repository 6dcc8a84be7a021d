//! Actuators whose coil moves in a magnetic field: voice-coil tactors, inertial motors, linear resonant actuators.
//!
//! | file | holds |
//! |---|---|
//! | [`parameters`], [`lra`], [`limits`], [`bounds`] | what one is made of, what a data sheet says, what it bears, where its motion ends |
//! | [`plant`] | a checked actuator on its load, as one linear system |
//! | [`response`], [`resonance`] | its exact frequency response, its pole pair |
//! | [`model`], [`readout`], [`energy`] | the same in time, one sample a step; what is seen of it; where the energy goes |
//! | [`large`], [`supply`] | in large motion; behind an amplifier with two limits |
//! | [`equaliser`], [`burst`] | what makes it even over a band; what makes a resonant one start and stop |

pub mod bounds;
pub mod burst;
mod contact;
pub mod energy;
pub mod equaliser;
mod flow;
pub mod large;
pub mod limits;
pub mod lra;
pub mod model;
pub mod parameters;
pub mod plant;
pub mod readout;
pub mod resonance;
pub mod response;
pub(in crate::actuator) mod sampled;
pub mod supply;
