//! A casing on springs, shaken by the mass that spins in it.
//!
//! M Ẍ + c Ẋ + K X = −m_e r s″ with s = sin θ (up and down: −cos θ). With Y = X + μ s, μ = m_e r/M, that is
//! Ÿ + (c/M) Ẏ + (K/M) Y = μ ((c/M) s′ + (K/M) s): nothing is differentiated twice, and what remains is small where the casing is nearly
//! free. s is a cubic between the ends of a piece (Hermite), and the oscillator's answer to a cubic is exact.

use super::kernels::{Kernels, Pair};
use super::parameters::Suspension;
use crate::actuator::elementary::{cosine, sine};

/// Both directions.
#[derive(Debug, Clone)]
pub(super) struct Mount {
    share: f64,
    axes: [Axis; 2],
    /// s and s′ of both.
    shape: [[f64; 2]; 2],
}

#[derive(Debug, Clone)]
struct Axis {
    pair: Pair,
    /// Over a whole step.
    step: Kernels,
    period: f64,
    /// K/M and c/M.
    stiffness: f64,
    damping: f64,
    /// Y and its derivative.
    y: [f64; 2],
}

/// sin θ and −cos θ, and their derivatives.
#[inline]
fn shape(phase: f64, speed: f64) -> [[f64; 2]; 2] {
    let (s, c) = (sine(phase), cosine(phase));
    [[s, c * speed], [-c, s * speed]]
}

impl Mount {
    pub fn new(share: f64, mass: f64, by: [Suspension; 2], period: f64) -> Self {
        let axes = by.map(|by| {
            let (stiffness, damping) = (by.stiffness / mass, by.damping / mass);
            let pair = Pair::new([[0.0, 1.0], [-stiffness, -damping]], stiffness);
            Axis { pair, step: pair.over(period), period, stiffness, damping, y: [0.0; 2] }
        });
        Self { share, axes, shape: shape(0.0, 0.0) }
    }

    /// The casing at rest where its springs hold it, the mass at an angle (turns) with a speed.
    pub fn place(&mut self, phase: f64, speed: f64) {
        self.shape = shape(phase, speed);
        for (axis, s) in self.axes.iter_mut().zip(&self.shape) {
            axis.y = s.map(|s| self.share * s);
        }
    }

    /// A whole step.
    pub fn step(&mut self, phase: f64, speed: f64) {
        let next = shape(phase, speed);
        for ((axis, from), to) in self.axes.iter_mut().zip(&self.shape).zip(&next) {
            let kernels = axis.step;
            axis.go(self.share, from, to, axis.period, &kernels);
        }
        self.shape = next;
    }

    /// A step, or a part of one, that ends with the mass at an angle with a speed.
    pub fn advance(&mut self, t: f64, phase: f64, speed: f64) {
        let next = shape(phase, speed);
        for ((axis, from), to) in self.axes.iter_mut().zip(&self.shape).zip(&next) {
            let kernels = axis.pair.over(t);
            axis.go(self.share, from, to, t, &kernels);
        }
        self.shape = next;
    }

    /// X and its counterpart upright, m.
    pub fn displacement(&self) -> [f64; 2] {
        std::array::from_fn(|n| self.axes[n].y[0] - self.share * self.shape[n][0])
    }

    /// Their derivatives, m/s.
    pub fn velocity(&self) -> [f64; 2] {
        std::array::from_fn(|n| self.axes[n].y[1] - self.share * self.shape[n][1])
    }

    /// Their second derivatives, m/s², given the acceleration that the mass alone would make.
    pub fn acceleration(&self, alone: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|n| {
            let (axis, [s, slope]) = (&self.axes[n], self.shape[n]);
            let (x, v) = (axis.y[0] - self.share * s, axis.y[1] - self.share * slope);
            alone[n] - axis.stiffness * x - axis.damping * v
        })
    }
}

impl Axis {
    #[inline]
    fn go(&mut self, share: f64, from: &[f64; 2], to: &[f64; 2], t: f64, kernels: &Kernels) {
        if t <= 0.0 {
            // The speed may have jumped by nothing but rounding.
            return;
        }
        let (k, c) = (self.stiffness, self.damping);
        let rise = (to[0] - from[0]) / t;
        let two = (3.0 * rise - 2.0 * from[1] - to[1]) / t;
        let three = (from[1] + to[1] - 2.0 * rise) / (t * t);
        let drive = [
            k * from[0] + c * from[1],
            k * from[1] + 2.0 * c * two,
            2.0 * (k * two + 3.0 * c * three),
            6.0 * k * three,
        ];
        let begins = [self.y[1], share * drive[0] - k * self.y[0] - c * self.y[1]];
        let mut time = t;
        let mut change = kernels.times(1, begins).map(|x| t * x);
        for n in 1..4 {
            time *= t;
            let more = kernels.times(n + 1, [0.0, share * drive[n]]);
            change = [change[0] + time * more[0], change[1] + time * more[1]];
        }
        self.y = [self.y[0] + change[0], self.y[1] + change[1]];
    }
}
