//! The names of random draws.
//!
//! A key is a stream of [`crate::dsp::random`], derived from the key of what it is part of. Streams are derived with a
//! second name of at least 1 and words are read with 0 there, so no draw is ever another's key.

use crate::dsp::random;

const SCORE: u64 = 0x53_43_4F_52_45;
const TWO_TO_MINUS_53: f64 = 1.0 / 9_007_199_254_740_992.0;

/// Of one of the score's roots.
pub(super) fn root(seed: u64, index: u64) -> u64 {
    random::stream(seed, index, SCORE)
}

/// Of one round of a pattern that is played at an occurrence.
pub(super) fn round(occurrence: u64, round: u64) -> u64 {
    random::stream(occurrence, round, 1)
}

/// Of an event of a playing, the `k`th time.
pub(super) fn occurrence(playing: u64, event: u64, k: u64) -> u64 {
    random::stream(playing, event, k.saturating_add(1))
}

/// Draw number of an occurrence: how far its onset moves.
pub(super) const ONSET: u64 = 0;
/// Draw number of an occurrence: which alternative.
pub(super) const CHOICE: u64 = 1;
/// Draw number of an occurrence: the first field's deviation.
pub(super) const FRACTIONS: u64 = 2;

/// Uniform in [−1, 1).
pub(super) fn deviation(key: u64, draw: u64) -> f64 {
    2.0 * fraction(key, draw) - 1.0
}

/// Uniform in [0, 1), in steps of 2^−53.
pub(super) fn fraction(key: u64, draw: u64) -> f64 {
    (long(key, draw) >> 11) as f64 * TWO_TO_MINUS_53
}

fn long(key: u64, draw: u64) -> u64 {
    let words = random::words(key, draw);
    u64::from(words[0]) | u64::from(words[1]) << 32
}

/// A permutation of 0 to n − 1, each as likely (Fisher and Yates; Durstenfeld, CACM 7, 1964).
pub(super) fn permutation(playing: u64, n: usize) -> Box<[u32]> {
    let mut all: Box<[u32]> = (0..n).map(|i| u32::try_from(i).unwrap_or(u32::MAX)).collect();
    for i in (1..n).rev() {
        let j = (u128::from(long(playing, i as u64)) * (i as u128 + 1)) >> 64;
        all.swap(i, j as usize);
    }
    all
}

#[cfg(test)]
mod tests {
    use super::{deviation, fraction, permutation};

    #[test]
    fn every_permutation_is_as_likely() {
        let mut counts = std::collections::HashMap::new();
        let n = 24_000;
        for key in 0..n {
            *counts.entry(permutation(key, 4)).or_insert(0.0) += 1.0;
        }
        assert_eq!(counts.len(), 24);
        let chi: f64 = counts.values().map(|c: &f64| (c - 1000.0).powi(2) / 1000.0).sum();
        // 23 degrees of freedom: above 64 once in 100,000.
        assert!(chi < 64.0, "{chi}");
    }

    #[test]
    fn draws_fill_their_range() {
        let draws: Vec<f64> = (0..10_000).map(|i| fraction(5, i)).collect();
        assert!(draws.iter().all(|x| (0.0..1.0).contains(x)));
        assert!((draws.iter().sum::<f64>() / 1e4 - 0.5).abs() < 5.0 * (1.0_f64 / 12.0 / 1e4).sqrt());
        let draws: Vec<f64> = (0..10_000).map(|i| deviation(6, i)).collect();
        assert!(draws.iter().all(|x| (-1.0..1.0).contains(x)));
        assert!((draws.iter().sum::<f64>() / 1e4).abs() < 5.0 * (1.0_f64 / 3.0 / 1e4).sqrt());
    }
}
