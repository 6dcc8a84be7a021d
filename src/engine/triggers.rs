//! Trigger outputs: pulses of full scale, or of the output's own level where that is lower, at markers.
//!
//! They leave at the device's rate, aligned with the vibration.

use super::vibration::{Vibration, single};
use crate::graph::plan::{OutputKind, Plan};
use crate::node::kernel::LEAD;
use crate::schedule::Instant;

/// Pulses on the trigger outputs.
#[derive(Debug)]
pub struct Triggers {
    outputs: Vec<Trigger>,
    channels: usize,
    ratio: usize,
    /// Device frames from an event to what it makes, at 250 Hz.
    late: f64,
}

#[derive(Debug)]
struct Trigger {
    channel: usize,
    /// How high its pulses are.
    height: f32,
    marker: Option<u32>,
    length: u64,
    /// The frames of the pulses to come and under way; one that overlaps the last makes it longer.
    pulses: [(u64, u64); WAITING],
    count: usize,
}

/// Pulses of one output that may wait at once: markers come to the engine a few milliseconds ahead.
const WAITING: usize = 64;

impl Triggers {
    /// Those of a plan.
    pub fn new(plan: &Plan, vibration: &Vibration) -> Self {
        let late = LEAD * plan.ratio as f64 + vibration.delay().frames(plan.device_rate);
        let outputs = plan
            .outputs
            .iter()
            .filter_map(|output| match output.kind {
                OutputKind::Trigger { marker, pulse } => Some(Trigger {
                    channel: output.channel as usize,
                    height: single(output.max_level),
                    marker,
                    length: ((pulse * plan.device_rate).round() as u64).max(1),
                    pulses: [(0, 0); WAITING],
                    count: 0,
                }),
                _ => None,
            })
            .collect();
        Self { outputs, channels: plan.channels, ratio: plan.ratio, late }
    }

    /// The channels on which pulses leave (from 0).
    pub fn channels(&self) -> impl Iterator<Item = usize> + '_ {
        self.outputs.iter().map(|output| output.channel)
    }

    /// Takes over the pulses to come and under way of old ones.
    pub fn take_over(&mut self, old: &mut Self) {
        for output in &mut self.outputs {
            if let Some(old) = old.outputs.iter_mut().find(|old| old.channel == output.channel) {
                (output.pulses, output.count) = (old.pulses, std::mem::take(&mut old.count));
            }
        }
    }

    /// Whether no pulse waits or is under way.
    pub fn is_idle(&self) -> bool {
        self.outputs.iter().all(|output| output.count == 0)
    }

    /// Lets no pulse be higher than these levels of the channels, one that is under way included.
    pub fn limit_to(&mut self, levels: &[f32]) {
        for output in &mut self.outputs {
            output.height = levels.get(output.channel).copied().unwrap_or(1.0);
        }
    }

    /// A marker at an instant: its pulse begins when vibration that began then is felt (by the group delay at 250 Hz), to the
    /// frame.
    pub fn mark(&mut self, marker: u32, at: Instant) {
        let frame =
            (at.sample as f64 + f64::from(at.fraction) / 4_294_967_296.0) * self.ratio as f64 + self.late;
        let begin = frame.round() as u64;
        for output in self.outputs.iter_mut().filter(|o| o.marker.is_none_or(|m| m == marker)) {
            let end = begin.saturating_add(output.length);
            match output.count.checked_sub(1).map(|last| &mut output.pulses[last]) {
                Some(last) if begin <= last.1 || output.count == WAITING => last.1 = last.1.max(end),
                _ => {
                    output.pulses[output.count] = (begin, end);
                    output.count += 1;
                }
            }
        }
    }

    /// Writes the pulses into the frames of `samples` engine samples from `clock` on; those of the last one lie in `rest`
    /// where `frames` has no room for it.
    pub fn write(&mut self, clock: u64, samples: usize, frames: &mut [f32], rest: &mut [f32]) {
        let whole = frames.len() / (self.ratio * self.channels).max(1) * self.ratio;
        let (first, count) = (clock.saturating_mul(self.ratio as u64), (samples * self.ratio) as u64);
        for output in &mut self.outputs {
            for &(begin, end) in &output.pulses[..output.count] {
                let from = begin.saturating_sub(first).min(count) as usize;
                let to = end.saturating_sub(first).min(count) as usize;
                let before = frames.chunks_exact_mut(self.channels).take(whole);
                let after = rest.chunks_exact_mut(self.channels);
                for frame in before.chain(after).take(to).skip(from) {
                    if let Some(value) = frame.get_mut(output.channel) {
                        *value = output.height;
                    }
                }
            }
            let over =
                output.pulses[..output.count].iter().take_while(|(_, end)| *end <= first + count).count();
            output.pulses.copy_within(over..output.count, 0);
            output.count -= over;
        }
    }
}
