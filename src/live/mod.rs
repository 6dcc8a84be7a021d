//! A session: a patch on a rig that plays in real time, and all the threads around it.
//!
//! ```text
//! keys, MIDI, OSC, program ─ queue a way ─ conductor ─ ring a source ─ callback ─ device
//!                        (stamped on arrival)   │                         │
//!                              patterns, triggers, log ◀──── reports ─────┘
//! ```
//!
//! Whatever arrives is stamped with wall time by the thread on which it arrives. The conductor turns that into a frame of the output
//! ([`clock`]): as much later as the longest block, so that the callback has not computed it yet. The callback knows engine time
//! alone.

pub mod board;
pub mod cables;
pub mod callback;
mod called_off;
pub mod clock;
pub mod conductor;
pub mod device_delay;
pub mod driver;
mod effort;
pub mod gate;
pub mod intake;
mod lately;
pub mod lent;
pub mod lever;
pub mod load;
pub mod local;
pub mod midi_board;
mod owed;
pub mod provenance;
pub mod queues;
pub mod relief;
pub mod reload;
pub mod remote;
mod sequence;
pub mod signal;
pub mod stamp;
pub mod steps;
pub mod torque;
pub mod tracker;
pub mod values;
pub mod walk;
pub mod way;
