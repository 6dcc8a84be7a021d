//! Keeps a reader as far behind a writer as it should be, by reading a little faster or slower.
//!
//! A proportional and integral loop, critically damped, behind two low-passes that keep the jitter of callbacks out of the speed
//! (F. Adriaensen, "Controlling adaptive resampling", Linux Audio Conference 2012). The integral is what the two clocks
//! differ by, so that in the end no error is left.

#![deny(clippy::disallowed_methods)]

use std::f64::consts::TAU;

/// The loop's bandwidth, Hz: in the end, and at first.
const SLOW: f64 = 0.02;
const FAST: f64 = 1.0;

/// The low-passes', in shares of that.
const SMOOTH: f64 = 10.0;

/// The most by which the speed may differ from 1. Crystals are within a thousandth; the rest is for catching up.
pub const MOST: f64 = 0.005;

/// Follows a writer.
#[derive(Debug, Clone, Default)]
pub struct Tracker {
    smooth: [f64; 2],
    /// What the clocks differ by, as a share.
    drift: f64,
    /// Seconds since it began.
    age: f64,
}

impl Tracker {
    /// The reader was put where it should be; what is known of the clocks is kept.
    pub fn recentre(&mut self) {
        self.smooth = [0.0; 2];
    }

    /// The speed, about 1, for the next `seconds`, where the reader is `error` seconds further behind than it should be.
    pub fn speed(&mut self, error: f64, seconds: f64) -> f64 {
        let bandwidth = (FAST / (1.0 + self.age)).max(SLOW);
        self.age += seconds;
        let omega = TAU * bandwidth;
        let share = 1.0 - (-SMOOTH * omega * seconds).exp();
        self.smooth[0] += share * (error - self.smooth[0]);
        self.smooth[1] += share * (self.smooth[0] - self.smooth[1]);
        let error = self.smooth[1];
        self.drift = (self.drift + omega * omega * error * seconds).clamp(-MOST, MOST);
        1.0 + (self.drift + 2.0 * omega * error).clamp(-MOST, MOST)
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST, Tracker};

    /// The error after so many seconds, for a writer that is fast by `drift` and a reader that begins `error` seconds late.
    fn follow(drift: f64, error: f64, seconds: f64) -> (f64, f64) {
        let (mut tracker, mut error, step) = (Tracker::default(), error, 64.0 / 48_000.0);
        for _ in 0..(seconds / step) as usize {
            let speed = tracker.speed(error, step);
            error += step * (1.0 + drift - speed);
        }
        (error, tracker.drift)
    }

    #[test]
    fn in_the_end_no_error_is_left() {
        for drift in [-1e-3, -50e-6, 0.0, 200e-6, 1e-3] {
            let (error, found) = follow(drift, 0.002, 200.0);
            assert!(error.abs() < 1e-6 && (found - drift).abs() < 1e-6, "{drift}: {error} {found}");
        }
    }

    #[test]
    fn it_stays_stable_and_within_its_bounds_whatever_comes() {
        let mut tracker = Tracker::default();
        for n in 0..10_000 {
            let error = if n % 7 < 3 { 1e3 } else { -1e3 };
            let speed = tracker.speed(error, if n % 11 == 1 { 1.5 } else { 1e-4 });
            assert!((speed - 1.0).abs() <= MOST + 1e-12, "{speed}");
        }
        // Faster than it can follow: it goes as fast as it may.
        let (error, found) = follow(0.02, 0.0, 10.0);
        assert!(error > 0.1 && found == MOST);
    }
}
