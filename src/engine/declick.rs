//! No step where one plan follows another: what the channels would jump by is added, and faded out.

use super::workspace::Workspace;
use crate::dsp::fade::{FADE, fade};
use crate::dsp::lanes::{LANES, Real};

/// The channels' last samples, and what is still to be faded out of them.
#[derive(Debug)]
pub struct Declick<R> {
    last: Vec<[R; LANES]>,
    before: Vec<[R; LANES]>,
    offset: Vec<[R; LANES]>,
    jumps: Vec<[bool; LANES]>,
    stage: Stage,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Stage {
    Idle,
    /// The next sample is the first of a new plan.
    Armed,
    /// Fading since this engine sample.
    Since(u64),
}

impl<R: Real> Declick<R> {
    /// For so many groups of channels.
    pub fn new(groups: usize) -> Self {
        let rows = || vec![[R::ZERO; LANES]; groups];
        let jumps = vec![[false; LANES]; groups];
        Self { last: rows(), before: rows(), offset: rows(), jumps, stage: Stage::Idle }
    }

    /// The next sample is the first of a new plan, by which these channels (from 0) may jump.
    pub fn arm(&mut self, jumps: &[bool]) {
        self.stage = Stage::Armed;
        for (group, jumps) in self.jumps.iter_mut().zip(jumps.chunks(LANES)) {
            group.iter_mut().zip(jumps).for_each(|(lane, jumps)| *lane = *jumps);
        }
    }

    /// Corrects a block of the mix whose first sample is `clock`, at `rate`, and remembers how it ends.
    pub fn apply(&mut self, work: &mut Workspace<R>, samples: usize, clock: u64, rate: f64) {
        if self.stage == Stage::Armed {
            for group in 0..self.offset.len() {
                let first = work.channels(group, 0, 1)[0];
                for l in 0..LANES {
                    let expected = self.last[group][l] + (self.last[group][l] - self.before[group][l]);
                    self.offset[group][l] = if self.jumps[group][l] { expected - first[l] } else { R::ZERO };
                }
            }
            self.stage = Stage::Since(clock);
        }
        if let Stage::Since(since) = self.stage {
            for group in 0..self.offset.len() {
                let offset = self.offset[group];
                for (frame, row) in work.channels(group, 0, samples).iter_mut().enumerate() {
                    let share = R::of(fade((clock - since + frame as u64) as f64 / rate));
                    for l in 0..LANES {
                        row[l] += offset[l] * share;
                    }
                }
            }
            if (clock - since) as f64 > FADE * rate {
                self.stage = Stage::Idle;
            }
        }
        for group in 0..self.last.len() {
            if !work.fed[group] {
                (self.last[group], self.before[group]) = ([R::ZERO; LANES], [R::ZERO; LANES]);
                continue;
            }
            let rows = work.channels(group, 0, samples);
            self.before[group] = if samples > 1 { rows[samples - 2] } else { self.last[group] };
            self.last[group] = rows[samples - 1];
        }
    }
}
