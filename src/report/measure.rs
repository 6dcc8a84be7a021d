//! A scene measured: how far the engine is from the reference, and what it takes.

use std::convert::Infallible;
use std::time::{Duration, Instant as Clock};

use realfft::num_complex::Complex64;

use super::compare::{Comparison, compare_watched};
use super::reference::{Played, Reference, reference_watched};
use crate::engine::Engine;
use crate::engine::event::{Event, Move, Play, Source};
use crate::engine::refusal::Refusal;
use crate::graph::plan::Plan;
use crate::player::stretch::{self, Feeds};
use crate::schedule::Instant;

/// Seconds that are added, so that all filters have rung out before the end.
pub const TAIL: f64 = 0.3;

/// Seconds that what was released at the end may ring, at most.
pub const RING: f64 = 8.0;

/// How many times the engine's rate the reference runs at.
pub const OVER: usize = 16;

/// Runs of a scene for its run time: so many at most, unless all together are over sooner than the least time that says anything of
/// a machine that does other things, too; and how long they may take together.
const MOST_RUNS: u32 = 9;
const LEAST: Duration = Duration::from_millis(100);
const WARM: Duration = Duration::from_millis(300);

/// What was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Engine against reference.
    pub comparison: Comparison,
    /// Seconds of vibration that were rendered.
    pub seconds: f64,
    /// Wall time that the engine took: the least of several runs, fewer for long scenes.
    pub run_time: Duration,
    /// Voices that had to make room; the reference does not model that, so with any the error says little.
    pub stolen: u64,
}

/// What was played: enough to play it again, and to say what it should have been. What engine-wide signals of the plan set off is no part
/// of it: they do so again, until it ends.
#[derive(Debug, Clone, Copy)]
pub struct Take<'a> {
    /// Voices, in seconds from the beginning, in order.
    pub events: &'a [(f64, Play)],
    /// How they were moved while they sounded, in order.
    pub moves: &'a [(f64, Move)],
    /// Channels of the audio input at the device's rate, from the beginning; those that are missing are silence.
    pub input: &'a [Vec<f32>],
    /// How long: what sounds longer is released then, and let ring out for [`RING`] at most. What rings longer still counts as
    /// error where the engine's delay moves it out of the time.
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
        let samples = ((self.seconds + self.rings(plan) + TAIL) * plan.engine_rate()).ceil();
        let seconds = samples / plan.engine_rate();
        let (events, moves) = (before(self.seconds, self.events), before(self.seconds, self.moves));
        let played = Played { events, moves, input: self.input, released: self.seconds };
        reference_watched(&plan.of_vibration(), &played, seconds, OVER, watch)
    }

    /// Seconds that it rings after its end, up to [`RING`]. A plan that no engine can be built for does not ring.
    pub fn rings(&self, plan: &Plan) -> f64 {
        let plan = &plan.of_vibration();
        let Ok(engine) = Engine::new(plan) else { return 0.0 };
        let mut playing = Playing::new(engine, plan, self);
        let mut frames = vec![0.0; STEP * plan.ratio * plan.channels];
        let ears = playing.engine.input_channels();
        let all = ((self.seconds + RING) * plan.engine_rate()).ceil() as usize;
        for first in (0..all).step_by(STEP) {
            let now = first as f64 / plan.engine_rate();
            if now >= self.seconds && playing.engine.is_silent() {
                return (now - self.seconds).min(RING);
            }
            let heard = interleaved(self.input, ears, first * plan.ratio, STEP * plan.ratio);
            stretch::play(&mut playing, plan.ratio, &heard, &mut frames);
        }
        RING
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
        let samples = ideal.channels.first().map_or(0, Vec::len);
        let (mut engine, mut frames, mut run_time) =
            self.run(plan, samples, &mut |share| watch(0.5 * share))?;
        // A short scene is over before the machine has warmed up: the least of some runs says what it takes.
        let (begin, mut runs) = (Clock::now(), 1);
        let more = |runs| runs < MOST_RUNS || begin.elapsed() < LEAST;
        while more(runs) && begin.elapsed() + run_time < WARM {
            let (engine_again, frames_again, again) = self.run(plan, samples, &mut |_| watch(0.5))?;
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
        let seconds = samples as f64 / plan.engine_rate();
        let stolen = engine.counters().stolen;
        Ok(Measured { comparison, seconds, run_time, stolen })
    }

    /// Plays it once, for so many samples of the engine: the engine as it ends, what it gave out, and the wall time that took.
    fn run<S: From<Refusal>>(
        &self,
        plan: &Plan,
        samples: usize,
        watch: &mut dyn FnMut(f64) -> Result<(), S>,
    ) -> Result<(Engine, Vec<f32>, Duration), S> {
        let plan = &plan.of_vibration();
        let mut playing = Playing::new(Engine::new(plan)?, plan, self);
        let mut frames = vec![0.0; samples * plan.ratio * plan.channels];
        let ears = playing.engine.input_channels();
        let heard = interleaved(self.input, ears, 0, samples * plan.ratio);
        let mut heard = heard.chunks(BLOCK * plan.ratio * ears.max(1));
        let begin = Clock::now();
        for part in frames.chunks_mut(BLOCK * plan.ratio * plan.channels) {
            // Seldom enough to take nothing of the time that is measured.
            watch(playing.engine.clock() as f64 / samples as f64)?;
            stretch::play(&mut playing, plan.ratio, heard.next().unwrap_or_default(), part);
        }
        Ok((playing.engine, frames, begin.elapsed()))
    }
}

