//! Active sensing: whether a cable is still there that had promised to say so.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use super::message::Message;

/// How long a cable that has said 0xFE may be silent. It says so every 300 ms at the latest, give or take a tenth (MIDI 1.0 Detailed Specification,
/// "Active Sensing"), so that one is lost only behind 330.
pub const SILENCE: Duration = Duration::from_millis(330);

/// How long at most silence is forgiven.
pub const FORGIVEN: Duration = Duration::from_secs(1);

/// Watches one cable, from its first 0xFE on. One thread may tell it what comes while another asks, and neither waits. Times are those since any
/// one beginning.
#[derive(Debug, Default)]
pub struct Sensing {
    /// When something came last, and up to when silence is not held against it, nanoseconds.
    last: AtomicU64,
    forgiven: AtomicU64,
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

    /// Whether it had promised to stay. It has not any more.
    pub fn take_promise(&self) -> bool {
        self.promised.swap(false, Ordering::AcqRel)
    }

    /// Silence up to now says nothing: whoever listens stood still, or something that came was lost on the way. That holds for [`FORGIVEN`] from the
    /// last that came, so that a cable which is gone is noticed in the end.
    pub fn forgive(&self, now: Duration) {
        let now = nanoseconds(now);
        if now.saturating_sub(self.last.load(Ordering::Acquire)) <= nanoseconds(FORGIVEN) {
            self.forgiven.fetch_max(now, Ordering::AcqRel);
        }
    }

    /// Whether the silence up to now is too long: the cable is lost. It is said once; then nothing is promised any more.
    pub fn is_lost(&self, now: Duration) -> bool {
        let since = self.last.load(Ordering::Acquire).max(self.forgiven.load(Ordering::Acquire));
        nanoseconds(now).saturating_sub(since) > nanoseconds(SILENCE) && self.take_promise()
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
        assert!(!cable.is_lost(MS(100_330)), "300 ms and a tenth, exactly");
        assert!(cable.is_lost(MS(100_330) + Duration::from_nanos(1)));
        assert!(!cable.is_lost(MS(200_000)), "it is said once");
        cable.message(MS(200_000), Message::ActiveSensing);
        assert!(cable.is_lost(MS(200_331)), "promised anew");
        cable.message(MS(300_000), Message::ActiveSensing);
        assert!(cable.take_promise() && !cable.take_promise() && !cable.is_lost(MS(400_000)));
    }

    #[test]
    fn silence_is_forgiven_for_a_second_and_no_longer() {
        let cable = Sensing::default();
        cable.message(MS(0), Message::ActiveSensing);
        cable.forgive(MS(250));
        assert!(!cable.is_lost(MS(580)), "it counts anew from then on");
        (1..40).for_each(|n| cable.forgive(MS(250 * n)));
        assert!(!cable.is_lost(MS(1_330)) && cable.is_lost(MS(1_331)));
        // Whatever comes begins anew.
        cable.message(MS(20_000), Message::ActiveSensing);
        cable.forgive(MS(20_900));
        assert!(!cable.is_lost(MS(21_230)) && cable.is_lost(MS(21_231)));
    }

    #[test]
    fn whatever_comes_shows_that_it_is_there() {
        let cable = Sensing::default();
        cable.message(MS(0), Message::ActiveSensing);
        cable.message(MS(250), Message::Clock);
        // The middle of a dump.
        cable.heard(MS(500));
        assert!(!cable.is_lost(MS(830)));
        // What a slow thread stamps late takes nothing back.
        cable.heard(MS(300));
        assert!(!cable.is_lost(MS(830)));
        cable.message(MS(800), Message::Reset);
        assert!(!cable.is_lost(MS(9_000)), "a reset ends the promise");
    }
}
