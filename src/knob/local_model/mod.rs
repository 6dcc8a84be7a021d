//! What a slow thread sends to the servo: not a torque, but a model of its world near the knob.
//!
//! A torque that is refreshed every T_s needs b ≥ K T_s / 2 of the device: at 30 Hz some 300 times what a motor has. A stiffness and a
//! contact, evaluated at every tick, need no more than the servo's own rate. Between updates torque stays continuous, and the
//! energy that an update injects is booked.
//!
//! | file | holds |
//! |---|---|
//! | [`model`] | a model, and where and until when it holds |
//! | [`follower`] | what the servo makes of models that come one after another |
//! | [`pending`] | models on their way: bounded, coalesced when full, never dropped silently |
//! | [`link`] | the two ends: a lossless queue one way, the newest reading the other |
//! | [`profile`] | the same idea one step faster: what the servo leaves to a thread that reads the knob oftener than blocks come |

pub mod follower;
pub mod link;
pub mod model;
pub mod pending;
pub mod profile;
#[cfg(test)]
mod tests;
