//! Wall time of a session.

use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Nanoseconds since a session began, on a clock that never goes back.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Hash)]
pub struct Stamp(pub u64);

impl Stamp {
    /// Seconds since the session began.
    pub fn seconds(self) -> f64 {
        self.0 as f64 * 1e-9
    }

    /// Seconds from `earlier` to this one, negative where it lies before.
    pub fn since(self, earlier: Self) -> f64 {
        self.0.wrapping_sub(earlier.0) as i64 as f64 * 1e-9
    }
}

/// The clock of a session, for all its threads. To read it takes no system call where the system keeps its time in user space,
/// as Linux, macOS and Windows do on common machines.
#[derive(Debug, Clone, Copy)]
pub struct Epoch(Instant);

impl Epoch {
    /// Begins now.
    pub fn begin() -> Self {
        Self(Instant::now())
    }

    /// The time now.
    pub fn now(&self) -> Stamp {
        self.at(Instant::now())
    }

    /// The time at an instant; the beginning, if that lies before it.
    pub fn at(&self, instant: Instant) -> Stamp {
        let age = instant.saturating_duration_since(self.0);
        Stamp(u64::try_from(age.as_nanos()).unwrap_or(u64::MAX))
    }

    /// The instant of a stamp.
    pub fn instant(&self, stamp: Stamp) -> Instant {
        self.0 + Duration::from_nanos(stamp.0)
    }
}

/// Nanoseconds on the same clock, for what can hold no epoch.
pub fn nanoseconds() -> u64 {
    static BEGIN: OnceLock<Instant> = OnceLock::new();
    u64::try_from(BEGIN.get_or_init(Instant::now).elapsed().as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::{Epoch, Stamp};

    #[test]
    fn differences_have_a_sign() {
        assert_eq!(Stamp(5_000_000_000).since(Stamp(3_500_000_000)), 1.5);
        assert_eq!(Stamp(3_500_000_000).since(Stamp(5_000_000_000)), -1.5);
        let epoch = Epoch::begin();
        let (first, second) = (epoch.now(), epoch.now());
        assert!(first <= second);
        assert_eq!(epoch.at(epoch.instant(second)), second);
    }
}
