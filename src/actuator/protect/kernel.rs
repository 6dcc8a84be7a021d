//! A block of samples, kept to the bounds in place.

use super::bounds::Bounds;
use super::counts::Counts;
use super::governor::Governor;
use super::motion::Motion;

mod setup;

pub use setup::RATES;
pub(super) use setup::tick_of;

/// Corner of the mean that is taken off where steady voltages are bounded, Hz: a steady voltage is down to 1/e of what it is too much by
/// after 0.16 s.
pub const CORNER: f64 = 1.0;
/// With a budget, samples beyond so many times full scale are held there.
const OVER: f64 = 16.0;
/// Keeps one output to its [`Bounds`]. What it makes of a run does not depend on how that is cut into blocks.
///
/// A block neither allocates nor locks; its time is bounded for each sample.
#[derive(Debug, Clone)]
pub struct Protection {
    bounds: Bounds,
    rate: f64,
    counts: Counts,
    /// Volts for a sample of 1; 1 where they are not known.
    volts: f64,
    /// Volts; between which volts; volts a sample.
    peak: f64,
    range: [f64; 2],
    slew: f64,
    alternating: Option<Filtered>,
    heat: Option<Governor>,
    rms: Option<Governor>,
    steady: Option<Steady>,
    motion: Option<Motion>,
    /// What left last.
    last: f64,
    /// Samples of a tick, and those left of this one.
    tick: u32,
    left: u32,
    /// Whether samples may pass in this tick that are no larger than this, without a closer look.
    plain: bool,
    pass: f32,
    /// Whether silence changes nothing.
    still: bool,
}

/// What alternates: the mean, by how much it follows each sample, and the budget of the rest.
#[derive(Debug, Clone)]
struct Filtered {
    mean: f64,
    pull: f64,
    governor: Governor,
}

/// A steady voltage: what of the mean is borne, the mean, and by how much it follows each sample.
#[derive(Debug, Clone)]
struct Steady {
    most: f64,
    mean: f64,
    pull: f64,
}

impl Protection {
    /// What it did so far.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// The winding, kelvins above the air, as of the last tick; `None` without a heat bound.
    pub fn temperature(&self) -> Option<f64> {
        self.heat.as_ref().map(Governor::level)
    }

    /// The gain that the budgets hold, as of the last tick: 1 where they do nothing.
    pub fn gain(&self) -> f64 {
        [&self.heat, &self.rms].into_iter().flatten().fold(1.0, |gain, budget| gain.min(budget.gain(0)))
    }

    /// Goes on where another was, of an output that was there before: as warm, from what left there last, and counts on.
    pub fn warm_as(&mut self, other: &Self) {
        self.counts = other.counts;
        self.last = other.last / other.volts * self.volts;
        for (own, other) in [(&mut self.heat, &other.heat), (&mut self.rms, &other.rms)] {
            if let (Some(own), Some(other)) = (own, other) {
                own.fill_as(other);
            }
        }
        self.begin();
    }

    /// Keeps samples to the bounds.
    pub fn process(&mut self, samples: &mut [f32]) {
        let mut rest = samples;
        while !rest.is_empty() {
            let (now, later) = rest.split_at_mut(rest.len().min(self.left as usize));
            self.part(now);
            self.left -= now.len() as u32;
            if self.left == 0 {
                self.end();
            }
            rest = later;
        }
    }

    /// Samples of one tick.
    fn part(&mut self, samples: &mut [f32]) {
        self.counts.samples += samples.len() as u64;
        if self.plain && self.passes(samples) {
            for budget in [&mut self.heat, &mut self.rms].into_iter().flatten() {
                budget.note_all(samples, self.volts);
            }
            self.last = samples.last().map_or(self.last, |&x| f64::from(x) * self.volts);
            return;
        }
        self.still &= samples.iter().all(|x| *x == 0.0);
        if self.still {
            return;
        }
        let first = self.tick - self.left + 1;
        for (k, sample) in (first..).zip(samples) {
            *sample = self.keep(*sample, k);
        }
    }

    /// Whether all may leave as they are.
    fn passes(&self, samples: &[f32]) -> bool {
        let quiet = samples.iter().fold(true, |quiet, x| quiet & (x.abs() <= self.pass));
        if !quiet || self.slew == f64::INFINITY {
            return quiet;
        }
        let (volts, slew) = (self.volts, self.slew);
        let steep = |x: f64, y: f64| (y * volts - x * volts).abs() > slew;
        let Some(first) = samples.first() else { return true };
        let begin = (f64::from(*first) * volts - self.last).abs() > slew;
        let pairs = samples.iter().zip(&samples[1..]);
        !pairs.fold(begin, |all, (x, y)| all | steep(f64::from(*x), f64::from(*y)))
    }

