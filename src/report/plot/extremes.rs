//! The least and greatest sample of each stretch of time, at a resolution that halves as the signal grows.

/// Columns that are never exceeded; from half of them on the resolution is what a picture needs.
const COLUMNS: usize = 4000;

/// Least and greatest of the samples of each column. All columns but the last hold equally many samples.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Extremes {
    per_column: u64,
    /// Samples in the last column.
    filled: u64,
    columns: Vec<[f32; 2]>,
}

impl Extremes {
    /// `expected` is a guess of the number of samples, 0 for none: a good one has no effect but fewer halvings on the way.
    pub fn new(expected: u64) -> Self {
        Self { per_column: expected.div_ceil(COLUMNS as u64).max(1), filled: 0, columns: Vec::new() }
    }

    pub fn push(&mut self, sample: f32) {
        match self.columns.last_mut() {
            Some([low, high]) if self.filled < self.per_column => {
                *low = low.min(sample);
                *high = high.max(sample);
                self.filled += 1;
                return;
            }
            _ => {}
        }
        if self.columns.len() == COLUMNS {
            self.columns = joined(&self.columns, 2);
            self.per_column = self.per_column.saturating_mul(2);
        }
        self.columns.push([sample; 2]);
        self.filled = 1;
    }

    /// At most `most` columns, and the samples that each of them holds.
    pub fn at_most(&self, most: usize) -> (u64, Vec<[f32; 2]>) {
        let group = self.columns.len().div_ceil(most.max(1)).max(1);
        (self.per_column * group as u64, joined(&self.columns, group))
    }
}

fn joined(columns: &[[f32; 2]], group: usize) -> Vec<[f32; 2]> {
    columns
        .chunks(group)
        .map(|few| {
            few.iter()
                .fold([f32::INFINITY, f32::NEG_INFINITY], |all, one| [all[0].min(one[0]), all[1].max(one[1])])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{COLUMNS, Extremes};

    fn signal(length: usize) -> Vec<f32> {
        (0..length).map(|n| ((n * n % 9973) as f32 / 5000.0 - 1.0) * (n as f32 * 0.001).cos()).collect()
    }

    #[test]
    fn columns_hold_exactly_the_extremes_of_their_samples() {
        for length in [0, 1, 3999, 4000, 4001, 8000, 100_003] {
            for expected in [0, 1, 50_000, 1_000_000] {
                let signal = signal(length);
                let mut extremes = Extremes::new(expected);
                signal.iter().for_each(|x| extremes.push(*x));
                for most in [1, 7, 1000, COLUMNS] {
                    let (samples, columns) = extremes.at_most(most);
                    assert!(columns.len() <= most);
                    let by_hand: Vec<[f32; 2]> = signal
                        .chunks(samples as usize)
                        .map(|c| {
                            [
                                c.iter().copied().fold(f32::MAX, f32::min),
                                c.iter().copied().fold(f32::MIN, f32::max),
                            ]
                        })
                        .collect();
                    assert_eq!(columns, by_hand, "{length} samples, {expected} expected, at most {most}");
                }
            }
        }
    }

    #[test]
    fn resolution_is_never_below_half_the_columns() {
        let mut extremes = Extremes::new(0);
        for n in 1..30_000 {
            extremes.push(n as f32);
            let columns = extremes.columns.len();
            assert!((n.min(COLUMNS / 2)..=COLUMNS).contains(&columns), "{columns} after {n}");
        }
    }
}
