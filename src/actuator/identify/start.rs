//! The drive with which a rotor leaves rest, from the recording itself.
//!
//! From any instant on the law says how a rotor at rest would turn, and so all of what is recorded but its amplitude and its phase. It began when
//! that agrees best. Looking back by the law from where it was seen would not do: backward, errors grow by e with every time constant, and the
//! more slowly a drive rises the longer a rotor turns unseen.

use super::least::solve;
use super::rotor::Rotor;
use super::spin::{Law, Push, Run};

/// With which drive a rotor began, in the sense in which it turns then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Began {
    /// The likeliest.
    pub at: f64,
    /// The least and the most that go with the recording.
    pub within: [f64; 2],
}

/// Time constants over which it is followed from where it was seen on.
const FOLLOWED: f64 = 2.0;
/// Instants in a time constant that are looked at first, and then in each of those.
const COARSE: f64 = 16.0;
const FINE: usize = 8;
/// The squares may grow by that of the 97.5 % quantile, four times: filters connect samples, and the law is known but so well.
const MORE: f64 = 4.0 * 3.84;
/// The part of a run's square that may be left where it began from rest.
const UNLIKE: f64 = 0.4;
/// Samples that are followed at least.
const LEAST: usize = 32;

/// Samples over which a leap may be spread.
const SPREAD: usize = 2;
/// Columns of what is fitted at an instant: middle, amplitude and phase, and both with what another friction would do to the angle.
const COLUMNS: usize = 5;

/// What is compared.
struct Rest<'a> {
    x: &'a [f64],
    push: &'a Push<'a>,
    law: Law,
    run: &'a Run,
    /// Where it is no longer followed.
    end: usize,
    /// Number, sum and sum of squares of what was recorded from where it can have begun first.
    sums: [f64; 3],
}

impl Began {
    /// A run of a rotor; `None` where it did not begin at rest, or where the drive did not rise.
    pub fn of(x: &[f64], rotor: &Rotor, run: &Run, push: &Push) -> Option<Self> {
        let law = Law { gravity: 0.0, ..rotor.law };
        let volts = |n: usize| Some(run.sense * push.mean(n, law.late)?);
        // Nothing turns below what running takes.
        let (running, off) = rotor.told(|law| law.drag / law.gain);
        let before = rotor.runs.iter().map(|other| other.samples.end).filter(|end| *end <= run.samples.start);
        let before = before.max().unwrap_or(0);
        let last = run.samples.start;
        let mut first = last;
        while first > before && volts(first - 1)? <= volts(first)? && volts(first - 1)? > running - off {
            first -= 1;
        }
        // Unless it was driven too little to turn before, it may have turned.
        let limit = match first.checked_sub(1) {
            Some(before) if volts(before)? <= running - off => before.saturating_sub(SPREAD - 1),
            _ => first,
        };
        let time = 1.0 / (law.rate * push.period);
        let end = run.samples.end.min(last + (FOLLOWED * time).min(x.len() as f64) as usize);
        if first == last || end < last + LEAST || end > x.len() {
            return None;
        }
        let all = &x[first..end];
        let sums = [all.len() as f64, all.iter().sum(), all.iter().map(|x| x * x).sum()];
        let rest = Rest { x, push, law, run, end, sums };
        let step = ((time / COARSE) as usize).max(1);
        let coarse: Vec<(usize, f64)> =
            (first..=last).step_by(step).filter_map(|n| Some((n, rest.left(n)?))).collect();
        let best = coarse.iter().min_by(|a, b| a.1.total_cmp(&b.1))?.0;
        let small = (step / FINE).max(1);
        let near = (best.saturating_sub(step).max(first)..=(best + step).min(last)).step_by(small);
        let near = near.filter_map(|n| Some((n, rest.left(n)?)));
        let (best, least) = near.min_by(|a, b| a.1.total_cmp(&b.1))?;
        let noise = least / (sums[0] - COLUMNS as f64 - 1.0);
        if noise * (end - last) as f64 > UNLIKE * square(&x[last..end]) {
            return None;
        }
        let goes = |n: usize| rest.left(n).is_some_and(|left| left <= least + MORE * noise);
        let rough = |n: &&(usize, f64)| n.1 <= least + MORE * noise;
        let edge = |from: usize, forward: bool| {
            let mut n = from;
            loop {
                let next = if forward { n + small } else { n.saturating_sub(small) };
                if !(first..=last).contains(&next) || next == n || !goes(next) {
                    return n;
                }
                n = next;
            }
        };
        // Where a rotor was at another angle it may have begun a turn sooner or later.
        let ends = coarse.iter().filter(rough).fold([best; 2], |[a, b], (n, _)| [a.min(*n), b.max(*n)]);
        let (soon, late) = (edge(ends[0], false), edge(ends[1], true));
        // What does not rise may have been enough for some time.
        let mut sooner = soon.saturating_sub(small).max(first);
        while sooner > first && volts(sooner - 1)? == volts(sooner)? {
            sooner -= 1;
        }
        if sooner == first && limit == first {
            return None;
        }
        // A leap that falls between two samples is spread over them.
        let sooner = sooner.saturating_sub(SPREAD).max(limit);
        let later = (late + small + SPREAD).min(push.samples.len() - 1);
        let within = [volts(sooner)? - off, volts(later)? + off];
        Some(Self { at: volts(best)?, within })
    }
}

impl Rest<'_> {
    /// The squares that are left if it was at rest until a sample.
    fn left(&self, from: usize) -> Option<f64> {
        let run = Run { samples: from..self.end, sense: self.run.sense, start: 0.0 };
        let spun = self.law.spin(&run, self.push)?;
        let unit = spun.speed.last()?.powi(2);
        let [count, sum, squares] = self.sums;
        let (mut normal, mut right) = (vec![vec![0.0; COLUMNS]; COLUMNS], [0.0; COLUMNS]);
        // θ by a drag: ψ″ = −1 − r ψ′, in time constants.
        let per = self.law.rate * self.push.period;
        for (n, x) in self.x[from..self.end].iter().enumerate() {
            let (s, c) = spun.angle[n].sin_cos();
            let [a, b] = [spun.speed[n] * spun.speed[n] / unit, spun.bend[n] / unit];
            let t = per * n as f64;
            let drags = t + (-t).exp_m1();
            let row = [1.0, a * s - b * c, a * c + b * s, drags * a * s, drags * a * c];
            for i in 0..COLUMNS {
                right[i] += row[i] * x;
                (i..COLUMNS).for_each(|j| normal[i][j] += row[i] * row[j]);
            }
        }
        for i in 0..COLUMNS {
            (0..i).for_each(|j| normal[i][j] = normal[j][i]);
        }
        (normal[0][0], right[0]) = (count, sum);
        let found = solve(&normal, &right)?;
        let left = squares - found.iter().zip(&right).map(|(f, r)| f * r).sum::<f64>();
        (unit > 0.0 && left.is_finite()).then_some(left.max(0.0))
    }
}

/// The sum of squares about the mean.
fn square(x: &[f64]) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    x.iter().map(|x| (x - mean) * (x - mean)).sum()
}
