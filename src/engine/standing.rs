//! What an engine does of its own at every sample or tick, besides the tasks that are added to it: how often, and what it has cost.

use std::sync::Arc;

use super::roster::Duty;

/// Seconds that the motors of a plan may take for an engine sample: an event in one of them, with room for a machine that is slower.
const MOTORS: f64 = 10e-6;
/// Seconds that a stretch of the knob's ticks may take for an engine sample.
const KNOB: f64 = 10e-6;

/// The standing work of an engine.
#[derive(Debug)]
pub(crate) struct Standing {
    motors: Arc<Duty>,
    knob: Arc<Duty>,
    /// Gives nanoseconds.
    clock: Option<fn() -> u64>,
}

impl Default for Standing {
    fn default() -> Self {
        let duty = |name, cost| Arc::new(Duty::new(name, cost, 0));
        Self { motors: duty("motors", MOTORS), knob: duty("knob", KNOB), clock: None }
    }
}

impl Standing {
    /// What is known of it.
    pub fn duties(&self) -> [Arc<Duty>; 2] {
        [Arc::clone(&self.motors), Arc::clone(&self.knob)]
    }

    /// Times all of it from now on.
    pub fn time(&mut self, clock: fn() -> u64) {
        self.clock = Some(clock);
    }

    /// Turns the motors for so many engine samples.
    #[inline]
    pub fn motors(&self, samples: usize, work: impl FnOnce()) {
        self.motors.timed(samples as u64, self.clock, work);
    }

    /// Runs the knob for so many engine samples.
    #[inline]
    pub fn knob(&self, samples: u64, work: impl FnOnce()) {
        self.knob.timed(samples, self.clock, work);
    }
}
