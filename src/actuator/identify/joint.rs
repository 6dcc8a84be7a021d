//! Winding and rotor fitted as one, to current and motion as one: L i′ = V − R i − k ω and J ω′ = k i − b ω − T_c, under the drive that is held.
//!
//! Each for itself, the winding needs the rotor's speed and the rotor the winding's current, and what is off in the one goes into the other.
//! Here nothing but the drive comes in: the angle at every whole turn of the recording, and the current at every sample, are compared with those
//! of one simulation. What is known of each is weighed by its noise, and angles are taken from the beginning of a run on, not from one to the next:
//! so a mean speed is as certain as both ends of it.

use super::least::{Fit, descend};
use super::reading::windows;
use super::rotor::{Rotor, Told};
use super::spin::{Law, Push, Run, Spun};
use super::winding::Winding;
use crate::actuator::exponential::{Square, exponential};

/// Samples that are simulated before those that are compared.
const BEFORE: usize = 12;
/// Rounds in which the noise is told from the fit, and the fit from the noise.
const ROUNDS: usize = 3;
/// How many times the noise of its windows the angle may be off, root mean square: else something is in it that the law does not have.
const ASTRAY: f64 = 3.0;

/// Samples of the current times parameters, at most: what is recorded beyond is not needed, and its derivatives would fill the memory.
const MOST: usize = 8_000_000;
/// How many times what both may be off it may differ from what was found before: else it is something else.
const FAR: f64 = 2.0;

/// What was fitted.
#[derive(Debug, Clone)]
pub(super) struct Joint {
    fit: Fit,
    period: f64,
}

/// The figures of a motor, and by how many samples both channels are behind the drive.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motor {
    pub resistance: f64,
    pub inductance: f64,
    pub gain: f64,
    pub inertia: f64,
    pub viscous: f64,
    pub dry: f64,
    late: [f64; 2],
}

/// A run as it was recorded.
struct Seen {
    run: Run,
    /// The samples of the drive over which it is simulated.
    begin: usize,
    end: usize,
    /// Samples, angles, and their noise.
    angles: Vec<(f64, f64, f64)>,
    /// Samples and currents, in the sense of the run.
    currents: Vec<(f64, f64)>,
}

/// What is simulated: currents, speeds, angles.
type Course = Vec<[f64; 3]>;

const FIGURES: usize = 8;
/// Of every run: the current, speed and angle with which it begins.
const OWN: usize = 3;

impl Motor {
    fn of(p: &[f64]) -> Self {
        Self {
            resistance: p[0],
            inductance: p[1],
            gain: p[2],
            inertia: p[3],
            viscous: p[4],
            dry: p[5],
            late: [p[6], p[7]],
        }
    }

    /// A step as numbers: what current, speed, volts and torque add to current, speed and angle.
    fn step(&self, period: f64) -> [[f64; 4]; 3] {
        let (r, l, k, j, b) = (self.resistance, self.inductance, self.gain, self.inertia, self.viscous);
        let mut a: Square = Square::default();
        a[0][..5].copy_from_slice(&[-r / l, -k / l, 0.0, 1.0 / l, 0.0]);
        a[1][..5].copy_from_slice(&[k / j, -b / j, 0.0, 0.0, 1.0 / j]);
        a[2][1] = 1.0;
        let e = exponential(&a, 5, period);
        std::array::from_fn(|n| [e[n][0], e[n][1], e[n][3], e[n][4]])
    }

