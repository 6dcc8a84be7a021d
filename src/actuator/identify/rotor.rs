//! The law of a rotor's speed, fitted to a recording of what it shakes.

use super::initial::{first, runs, switches};
use super::least::{Fit, descend};
use super::reading::{LEAST_WINDOWS, arm, fast, gravity, kept, ratio, windows};
use super::recording::{Mistake, Name};
use super::spin::{Law, Push, Run, Spun, Window};
use super::track::follow;

/// A figure, and how far off it may be.
pub(super) type Told = (f64, f64);

/// What was fitted.
#[derive(Debug, Clone)]
pub(super) struct Rotor {
    /// The law.
    pub law: Law,
    /// Where it was seen to turn.
    pub runs: Vec<Run>,
    /// The amplitude over √(ω⁴ + α²).
    pub arm: Told,
    /// γ = m_e g r / J, 1/s².
    pub gravity: Told,
    /// Of the acceleration, dB.
    pub signal_to_noise: f64,
    /// Whether the drive switched while it turned, so that lateness shows.
    pub switched: bool,
    /// Whether it turned at one drive only, so that drag and gain do not come apart: the drag is 0 then.
    pub single: bool,
    fit: Fit,
    /// The parameters with but half of what gravity takes: the rest of its series is less than that.
    other: Vec<f64>,
    free: Free,
}

/// What is fitted besides gain, rate and the speeds at which runs begin.
#[derive(Debug, Clone, Copy)]
struct Free {
    drag: bool,
    late: bool,
    coast: bool,
    /// Not fitted: whether volts drive it, by which gravity slows it.
    volts: bool,
}

/// Least signal to noise, dB.
const LEAST: f64 = 6.0;
/// Turns that must be seen, in stretches of at least so many halves.
const TURNS: usize = 8;
const KNOTS: usize = 8;
/// Rounds of reading the windows by the law, and fitting the law to them.
const ROUNDS: usize = 6;
/// Gravity counts where its ripple is so many times its uncertainty.
const SEEN: f64 = 1.0;
/// Time constants over which a run is followed back to rest.
const BACK: f64 = 4.0;

impl Rotor {
    /// Of a recorded acceleration.
    ///
    /// # Errors
    /// No vibration, or one that does not follow the drive; too few turns; too high a frequency.
    pub fn of(x: &[f64], push: &Push) -> Result<Self, Mistake> {
        let (mut stretches, best) = follow(x, 1.0 / push.period)?;
        let share = best.clamp(1e-3, 0.999);
        if stretches.is_empty() {
            let is = 10.0 * (share / (1.0 - share)).log10();
            return Err(Mistake::Noise(Name::Acceleration, is, LEAST));
        }
        let knots: usize = stretches.iter().map(|s| s.knots.len()).sum();
        let seen: f64 = stretches.iter().map(|s| s.samples() * push.period).sum();
        let short = |turns: usize| Mistake::Short(seen, seen * 2.0 * turns as f64 / knots as f64, "turning");
        // What is but a turn or two may be noise.
        stretches.retain(|s| s.knots.len() >= KNOTS);
        if stretches.iter().map(|s| s.knots.len()).sum::<usize>() < 2 * TURNS {
            return Err(short(TURNS));
        }
        let runs = runs(&stretches, push);
        let steady = push.is_steady(&runs);
        let law = first(&stretches, &runs, push, steady).ok_or(short(knots))?;
        let opens = |run: &Run| {
            push.open
                .iter()
                .any(|o| o.start < run.samples.end && o.end > run.samples.start && o.end > o.start)
        };
        let late = !steady && switches(&runs, push);
        let free = Free { drag: !steady, late, coast: runs.iter().any(opens), volts: true };
        let rotor = Self::rounds(x, push, law, runs, free).ok_or(short(knots))?;
        if rotor.signal_to_noise < LEAST {
            return Err(Mistake::Noise(Name::Acceleration, rotor.signal_to_noise, LEAST));
        }
        Ok(rotor)
    }

    /// The same runs under another drive: the current instead of the voltage.
    pub fn again(&self, x: &[f64], push: &Push, law: Law) -> Option<Self> {
        let free = Free { drag: true, late: switches(&self.runs, push), coast: false, volts: false };
        Self::rounds(x, push, law, self.runs.clone(), free)
    }

