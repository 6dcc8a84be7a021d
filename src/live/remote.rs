//! A knob that another thread talks to: its angle is heard as an input is, its torque goes back.
//!
//! Two cells hold the newest of each, and neither side ever waits for the other. Every torque carries the time of the angle that it was made
//! of. One that is older than was allowed for is none: so whatever stops, the line, the callback or a thread, torque does not outlast it.

#![deny(clippy::disallowed_methods)]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::intake::Hearing;
use super::stamp::nanoseconds;
use crate::knob::angle::decoder::NOT_HEARD;
use crate::knob::local_model::link::{Cell, Seen};

#[derive(Debug, Default)]
struct Shared {
    /// Nanoseconds and angle, written by the line's thread.
    angle: Cell,
    /// Nanoseconds of the angle, and the torque that it gave, written by the callback.
    torque: Cell,
    /// Nanoseconds of the angle that the callback hears; 0: none.
    heard: AtomicU64,
    /// Whether torque came too late at the line's end, and whether it is wanted at all.
    late: AtomicBool,
    wanted: AtomicBool,
}

/// The end of the thread that talks to the knob.
#[derive(Debug)]
pub struct Line {
    shared: Arc<Shared>,
    /// The oldest that an angle may be when its torque is there, nanoseconds.
    oldest: u64,
    torque: Seen,
}

/// The callback's end: what it hears.
#[derive(Debug)]
pub struct Heard {
    shared: Arc<Shared>,
    /// The oldest that an angle may be when it is heard, nanoseconds.
    oldest: u64,
    amplitude: f64,
    channels: [usize; 2],
    seen: Seen,
    /// The angle at the end of the last block.
    before: Option<f64>,
}

/// The callback's end: what it gives.
#[derive(Debug)]
pub struct Given {
    shared: Arc<Shared>,
}

/// Whole nanoseconds of so many seconds.
fn whole(seconds: f64) -> u64 {
    (seconds * 1e9).clamp(0.0, 1e18) as u64
}

/// Both ends of a knob that may take `allowance` seconds from an angle to its torque, and `patience` until the next angle. It is heard as
/// sine and cosine of `amplitude` on two `channels`.
pub fn remote(allowance: f64, patience: f64, amplitude: f64, channels: [usize; 2]) -> (Heard, Line) {
    let shared = Arc::<Shared>::default();
    let line = Line { shared: Arc::clone(&shared), oldest: whole(allowance), torque: Seen::default() };
    let oldest = whole(patience);
    (Heard { shared, oldest, amplitude, channels, seen: Seen::default(), before: None }, line)
}

impl Line {
    /// The angle, radians, read just now.
    pub fn put(&mut self, angle: f64) {
        self.put_at(nanoseconds(), angle);
    }

    fn put_at(&mut self, now: u64, angle: f64) {
        // 0 stands for none.
        self.shared.angle.write(&Seen { tick: now.max(1), angle, ..Seen::default() });
    }

    /// There is no angle any more.
    pub fn lose(&mut self) {
        self.shared.angle.write(&Seen::default());
    }

    /// The torque to give now, N m.
    pub fn torque(&mut self) -> f64 {
        self.torque_at(nanoseconds())
    }

    fn torque_at(&mut self, now: u64) -> f64 {
        // While it is being written it is the one before.
        self.torque = self.shared.torque.read().unwrap_or(self.torque);
        let Seen { tick, torque, .. } = self.torque;
        let late = tick == 0 || now.saturating_sub(tick) > self.oldest;
        // Before the first there is nothing to be late.
        self.shared.late.store(late && tick != 0, Ordering::Relaxed);
        if late || !torque.is_finite() { 0.0 } else { torque }
    }

    /// Whether somebody wants torque, and nothing has taken it away.
    pub fn is_wanted(&self) -> bool {
        self.shared.wanted.load(Ordering::Relaxed)
    }
}

impl Heard {
    /// What the callback gives back.
    pub fn given(&self) -> Given {
        Given { shared: Arc::clone(&self.shared) }
    }