    /// A run from `own` on; `None` where the figures cannot be.
    fn course(&self, seen: &Seen, own: &[f64], law: &Law, push: &Push) -> Option<Course> {
        let is_motor = [self.resistance, self.inductance, self.gain, self.inertia].iter().all(|x| *x > 0.0);
        if !(is_motor && self.late.iter().all(|late| late.is_finite())) {
            return None;
        }
        let (rows, slowest) = (self.step(push.period), law.slowest());
        let mut now = [own[0], own[1], own[2]];
        let mut all = Vec::with_capacity(seen.end - seen.begin + 1);
        all.push(now);
        for n in seen.begin..seen.end {
            let volts = seen.run.sense * push.samples[n.min(push.samples.len() - 1)];
            let sinks =
                law.gravity * law.gravity * law.damping * 0.5 / now[1].max(slowest).powi(3).max(1e-300);
            let input = [now[0], now[1], volts, -self.dry - self.inertia * sinks];
            let add = rows.map(|row| row.iter().zip(&input).map(|(a, b)| a * b).sum::<f64>());
            now = std::array::from_fn(|i| now[i] + add[i]);
            all.push(now);
        }
        Some(all)
    }
}

impl Seen {
    /// What lies at a place between samples of the drive: two samples and the part of the way.
    fn between<'a>(&self, course: &'a Course, at: f64) -> ([&'a [f64; 3]; 2], f64) {
        let place = (at - self.begin as f64).clamp(0.0, (course.len() - 2) as f64 + 0.999_999);
        let whole = place as usize;
        ([&course[whole], &course[whole + 1]], place - whole as f64)
    }

    fn angle(&self, course: &Course, at: f64, period: f64) -> f64 {
        let ([a, b], part) = self.between(course, at);
        a[2] + period * part * (a[1] + 0.5 * part * (b[1] - a[1]))
    }

    /// `leaves`: what of the current a sample leaves; and the same over the part.
    fn current(&self, course: &Course, at: f64, leaves: f64) -> f64 {
        let ([a, b], part) = self.between(course, at);
        let goes_to = (b[0] - leaves * a[0]) / (1.0 - leaves);
        goes_to + (a[0] - goes_to) * leaves.powf(part)
    }
}

