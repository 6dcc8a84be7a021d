//! Elliptic (Cauer) low-pass design.
//!
//! After S. J. Orfanidis, "Lecture Notes on Elliptic Filter Design" (2006): the Jacobi functions cd and sn follow from
//! Landen's transformation, the degree equation is solved through the nome; then the bilinear transform, the pass edge
//! prewarped.

use super::biquad::{Biquad, Complex};
use std::f64::consts::PI;

/// A low-pass as `gain` times sections with unit-circle zeros, b = (1, b1, 1), the sharpest resonance last.
#[derive(Clone, Debug, PartialEq)]
pub struct Elliptic {
    /// Factor before the sections.
    pub gain: f64,
    /// The second-order sections.
    pub sections: Vec<Biquad>,
    /// Sampling rate, Hz.
    pub rate: f64,
}

/// Sections of [`Elliptic::band_limit`].
pub const BAND_SECTIONS: usize = 4;
/// Its pass band: ripple (dB) to the edge (Hz); least loss of its stop band (dB), which begins just below 1 kHz.
const BAND: (f64, f64, f64) = (0.3, 850.0, 66.0);

impl Elliptic {
    /// That by which everything that vibrates is kept below 1 kHz, at an engine's rate (Hz).
    pub fn band_limit(rate: f64) -> Self {
        Self::low_pass(BAND_SECTIONS, BAND.0, BAND.2, BAND.1, rate)
    }

    /// Low-pass of order 2 × `pairs`: `ripple` dB (above 0) up to `edge` Hz (below `rate` / 2), at least `stop` dB
    /// (above `ripple`) in the stop band.
    pub fn low_pass(pairs: usize, ripple: f64, stop: f64, edge: f64, rate: f64) -> Self {
        let order = (2 * pairs) as f64;
        let pass_error = (10f64.powf(ripple / 10.0) - 1.0).sqrt();
        let selectivity = pass_error / (10f64.powf(stop / 10.0) - 1.0).sqrt();
        let modulus = of_nome(nome(selectivity).powf(1.0 / order));
        let ladder = landen(modulus);
        let shift = inverse_sn_imaginary(1.0 / pass_error, selectivity) / order;
        let warp = (PI * edge / rate).tan();
        let mut sections = Vec::with_capacity(pairs);
        let mut at_zero = 1.0;
        for i in (1..=pairs).rev() {
            let u = (2 * i - 1) as f64 / order;
            let zero = warp / (modulus * cd(Complex::new(u, 0.0), &ladder).re);
            let w = cd(Complex::new(u, -shift), &ladder);
            // The pole j w, on the left whichever sign w came with.
            let s = Complex::new(-w.im.abs() * warp, w.re * warp);
            let z = (Complex::from(1.0) + s) / (Complex::from(1.0) - s);
            let b1 = -2.0 * (2.0 * zero.atan()).cos();
            let section = Biquad { b: [1.0, b1, 1.0], a: [-2.0 * z.re, z.re * z.re + z.im * z.im] };
            at_zero *= section.response(0.0, rate).re;
            sections.push(section);
        }
        // An even order starts at the bottom of the ripple.
        Self { gain: 10f64.powf(-ripple / 20.0) / at_zero, sections, rate }
    }

    /// Response at `frequency` (Hz).
    pub fn response(&self, frequency: f64) -> Complex {
        self.sections.iter().fold(self.gain.into(), |h, s| h * s.response(frequency, self.rate))
    }

    /// Group delay at `frequency` (Hz), in seconds, from the sections' logarithmic derivative.
    pub fn group_delay(&self, frequency: f64) -> f64 {
        let z = Complex::turned(-2.0 * PI * frequency / self.rate);
        // τ = Re(Σ k c_k z^-k / Σ c_k z^-k), numerator's less denominator's, in samples.
        let lag = |c: [f64; 3]| {
            let sum = Complex::from(c[0]) + z * (Complex::from(c[1]) + z * c[2]);
            let weighted = z * (Complex::from(c[1]) + z * (2.0 * c[2]));
            (weighted / sum).re
        };
        self.sections.iter().map(|s| lag(s.b) - lag([1.0, s.a[0], s.a[1]])).sum::<f64>() / self.rate
    }

    /// Phase delay at `frequency` (Hz, above 0), in seconds; right while a section turns by less than half a turn.
    pub fn phase_delay(&self, frequency: f64) -> f64 {
        let angle: f64 = self.sections.iter().map(|s| s.response(frequency, self.rate).angle()).sum();
        -angle / (2.0 * PI * frequency)
    }
}

/// Descending Landen sequence of a modulus.
fn landen(modulus: f64) -> Vec<f64> {
    let mut ladder = vec![modulus];
    let mut k = modulus;
    while k > 1e-17 && ladder.len() < 16 {
        k = (k / (1.0 + (1.0 - k * k).sqrt())).powi(2);
        ladder.push(k);
    }
    ladder
}

/// cd(u K, k), `u` in quarter periods, for the ladder of k.
fn cd(u: Complex, ladder: &[f64]) -> Complex {
    let (sin, cos) = (u.re * PI / 2.0).sin_cos();
    let b = u.im * PI / 2.0;
    let mut w = Complex::new(cos * b.cosh(), -sin * b.sinh());
    for &v in ladder[1..].iter().rev() {
        w = Complex::from(1.0 + v) * w / (Complex::from(1.0) + Complex::from(v) * w * w);
    }
    w
}

