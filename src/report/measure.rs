//! A scene measured: how far the engine is from the reference, and what it takes.

use std::time::{Duration, Instant as Clock};

use realfft::num_complex::Complex64;

use super::compare::{Comparison, compare};
use super::reference::reference;
use crate::engine::Engine;
use crate::engine::event::{Event, Play, Source};
use crate::engine::vibration::Refusal;
use crate::graph::plan::Plan;
use crate::schedule::Instant;

/// Seconds that are added, so that all filters have rung out before the end.
pub const TAIL: f64 = 0.3;

/// How many times the engine's rate the reference runs at.
pub const OVER: usize = 16;

/// What was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Engine against reference.
    pub comparison: Comparison,
    /// Seconds of vibration that were rendered.
    pub seconds: f64,
    /// Wall time that the engine took.
    pub run_time: Duration,
    /// Voices that had to make room; the reference does not model that, so with any the error says little.
    pub stolen: u64,
}

/// Plays `events` (seconds from the beginning, in order) on a plan for `seconds` and a tail, by the engine and by the reference.
///
/// Sound that is still under way at the end counts as error where the engine's delay moves it out; let everything end first.
///
/// # Errors
/// A plan that no engine can be built for.
pub fn measure(plan: &Plan, events: &[(f64, Play)], seconds: f64) -> Result<Measured, Refusal> {
    let mut engine = Engine::new(plan)?;
    let rate = plan.engine_rate();
    let samples = ((seconds + TAIL) * rate).ceil() as usize;
    let block = 64 * plan.ratio * plan.channels;
    let mut frames = vec![0.0; samples * plan.ratio * plan.channels];
    let mut next = events.iter().peekable();
    let begin = Clock::now();
    for part in frames.chunks_mut(block) {
        let until = (engine.clock() + 64) as f64 / rate;
        while let Some((at, play)) = next.next_if(|(at, _)| *at < until && engine.room() > 0) {
            engine.schedule(Instant::of_samples(at * rate), Source::Pattern, Event::Play(*play));
        }
        engine.process(part);
    }
    let run_time = begin.elapsed();
    let ideal = reference(plan, events, samples as f64 / rate, OVER);
    let delay = engine.delay();
    let comparison = compare(
        &frames,
        &ideal,
        plan.ratio,
        delay.lead + delay.up_sampling + delay.band_limit_phase,
        &|hertz| designed(&engine, hertz),
    );
    Ok(Measured { comparison, seconds: samples as f64 / rate, run_time, stolen: engine.counters().stolen })
}

/// The output stage's designed response without the delay that the engine reports for it.
pub fn designed(engine: &Engine, hertz: f64) -> Complex64 {
    let delay = engine.delay();
    let response = engine.stage().vibration().response(hertz);
    let phase = std::f64::consts::TAU * hertz * (delay.up_sampling + delay.band_limit_phase);
    Complex64::new(response.re, response.im) * Complex64::cis(phase)
}
