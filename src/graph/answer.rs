//! What a signal or the knob sets off: a voice, at once, or a pattern, a fixed time later.
//!
//! The engine begins a voice by itself. A pattern is unrolled by whoever feeds the engine, in another thread where it plays live, so it has to
//! be told first; what is told in time begins at its instant, however the engine is asked for its frames.

use super::start::FIELDS;
use crate::space::spot::Spot;

/// Seconds that whoever feeds an engine has, behind the block in which something was set off, to give it what a pattern begins with.
pub const TELLING: f64 = 0.01;

/// Engine samples from the instant at which something is set off to the beginning of the pattern that this plays, for blocks of so many
/// frames: one block, and [`TELLING`].
pub fn latency(block: u32, device_rate: f64, engine_rate: f64) -> u64 {
    ((f64::from(block) / device_rate + TELLING) * engine_rate).ceil() as u64
}

/// What is set off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Answer {
    /// A voice.
    Voice(Voiced),
    /// A pattern.
    Pattern(Started),
}

/// A voice that is set off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Voiced {
    /// Its instrument, by its place in the plan.
    pub instrument: u32,
    /// Where it sounds.
    pub place: Spot,
    /// Its level.
    pub level: f64,
    /// Decibels above the threshold that a level of 1 is to be felt like; `None`: as loud as it comes.
    pub felt: Option<f64>,
    /// Seconds until its release.
    pub duration: f64,
    /// Its own fields, in the order in which it declares them.
    pub own: [f64; FIELDS],
}

/// A pattern that is set off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Started {
    /// Its name, by its place in [`super::plan::Plan::answering`].
    pub pattern: u32,
    /// Factor of its levels, 0 to 100.
    pub gain: f64,
    /// How many times as fast it plays, 0.001 to 1000.
    pub rate: f64,
}

impl Started {
    /// As it stands, within its ranges.
    pub fn new(pattern: u32, gain: f64, rate: f64) -> Self {
        Self { pattern, gain: gain.clamp(0.0, 100.0), rate: rate.clamp(0.001, 1000.0) }
    }
}

#[cfg(test)]
mod tests {
    use super::latency;

    #[test]
    fn it_is_a_block_and_ten_milliseconds_in_whole_samples() {
        assert_eq!(latency(0, 48_000.0, 8_000.0), 80);
        assert_eq!(latency(48, 48_000.0, 8_000.0), 88);
        // 256 frames are 42.7 samples.
        assert_eq!(latency(256, 48_000.0, 8_000.0), 123);
    }
}
