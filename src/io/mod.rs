//! The edges: files in and out. Nothing below this room opens one.

pub mod assets;
pub mod calibrations;
#[cfg(feature = "live")]
pub mod device;
pub mod error;
pub mod events;
#[cfg(feature = "live")]
pub mod gesture;
pub mod input;
#[cfg(feature = "live")]
pub mod journal;
#[cfg(feature = "serial")]
pub mod knob;
#[cfg(feature = "live")]
pub mod latency;
#[cfg(feature = "live")]
pub mod learn;
pub mod load;
pub mod log;
#[cfg(feature = "live")]
pub mod midi_in;
mod open;
#[cfg(feature = "live")]
pub mod osc;
pub mod out;
#[cfg(feature = "live")]
pub mod recorder;
pub mod replace;
pub(crate) mod resample;
#[cfg(feature = "live")]
pub mod session;
#[cfg(feature = "midi")]
pub mod song;
pub mod text;
pub mod watch;
pub mod wav;
