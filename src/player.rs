//! A patch on a rig, playing: a performer together with the engine that it feeds.

pub(crate) mod stretch;

use std::sync::Arc;

use crate::engine::event::{Event, Move, Play, Source};
use crate::engine::knob::Knob;
use crate::engine::{Counters, Engine};
use crate::graph::plan::Plan;
use crate::graph::scene::{Options, scene};
use crate::graph::watch::LATENCY;
use crate::knob::local_model::link::Slow;
use crate::midi::Message;
use crate::node::asset::Assets;
use crate::patch::Patch;
use crate::performer::{Callings, MidiCounts, Performer, When};
use crate::rig::Rig;
use crate::schedule::Instant;
use crate::text::{Problem, Problems};

pub use crate::performer::{Happening, Heard, Listener, Note, OpenEvents, Origin, Touch};

/// A patch on a rig, playing.
///
/// It unrolls patterns as it goes, which may allocate and read files; [`Engine::process`] alone is fit for an audio callback.
pub struct Player {
    engine: Engine,
    performer: Performer,
    callings: Callings,
}

impl Player {
    /// A player for a patch without events files.
    ///
    /// # Errors
    /// Everything that keeps patch and rig from playing together.
    pub fn new(patch: &Patch, rig: &Rig, options: &Options, assets: &dyn Assets) -> Result<Self, Problems> {
        let refuse =
            |path: &str| Err(Problem::of_file(format!("events files are not read here, so not `{path}`")));
        Self::with_files(patch, rig, options, assets, Box::new(refuse))
    }

    /// A player that opens events files by `files`.
    ///
    /// # Errors
    /// As [`Player::new`].
    pub fn with_files(
        patch: &Patch,
        rig: &Rig,
        options: &Options,
        assets: &dyn Assets,
        files: OpenEvents,
    ) -> Result<Self, Problems> {
        let scene = scene(patch, rig, options, assets)?;
        let told = |problem: Problem| patch.origin.problems(vec![problem]);
        let mut engine = Engine::new(&scene.plan).map_err(|r| told(Problem::of_file(r.to_string())))?;
        let callings = Callings::of(&scene.plan);
        let (shared, rig) = (Arc::new(patch.clone()), Arc::new(rig.clone()));
        let mut performer = Performer::new(scene, shared, rig, files).map_err(told)?;
        performer.begin(&mut engine).map_err(told)?;
        Ok(Self { engine, performer, callings })
    }

    /// The engine.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// What the engine runs.
    pub fn plan(&self) -> &Plan {
        self.performer.plan()
    }

    /// What happened so far.
    pub fn counters(&self) -> Counters {
        self.engine.counters()
    }

    /// Seconds computed so far.
    pub fn seconds(&self) -> f64 {
        self.engine.clock() as f64 / self.plan().engine_rate()
    }

    /// Seconds until the last event of the patterns has ended, where that is known beforehand.
    pub fn length(&self) -> Option<f64> {
        self.performer.length()
    }

    /// Whether something of the patterns was left out so far because it lies past [`crate::score::HORIZON`].
    pub fn is_cut(&self) -> bool {
        self.performer.is_cut()
    }

    /// Whether the patterns have ended and nothing sounds or rings any more.
    pub fn is_over(&self) -> bool {
        self.performer.is_over() && self.engine.is_silent()
    }

    /// Plays messages of MIDI, each at its time in seconds from the beginning, in order of time, through the triggers and bindings of
    /// the patch; `seconds` is when the song ends and what keys still hold is let go.
    pub fn play_song(&mut self, messages: impl IntoIterator<Item = (f64, Message)>, seconds: f64) {
        self.performer.play_song(messages, seconds);
    }

    /// What of the messages of MIDI could not be used.
    pub fn midi_counts(&self) -> MidiCounts {
        self.performer.midi_counts()
    }

    /// The tempo of a song counts the beats of patterns with clock = "midi", from its beginning to its end: `tempi` are the seconds at which
    /// it changes and what to, in beats a minute, as [`crate::midi::file`] has them.
    ///
    /// # Errors
    /// What is wrong with the patterns that play from the beginning.
    pub fn follow_song(&mut self, tempi: &[(f64, f64)], seconds: f64) -> Result<(), Problem> {
        self.performer.follow_song(tempi, seconds)
    }

    /// What stopped a pattern before its end, if something did: an events file with a bad line. Of several the first; others go on.
    pub fn trouble(&self) -> Option<&Problem> {
        self.performer.trouble()
    }

    /// Keeps what is played from now on, in seconds, for a reference. What signals set off is not kept: whoever plays the plan again sets
    /// it off again.
    pub fn record(&mut self) {
        self.performer.record();
    }

    /// What was played since [`Player::record`].
    pub fn recorded(&self) -> &[(f64, Play)] {
        self.performer.recorded()
    }

    /// How that was moved while it sounded, in seconds.
    pub fn recorded_moves(&self) -> &[(f64, Move)] {
        self.performer.recorded_moves()
    }

    /// Tells `listener` of every event from now on, as it is given to the engine, and of those that were played at the
    /// beginning if nothing was computed yet. Voices that are always on are no events.
    pub fn listen(&mut self, listener: Listener) {
        self.performer.listen(listener);
    }

    /// Plays a voice now. Gives an id to release it by.
    ///
    /// # Errors
    /// A voice that the patch does not have or the plan left out, a field it does not declare, a place the rig does not have,
    /// a number that is not finite, a time before the beginning or past [`crate::score::HORIZON`], or no room in the engine's
    /// queue.
    pub fn play(&mut self, voice: &str, note: &Note) -> Result<u64, Problem> {
        let now = self.now();
        self.performer.play(now, voice, note, &mut self.engine)
    }

