//! What a converter gives between its samples: all that is below half its rate, and nothing beyond.
//!
//! Where a source goes into something linear it may as well be held for each sample; a rectifier makes another mean of a held carrier than of
//! the smooth one that a real converter gives, by hundredths where a turn has twelve samples and by more where it has three.
//!
//! Each sample stands in the middle of its frame, where what is held for the frame has its mean: what is joined is not later than what is held.
//! That takes the [`LATE`] samples that follow, which are sinc in a window: what is below 0.45 of the rate comes out within 2e-6 of it.

use crate::actuator::fault::{Fault, within};
use crate::dsp::sinc::weights;

/// Samples that must follow one before it is known what is given in its frame.
pub const LATE: usize = 48;

/// Samples that count for a frame.
const TAPS: usize = 2 * LATE + 1;

/// Parts of a frame, at most.
pub const MOST_PARTS: u32 = 256;

/// A converter in time.
#[derive(Debug, Clone, PartialEq)]
pub struct Converter {
    /// What the samples weigh in the middle of each part of a frame.
    rows: Vec<[f64; TAPS]>,
    /// The last samples twice in a row, so that they always lie side by side somewhere, and where the oldest is.
    samples: [f64; 2 * TAPS],
    oldest: usize,
    /// Samples since the last that was not 0.
    silent: usize,
}

impl Converter {
    /// Silent, with frames in so many parts, 1 to [`MOST_PARTS`].
    ///
    /// # Errors
    /// A number of parts that cannot be.
    pub fn new(parts: u32) -> Result<Self, Fault> {
        within("parts", f64::from(parts), (1.0, f64::from(MOST_PARTS)), "of a frame")?;
        let row = |n: u32| {
            let place = (f64::from(n) + 0.5) / f64::from(parts) - 0.5;
            let mut row = [0.0; TAPS];
            for (index, weight) in weights(place, LATE as f64) {
                if let Some(slot) = row.get_mut((index + LATE as i64) as usize) {
                    *slot = weight;
                }
            }
            row
        };
        Ok(Self { rows: (0..parts).map(row).collect(), samples: [0.0; 2 * TAPS], oldest: 0, silent: TAPS })
    }

    /// Parts of a frame.
    pub fn parts(&self) -> usize {
        self.rows.len()
    }

    /// Takes a sample, and gives what leaves in the middle of each part of the frame [`LATE`] samples before it. Silence is exactly 0.
    #[inline]
    pub fn step(&mut self, sample: f64, parts: &mut [f64]) {
        self.silent = if sample == 0.0 { self.silent.saturating_add(1) } else { 0 };
        (self.samples[self.oldest], self.samples[self.oldest + TAPS]) = (sample, sample);
        self.oldest = if self.oldest + 1 == TAPS { 0 } else { self.oldest + 1 };
        if self.silent >= TAPS {
            return parts.fill(0.0);
        }
        let last = &self.samples[self.oldest..self.oldest + TAPS];
        for (part, row) in parts.iter_mut().zip(&self.rows) {
            // Four sums side by side, always in the same order.
            let mut sums = [0.0; 4];
            for (weights, samples) in row.chunks(4).zip(last.chunks(4)) {
                for (sum, (weight, sample)) in sums.iter_mut().zip(weights.iter().zip(samples)) {
                    *sum += weight * sample;
                }
            }
            *part = (sums[0] + sums[2]) + (sums[1] + sums[3]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Converter, LATE, MOST_PARTS, TAPS};
    use std::f64::consts::TAU;

    /// A tone is itself between its samples, each of which is in the middle of its frame; to 0.45 of the rate, beyond which no carrier goes.
    #[test]
    fn a_tone_is_itself_between_its_samples() {
        for parts in [1, 2, 5, 16] {
            for share in [0.0, 0.01, 1.0 / 12.0, 0.25, 1.0 / 3.0, 0.45] {
                let mut converter = Converter::new(parts).unwrap();
                let wave = |x: f64| (TAU * share * x + 0.3).cos();
                let mut out = vec![0.0; parts as usize];
                for n in 0..400 {
                    converter.step(wave(f64::from(n)), &mut out);
                    if n < 2 * LATE as u32 + 1 {
                        continue;
                    }
                    for (part, is) in out.iter().enumerate() {
                        let at = f64::from(n) - LATE as f64 - 0.5 + (part as f64 + 0.5) / f64::from(parts);
                        assert!((is - wave(at)).abs() < 2e-6, "{parts} {share} {n}: {is} {}", wave(at));
                    }
                }
            }
        }
    }

    #[test]
    fn silence_is_nothing_and_a_single_sample_is_what_it_weighs() {
        let mut converter = Converter::new(4).unwrap();
        let mut out = [1.0; 4];
        converter.step(0.0, &mut out);
        assert_eq!((out, converter.parts()), ([0.0; 4], 4));
        let all: Vec<f64> = (0..2 * TAPS)
            .flat_map(|n| {
                converter.step(if n == 0 { 1.0 } else { 0.0 }, &mut out);
                out
            })
            .collect();
        // As much before it as after, of the size of one sample, and then exactly nothing.
        let (middle, whole) = (LATE * 4, &all[..(2 * LATE + 1) * 4]);
        assert!(whole.iter().zip(whole.iter().rev()).all(|(a, b)| (a - b).abs() < 1e-12));
        assert!((whole.iter().sum::<f64>() / 4.0 - 1.0).abs() < 1e-6 && whole[middle + 1] > 0.97);
        assert!(all[whole.len()..].iter().all(|x| *x == 0.0));
    }

    #[test]
    fn what_cannot_be_is_refused() {
        for parts in [0, MOST_PARTS + 1] {
            assert_eq!(Converter::new(parts).unwrap_err().field, "parts");
        }
    }
}
