//! Ctrl-C and its kin: the first asks to come to an end, the second means it.

use super::failure::Failure;
use signal_hook::consts::signal::{SIGINT, SIGTERM};
use signal_hook::flag;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

#[cfg(unix)]
const SIGNALS: [i32; 3] = [SIGINT, SIGTERM, signal_hook::consts::signal::SIGHUP];
#[cfg(not(unix))]
const SIGNALS: [i32; 2] = [SIGINT, SIGTERM];

fn unheard(error: &std::io::Error) -> Failure {
    Failure::said(71, format!("Ctrl-C cannot be listened to ({error})"))
}

/// Whether somebody has asked to stop.
#[derive(Debug, Clone, Default)]
pub struct Stop {
    signal: Arc<AtomicUsize>,
}

impl Stop {
    /// Listens from now on.
    ///
    /// # Errors
    /// When the system does not let the program listen.
    pub fn listen() -> Result<Self, Failure> {
        let stop = Self::default();
        let again = Arc::new(AtomicBool::new(false));
        for signal in SIGNALS {
            // In this order: the second of them ends the program before it is noted as the first.
            flag::register_conditional_shutdown(signal, 128 + signal, Arc::clone(&again))
                .and_then(|_| flag::register(signal, Arc::clone(&again)))
                .and_then(|_| flag::register_usize(signal, Arc::clone(&stop.signal), signal as usize))
                .map_err(|error| unheard(&error))?;
        }
        Ok(stop)
    }

    /// Sets a flag at the moment at which somebody asks.
    ///
    /// # Errors
    /// As [`Stop::listen`].
    pub fn also(&self, set: &Arc<AtomicBool>) -> Result<(), Failure> {
        for signal in SIGNALS {
            flag::register(signal, Arc::clone(set)).map_err(|error| unheard(&error))?;
        }
        Ok(())
    }

    /// The exit code to end with, if somebody has asked: 129 for SIGHUP, 130 for Ctrl-C, 143 for SIGTERM.
    pub fn asked(&self) -> Option<u8> {
        match self.signal.load(Ordering::Relaxed) {
            0 => None,
            signal => Some(u8::try_from(128 + signal).unwrap_or(130)),
        }
    }
}
