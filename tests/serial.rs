//! Knobs on serial lines: the sessions on a clock of their own against simulated devices, and the driver against the same devices behind a
//! pseudo-terminal.
//!
//! The devices share no code with the drivers: lines, COBS, CRC and varints are written anew here, after the firmwares. Behind each is a
//! simulated knob that really turns.
#![cfg(target_os = "linux")]

#[cfg(feature = "cli")]
#[path = "common/bench.rs"]
mod bench;
#[path = "serial/cable.rs"]
mod cable;
#[path = "serial/driven.rs"]
mod driven;
#[path = "serial/frames.rs"]
mod frames;
#[path = "serial/hand.rs"]
mod hand;
#[path = "serial/noise.rs"]
mod noise;
#[path = "serial/odrive.rs"]
mod odrive;
#[path = "serial/odrive_tests.rs"]
mod odrive_tests;
#[cfg(feature = "cli")]
#[path = "serial/played.rs"]
mod played;
#[path = "serial/smartknob.rs"]
mod smartknob;
#[path = "serial/smartknob_tests.rs"]
mod smartknob_tests;
#[path = "serial/terminal.rs"]
mod terminal;
