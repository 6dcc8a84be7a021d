//! Diodes into a motor: which carrier makes which current flow against what a motor's turning sets against it.
//!
//! Behind a rectifier, current flows only while a half-wave is above the motor's own voltage E and what the diodes take, d. Without inductance
//! it flows while A sin x > u = E + d, and its mean over the half-waves is R i = (2/π) (√(A² − u²) − u acos(u/A)) of a bridge, half of that of one
//! diode: [`Rectifier::mean`] with u in the place of the drop. An inductance holds the current back at first and keeps it flowing
//! after, against u: less flows on average, down to (2/π) A − u where it never ceases.
//!
//! All of it grows as volts do, so one row of ratios is enough for every amplitude and every speed. Where the current of a bridge begins never
//! to cease, what flows has a kink: there the row has an entry, and beyond it is one straight line.

use super::carrier::{Carrier, Rectifier};
use crate::actuator::fault::{Fault, not_negative, positive};
use std::f64::consts::{PI, TAU};

/// Ratios that are worked out ahead.
const ROWS: usize = 256;

/// Halvings in which the end of a current is found.
const HALVINGS: usize = 60;

/// Pieces in which a square is integrated.
const PIECES: usize = 64;

/// What a carrier drives through a rectifier and a motor's winding.
#[derive(Debug, Clone, PartialEq)]
pub struct Conduction {
    rectifier: Rectifier,
    /// ωL/R: by how many radians of the carrier the current is late.
    lag: f64,
    /// Of each angle: (R i)/(R i + u), A/(R i + u), and the mean square of what ripples about R i over (R i + u)²; from what hardly flows to what
    /// flows against nothing.
    rows: Vec<[f64; 3]>,
}

impl Conduction {
    /// That of a carrier into a winding of a time constant L/R, s (0: without inductance).
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn new(carrier: &Carrier, electrical_time: f64) -> Result<Self, Fault> {
        positive("carrier", carrier.hertz)?;
        not_negative("diode_drop", carrier.rectifier.drop)?;
        not_negative("inductance", electrical_time)?;
        let (rectifier, lag) = (carrier.rectifier, TAU * carrier.hertz * electrical_time);
        let row = |opposed: f64| {
            let [flows, square] = flows(opposed, lag, rectifier.full_wave);
            let (whole, ripples) = (flows + opposed, (square - flows * flows).max(0.0));
            [flows / whole, 1.0 / whole, ripples / (whole * whole)]
        };
        let never_ceases = if rectifier.full_wave { never_ceases(lag) } else { 0.0 };
        let most = never_ceases.acos();
        let against = |n: usize| if n == ROWS { never_ceases } else { (most * n as f64 / ROWS as f64).cos() };
        let mut rows: Vec<[f64; 3]> = (0..=ROWS).map(against).map(row).collect();
        if never_ceases > 0.0 {
            rows.push(row(0.0));
        }
        Ok(Self { rectifier, lag, rows })
    }

    /// What stands against a carrier's amplitude while a motor's turning makes so many volts.
    fn against(&self, emf: f64) -> f64 {
        (emf + self.rectifier.drop).max(0.0)
    }

    /// What the mean current is worth on the resistance, V, for an amplitude (V) against a motor's own voltage (V).
    pub fn mean(&self, amplitude: f64, emf: f64) -> f64 {
        let against = self.against(emf);
        if !(amplitude > against && amplitude.is_finite()) {
            return 0.0;
        }
        amplitude * flows(against / amplitude, self.lag, self.rectifier.full_wave)[0]
    }

    /// The amplitude, V, whose mean current is worth so many volts on the resistance, against a motor's own voltage (V); 0 for what is
    /// not above 0.
    ///
    /// It looks the ratio up: the mean is within 2e-4 of the wish where that is 1 % or more of all that the amplitude works against (wish, motor and diodes
    /// together), within 1e-3 where it is 1e-3 of it, within 3e-3 where it is 1e-4.
    #[inline]
    pub fn amplitude(&self, mean: f64, emf: f64) -> f64 {
        if !(mean > 0.0 && mean.is_finite() && emf.is_finite()) {
            return 0.0;
        }
        let whole = mean + self.against(emf);
        let share = mean / whole;
        let above = self.rows.partition_point(|row| row[0] < share).clamp(1, self.rows.len() - 1);
        let ([low, from, _], [high, to, _]) = (self.rows[above - 1], self.rows[above]);
        let at = ((share - low) / (high - low)).clamp(0.0, 1.0);
        whole * (from + at * (to - from))
    }

    /// The root of the mean square of the current, on the resistance, V: of one whose mean is worth so many volts there, against a motor's own voltage
    /// (V). 0 for what is not above 0.
    #[inline]
    pub fn root(&self, mean: f64, emf: f64) -> f64 {
        if !(mean > 0.0 && mean.is_finite() && emf.is_finite()) {
            return 0.0;
        }
        let whole = mean + self.against(emf);
        let share = mean / whole;
        let above = self.rows.partition_point(|row| row[0] < share).clamp(1, self.rows.len() - 1);
        let ([low, _, from], [high, _, to]) = (self.rows[above - 1], self.rows[above]);
        let at = ((share - low) / (high - low)).clamp(0.0, 1.0);
        (mean * mean + whole * whole * (from + at * (to - from))).sqrt()
    }

