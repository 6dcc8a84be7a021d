//! Why a knob is not, or no longer, at the other end.

use std::fmt;

/// Why torque ended.
#[derive(Debug, Clone, PartialEq)]
pub enum Lost {
    /// The port is gone or does not take bytes: what the system said.
    Vanished(String),
    /// It never answered what it was asked.
    Silent(String),
    /// It answered, and does so no longer, for so many seconds.
    Stalled(f64),
    /// So many bytes came within a second that nobody had asked for.
    Flood(usize),
    /// It says back what it is told.
    Echo(String),
    /// It speaks something else: what it said.
    Dialect(String),
    /// It stopped its motor.
    Axis {
        /// The state that it says it is in; 8 is closed loop.
        state: Option<i64>,
        /// Its errors, as bits; 0 where it does not say.
        errors: u64,
        /// The errors by name.
        names: String,
        /// Whether its watchdog alone did it, which silence on the line does too.
        watchdog: bool,
    },
    /// It has no watchdog that could be set: what was tried.
    Unwatched(String),
}

impl Lost {
    /// Whether only somebody at the device can help, so that to try again is of no use.
    pub fn is_final(&self) -> bool {
        match self {
            Self::Vanished(_) | Self::Silent(_) | Self::Stalled(_) | Self::Flood(_) => false,
            Self::Axis { watchdog, errors, .. } => !watchdog && *errors != 0,
            Self::Echo(_) | Self::Dialect(_) | Self::Unwatched(_) => true,
        }
    }
}

impl fmt::Display for Lost {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Vanished(why) => write!(f, "the port is gone ({why}): plug it in again; it is looked for"),
            Self::Silent(asked) => write!(
                f,
                "no answer to {asked}: check the cable, that the device has power, and that this is its port"
            ),
            Self::Stalled(seconds) => write!(
                f,
                "no answer for {:.0} ms: the device hangs or the cable is loose; it is asked again",
                seconds * 1e3
            ),
            Self::Flood(bytes) => write!(
                f,
                "{bytes} bytes in a second that nobody asked for: this is not the knob's port, or its log is on"
            ),
            Self::Echo(line) => write!(
                f,
                "it says back what it is told ({line}): this is a terminal or a loop of wire, not a knob"
            ),
            Self::Dialect(said) => write!(f, "it speaks something else ({said}): name the port of the knob"),
            Self::Axis { state, errors, names, watchdog } => {
                f.write_str("the device stopped its motor")?;
                if let Some(state) = state {
                    write!(f, ", its axis is in state {state}")?;
                }
                match (errors, watchdog) {
                    (0, _) => f.write_str(": it says no error, so it was restarted or told to by another"),
                    (_, true) => f.write_str(": its watchdog did, as nothing reached it for too long"),
                    _ => write!(
                        f,
                        ", error {errors:#x} ({names}): see to its cause, clear it with the device's own tool and begin again"
                    ),
                }
            }
            Self::Unwatched(tried) => write!(
                f,
                "the device has no watchdog that can be set ({tried}), so nothing would stop its motor if this program dies: \
                 update its firmware, or allow it in the settings"
            ),
        }
    }
}

impl std::error::Error for Lost {}
