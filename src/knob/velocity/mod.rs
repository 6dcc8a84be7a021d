//! Speed from an encoder.
//!
//! An encoder's angle moves in counts, so a difference over one tick moves in counts a tick: 1.6 rad/s at 1 kHz, 75 rad/s at 48 kHz for
//! 4000 counts a turn. Every estimator pays for less of that noise with lag; [`error`] says how much of both at a rate and a motion.
//!
//! | estimator | what it takes | when |
//! |---|---|---|
//! | [`difference`] | nothing | slow rates, coarse effects; its lag is half a tick |
//! | [`filtered`] | a corner frequency | smooth motion, known bandwidth |
//! | [`adaptive`] | a longest window | slow and fast motion in turn, no figure known of it |
//! | [`window`] | a longest window | the same at rates far above those of counts |
//! | [`kalman`] | a bound on acceleration | the least error where the bound holds |
//! | [`edges`] | nothing | rates far above those of counts |
//!
//! [`decimated`] runs any of them at a fraction of the rate, [`choice`] is any of them, [`transfer`] what they do to a loop. None allocates once it is made, and each refuses what is not a number by
//! saying what it said before.

pub mod adaptive;
pub mod choice;
pub mod decimated;
pub mod difference;
pub mod edges;
pub mod error;
pub mod filtered;
pub mod kalman;
mod ring;
pub mod transfer;
pub mod window;

/// Angles at a fixed rate in, speed out.
pub trait Estimator {
    /// The next reading (radians); the speed now (rad/s).
    fn push(&mut self, angle: f64) -> f64;
    /// At rest at an angle.
    fn reset(&mut self, angle: f64);
}

#[cfg(test)]
mod tests;
