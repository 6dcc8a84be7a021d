//! Second-order sections and their frequency response.

use std::f64::consts::TAU;

pub use super::complex::Complex;

/// Sections of an equaliser, at most, wherever one is described or built.
pub(crate) const MOST_SECTIONS: usize = 16;

/// A second-order section, (b0 + b1 z⁻¹ + b2 z⁻²) / (1 + a1 z⁻¹ + a2 z⁻²).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Biquad {
    /// b0, b1, b2.
    pub b: [f64; 3],
    /// a1, a2.
    pub a: [f64; 2],
}

impl Biquad {
    /// Passes everything as it is.
    pub const THROUGH: Self = Self { b: [1.0, 0.0, 0.0], a: [0.0, 0.0] };

    /// A bell of `gain` (dB) at `frequency` (Hz, within 0 to `rate` / 2) with quality `q` (above 0), at `rate` (Hz).
    /// After R. Bristow-Johnson's "Cookbook formulae for audio equalizer biquad filter coefficients".
    /// A value out of range gives [`Biquad::THROUGH`]: the rig's check has refused it before.
    pub fn peaking(frequency: f64, q: f64, gain: f64, rate: f64) -> Self {
        let sound =
            frequency > 0.0 && frequency < 0.5 * rate && q > 0.0 && q.is_finite() && gain.abs() <= 60.0;
        if !sound {
            return Self::THROUGH;
        }
        let amplitude = 10f64.powf(gain / 40.0);
        let (sin, cos) = (TAU * frequency / rate).sin_cos();
        let alpha = sin / (2.0 * q);
        let a0 = 1.0 + alpha / amplitude;
        Self {
            b: [(1.0 + alpha * amplitude) / a0, -2.0 * cos / a0, (1.0 - alpha * amplitude) / a0],
            a: [-2.0 * cos / a0, (1.0 - alpha / amplitude) / a0],
        }
    }

    /// Response at `frequency` (Hz) for a sampling `rate` (Hz).
    pub fn response(&self, frequency: f64, rate: f64) -> Complex {
        let z = Complex::turned(-TAU * frequency / rate);
        let above = Complex::from(self.b[0]) + z * (Complex::from(self.b[1]) + z * self.b[2]);
        let below = Complex::from(1.0) + z * (Complex::from(self.a[0]) + z * self.a[1]);
        above / below
    }

    /// One sample through the section (transposed direct form II); `state` starts at zero.
    pub(crate) fn step(&self, state: &mut [f64; 2], x: f64) -> f64 {
        let y = self.b[0] * x + state[0];
        state[0] = self.b[1] * x - self.a[0] * y + state[1];
        state[1] = self.b[2] * x - self.a[1] * y;
        y
    }
}

#[cfg(test)]
mod tests {
    use super::{Biquad, Complex};

    #[test]
    fn a_bell_has_its_gain_at_its_frequency_and_none_far_away() {
        let bell = Biquad::peaking(250.0, 2.0, 6.0, 8000.0);
        let decibel = |f: f64| 20.0 * bell.response(f, 8000.0).abs().log10();
        assert!((decibel(250.0) - 6.0).abs() < 1e-9);
        assert!(decibel(0.0).abs() < 1e-9);
        assert!(decibel(4000.0).abs() < 1e-9);
        assert_eq!(Biquad::peaking(f64::NAN, 2.0, 6.0, 8000.0), Biquad::THROUGH);
    }

    #[test]
    fn the_impulse_response_sums_to_the_frequency_response() {
        let bell = Biquad::peaking(500.0, 1.0, -9.0, 8000.0);
        let (mut state, mut sum) = ([0.0; 2], Complex::default());
        for n in 0..4000 {
            let y = bell.step(&mut state, if n == 0 { 1.0 } else { 0.0 });
            sum = sum + Complex::turned(-std::f64::consts::TAU * 300.0 / 8000.0 * f64::from(n)) * y;
        }
        assert!((sum - bell.response(300.0, 8000.0)).abs() < 1e-12);
    }
}