    /// The k-th sample of a tick, from 1.
    #[inline]
    fn keep(&mut self, came: f32, k: u32) -> f32 {
        let (counts, volts, last) = (&mut self.counts, self.volts, self.last);
        let input = f64::from(came) * volts;
        let mut v = input;
        if !came.is_finite() {
            counts.masked += 1;
            v = 0.0;
        }
        let remembers =
            self.heat.is_some() || self.rms.is_some() || self.alternating.is_some() || self.steady.is_some();
        if remembers && v.abs() > OVER * volts {
            counts.held += 1;
            v = v.clamp(-OVER * volts, OVER * volts);
        }
        if let Some(a) = &mut self.alternating {
            a.mean += a.pull * (v - a.mean);
            let (fast, gain) = (v - a.mean, a.governor.gain(k));
            let after = if gain == 1.0 { v } else { a.mean + gain * fast };
            a.governor.note(fast, gain * fast, 0.0);
            counts.alternating.enter(v, after);
            v = after;
        }
        let heat = self.heat.as_ref().map_or(1.0, |budget| budget.gain(k));
        let rms = self.rms.as_ref().map_or(1.0, |budget| budget.gain(k));
        let gain = heat.min(rms);
        let mut by = [false; 2];
        if gain != 1.0 {
            let after = v * gain;
            by = [heat <= rms && after != v, heat > rms && after != v];
            let which = if by[0] { &mut counts.heat } else { &mut counts.rms };
            which.enter(v, after);
            v = after;
        }
        let mut off = 0.0;
        if let Some(steady) = &self.steady {
            off = steady.mean - steady.mean.clamp(-steady.most, steady.most);
            counts.steady.enter(v, v - off);
            v -= off;
        }
        let wanted = if gain == 1.0 { v } else { v / gain };
        let hold = |v: f64, most: f64| v.max(-most).min(most);
        let [low, high] = self.range;
        counts.peak.enter(v, v.max(low).min(high));
        v = v.max(low).min(high);
        if let Some(budget) = &self.heat {
            counts.heat.enter_more(by[0], v, hold(v, budget.cap()));
            v = hold(v, budget.cap());
        }
        if let Some(budget) = &self.rms {
            counts.rms.enter_more(by[1], v, hold(v, budget.cap()));
            v = hold(v, budget.cap());
        }
        if (v - last).abs() > self.slew {
            let after = if v > last { last + self.slew } else { last - self.slew };
            counts.slew.enter(v, after);
            v = after;
        }
        let (range, slew) = (self.range, self.slew);
        let round = |v: f64| if v == input { (came, v) } else { rounded(v, volts, last, range, slew) };
        let (sample, left);
        let mut current = 0.0;
        if let Some(motion) = &mut self.motion {
            let chosen;
            (sample, left, chosen) = motion.step(last, v, round);
            current = motion.amperes();
            if self.bounds.stroke.is_some() {
                counts.stroke.enter(v, chosen);
                counts.farthest = counts.farthest.max(motion.displacement().abs());
            }
        } else {
            (sample, left) = round(v);
        }
        if let Some(steady) = &mut self.steady {
            steady.mean += steady.pull * (left + off - steady.mean);
        }
        for budget in [&mut self.heat, &mut self.rms].into_iter().flatten() {
            budget.note(wanted, left, current);
        }
        counts.changed += u64::from(sample.to_bits() != came.to_bits());
        self.last = left;
        sample
    }

    /// Ends a tick.
    fn end(&mut self) {
        for budget in [&mut self.heat, &mut self.rms].into_iter().flatten() {
            budget.tick();
        }
        if let Some(a) = &mut self.alternating {
            a.governor.tick();
            a.mean = settled(a.mean);
        }
        if let Some(steady) = &mut self.steady {
            steady.mean = settled(steady.mean);
        }
        if let Some(motion) = &mut self.motion {
            motion.settle();
        }
        if let Some(heat) = &self.heat {
            self.counts.warmest = self.counts.warmest.max(heat.level());
        }
        self.begin();
    }

    /// Begins a tick.
    fn begin(&mut self) {
        self.left = self.tick;
        let budgets = [&self.heat, &self.rms];
        let mut idle = self.motion.is_none() && self.steady.is_none() && self.alternating.is_none();
        let mut most = self.range[1].min(-self.range[0]);
        for budget in budgets.into_iter().flatten() {
            idle &= budget.is_idle();
            most = most.min(budget.cap()).min(OVER * self.volts);
        }
        let means =
            self.alternating.as_ref().map_or(0.0, |a| a.mean) + self.steady.as_ref().map_or(0.0, |s| s.mean);
        self.still = self.last == 0.0 && means == 0.0 && self.motion.as_ref().is_none_or(Motion::is_still);
        self.plain = idle;
        self.pass = below(most, self.volts);
    }
}

fn settled(x: f64) -> f64 {
    if x.abs() < 1e-30 { 0.0 } else { x }
}

/// The largest finite sample that makes no more than so many volts, or the one next to it.
fn below(most: f64, volts: f64) -> f32 {
    let near = (most / volts).min(f64::from(f32::MAX)) as f32;
    if f64::from(near) * volts > most { near.next_down() } else { near }
}

/// The sample for a voltage, and the voltage that it makes: where rounding would break range or slew, the next one inside.
#[inline(always)]
fn rounded(v: f64, volts: f64, last: f64, [low, high]: [f64; 2], slew: f64) -> (f32, f64) {
    let mut sample = (v / volts) as f32;
    let made = |sample: f32| f64::from(sample) * volts;
    if made(sample) > high || made(sample) < low {
        sample = if sample > 0.0 { sample.next_down() } else { sample.next_up() };
    }
    if (made(sample) - last).abs() > slew {
        sample = if made(sample) > last { sample.next_down() } else { sample.next_up() };
    }
    (sample, made(sample))
}

#[cfg(test)]
mod tests;
