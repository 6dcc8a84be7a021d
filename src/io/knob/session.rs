//! A conversation with a knob: bytes and times in, bytes out.

use super::lost::Lost;
use super::servo::Servo;
use super::trip::RoundTrip;

/// What to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Turn {
    /// Ask again at this time (seconds), or as soon as bytes come if it waits for some.
    Until {
        /// When at the latest.
        time: f64,
        /// Whether an answer is awaited.
        awaits: bool,
    },
    /// It has ended as it was told to.
    Done,
    /// It has ended: the device is no longer driven.
    Lost(Lost),
}

/// What happened so far, since the session was made.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Readings that the servo got.
    pub readings: u64,
    /// Answers whose checksum was wrong or missing.
    pub bad_checksum: u64,
    /// Questions without an answer in time.
    pub dropped: u64,
    /// Answers that came after their time.
    pub late: u64,
    /// Other things that were not asked for.
    pub unexpected: u64,
    /// Torques that were held to the limit.
    pub clipped: u64,
    /// Torques that were not a number and became 0.
    pub not_finite: u64,
    /// How often it was lost.
    pub lost: u64,
}

/// A conversation. Times are seconds of one clock, and never fall.
pub trait Session: Send {
    /// Begins anew: the line was just opened, or the device was lost.
    fn begin(&mut self, now: f64);

    /// Takes bytes that have come.
    fn hear(&mut self, bytes: &[u8], now: f64, servo: &mut dyn Servo);

    /// Does what is due, and appends what is to be written.
    fn turn(&mut self, now: f64, servo: &mut dyn Servo, out: &mut Vec<u8>) -> Turn;

    /// The line is gone: torque ends.
    fn lose(&mut self, why: &Lost);

    /// Ends in good order; [`Turn::Done`] tells when that is done.
    fn stop(&mut self, now: f64);

    /// The torque in force as far as is known here, N m; 0 unless the device is driven from here.
    fn torque(&self) -> f64;

    /// Whether readings come.
    fn is_ready(&self) -> bool;

    /// What happened so far.
    fn counts(&self) -> Counts;

    /// How long answers take.
    fn round_trip(&self) -> RoundTrip;
}
