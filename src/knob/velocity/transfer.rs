//! What an estimator does to a small motion, as a transfer function.
//!
//! Every estimator is a difference over n ticks, (1 − z^−n) / (n T), through a filter that has a gain of 1 for slow motion. For the
//! loop's eigenvalues nothing else of it matters.

use crate::dsp::complex::Complex;
use crate::knob::low_pass::LowPass;
use crate::knob::stability::roots::value;

/// Speed over angle: (1 − z^−`ticks`) / (`ticks` T) · `above` / `below`, polynomials in w = z − 1 from the lowest power.
#[derive(Debug, Clone, PartialEq)]
pub struct Transfer {
    /// n.
    pub ticks: usize,
    /// The filter's numerator.
    pub above: Vec<f64>,
    /// Its denominator.
    pub below: Vec<f64>,
}

impl Transfer {
    /// A plain difference over so many ticks.
    pub fn difference(ticks: usize) -> Self {
        Self { ticks: ticks.max(1), above: vec![1.0], below: vec![1.0] }
    }

    /// A difference over one tick, through a low-pass.
    pub fn filtered(low_pass: &LowPass) -> Self {
        let (above, below) = low_pass.polynomials();
        Self { ticks: 1, above: above.to_vec(), below: below.to_vec() }
    }

    /// An α-β filter: v̂ / θ = (β / T) z w / (w² + (α + β) w + β).
    pub fn tracking(alpha: f64, beta: f64) -> Self {
        Self { ticks: 1, above: vec![beta, 2.0 * beta, beta], below: vec![beta, alpha + beta, 1.0] }
    }

    /// Whether it is the difference over one tick.
    pub fn is_plain(&self) -> bool {
        self.ticks == 1 && self.above == [1.0] && self.below == [1.0]
    }

    /// Its value times T at the angle ωT of a frequency, as numerator and denominator.
    pub(crate) fn at(&self, phi: f64, w: Complex) -> (Complex, Complex) {
        let n = self.ticks as f64;
        let half = 0.5 * phi * n;
        // 1 − e^{−jφn} without a difference of two near each other.
        let difference = Complex::turned(-half) * Complex::new(0.0, 2.0 * half.sin() / n);
        (difference * value(&self.above, w), value(&self.below, w))
    }
}
