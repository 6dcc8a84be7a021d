//! What a recording of an actuator's response to a known drive tells of it, with intervals; and what it does not.
//!
//! | file | holds |
//! |---|---|
//! | [`motor`] | a rumble motor from the vibration of its casing, its current, its voltage when open |
//! | [`resonant`] | a voice coil, an inertial or a linear resonant actuator from its acceleration and current |
//! | [`stimulus`] | drives that tell much: what to play when such a recording is made |
//! | `estimate` | figures with intervals, and reasons why there are none |
//! | `recording` | channels, and what is wrong with them |
//! | `track`, `spin`, `reading` | a motor: following its turns, the law of its speed, what a recording says by that |
//! | `initial`, `rotor`, `start`, `winding` | a first guess of the law, its fit, what it leaves rest with, the coil |
//! | `spectrum`, `held`, `coil` | a resonance: a first guess, the response that is fitted, the coil |
//! | `least` | least squares, and how far off their result may be |
//!
//! Nothing of this is for real time, and nothing reads a file: samples come in as slices.

mod coil;
#[cfg(test)]
mod coverage;
mod estimate;
mod held;
mod initial;
mod joint;
mod least;
pub mod motor;
#[cfg(test)]
mod noise;
mod reading;
mod recording;
pub mod resonant;
mod rotor;
mod spectrum;
mod spin;
mod start;
pub mod stimulus;
mod track;
mod winding;

pub use estimate::{Estimate, Identified, Untold};
pub use recording::{Channel, Mistake, Name, RATES};
