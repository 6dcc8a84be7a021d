//! How long a callback itself worked, told from how long it took.

#![deny(clippy::disallowed_methods)]

use std::time::Duration;

use cpu_time::ThreadTime;

/// What a callback takes is what it works, unless the system lets something else run meanwhile: then only the processor's own clock for the thread knows.
/// To read that is a system call, of about a twentieth of what a small scene takes, and it can tell no more than what has passed since it was read last.
/// So it is read where a callback took long, and now and then; either clock is an upper bound, but for
/// the ticks of one that is coarse (15 ms on Windows), and the lesser one counts.
#[derive(Debug, Default)]
pub struct Effort {
    /// When the clock was read last, on which thread, and callbacks since.
    read: Option<(Duration, usize)>,
    since: u32,
}

/// Of its period, a callback that takes less is short.
const SHORT: f64 = 1.0 / 64.0;

/// Callbacks from one reading to the next at most, all of them short: by so many of those the next may be taken for too long.
const EVERY: u32 = 8;

impl Effort {
    /// Seconds that a callback worked, at most, which took `wall` seconds of its `period`.
    pub fn of(&mut self, wall: f64, period: f64) -> f64 {
        self.since += 1;
        if wall < SHORT * period && self.since < EVERY {
            return wall;
        }
        let now = ThreadTime::try_now().ok().map(|now| (now.as_duration(), thread()));
        self.since = 0;
        own(std::mem::replace(&mut self.read, now), now).map_or(wall, |own| own.min(wall))
    }

    /// Another device calls back from now on.
    pub fn forget(&mut self) {
        *self = Self::default();
    }
}

/// Seconds between two readings of one thread.
fn own(before: Option<(Duration, usize)>, now: Option<(Duration, usize)>) -> Option<f64> {
    let ((before, thread), (now, here)) = before.zip(now)?;
    // One that came after another is gone may stand in its place, and has mostly worked less; a device says that it has moved.
    let own = now.checked_sub(before).filter(|_| thread == here)?;
    Some(own.as_secs_f64())
}

/// Something that differs from thread to thread among those that there are.
fn thread() -> usize {
    thread_local!(static HERE: u8 = const { 0 });
    HERE.with(|here| std::ptr::from_ref(here).addr())
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test is no audio thread")]
mod tests {
    use std::time::{Duration, Instant};

    use cpu_time::ThreadTime;

    use super::{EVERY, Effort, own};

    /// A period that no callback of the tests comes near.
    const LONG: f64 = 10.0;

    fn works(seconds: f64) {
        let begin = ThreadTime::now();
        while begin.elapsed().as_secs_f64() < seconds {
            std::hint::spin_loop();
        }
    }

    #[test]
    fn what_a_callback_waits_is_not_what_it_works() {
        let mut effort = Effort::default();
        let mut callback = |work: f64, wait: f64, period: f64| {
            let begin = Instant::now();
            works(work);
            std::thread::sleep(Duration::from_secs_f64(wait));
            effort.of(begin.elapsed().as_secs_f64(), period)
        };
        // Nothing is known of the thread: all of it counts.
        assert!(callback(0.0, 0.005, 0.01) >= 0.005);
        for _ in 0..3 {
            let waits = callback(0.001, 0.02, 0.01);
            assert!((0.001..0.01).contains(&waits), "{waits}");
            // Reading says no less than what it worked.
            let works = callback(0.003, 0.0, 0.003);
            assert!(works >= 0.0029, "{works}");
        }
    }

    #[test]
    fn short_ones_count_as_long_as_they_took_and_the_clock_is_read_now_and_then() {
        let mut effort = Effort::default();
        let told: Vec<bool> = (0..3 * EVERY).map(|_| effort.of(0.1, LONG) == 0.1).collect();
        // The first reading has none before it; this thread has worked far less than a tenth of a second between two.
        let read: Vec<u32> = (1..).zip(&told).filter(|(_, whole)| !**whole).map(|(n, _)| n).collect();
        assert_eq!(read, [2 * EVERY, 3 * EVERY]);
    }

    #[test]
    fn what_another_thread_worked_is_nothing_to_it() {
        let at = |ms, thread| Some((Duration::from_millis(ms), thread));
        assert_eq!(own(at(5, 1), at(7, 1)), Some(0.002));
        assert_eq!((own(at(5, 1), at(7, 2)), own(at(5, 1), at(4, 1))), (None, None));
        assert_eq!((own(None, at(4, 1)), own(at(4, 1), None)), (None, None));
        let mut effort = Effort::default();
        assert_eq!(effort.of(LONG, LONG), LONG);
        std::thread::scope(|scope| {
            let there = scope.spawn(|| effort.of(LONG, LONG)).join();
            assert_eq!(there.ok(), Some(LONG));
        });
        assert!(effort.of(LONG, LONG) == LONG);
        effort.forget();
        assert_eq!(effort.of(LONG, LONG), LONG);
    }
}
