//! Polyphase interpolator design: a linear-phase FIR by weighted least squares with don't-care bands.
//!
//! The source holds nothing above [`CONTENT`], so only the pass band and the images k·rate ± `CONTENT` count; what lies
//! between is free. The Gram matrix is in closed form (integrals of cosines); a trace of ridge keeps it regular.

use super::biquad::Complex;
use std::f64::consts::TAU;

/// Highest frequency that counts, Hz: the band limit has left its pass band by then.
pub const CONTENT: f64 = 900.0;
/// Weight of the pass band against the images.
const PASS_WEIGHT: f64 = 0.05;
/// Ridge as a share of the mean diagonal.
const RIDGE: f64 = 1e-14;

/// Raises a rate by a whole ratio.
#[derive(Clone, Debug, PartialEq)]
pub struct Interpolator {
    /// Impulse response at the raised rate, `taps` × `ratio` values that sum to about `ratio`.
    pub response: Vec<f64>,
    /// Taps a phase.
    pub taps: usize,
    /// Ratio of the rates.
    pub ratio: usize,
    rate: f64,
}

impl Interpolator {
    /// `taps` (1 or more) a phase, from `rate` (Hz) to `ratio` × `rate`. A ratio of 1 passes samples as they are.
    pub fn design(taps: usize, ratio: usize, rate: f64) -> Self {
        if ratio <= 1 {
            return Self { response: vec![1.0], taps: 1, ratio: 1, rate };
        }
        let length = taps * ratio;
        let half = length.div_ceil(2);
        let high = rate * ratio as f64;
        // Tap k sits at ±(k + first) samples of the raised rate; the middle one of an odd length counts once.
        let first = if length.is_multiple_of(2) { 0.5 } else { 0.0 };
        let at = |k: usize| k as f64 + first;
        let count = |k: usize| if at(k) == 0.0 { 1.0 } else { 2.0 };
        let mut bands = vec![(0.0, CONTENT, PASS_WEIGHT)];
        for k in 1..=ratio / 2 {
            let centre = k as f64 * rate;
            bands.push((centre - CONTENT, (centre + CONTENT).min(high / 2.0), 1.0));
        }
        // ∫ cos(2π f t / high) df over a band, in units of the content's width.
        let integral = |from: f64, to: f64, t: f64| {
            let w = TAU * t / high;
            if w == 0.0 { (to - from) / CONTENT } else { ((to * w).sin() - (from * w).sin()) / (w * CONTENT) }
        };
        let mut gram = vec![0.0; half * half];
        let mut right = vec![0.0; half];
        for i in 0..half {
            right[i] = PASS_WEIGHT * count(i) * integral(0.0, CONTENT, at(i));
            for j in 0..=i {
                let mut sum = 0.0;
                for &(from, to, weight) in &bands {
                    sum += weight * (integral(from, to, at(i) - at(j)) + integral(from, to, at(i) + at(j)));
                }
                gram[i * half + j] = 0.5 * count(i) * count(j) * sum;
            }
        }
        let mean = (0..half).map(|i| gram[i * half + i]).sum::<f64>() / half as f64;
        let right = regular(&gram, &right, RIDGE * mean);
        let response = (0..length)
            .map(|n| {
                let from_middle = (n as f64 - (length - 1) as f64 / 2.0).abs();
                right[(from_middle - first).round() as usize] * ratio as f64
            })
            .collect();
        Self { response, taps, ratio, rate }
    }

    /// Delay in samples of the raised rate.
    pub fn delay(&self) -> f64 {
        (self.response.len() - 1) as f64 / 2.0
    }

    /// Response at `frequency` (Hz), 1 at 0 Hz.
    pub fn response(&self, frequency: f64) -> Complex {
        let step = -TAU * frequency / (self.rate * self.ratio as f64);
        let mut sum = Complex::default();
        for (n, &h) in self.response.iter().enumerate() {
            sum = sum + Complex::turned(step * n as f64) * (h / self.ratio as f64);
        }
        sum
    }
}

/// Solves the system with `ridge`, or with the least tenfold of it that keeps it regular in spite of rounding.
fn regular(matrix: &[f64], right: &[f64], ridge: f64) -> Vec<f64> {
    let n = right.len();
    let mut ridge = ridge;
    for _ in 0..8 {
        let (mut with, mut found) = (matrix.to_vec(), right.to_vec());
        for i in 0..n {
            with[i * n + i] += ridge;
        }
        if solve(&mut with, &mut found) {
            return found;
        }
        ridge *= 10.0;
    }
    right.to_vec()
}

/// Solves the symmetric positive system in place (Cholesky; only the lower triangle is read). Says whether rounding left it positive.
fn solve(matrix: &mut [f64], right: &mut [f64]) -> bool {
    let n = right.len();
    for i in 0..n {
        for j in 0..=i {
            let dot: f64 = (0..j).map(|k| matrix[i * n + k] * matrix[j * n + k]).sum();
            let rest = matrix[i * n + j] - dot;
            if i == j && rest <= 0.0 {
                return false;
            }
            matrix[i * n + j] = if i == j { rest.sqrt() } else { rest / matrix[j * n + j] };
        }
        let dot: f64 = (0..i).map(|k| matrix[i * n + k] * right[k]).sum();
        right[i] = (right[i] - dot) / matrix[i * n + i];
    }
    for i in (0..n).rev() {
        let dot: f64 = (i + 1..n).map(|k| matrix[k * n + i] * right[k]).sum();
        right[i] = (right[i] - dot) / matrix[i * n + i];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::Interpolator;

    /// Worst ripple to 850 Hz and worst image of content to 850 Hz, in decibels.
    fn figures(taps: usize, ratio: usize, rate: f64) -> (f64, f64) {
        let design = Interpolator::design(taps, ratio, rate);
        let decibel = |f: f64| 20.0 * design.response(f).abs().log10();
        let (mut ripple, mut image) = (0f64, -400f64);
        for f in (0..=850).step_by(10).map(f64::from) {
            ripple = ripple.max(decibel(f).abs());
            for k in 1..=ratio / 2 {
                image = image.max(decibel(k as f64 * rate - f)).max(decibel(k as f64 * rate + f));
            }
        }
        (ripple, image)
    }

    #[test]
    fn ripple_and_images_stay_small_at_every_ratio() {
        for (taps, worst) in [(4, -66.0), (6, -95.0), (8, -120.0), (12, -140.0)] {
            for (ratio, rate) in [(6, 8000.0), (6, 7350.0), (11, 8018.2), (12, 8000.0), (24, 8000.0)] {
                assert!(Interpolator::design(taps, ratio, rate).response.iter().all(|h| h.is_finite()));
                let (ripple, image) = figures(taps, ratio, rate);
                assert!(ripple < 0.02 && image < worst, "{taps} taps, {ratio} at {rate}: {ripple} {image}");
            }
        }
    }

    #[test]
    fn it_is_symmetric_and_a_ratio_of_one_is_nothing() {
        for (taps, ratio) in [(6, 6), (5, 11), (7, 3)] {
            let h = Interpolator::design(taps, ratio, 8000.0).response;
            assert_eq!(h.len(), taps * ratio);
            for n in 0..h.len() {
                assert_eq!(h[n], h[h.len() - 1 - n]);
            }
        }
        let none = Interpolator::design(6, 1, 8000.0);
        assert_eq!((none.delay(), none.response(300.0).abs()), (0.0, 1.0));
    }
}
