//! The low pass for the gains of a point that crosses from one piece of an array to the next.

/// A low pass of boxes: pieces of an engine sample, in each of which a gain counts by its mean.
#[derive(Debug, Clone, Copy)]
pub(super) struct Kernel {
    /// Boxes to an engine sample.
    pub(super) boxes: usize,
    /// The weights of its boxes from the first to the last, symmetric, 1 in sum.
    pub(super) weights: &'static [f64],
}

/// For points that take less than [`SLOW`] of the array's spacing in an engine sample.
///
/// A mean over one sample, made up for to the second order.
pub(super) const COARSE: Kernel = Kernel { boxes: 1, weights: &[-1.0 / 24.0, 13.0 / 12.0, -1.0 / 24.0] };

/// For all others: of those with so flat a pass band, the one with which the sum of squares of gains that begin as √t swings least.
pub(super) const FINE: Kernel = Kernel {
    boxes: 3,
    weights: &[
        0.000_342_443_994,
        -0.008_763_089_890,
        0.008_382_051_597,
        0.009_334_311_324,
        0.023_132_398_626,
        -0.036_040_705_888,
        -0.045_207_667_736,
        -0.040_319_283_308,
        0.132_114_460_615,
        0.266_004_307_705,
        0.382_041_545_922,
        0.266_004_307_705,
        0.132_114_460_615,
        -0.040_319_283_308,
        -0.045_207_667_736,
        -0.036_040_705_888,
        0.023_132_398_626,
        0.009_334_311_324,
        0.008_382_051_597,
        -0.008_763_089_890,
        0.000_342_443_994,
    ],
};

/// The share of the spacing from which on the finer one is used.
pub(super) const SLOW: f64 = 0.0095;

/// The same share of the width, of a point that has one: a narrow one changes gains within less than the spacing.
pub(super) const SLOW_OF_WIDTH: f64 = 0.05;

/// The share of the spacing in an engine sample from which on weights of a surface, which are parabolas, are not as good as straight in half a box.
pub(super) const QUICK: f64 = 0.05;

/// The same for those of a width: below it they go straight over a box to the last 80 dB, between the two over its half.
pub(super) const BRISK: f64 = 0.02;

impl Kernel {
    /// When one of its boxes begins: whole engine samples from now, and a share of one. From every sample that share is the same to the bit.
    pub(super) fn edge(self, number: usize) -> (i64, f64) {
        let (per, count) = (self.boxes as i64, self.weights.len() as i64);
        // There are as many before now as after, so that an edge lies half a sample from it; in sixths, or halves, of a sample.
        let halves = 2 * number as i64 - count;
        (halves.div_euclid(2 * per), halves.rem_euclid(2 * per) as f64 / (2 * per) as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::{COARSE, FINE, Kernel};

    /// The response at a frequency in shares of the engine's rate.
    fn response(kernel: Kernel, f: f64) -> f64 {
        let middle = 0.5 * (kernel.weights.len() - 1) as f64;
        let box_width = std::f64::consts::PI * f / kernel.boxes as f64;
        let of_box = if box_width == 0.0 { 1.0 } else { box_width.sin() / box_width };
        let sum: f64 = kernel
            .weights
            .iter()
            .enumerate()
            .map(|(k, w)| w * (2.0 * box_width * (k as f64 - middle)).cos())
            .sum();
        of_box * sum
    }

    /// The largest magnitude of what `of` says within a band.
    fn most(low: f64, high: f64, of: impl Fn(f64) -> f64) -> f64 {
        (0..=400).map(|n| of(low + (high - low) * f64::from(n) / 400.0).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn what_signals_meet_passes_and_what_would_fold_onto_them_does_not() {
        for (kernel, ripple, floors) in
            [(FINE, 0.0006, [-45.9, -53.9, -20.0]), (COARSE, 0.033, [-8.8, -16.0, -20.0])]
        {
            assert!((response(kernel, 0.0) - 1.0).abs() < 1e-11);
            assert!(most(0.0, 0.27, |f| response(kernel, f) - 1.0) < ripple);
            for (n, floor) in floors.into_iter().enumerate() {
                let about = (n + 1) as f64;
                let db = 20.0 * most(about - 0.27, about + 0.27, |f| response(kernel, f)).log10();
                assert!(db < floor, "{about}: {db}");
            }
        }
    }
}
