//! A patch on a rig, playing: the engine together with the patterns that feed it.

mod heard;
pub(crate) mod stretch;

use std::collections::HashMap;
use std::sync::Arc;

use crate::engine::Counters;
use crate::engine::Engine;
use crate::engine::event::{Event, Play, Source};
use crate::graph::plan::Plan;
use crate::graph::scene::{Options, Scene, scene};
use crate::node::asset::Assets;
use crate::patch::{Patch, Place};
use crate::rig::{Finder, Rig};
use crate::schedule::Instant;
use crate::score::{EventStream, HORIZON, Score, Timed, What};
use crate::text::{Problem, Problems};

pub use heard::{Happening, Heard, Listener, Origin};

/// Opens events files for the score, by their path as written in the patch.
pub type OpenEvents = Box<dyn FnMut(&str) -> Result<EventStream<'static>, Problem> + Send>;

/// A patch on a rig, playing.
///
/// It unrolls patterns as it goes, which may allocate and read files; [`Engine::process`] alone is fit for an audio callback.
pub struct Player {
    engine: Engine,
    plan: Plan,
    patch: Arc<Patch>,
    rig: Arc<Rig>,
    finder: Arc<Finder>,
    instruments: Vec<Option<u32>>,
    /// Places of voices in the patch: by name, and by instrument.
    voices: HashMap<String, usize>,
    voice_of: Vec<usize>,
    score: Score<'static>,
    ahead: Option<Timed>,
    over: bool,
    trouble: Option<Problem>,
    played: u64,
    record: Option<Vec<(f64, Play)>>,
    listener: Option<Listener>,
    /// What was played before anything was computed, for a listener who comes then.
    first: Vec<(f64, Play)>,
}

/// Voices that the program plays have ids from here on, so that they share no random numbers with those of patterns.
const PROGRAM: u64 = 1 << 62;

/// Room in the engine's queue that patterns leave, so that the program can always release and set something.
const FOR_PROGRAM: usize = 1024;