    fn rounds(x: &[f64], push: &Push, law: Law, runs: Vec<Run>, free: Free) -> Option<Self> {
        let (mut law, mut runs, mut found) = (law, runs, None);
        for round in 0..ROUNDS {
            let mut spun: Vec<Spun> = runs.iter().map(|run| law.spin(run, push)).collect::<Option<_>>()?;
            let mut read = windows(&runs, &spun, x);
            let gravity = gravity(&spun, &read);
            if round > 0 && free.volts {
                law.gravity = if gravity.0 > SEEN * gravity.1 { gravity.0 } else { 0.0 };
                law.damping = law.rate;
            }
            if round == 1 {
                runs = fast(&runs, &spun, law.slowest());
                spun = runs.iter().map(|run| law.spin(run, push)).collect::<Option<_>>()?;
                read = windows(&runs, &spun, x);
            }
            // What tells nothing must not be fitted.
            let keep: Vec<bool> = read.iter().map(|windows| windows.len() >= LEAST_WINDOWS).collect();
            kept(&mut runs, &keep);
            kept(&mut spun, &keep);
            kept(&mut read, &keep);
            let values = free.values(&law, &runs);
            let fit = fit(&law, &runs, &spun, &read, push, free, &values)?;
            if round + 1 == ROUNDS {
                let half = Law { gravity: law.gravity * 0.5f64.sqrt(), ..law };
                let other = if law.gravity > 0.0 {
                    self::fit(&half, &runs, &spun, &read, push, free, &fit.values)?.values
                } else {
                    fit.values.clone()
                };
                found = Some((other, gravity, arm(&read)?, ratio(&read), fit.clone()));
            }
            law = free.law(&law, &fit.values);
            for (run, start) in runs.iter_mut().zip(free.starts(&fit.values)) {
                run.start = *start;
            }
        }
        let (other, gravity, arm, signal_to_noise, fit) = found?;
        let (switched, single) = (free.late, !free.drag);
        Some(Self { law, runs, arm, gravity, signal_to_noise, switched, single, fit, other, free })
    }

    /// A figure of the law, and how far off it may be: by the fit, and by what gravity does that the law does not.
    pub fn told(&self, figure: impl Fn(&Law) -> f64) -> Told {
        let of = |values: &[f64]| figure(&self.free.law(&self.law, values));
        let value = of(&self.fit.values);
        (value, self.fit.off_of(of) + (of(&self.other) - value).abs())
    }

    /// By how much the recording lags the drive, s. Where the drive did not switch while it turned, that can only be seen from when it left
    /// rest, which is as uncertain as the help of gravity in its first turn.
    pub fn late(&self, push: &Push) -> Told {
        if self.switched {
            return self.told(|law| law.late);
        }
        let behind = self.runs.iter().filter_map(|run| {
            let at = self.begins(run, push)?;
            let step = (1..=at).rev().find(|n| push.samples[*n] != push.samples[n - 1])?;
            let pull = (self.law.gain * run.sense * push.samples[at] - self.law.drag).abs();
            let first = (2.0 * std::f64::consts::TAU / pull).sqrt();
            Some(((at - step) as f64 * push.period, self.gravity.0 / pull * first))
        });
        behind.min_by(|a, b| (a.0 + a.1).total_cmp(&(b.0 + b.1))).unwrap_or((0.0, 0.0))
    }

    /// The sample at which a run left rest, by the law; `None` where it did not begin there.
    pub fn begins(&self, run: &Run, push: &Push) -> Option<usize> {
        let decay = (-self.law.rate * push.period).exp();
        let share = (1.0 - decay) / self.law.rate;
        let mut speed = run.start;
        // Backward, errors grow with the time constant.
        let span = (BACK / (self.law.rate * push.period)) as usize;
        for n in (run.samples.start.saturating_sub(span)..run.samples.start).rev() {
            let pull = self.law.gain * run.sense * push.mean(n, self.law.late)? - self.law.drag;
            speed = (speed - share * pull) / decay;
            if speed <= 0.0 {
                return Some(n);
            }
            if pull <= 0.0 || speed >= 1e9 || speed.is_nan() {
                return None;
            }
        }
        None
    }

