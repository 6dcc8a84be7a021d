//! Voices and patterns that signals set off: looks at every sample of what is watched, and keeps what is to begin until its time has come.

use super::core::GRID;
use super::event::Play;
use crate::graph::answer::{Answer, Started};
use crate::graph::plan::Plan;
use crate::graph::watch::{LATENCY, MOST_STARTS, Watch, id};
use crate::node::kernel::LEAD;
use crate::schedule::{Instant, Queue};

/// Samples that may be computed between two looks: what passes a threshold within them is seen before what it sets off must begin.
/// Signals lag behind events by [`LEAD`].
pub const STRETCH: u64 = LATENCY - LEAD as u64;

/// Onsets of one watch that may wait. A signal has to come back first, so it passes a threshold at every second sample at most.
const WAITING: usize = (LATENCY + STRETCH) as usize / 2 + 1;

/// What has been set off and nobody has asked for yet, at most.
const KEPT: usize = 4096;

/// A signal, or the knob, has set something off, by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// When that begins: a voice by itself, a pattern where whoever feeds the engine sees to it.
    pub at: Instant,
    /// What watched the signal, by its place in [`Plan::watches`]; those of the knob are counted on behind them.
    pub watch: u32,
    /// How often watches of that place had set something off before.
    pub number: u64,
    /// What.
    pub what: SetOff,
}

/// What was set off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SetOff {
    /// A voice.
    Voice(Play),
    /// A pattern.
    Pattern(Started),
}

impl Crossing {
    /// What a watch sets off that does so `at` an instant; a pattern begins `answer` samples after that.
    pub(super) fn new(at: Instant, (watch, number): (u32, u64), what: &Answer, answer: u64) -> Self {
        match what {
            Answer::Voice(voiced) => {
                let play = Play::of(voiced, id(watch as usize, number));
                Self { at, watch, number, what: SetOff::Voice(play) }
            }
            Answer::Pattern(started) => {
                let at = Instant { sample: at.sample.saturating_add(answer), ..at };
                Self { at, watch, number, what: SetOff::Pattern(*started) }
            }
        }
    }

    /// Its id: that of the voice.
    pub fn id(&self) -> u64 {
        id(self.watch as usize, self.number)
    }

    /// The voice, if it is one.
    pub fn play(&self) -> Option<&Play> {
        if let SetOff::Voice(play) = &self.what { Some(play) } else { None }
    }
}

/// What is known of one signal.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// The value before; not-a-number where that is not known.
    before: f64,
    /// The first sample that is looked at.
    from: u64,
    /// Whether it has come back since it set something off.
    armed: bool,
    /// No onset before this.
    free: Instant,
    /// How often it has set something off.
    number: u64,
}

impl Seen {
    /// Of a signal whose first value is that of sample `from`.
    fn new(from: u64) -> Self {
        Self { before: f64::NAN, from, armed: true, free: Instant::default(), number: 0 }
    }

    /// Looks at the value of a sample, turned so that it has to rise. Gives the onset of what it sets off.
    #[inline]
    fn look(&mut self, watch: &Rising, value: f64, sample: u64) -> Option<Instant> {
        if !value.is_finite() {
            self.before = f64::NAN;
            return None;
        }
        let before = std::mem::replace(&mut self.before, value);
        if value < watch.rearm {
            self.armed = true;
        }
        let (passed, stood) = (value >= watch.threshold, before >= watch.threshold);
        if !passed || stood {
            return None;
        }
        // It may have stood here for long, where nobody knows what was before.
        if !std::mem::replace(&mut self.armed, false) || before.is_nan() {
            return None;
        }
        // Halves, which no two numbers are too far apart for.
        let share = (0.5 * watch.threshold - 0.5 * before) / (0.5 * value - 0.5 * before);
        // Above 0 and at most 1, so that what two signals set off in one sample comes after all of the sample before.
        let share = if share.is_nan() { 1.0 } else { share };
        let fraction = ((share * 4_294_967_296.0).ceil() as u64).clamp(1, 1 << 32);
        let begins = sample + (STRETCH - 1);
        let at = Instant { sample: begins + (fraction >> 32), fraction: fraction as u32 };
        if at < self.free {
            return None;
        }
        self.free = at + watch.hold;
        Some(at)
    }
}

/// A watch, turned so that its signal has to rise.
#[derive(Debug)]
struct Rising {
    signal: usize,
    sign: f64,
    threshold: f64,
    rearm: f64,
    /// Samples.
    hold: f64,
    answer: Answer,
}

impl Rising {
    fn new(watch: &Watch, rate: f64) -> Self {
        let &Watch { signal, threshold, rises, rearm, hold, answer, .. } = watch;
        let sign = if rises { 1.0 } else { -1.0 };
        Self {
            signal: signal as usize,
            sign,
            threshold: sign * threshold,
            rearm: sign * rearm,
            hold: hold * rate,
            answer,
        }
    }
}

