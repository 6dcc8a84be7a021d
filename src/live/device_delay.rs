//! What a device says of what it holds.
#![deny(clippy::disallowed_methods)]

use std::sync::atomic::{AtomicU64, Ordering};

/// From a callback to when the device plays its first frame: as much as it holds already of what it was given.
///
/// Some never say. One that does says nought where it ran dry, which is not to be taken for having said nothing.
#[derive(Debug, Default)]
pub struct DeviceDelay(AtomicU64);

impl DeviceDelay {
    /// Nanoseconds, as the device said last; none as long as it said nothing.
    pub fn get(&self) -> Option<u64> {
        self.0.load(Ordering::Relaxed).checked_sub(1)
    }

    /// In seconds, and 0 as long as it said nothing.
    pub fn seconds(&self) -> f64 {
        self.get().unwrap_or(0) as f64 * 1e-9
    }

    /// Notes what it says, in nanoseconds.
    pub fn note(&self, nanoseconds: u64) {
        if nanoseconds > 0 || self.0.load(Ordering::Relaxed) > 0 {
            self.0.store(nanoseconds.saturating_add(1), Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::DeviceDelay;

    #[test]
    fn nought_is_something_said_only_after_more() {
        let delay = DeviceDelay::default();
        delay.note(0);
        assert_eq!((delay.get(), delay.seconds()), (None, 0.0));
        delay.note(3_000_000);
        assert_eq!((delay.get(), delay.seconds()), (Some(3_000_000), 0.003));
        delay.note(0);
        assert_eq!((delay.get(), delay.seconds()), (Some(0), 0.0));
    }
}
