//! A motor's winding, from its current: V = R i + L di/dt + k ω.
//!
//! The speed is that of the fitted law. The current is simulated from the voltage and compared with the recorded one, rather than its derivative
//! taken: noise of the recording stays outside of the law then, and biases nothing.

use super::estimate::Identified;
use super::initial::of_spun;
use super::least::{Fit, descend, linear};
use super::rotor::Rotor;
use super::spin::{Law, Push, Run};

/// The part of a sample to which the instants of voltage and current are known.
const INSTANT: f64 = 0.1;

/// What was fitted.
#[derive(Debug, Clone)]
pub(super) struct Winding {
    /// R, ohm, and how far off it may be.
    pub resistance: [f64; 2],
    /// k, N m/A, and how far off it may be.
    pub gain: [f64; 2],
    /// e^(−R T/L), what a sample leaves of a current: its least, itself, its most.
    leaves: [f64; 3],
    period: f64,
}

/// The most that may be left of the current's mean square.
const LEFT: f64 = 0.3;

impl Winding {
    /// From a current, the voltages behind it, and the speeds; `None` where it does not follow them.
    pub fn of(current: &[f64], runs: &[(Run, Vec<f64>)], push: &Push) -> Option<Self> {
        let is_open = |n: usize| push.open.iter().any(|range| range.contains(&n));
        // In the sense of the run: voltage, speed, current, and that of the next sample.
        let mut steps: Vec<[f64; 4]> = Vec::new();
        let mut begins = Vec::new();
        for (run, speed) in runs {
            begins.push(steps.len());
            let last = run.samples.end.min(current.len() - 1);
            for n in run.samples.start..last {
                if is_open(n) {
                    begins.push(steps.len());
                    continue;
                }
                let at = n - run.samples.start;
                let mean = 0.5 * (speed[at] + speed.get(at + 1).copied().unwrap_or(speed[at]));
                let s = run.sense;
                steps.push([s * push.samples[n], mean, s * current[n], s * current[n + 1]]);
            }
        }
        let rows = steps.iter().map(|[v, w, i, next]| (vec![*v, -*w], 0.5 * (i + next)));
        let first = linear(rows, 2)?;
        let square: f64 = steps.iter().map(|s| s[3] * s[3]).sum::<f64>() / steps.len() as f64;
        let rest = |p: &[f64], leaves: f64| -> Option<Vec<f64>> {
            if !(0.0..1.0).contains(&leaves) {
                return None;
            }
            let (mut i, mut next) = (0.0, begins.iter().peekable());
            let mut rest = Vec::with_capacity(steps.len());
            for (n, [v, w, begin, now]) in steps.iter().enumerate() {
                while next.next_if(|b| **b <= n).is_some() {
                    i = *begin;
                }
                i = leaves * i + (1.0 - leaves) * (p[0] * v - p[1] * w);
                rest.push(i - now);
            }
            Some(rest)
        };
        let begin = [first[0], first[1], 0.05];
        let steps_of = [1e-6 * first[0].abs(), 1e-6 * first[1].abs().max(1e-12), 1e-6];
        let with = descend(&begin, &steps_of, |p| rest(p, p[2]));
        let (fit, leaves) = match with {
            Some(fit) => {
                let off = fit.off(&[0.0, 0.0, 1.0]);
                let e = fit.values[2];
                (fit, [e - off, e, e + off])
            }
            None => (descend(&begin[..2], &steps_of[..2], |p| rest(p, 0.0))?, [0.0; 3]),
        };
        if !(fit.left < LEFT * square && fit.values[0] > 0.0 && fit.values[1] > 0.0) {
            return None;
        }
        let with_off = |figure: &dyn Fn(&[f64]) -> f64, fit: &Fit| [figure(&fit.values), fit.off_of(figure)];
        Some(Self {
            resistance: with_off(&|p| 1.0 / p[0], &fit),
            gain: with_off(&|p| p[1] / p[0], &fit),
            leaves,
            period: push.period,
        })
    }

    /// The current by this winding wherever the rotor was seen to turn: without the noise of the recording.
    pub fn current(&self, recorded: &[f64], runs: &[(Run, Vec<f64>)], push: &Push) -> Vec<f64> {
        let mut all = recorded.to_vec();
        let ([r, _], [k, _], [_, leaves, _]) = (self.resistance, self.gain, self.leaves);
        for (run, speed) in runs {
            let last = run.samples.end.min(all.len() - 1);
            for n in run.samples.start..last {
                let at = n - run.samples.start;
                let mean = 0.5 * (speed[at] + speed.get(at + 1).copied().unwrap_or(speed[at]));
                all[n + 1] = match push.mean(n, 0.0) {
                    Some(volts) => leaves * all[n] + (1.0 - leaves) * (volts - run.sense * k * mean) / r,
                    None => 0.0,
                };
            }
        }
        all
    }

    /// L/R, s: its least, itself, its most.
    pub fn electrical_time(&self) -> [f64; 3] {
        self.leaves.map(|e| if e > 0.0 { -self.period / e.min(1.0 - 1e-12).ln() } else { 0.0 })
    }

    /// What of it a rig knows.
    pub fn tell(&self, all: &mut Identified) {
        let [r, off] = self.resistance;
        all.key("resistance", "ohm", r, [off, off]);
        let [least, time, most] = self.electrical_time();
        if self.leaves[0] > 0.0 {
            let share = off / r;
            let off = r * INSTANT * self.period;
            let sides = [r * (time - least * (1.0 - share)), r * (most * (1.0 + share) - time)];
            all.key("inductance", "H", r * time, sides.map(|side| side + off));
        } else {
            let most = r * most.max(0.3 * self.period);
            all.untold(
                "inductance",
                format!("the current settles within a sample: below {most:.1e} H; record faster to see it"),
            );
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