    /// Plays a voice `at` seconds from the beginning.
    ///
    /// # Errors
    /// As [`Player::play`].
    pub fn play_at(&mut self, at: f64, voice: &str, note: &Note) -> Result<u64, Problem> {
        let at = When::of_seconds(at, self.plan().engine_rate());
        self.performer.play(at, voice, note, &mut self.engine)
    }

    /// The next sample to be computed.
    fn now(&self) -> When {
        When::of_sample(self.engine.clock(), self.plan().engine_rate())
    }

    /// Releases what was played under an id, now.
    pub fn release(&mut self, id: u64) {
        let now = self.now();
        self.performer.release(now, id, &mut self.engine);
    }

    /// Releases every voice that sounds now, held and always-on ones too: each falls silent by its own release, and one without
    /// an envelope within 4 ms. The patterns go on, so what they play later sounds.
    pub fn release_all(&mut self) {
        let now = self.now();
        self.performer.release_all(now, &mut self.engine);
    }

    /// Moves the hand that holds what was played under an id, now; see [`Touch`].
    ///
    /// # Errors
    /// A value that is not finite, or no room in the engine's queue.
    pub fn touch(&mut self, id: u64, touch: Touch) -> Result<(), Problem> {
        let now = self.now();
        self.performer.touch(now, id, touch, &mut self.engine)
    }

    /// The same, `at` seconds from the beginning.
    ///
    /// # Errors
    /// As [`Player::touch`], or a time that cannot be.
    pub fn touch_at(&mut self, at: f64, id: u64, touch: Touch) -> Result<(), Problem> {
        let at = When::of_seconds(at, self.plan().engine_rate());
        self.performer.touch(at, id, touch, &mut self.engine)
    }

    /// Sends a control to a value, now; it arrives after its smoothing. The control's range holds.
    ///
    /// # Errors
    /// A control that the patch does not have, a value that is not finite, or no room in the engine's queue.
    pub fn set(&mut self, control: &str, value: f64) -> Result<(), Problem> {
        let now = self.now();
        self.performer.set(now, control, value, &mut self.engine)
    }

    /// Sends a control to a value in a straight line, from `at` seconds on and within so many seconds. The control's range holds.
    ///
    /// # Errors
    /// As [`Player::set`], or a time that cannot be.
    pub fn glide_at(&mut self, at: f64, control: &str, value: f64, seconds: f64) -> Result<(), Problem> {
        let index = self.plan().control(control)?;
        let fine = at.is_finite() && at >= 0.0 && value.is_finite() && seconds >= 0.0;
        if !fine {
            let what = format!("control `{control}` cannot go to {value} in {seconds} s from {at} s on");
            return Err(Problem::of_file(what).help("give finite numbers, times from 0 on".to_string()));
        }
        let at = When::of_seconds(at, self.plan().engine_rate()).instant;
        let taken = self.engine.schedule(at, Source::Program, Event::Glide(index, value, seconds));
        let full = || Problem::of_file("no room for more events").help("play what waits first".to_string());
        taken.then_some(()).ok_or_else(full)
    }

    /// Lets a hand push the simulated knob with a torque (N m) from `at` seconds on. Says whether there was room in the engine's queue.
    pub fn push_at(&mut self, at: f64, torque: f64) -> bool {
        let at = When::of_seconds(at, self.plan().engine_rate());
        self.engine.schedule(at.instant, Source::Program, Event::Push(torque))
    }

    /// Lets torque of the knob rise from 0, after a fault as well, or lets it go at once. Says whether there was room in the engine's queue.
    pub fn arm(&mut self, arms: bool) -> bool {
        let now = Instant { sample: self.engine.clock(), fraction: 0 };
        self.engine.schedule(now, Source::Program, Event::Arm(arms))
    }

    /// An end by which a slow thread sends local models to the knob and sees it; `None` where the patch has none.
    pub fn link_knob(&mut self) -> Option<Slow> {
        self.engine.link_knob()
    }

    /// The knob, if the patch has one.
    pub fn knob(&self) -> Option<&Knob> {
        self.engine.knob()
    }

    /// Fills `output`, interleaved frames of all channels.
    pub fn process(&mut self, output: &mut [f32]) {
        self.process_input(&[], output);
    }

    /// As [`Player::process`], with what came in during the same frames: interleaved frames of [`Engine::input_channels`]. Missing
    /// frames count as silence.
    pub fn process_input(&mut self, input: &[f32], output: &mut [f32]) {
        let ratio = self.plan().ratio;
        stretch::play(self, ratio, input, output);
        self.tell_crossings();
    }

    /// Tells of what signals have set off, and starts patterns for it.
    fn tell_crossings(&mut self) {
        for crossing in self.engine.crossings() {
            self.performer.cross(&self.callings, &crossing);
        }
    }
}

impl stretch::Feeds for Player {
    fn engine(&mut self) -> &mut Engine {
        &mut self.engine
    }

    fn most(&self) -> usize {
        match self.callings.has_patterns() {
            // What nodes have seen is set off some samples later, and the engine is fed some ahead.
            true => self.plan().answer.saturating_sub(LATENCY + 4).max(1) as usize,
            false => usize::MAX,
        }
    }

    fn feed(&mut self, until: u64) -> Option<u64> {
        self.tell_crossings();
        self.performer.feed(until, &mut self.engine)
    }
}
