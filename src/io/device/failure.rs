//! What goes wrong with devices.

use std::fmt;

/// Why a device does not play.
#[derive(Debug, Clone, PartialEq)]
pub struct DeviceError {
    /// What kind of trouble it is.
    pub kind: Trouble,
    /// What happened, to which device.
    pub what: String,
    /// What to do about it.
    pub help: Option<String>,
}

/// Kinds of trouble, by what helps against them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Trouble {
    /// There is no such device, or it went away.
    Missing,
    /// Somebody else has it; to try again may help.
    Busy,
    /// The system does not let us.
    Forbidden,
    /// It does not offer what is wanted of it.
    Unfit,
    /// The system has no thread left.
    System,
    /// Anything else.
    Other,
}

impl Trouble {
    /// The exit code of a program that ends for it, as `sysexits.h` has them.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Missing | Self::Unfit => 69,
            Self::Busy => 75,
            Self::Forbidden => 77,
            Self::System => 71,
            Self::Other => 74,
        }
    }
}

impl DeviceError {
    /// Of a device.
    pub fn new(kind: Trouble, what: impl Into<String>) -> Self {
        Self { kind, what: what.into(), help: None }
    }

    /// Of a thread for `what` that the system did not give.
    pub(super) fn no_thread(what: &str, error: &std::io::Error) -> Self {
        Self::new(Trouble::System, format!("no thread for the {what}: {error}"))
    }

    /// With what to do about it.
    #[must_use]
    pub fn help(self, help: impl Into<String>) -> Self {
        Self { help: Some(help.into()), ..self }
    }

    /// With something more to do about it.
    #[must_use]
    pub(super) fn and(self, more: &str) -> Self {
        let help = self.help.iter().map(String::as_str).chain([more]).collect::<Vec<_>>().join("; ");
        self.help(help)
    }

    /// Of what cpal says about `device`.
    pub fn of(device: &str, error: &cpal::Error) -> Self {
        use cpal::ErrorKind as Kind;
        let (kind, help) = match error.kind() {
            Kind::DeviceBusy => {
                (Trouble::Busy, "close the program that plays on it, or play through a sound server")
            }
            Kind::DeviceNotAvailable => {
                (Trouble::Missing, "plug it in; `pacinian devices` lists what is there")
            }
            Kind::HostUnavailable => {
                (Trouble::Missing, "start the sound server; `pacinian devices` says what runs")
            }
            Kind::PermissionDenied => (
                Trouble::Forbidden,
                "on Linux, add yourself to the group audio: sudo usermod -aG audio $USER, then log in again",
            ),
            Kind::UnsupportedOperation => {
                (Trouble::Unfit, "`pacinian devices` lists what can be played on and what can be heard")
            }
            Kind::UnsupportedConfig | Kind::InvalidInput => {
                (Trouble::Unfit, "`pacinian devices` lists channels, rates and blocks that it offers")
            }
            _ => (
                Trouble::Other,
                "unplug it and plug it in again; where that does not help, the system's log may say more (on Linux: dmesg)",
            ),
        };
        // What is to be done follows behind it.
        let error = error.to_string();
        Self::new(kind, format!("{device}: {}", error.trim_end_matches('.'))).help(help)
    }
}

impl fmt::Display for DeviceError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.what)?;
        match &self.help {
            Some(help) => write!(f, "; {help}"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for DeviceError {}