/// The v with sn(i v K, k) = i `t`.
fn inverse_sn_imaginary(t: f64, modulus: f64) -> f64 {
    let ladder = landen(modulus);
    let mut t = t;
    for pair in ladder.windows(2) {
        t = 2.0 / (1.0 + pair[1]) * t / (1.0 + (1.0 + t * t * pair[0] * pair[0]).sqrt());
    }
    t.asinh() * 2.0 / PI
}

/// Nome exp(−π K'/K) of a modulus; K by the arithmetic-geometric mean.
fn nome(modulus: f64) -> f64 {
    let mean = |mut a: f64, mut b: f64| {
        while (a - b).abs() > 1e-16 * a {
            (a, b) = ((a + b) / 2.0, (a * b).sqrt());
            if (a - b).abs() < 4e-16 * a {
                break;
            }
        }
        a
    };
    // K ∝ 1 / agm(1, k'), K' ∝ 1 / agm(1, k).
    (-PI * mean(1.0, (1.0 - modulus * modulus).sqrt()) / mean(1.0, modulus)).exp()
}

/// Modulus of a nome, by the theta series.
fn of_nome(q: f64) -> f64 {
    let (mut above, mut below) = (1.0, 1.0);
    for m in 1..32 {
        above += q.powi(m * (m + 1));
        below += 2.0 * q.powi(m * m);
    }
    4.0 * q.sqrt() * (above / below).powi(2)
}

#[cfg(test)]
mod tests {
    use super::Elliptic;

    /// (Hz, real, imaginary) of scipy.signal.ellip(8, 0.3, 66, 850, fs=…).
    const AT_8000: [(f64, f64, f64); 11] = [
        (20.0, 9.615355808469e-01, -9.928981710644e-02),
        (100.0, 8.485229703178e-01, -4.887705068711e-01),
        (250.0, 1.848002665707e-01, -9.815904044854e-01),
        (500.0, -9.700165559124e-01, -1.395203050375e-01),
        (700.0, 2.238713794490e-01, 9.401548234288e-01),
        (840.0, 4.327005711720e-02, -9.978565709724e-01),
        (850.0, -4.317338573860e-01, -8.642107249876e-01),
        (900.0, -7.910466592666e-02, 7.867259749061e-02),
        (1000.0, -7.262058895709e-06, 2.645016433610e-04),
        (1500.0, -1.703133720379e-04, -1.588984176068e-04),
        (3000.0, 2.499775144426e-04, 4.768500584629e-05),
    ];
    const AT_7350: [(f64, f64, f64); 11] = [
        (20.0, 9.616008450723e-01, -9.857165696387e-02),
        (100.0, 8.502558584173e-01, -4.854227256446e-01),
        (250.0, 1.946308845683e-01, -9.798413004994e-01),
        (500.0, -9.666110222969e-01, -1.566956430761e-01),
        (700.0, 2.051855381009e-01, 9.442323664058e-01),
        (840.0, 4.932450710949e-02, -9.974155102776e-01),
        (850.0, -4.317338573860e-01, -8.642107249876e-01),
        (900.0, -7.535729437685e-02, 7.674877300761e-02),
        (1000.0, -1.929478634803e-06, 1.205910200965e-04),
        (1500.0, -2.053333215929e-04, -1.851291165392e-04),
        (3000.0, 3.407413054544e-04, 5.068777419228e-05),
    ];

    #[test]
    fn the_response_is_that_of_scipy() {
        for (rate, table) in [(8000.0, AT_8000), (7350.0, AT_7350)] {
            let filter = Elliptic::low_pass(4, 0.3, 66.0, 850.0, rate);
            for (hertz, re, im) in table {
                let h = filter.response(hertz);
                assert!((h.re - re).hypot(h.im - im) < 1e-9, "{rate} {hertz}: {h:?}");
            }
        }
    }

    #[test]
    fn ripple_and_stop_band_hold_over_both_bands() {
        for rate in [6000.0, 7350.0, 8000.0, 8018.0, 12_000.0] {
            let filter = Elliptic::low_pass(4, 0.3, 66.0, 850.0, rate);
            for hertz in 0..=850 {
                let decibel = 20.0 * filter.response(f64::from(hertz)).abs().log10();
                assert!((-0.300_001..1e-6).contains(&decibel), "{rate} {hertz}: {decibel}");
            }
            for hertz in 1005..(rate / 2.0) as i32 {
                assert!(filter.response(f64::from(hertz)).abs() < 0.000_501_2, "{rate} {hertz}");
            }
        }
    }

    #[test]
    fn the_delays_are_slopes_of_the_phase() {
        let filter = Elliptic::low_pass(4, 0.3, 66.0, 850.0, 8000.0);
        let slope = filter.response(249.99).angle() - filter.response(250.01).angle();
        let group = slope / (std::f64::consts::TAU * 0.02);
        assert!((filter.group_delay(250.0) - group).abs() < 1e-9);
        assert!((filter.group_delay(250.0) - 0.963_050e-3).abs() < 1e-8);
        // From 0 Hz the phase grows steadily, so the mean slope is the phase delay.
        let mean = (0..250).map(|f| filter.group_delay(f64::from(f) + 0.5)).sum::<f64>() / 250.0;
        assert!((filter.phase_delay(250.0) - mean).abs() < 1e-8);
    }
}
