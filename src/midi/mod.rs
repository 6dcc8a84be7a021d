//! MIDI as it is meant: bytes become messages, messages become gestures.
//!
//! Everything here is pure. There are no ports, threads or clocks, and no file is opened: bytes and times come from outside, and what they
//! mean goes out again. [`parser::Parser`] makes [`Message`]s of bytes in any cuts;
//! [`interpreter::Interpreter`] makes [`Gesture`]s of messages: notes that begin, move and end, controllers, panic;
//! [`sensing::Sensing`] says when a cable is lost that had promised to stay.
//! With the feature `midi`, `file::Song` reads Standard MIDI Files from bytes.
//!
//! The numbers are those of the MIDI 1.0 Detailed Specification (MIDI Association, M1 4.2.1) and of its additions, each named where it
//! is used.

pub mod channel;
pub mod claims;
pub mod curve;
mod desk;
pub mod encoder;
#[cfg(feature = "midi")]
pub mod file;
pub mod gesture;
pub mod interpreter;
pub mod message;
pub mod moved;
mod parameter;
pub mod parser;
pub mod pitch;
pub mod reach;
pub mod sensing;
pub mod sounding;
mod strip;
pub mod travel;
pub mod zone;

pub use channel::Channel;
pub use claims::Claims;
pub use curve::Curve;
pub use encoder::Encoder;
pub use gesture::{Expression, Gesture, Reason, Transport, What};
pub use interpreter::Interpreter;
pub use message::Message;
pub use parser::Parser;
pub use zone::Zone;