impl Joint {
    /// From what was found of each; `None` where both do not go together.
    pub fn of(
        x: &[f64],
        current: &[f64],
        winding: &Winding,
        rotor: &Rotor,
        under: &Rotor,
        volts: &Push,
    ) -> Option<Self> {
        let period = volts.period;
        let ([k, off_k], [r, off_r]) = (winding.gain, winding.resistance);
        let first = Motor {
            resistance: r,
            inductance: r * winding.electrical_time()[1],
            gain: k,
            inertia: k / under.law.gain,
            viscous: k / under.law.gain * under.law.rate,
            dry: k / under.law.gain * under.law.drag,
            late: [under.law.late / period, winding.late[0] / period],
        };
        let law = rotor.law;
        let spun: Vec<Spun> = rotor.runs.iter().map(|run| law.spin(run, volts)).collect::<Option<_>>()?;
        let read = windows(&rotor.runs, &spun, x);
        let back = first.late[0].max(first.late[1]).ceil();
        let (mut seen, mut samples) = (Vec::new(), 0);
        for ((run, spun), windows) in rotor.runs.iter().zip(&spun).zip(&read) {
            let begin = run.samples.start as f64 - back - 1.0;
            let end = run.samples.end as f64 - first.late[0].min(first.late[1]).floor() + 1.0;
            if begin < 0.0 || windows.len() < 4 {
                continue;
            }
            samples += run.samples.len();
            if samples * (FIGURES + OWN * (seen.len() + 1)) > MOST {
                break;
            }
            let (begin, end) = (begin as usize, (end as usize).min(volts.samples.len()));
            if end < begin + 2 {
                continue;
            }
            let at = |n: usize| (run.samples.start + n) as f64;
            let angles = windows.iter().map(|w| (at(w.middle), spun.angle[w.middle] + w.ahead, w.noise));
            let currents = run.samples.clone().skip(BEFORE).filter(|n| *n < current.len());
            seen.push(Seen {
                begin,
                end,
                angles: angles.collect(),
                currents: currents.map(|n| (n as f64, run.sense * current[n])).collect(),
                run: run.clone(),
            });
        }
        if seen.is_empty() {
            return None;
        }
        let mut begin = vec![
            first.resistance,
            first.inductance,
            first.gain,
            first.inertia,
            first.viscous,
            first.dry,
            first.late[0],
            first.late[1],
        ];
        let mut steps: Vec<f64> = begin.iter().map(|x| 1e-6 * x.abs()).collect();
        steps[4] = steps[4].max(1e-6 * k * k / r);
        steps[5] = steps[5].max(1e-6 * k * volts.samples.iter().fold(0.0_f64, |m, u| m.max(u.abs())) / r);
        (steps[6], steps[7]) = (1e-4, 1e-4);
        for seen in &seen {
            let current = seen.currents.first()?.1;
            begin.extend([current, seen.run.start, 0.0]);
            steps.extend([1e-6 * current.abs().max(1e-3), 1e-6 * seen.run.start.max(1.0), 1e-6]);
        }
        let rest = |p: &[f64]| -> Option<[Vec<f64>; 2]> {
            let motor = Motor::of(p);
            let leaves = (-motor.resistance / motor.inductance * period).exp();
            let (mut turned, mut flowed) = (Vec::new(), Vec::new());
            for (n, seen) in seen.iter().enumerate() {
                let own = &p[FIGURES + OWN * n..][..OWN];
                let course = motor.course(seen, own, &law, volts)?;
                let angles = seen.angles.iter();
                turned.extend(angles.map(|(at, is, _)| seen.angle(&course, at - motor.late[0], period) - is));
                let currents = seen.currents.iter();
                flowed
                    .extend(currents.map(|(at, is)| seen.current(&course, at - motor.late[1], leaves) - is));
            }
            turned.iter().chain(&flowed).all(|x| x.is_finite()).then_some([turned, flowed])
        };
        // So that the angles begin where they are.
        let [turned, _] = rest(&begin)?;
        let mut from = 0;
        for (n, seen) in seen.iter().enumerate() {
            begin[FIGURES + OWN * n + 2] -= turned[from];
            from += seen.angles.len();
        }
        let noise: Vec<f64> =
            seen.iter().flat_map(|seen| seen.angles.iter().map(|(.., noise)| *noise)).collect();
        let square = |rest: &[f64]| rest.iter().map(|r| r * r).sum::<f64>() / rest.len() as f64;
        let [mut floor, mut scatter] = {
            let [turned, flowed] = rest(&begin)?;
            [square(&turned), square(&flowed)]
        };
        let mut found = None;
        for _ in 0..ROUNDS {
            let weigh = |[turned, flowed]: [Vec<f64>; 2]| -> Vec<f64> {
                let turned =
                    turned.iter().zip(&noise).map(|(r, noise)| r / (noise * noise + floor).sqrt().max(1e-9));
                turned.chain(flowed.iter().map(|r| r / scatter.sqrt().max(1e-30))).collect()
            };
            let fit = descend(&begin, &steps, |p| rest(p).map(weigh))?;
            let [turned, flowed] = rest(&fit.values)?;
            floor = (square(&turned) - square(&noise)).max(0.0);
            scatter = square(&flowed);
            begin.clone_from(&fit.values);
            found = Some(fit);
        }
        let fit = found?;
        let joint = Self { fit, period };
        let near =
            |(value, off): Told, [other, more]: [f64; 2]| (value - other).abs() < FAR * off.hypot(more);
        let goes = floor < ASTRAY * ASTRAY * square(&noise)
            && near(joint.told(|motor| motor.resistance), [r, off_r])
            && near(joint.told(|motor| motor.gain), [k, off_k]);
        goes.then_some(joint)
    }

    /// A figure, and how far off it may be.
    pub fn told(&self, figure: impl Fn(&Motor) -> f64) -> Told {
        let of = |p: &[f64]| figure(&Motor::of(p));
        (of(&self.fit.values), self.fit.off_of(of))
    }

    /// Seconds by which the current is behind the drive.
    pub fn late(&self) -> Told {
        let (late, off) = self.told(|motor| motor.late[1]);
        (late * self.period, off * self.period)
    }
}
