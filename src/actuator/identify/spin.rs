//! The speed of a rotor by a law of three numbers, and what a recording says of its angle.
//!
//! ω′ = g u − r ω − c with the drive u (volts or amperes), held over each sample: exact from sample to sample. Gravity in a mass that
//! spins only makes a ripple, which whole turns average out, and slows it by γ² r / (2 ω³) (the mean of γ sin θ over a turn, to second
//! order in γ/ω²; γ = m_e g r / J).

use std::f64::consts::TAU;
use std::ops::Range;

use super::least::solve;

/// The numbers of the law.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Law {
    /// g, rad/s² for each unit of the drive.
    pub gain: f64,
    /// r, 1/s.
    pub rate: f64,
    /// c, rad/s².
    pub drag: f64,
    /// Seconds by which the recording lags the drive.
    pub late: f64,
    /// r with open terminals, 1/s.
    pub coast: f64,
    /// γ, rad/s².
    pub gravity: f64,
    /// The r by which gravity slows it, 1/s: that of a voltage, whatever drives the law.
    pub damping: f64,
}

/// What drives the rotor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Push<'a> {
    /// What is held from each sample to the next, or a mean over that time; or amperes at each.
    pub samples: &'a [f64],
    /// Whether each is of the whole sample; else they are of instants, with straight lines between.
    pub held: bool,
    /// Where the terminals are open, and the drive says nothing.
    pub open: &'a [Range<usize>],
    /// Seconds a sample.
    pub period: f64,
}

/// A time over which the rotor turns one way.
#[derive(Debug, Clone)]
pub(super) struct Run {
    /// Samples.
    pub samples: Range<usize>,
    /// The way, 1 or −1: that of the drive which started it.
    pub sense: f64,
    /// Its speed at the beginning, rad/s.
    pub start: f64,
}

/// A run, sample by sample.
#[derive(Debug, Clone, Default)]
pub(super) struct Spun {
    /// rad, 0 at the beginning.
    pub angle: Vec<f64>,
    /// rad/s.
    pub speed: Vec<f64>,
    /// rad/s².
    pub bend: Vec<f64>,
}

/// What a whole number of turns of a recording says.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    /// The sample in its middle, of the run.
    pub middle: usize,
    /// By how much the recorded angle is ahead, rad; not wrapped.
    pub ahead: f64,
    /// The deviation of that by noise, rad.
    pub noise: f64,
    /// Amplitude over √(ω⁴ + α²).
    pub arm: f64,
    /// The second harmonic over the first, its phase counted from twice that of the first.
    pub second: [f64; 2],
    /// Mean square that is explained, and left.
    pub squares: [f64; 2],
}

/// A rate may come out somewhat below 0 where there is none, 1/s: so that a fit does not end at an edge.
const LEAST_RATE: f64 = -10.0;
/// Samples that a window has at least.
const SAMPLES: usize = 24;

impl Push<'_> {
    /// The drive in the mean over a sample, seconds `late`; `None` where the terminals are open.
    pub fn mean(&self, n: usize, late: f64) -> Option<f64> {
        let shift = late / self.period;
        let (whole, part) = (shift.floor(), shift - shift.floor());
        let at = |k: f64| {
            let k = (n as f64 - k).clamp(0.0, (self.samples.len() - 1) as f64) as usize;
            let next = (k + 1).min(self.samples.len() - 1);
            if self.held { self.samples[k] } else { 0.5 * (self.samples[k] + self.samples[next]) }
        };
        let now = (n as f64 - whole).max(0.0) as usize;
        let open = self.open.iter().any(|range| range.contains(&now));
        (!open).then(|| (1.0 - part) * at(whole) + part * at(whole + 1.0))
    }

    /// Whether the drive is the same, and on, all over some runs.
    pub fn is_steady(&self, runs: &[Run]) -> bool {
        let mut all = runs.iter().flat_map(|run| run.samples.clone().map(|n| (run.sense, n)));
        let first = all.next().and_then(|(sense, n)| Some(sense * self.mean(n, 0.0)?));
        let (least, most) = self.samples.iter().fold((0.0_f64, 0.0_f64), |(l, m), x| (l.min(*x), m.max(*x)));
        let same = |value: f64| first.is_some_and(|first| (first - value).abs() <= 1e-3 * (most - least));
        all.all(|(sense, n)| self.mean(n, 0.0).is_some_and(|u| same(sense * u)))
    }
}