/// What lies before so many seconds.
fn before<T>(seconds: f64, all: &[(f64, T)]) -> &[(f64, T)] {
    &all[..all.partition_point(|(at, _)| *at < seconds)]
}

/// Samples of the engine that are played at once.
const BLOCK: usize = 4096;
/// And where the moment is looked for at which it falls silent.
const STEP: usize = 64;

/// A take on an engine.
struct Playing<'a> {
    engine: Engine,
    events: std::slice::Iter<'a, (f64, Play)>,
    moves: std::slice::Iter<'a, (f64, Move)>,
    rate: f64,
    /// When everything is released; `None` as soon as the engine knows.
    end: Option<f64>,
}

impl<'a> Playing<'a> {
    fn new(engine: Engine, plan: &Plan, take: &Take<'a>) -> Self {
        let (events, moves) = (before(take.seconds, take.events), before(take.seconds, take.moves));
        let mut engine = engine;
        engine.watch_until(Instant::of_samples(take.seconds * plan.engine_rate()));
        Self {
            engine,
            events: events.iter(),
            moves: moves.iter(),
            rate: plan.engine_rate(),
            end: Some(take.seconds),
        }
    }
}

impl Feeds for Playing<'_> {
    fn engine(&mut self) -> &mut Engine {
        &mut self.engine
    }

    fn feed(&mut self, until: u64) -> Option<u64> {
        let before = until as f64 / self.rate;
        let due = |at: f64| (at < before).then(|| Instant::of_samples(at * self.rate));
        loop {
            let (play, moved) = (self.events.as_slice().first(), self.moves.as_slice().first());
            // A voice begins before it moves.
            let (at, event) = match (play, moved) {
                (Some((at, play)), moved) if moved.is_none_or(|(of, _)| at <= of) => {
                    (*at, Event::Play(*play))
                }
                (_, Some((at, moved))) => (*at, Event::Touch(*moved)),
                (_, None) => break,
            };
            let at = due(at)?;
            if self.engine.room() == 0 {
                return Some(at.ceiling());
            }
            self.engine.schedule(at, Source::Pattern, event);
            if matches!(event, Event::Play(_)) {
                self.events.next();
            } else {
                self.moves.next();
            }
        }
        let at = due(self.end?)?;
        if self.engine.room() == 0 {
            return Some(at.ceiling());
        }
        self.engine.schedule(at, Source::Pattern, Event::ReleaseAll);
        self.end = None;
        None
    }
}

/// Frames of an input from `first` on; none where there is no input.
fn interleaved(input: &[Vec<f32>], channels: usize, first: usize, frames: usize) -> Vec<f32> {
    let at = |channel: usize, frame: usize| input.get(channel).and_then(|c| c.get(frame)).copied();
    let frame = |n| (0..channels).map(move |c| at(c, n).unwrap_or(0.0));
    (first..first + if input.is_empty() { 0 } else { frames }).flat_map(frame).collect()
}

