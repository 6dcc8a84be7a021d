//! A moment, in seconds and on the engine's clock.

use crate::schedule::Instant;

/// A moment, in seconds from the beginning and on the engine's clock.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct When {
    /// Seconds from the beginning.
    pub seconds: f64,
    /// The same on the engine's clock.
    pub instant: Instant,
}

impl When {
    /// So many seconds from the beginning, for an engine of `rate` samples a second.
    pub fn of_seconds(seconds: f64, rate: f64) -> Self {
        Self { seconds, instant: Instant::of_samples(seconds * rate) }
    }

    /// At an instant of an engine of `rate` samples a second.
    pub fn of_instant(instant: Instant, rate: f64) -> Self {
        Self { seconds: instant.since(Instant::default()) / rate, instant }
    }

    /// Then, or at `other` if that is later.
    pub fn no_earlier(self, other: Self) -> Self {
        if other.instant > self.instant { other } else { self }
    }

    /// With an engine sample. It is that sample exactly, which seconds and back again would not always give.
    pub fn of_sample(sample: u64, rate: f64) -> Self {
        Self { seconds: sample as f64 / rate, instant: Instant { sample, fraction: 0 } }
    }
}
