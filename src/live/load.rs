//! How much of their time callbacks take.

#![deny(clippy::disallowed_methods)]

use std::sync::atomic::{AtomicU64, Ordering};

/// Octaves, from 2^-12 of a period to 16 periods, and bits of a number's fraction that tell the buckets of one.
const OCTAVES: usize = 16;
const LEAST: u64 = 12;
const FINE: u32 = 4;
const BUCKETS: usize = OCTAVES << FINE;

/// Where a share's first bits lie among all numbers', of which those of the first bucket are these: a number's bits rise with it.
const SHIFT: u32 = f64::MANTISSA_DIGITS - 1 - FINE;
const FIRST: u64 = (1023 - LEAST) << FINE;

/// A histogram of run time over period, written by one thread and read by others. Buckets are a sixteenth wide, or less.
#[derive(Debug)]
pub struct Load {
    buckets: [AtomicU64; BUCKETS],
    /// Callbacks that took longer than their period.
    over: AtomicU64,
    /// Sums of nanoseconds: of run time, and of periods.
    busy: AtomicU64,
    time: AtomicU64,
    /// The largest share, as bits of a number that is never negative.
    most: AtomicU64,
}

impl Default for Load {
    fn default() -> Self {
        let zero = || AtomicU64::new(0);
        Self {
            buckets: std::array::from_fn(|_| zero()),
            over: zero(),
            busy: zero(),
            time: zero(),
            most: zero(),
        }
    }
}

impl Load {
    /// A callback took `busy` of its `period`, both in seconds.
    pub fn note(&self, busy: f64, period: f64) {
        let share = busy / period;
        if !(share >= 0.0 && share.is_finite()) {
            return;
        }
        let bucket = (share.to_bits() >> SHIFT).saturating_sub(FIRST).min(BUCKETS as u64 - 1);
        add(&self.buckets[bucket as usize], 1);
        add(&self.over, u64::from(share > 1.0));
        add(&self.busy, (busy * 1e9) as u64);
        add(&self.time, (period * 1e9) as u64);
        if share > self.most() {
            self.most.store(share.to_bits(), Ordering::Relaxed);
        }
    }

    /// Callbacks so far.
    pub fn count(&self) -> u64 {
        self.buckets.iter().map(|bucket| bucket.load(Ordering::Relaxed)).sum()
    }

    /// Callbacks that took longer than their period.
    pub fn over(&self) -> u64 {
        self.over.load(Ordering::Relaxed)
    }

    /// The share of all time that callbacks took; 0 before the first.
    pub fn mean(&self) -> f64 {
        let time = self.time.load(Ordering::Relaxed);
        if time == 0 { 0.0 } else { self.busy.load(Ordering::Relaxed) as f64 / time as f64 }
    }

    /// The largest share.
    pub fn most(&self) -> f64 {
        f64::from_bits(self.most.load(Ordering::Relaxed))
    }

    /// The share that `part` of all callbacks (0 to 1) do not pass, to the next bucket's edge; 0 before the first.
    pub fn quantile(&self, part: f64) -> f64 {
        let wanted = (self.count() as f64 * part).ceil();
        let mut sum = 0.0;
        for (number, bucket) in self.buckets.iter().enumerate() {
            sum += bucket.load(Ordering::Relaxed) as f64;
            if sum > 0.0 && sum >= wanted {
                // The last one has all that is more.
                let last = number == BUCKETS - 1;
                let edge = f64::from_bits((FIRST + number as u64 + 1) << SHIFT);
                return if last { self.most() } else { edge.min(self.most()) };
            }
        }
        0.0
    }
}

/// One thread alone writes, so that nothing has to be kept from others meanwhile.
fn add(figure: &AtomicU64, more: u64) {
    figure.store(figure.load(Ordering::Relaxed).wrapping_add(more), Ordering::Relaxed);
}

#[cfg(test)]
mod tests {
    use super::Load;

    #[test]
    fn quantiles_lie_within_a_bucket_of_the_sorted_list() {
        let load = Load::default();
        assert_eq!((load.count(), load.quantile(0.5), load.mean()), (0, 0.0, 0.0));
        let shares: Vec<f64> = (1..=1000).map(|n| f64::from(n) * 0.0011).collect();
        shares.iter().for_each(|share| load.note(share * 1e-3, 1e-3));
        for part in [0.001, 0.1, 0.5, 0.9, 0.999, 1.0] {
            let exact = shares[(part * 1000.0_f64).ceil() as usize - 1];
            let found = load.quantile(part);
            assert!(found >= exact * 0.999_999 && found <= exact * 1.0625, "{part}: {found} for {exact}");
        }
        assert_eq!((load.count(), load.over()), (1000, 91));
        assert!((load.most() - 1.1).abs() < 1e-9 && (load.mean() - 0.550_55).abs() < 1e-4);
        load.note(0.0, 1e-3);
        load.note(1e-30, 1e-3);
        assert_eq!(load.quantile(0.001), f64::exp2(-12.0) * 1.0625, "the first bucket has all that is less");
        load.note(0.155, 1e-3);
        assert!((load.quantile(1.0) - 155.0).abs() < 1e-9, "the last bucket has all that is more");
        load.note(f64::NAN, 1e-3);
        load.note(1.0, 0.0);
        load.note(5.0, 1e-9);
        assert_eq!(load.count(), 1004);
    }
}