    /// The mean whose root mean square that is while the motor stands: the inverse of [`Conduction::root`], V.
    pub fn mean_of_root(&self, root: f64) -> f64 {
        if !(root > 0.0 && root.is_finite()) {
            return 0.0;
        }
        let against = self.against(0.0);
        if against == 0.0 {
            return self.rows.last().map_or(0.0, |row| root / (1.0 + row[2]).sqrt());
        }
        // Of the whole it works against, what stands against it is 1 − share: with v what ripples, share² + v = (root/against)² (1 − share)².
        let times = root / against * (root / against);
        let left = |share: f64, ripples: f64| share * share + ripples - times * (1.0 - share) * (1.0 - share);
        let above = self.rows.partition_point(|row| left(row[0], row[2]) < 0.0);
        let above = above.clamp(1, self.rows.len() - 1);
        let ([low, _, from], [high, _, to]) = (self.rows[above - 1], self.rows[above]);
        // Between two rows both go in straight lines: a t² + 2 b t = c.
        let (way, c) = (high - low, -left(low, from));
        let (a, b) = ((1.0 - times) * way * way, (low + times * (1.0 - low)) * way + 0.5 * (to - from));
        let at = c / (b + (b * b + a * c).max(0.0).sqrt());
        let share = low + at.clamp(0.0, 1.0) * way;
        against * share / (1.0 - share)
    }
}

/// Against how much, as a share of the amplitude, the current of a bridge just never ceases: the steady state of |sin x| touches 0 where sin x = u.
/// That is 2/π of an endless lag, and nothing of none.
fn never_ceases(lag: f64) -> f64 {
    if lag == 0.0 {
        return 0.0;
    }
    let (whole, kept) = (1.0 + lag * lag, kept(lag));
    let least = |x: f64| (x.sin() - lag * x.cos()) / whole - x.sin() + kept * (-x / lag).exp();
    let (mut low, mut high) = (0.0, (2.0 / PI).asin());
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if least(middle) > 0.0 { low = middle } else { high = middle }
    }
    low.sin()
}

/// What is left at the beginning of a half-wave of those before, where the current never ceases: i(π) = i(0) leaves 2 lag/(1 + lag²), spread over them.
fn kept(lag: f64) -> f64 {
    -2.0 * lag / ((1.0 + lag * lag) * (-PI / lag).exp_m1())
}

/// The mean of R i, and that of its square, for an amplitude of 1 against `opposed`, 0 to 1, where the current is `lag` radians late.
fn flows(opposed: f64, lag: f64, full_wave: bool) -> [f64; 2] {
    let turn = if full_wave { PI } else { TAU };
    let begin = opposed.clamp(0.0, 1.0).asin();
    // ∫ (sin x − u) dx over what flows; the inductance keeps nothing from one half-wave to the next.
    let flowed = |end: f64| ((begin.cos() - end.cos()) - opposed * (end - begin)) / turn;
    if lag == 0.0 {
        let square = simpson(begin, PI - begin, |x| x.sin() - opposed) / turn;
        return [flowed(PI - begin).max(0.0), square];
    }
    // The current at x, after it was `before` at `from`, under sin x − u.
    let steady = |x: f64| (x.sin() - lag * x.cos()) / (1.0 + lag * lag) - opposed;
    let current =
        |x: f64, from: f64, before: f64| steady(x) + (before - steady(from)) * (-(x - from) / lag).exp();
    // From where the source is below what stands against it, the current only falls.
    let ends = |low: f64, high: f64, from: f64, before: f64| {
        let (mut low, mut high) = (low, high);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if current(middle, from, before) > 0.0 { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    };
    let once = |high: f64| {
        let end = ends(PI - begin, high, begin, 0.0);
        [flowed(end).max(0.0), simpson(begin, end, |x| current(x, begin, 0.0)) / turn]
    };
    if !full_wave {
        return once(TAU + begin);
    }
    let crossing = current(PI, begin, 0.0);
    if crossing <= 0.0 {
        return once(PI);
    }
    // The other pair of diodes takes over: the same half-wave again, from its beginning to where this one began, if it flows for so long; it
    // never ceases then, and the mean is that of a whole half-wave.
    let end = ends(0.0, begin, 0.0, crossing);
    let mean = (flowed(PI) + ((1.0 - end.cos()) - opposed * end) / turn).max(0.0);
    if opposed < never_ceases(lag) {
        let least = steady(0.0) + kept(lag);
        return [mean, simpson(0.0, PI, |x| current(x, 0.0, least)) / turn];
    }
    let square =
        simpson(begin, PI, |x| current(x, begin, 0.0)) + simpson(0.0, end, |x| current(x, 0.0, crossing));
    [mean, square / turn]
}

/// The integral of a square.
fn simpson(from: f64, to: f64, of: impl Fn(f64) -> f64) -> f64 {
    let step = (to - from) / PIECES as f64;
    let square = |n: usize| of(from + step * n as f64).powi(2);
    let inside = (1..PIECES).map(|n| square(n) * if n % 2 == 0 { 2.0 } else { 4.0 });
    (square(0) + inside.sum::<f64>() + square(PIECES)) * step / 3.0
}

#[cfg(test)]
mod tests;
