//! The last line of a callback: a panic ends in silence, not in the host.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Stands between an audio callback and what it calls. Nothing in here panics on purpose; should something do so after all, be it a
/// [`super::task::Task`] of somebody else's, the output is silence from there on, and the fault stays until the guard is made anew.
///
/// ```
/// # let mut engine_process = |output: &mut [f32]| output.fill(0.5);
/// let mut guard = pacinian::engine::guard::Guard::default();
/// let fault = guard.fault();
/// let mut callback = move |output: &mut [f32]| guard.call(output, &mut engine_process);
/// # let mut output = [0.0; 4];
/// callback(&mut output);
/// assert!(!fault.is_latched());
/// ```
#[derive(Debug, Default)]
pub struct Guard {
    fault: Fault,
    /// What the panic brought, which is freed with the guard and not on the audio thread.
    brought: Option<Box<dyn Any + Send>>,
}

/// Whether a guard has caught a panic, for other threads.
#[derive(Debug, Clone, Default)]
pub struct Fault(Arc<AtomicBool>);

impl Fault {
    /// Whether there was a panic, so that the output is silence.
    pub fn is_latched(&self) -> bool {
        self.0.load(Ordering::Acquire)
    }
}

impl Guard {
    /// For whoever watches from another thread.
    pub fn fault(&self) -> Fault {
        self.fault.clone()
    }

    /// Lets `process` fill `output`. Where it panics, and ever after, the output is silence, and `process` is not called again:
    /// what it works on may be half-way between two states.
    ///
    /// Catching a panic is not fit for an audio thread, as the panic itself is not: it allocates and writes to standard error.
    pub fn call(&mut self, output: &mut [f32], process: impl FnOnce(&mut [f32])) {
        if self.brought.is_none() {
            match catch_unwind(AssertUnwindSafe(|| process(output))) {
                Ok(()) => return,
                Err(brought) => {
                    self.brought = Some(brought);
                    self.fault.0.store(true, Ordering::Release);
                }
            }
        }
        output.fill(0.0);
    }
}

#[cfg(test)]
mod tests {
    use super::Guard;
    use crate::engine::Engine;
    use crate::engine::task::{Task, Values};
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;
    use crate::schedule::Beat;

    /// A task that panics when the clock has come to a sample.
    struct Faulty(u64);

    impl Task for Faulty {
        fn beat(&self) -> Beat {
            Beat::every(1)
        }
        fn run(&mut self, board: &mut dyn Values) {
            if board.clock() == self.0 {
                // As a panic, but without its words on standard error.
                std::panic::resume_unwind(Box::new("a task that panics"));
            }
        }
    }

    fn humming() -> Engine {
        let text = "format = \"pacinian-patch/1\"\ntitle = \"Hum\"\n[voice.hum]\nstart = \"always\"\noutput = \"tone\"\n\
                    [voice.hum.nodes]\ntone = { type = \"sine\", frequency = 100 }\n";
        let patch = Patch::parse("hum.toml", text.as_bytes()).unwrap().value;
        let plan = scene(&patch, &Rig::default_for(2), &Options::default(), &NoAssets).unwrap().plan;
        Engine::new(&plan).unwrap()
    }

    #[test]
    fn a_panic_becomes_silence_and_a_fault_that_stays() {
        let (mut engine, mut plain) = (humming(), humming());
        // In the middle of the third call.
        engine.add_task(Box::new(Faulty(200)));
        let mut guard = Guard::default();
        let fault = guard.fault();
        let (mut output, mut expected, mut calls) = ([0.0; 960], [0.0; 960], 0);
        for call in 0..10 {
            output.fill(f32::NAN);
            guard.call(&mut output, |output| {
                calls += 1;
                engine.process(output);
            });
            plain.process(&mut expected);
            assert_eq!(fault.is_latched(), call >= 2, "call {call}");
            match call {
                0 | 1 => assert!(output == expected && output.iter().any(|x| *x != 0.0)),
                _ => assert!(output.iter().all(|x| *x == 0.0), "call {call}"),
            }
        }
        assert_eq!(calls, 3, "what has failed is left alone");
        // What one guard has caught is no other's business.
        let mut other = Guard::default();
        other.call(&mut output, |output| plain.process(output));
        assert!(!other.fault().is_latched() && output.iter().any(|x| *x != 0.0));
    }
}
