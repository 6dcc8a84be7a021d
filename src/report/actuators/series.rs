//! Taylor series of the motion under a held drive, as long as nothing begins or ends.

use super::equation::{Equation, LARGE, LINEAR, State};

/// Terms beyond the first.
pub const ORDER: usize = 24;
/// The last two terms may be this share of the largest.
const TAIL: f64 = 1e-18;

type Terms = [f64; ORDER + 1];

/// What holds meanwhile.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Regime {
    /// Whether dry friction holds it at rest.
    pub sticks: bool,
    /// Sense in which it slips where there is dry friction: 1 or −1; else 0.
    pub slips: f64,
    /// Side of the end stop that pushes: 1 or −1; 0: none.
    pub stop: f64,
}

/// Coefficients by powers of time, of current, speed and place.
#[derive(Debug, Clone)]
pub struct Series {
    terms: [Terms; 3],
}

impl Series {
    /// From a state, by the recurrences that the equations are between coefficients.
    pub fn new(e: &Equation, regime: &Regime, [current, speed, place]: State, drive: f64) -> Self {
        let (kind, zero) = (e.kind(), [0.0; ORDER + 1]);
        let [mut i, mut v, mut y, mut square, mut gain, mut sine, mut cosine] = [zero; 7];
        (i[0], v[0], y[0]) = (current, if regime.sticks { 0.0 } else { speed }, place);
        (sine[0], cosine[0]) = place.sin_cos();
        let mut steady = e.direct * drive - regime.slips * e.coulomb;
        if regime.stop != 0.0 {
            steady += regime.stop * e.stop_stiffness * e.stroke;
        }
        let touching = regime.stop.abs();
        let (stiffness, damping) =
            (e.stiffness + touching * e.stop_stiffness, e.damping + touching * e.stop_damping);
        for n in 0..ORDER {
            let (first, next) = (if n == 0 { 1.0 } else { 0.0 }, (n + 1) as f64);
            let (mut force, mut back) = (e.gain * i[n], e.gain * v[n]);
            if kind == LARGE {
                square[n] = product(&y, &y, n);
                gain[n] = e.gain * (first - e.falls * square[n]);
                (force, back) = (product(&gain, &i, n), product(&gain, &v, n));
                force -= e.cubic * product(&square, &y, n);
            } else if kind != LINEAR && e.weight != 0.0 {
                if n > 0 {
                    // s' = c y' and c' = −s y'.
                    let sum =
                        |of: &Terms| (1..=n).map(|k| k as f64 * y[k] * of[n - k]).sum::<f64>() / n as f64;
                    (sine[n], cosine[n]) = (sum(&cosine), -sum(&sine));
                }
                force -= e.weight * sine[n];
            }
            i[n + 1] = (first * drive - e.resistance * i[n] - back) / (e.inductance * next);
            force += first * steady - damping * v[n] - stiffness * y[n];
            v[n + 1] = if regime.sticks { 0.0 } else { force / (e.inertia * next) };
            y[n + 1] = v[n] / next;
        }
        Self { terms: [i, v, y] }
    }

    /// How far all has gone after a time.
    pub fn change(&self, time: f64) -> State {
        self.terms.map(|terms| time * terms[1..].iter().rev().fold(0.0, |sum, term| sum * time + term))
    }

    /// Where all is after a time.
    pub fn at(&self, time: f64) -> State {
        self.terms.map(|terms| terms.iter().rev().fold(0.0, |sum, term| sum * time + term))
    }

    /// The largest part of a time that the series is good for.
    pub fn reach(&self, time: f64) -> f64 {
        let good = |time: f64| {
            self.terms.iter().all(|terms| {
                let (mut power, mut most, mut size) = (1.0, 0.0f64, [0.0; 2]);
                for term in terms {
                    size = [size[1], (term * power).abs()];
                    most = most.max(size[1]);
                    power *= time;
                }
                size[0].max(size[1]) <= TAIL * most
            })
        };
        let mut time = time;
        for _ in 0..200 {
            if good(time) {
                break;
            }
            time *= 0.8;
        }
        time
    }
}

/// The `n`th coefficient of a product.
fn product(a: &Terms, b: &Terms, n: usize) -> f64 {
    (0..=n).map(|k| a[k] * b[n - k]).sum()
}
