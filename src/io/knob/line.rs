//! A line of bytes to a device.

use std::fmt;
use std::time::Duration;

/// A line of bytes to one device. Errors are what the system said, after which the line is closed.
pub trait Line: Send {
    /// Reads what is there, and waits for something no longer than `wait`. 0: nothing came.
    ///
    /// # Errors
    /// The device is gone.
    fn read(&mut self, to: &mut [u8], wait: Duration) -> Result<usize, String>;

    /// Writes all of it.
    ///
    /// # Errors
    /// The device is gone, or takes nothing.
    fn write(&mut self, bytes: &[u8]) -> Result<(), String>;

    /// Opens the same device again, and no other.
    ///
    /// # Errors
    /// Why it cannot be opened.
    fn open_again(&mut self) -> Result<(), LineError>;
}

/// Why a line cannot be opened.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineError {
    /// What kind of trouble it is.
    pub kind: Trouble,
    /// What happened at which port.
    pub message: String,
    /// What to do about it.
    pub help: &'static str,
}

/// Kinds of trouble with a line, by what helps against them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    /// There is no such device.
    Missing,
    /// Another program has it.
    Busy,
    /// The system does not let us.
    Forbidden,
    /// There is another device in its place.
    Other,
    /// The system failed otherwise.
    Failed,
}

impl LineError {
    /// The exit code of a program that ends for it, as `sysexits.h` has them.
    pub fn exit_code(&self) -> u8 {
        match self.kind {
            Trouble::Missing | Trouble::Other => 69,
            Trouble::Failed => 74,
            Trouble::Busy => 75,
            Trouble::Forbidden => 77,
        }
    }
}

impl fmt::Display for LineError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}; {}", self.message, self.help)
    }
}

impl std::error::Error for LineError {}