impl Law {
    /// A run by this law; `None` where the numbers cannot be.
    pub fn spin(&self, run: &Run, push: &Push) -> Option<Spun> {
        let t = push.period;
        let steps = [self.rate, self.coast].map(|rate| {
            let z = rate * t;
            // (1 − e^−z)/z and (z − 1 + e^−z)/z², times T and T².
            let q = if z.abs() < 1e-6 { 1.0 - 0.5 * z } else { -(-z).exp_m1() / z };
            let p = if z.abs() < 1e-3 { 0.5 - z / 6.0 + z * z / 24.0 } else { (1.0 - q) / z };
            (rate, q * t, p * t * t)
        });
        let finite = [self.gain, self.drag, self.late, run.start, self.gravity].iter().all(|x| x.is_finite());
        if !finite || !steps.iter().all(|(rate, ..)| (LEAST_RATE..1e9).contains(rate)) {
            return None;
        }
        let slowest = self.slowest();
        let mut spun = Spun::default();
        let (mut angle, mut speed) = (0.0, run.start);
        for n in run.samples.clone() {
            let drive = push.mean(n, self.late);
            let (rate, q, p) = steps[usize::from(drive.is_none())];
            let pull = drive.map_or(0.0, |u| self.gain * run.sense * u);
            let sinks =
                self.gravity * self.gravity * self.damping * 0.5 / speed.max(slowest).powi(3).max(1e-300);
            let bend = pull - self.drag - sinks - rate * speed;
            spun.angle.push(angle);
            spun.speed.push(speed);
            spun.bend.push(bend);
            angle += speed * t + p * bend;
            speed += q * bend;
        }
        Some(spun)
    }

    /// The speed below which gravity is more than a ripple, rad/s.
    pub fn slowest(&self) -> f64 {
        (10.0 * self.gravity).sqrt()
    }
}

impl Spun {
    /// What a recording says, whole turn by whole turn: x = E ((ω² sin − α cos)(θ + ahead)) and what gravity adds at twice the frequency.
    pub fn windows(&self, x: &[f64]) -> Vec<Window> {
        let (mut windows, mut begin, mut last) = (Vec::<Window>::new(), 0, 0.0);
        while let Some(window) = self.next(x, begin, last) {
            let (end, window) = window;
            last = window.ahead;
            windows.push(window);
            begin = end;
        }
        windows
    }

    /// The samples from `begin` on that make whole turns, enough of them; and where they end.
    fn next(&self, x: &[f64], begin: usize, last: f64) -> Option<(usize, Window)> {
        let from = *self.angle.get(begin)?;
        let per_turn = TAU / (self.angle.get(begin + 1)? - from);
        let turns = (SAMPLES as f64 / per_turn).ceil().max(1.0);
        let length = self.angle[begin..].iter().take_while(|angle| **angle < from + TAU * turns).count();
        let end = begin + length;
        if per_turn <= 0.0 || per_turn.is_nan() || end >= self.angle.len() || length < SAMPLES / 2 {
            return None;
        }
        let middle = begin + length / 2;
        let unit = self.speed[middle] * self.speed[middle];
        let (mut normal, mut right, mut square) = (vec![vec![0.0; 5]; 5], [0.0; 5], 0.0);
        for n in begin..end {
            let (s, c) = self.angle[n].sin_cos();
            let [a, b] = [self.speed[n] * self.speed[n] / unit, self.bend[n] / unit];
            let row = [1.0, a * s - b * c, a * c + b * s, 2.0 * s * c, c * c - s * s];
            for i in 0..5 {
                right[i] += row[i] * x[n];
                (0..5).for_each(|j| normal[i][j] += row[i] * row[j]);
            }
            square += x[n] * x[n];
        }
        let found = solve(&normal, &right)?;
        let left = square - found.iter().zip(&right).map(|(f, r)| f * r).sum::<f64>();
        let count = length as f64;
        let left = left.max(0.0) / (count - 5.0).max(1.0);
        let amplitude = found[1].hypot(found[2]);
        let phase = found[2].atan2(found[1]);
        let ahead = phase + TAU * ((last - phase) / TAU).round();
        let (s, c) = (2.0 * phase).sin_cos();
        let second = [found[3] * c + found[4] * s, found[4] * c - found[3] * s].map(|h| h / amplitude);
        let noise = (2.0 * left / count).sqrt() / amplitude;
        let squares = [0.5 * amplitude * amplitude, left];
        (amplitude > 0.0)
            .then_some((end, Window { middle, ahead, noise, arm: amplitude / unit, second, squares }))
    }
}

#[cfg(test)]
mod tests;
