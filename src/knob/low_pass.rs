//! Second-order low-pass: smooths a velocity estimate, and torque on its way to the amplifier.
//!
//! Butterworth's, by the bilinear transform with the corner where it was asked for. In w = z − 1 and c = tan(π f T) it is
//! c² (w + 2)² / (w² + √2 c w (w + 2) + c² (w + 2)²): coefficients that lose no digits where f T is small.

use crate::actuator::fault::{Fault, Limit, check, positive};
use std::f64::consts::{PI, SQRT_2};

/// The corner may not lie above this share of the rate.
pub const MOST_SHARE: f64 = 0.45;

/// A low-pass and its state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass {
    corner: f64,
    c: f64,
    scale: f64,
    damping: f64,
    /// State-variable form: two trapezoidal integrators.
    first: f64,
    second: f64,
}

impl LowPass {
    /// A low-pass with its corner (-3 dB) at `hertz`, run every `period` seconds.
    ///
    /// # Errors
    /// `period` is not above 0; `hertz` is not within 0 (excluded) and [`MOST_SHARE`] of the rate.
    pub fn new(hertz: f64, period: f64) -> Result<Self, Fault> {
        positive("period", period)?;
        positive("low_pass", hertz)?;
        check("low_pass", hertz, Limit::Most(MOST_SHARE / period))?;
        let c = (PI * hertz * period).tan();
        let scale = 1.0 / (1.0 + c * (SQRT_2 + c));
        Ok(Self { corner: hertz, c, scale, damping: SQRT_2 + c, first: 0.0, second: 0.0 })
    }

    /// One value through the filter.
    #[inline(always)]
    pub fn step(&mut self, x: f64) -> f64 {
        let high = (x - self.damping * self.first - self.second) * self.scale;
        let band = self.c * high + self.first;
        self.first = self.c * high + band;
        let low = self.c * band + self.second;
        self.second = self.c * band + low;
        low
    }

    /// At rest at a value.
    pub fn reset(&mut self, value: f64) {
        (self.first, self.second) = (0.0, value);
    }

    /// Whether what is left in it is below `least`, so that it may be put at rest.
    pub fn faded(&self, least: f64) -> bool {
        self.first.abs() + self.second.abs() < least
    }

    /// The corner, hertz.
    pub fn corner(&self) -> f64 {
        self.corner
    }

    /// Seconds by which slow signals come late: √2 / ω.
    pub fn lag(&self) -> f64 {
        SQRT_2 / (2.0 * PI * self.corner)
    }

    /// Numerator and denominator in w = z − 1, lowest power first.
    pub fn polynomials(&self) -> ([f64; 3], [f64; 3]) {
        let (c, cc) = (self.c, self.c * self.c);
        ([4.0 * cc, 4.0 * cc, cc], [4.0 * cc, 2.0 * SQRT_2 * c + 4.0 * cc, 1.0 + SQRT_2 * c + cc])
    }
}

#[cfg(test)]
mod tests {
    use super::LowPass;
    use crate::dsp::complex::Complex;

    #[test]
    fn it_answers_as_its_polynomials_say() {
        let period = 1e-4;
        for hertz in [20.0, 100.0, 2000.0] {
            let f = LowPass::new(hertz, period).unwrap();
            let (b, a) = f.polynomials();
            let of = |p: [f64; 3], w: Complex| (w * p[2] + p[1]) * w + p[0];
            for tone in [hertz, 37.0, 1234.5] {
                let z = Complex::turned(std::f64::consts::TAU * tone * period);
                let (mut run, mut sum) = (f, Complex::default());
                // The impulse response, transformed.
                for n in 0..40_000 {
                    let h = run.step(if n == 0 { 1.0 } else { 0.0 });
                    sum = sum + Complex::turned(-std::f64::consts::TAU * tone * period * f64::from(n)) * h;
                }
                let w = z - Complex::from(1.0);
                let exact = of(b, w) / of(a, w);
                assert!((sum - exact).abs() < 1e-10, "{hertz} {tone}");
                if tone == hertz {
                    assert!((exact.abs() - 0.5f64.sqrt()).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn it_rests_where_it_is_put_and_refuses_what_cannot_be() {
        let mut f = LowPass::new(100.0, 1e-3).unwrap();
        f.reset(0.25);
        assert!((f.step(0.25) - 0.25).abs() < 1e-15);
        for (hertz, period) in [(0.0, 1e-3), (451.0, 1e-3), (f64::NAN, 1e-3), (10.0, 0.0), (10.0, -1.0)] {
            assert!(LowPass::new(hertz, period).is_err());
        }
    }
}
