//! Raw outputs: the mix as it is, at the device's rate; neither equalised nor limited nor band-limited to 1 kHz.
//!
//! What an engine sample is between two of them is said by the filter that brings vibration up too: it passes 0 to 1 kHz as it
//! is and keeps the images of that away. Whatever a patch puts between 1 kHz and half the engine's rate goes out as well, weaker
//! towards the end, and with images. Full scale is the limit, or the output's own level where that is lower: beyond it
//! a sample is cut, and counted.

use super::vibration::{Counts, Row, single};
use super::workspace::BLOCK;
use crate::dsp::biquad::Complex;
use crate::dsp::interpolator::Interpolator;
use crate::dsp::lanes::LANES;
use crate::graph::plan::{Output, OutputKind, Plan};

/// The raw outputs of a plan.
#[derive(Debug)]
pub struct Raw {
    lines: Vec<Line>,
    /// By phase: a tap for each sample of the window, oldest first.
    phases: Vec<Vec<f32>>,
    filter: Interpolator,
    channels: usize,
    counts: Counts,
}

#[derive(Debug)]
struct Line {
    channel: usize,
    /// The most that leaves it.
    most: f32,
    /// The samples that the filter still needs, and behind them those of the block.
    window: Vec<f32>,
}

impl Raw {
    /// Those of a plan.
    pub fn new(plan: &Plan) -> Self {
        let raw: Vec<_> = plan.outputs.iter().filter(|o| o.kind == OutputKind::Raw).collect();
        // Where there are none, neither is the filter.
        let (taps, ratio) = if raw.is_empty() { (1, 1) } else { (plan.taps, plan.ratio) };
        let filter = Interpolator::design(taps, ratio, plan.device_rate / ratio as f64);
        let there = raw.iter().filter(|o| (o.channel as usize) < plan.channels);
        let line = |output: &&Output| Line {
            channel: output.channel as usize,
            most: single(output.max_level),
            window: vec![0.0; filter.taps - 1 + BLOCK],
        };
        let lines = there.map(line).collect();
        let tap =
            |phase: usize, k: usize| filter.response[(filter.taps - 1 - k) * filter.ratio + phase] as f32;
        let phases = (0..filter.ratio).map(|p| (0..filter.taps).map(|k| tap(p, k)).collect()).collect();
        Self { lines, phases, filter, channels: plan.channels, counts: Counts::default() }
    }

    /// Whether a channel (from 0) is one of them.
    pub fn has(&self, channel: usize) -> bool {
        self.lines.iter().any(|line| line.channel == channel)
    }

    /// The designed linear response at `frequency` (Hz), delay included.
    pub fn response(&self, frequency: f64) -> Complex {
        self.filter.response(frequency)
    }

    /// Whether all of it is silence.
    pub fn is_idle(&self) -> bool {
        self.lines.iter().all(|line| line.window[..self.filter.taps - 1].iter().all(|x| *x == 0.0))
    }

    /// Lets no more leave the channels than these levels.
    pub fn limit_to(&mut self, levels: &[f32]) {
        for line in &mut self.lines {
            line.most = levels.get(line.channel).copied().unwrap_or(1.0);
        }
    }

    /// Takes over from old ones what goes on as it was: channels that are not among the `crossed`.
    pub fn take_over(&mut self, old: &mut Self, crossed: &[usize]) {
        for line in self.lines.iter_mut().filter(|line| !crossed.contains(&line.channel)) {
            if let Some(old) = old.lines.iter_mut().find(|old| old.channel == line.channel) {
                std::mem::swap(line, old);
            }
        }
    }

    /// Samples that were no numbers, and those that were beyond full scale.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Takes its channels out of the mix: a block of `samples` rows for each group of eight channels, and whether it was fed.
    pub fn take(&mut self, rows: &mut [Row], fed: &[bool], samples: usize) {
        for line in &mut self.lines {
            let (group, lane) = (line.channel / LANES, line.channel % LANES);
            let new = &mut line.window[self.filter.taps - 1..][..samples];
            match rows.get_mut(group * samples..(group + 1) * samples) {
                Some(rows) if fed.get(group) != Some(&false) => {
                    for (new, row) in new.iter_mut().zip(rows) {
                        *new = std::mem::take(&mut row[lane]);
                        if !new.is_finite() {
                            *new = 0.0;
                            self.counts.masked += 1;
                        }
                    }
                }
                _ => new.fill(0.0),
            }
        }
    }

    /// Writes the frames of the samples that were taken last; those of the last one lie in `rest` where `frames` has no room.
    pub fn write(&mut self, samples: usize, frames: &mut [f32], rest: &mut [f32]) {
        let (ratio, past) = (self.filter.ratio, self.filter.taps - 1);
        let whole = frames.len() / (ratio * self.channels).max(1) * ratio;
        for line in &mut self.lines {
            let before = frames.chunks_exact_mut(self.channels).take(whole);
            let mut frames = before.chain(rest.chunks_exact_mut(self.channels));
            for window in line.window[..past + samples].windows(past + 1) {
                for (taps, frame) in self.phases.iter().zip(&mut frames) {
                    let value: f32 = taps.iter().zip(window).map(|(tap, x)| tap * x).sum();
                    // The sum of what is near the end of the numbers may be none.
                    let within = value.abs() <= line.most;
                    let cut = if value.is_nan() { 0.0 } else { line.most.copysign(value) };
                    self.counts.clamped += u64::from(!within);
                    frame[line.channel] = if within { value } else { cut };
                }
            }
            line.window.copy_within(samples..samples + past, 0);
        }
    }
}
