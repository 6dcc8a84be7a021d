//! What tactors get of a voice that moves, by the definition: the law where it is, many times in every fine sample.

use std::collections::BTreeMap;

use crate::engine::event::Play;
use crate::graph::plan::{Instrument, Plan};
use crate::space::moving::LATE;
use crate::space::point::Point;
use crate::space::spot::Spot;

/// Places looked at within a fine sample. At 16 times the engine's rate these are half a million a second, and what the corners of √w fold
/// back from there is 110 dB down at 50 m/s over 5 cm.
const PLACES: usize = 4;

/// The way of a voice.
pub(super) struct Way<'a> {
    /// The plan.
    pub plan: &'a Plan,
    /// Its instrument.
    pub instrument: &'a Instrument,
    /// Its event.
    pub play: &'a Play,
    /// Its onset, in fine samples.
    pub born: f64,
    /// What its program says of where it is, fine sample by fine sample; empty where it says nothing.
    pub steps: &'a [[f64; 4]],
}

impl Way<'_> {
    /// By channel, what it gets of a voice's samples, whose first has number `first`, at `fine` samples a second.
    pub fn moved(&self, first: i64, fine: f64, samples: &[f64]) -> BTreeMap<u32, Vec<f64>> {
        let mut channels = BTreeMap::new();
        let Some(mut spread) = self.plan.spread.clone() else { return channels };
        let late = (LATE as f64 * fine * self.plan.ratio as f64 / self.plan.device_rate).round() as usize;
        let mut gains = Vec::with_capacity(spread.channels().len());
        for (n, sample) in samples.iter().enumerate().filter(|(_, sample)| **sample != 0.0) {
            for k in 0..PLACES {
                let off = (k as f64 + 0.5) / PLACES as f64 - 0.5;
                let seconds = (first as f64 + n as f64 + off - self.born) / fine;
                let (point, wider) = self.at([n, n.saturating_sub(late)], off, seconds);
                gains.clear();
                let width = (self.instrument.width + wider).max(0.0);
                spread.gains(point, width, self.instrument.law, &mut gains);
                for (channel, gain) in &gains {
                    let gain = self.needs(*channel, *gain);
                    let own = channels.entry(*channel).or_insert_with(|| vec![0.0; samples.len()]);
                    own[n] += sample * gain / PLACES as f64;
                }
            }
        }
        channels
    }

    /// The gain of a channel, or what that needs for a voice that says how strongly it is felt.
    fn needs(&self, channel: u32, gain: f64) -> f64 {
        let Some(felt) = self.play.felt else { return gain };
        let frequency = self.play.own.first().copied().unwrap_or_default();
        let hertz = self.instrument.pitch.hertz(frequency).unwrap_or(frequency);
        let gauge = self.plan.gauges.get(channel as usize).and_then(Option::as_ref);
        gauge.map_or(0.0, |gauge| gauge.gain(gain, self.play.level, felt, hertz))
    }

    /// Where it is, and how much wider, `off` from a fine sample, so many seconds after its onset: where it was told to be at an earlier one.
    fn at(&self, [now, told]: [usize; 2], off: f64, seconds: f64) -> (Point, f64) {
        let from = match self.play.place {
            Spot::Point(point) => point,
            Spot::Path(path) => match self.plan.paths.get(path as usize) {
                Some(route) => route.at(seconds, self.play.duration),
                None => [0.0; 3],
            },
            Spot::Row(_) => [0.0; 3],
        };
        let step = |n: usize, axis: usize| {
            let beside = if off < 0.0 { n.saturating_sub(1) } else { n + 1 };
            let here = self.steps.get(n)?;
            let there = self.steps.get(beside).unwrap_or(here);
            Some(here[axis] + off.abs() * (there[axis] - here[axis]))
        };
        let Some(wider) = step(now, 3) else { return (from, 0.0) };
        ([0, 1, 2].map(|axis| from[axis] + step(told, axis).unwrap_or(0.0)), wider)
    }
}
