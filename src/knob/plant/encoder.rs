//! What a controller knows of the angle: counts of an encoder, some ticks late.

use crate::actuator::fault::{Fault, Limit, check, within};
use std::f64::consts::TAU;

/// Delays beyond this, in ticks, are refused.
pub const MOST_DELAY: usize = 4096;

/// An incremental encoder, read in quadrature: θ_q = δ ⌊θ/δ⌋ with δ = 2π / (4 lines).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Encoder {
    counts: f64,
    quantum: f64,
}

impl Encoder {
    /// Of so many lines a turn, 0.25 to 1e8: a turn has four counts a line.
    ///
    /// # Errors
    /// Lines beyond those, or that make no whole number of counts.
    pub fn new(lines: f64) -> Result<Self, Fault> {
        within("lines", lines, (0.25, 1e8), "a turn")?;
        Self::of_counts(4.0 * lines)
    }

    /// Of so many counts a turn, 1 to 4e8.
    ///
    /// # Errors
    /// Counts beyond those, or that are no whole number.
    pub fn of_counts(counts: f64) -> Result<Self, Fault> {
        within("counts", counts, (1.0, 4e8), "a turn")?;
        if counts.fract() != 0.0 {
            let limit = Limit::Least(counts.ceil());
            return Err(Fault {
                field: "counts",
                value: counts,
                limit,
                because: Some("a turn has a whole number of counts"),
            });
        }
        Ok(Self { counts, quantum: TAU / counts })
    }

    /// The angle of a count, δ, rad.
    pub fn quantum(&self) -> f64 {
        self.quantum
    }

    /// Whole counts at an angle, rad: rounded downwards, and 0 for what is no number. It holds 2^63 of them.
    pub fn count(&self, angle: f64) -> i64 {
        (angle / self.quantum).floor() as i64
    }

    /// What a counter of 32 bits shows: it wraps at ±2^31.
    pub fn register(&self, angle: f64) -> i32 {
        self.count(angle) as i32
    }

    /// Counts a turn.
    pub fn counts(&self) -> f64 {
        self.counts
    }

    /// The angle read, rad.
    pub fn read(&self, angle: f64) -> f64 {
        self.quantum * self.count(angle) as f64
    }
}

/// Unwraps a counter of 32 bits that moves by less than 2^31 between two readings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Unwrap {
    count: i64,
}

impl Unwrap {
    /// Begins at a count.
    pub fn new(count: i64) -> Self {
        Self { count }
    }

    /// All counts, at a register's next reading.
    pub fn read(&mut self, register: i32) -> i64 {
        let moved = register.wrapping_sub(self.count as i32);
        self.count = self.count.wrapping_add(i64::from(moved));
        self.count
    }
}

/// A reading some ticks late. Before the first, all was as the initial reading.
#[derive(Debug, Clone)]
pub struct Delay {
    past: Vec<f64>,
    next: usize,
}

impl Delay {
    /// Of so many ticks, 0 to [`MOST_DELAY`], after which `initial` has been read for ever.
    ///
    /// # Errors
    /// More ticks than that.
    pub fn new(ticks: usize, initial: f64) -> Result<Self, Fault> {
        check("delay", ticks as f64, Limit::Most(MOST_DELAY as f64))?;
        Ok(Self { past: vec![initial; ticks], next: 0 })
    }

    /// Takes what is read now and gives what was read the delay ago.
    #[inline]
    pub fn pass(&mut self, now: f64) -> f64 {
        let Some(slot) = self.past.get_mut(self.next) else { return now };
        let before = std::mem::replace(slot, now);
        self.next += 1;
        if self.next == self.past.len() {
            self.next = 0;
        }
        before
    }

    /// All of the past as `initial` again.
    pub fn reset(&mut self, initial: f64) {
        self.past.fill(initial);
    }
}

#[cfg(test)]
mod tests {
    use super::{Delay, Encoder, Unwrap};

    #[test]
    fn counts_are_rounded_downwards() {
        let encoder = Encoder::new(1000.0).unwrap();
        assert_eq!(encoder, Encoder::of_counts(4000.0).unwrap());
        let q = encoder.quantum();
        assert_eq!(
            [0.0, 0.5, 0.999_999, -1e-6, -1.0, -1.000_001].map(|x| encoder.count(x * q)),
            [0, 0, 0, -1, -1, -2]
        );
        assert_eq!(encoder.read(7.5 * q), 7.0 * q);
        assert_eq!((encoder.count(f64::NAN), encoder.count(f64::INFINITY)), (0, i64::MAX));
        assert!(
            Encoder::new(0.0).is_err() && Encoder::of_counts(3.5).is_err() && Encoder::new(f64::NAN).is_err()
        );
    }

    #[test]
    fn counts_go_on_where_a_register_wraps() {
        let encoder = Encoder::of_counts(4000.0).unwrap();
        for start in [i64::from(i32::MAX) - 3, i64::from(i32::MIN) + 3] {
            let at = |n: i64| (n as f64 + 0.5) * encoder.quantum();
            let mut unwrap = Unwrap::new(start);
            for step in [1, 3, 700, -1400, 2_000_000_000, -2_100_000_000] {
                let count = start + step;
                assert_eq!(encoder.count(at(count)), count);
                assert_eq!(unwrap.read(encoder.register(at(count))), count);
                unwrap = Unwrap::new(start);
            }
        }
    }

    #[test]
    fn a_delay_is_as_many_ticks_and_begins_with_the_first_reading() {
        for ticks in [0, 1, 2, 7] {
            let mut delay = Delay::new(ticks, -1.0).unwrap();
            for n in 0..30 {
                let expected = if n < ticks { -1.0 } else { (n - ticks) as f64 };
                assert_eq!(delay.pass(n as f64), expected);
            }
            delay.reset(5.0);
            assert_eq!(delay.pass(1.0), if ticks == 0 { 1.0 } else { 5.0 });
        }
        assert!(Delay::new(1 << 20, 0.0).is_err());
    }
}
