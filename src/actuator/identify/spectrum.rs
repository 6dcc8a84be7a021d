//! A first guess of a resonance, from the spectra of drive and response.

use std::f64::consts::TAU;

use super::least::linear;
use crate::dsp::complex::Complex;

/// Frequencies that are looked at, spread evenly over the octaves.
const FREQUENCIES: usize = 400;
/// A frequency is driven where the drive's rate of change is more than this share of its greatest.
const DRIVEN: f64 = 0.05;
/// Weakest and strongest resonance that is guessed.
const QS: (f64, f64) = (0.3, 200.0);

/// Spectra at some frequencies.
pub(super) struct Spectra {
    /// Hz.
    hertz: Vec<f64>,
    response: Vec<Complex>,
    drive: Vec<Complex>,
}

impl Spectra {
    /// Of a drive and a response to it. It is their differences from sample to sample whose spectra are taken: both have the same ratio, and
    /// a drive that stays on at the end has no edge there.
    pub fn new(drive: &[f64], response: &[f64], rate: f64) -> Self {
        let (low, high) = (2.0 * rate / drive.len() as f64, 0.45 * rate);
        let step = (high / low).ln() / (FREQUENCIES - 1) as f64;
        let hertz: Vec<f64> = (0..FREQUENCIES).map(|n| low * (step * n as f64).exp()).collect();
        let of = |x: &[f64]| {
            let steps: Vec<f64> = x.windows(2).map(|x| x[1] - x[0]).collect();
            hertz.iter().map(|f| transform(&steps, f / rate)).collect()
        };
        let (drive, response) = (of(drive), of(response));
        Self { hertz, response, drive }
    }

    /// The lowest and the highest frequency that is driven, Hz.
    pub fn driven(&self) -> (f64, f64) {
        let rates: Vec<f64> = self.drive.iter().map(|u| u.abs()).collect();
        let most = rates.iter().fold(0.0_f64, |m, r| m.max(*r));
        let is = |r: &f64| *r > DRIVEN * most;
        let low = rates.iter().position(is).unwrap_or(0);
        let high = rates.iter().rposition(is).unwrap_or(0);
        (self.hertz[low], self.hertz[high])
    }

    /// Where the response is greatest for its drive, Hz.
    pub fn peak(&self) -> f64 {
        let (low, high) = self.driven();
        let each = (0..self.hertz.len()).filter(|n| (low..=high).contains(&self.hertz[*n]));
        let share = |n: &usize| self.response[*n].abs() / self.drive[*n].abs();
        each.max_by(|a, b| share(a).total_cmp(&share(b))).map_or(0.0, |n| self.hertz[n])
    }

    /// Guesses of ω (rad/s) and Q, the likeliest first: by all of the response, and by where it is greatest with some qualities.
    pub fn guesses(&self) -> Vec<(f64, f64)> {
        let peak = TAU * self.peak();
        let mut pairs: Vec<(f64, f64)> = self.by_magnitude().into_iter().collect();
        pairs.extend([1.0, 3.0, 10.0, 30.0].map(|q| (peak, q)));
        pairs.retain(|(omega, _)| *omega > 0.0);
        pairs
    }

    /// |H|² = G² ω⁴ / ((Ω² − ω²)² + (Ω ω/Q)²) makes ω⁴/|H|² a quadratic polynomial of ω²: Ω and Q without any phase.
    fn by_magnitude(&self) -> Option<(f64, f64)> {
        let (low, high) = self.driven();
        let unit = TAU * (low * high).sqrt();
        let loudest = self.response.iter().fold(0.0_f64, |m, y| m.max(y.abs()));
        let rows = (0..self.hertz.len()).filter(|n| (low..=high).contains(&self.hertz[*n])).filter_map(|n| {
            let square = (TAU * self.hertz[n] / unit).powi(2);
            let share = (self.response[n].abs() / self.drive[n].abs()).powi(2);
            let weight = share / (square * square) * self.response[n].abs() / loudest;
            let row = vec![weight * square * square, weight * square, weight];
            weight.is_finite().then_some((row, weight * square * square / share))
        });
        let found = linear(rows, 3)?;
        let (top, middle, bottom) = (found[0], found[1], found[2]);
        let square = (bottom / top).sqrt();
        let inverse = 2.0 + middle / (top * square);
        (top > 0.0 && square > 0.0 && inverse > 0.0)
            .then(|| (unit * square.sqrt(), inverse.sqrt().recip().clamp(QS.0, QS.1)))
    }
}

/// The spectrum at a frequency, cycles a sample.
fn transform(x: &[f64], cycles: f64) -> Complex {
    let turn = Complex::turned(-TAU * cycles);
    let (mut now, mut sum) = (Complex::new(1.0, 0.0), Complex::default());
    for x in x {
        sum = sum + now * *x;
        now = now * turn;
    }
    sum
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::super::held::Held;
    use super::{Spectra, transform};

    fn sweep(from: f64, to: f64, count: usize, rate: f64) -> Vec<f64> {
        let length = count as f64 / rate;
        let slope = (to - from) / length;
        let angle = |t: f64| TAU * t * (from + 0.5 * slope * t);
        (0..count).map(|n| angle(n as f64 / rate).sin()).collect()
    }

    #[test]
    fn a_sine_has_its_amplitude() {
        let x: Vec<f64> = (0..1000).map(|n| 3.0 * (TAU * 0.05 * f64::from(n) + 0.4).cos()).collect();
        let y = transform(&x, 0.05);
        assert!((y.abs() / 1500.0 - 1.0).abs() < 1e-9 && (y.angle() - 0.4).abs() < 1e-9);
    }

    #[test]
    fn a_guess_comes_near_whatever_the_delay() {
        let drive = sweep(20.0, 800.0, 16_000, 8000.0);
        for (hertz, q, delay) in [(175.0, 15.0, 0.0), (60.0, 1.3, 0.031), (300.0, 5.0, -0.002)] {
            let out = Held::resonance(TAU * hertz, q, 0.0).play(&drive, 1.0 / 8000.0, delay).unwrap();
            let out: Vec<f64> = out.iter().map(|y| -0.3 * y).collect();
            let spectra = Spectra::new(&drive, &out, 8000.0);
            let (omega, guess) = spectra.guesses()[0];
            assert!((omega / (TAU * hertz) - 1.0).abs() < 0.05, "{hertz}: {omega}");
            assert!((guess / q - 1.0).abs() < 0.4, "{q}: {guess}");
            let (low, high) = spectra.driven();
            assert!(low < 45.0 && (780.0..900.0).contains(&high), "{low} {high}");
        }
    }
}
