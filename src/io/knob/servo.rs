//! What a knob's readings go to, and torque comes from.

use super::lost::Lost;
use super::trip::RoundTrip;

/// What the knob said.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reading {
    /// Radians.
    pub angle: f64,
    /// Radians a second, of a device that says so.
    pub velocity: Option<f64>,
    /// Seconds since the reading before; of the first, those that should pass between two.
    pub dt: f64,
    /// How long answers take.
    pub round_trip: RoundTrip,
}

/// What becomes of a knob, beside its readings.
#[derive(Debug, Clone, PartialEq)]
pub enum News {
    /// It is there and ready: what it says it is.
    Ready(String),
    /// Something to know about it.
    Note(String),
    /// It was pressed or let go, so many times since the reading before.
    Press(u8),
    /// What it was told to be, it is: by the name that was given.
    InForce(String),
    /// What it was told to be, it is not: the name, and why.
    Refused(String, String),
}

/// Answers readings with torque. It runs on the driver's thread; should it panic, that thread ends and the device's watchdog stops the
/// motor.
pub trait Servo: Send {
    /// The torque for a reading, N m; it is held to the session's limit, and what is not a number is 0. A device that renders by itself
    /// takes none: then it is of no account.
    fn tick(&mut self, reading: &Reading) -> f64;

    /// The torque of an exchange that is about to be written, N m, if it may have changed since `tick`.
    fn newest(&mut self) -> Option<f64> {
        None
    }

    /// The device is there, and has said nothing new: one that renders by itself may be silent while it stands.
    fn rest(&mut self) {}

    /// Torque has ended. It may begin again: then `tick` is called again.
    fn lost(&mut self, why: &Lost);

    /// Something else happened.
    fn news(&mut self, _news: &News) {}
}