    /// Every run with the speed at each of its samples, rad/s, as it was when the drive was recorded.
    pub fn speeds(&self, push: &Push) -> Vec<(Run, Vec<f64>)> {
        let shift = self.law.late / push.period;
        let all = self.runs.iter().filter_map(|run| {
            let spun = self.law.spin(run, push)?;
            // The samples of the drive that lie within, and the speed between two of the recording.
            let [begin, end] = [run.samples.start as f64 - shift, (run.samples.end - 1) as f64 - shift];
            let first = (begin.ceil().max(0.0) as usize).min(push.samples.len());
            let last = ((end.floor() + 1.0).max(0.0) as usize).clamp(first, push.samples.len());
            let at = |n: usize| {
                let place = (n as f64 - begin).clamp(0.0, (spun.speed.len() - 1) as f64);
                let (whole, part) = (place as usize, place.fract());
                let next = spun.speed.get(whole + 1).unwrap_or(&spun.speed[whole]);
                (1.0 - part) * spun.speed[whole] + part * next
            };
            let speed: Vec<f64> = (first..last).map(at).collect();
            (!speed.is_empty()).then(|| (Run { samples: first..last, start: speed[0], ..run.clone() }, speed))
        });
        all.collect()
    }
}

impl Free {
    fn values(self, law: &Law, runs: &[Run]) -> Vec<f64> {
        let mut values = vec![law.gain, law.rate];
        let others = [(self.drag, law.drag), (self.late, law.late), (self.coast, law.coast)];
        values.extend(others.iter().filter(|(free, _)| *free).map(|(_, value)| *value));
        values.extend(runs.iter().map(|run| run.start));
        values
    }

    fn law(self, from: &Law, values: &[f64]) -> Law {
        let mut law = Law { gain: values[0], rate: values[1], ..*from };
        let fields = [(self.drag, &mut law.drag), (self.late, &mut law.late), (self.coast, &mut law.coast)];
        for ((_, field), value) in fields.into_iter().filter(|(free, _)| *free).zip(&values[2..]) {
            *field = *value;
        }
        law
    }

    fn starts(self, values: &[f64]) -> &[f64] {
        &values[2 + usize::from(self.drag) + usize::from(self.late) + usize::from(self.coast)..]
    }
}

/// Fits the law to how far the angle goes from window to window. What noise does to each is known; what else there is counts as equal for all.
fn fit(
    law: &Law,
    runs: &[Run],
    spun: &[Spun],
    read: &[Vec<Window>],
    push: &Push,
    free: Free,
    start: &[f64],
) -> Option<Fit> {
    // Run, two samples, how far it went between, variance.
    let mut pairs = Vec::new();
    for (n, (windows, spun)) in read.iter().zip(spun).enumerate() {
        for pair in windows.windows(2) {
            let angle = |w: &Window| spun.angle[w.middle] + w.ahead;
            let noise = pair.iter().map(|w| w.noise * w.noise).sum::<f64>();
            pairs.push((n, [pair[0].middle, pair[1].middle], angle(&pair[1]) - angle(&pair[0]), noise));
        }
    }
    let went = |values: &[f64]| -> Option<Vec<f64>> {
        let law = free.law(law, values);
        let spun = runs
            .iter()
            .zip(free.starts(values))
            .map(|(run, start)| law.spin(&Run { start: *start, ..run.clone() }, push));
        let spun = spun.collect::<Option<Vec<Spun>>>()?;
        Some(
            pairs.iter().map(|(n, [a, b], went, _)| spun[*n].angle[*b] - spun[*n].angle[*a] - went).collect(),
        )
    };
    let top = push.samples.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    // Where nothing slows it but dry friction, its rate is as good as none.
    let least = 1.0 / (push.period * push.samples.len() as f64);
    let (force, rate) = (law.gain.abs() * top, law.rate.abs().max(least));
    let mut steps = vec![1e-6 * law.gain.abs(), 1e-6 * rate];
    let others = [(free.drag, 1e-6 * force), (free.late, 1e-3 * push.period), (free.coast, 1e-4 * rate)];
    steps.extend(others.iter().filter(|(free, _)| *free).map(|(_, step)| *step));
    steps.extend(runs.iter().map(|run| 1e-6 * run.start.abs().max(1.0)));
    let (mut start, mut found, mut floor) = (start.to_vec(), None, 0.0);
    for _ in 0..2 {
        let weigh = |rest: Vec<f64>| -> Vec<f64> {
            rest.iter().zip(&pairs).map(|(r, (.., noise))| r / (noise + floor).sqrt().max(1e-9)).collect()
        };
        let fit = descend(&start, &steps, |values| went(values).map(weigh))?;
        let rest = went(&fit.values)?;
        let (mut more, mut weights) = (0.0, 0.0);
        for (r, (.., noise)) in rest.iter().zip(&pairs) {
            let weight = 1.0 / (noise * noise).max(1e-18);
            (more, weights) = (more + weight * (r * r - noise), weights + weight);
        }
        floor = (more / weights).max(0.0);
        start.clone_from(&fit.values);
        found = Some(fit);
    }
    found
}
