//! Where the controls of a session stand.

use std::collections::BTreeMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

use super::way::{WAYS, Way};

/// Where each control was sent last, by whomever: MIDI, OSC, keys or a program. The conductor shows it, the audio thread does not.
#[derive(Debug, Default)]
pub struct Values(Mutex<Shown>);

#[derive(Debug, Default)]
struct Shown {
    by_name: BTreeMap<String, f64>,
    /// The numbers of the last signals that are done, by way.
    done: [u64; WAYS],
}

impl Values {
    fn shown(&self) -> MutexGuard<'_, Shown> {
        // Whoever panicked while it was held has lost a value at most.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Where a control stands; `None` for one that the patch does not have. It may wait while the conductor writes a few numbers down, and is
    /// not for a thread that must not.
    pub fn get(&self, control: &str) -> Option<f64> {
        self.shown().by_name.get(control).copied()
    }

    /// The same as of a signal that came by that way; `None` as well where that signal is not done yet.
    pub(crate) fn since(&self, control: &str, way: Way, signal: u64) -> Option<f64> {
        let shown = self.shown();
        shown.by_name.get(control).copied().filter(|_| shown.done[way as usize] >= signal)
    }

    /// The last signals of each way were these, where they are not 0.
    pub(crate) fn done(&self, signals: [u64; WAYS]) {
        let mut shown = self.shown();
        shown.done.iter_mut().zip(signals).for_each(|(done, signal)| *done = (*done).max(signal));
    }

    /// They stand so now, and there are no others.
    pub(crate) fn show<'a>(&self, values: impl Iterator<Item = (&'a str, f64)>) {
        self.shown().by_name = values.map(|(name, value)| (name.into(), value)).collect();
    }
}