    fn hear_at(&mut self, now: u64, channels: usize, frames: &mut [f32]) {
        self.seen = self.shared.angle.read().unwrap_or(self.seen);
        let Seen { tick, angle, .. } = self.seen;
        let channels = channels.max(1);
        if tick == 0 || now.saturating_sub(tick) > self.oldest || !angle.is_finite() {
            self.before = None;
            self.shared.heard.store(0, Ordering::Relaxed);
            frames.fill(NOT_HEARD);
            return;
        }
        self.shared.heard.store(tick, Ordering::Relaxed);
        // Straight from one reading to the next, so that speeds are no steps.
        let from = self.before.replace(angle).unwrap_or(angle);
        let count = (frames.len() / channels) as f64;
        for (n, frame) in frames.chunks_exact_mut(channels).enumerate() {
            let (sine, cosine) = (from + (angle - from) * (n + 1) as f64 / count).sin_cos();
            frame.fill(0.0);
            for (channel, value) in self.channels.into_iter().zip([sine, cosine]) {
                if let Some(slot) = frame.get_mut(channel) {
                    *slot = (self.amplitude * value) as f32;
                }
            }
        }
    }
}

impl Hearing for Heard {
    fn hear(&mut self, _due: f64, channels: usize, frames: &mut [f32]) {
        self.hear_at(nanoseconds(), channels, frames);
    }

    fn mark(&mut self, _channels: &[usize]) {}
}

impl Given {
    /// The torque, N m, that came of what is heard now.
    pub fn put(&self, torque: f64, wanted: bool) {
        let tick = self.shared.heard.load(Ordering::Relaxed);
        self.shared.wanted.store(wanted, Ordering::Relaxed);
        self.shared.torque.write(&Seen { tick, torque, ..Seen::default() });
    }

    /// Whether what was given came in time.
    pub fn in_time(&self) -> bool {
        !self.shared.late.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::{NOT_HEARD, remote};

    const MS: u64 = 1_000_000;

    /// Frames that were heard, as angles; `None`: not heard.
    fn angles(frames: &[f32]) -> Vec<Option<f64>> {
        let of = |frame: &[f32]| match frame[1] {
            NOT_HEARD => None,
            _ => Some(f64::from(frame[0]).atan2(f64::from(frame[1]))),
        };
        frames.chunks(2).map(of).collect()
    }

    #[test]
    fn an_angle_is_heard_straight_from_the_one_before_and_no_longer_than_patience_lasts() {
        let (mut heard, mut line) = remote(0.01, 0.004, 0.5, [0, 1]);
        let mut hear = |now: u64| {
            let mut frames = [0.0; 8];
            heard.hear_at(now * MS, 2, &mut frames);
            angles(&frames)
        };
        assert_eq!(hear(1), [None; 4], "nothing was read yet");
        line.put_at(2 * MS, 0.2);
        let near = |got: Vec<Option<f64>>, want: [f64; 4]| {
            got.iter().zip(want).all(|(got, want)| got.is_some_and(|got| (got - want).abs() < 1e-6))
        };
        assert!(near(hear(3), [0.2; 4]));
        line.put_at(4 * MS, 0.6);
        assert!(near(hear(5), [0.3, 0.4, 0.5, 0.6]));
        assert!(near(hear(8), [0.6; 4]));
        assert_eq!(hear(9), [None; 4], "5 ms old");
        line.put_at(10 * MS, 1.0);
        // Where it was lost it begins anew.
        assert!(near(hear(10), [1.0; 4]));
        line.lose();
        assert_eq!(hear(10), [None; 4]);
        line.put_at(11 * MS, f64::NAN);
        assert_eq!(hear(11), [None; 4]);
    }

    #[test]
    fn no_torque_outlasts_the_angle_that_it_was_made_of() {
        let (mut heard, mut line) = remote(0.01, 0.004, 0.5, [0, 1]);
        let given = heard.given();
        assert_eq!((line.torque_at(0), given.in_time(), line.is_wanted()), (0.0, true, false));
        line.put_at(5 * MS, 0.2);
        heard.hear_at(6 * MS, 2, &mut [0.0; 8]);
        // One that comes meanwhile is not the one that was heard.
        line.put_at(7 * MS, 0.3);
        given.put(0.03, true);
        assert_eq!((line.torque_at(15 * MS), given.in_time(), line.is_wanted()), (0.03, true, true));
        assert_eq!((line.torque_at(16 * MS), given.in_time()), (0.0, false));
        heard.hear_at(10 * MS, 2, &mut [0.0; 8]);
        given.put(f64::NAN, true);
        assert_eq!((line.torque_at(16 * MS), given.in_time()), (0.0, true), "it is no number");
        // What was made of nothing is none, and not late.
        heard.hear_at(30 * MS, 2, &mut [0.0; 8]);
        given.put(0.02, false);
        assert_eq!((line.torque_at(30 * MS), given.in_time(), line.is_wanted()), (0.0, true, false));
    }
}
