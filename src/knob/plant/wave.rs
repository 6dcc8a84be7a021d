//! Torque over the angle of a turn: cogging, ripple, and detents that act continuously.

use crate::actuator::elementary::{cosine, sine, wrapped};
use crate::actuator::fault::{Fault, Limit, check, within};
use std::f64::consts::TAU;

/// Harmonics of a wave, at most.
pub const MOST_HARMONICS: usize = 16;
/// Periods a turn, at most.
pub const MOST_PERIODS: f64 = 10_000.0;
/// What of a table's largest harmonic is no more than its rounding.
const SMALL: f64 = 1e-12;

/// s sin(N θ) + c cos(N θ).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Harmonic {
    /// N, periods a turn: a whole number, 0 to [`MOST_PERIODS`].
    pub periods: f64,
    /// s.
    pub sine: f64,
    /// c.
    pub cosine: f64,
}

/// A sum of harmonics of a turn: in N m for cogging, without a unit for ripple.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wave {
    harmonics: [Harmonic; MOST_HARMONICS],
    used: usize,
}

impl Wave {
    /// Of these harmonics.
    ///
    /// # Errors
    /// More than [`MOST_HARMONICS`]; periods that are not a whole number within limits; amplitudes beyond ±1e6.
    pub fn new(harmonics: &[Harmonic]) -> Result<Self, Fault> {
        check("harmonics", harmonics.len() as f64, Limit::Most(MOST_HARMONICS as f64))?;
        let mut wave = Self::default();
        for (to, harmonic) in wave.harmonics.iter_mut().zip(harmonics) {
            within("periods", harmonic.periods, (0.0, MOST_PERIODS), "a turn")?;
            if harmonic.periods.fract() != 0.0 {
                let limit = Limit::Least(harmonic.periods.ceil());
                return Err(Fault::because(
                    "periods",
                    harmonic.periods,
                    limit,
                    "a turn has a whole number of them",
                ));
            }
            within("sine", harmonic.sine, (-1e6, 1e6), "")?;
            within("cosine", harmonic.cosine, (-1e6, 1e6), "")?;
            *to = *harmonic;
            wave.used += 1;
        }
        Ok(wave)
    }

    /// A detent of `periods` rests a turn: −A sin(N θ).
    ///
    /// # Errors
    /// As [`Wave::new`].
    pub fn detent(amplitude: f64, periods: f64) -> Result<Self, Fault> {
        Self::new(&[Harmonic { periods, sine: -amplitude, cosine: 0.0 }])
    }

    /// Through values at equal angles over `1 / repeats` of a turn, the first at 0: its trigonometric interpolation, and so smooth. Returns
    /// also the largest difference to the values, for a table with more harmonics than [`MOST_HARMONICS`] keeps its largest ones.
    ///
    /// # Errors
    /// Fewer than 2 values or more than 4096, one that is no number, periods beyond limits.
    pub fn of_table(values: &[f64], repeats: f64) -> Result<(Self, f64), Fault> {
        let count = values.len();
        within("table points", count as f64, (2.0, 4096.0), "")?;
        within("repeats", repeats, (1.0, MOST_PERIODS), "a turn")?;
        for &value in values {
            within("table value", value, (-1e6, 1e6), "")?;
        }
        let mut all: Vec<Harmonic> = (0..=count / 2).map(|n| harmonic(values, n, repeats)).collect();
        let size = |h: &Harmonic| h.sine.abs().max(h.cosine.abs());
        all.sort_by(|a, b| size(b).total_cmp(&size(a)));
        let least = all.first().map_or(0.0, size) * SMALL;
        all.retain(|h| size(h) > least);
        all.truncate(MOST_HARMONICS);
        let wave = Self::new(&all)?;
        let angle = |n: usize| TAU * n as f64 / (count as f64 * repeats);
        let worst = values.iter().enumerate().map(|(n, v)| (wave.at(angle(n)) - v).abs()).fold(0.0, f64::max);
        Ok((wave, worst))
    }

    /// Whether it is nothing at every angle.
    pub fn is_flat(&self) -> bool {
        self.harmonics().iter().all(|h| h.cosine == 0.0 && (h.sine == 0.0 || h.periods == 0.0))
    }

    /// What it is made of.
    pub fn harmonics(&self) -> &[Harmonic] {
        &self.harmonics[..self.used]
    }

    /// Its value at an angle, rad.
    pub fn at(&self, angle: f64) -> f64 {
        self.harmonics()
            .iter()
            .map(|h| {
                let [s, c] = phase(h.periods, angle);
                h.sine * s + h.cosine * c
            })
            .sum()
    }

    /// How fast it rises with the angle, 1/rad.
    pub fn slope(&self, angle: f64) -> f64 {
        self.harmonics()
            .iter()
            .map(|h| {
                let [s, c] = phase(h.periods, angle);
                h.periods * (h.sine * c - h.cosine * s)
            })
            .sum()
    }

