//! A motor's winding, from its current: V = R i + L di/dt + k ω.
//!
//! The speed is that of the fitted law. The current is simulated from the voltage and compared with the recorded one, rather than its derivative
//! taken: noise of the recording stays outside of the law then, and biases nothing.

mod course;

use super::estimate::Identified;
use super::initial::of_spun;
use super::least::{descend, linear};
use super::rotor::Rotor;
use super::spin::{Law, Push, Run};
use course::{Course, Figures, mean};
use std::ops::Range;

/// The part of a sample to which the instants of voltage and current are known at best.
const INSTANT: f64 = 0.1;
/// The same, one standard deviation, of a drive that comes back: where between two samples it jumps is not in it. So much is not known of any
/// delay, at least, whatever a coil of a sample or less seems to say.
const BETWEEN: f64 = 0.5;
/// Samples by which what a recording and its fit leave open is tried.
const FARTHEST: f64 = 1.0;
/// Samples to both sides over which an unknown instant is looked for; and those that a coil takes at least to be told from one.
const SOUGHT: isize = 6;
const SLOWEST: f64 = 1.5;
/// What a sample may leave of a current, to begin with.
const LEAVES: [f64; 4] = [0.05, 0.4, 0.75, 0.93];
/// The samples that a coil may take that shows in none.
const HIDDEN: f64 = 0.3;
/// The most that may be left of the current's mean square.
const LEFT: f64 = 0.3;

/// How well it is known by how many seconds a current is behind what is at the terminals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Instant {
    /// So many.
    Fixed(f64),
    /// So many, to a part of a sample.
    About(f64),
    /// Nobody knows, but a few samples at most.
    Unknown,
}

/// What was fitted.
#[derive(Debug, Clone)]
pub(super) struct Winding {
    /// R, ohm, and how far off it may be.
    pub resistance: [f64; 2],
    /// k, N m/A, and how far off it may be.
    pub gain: [f64; 2],
    /// Seconds by which the current is behind the drive, and how far off they may be.
    pub late: [f64; 2],
    /// L/R, s: its least, itself, its most.
    times: [f64; 3],
    /// Whether the coil is told from a delay.
    pub is_told: bool,
    figures: Figures,
    period: f64,
}

impl Winding {
    /// From a current, the voltages behind it, and the speeds; `None` where it does not follow them.
    pub fn of(current: &[f64], runs: &[(Run, Vec<f64>)], push: &Push, instant: Instant) -> Option<Self> {
        let course = Course::of(current, runs, push);
        let period = push.period;
        let (first, left) = guess(&course, instant, period)?;
        let of = |p: &[f64]| Figures {
            conductance: p[0],
            gain: p[1],
            leaves: p.get(2).copied().unwrap_or(0.0),
            late: p.get(3).copied().unwrap_or(first.late),
        };
        // What is known beforehand is one more residual, as strong as the noise makes it.
        let deviation = (left / course.len() as f64).sqrt();
        let rest = |p: &[f64]| {
            let figures = of(p);
            let mut rest = course.rest(&figures)?;
            if let Instant::About(seconds) = instant {
                rest.push(deviation * (figures.late - seconds / period) / BETWEEN);
            }
            Some(rest)
        };
        let begin = [first.conductance, first.gain, first.leaves.max(LEAVES[0]), first.late];
        let steps = [1e-6 * begin[0].abs(), 1e-6 * begin[1].abs().max(1e-12), 1e-6, 1e-4];
        let free = if matches!(instant, Instant::Fixed(_)) { 3 } else { 4 };
        let (fit, [leaves, late]) = match descend(&begin[..free], &steps[..free], rest) {
            Some(fit) => {
                let both = [2, 3].map(|n| match fit.values.get(n) {
                    Some(value) => {
                        let mut gradient = vec![0.0; free];
                        gradient[n] = 1.0;
                        [*value, fit.off(&gradient)]
                    }
                    None => [first.late, 0.0],
                });
                (fit, both)
            }
            // Nothing in it depends on the coil.
            None => {
                let fit = descend(&begin[..2], &steps[..2], |p| course.rest(&of(p)))?;
                (fit, [[0.0; 2], [first.late, 0.0]])
            }
        };
        if !(fit.left < LEFT * course.square() && fit.values[0] > 0.0 && fit.values[1] > 0.0) {
            return None;
        }
        // At the end of what was looked through, what belongs together is farther away.
        if instant == Instant::Unknown && late[0].abs() > SOUGHT as f64 - 0.5 {
            return None;
        }
        let time = |e: f64| if e > 0.0 { -period / e.min(1.0 - 1e-12).ln() } else { 0.0 };
        let mut times = [leaves[0] - leaves[1], leaves[0], leaves[0] + leaves[1]].map(time);
        let is_told = times[1] > SLOWEST * period || matches!(instant, Instant::Fixed(_));
        if !is_told {
            let most = if instant == Instant::Unknown { 2.0 * SLOWEST } else { 1.0 };
            times = [0.0, times[1], times[1].max(most * period)];
        }
        let off = match (instant, is_told) {
            (Instant::Fixed(_), _) => 0.0,
            (_, true) => late[1],
            (_, false) => late[1].max(BETWEEN),
        };
        let with_off = |figure: &dyn Fn(&[f64]) -> f64| [figure(&fit.values), fit.off_of(figure)];
        Some(Self {
            resistance: with_off(&|p| 1.0 / p[0]),
            gain: with_off(&|p| p[1] / p[0]),
            late: [late[0], off].map(|samples| samples * period),
            times,
            is_told,
            figures: of(&fit.values),
            period,
        })
    }