/// An onset that waits.
#[derive(Debug, Clone, Copy)]
struct Start {
    watch: u32,
    number: u64,
}

/// The watches of a plan at work.
#[derive(Debug)]
pub struct Watcher {
    watches: Vec<Rising>,
    seen: Vec<Seen>,
    waiting: Queue<Start>,
    /// Onsets from here on do not take place.
    until: Instant,
    /// Samples from the onset of a voice that is set off to the beginning of a pattern that is.
    answer: u64,
    /// The stretch of the grid in which something was set off last, and how much.
    stretch: (u64, u64),
    begun: Vec<Crossing>,
    /// What has begun and was not kept, for want of room.
    unkept: u64,
}

impl Watcher {
    /// Those of a plan that runs at `rate`.
    pub fn new(plan: &Plan, rate: f64) -> Self {
        let watches: Vec<Rising> = plan.watches.iter().map(|watch| Rising::new(watch, rate)).collect();
        let count = watches.len();
        let knob = plan.knob.as_ref().is_some_and(|knob| !knob.starts.is_empty());
        Self {
            // What was before the beginning is nothing.
            seen: vec![Seen::new(LEAD as u64); count],
            waiting: Queue::new(WAITING * count),
            until: Instant::NEVER,
            answer: plan.answer.saturating_sub(LATENCY),
            stretch: (0, 0),
            begun: Vec::with_capacity(if count > 0 || knob { KEPT } else { 0 }),
            unkept: 0,
            watches,
        }
    }

    /// Whether there is nothing to watch.
    pub fn is_idle(&self) -> bool {
        self.watches.is_empty()
    }

    /// Whether nothing waits to begin.
    pub fn is_empty(&self) -> bool {
        self.waiting.is_empty()
    }

    /// When the next voice begins.
    pub fn next(&self) -> Option<Instant> {
        self.waiting.first()
    }

    /// Nothing begins at this instant or later.
    pub fn end_at(&mut self, until: Instant) {
        self.until = until;
    }

    /// Looks at `frames` samples from `clock` on: `values` gives those of a signal, by its number. Gives how many onsets found no room,
    /// which there always is.
    pub fn look<V: Fn(usize) -> f64>(
        &mut self,
        clock: u64,
        frames: usize,
        values: impl Fn(usize) -> Option<V>,
    ) -> u64 {
        let mut dropped = 0;
        for (number, (watch, seen)) in self.watches.iter().zip(&mut self.seen).enumerate() {
            let Some(value) = values(watch.signal) else { continue };
            for frame in 0..frames {
                let sample = clock + frame as u64;
                if sample < seen.from {
                    continue;
                }
                let Some(at) = seen.look(watch, watch.sign * value(frame), sample) else { continue };
                if at < self.until {
                    let start = Start { watch: number as u32, number: seen.number };
                    seen.number += 1;
                    dropped += u64::from(self.waiting.push(at, 0, start).is_err());
                }
            }
        }
        dropped
    }

    /// What is set off before the next sample, if something is: when, and what; `None` for what is too much.
    pub fn begin(&mut self, clock: u64) -> Option<(Instant, Option<SetOff>)> {
        let entry = self.waiting.pop_due(clock)?;
        let Start { watch, number } = entry.what;
        let stretch = clock / GRID;
        if self.stretch.0 != stretch {
            self.stretch = (stretch, 0);
        }
        if self.stretch.1 >= MOST_STARTS {
            return Some((entry.at, None));
        }
        self.stretch.1 += 1;
        let Some(rising) = self.watches.get(watch as usize) else { return Some((entry.at, None)) };
        let crossing = Crossing::new(entry.at, (watch, number), &rising.answer, self.answer);
        self.keep(crossing);
        Some((entry.at, Some(crossing.what)))
    }

    /// Keeps what has been set off, until somebody asks.
    pub fn keep(&mut self, crossing: Crossing) {
        if self.begun.len() < self.begun.capacity() {
            self.begun.push(crossing);
        } else {
            self.unkept += 1;
        }
    }

    /// What has begun since this was asked last, in its order.
    pub fn begun(&mut self) -> std::vec::Drain<'_, Crossing> {
        self.begun.drain(..)
    }

    /// How much of what has begun since this was asked last was not kept.
    pub fn take_unkept(&mut self) -> u64 {
        std::mem::take(&mut self.unkept)
    }

    /// Goes on as `old`, before sample `clock`: `to` names for each old watch the one that goes on as it. `same`: whether the signals are
    /// those of before. Gives how many onsets are lost, since what was to begin is there no more.
    pub fn adopt(&mut self, old: &mut Self, to: &[Option<usize>], same: bool, clock: u64) -> u64 {
        let to = |old: usize| to.get(old).copied().flatten();
        let from = clock + LEAD as u64;
        // So that no id comes again.
        let number = old.seen.iter().map(|seen| seen.number).max().unwrap_or(0);
        for seen in &mut self.seen {
            *seen = Seen { number, ..Seen::new(from) };
        }
        for (place, known) in old.seen.iter().enumerate() {
            let Some(seen) = to(place).and_then(|place| self.seen.get_mut(place)) else { continue };
            *seen = Seen { number, ..*known };
            if !same {
                // What a signal that is another now does as it takes over sets nothing off.
                (seen.before, seen.from) = (f64::NAN, from);
            }
        }
        let mut lost = 0;
        while let Some(entry) = old.waiting.pop_due(u64::MAX) {
            let start =
                to(entry.what.watch as usize).map(|watch| Start { watch: watch as u32, ..entry.what });
            let kept = start.is_some_and(|start| self.waiting.push(entry.at, 0, start).is_ok());
            lost += u64::from(!kept);
        }
        (self.stretch, self.until, self.unkept) = (old.stretch, old.until, old.unkept);
        // What has begun is told of by those who know its plan.
        for crossing in old.begun.drain(..) {
            self.keep(crossing);
        }
        lost
    }
}