/// Plays `events` (seconds from the beginning, in order) on a plan for `seconds` and a tail, by the engine and by the reference.
///
/// What is still under way then is released and rings out, as of a [`Take`].
///
/// # Errors
/// A plan that no engine can be built for.
pub fn measure(plan: &Plan, events: &[(f64, Play)], seconds: f64) -> Result<Measured, Refusal> {
    let take = Take { events, moves: &[], input: &[], seconds };
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
    use crate::engine::event::Play;
    use crate::engine::refusal::Refusal;
    use crate::graph::plan::Plan;
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::player::Player;
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

    fn plan_of(patch: &[u8]) -> (Patch, Plan) {
        let head = b"format = \"pacinian-patch/1\"\ntitle = \"t\"\n";
        let patch = Patch::parse("p", &[head, patch].concat()).unwrap_or_else(|p| panic!("{p}")).value;
        let options = Options { live: true, ..Options::default() };
        let plan = scene(&patch, &Rig::default_for(1), &options, &NoAssets).unwrap().plan;
        (patch, plan)
    }

    /// More falls on a moment than the engine's queue holds: a take is played as it was.
    #[test]
    fn what_a_player_played_is_played_again_bit_by_bit() {
        let one = "{ at = 0.01, voice = \"a\", level = 0.1, duration = 0.002, repeat = { every = 1e-6, times = 10000 } },";
        let text = format!(
            "[voice.a]\nvoices = 4\noutput = \"s\"\nnodes.s = {{ type = \"white\", amplitude = 0.2 }}\n\
             [pattern.p]\nevents = [{}{{ at = 0.2, voice = \"a\" }}]\n",
            one.repeat(4)
        );
        let (patch, _) = plan_of(text.as_bytes());
        let mut player = Player::new(&patch, &Rig::default_for(1), &Options::default(), &NoAssets).unwrap();
        player.record();
        let (plan, samples) = (player.plan().clone(), 4000);
        let mut frames = vec![0.0; samples * plan.ratio];
        player.process(&mut frames);
        assert_eq!((player.recorded().len(), player.counters().late), (40_001, 0));
        let take = Take { events: player.recorded(), moves: &[], input: &[], seconds: 0.5 };
        let (engine, again, _) = take.run::<End>(&plan, samples, &mut |_| Ok(())).unwrap();
        assert_eq!((engine.counters().late, engine.counters().dropped), (0, 0));
        assert!(frames.iter().zip(&again).all(|(a, b)| a.to_bits() == b.to_bits()));
    }

    /// What would sound for ever is released at the end of the time, by engine and reference alike.
    #[test]
    fn what_is_under_way_at_the_end_is_no_error() {
        let held = |at: f64| (at, Play { duration: f64::INFINITY, level: 0.5, id: 7, ..Play::default() });
        let sine = "s = { type = \"sine\", frequency = 150, amplitude = 0.5 }";
        let product = "type = \"multiply\", inputs = [\"s\", \"e\"]";
        for (voice, events) in [
            (format!("start = \"always\"\noutput = \"s\"\n[voice.v.nodes]\n{sine}"), vec![]),
            (
                format!(
                    "start = \"always\"\noutput = \"o\"\n[voice.v.nodes]\n{sine}\n\
                     e = {{ type = \"lfo\", rate = 3 }}\no = {{ {product} }}"
                ),
                vec![],
            ),
            (format!("output = \"s\"\n[voice.v.nodes]\n{sine}"), vec![held(0.1), held(0.7)]),
            (
                format!(
                    "output = \"o\"\n[voice.v.nodes]\n{sine}\n\
                     e = {{ type = \"envelope\", release = 1.5 }}\no = {{ {product} }}"
                ),
                vec![held(0.1), held(0.3), held(2.0)],
            ),
        ] {
            let (_, plan) = plan_of(format!("[voice.v]\n{voice}\n").as_bytes());
            let take = Take { events: &events, moves: &[], input: &[], seconds: 0.8 };
            let measured = take.measure(&plan, &take.reference(&plan)).unwrap();
            assert!(measured.comparison.error_db < -80.0, "{voice}: {measured:?}");
            assert!(take.rings(&plan) < 2.0, "{voice}: {}", take.rings(&plan));
        }
    }

    #[test]
    fn who_waits_is_told_how_far_it_is_and_may_stop_it_anywhere() {
        let patch = Patch::parse("p", PATCH).unwrap().value;
        let plan = scene(&patch, &Rig::default_for(2), &Options::default(), &NoAssets).unwrap().plan;
        let take = Take { events: &[], moves: &[], input: &[], seconds: 1.0 };
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
