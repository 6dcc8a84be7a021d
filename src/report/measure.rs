//! A scene measured: how far the engine is from the reference, and what it takes.

use std::time::{Duration, Instant as Clock};

use realfft::num_complex::Complex64;

use super::compare::{Comparison, compare};
use super::reference::{Reference, reference_hearing};
use crate::engine::Engine;
use crate::engine::event::{Event, Play, Source};
use crate::engine::refusal::Refusal;
use crate::graph::plan::Plan;
use crate::schedule::Instant;

/// Seconds that are added, so that all filters have rung out before the end.
pub const TAIL: f64 = 0.3;

/// How many times the engine's rate the reference runs at.
pub const OVER: usize = 16;

/// Runs of a scene for its run time, at most, and how long they may take together.
const MOST_RUNS: u32 = 9;
const WARM: Duration = Duration::from_millis(300);

/// What was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Engine against reference.
    pub comparison: Comparison,
    /// Seconds of vibration that were rendered.
    pub seconds: f64,
    /// Wall time that the engine took: the least of up to nine runs, fewer for long scenes.
    pub run_time: Duration,
    /// Voices that had to make room; the reference does not model that, so with any the error says little.
    pub stolen: u64,
}

/// What was played: enough to play it again, and to say what it should have been.
#[derive(Debug, Clone, Copy)]
pub struct Take<'a> {
    /// Voices, in seconds from the beginning, in order.
    pub events: &'a [(f64, Play)],
    /// Channels of the audio input at the device's rate, from the beginning; those that are missing are silence.
    pub input: &'a [Vec<f32>],
    /// How long. Sound that is still under way at the end counts as error where the engine's delay moves it out.
    pub seconds: f64,
}

impl Take<'_> {
    /// What it should have been, with [`TAIL`] at the end. The same for plans of one scene that differ in number type, or in taps
    /// where nothing listens to an input, whose filter has as many.
    pub fn reference(&self, plan: &Plan) -> Reference {
        reference_hearing(plan, self.events, self.input, self.samples(plan) as f64 / plan.engine_rate(), OVER)
    }

    /// Plays it on a plan and compares it with its reference.
    ///
    /// # Errors
    /// A plan that no engine can be built for.
    pub fn measure(&self, plan: &Plan, ideal: &Reference) -> Result<Measured, Refusal> {
        let (mut engine, mut frames, mut run_time) = self.run(plan)?;
        // A short scene is over before the machine has warmed up: the least of some runs says what it takes.
        let (begin, mut runs) = (Clock::now(), 1);
        while runs < MOST_RUNS && begin.elapsed() + run_time < WARM {
            let (engine_again, frames_again, again) = self.run(plan)?;
            (engine, frames, run_time) = (engine_again, frames_again, run_time.min(again));
            runs += 1;
        }
        let delay = engine.delay();
        let comparison = compare(
            &frames,
            ideal,
            plan.ratio,
            delay.lead + delay.up_sampling + delay.band_limit_phase,
            &|channel, hertz| designed(&engine, channel, hertz),
        );
        let seconds = self.samples(plan) as f64 / plan.engine_rate();
        let stolen = engine.counters().stolen;
        Ok(Measured { comparison, seconds, run_time, stolen })
    }

    /// Plays it once: the engine as it ends, what it gave out, and the wall time that took.
    fn run(&self, plan: &Plan) -> Result<(Engine, Vec<f32>, Duration), Refusal> {
        let mut engine = Engine::new(plan)?;
        let (rate, samples) = (plan.engine_rate(), self.samples(plan));
        let block = 64 * plan.ratio;
        let mut frames = vec![0.0; samples * plan.ratio * plan.channels];
        let heard = interleaved(self.input, engine.input_channels(), samples * plan.ratio);
        let mut heard = heard.chunks(block * engine.input_channels().max(1));
        let mut next = self.events.iter().peekable();
        let begin = Clock::now();
        for part in frames.chunks_mut(block * plan.channels) {
            let until = (engine.clock() + 64) as f64 / rate;
            while let Some((at, play)) = next.next_if(|(at, _)| *at < until && engine.room() > 0) {
                engine.schedule(Instant::of_samples(at * rate), Source::Pattern, Event::Play(*play));
            }
            engine.process_input(heard.next().unwrap_or_default(), part);
        }
        Ok((engine, frames, begin.elapsed()))
    }

    fn samples(&self, plan: &Plan) -> usize {
        ((self.seconds + TAIL) * plan.engine_rate()).ceil() as usize
    }
}

fn interleaved(input: &[Vec<f32>], channels: usize, frames: usize) -> Vec<f32> {
    let at = |channel: usize, frame: usize| input.get(channel).and_then(|c| c.get(frame)).copied();
    let frame = |n| (0..channels).map(move |c| at(c, n).unwrap_or(0.0));
    (0..if input.is_empty() { 0 } else { frames }).flat_map(frame).collect()
}

/// Plays `events` (seconds from the beginning, in order) on a plan for `seconds` and a tail, by the engine and by the reference.
///
/// Sound that is still under way at the end counts as error where the engine's delay moves it out; let everything end first.
///
/// # Errors
/// A plan that no engine can be built for.
pub fn measure(plan: &Plan, events: &[(f64, Play)], seconds: f64) -> Result<Measured, Refusal> {
    let take = Take { events, input: &[], seconds };
    take.measure(plan, &take.reference(plan))
}

/// The output stage's designed response on a channel (from 0) without the delay that the engine reports for it.
pub fn designed(engine: &Engine, channel: usize, hertz: f64) -> Complex64 {
    let delay = engine.delay();
    let response = engine.stage().response(channel, hertz);
    let phase = std::f64::consts::TAU * hertz * (delay.up_sampling + delay.band_limit_phase);
    Complex64::new(response.re, response.im) * Complex64::cis(phase)
}
