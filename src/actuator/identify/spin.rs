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
    /// Volts that are held from each sample to the next, or amperes at each.
    pub samples: &'a [f64],
    /// Whether they are held.
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
mod tests {
    use super::{Law, Push, Run};
    use crate::actuator::motor::{Drive, Motor, Parameters, Plan, Wish};

    /// The law against the exact motor: without inductance and gravity they are one.
    #[test]
    fn it_is_the_motor_where_gravity_and_inductance_are_left_out() {
        let p = Parameters { gravity: 0.0, inductance: 0.0, ..Parameters::COIN };
        let plan = Plan::choose(&p, 8000.0, &Wish { error: 0.0, posture: true, casing: true });
        let mut motor = Motor::<false>::new(&p, &plan, 8000.0).unwrap();
        let inertia = p.effective_inertia();
        let law = Law {
            gain: p.gain / p.resistance / inertia,
            rate: 1.0 / p.mechanical_time(),
            drag: p.coulomb / inertia,
            late: 0.0,
            coast: p.viscous / inertia,
            gravity: 0.0,
            damping: 0.0,
        };
        let volts: Vec<f64> = (0..1600).map(|n| if n < 800 { -3.0 } else { -1.5 }).collect();
        let open: Vec<_> = std::iter::once(1200..1400).collect();
        let push = Push { samples: &volts, held: true, open: &open, period: 1.0 / 8000.0 };
        let spun = law.spin(&Run { samples: 0..1600, sense: -1.0, start: 0.0 }, &push).unwrap();
        for n in 0..1600 {
            let turned = std::f64::consts::TAU * motor.reading().turns + motor.reading().angle;
            assert!((spun.speed[n] + motor.speed()).abs() < 1e-8, "{n}: {} {}", spun.speed[n], motor.speed());
            assert!((spun.angle[n] + turned).abs() < 1e-9 * (1.0 + turned.abs()), "{n}");
            motor.drive(if open[0].contains(&n) { Drive::Open } else { Drive::Voltage(volts[n]) });
            if n > 0 {
                assert!((spun.bend[n] + motor.angular_acceleration()).abs() < 1e-6 * law.drag, "{n}");
            }
            motor.step();
        }
        // Half a sample late: the volt-seconds of both neighbours.
        let late = Law { late: 0.5 / 8000.0, ..law };
        let spun = late.spin(&Run { samples: 700..900, sense: -1.0, start: 1000.0 }, &push).unwrap();
        let held = |n: usize| spun.bend[n] + law.drag + law.rate * spun.speed[n];
        assert!((held(100) / law.gain - 2.25).abs() < 1e-9 && (held(101) / law.gain - 1.5).abs() < 1e-9);
        assert!(
            Law { rate: -11.0, ..law }.spin(&Run { samples: 0..9, sense: 1.0, start: 0.0 }, &push).is_none()
        );
    }

    /// What gravity takes of the mean speed, against the exact motor over some hundred turns: near the slowest speed that is used, where it takes
    /// 0.4 % (and is 1e4 times what the mean over turns that are not whole leaves open), and at twice that.
    #[test]
    fn gravity_slows_a_rotor_as_the_law_says() {
        let p = Parameters { inductance: 0.0, ..Parameters::COIN };
        let inertia = p.effective_inertia();
        let free = Law {
            gain: p.gain / p.resistance / inertia,
            rate: 1.0 / p.mechanical_time(),
            drag: p.coulomb / inertia,
            late: 0.0,
            coast: 0.0,
            gravity: 0.0,
            damping: 1.0 / p.mechanical_time(),
        };
        let law = Law { gravity: p.weight() / inertia, ..free };
        for (volts, takes) in [(0.83, 0.003..0.006), (1.2, 0.000_05..0.001)] {
            let plan = Plan::choose(&p, 8000.0, &Wish { error: 0.0, posture: true, casing: true });
            let mut motor = Motor::<false>::new(&p, &plan, 8000.0).unwrap();
            motor.place(0.0, p.steady_speed(volts));
            motor.drive(Drive::Voltage(volts));
            let turned =
                |motor: &Motor<false>| std::f64::consts::TAU * motor.reading().turns + motor.reading().angle;
            (0..8000).for_each(|_| motor.step());
            let before = turned(&motor);
            (0..80_000).for_each(|_| motor.step());
            let mean = (turned(&motor) - before) / 10.0;
            let drive = vec![volts; 8000];
            let push = Push { samples: &drive, held: true, open: &[], period: 1.0 / 8000.0 };
            let settles = |law: &Law| {
                let spun = law.spin(&Run { samples: 0..8000, sense: 1.0, start: mean }, &push).unwrap();
                spun.speed[7999]
            };
            let [without, with] = [settles(&free), settles(&law)];
            assert!(mean > law.slowest() && takes.contains(&(without / mean - 1.0)), "{mean} {without}");
            assert!((without - with) / (without - mean) > 0.85, "{mean} {with} {without}");
            assert!((without - with) / (without - mean) < 1.15, "{mean} {with} {without}");
        }
    }

    /// Turns of a known recording, ahead by 0.2 rad, with a second harmonic of 5 % a quarter of a period off.
    #[test]
    fn a_window_reads_angle_arm_and_harmonic() {
        let law =
            Law { gain: 2000.0, rate: 20.0, drag: 500.0, late: 0.0, coast: 1.0, gravity: 0.0, damping: 0.0 };
        let volts = vec![3.0; 4000];
        let push = Push { samples: &volts, held: true, open: &[], period: 1e-4 };
        let spun = law.spin(&Run { samples: 0..4000, sense: 1.0, start: 100.0 }, &push).unwrap();
        // Without a harmonic, every window does, that of the fastest change first.
        let clean = |n: usize| {
            let angle = spun.angle[n] + 0.2;
            spun.speed[n].powi(2) * angle.sin() - spun.bend[n] * angle.cos()
        };
        let clean: Vec<f64> = (0..4000).map(clean).collect();
        for w in spun.windows(&clean) {
            assert!((w.ahead - 0.2).abs() < 1e-9 && (w.arm - 1.0).abs() < 1e-9, "{w:?}");
        }
        let x: Vec<f64> = (0..4000)
            .map(|n| {
                let (angle, w2) = (spun.angle[n] + 0.2, spun.speed[n].powi(2));
                1e-5 * (w2 * angle.sin() - spun.bend[n] * angle.cos()) + 5e-7 * w2 * (2.0 * angle).cos()
            })
            .collect();
        let windows = spun.windows(&x);
        assert!(windows.len() > 12, "{}", windows.len());
        for w in &windows[windows.len() - 8..] {
            assert!((w.ahead - 0.2).abs() < 2e-3 && (w.arm / 1e-5 - 1.0).abs() < 3e-3, "{w:?}");
            assert!(w.second[0].abs() < 2e-3 && (w.second[1] - 0.05).abs() < 2e-3, "{w:?}");
        }
    }
}
