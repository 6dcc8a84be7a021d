//! What a session with an ODrive keeps to.

use crate::actuator::fault::{Fault, within};

/// What a session with an ODrive keeps to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Axis 0 or 1 of the board.
    pub axis: u8,
    /// The largest torque that is ever commanded, 1e-6 to 1e3 N m. The board's own limit is lowered to it, and never raised.
    pub most_torque: f64,
    /// The speed to which the board holds the motor, 0.1 to 1e4 rad/s; likewise.
    pub most_speed: f64,
    /// Exchanges a second at most, 1 to 20,000.
    pub rate: f64,
    /// Seconds without a command after which the board stops its motor, 0.01 to 1. Without an answer for as long, the session is lost.
    pub watchdog: f64,
    /// Seconds that an answer may take, 1e-3 to half the watchdog's; then torque is 0 until another comes.
    pub patience: f64,
    /// Seconds over which torque falls when it is stopped, 0 to 1.
    pub ramp: f64,
    /// Whether to drive a board whose watchdog cannot be set: then nothing stops the motor if the program dies.
    pub unwatched: bool,
}

impl Default for Settings {
    /// Axis 0, 0.05 N m, 60 rad/s, 1,000 exchanges a second, a watchdog of 50 ms.
    fn default() -> Self {
        Self {
            axis: 0,
            most_torque: 0.05,
            most_speed: 60.0,
            rate: 1_000.0,
            watchdog: 0.05,
            patience: 0.015,
            ramp: 0.02,
            unwatched: false,
        }
    }
}

impl Settings {
    /// Refuses what cannot be.
    ///
    /// # Errors
    /// The first field beyond its limits.
    pub fn check(&self) -> Result<(), Fault> {
        within("axis", f64::from(self.axis), (0.0, 1.0), "as the board counts them")?;
        within("most torque", self.most_torque, (1e-6, 1e3), "N m")?;
        within("most speed", self.most_speed, (0.1, 1e4), "rad/s")?;
        within("rate", self.rate, (1.0, 2e4), "Hz")?;
        within("watchdog", self.watchdog, (0.01, 1.0), "s")?;
        within("patience", self.patience, (1e-3, self.watchdog / 2.0), "s: half the watchdog's at most")?;
        within("ramp", self.ramp, (0.0, 1.0), "s")?;
        if self.rate * self.watchdog < 2.0 {
            let limit = crate::actuator::fault::Limit::Least(2.0 / self.watchdog);
            return Err(Fault::because("rate", self.rate, limit, "the watchdog must be fed twice over"));
        }
        Ok(())
    }
}
