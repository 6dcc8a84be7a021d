//! From the mix to the device: the output stage of each kind of output.

use std::ops::Range;

use super::vibration::{Counts, Options, Refusal, Row, Vibration};
use crate::dsp::isa::Isa;
use crate::dsp::lanes::{LANES, Real};
use crate::graph::plan::Plan;
use crate::schedule::Instant;

/// The output stage.
pub struct Stage {
    vibration: Vibration,
    /// The mix in the stage's own number type, a block for each group of channels.
    rows: Vec<Row>,
}

impl Stage {
    /// The stage of a plan.
    ///
    /// # Errors
    /// A rate or a number of taps that the stage cannot be built for.
    pub fn new(plan: &Plan, isa: Isa) -> Result<Self, Refusal> {
        let options = Options { taps: plan.taps, isa, ..Options::default() };
        let vibration = Vibration::new(plan.channels, plan.device_rate, &options)?;
        let rows = vec![Row::default(); vibration.groups() * super::workspace::BLOCK];
        Ok(Self { vibration, rows })
    }

    /// What the stage does to vibration outputs.
    pub fn vibration(&self) -> &Vibration {
        &self.vibration
    }

    /// What the stage has met so far.
    pub fn counts(&self) -> Counts {
        self.vibration.counts()
    }

    /// Whether nothing rings in it.
    pub fn is_asleep(&self) -> bool {
        (0..self.vibration.groups()).all(|g| self.vibration.sleeps(g))
    }

    /// A marker at an instant, when `clock` is the next engine sample.
    pub fn mark(&mut self, _name: u32, _at: Instant, _clock: u64) {}

    /// Whole engine samples whose frames fit into `output`.
    pub fn fits(&self, output: &[f32]) -> usize {
        output.len() / (self.vibration.ratio() * self.vibration.channels()).max(1)
    }

    /// Renders a range of the mix, whose first engine sample is `begin`, to interleaved frames of the device.
    pub fn process<R: Real>(
        &mut self,
        mix: &[Vec<[R; LANES]>],
        fed: &[bool],
        range: Range<usize>,
        begin: u64,
        output: &mut [f32],
    ) {
        if range.is_empty() {
            return;
        }
        let samples = range.len();
        for ((block, rows), fed) in self.rows.chunks_exact_mut(samples).zip(mix).zip(fed) {
            if *fed {
                for (to, from) in block.iter_mut().zip(&rows[range.clone()]) {
                    for l in 0..LANES {
                        to[l] = from[l].wide() as f32;
                    }
                }
            }
        }
        self.vibration.process(samples, &mut self.rows, fed, begin + range.start as u64, output);
    }
}
