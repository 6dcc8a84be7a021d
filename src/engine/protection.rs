//! What stands last before the device on each output whose actuator is known: nothing leaves that it does not bear.

use crate::actuator::fault::Fault;
use crate::actuator::protect::counts::Counts;
use crate::actuator::protect::kernel::Protection;
use crate::graph::plan::Plan;

use super::workspace::BLOCK;

/// The protections of a plan.
#[derive(Debug)]
pub struct Protections {
    lines: Vec<Line>,
    channels: usize,
    ratio: usize,
}

#[derive(Debug)]
struct Line {
    channel: usize,
    kernel: Protection,
    /// The frames of a block.
    frames: Vec<f32>,
}

impl Protections {
    /// Those of a plan.
    ///
    /// # Errors
    /// A figure of a bound that cannot be, with its channel (from 0).
    pub fn new(plan: &Plan) -> Result<Self, (u32, Fault)> {
        let line = |(channel, bounds): &(u32, _)| {
            let kernel = Protection::new(bounds, plan.device_rate).map_err(|fault| (*channel, fault))?;
            Ok(Line { channel: *channel as usize, kernel, frames: vec![0.0; BLOCK * plan.ratio] })
        };
        let there = plan.protections.iter().filter(|(channel, _)| (*channel as usize) < plan.channels);
        let lines = there.map(line).collect::<Result<_, _>>()?;
        Ok(Self { lines, channels: plan.channels, ratio: plan.ratio })
    }

    /// What was held back on a channel (from 0); `None` where nothing is known that would be.
    pub fn counts(&self, channel: usize) -> Option<Counts> {
        self.lines.iter().find(|line| line.channel == channel).map(|line| line.kernel.counts())
    }

    /// Takes over from old ones: what is on channels that are not among the `crossed` goes on as it was, the others are as warm.
    pub fn take_over(&mut self, old: &mut Self, crossed: &[usize]) {
        for line in &mut self.lines {
            let Some(old) = old.lines.iter_mut().find(|old| old.channel == line.channel) else { continue };
            match crossed.contains(&line.channel) {
                false => std::mem::swap(line, old),
                true => line.kernel.warm_as(&old.kernel),
            }
        }
    }

    /// The winding of what is on a channel (from 0), kelvins above the air, as of the last tick; `None` where its heat is not watched here.
    pub fn temperature(&self, channel: usize) -> Option<f64> {
        self.lines.iter().find(|line| line.channel == channel)?.kernel.temperature()
    }

    /// Samples that left other than they came, of all channels.
    pub fn changed(&self) -> u64 {
        self.lines.iter().map(|line| line.kernel.counts().changed).sum()
    }

    /// Holds back what is not borne in the frames of a block; those of its last engine sample lie in `rest` where `frames` has no room.
    pub fn hold(&mut self, samples: usize, frames: &mut [f32], rest: &mut [f32]) {
        if self.lines.is_empty() {
            return;
        }
        let ratio = self.ratio;
        let whole = frames.len() / (ratio * self.channels).max(1) * ratio;
        for line in &mut self.lines {
            let block = &mut line.frames[..samples * ratio];
            let before = frames.chunks_exact(self.channels).take(whole);
            for (own, frame) in block.iter_mut().zip(before.chain(rest.chunks_exact(self.channels))) {
                *own = frame[line.channel];
            }
            line.kernel.process(block);
            let before = frames.chunks_exact_mut(self.channels).take(whole);
            for (own, frame) in block.iter().zip(before.chain(rest.chunks_exact_mut(self.channels))) {
                frame[line.channel] = *own;
            }
        }
    }
}
