//! Active sensing: whether a cable is still there that had promised to say so.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use super::message::Message;

/// How long a cable that has said 0xFE may be silent: MIDI 1.0 Detailed Specification, "Active Sensing".
pub const SILENCE: Duration = Duration::from_millis(300);

/// Watches one cable, from its first 0xFE on. One thread may tell it what comes while another asks, and neither waits. Times are those since any
/// one beginning.
#[derive(Debug, Default)]
pub struct Sensing {
    /// When something came last, nanoseconds.
    last: AtomicU64,
    promised: AtomicBool,
}

impl Sensing {
    /// Bytes came, though they make no message, as those in the middle of a long system exclusive do: the cable is there.
    pub fn heard(&self, now: Duration) {
        self.last.fetch_max(nanoseconds(now), Ordering::AcqRel);
    }

    /// A message came: 0xFE promises that there will be others; a reset takes that back.
    pub fn message(&self, now: Duration, message: Message) {
        self.heard(now);
        match message {
            Message::ActiveSensing => self.promised.store(true, Ordering::Release),
            Message::Reset => self.promised.store(false, Ordering::Release),
            _ => {}
        }
    }

    /// Whether it has promised to stay.
    pub fn is_promised(&self) -> bool {
        self.promised.load(Ordering::Acquire)
    }

    /// Whether the silence up to now is too long: the cable is lost. It is said once; then nothing is promised any more.
    pub fn is_lost(&self, now: Duration) -> bool {
        let silence = nanoseconds(now).saturating_sub(self.last.load(Ordering::Acquire));
        silence > nanoseconds(SILENCE) && self.promised.swap(false, Ordering::AcqRel)
    }
}

/// 584 years is long enough.
fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests {
    use super::{Duration, Message, Sensing};

    const MS: fn(u64) -> Duration = Duration::from_millis;

    #[test]
    fn a_lost_cable_is_noticed_only_after_it_promised() {
        let cable = Sensing::default();
        cable.message(MS(100), Message::Clock);
        assert!(!cable.is_lost(MS(100_000)), "nothing was promised");
        cable.message(MS(100_000), Message::ActiveSensing);
        assert!(cable.is_promised() && !cable.is_lost(MS(100_300)), "exactly");
        assert!(cable.is_lost(MS(100_300) + Duration::from_nanos(1)));
        assert!(!cable.is_lost(MS(200_000)), "it is said once");
        cable.message(MS(200_000), Message::ActiveSensing);
        assert!(cable.is_lost(MS(200_301)), "promised anew");
    }

    #[test]
    fn whatever_comes_shows_that_it_is_there() {
        let cable = Sensing::default();
        cable.message(MS(0), Message::ActiveSensing);
        cable.message(MS(250), Message::Clock);
        // The middle of a dump.
        cable.heard(MS(500));
        assert!(!cable.is_lost(MS(800)));
        // What a slow thread stamps late takes nothing back.
        cable.heard(MS(300));
        assert!(!cable.is_lost(MS(800)));
        cable.message(MS(800), Message::Reset);
        assert!(!cable.is_lost(MS(9_000)), "a reset ends the promise");
    }
}