    /// Its energy if it is a torque: minus its integral from 0, J.
    pub fn energy(&self, angle: f64) -> f64 {
        self.harmonics()
            .iter()
            .map(|h| {
                let [s, c] = phase(h.periods, angle);
                if h.periods == 0.0 {
                    -h.cosine * angle
                } else {
                    (h.sine * (c - 1.0) - h.cosine * s) / h.periods
                }
            })
            .sum()
    }

    /// Bounds of |dwave/dθ|, and the most periods a turn.
    pub(super) fn bounds(&self) -> (f64, f64) {
        self.harmonics().iter().fold((0.0, 0.0), |(slope, most), h| {
            (slope + h.periods * (h.sine * h.sine + h.cosine * h.cosine).sqrt(), h.periods.max(most))
        })
    }
}

/// Sine and cosine of N θ.
pub(super) fn phase(periods: f64, angle: f64) -> [f64; 2] {
    // The whole turns come off first: the periods a turn are whole too.
    let (turns, _) = wrapped(angle / TAU);
    let (turns, _) = wrapped(turns * periods);
    [sine(turns), cosine(turns)]
}

fn harmonic(values: &[f64], n: usize, repeats: f64) -> Harmonic {
    let count = values.len();
    let (mut s, mut c) = (0.0, 0.0);
    for (k, value) in values.iter().enumerate() {
        let turns = ((n * k) % count) as f64 / count as f64;
        s += value * sine(turns);
        c += value * cosine(turns);
    }
    let alone = n == 0 || 2 * n == count;
    let share = if alone { 1.0 } else { 2.0 } / count as f64;
    Harmonic { periods: n as f64 * repeats, sine: if alone { 0.0 } else { s * share }, cosine: c * share }
}

#[cfg(test)]
mod tests {
    use super::{Harmonic, Wave};
    use std::f64::consts::TAU;

    #[test]
    fn it_is_its_harmonics_however_far_it_turned() {
        let wave = Wave::new(&[
            Harmonic { periods: 24.0, sine: -8e-3, cosine: 1e-3 },
            Harmonic { periods: 0.0, sine: 1.0, cosine: 0.5 },
        ])
        .unwrap();
        for n in -50..50 {
            let angle = f64::from(n) * 0.173;
            let expected = 0.5 - 8e-3 * (24.0 * angle).sin() + 1e-3 * (24.0 * angle).cos();
            assert!((wave.at(angle) - expected).abs() < 1e-15);
            assert!((wave.at(angle + 1000.0 * TAU) - expected).abs() < 1e-12);
            let slope = (wave.energy(angle + 1e-6) - wave.energy(angle - 1e-6)) / 2e-6;
            assert!((slope + wave.at(angle)).abs() < 1e-9);
            let slope = (wave.at(angle + 1e-6) - wave.at(angle - 1e-6)) / 2e-6;
            assert!((slope - wave.slope(angle)).abs() < 1e-8);
        }
        assert!(!wave.is_flat() && Wave::default().is_flat());
    }

    #[test]
    fn a_table_is_met_at_its_points() {
        for count in [2usize, 5, 16, 31] {
            let values: Vec<f64> = (0..count).map(|n| (n as f64 * 1.7).sin() + 0.1).collect();
            let (wave, worst) = Wave::of_table(&values, 7.0).unwrap();
            assert!(worst < 1e-14, "{count} {worst}");
            for (n, value) in values.iter().enumerate() {
                let angle = TAU * (n as f64 / count as f64 + 3.0) / 7.0;
                assert!((wave.at(angle) - value).abs() < 1e-13);
            }
        }
        let jagged: Vec<f64> = (0..64).map(|n| if n % 3 == 0 { 1.0 } else { -0.4 }).collect();
        let (wave, worst) = Wave::of_table(&jagged, 1.0).unwrap();
        assert!(wave.harmonics().len() == 16 && worst > 1e-3);
    }

    #[test]
    fn what_cannot_be_is_named() {
        let of = |periods: f64, sine: f64| Wave::new(&[Harmonic { periods, sine, cosine: 0.0 }]);
        assert_eq!(of(1.5, 1.0).unwrap_err().field, "periods");
        assert_eq!(of(1e9, 1.0).unwrap_err().field, "periods");
        assert_eq!(of(1.0, f64::NAN).unwrap_err().field, "sine");
        assert_eq!(Wave::new(&[Harmonic::default(); 17]).unwrap_err().field, "harmonics");
        assert_eq!(Wave::of_table(&[1.0], 1.0).unwrap_err().field, "table points");
        assert_eq!(Wave::of_table(&[1.0, f64::NAN], 1.0).unwrap_err().field, "table value");
        assert_eq!(Wave::of_table(&[1.0, 2.0], 0.0).unwrap_err().field, "repeats");
    }
}