#[cfg(test)]
mod tests {
    use super::{Answer, Instant, Rising, STRETCH, Seen, Started, Watch};

    fn rising(threshold: f64, rearm: f64, hold: f64) -> Rising {
        let watch = Watch {
            name: "node.n rises 0".into(),
            signal: 0,
            threshold,
            rises: true,
            rearm,
            hold,
            answer: Answer::Pattern(Started::new(0, 1.0, 1.0)),
        };
        Rising::new(&watch, 8000.0)
    }

    /// Crossings in samples, by their place between samples, of values that begin with sample 100.
    fn crossings(watch: &Rising, values: &[f64]) -> Vec<f64> {
        let mut seen = Seen::new(100);
        let found =
            values.iter().enumerate().filter_map(|(n, value)| seen.look(watch, *value, 100 + n as u64));
        found.map(|at| at.since(Instant { sample: 100 + STRETCH, fraction: 0 })).collect()
    }

    #[test]
    fn a_line_between_two_samples_says_when() {
        let half = rising(0.5, 0.5, 0.0);
        assert_eq!(crossings(&half, &[0.0, 1.0, 0.4, 0.6, 0.5, 0.6]), [0.5, 2.5]);
        assert_eq!(crossings(&half, &[0.25, 0.5, 0.5, 0.25, 0.75]), [1.0, 3.5]);
        // On its way up it stands on the threshold: that is where it passes it, once.
        assert_eq!(crossings(&half, &[0.0, 0.5, 1.0, 0.5, 1.0]), [1.0]);
        // However steep, never at the sample before.
        let steep = crossings(&rising(0.0, 0.0, 0.0), &[-1e-300, 1e300]);
        assert!(steep[0] > 0.0 && steep[0] < 1e-9, "{steep:?}");
        assert_eq!(crossings(&rising(0.0, 0.0, 0.0), &[-1.7e308, 1.7e308]), [0.5]);
    }

    #[test]
    fn nothing_is_set_off_by_what_is_there_from_the_beginning_or_is_no_number() {
        let half = rising(0.5, 0.5, 0.0);
        assert_eq!(crossings(&half, &[0.9, 0.8, 0.9]), [] as [f64; 0]);
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(crossings(&half, &[0.0, bad, 0.9, 0.6]), [] as [f64; 0]);
            assert_eq!(crossings(&half, &[0.9, bad, 0.9, bad, bad]), [] as [f64; 0]);
            assert_eq!(crossings(&half, &[0.0, bad, 0.0, 1.0]), [2.5]);
        }
        for nothing in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert_eq!(crossings(&rising(nothing, nothing, 0.0), &[0.0, 1.0, -1.0, 1.0]), [] as [f64; 0]);
            assert_eq!(crossings(&rising(nothing, 0.5, 0.0), &[0.0, 1.0, -1.0, 1.0]), [] as [f64; 0]);
        }
    }

    #[test]
    fn it_has_to_come_back_first() {
        let values = [0.0, 1.0, 0.4, 1.0, 0.3, 0.1, 1.0];
        assert_eq!(crossings(&rising(0.5, 0.5, 0.0), &values).len(), 3);
        assert_eq!(crossings(&rising(0.5, 0.2, 0.0), &values).len(), 2);
        // What was there from the beginning has to come back as well.
        assert_eq!(crossings(&rising(0.5, 0.2, 0.0), &[0.9, 0.4, 0.9, 0.1, 0.9]).len(), 1);
    }

    #[test]
    fn it_holds_still_for_a_while() {
        // Three samples, to the fraction of one.
        let held = rising(0.5, 0.5, 3.0 / 8000.0);
        assert_eq!(crossings(&held, &[0.0, 1.0, 0.0, 1.0, 0.25, 0.75, 0.0, 1.0]), [0.5, 4.5]);
        // What comes too soon is over, and not put off.
        assert_eq!(crossings(&held, &[0.0, 1.0, 0.0, 1.0, 1.0, 1.0, 1.0]), [0.5]);
    }
}