/// Room that what the program plays leaves, so that it never keeps patterns waiting.
const FOR_PATTERNS: usize = 2 * FOR_PROGRAM;

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
        let Scene { plan, patterns, instruments } = scene(patch, rig, options, assets)?;
        let (patch, rig) = (Arc::new(patch.clone()), Arc::new(rig.clone()));
        // Where two voices share a name, the first has it.
        let voices = patch.voices.iter().enumerate().rev().map(|(i, v)| (v.name.clone(), i)).collect();
        let mut voice_of = vec![usize::MAX; plan.instruments.len()];
        for (voice, instrument) in instruments.iter().enumerate() {
            if let Some(slot) = instrument.and_then(|i| voice_of.get_mut(i as usize)) {
                *slot = voice;
            }
        }
        let roots: Vec<(usize, f64)> = patterns.iter().map(|&p| (p, 0.0)).collect();
        let finder = Arc::new(Finder::new(&rig));
        let (of_rig, found) = (Arc::clone(&rig), Arc::clone(&finder));
        let places = move |place: Option<&Place>| of_rig.resolve_by(&found, place, &(0..0)).map(|i| i as u32);
        let score = Score::new(&patch, places, &roots, plan.seed, files)
            .map_err(|p| patch.origin.problems(vec![p]))?;
        let mut player = Self {
            engine: Engine::new(&plan)
                .map_err(|r| patch.origin.problems(vec![Problem::of_file(r.to_string())]))?,
            plan,
            patch,
            rig,
            finder,
            instruments,
            voices,
            voice_of,
            score,
            ahead: None,
            over: false,
            trouble: None,
            played: 0,
            record: None,
            listener: None,
            first: Vec::new(),
        };
        player.start().map_err(|p| player.patch.origin.problems(vec![p]))?;
        Ok(player)
    }

    /// Voices with a trigger `start` sound at the beginning.
    fn start(&mut self) -> Result<(), Problem> {
        let patch = Arc::clone(&self.patch);
        for trigger in patch.triggers.iter().filter(|t| t.on == crate::patch::Source::Start) {
            if self.voices.contains_key(&trigger.play) {
                let mut note = Note { place: trigger.place.clone(), ..Note::default() };
                for (field, expr, span) in &trigger.set {
                    let value = expr.constant().ok_or_else(|| {
                        let what = format!("`{field}` must be a number: `start` gives nothing to read");
                        Problem::error(span, what)
                    })?;
                    match field.as_str() {
                        "level" => note.level = Some(value),
                        "duration" => note.duration = Some(value),
                        _ => note.fields.push((field.clone(), value)),
                    }
                }
                self.play_at(0.0, &trigger.play, &note)
                    .map_err(|problem| Problem { span: Some(trigger.span.clone()), ..problem })?;
            }
        }
        Ok(())
    }

    /// The engine.
    pub fn engine(&self) -> &Engine {
        &self.engine
    }

    /// What the engine runs.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// What happened so far.
    pub fn counters(&self) -> Counters {
        self.engine.counters()
    }

    /// Seconds computed so far.
    pub fn seconds(&self) -> f64 {
        self.engine.clock() as f64 / self.plan.engine_rate()
    }

    /// Seconds until the last event of the patterns has ended, where that is known beforehand.
    pub fn length(&self) -> Option<f64> {
        self.score.length()
    }

    /// Whether something of the patterns was left out so far because it lies past [`crate::score::HORIZON`].
    pub fn is_cut(&self) -> bool {
        self.score.cut()
    }

    /// Whether the patterns have ended and nothing sounds or rings any more.
    pub fn is_over(&self) -> bool {
        self.over && self.engine.is_silent()
    }

    /// What stopped the patterns before their end, if something did: an events file with a bad line.
    pub fn trouble(&self) -> Option<&Problem> {
        self.trouble.as_ref()
    }

    /// Keeps what is played from now on, in seconds, for a reference.
    pub fn record(&mut self) {
        self.record.get_or_insert_default();
    }

    /// What was played since [`Player::record`].
    pub fn recorded(&self) -> &[(f64, Play)] {
        self.record.as_deref().unwrap_or_default()
    }

    /// Tells `listener` of every event from now on, as it is given to the engine, and of those that were played at the
    /// beginning if nothing was computed yet. Voices that are always on are no events.
    pub fn listen(&mut self, listener: Listener) {
        self.listener = Some(listener);
        for (at, play) in std::mem::take(&mut self.first) {
            self.tell_play(at, None, &play);
        }
    }

    /// Plays a voice now. Gives an id to release it by.
    ///
    /// # Errors
    /// A voice that the patch does not have or the plan left out, a field it does not declare, a place the rig does not have,
    /// a number that is not finite, a time before the beginning or past [`crate::score::HORIZON`], or no room in the engine's
    /// queue.
    pub fn play(&mut self, voice: &str, note: &Note) -> Result<u64, Problem> {
        self.play_at(self.seconds(), voice, note)
    }

    /// Plays a voice `at` seconds from the beginning.
    ///
    /// # Errors
    /// As [`Player::play`].
    pub fn play_at(&mut self, at: f64, voice: &str, note: &Note) -> Result<u64, Problem> {
        if !(0.0..=HORIZON).contains(&at) {
            let what = format!("nothing can be played at {at} s");
            let help = format!("give the seconds from the beginning, 0 to {HORIZON}");
            return Err(Problem::of_file(what).help(help));
        }
        let patch = Arc::clone(&self.patch);
        let index = self.voices.get(voice).copied();
        let Some((index, instrument)) = index.and_then(|v| Some((v, self.instruments[v]?))) else {
            // Of a name that the patch does not have either, the plan says which are near.
            self.plan.play(voice, &[]).map_err(|problem| match index {
                Some(_) => Problem::of_file(format!("voice `{voice}` was left out, since nothing starts it"))
                    .help("compile it with `live`".to_string()),
                None => problem,
            })?;
            return Err(Problem::of_file(format!("voice `{voice}` cannot be played")));
        };
        let voice = &patch.voices[index];
        let (level, duration) = (note.level.unwrap_or(voice.level), note.duration.unwrap_or(voice.duration));
        let mut fields = vec![("level", level), ("duration", duration)];
        fields.extend(note.fields.iter().map(|(name, value)| (name.as_str(), *value)));
        let own = self.plan.play(&voice.name, &fields)?.own;
        let place = note.place.as_ref().or(voice.place.as_ref());
        let place = self.rig.resolve_by(&self.finder, place, &(0..0))? as u32;
        if self.engine.room() <= FOR_PATTERNS {
            return Err(Problem::of_file("the engine's queue is full; play less at once"));
        }
        self.played += 1;
        let id = PROGRAM + self.played;
        let play = Play { instrument, place, level, duration, own, id };
        if self.send(at, Source::Program, play) {
            self.tell_play(at, None, &play);
            Ok(id)
        } else {
            Err(Problem::of_file("the engine's queue is full; play less at once"))
        }
    }

    /// Releases what was played under an id, now.
    pub fn release(&mut self, id: u64) {
        let now = Instant { sample: self.engine.clock(), fraction: 0 };
        if self.engine.schedule(now, Source::Program, Event::Release(id)) {
            self.tell(self.seconds(), now, None, Some(id), Happening::Release);
        }
    }

    /// Releases every voice that sounds now, held and always-on ones too: each falls silent by its own release, and one without
    /// an envelope within 4 ms. The patterns go on, so what they play later sounds.
    pub fn release_all(&mut self) {
        let now = Instant { sample: self.engine.clock(), fraction: 0 };
        if self.engine.schedule(now, Source::Program, Event::ReleaseAll) {
            self.tell(self.seconds(), now, None, None, Happening::ReleaseAll);
        }
    }

    /// Sends a control to a value, now; it arrives after its smoothing. The control's range holds.
    ///
    /// # Errors
    /// A control that the patch does not have or that nothing reads, a value that is not finite, or no room in the engine's queue.
    pub fn set(&mut self, control: &str, value: f64) -> Result<(), Problem> {
        let index = self.plan.control(control)?;
        if !value.is_finite() {
            let what = format!("control `{control}` cannot be set to {value}");
            return Err(Problem::of_file(what).help("give a finite number".to_string()));
        }
        let now = Instant { sample: self.engine.clock(), fraction: 0 };
        if !self.engine.schedule(now, Source::Program, Event::Control(index, value)) {
            return Err(Problem::of_file("the engine's queue is full; compute some frames first"));
        }
        self.tell(self.seconds(), now, None, None, Happening::Control(control, value));
        Ok(())
    }

    /// Fills `output`, interleaved frames of all channels.
    pub fn process(&mut self, output: &mut [f32]) {
        self.process_input(&[], output);
    }

    /// As [`Player::process`], with what came in during the same frames: interleaved frames of [`Engine::input_channels`]. Missing
    /// frames count as silence.
    pub fn process_input(&mut self, input: &[f32], output: &mut [f32]) {
        let ratio = self.plan.ratio;
        stretch::play(self, ratio, input, output);
    }

    /// Gives the engine all events before engine sample `until`, as long as it has room. Where it has not, the sample with which
    /// the first event takes effect that did not find any.
    fn feed_before(&mut self, until: u64) -> Option<u64> {
        let until = until as f64 / self.plan.engine_rate();
        while !self.over {
            let next = match self.ahead.take().map(Ok).or_else(|| self.score.next()) {
                Some(Ok(next)) => next,
                Some(Err(problem)) => {
                    self.trouble = Some(problem);
                    self.over = true;
                    return None;
                }
                None => {
                    self.over = true;
                    return None;
                }
            };
            if next.at >= until {
                self.ahead = Some(next);
                return None;
            }
            if self.engine.room() <= FOR_PROGRAM {
                let at = Instant::of_samples(next.at * self.plan.engine_rate());
                self.ahead = Some(next);
                return Some(at.ceiling());
            }
            match next.what {
                What::Play(note) => {
                    let Some(instrument) = self.instruments[note.voice] else { continue };
                    let (place, level, duration, own) = (note.place, note.level, note.duration, note.own);
                    let play = Play { instrument, place, level, duration, own, id: next.id };
                    if self.send(next.at, Source::Pattern, play) {
                        let from = Stand { pattern: next.pattern, event: next.event, drawn: next.drawn };
                        self.tell_play(next.at, Some(from), &play);
                    }
                }
                What::Marker(name) => {
                    let number =
                        self.plan.markers.iter().position(|m| *m == name).map_or(u32::MAX, |i| i as u32);
                    let at = Instant::of_samples(next.at * self.plan.engine_rate());
                    if self.engine.schedule(at, Source::Pattern, Event::Marker(number)) {
                        let from = Stand { pattern: next.pattern, event: next.event, drawn: next.drawn };
                        self.tell(next.at, at, Some(from), Some(next.id), Happening::Marker(&name));
                    }
                }
            }
        }
        None
    }

    fn send(&mut self, at: f64, source: Source, play: Play) -> bool {
        let taken = self.engine.schedule(
            Instant::of_samples(at * self.plan.engine_rate()),
            source,
            Event::Play(play),
        );
        if let Some(record) = self.record.as_mut().filter(|_| taken) {
            record.push((at, play));
        }
        taken
    }

    /// Tells the listener of a voice.
    fn tell_play(&mut self, at: f64, from: Option<Stand>, play: &Play) {
        if self.listener.is_none() {
            if self.engine.clock() == 0 && from.is_none() {
                self.first.push((at, *play));
            }
            return;
        }
        let instant = Instant::of_samples(at * self.plan.engine_rate());
        let patch = Arc::clone(&self.patch);
        let rig = Arc::clone(&self.rig);
        let voice = self.voice_of.get(play.instrument as usize);
        let Some(voice) = voice.and_then(|voice| patch.voices.get(*voice)) else { return };
        let what = Happening::Voice {
            name: &voice.name,
            place: rig.outputs.get(play.place as usize).map_or("", |output| &output.name),
            level: play.level,
            duration: play.duration,
            fields: &voice.fields,
            own: &play.own,
        };
        self.tell(at, instant, from, Some(play.id), what);
    }

    /// Tells the listener of anything.
    fn tell(&mut self, at: f64, instant: Instant, from: Option<Stand>, id: Option<u64>, what: Happening<'_>) {
        let Some(listener) = &mut self.listener else { return };
        let origin = from.map(|Stand { pattern, event, drawn }| Origin {
            pattern: self.patch.patterns.get(pattern).map_or("", |p| &p.name),
            event,
            drawn,
        });
        listener(&Heard { at, instant, origin, id, what });
    }
}

impl stretch::Feeds for Player {
    fn engine(&mut self) -> &mut Engine {
        &mut self.engine
    }

    fn feed(&mut self, until: u64) -> Option<u64> {
        self.feed_before(until)
    }
}

/// Where in the patterns an event stands: pattern, event and alternative, by number.
#[derive(Debug, Clone, Copy)]
struct Stand {
    pattern: usize,
    event: u64,
    drawn: Option<u32>,
}

/// What a program may say about a voice that it plays; what it does not say is as the voice has it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Note {
    /// Share of the rated vibration.
    pub level: Option<f64>,
    /// Seconds until the release; infinite to hold it.
    pub duration: Option<f64>,
    /// Where.
    pub place: Option<Place>,
    /// Fields that the voice declares, `frequency` among them.
    pub fields: Vec<(String, f64)>,
}
