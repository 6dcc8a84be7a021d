//! An ODrive, by its ASCII lines: the torque is computed here, exchange by exchange.
//!
//! A command is a line with a checksum; so is each answer. An exchange is one write, `c 0 torque` and `f 0`, and one line back: turns and
//! turns a second. Set-up asks who is there and for its errors, lowers its limits, starts its watchdog and closes its loop; what the board
//! does not know is said in [`News::Note`](super::servo::News::Note), but for the watchdog, without which nothing begins.
//!
//! Written after `Firmware/communication/ascii_protocol.cpp` of odriverobotics/ODrive (firmware 0.5) and ODrive's documentation of
//! firmware 0.6. What the first does and a host must know: a line with a wrong checksum is dropped without a word; so are the end of an
//! answer beyond 64 bytes, its line end included, and that of a property beyond 9; a command that sets something is answered only if
//! it fails. The second drops an answer while the one before is still being sent, so one question at a time is asked here.

mod errors;
mod lines;
mod session;
mod settings;
mod setup;
pub mod text;

pub use session::ODrive;
pub use settings::Settings;
