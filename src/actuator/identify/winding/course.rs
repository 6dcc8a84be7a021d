//! What a winding does sample by sample under a drive that is held, and behind it by any part of a sample.

use super::super::spin::{Push, Run};

/// One sample to the next: where the drive is, the sense of the run, its speed in the mean, and the currents at both ends in that sense.
struct Step {
    at: usize,
    sense: f64,
    speed: f64,
    ends: [f64; 2],
}

/// The figures of a winding.
#[derive(Debug, Clone, Copy)]
pub(super) struct Figures {
    /// 1/R, 1/ohm.
    pub conductance: f64,
    /// k/R.
    pub gain: f64,
    /// e^(−R T/L).
    pub leaves: f64,
    /// Samples by which the current is behind the drive.
    pub late: f64,
}

/// All samples over which the law of a winding holds.
pub(super) struct Course<'a> {
    steps: Vec<Step>,
    /// Steps at which the current is taken as it was recorded.
    begins: Vec<usize>,
    push: &'a Push<'a>,
}

impl Figures {
    /// The current behind a sample that began with `current`, in the sense of the run: exact for a drive that jumps within it.
    pub fn next(&self, current: f64, sense: f64, speed: f64, volts: &[f64], at: usize) -> f64 {
        let [before, now, part] = self.drives(sense, volts, at);
        let behind = if self.leaves > 0.0 { self.leaves.powf(1.0 - part) } else { 0.0 };
        let pull = self.conductance * ((behind - self.leaves) * before + (1.0 - behind) * now);
        self.leaves * current + pull - (1.0 - self.leaves) * self.gain * speed
    }

    /// Its mean over that sample: what voltage and speed leave to the inductance is as the current's growth.
    pub fn mean(&self, [current, next]: [f64; 2], sense: f64, speed: f64, volts: &[f64], at: usize) -> f64 {
        let [before, now, part] = self.drives(sense, volts, at);
        let grows = if self.leaves > 0.0 { (next - current) / self.leaves.ln() } else { 0.0 };
        self.conductance * (part * before + (1.0 - part) * now) - self.gain * speed + grows
    }

    /// The voltage with which a sample begins, that with which it ends, and the part of it for which the first lasts.
    fn drives(&self, sense: f64, volts: &[f64], at: usize) -> [f64; 3] {
        let whole = self.late.floor();
        // The cast saturates.
        let drive = |back: isize| {
            let n = (at as isize).saturating_sub(whole as isize).saturating_sub(back);
            sense * volts[n.clamp(0, volts.len() as isize - 1) as usize]
        };
        [drive(1), drive(0), self.late - whole]
    }
}

/// The speed in the mean over the sample that begins at `at` of a run.
pub(super) fn mean(speed: &[f64], at: usize) -> f64 {
    0.5 * (speed[at] + speed.get(at + 1).copied().unwrap_or(speed[at]))
}

impl<'a> Course<'a> {
    pub fn of(current: &[f64], runs: &[(Run, Vec<f64>)], push: &'a Push<'a>) -> Self {
        let is_open = |n: usize| push.open.iter().any(|range| range.contains(&n));
        let (mut steps, mut begins) = (Vec::new(), Vec::new());
        for (run, speed) in runs {
            begins.push(steps.len());
            for n in run.samples.start..run.samples.end.min(current.len() - 1) {
                if is_open(n) {
                    begins.push(steps.len());
                    continue;
                }
                let (sense, at) = (run.sense, n - run.samples.start);
                let ends = [current[n], current[n + 1]].map(|i| sense * i);
                steps.push(Step { at: n, sense, speed: mean(speed, at), ends });
            }
        }
        Self { steps, begins, push }
    }

    /// How many samples.
    pub fn len(&self) -> usize {
        self.steps.len()
    }

    /// The rows of V/R − k ω/R = i, so many samples late, with what each should be.
    pub fn rows(&self, late: isize) -> impl Iterator<Item = (Vec<f64>, f64)> {
        let volts = self.push.samples;
        self.steps.iter().map(move |step| {
            let n = (step.at as isize - late).clamp(0, volts.len() as isize - 1) as usize;
            (vec![step.sense * volts[n], -step.speed], 0.5 * (step.ends[0] + step.ends[1]))
        })
    }

    /// The mean square of the current.
    pub fn square(&self) -> f64 {
        self.steps.iter().map(|step| step.ends[1] * step.ends[1]).sum::<f64>() / self.steps.len() as f64
    }

    /// By how much the law's current is off at the end of each sample; `None` where the figures cannot be.
    pub fn rest(&self, figures: &Figures) -> Option<Vec<f64>> {
        if !(0.0..1.0).contains(&figures.leaves) || !figures.late.is_finite() {
            return None;
        }
        let (mut current, mut begins) = (0.0, self.begins.iter().peekable());
        let mut rest = Vec::with_capacity(self.steps.len() + 1);
        for (n, step) in self.steps.iter().enumerate() {
            while begins.next_if(|begin| **begin <= n).is_some() {
                current = step.ends[0];
            }
            current = figures.next(current, step.sense, step.speed, self.push.samples, step.at);
            rest.push(current - step.ends[1]);
        }
        Some(rest)
    }
}
