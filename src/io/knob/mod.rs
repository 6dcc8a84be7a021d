//! Knobs on serial ports.
//!
//! | file | holds |
//! |---|---|
//! | [`ports`] | which ports there are, and which of them may be a knob |
//! | [`mod@line`], [`port`] | a line of bytes; the serial port |
//! | [`session`], [`servo`], [`lost`] | what talks over a line, what it moves, and why it no longer does |
//! | [`driver`] | the thread that owns all three |
//! | `patched` | a session's knob on a line |
//! | [`odrive`] | an ODrive, by its ASCII lines: the torque is computed here |
//! | [`smartknob`] | a SmartKnob, by its frames: the torque is computed in the knob, here it is told what to be |
//!
//! A session has no clock and no port: bytes go in with a time, bytes come out. So every trouble a cable can make is tried without one.
//! Nothing here is for an audio callback: [`driver::run`] has its own thread, which may wait, lock and allocate.
//!
//! What stops a motor when a program dies is never that program. An ODrive's own watchdog does, and a session that cannot set it does not
//! begin; a SmartKnob renders by itself.
//!
//! Both are written after the firmware's sources and tried against simulated devices only: no hardware has been at hand.

mod budget;
pub mod driver;
pub mod line;
pub mod lost;
pub mod odrive;
#[cfg(feature = "live")]
pub mod patched;
pub mod port;
pub mod ports;
pub mod servo;
pub mod session;
pub mod smartknob;
pub mod trip;
