//! A SmartKnob: the torque is computed in the knob, and here it is told what to be.
//!
//! | file | holds |
//! |---|---|
//! | [`frame`] | COBS and CRC-32 |
//! | [`message`] | what the frames hold, in two dialects |
//! | [`config`] | what a knob can be |
//! | [`compile`] | effects into that, and what it cannot be |
//! | [`SmartKnob`] | the session |
//!
//! It begins in a mode of plain text in which single letters are commands, among them one that starts a calibration of the motor. A byte of
//! 0 ends that mode. So eight of them go first, all up to a 0 from the knob is dropped, and what is sent until the knob has acknowledged
//! something holds no byte that is a letter, a digit or a space. The same is done again before a message to a knob that has been silent,
//! for it may have been restarted.
//!
//! Written after the firmware of scottbez1/smartknob and its fork SeedLabs-it/smartknob-firmware, and the notes in [`message`] say in what
//! they differ. That a message was acknowledged does not mean that it was taken: a configuration is in force when the knob says it back.

pub mod compile;
pub mod config;
pub mod frame;
pub mod message;
mod session;
mod wire;

pub use session::{Feel, Remote, Settings, SmartKnob};
