//! MIDI as it is meant: bytes become messages, messages become gestures.
//!
//! Everything here is pure. There are no ports, threads or clocks, and no file is opened: bytes and times come from outside, and what they
//! mean goes out again. [`parser::Parser`] makes [`Message`]s of bytes in any cuts.
//!
//! The numbers are those of the MIDI 1.0 Detailed Specification (MIDI Association, M1 4.2.1) and of its additions, each named where it
//! is used.

pub mod channel;
pub mod message;
pub mod parser;

pub use channel::Channel;
pub use message::Message;
pub use parser::Parser;
