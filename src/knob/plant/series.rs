//! The motion over a short time as a power series: of what is linear, and of torque over the angle.
//!
//! Coefficients follow from each other (Moore, 1966; Jorba & Zou, 2005): x_{k+1} (k + 1) is what the equation makes of x_k; sine and cosine of N θ
//! follow from θ by (sin φ)' = φ' cos φ. With 18 terms over a time in which nothing turns by more than 0.9 rad, what is left out of what is
//! linear is below 0.9^19 / 19! = 1e-18 of what moves. Torque over the angle makes the series converge over a limited time only; there the
//! last terms tell how far it may be used.

use super::network::{ANGLE, Network, SPEED, State};
use super::wave::{MOST_HARMONICS, Wave, phase};
use crate::actuator::elementary::{exp, ln};
use crate::actuator::exponential::{MOST, Square};

/// Terms beyond the first.
pub(super) const ORDER: usize = 18;
/// The longest time, in radians of the fastest.
pub(super) const REACH: f64 = 0.9;

/// What is left out of the phase of a wave, rad.
const LEFT_OUT: f64 = 1e-17;

/// One number's series.
pub(super) type Terms = [f64; ORDER + 1];

/// A state's series.
#[derive(Debug, Clone)]
pub(super) struct Series {
    terms: [Terms; MOST],
}

/// Sines and cosines of a wave's harmonics, as series.
struct Waves<'a> {
    wave: &'a Wave,
    sines: [Terms; MOST_HARMONICS],
    cosines: [Terms; MOST_HARMONICS],
    value: Terms,
}

impl<'a> Waves<'a> {
    fn new(wave: &'a Wave, angle: f64) -> Self {
        let none = [[0.0; ORDER + 1]; MOST_HARMONICS];
        let mut waves = Self { wave, sines: none, cosines: none, value: [0.0; ORDER + 1] };
        for (n, h) in wave.harmonics().iter().enumerate() {
            let [s, c] = phase(h.periods, angle);
            (waves.sines[n][0], waves.cosines[n][0]) = (s, c);
            waves.value[0] += h.sine * s + h.cosine * c;
        }
        waves
    }

    /// The term `k`, 1 or more, from those of the angle up to it.
    fn extend(&mut self, angle: &Terms, k: usize) {
        for (n, h) in self.wave.harmonics().iter().enumerate() {
            let (mut s, mut c) = (0.0, 0.0);
            for j in 1..=k {
                let turned = j as f64 * angle[j];
                s += turned * self.cosines[n][k - j];
                c -= turned * self.sines[n][k - j];
            }
            let share = h.periods / k as f64;
            (self.sines[n][k], self.cosines[n][k]) = (share * s, share * c);
            self.value[k] += share * (h.sine * s + h.cosine * c);
        }
    }
}

fn product(a: &Terms, b: &Terms, k: usize) -> f64 {
    (0..=k).map(|j| a[j] * b[k - j]).sum()
}

impl Series {
    /// From a state, with what is linear. `torque` is the drive's where no winding makes it; ripple acts on that. `origin` is what angles count from.
    /// A rotor that sticks has
    /// no torque over its angle here.
    pub fn new(
        network: &Network,
        a: &Square,
        f: &State,
        x: &State,
        [torque, origin]: [f64; 2],
        stuck: bool,
    ) -> Self {
        let (size, build) = (network.size, &network.build);
        let mut terms = [[0.0; ORDER + 1]; MOST];
        (0..size).for_each(|j| terms[j][0] = x[j]);
        let flat = build.cogging.is_flat() && build.ripple.is_flat();
        let mut waves = (!stuck && !flat)
            .then(|| [&build.cogging, &build.ripple].map(|w| Waves::new(w, origin + x[ANGLE])));
        let lightness = 1.0 / build.parameters.inertia;
        for k in 0..ORDER {
            let mut next = if k == 0 { *f } else { [0.0; MOST] };
            for (row, next) in a.iter().zip(&mut next).take(size) {
                for (e, x) in row.iter().zip(&terms).take(size) {
                    *next += e * x[k];
                }
            }
            if let Some([cogging, ripple]) = &mut waves {
                if k > 0 {
                    cogging.extend(&terms[ANGLE], k);
                    ripple.extend(&terms[ANGLE], k);
                }
                let mut more = cogging.value[k] + torque * ripple.value[k];
                if let (Some(winding), Some(i)) = (build.winding(), network.current) {
                    more += winding.gain * product(&ripple.value, &terms[i], k);
                    next[i] -= winding.gain / winding.inductance * product(&ripple.value, &terms[SPEED], k);
                }
                next[SPEED] += more * lightness;
            }
            for (terms, next) in terms.iter_mut().zip(&next).take(size) {
                terms[k + 1] = next / (k + 1) as f64;
            }
        }
        Self { terms }
    }

    /// For how long the series of the angle holds where torque depends on it, by `periods` a turn: its last terms are below [`LEFT_OUT`] then.
    pub fn holds(&self, periods: f64) -> f64 {
        [ORDER - 1, ORDER]
            .map(|k| reach(periods * self.terms[ANGLE][k].abs(), k))
            .into_iter()
            .fold(f64::INFINITY, f64::min)
    }

    /// The state after a time.
    pub fn at(&self, t: f64, size: usize) -> State {
        let mut x = [0.0; MOST];
        for (x, terms) in x.iter_mut().zip(&self.terms).take(size) {
            *x = value(terms, t).0;
        }
        x
    }

    /// The series of a weighted sum of the state and an offset.
    pub fn sum(&self, row: &State, offset: f64, size: usize) -> Terms {
        let mut sum = [0.0; ORDER + 1];
        sum[0] = offset;
        for (weight, terms) in row.iter().zip(&self.terms).take(size) {
            if *weight != 0.0 {
                sum.iter_mut().zip(terms).for_each(|(sum, term)| *sum += weight * term);
            }
        }
        sum
    }
}

/// Where a term `size` t^k is as large as what may be left out.
fn reach(size: f64, k: usize) -> f64 {
    if size.is_normal() { exp((ln(LEFT_OUT) - ln(size)) / k as f64) } else { f64::INFINITY }
}

/// A series at a time, and its slope.
pub(super) fn value(terms: &Terms, t: f64) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for term in terms.iter().rev() {
        slope = slope * t + value;
        value = value * t + term;
    }
    (value, slope)
}
