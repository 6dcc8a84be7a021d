//! Whether a server computes ahead of time, as JACK does for a program that exports (freewheel): nobody hears that, and what is given away then is lost.

#![deny(clippy::disallowed_methods)]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Ahead by so much, seconds, it is noticed: no server's buffer is that long, and what of a session is played by then is no more.
const LEAD: f64 = 0.5;

/// Over so many seconds that is looked at.
const WINDOW: f64 = 1.0;

/// Up to so much faster than it plays, over a window, it keeps time again.
const IN_TIME: f64 = 1.5;

/// Looks at what a device asks for. For the audio thread.
pub(super) struct Ahead {
    /// Frames a second.
    rate: f64,
    /// Since when, seconds.
    since: f64,
    /// Asked for since then.
    frames: u64,
    rushes: Arc<AtomicBool>,
}

impl Ahead {
    /// Of a device of that rate, at `now` seconds. Whether it is ahead is said in `rushes`.
    pub fn new(rate: f64, now: f64, rushes: Arc<AtomicBool>) -> Self {
        Self { rate, since: now, frames: 0, rushes }
    }

    /// So many frames are asked for at `now` seconds. Says whether that is ahead of time.
    pub fn asks(&mut self, frames: u64, now: f64) -> bool {
        self.frames += frames;
        let (asked, passed) = (self.frames as f64 / self.rate, now - self.since);
        let mut rushes = self.rushes.load(Ordering::Relaxed);
        if asked - passed > LEAD {
            rushes = true;
        } else if passed >= WINDOW {
            rushes &= asked > IN_TIME * passed;
        }
        // That it was late gives it nothing to catch up on.
        if passed >= WINDOW || (asked < passed && !rushes) {
            (self.since, self.frames) = (now, 0);
        }
        self.rushes.store(rushes, Ordering::Relaxed);
        rushes
    }
}

#[cfg(test)]
mod tests {
    use super::{Ahead, Arc, AtomicBool};

    /// Blocks of 1,024 at 48 kHz, each asked for at a moment of its own; gives the first that is ahead, and the first behind it that is not.
    fn found(moments: impl Iterator<Item = f64>) -> (Option<f64>, Option<f64>) {
        let mut ahead = Ahead::new(48_000.0, 0.0, Arc::<AtomicBool>::default());
        let mut found = (None, None);
        for at in moments {
            match ahead.asks(1_024, at) {
                true => _ = found.0.get_or_insert(at),
                false if found.0.is_some() => _ = found.1.get_or_insert(at),
                false => {}
            }
        }
        found
    }

    const BLOCK: f64 = 1_024.0 / 48_000.0;

    #[test]
    fn a_device_that_keeps_time_is_never_ahead() {
        for fast in [0.99, 1.0, 1.01] {
            assert_eq!(found((0..10_000).map(|n| f64::from(n) * BLOCK / fast)), (None, None), "{fast}");
        }
        // Blocks that come two at a time, and a machine that stands still now and then, behind which what was due comes at once.
        assert_eq!(found((0..10_000).map(|n| f64::from(n / 2) * 2.0 * BLOCK)), (None, None));
        let stalls = |at: f64| if at % 3.0 < 0.4 { at - at % 3.0 + 0.4 } else { at };
        assert_eq!(found((0..10_000).map(|n| stalls(f64::from(n) * BLOCK))), (None, None));
    }

    #[test]
    fn one_in_a_hurry_is_found_before_it_has_taken_a_second_and_is_in_time_again_behind_that() {
        for speed in [3.0, 10.0, 300.0] {
            // Five seconds in time, two in a hurry, and in time again.
            let hurried = (2.0 * speed / BLOCK) as u32;
            let moments = (0..234).map(|n| f64::from(n) * BLOCK);
            let moments = moments.chain((0..hurried).map(|n| 5.0 + f64::from(n) * BLOCK / speed));
            let moments = moments.chain((0..400).map(|n| 7.0 + f64::from(n) * BLOCK));
            let (Some(begin), Some(end)) = found(moments) else { panic!("{speed}") };
            let taken = (begin - 5.0) * speed;
            assert!((0.4..1.5).contains(&taken), "{speed}: {taken} s");
            assert!((7.0..9.5).contains(&end), "{speed}: {end}");
        }
    }
}