    /// The instants that are as far off as they may be, a sample at most: what they do to a figure, an interval must hold. None where it is known.
    pub fn others(&self) -> Vec<Instant> {
        let [late, off] = self.late;
        let off = off.min(FARTHEST * self.period);
        if off > 0.0 { vec![Instant::Fixed(late - off), Instant::Fixed(late + off)] } else { Vec::new() }
    }

    /// The same with intervals as much wider as others differ.
    pub fn wider<'a>(mut self, others: impl Iterator<Item = &'a Self>) -> Self {
        let (r, k) = (self.resistance, self.gain);
        for other in others {
            self.resistance[1] = self.resistance[1].max(r[1] + (other.resistance[0] - r[0]).abs());
            self.gain[1] = self.gain[1].max(k[1] + (other.gain[0] - k[0]).abs());
        }
        self
    }

    /// The mean current over each sample, by this winding wherever the rotor was seen to turn: without the noise of the recording.
    pub fn currents(&self, recorded: &[f64], runs: &[(Run, Vec<f64>)], push: &Push) -> Vec<f64> {
        let next = |n: usize| recorded[(n + 1).min(recorded.len() - 1)];
        let mut all: Vec<f64> = (0..recorded.len()).map(|n| 0.5 * (recorded[n] + next(n))).collect();
        let is_open = |n: usize| push.open.iter().any(|range| range.contains(&n));
        for (run, speed) in runs {
            let Range { start, end } = run.samples;
            let mut now = run.sense * recorded[start.min(recorded.len() - 1)];
            for n in start..end.min(all.len() - 1) {
                if is_open(n) {
                    (now, all[n]) = (0.0, 0.0);
                    continue;
                }
                let speed = mean(speed, n - start);
                let next = self.figures.next(now, run.sense, speed, push.samples, n);
                all[n] = run.sense * self.figures.mean([now, next], run.sense, speed, push.samples, n);
                now = next;
            }
        }
        all
    }

    /// L/R, s: its least, itself, its most.
    pub fn electrical_time(&self) -> [f64; 3] {
        self.times
    }

    /// What of it a rig knows.
    pub fn tell(&self, all: &mut Identified) {
        let [r, off] = self.resistance;
        all.key("resistance", "ohm", r, [off, off]);
        let [least, time, most] = self.times;
        if self.is_told && least > 0.0 {
            let share = off / r;
            let off = r * INSTANT * self.period;
            let sides = [r * (time - least * (1.0 - share)), r * (most * (1.0 + share) - time)];
            all.key("inductance", "H", r * time, sides.map(|side| side + off));
        } else if self.is_told {
            let most = r * most.max(HIDDEN * self.period);
            all.untold(
                "inductance",
                format!("the current settles within a sample: below {most:.1e} H; record faster to see it"),
            );
        } else {
            let why = format!(
                "the current settles within some two samples, which cannot be told from a delay: below {:.1e} H; record faster to see it",
                r * most
            );
            all.untold("inductance", why);
        }
        let [k, off] = self.gain;
        all.key("torque_constant", "N m/A", k, [off, off]);
    }

    /// The law of the same motion under the current.
    pub fn law(rotor: &Rotor, volts: &Push, current: &Push) -> Option<Law> {
        let law = of_spun(&rotor.speeds(volts), current)?;
        Some(Law { gravity: rotor.law.gravity, damping: rotor.law.damping, ..law })
    }
}

/// A first guess, and the squares that it leaves: of every delay and some coils, the best.
fn guess(course: &Course, instant: Instant, period: f64) -> Option<(Figures, f64)> {
    let lates: Vec<f64> = match instant {
        Instant::Fixed(seconds) => vec![seconds / period],
        Instant::About(seconds) => [-1.0, 0.0, 1.0].map(|more| seconds / period + more).to_vec(),
        // Between two samples, so that both sides show.
        Instant::Unknown => (-SOUGHT..=SOUGHT).map(|late| late as f64 + 0.5).collect(),
    };
    let mut best: Option<(Figures, f64)> = None;
    for late in lates {
        let first = linear(course.rows(late.floor() as isize), 2)?;
        for leaves in LEAVES.into_iter().chain([0.0]) {
            let figures = Figures { conductance: first[0], gain: first[1], leaves, late };
            let Some(rest) = course.rest(&figures) else { continue };
            let left = rest.iter().map(|r| r * r).sum::<f64>();
            if best.is_none_or(|(_, least)| left < least) {
                best = Some((figures, left));
            }
        }
    }
    best
}

/// k from the voltage at open terminals, and how far off it may be.
pub(super) fn of_open(voltage: &[f64], rotor: &Rotor, push: &Push) -> Option<(f64, f64)> {
    let mut pairs = Vec::new();
    for (run, speed) in rotor.speeds(push) {
        let open = |n: &usize| push.open.iter().any(|range| range.contains(n));
        let samples = run.samples.clone().filter(open);
        pairs.extend(samples.map(|n| (run.sense * voltage[n], speed[n - run.samples.start])));
    }
    let fit = descend(&[1e-3], &[1e-9], |p| Some(pairs.iter().map(|(v, w)| p[0] * w - v).collect()))?;
    Some((fit.values[0], fit.off(&[1.0])))
}
