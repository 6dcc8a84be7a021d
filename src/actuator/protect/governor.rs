//! The gain and the cap that keep a budget.

use super::store::{HASTE, Store};
use crate::actuator::elementary::exp;

/// Seconds over which the mean square wanted is taken at most, and its share of the store's time.
const LOOK: (f64, f64) = (0.025, 1.0 / 32.0);
/// Nothing is turned down further than this; the cap does what is left to do.
const LEAST: f64 = 1e-6;

/// How current follows volts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Flow {
    /// The budget is one of volts.
    Volts,
    /// Through these ohms.
    Ohms(f64),
    /// Through the winding, as warm as it is.
    Winding,
    /// As a model says, which has these ohms and passes no more on the whole than they alone.
    Model(f64),
}

/// Keeps a budget: its gain glides over each tick, its cap stands.
#[derive(Debug, Clone)]
pub(super) struct Governor {
    store: Store,
    flow: Flow,
    tick: f64,
    samples: f64,
    /// A² for each V² of this tick.
    admits: f64,
    /// Of this tick: squares wanted and let out, V², and of the current, A².
    wanted: f64,
    left: f64,
    current: f64,
    /// The last two for longer: how much current the drive of late makes.
    past: [f64; 2],
    /// Mean square wanted of late, V²; by how much it follows upwards and downwards each tick.
    need: f64,
    pace: [f64; 2],
    /// At the last tick, and the way of each sample to the next.
    gain: f64,
    step: f64,
    target: f64,
    cap: f64,
}

impl Governor {
    /// Nothing done yet; a tick of so many samples at a rate.
    pub fn new(store: Store, flow: Flow, samples: u32, rate: f64) -> Self {
        let tick = f64::from(samples) / rate;
        let time = store.time();
        let follow = |over: f64| 1.0 - exp(-tick / over);
        let pace = [follow(LOOK.0.min(LOOK.1 * time)), follow(time / HASTE)];
        let mut it = Self {
            store,
            flow,
            tick,
            samples: f64::from(samples),
            admits: 1.0,
            wanted: 0.0,
            left: 0.0,
            current: 0.0,
            past: [0.0; 2],
            need: 0.0,
            pace,
            gain: 1.0,
            step: 0.0,
            target: 1.0,
            cap: f64::INFINITY,
        };
        it.look();
        it
    }

    /// The gain at the k-th sample of the tick, from 1.
    #[inline(always)]
    pub fn gain(&self, k: u32) -> f64 {
        if self.step == 0.0 { self.gain } else { self.gain + self.step * f64::from(k) }
    }

    /// Whether it turns nothing down in this tick.
    #[inline(always)]
    pub fn is_idle(&self) -> bool {
        self.gain == 1.0 && self.step == 0.0
    }

    /// No magnitude above this may leave, volts.
    #[inline(always)]
    pub fn cap(&self) -> f64 {
        self.cap
    }

    /// Whether it needs a model's currents.
    pub fn wants_current(&self) -> bool {
        matches!(self.flow, Flow::Model(_))
    }

    /// Takes note of a sample: volts wanted, volts let out, amperes.
    #[inline(always)]
    pub fn note(&mut self, wanted: f64, left: f64, current: f64) {
        self.note_squares(wanted * wanted, left * left, current * current);
    }

    /// The same by their mean squares over the time of a sample.
    #[inline(always)]
    pub fn note_squares(&mut self, wanted: f64, left: f64, current: f64) {
        self.wanted += wanted;
        self.left += left;
        self.current += current;
    }

    /// Takes note of samples (volts for each unit of them) that all left as they came.
    #[inline]
    pub fn note_all(&mut self, samples: &[f32], volts: f64) {
        let (mut wanted, mut left) = (self.wanted, self.left);
        for &x in samples {
            let v = f64::from(x) * volts;
            wanted += v * v;
            left += v * v;
        }
        (self.wanted, self.left) = (wanted, left);
    }

    /// Kelvins above the air, or the mean square.
    pub fn level(&self) -> f64 {
        self.store.level()
    }

    /// Goes on where another was: as warm, or of the same mean square, from the next sample on at the gain that this takes. One of another kind changes
    /// nothing.
    pub fn fill_as(&mut self, other: &Self) {
        let alike =
            matches!((self.flow, other.flow), (Flow::Volts, Flow::Volts) | (Flow::Ohms(_), Flow::Ohms(_)));
        if alike || matches!(self.store, Store::Heat { .. }) {
            self.store.fill_as(&other.store);
            (self.need, self.past) = (other.need, other.past);
            (self.gain, self.target) = (other.gain, other.target);
            self.look();
        }
    }

    /// The mean square that may be driven for so many seconds from within a tick on, of which so many samples have passed: what brings the store
    /// to no more than [`Store::hard`] lets it, V².
    pub fn spare(&self, seconds: f64, passed: u32) -> f64 {
        let sample = self.tick / self.samples;
        let whole = f64::from(passed) * sample + seconds;
        // What has passed of the tick is not known to the store yet.
        (self.store.hard(whole) / self.admits * whole - self.left * sample).max(0.0) / seconds
    }

    /// No magnitude above this may leave in the rest of a tick of which so many samples have passed, whatever left in them, volts.
    pub fn rest(&self, passed: u32) -> f64 {
        let left = (self.cap * self.cap * self.samples - self.left).max(0.0);
        (left / (self.samples - f64::from(passed)).max(1.0)).sqrt().min(self.cap)
    }

    /// At the end of a tick.
    pub fn tick(&mut self) {
        let [wanted, left, current] = [self.wanted, self.left, self.current].map(|sum| sum / self.samples);
        (self.wanted, self.left, self.current) = (0.0, 0.0, 0.0);
        let current = if self.wants_current() { current } else { left * self.admits };
        self.store.step(current, self.tick);
        for (past, now) in self.past.iter_mut().zip([left, current]) {
            *past += self.pace[1] * (now - *past);
            // So that no number becomes so small that arithmetic slows down.
            *past = if *past > 1e-60 { *past } else { 0.0 };
        }
        self.need += self.pace[usize::from(wanted < self.need)] * (wanted - self.need);
        self.need = if self.need > 1e-60 { self.need } else { 0.0 };
        self.look();
    }

    /// The gain and the cap of the next tick.
    fn look(&mut self) {
        // What the drive makes, and what it can make at most.
        let (ohms, makes) = match self.flow {
            Flow::Volts => (1.0, None),
            Flow::Ohms(ohms) => (ohms, None),
            Flow::Winding => (self.store.resistance().unwrap_or(1.0), None),
            Flow::Model(ohms) => (ohms, (self.past[0] > 0.0).then(|| self.past[1] / self.past[0])),
        };
        self.admits = 1.0 / (ohms * ohms);
        let makes = makes.unwrap_or(self.admits).min(self.admits);
        let (soft, need) = (self.store.soft(), self.need * makes);
        // Samples that are rounded to single precision at the limit are not turned down.
        let target = if need > soft * (1.0 + 2e-6) { (soft / need).sqrt().max(LEAST) } else { 1.0 };
        self.gain = self.target;
        self.step = (target - self.gain) / self.samples;
        self.target = target;
        self.cap = self.store.hard(self.tick).sqrt() * ohms;
    }
}

#[cfg(test)]
mod tests;
