//! All roots of a loop's characteristic equation.
//!
//! With w = z − 1 it is D(w) z^m + N(w) C(w) = 0: three short polynomials and one long delay; with an estimator that looks back
//! over n ticks, or a spring that is sooner than the damping, further ones, P(w) z^n. Companion matrices of 500 rows would
//! spread the delay over rounding errors; here z^m is one power, so that a root costs the same however long the delay is. The
//! roots are found together by the iteration of Ehrlich (1967) and Aberth (1973). They are kept as w, so that a root's distance
//! from the unit circle, (2 Re w + |w|²) / (1 + |z|), has all its digits where it matters: close to 1.

use crate::dsp::complex::Complex;

const MOST_SWEEPS: usize = 400;
/// Steps below this, relative to the root's distance from 1, change nothing any more.
const SETTLED: f64 = 4e-16;

/// D(w) z^m + Σ P(w) z^n + N(w) C(w), coefficients from the lowest power.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Characteristic {
    /// D.
    pub delayed: Vec<f64>,
    /// m.
    pub lag: usize,
    /// Each P, and its n, at most m.
    pub between: Vec<(Vec<f64>, usize)>,
    /// N C.
    pub fed_back: Vec<f64>,
}

/// The product of two polynomials.
pub fn product(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0; (a.len() + b.len()).saturating_sub(1)];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            all[i + j] += x * y;
        }
    }
    all
}

/// Adds a polynomial to another.
pub fn add(to: &mut Vec<f64>, p: &[f64]) {
    to.resize(to.len().max(p.len()), 0.0);
    to.iter_mut().zip(p).for_each(|(sum, c)| *sum += c);
}

/// A polynomial's value.
pub fn value(p: &[f64], w: Complex) -> Complex {
    p.iter().rev().fold(Complex::default(), |sum, c| sum * w + *c)
}

/// A polynomial's value and slope.
fn value_and_slope(p: &[f64], w: Complex) -> (Complex, Complex) {
    p.iter().rev().fold(Default::default(), |(v, s), c| (v * w + *c, s * w + v))
}

/// z^m by squaring.
fn power(z: Complex, mut m: usize) -> Complex {
    let (mut result, mut square) = (Complex::from(1.0), z);
    while m > 0 {
        if m & 1 == 1 {
            result = result * square;
        }
        square = square * square;
        m >>= 1;
    }
    result
}

impl Characteristic {
    /// Newton's step P / P′. Outside the unit circle both sides are divided by z^m, which would overflow.
    fn newton(&self, w: Complex) -> Complex {
        let z = w + 1.0;
        let (d, slope_d) = value_and_slope(&self.delayed, w);
        let (n, slope_n) = value_and_slope(&self.fed_back, w);
        let m = self.lag as f64;
        // z^k and k z^(k − 1).
        let both = |k: usize| match k {
            0 => (Complex::from(1.0), Complex::default()),
            _ => {
                let before = power(z, k - 1);
                (before * z, before * k as f64)
            }
        };
        if z.abs() > 1.0 {
            let over = Complex::from(1.0) / z;
            let back = power(over, self.lag);
            let (mut p, mut slope) = (d + n * back, slope_d + d * m * over + slope_n * back);
            for (between, less) in &self.between {
                let (q, slope_q) = value_and_slope(between, w);
                let apart = power(over, self.lag.saturating_sub(*less));
                p = p + q * apart;
                slope = slope + (slope_q + q * *less as f64 * over) * apart;
            }
            p / slope
        } else {
            let (on, on_slope) = both(self.lag);
            let (mut p, mut slope) = (d * on + n, slope_d * on + d * on_slope + slope_n);
            for (between, less) in &self.between {
                let (q, slope_q) = value_and_slope(between, w);
                let (part, part_slope) = both(*less);
                p = p + q * part;
                slope = slope + slope_q * part + q * part_slope;
            }
            p / slope
        }
    }

    /// Every root, as w = z − 1.
    pub fn roots(&self) -> Vec<Complex> {
        let degree = |p: &[f64]| p.iter().rposition(|c| *c != 0.0).unwrap_or(0);
        let count = (degree(&self.delayed) + self.lag)
            .max(degree(&self.fed_back))
            .max(self.between.iter().map(|(p, less)| degree(p) + less).max().unwrap_or(0));
        #[cfg(test)]
        super::work::eigenvalues(count);
        let mut roots: Vec<Complex> = (0..count)
            .map(|k| {
                let turn = std::f64::consts::TAU * (k as f64 + 0.37) / count as f64;
                Complex::turned(turn) * 0.98 + Complex::from(-1.0)
            })
            .collect();
        let mut moving = vec![true; count];
        for _ in 0..MOST_SWEEPS {
            for i in 0..count {
                if !moving[i] {
                    continue;
                }
                let w = roots[i];
                let newton = self.newton(w);
                let mut repelled = Complex::default();
                for (j, other) in roots.iter().enumerate() {
                    let apart = w - *other;
                    let size = apart.re * apart.re + apart.im * apart.im;
                    if j != i && size > 0.0 {
                        repelled = repelled + Complex::new(apart.re / size, -apart.im / size);
                    }
                }
                let step = newton / (Complex::from(1.0) - newton * repelled);
                if step.re.is_finite() && step.im.is_finite() {
                    roots[i] = w - step;
                    moving[i] = step.abs() > SETTLED * w.abs();
                } else {
                    // At a root, or where the slope is zero: nudged, it decides which.
                    moving[i] = newton.abs() > 0.0;
                    roots[i] = w * 1.000_001;
                }
            }
            if !moving.contains(&true) {
                break;
            }
        }
        roots
    }

    /// How far the outermost root lies outside the unit circle: negative if all lie inside. The spectral radius is this plus 1.
    pub fn excess(&self) -> f64 {
        self.roots().iter().map(|w| excess(*w)).fold(-1.0, f64::max)
    }
}

/// |1 + w| − 1.
pub fn excess(w: Complex) -> f64 {
    (2.0 * w.re + w.re * w.re + w.im * w.im) / (1.0 + (w + 1.0).abs())
}
