//! Work that comes back at exact intervals of engine time, on the audio thread.

use super::control::Ramp;
use crate::dsp::lanes::Real;
use crate::schedule::{Beat, Instant};

/// A periodic task. It may not allocate, lock, block or panic.
pub trait Task: Send {
    /// When it runs.
    fn beat(&self) -> Beat;
    /// Runs, before the sample that `board` names.
    fn run(&mut self, board: &mut dyn Values);
    /// What it is called, where its cost is shown.
    fn name(&self) -> &str {
        "task"
    }
    /// Seconds that a run may take on the slowest machine it is meant for; 0 says nothing. Runs that take longer are counted.
    fn cost(&self) -> f64 {
        0.0
    }
    /// How soon it rests when the callback has too much to do: the highest rank first, 0 never. What moves something, a motor's drive
    /// or a knob's servo, is 0; what only shows something is high.
    fn rank(&self) -> u8 {
        0
    }
    /// It rests from here on, or runs again.
    fn rest(&mut self, rests: bool) {
        let _ = rests;
    }
}

/// What a task may read and move.
pub trait Values {
    /// The next sample to be computed.
    fn clock(&self) -> u64;
    /// The latest value of an engine-wide signal, by its number in the plan; 0 before the first sample.
    fn signal(&self, index: usize) -> f64;
    /// Sends a control, by its place in the plan, to a value.
    fn send(&mut self, control: usize, value: f64);
}

/// Values of an engine.
pub(crate) struct Board<'a, R: Real> {
    /// The controls.
    pub controls: &'a mut [Ramp<R>],
    /// The signals' latest values.
    pub latest: &'a [R],
    /// The next sample.
    pub clock: u64,
}

impl<R: Real> Values for Board<'_, R> {
    fn clock(&self) -> u64 {
        self.clock
    }
    fn signal(&self, index: usize) -> f64 {
        self.latest.get(index).map_or(0.0, |x| x.wide())
    }
    fn send(&mut self, control: usize, value: f64) {
        if let Some(ramp) = self.controls.get_mut(control) {
            ramp.send(value, Instant { sample: self.clock, fraction: 0 });
        }
    }
}
