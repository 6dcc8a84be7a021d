//! A point in engine time.

use std::ops::Add;

/// A count of engine samples and a fraction of one (2^32 is a whole sample).
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default)]
pub struct Instant {
    /// Whole engine samples since the engine began.
    pub sample: u64,
    /// The rest, in 2^-32 samples.
    pub fraction: u32,
}

const ONE: f64 = 4_294_967_296.0;

impl Instant {
    /// The latest instant there is: nothing is due then.
    pub const NEVER: Self = Self { sample: u64::MAX, fraction: u32::MAX };

    /// The instant `samples` after the beginning; before the beginning and not-a-number count as the beginning, and what
    /// lies past the end of time as [`Instant::NEVER`].
    pub fn of_samples(samples: f64) -> Self {
        if samples >= 1.8e19 {
            return Self::NEVER;
        }
        let samples = if samples > 0.0 { samples } else { 0.0 };
        let whole = samples.floor();
        Self { sample: whole as u64, fraction: ((samples - whole) * ONE) as u32 }
    }

    /// The first engine sample that lies at or after this instant.
    pub fn ceiling(self) -> u64 {
        self.sample.saturating_add(u64::from(self.fraction > 0))
    }

    /// The first instant that takes effect with engine sample `sample`, as its [`Instant::ceiling`]: nothing that still does lies before it.
    pub fn first_of(sample: u64) -> Self {
        match sample.checked_sub(1) {
            Some(before) => Self { sample: before, fraction: 1 },
            None => Self::default(),
        }
    }

    /// Samples from this instant to engine sample `sample`, negative where the instant lies later.
    pub fn until(self, sample: u64) -> f64 {
        let (whole, less) = self.apart(sample);
        whole as f64 - less
    }

    /// The same as whole samples, and the share of one that is less.
    pub fn apart(self, sample: u64) -> (i64, f64) {
        (sample.wrapping_sub(self.sample) as i64, f64::from(self.fraction) / ONE)
    }

    /// Samples from `earlier` to this instant.
    pub fn since(self, earlier: Self) -> f64 {
        earlier.until(self.sample) + f64::from(self.fraction) / ONE
    }
}

impl Add<f64> for Instant {
    type Output = Self;

    /// This instant and `samples` more (at least 0); saturates at [`Instant::NEVER`].
    fn add(self, samples: f64) -> Self {
        let more = Self::of_samples(samples);
        let (fraction, carry) = self.fraction.overflowing_add(more.fraction);
        match self.sample.checked_add(more.sample).and_then(|s| s.checked_add(u64::from(carry))) {
            Some(sample) if more != Self::NEVER => Self { sample, fraction },
            _ => Self::NEVER,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Instant;

    #[test]
    fn instants_keep_their_fraction() {
        let t = Instant::of_samples(10.25);
        assert_eq!((t.sample, t.ceiling()), (10, 11));
        assert_eq!(t.until(12), 1.75);
        assert_eq!(t.until(10), -0.25);
        assert_eq!((t + 0.75).sample, 11);
        assert_eq!((t + 0.75).fraction, 0);
        assert_eq!((t + 5.5).since(t), 5.5);
        assert_eq!(Instant::of_samples(7.0).ceiling(), 7);
    }

    #[test]
    fn the_first_instant_of_a_sample_is_before_all_others_of_it() {
        for sample in [0, 1, 2, 8_000, u64::MAX] {
            let first = Instant::first_of(sample);
            assert_eq!(first.ceiling(), sample);
            let before = match first.fraction {
                0 => continue,
                fraction => Instant { fraction: fraction - 1, ..first },
            };
            assert_eq!(before.ceiling(), sample - 1);
        }
        assert_eq!(Instant::first_of(0), Instant::of_samples(0.0));
    }

    #[test]
    fn hostile_times_saturate() {
        assert_eq!(Instant::of_samples(f64::NAN), Instant::default());
        assert_eq!(Instant::of_samples(-1.0), Instant::default());
        assert_eq!(Instant::of_samples(f64::INFINITY), Instant::NEVER);
        assert_eq!(Instant::of_samples(3.0) + f64::INFINITY, Instant::NEVER);
        assert_eq!(Instant { sample: u64::MAX - 1, fraction: 0 } + 10.0, Instant::NEVER);
        assert_eq!(Instant::NEVER.ceiling(), u64::MAX);
    }
}
