//! A scene measured: how far the engine is from the reference, and what it takes.

use std::convert::Infallible;
use std::time::{Duration, Instant as Clock};

use realfft::num_complex::Complex64;

use super::compare::{Comparison, compare_watched};
use super::reference::{Reference, reference_watched};
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
        let Ok(all) = self.reference_watched(plan, &mut |_| Ok::<(), Infallible>(()));
        all
    }

    /// As [`Take::reference`], for somebody who waits: `watch` is asked many times a second with the share that is done, from 0 to 1.
    ///
    /// # Errors
    /// The first that `watch` gives, at once.
    pub fn reference_watched<S>(
        &self,
        plan: &Plan,
        watch: &mut dyn FnMut(f64) -> Result<(), S>,
    ) -> Result<Reference, S> {
        let seconds = self.samples(plan) as f64 / plan.engine_rate();
        reference_watched(plan, self.events, self.input, seconds, OVER, watch)
    }

    /// Plays it on a plan and compares it with its reference.
    ///
    /// # Errors
    /// A plan that no engine can be built for.
    pub fn measure(&self, plan: &Plan, ideal: &Reference) -> Result<Measured, Refusal> {
        self.measure_watched(plan, ideal, &mut |_| Ok(()))
    }

    /// As [`Take::measure`], for somebody who waits: `watch` is asked many times a second with the share that is done, from 0 to 1.
    ///
    /// # Errors
    /// A plan that no engine can be built for, and the first that `watch` gives, at once.
    pub fn measure_watched<S: From<Refusal>>(
        &self,
        plan: &Plan,
        ideal: &Reference,
        watch: &mut dyn FnMut(f64) -> Result<(), S>,
    ) -> Result<Measured, S> {
        let (mut engine, mut frames, mut run_time) = self.run(plan, &mut |share| watch(0.5 * share))?;
        // A short scene is over before the machine has warmed up: the least of some runs says what it takes.
        let (begin, mut runs) = (Clock::now(), 1);
        while runs < MOST_RUNS && begin.elapsed() + run_time < WARM {
            let (engine_again, frames_again, again) = self.run(plan, &mut |_| watch(0.5))?;
            (engine, frames, run_time) = (engine_again, frames_again, run_time.min(again));
            runs += 1;
        }
        let delay = engine.delay();
        let comparison = compare_watched(
            &frames,
            ideal,
            plan.ratio,
            delay.lead + delay.up_sampling + delay.band_limit_phase,
            &|channel, hertz| designed(&engine, channel, hertz),
            &mut |share| watch(0.5 + 0.5 * share),
        )?;
        let seconds = self.samples(plan) as f64 / plan.engine_rate();
        let stolen = engine.counters().stolen;
        Ok(Measured { comparison, seconds, run_time, stolen })
    }

    /// Plays it once: the engine as it ends, what it gave out, and the wall time that took.
    fn run<S: From<Refusal>>(
        &self,
        plan: &Plan,
        watch: &mut dyn FnMut(f64) -> Result<(), S>,
    ) -> Result<(Engine, Vec<f32>, Duration), S> {
        let mut engine = Engine::new(plan)?;
        let (rate, samples) = (plan.engine_rate(), self.samples(plan));
        let block = 64 * plan.ratio;
        let mut frames = vec![0.0; samples * plan.ratio * plan.channels];
        let heard = interleaved(self.input, engine.input_channels(), samples * plan.ratio);
        let mut heard = heard.chunks(block * engine.input_channels().max(1));
        let mut next = self.events.iter().peekable();
        let begin = Clock::now();
        for (n, part) in frames.chunks_mut(block * plan.channels).enumerate() {
            // Seldom enough to take nothing of the time that is measured.
            if n.is_multiple_of(64) {
                watch(engine.clock() as f64 / samples as f64)?;
            }
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

#[cfg(test)]
mod tests {
    use super::Take;
    use crate::engine::refusal::Refusal;
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;

    /// Why it ended.
    #[derive(Debug, PartialEq)]
    enum End {
        Asked,
        Refused,
    }

    impl From<Refusal> for End {
        fn from(_: Refusal) -> Self {
            Self::Refused
        }
    }

    /// A voice that is always on, and a shared node: the two that go on for all of the time.
    const PATCH: &[u8] = b"format = \"pacinian-patch/1\"\ntitle = \"t\"\n[shared.nodes]\nslow = { type = \"lfo\", rate = 2 }\n\
        [voice.a]\nstart = \"always\"\noutput = \"o\"\n[voice.a.nodes]\ns = { type = \"sine\", frequency = 250 }\n\
        o = { type = \"multiply\", inputs = [\"s\", \"slow\"] }\n";

    #[test]
    fn who_waits_is_told_how_far_it_is_and_may_stop_it_anywhere() {
        let patch = Patch::parse("p", PATCH).unwrap().value;
        let plan = scene(&patch, &Rig::default_for(2), &Options::default(), &NoAssets).unwrap().plan;
        let take = Take { events: &[], input: &[], seconds: 1.0 };
        let mut shares = Vec::new();
        let mut all = |share| {
            shares.push(share);
            Ok::<(), End>(())
        };
        let ideal = take.reference_watched(&plan, &mut all).unwrap();
        assert_eq!(ideal, take.reference(&plan));
        assert!(shares.is_sorted() && shares.len() > 100, "{} times", shares.len());
        assert!(shares.first() == Some(&0.0) && shares.last().is_some_and(|last| (0.9..=1.0).contains(last)));
        for stop in [0.0, 0.2, 0.7] {
            let (mut asked, mut late) = (false, 0);
            let watched = take.reference_watched(&plan, &mut |share| {
                late += usize::from(asked);
                asked |= share >= stop;
                if asked { Err(End::Asked) } else { Ok(()) }
            });
            assert_eq!((watched.unwrap_err(), late), (End::Asked, 0), "{stop}");
            let measured = take.measure_watched(&plan, &ideal, &mut |share| {
                if share >= stop { Err(End::Asked) } else { Ok(()) }
            });
            assert_eq!(measured.unwrap_err(), End::Asked, "{stop}");
        }
    }
}
