//! Who plays a patch: patterns and what the program asks for become events of the engine.
//!
//! A performer has no engine. It gives its events to an [`Outlet`], which may be an engine at once ([`crate::player`]) or a ring that
//! leads to one in another thread. It may allocate and read files.

mod beats;
mod bindings;
mod clocked;
mod crossed;
mod hands;
mod heard;
mod here;
mod letting;
mod note;
pub(crate) mod outlet;
mod patterns;
mod pickup;
mod run;
#[cfg(test)]
mod staged;
mod stopping;
mod stream;
mod succession;
mod touch;
mod when;
mod whence;

use std::collections::{BTreeMap, BTreeSet, HashMap, VecDeque};
use std::sync::{Arc, Mutex, PoisonError};

use crate::dsp::random;
use crate::engine::event::{Event, Move, Play, Source};
use crate::graph::plan::Plan;
use crate::graph::scene::Scene;
use crate::midi::Message;
use crate::patch::{Patch, Voice};
use crate::rig::{Finder, Rig};
use crate::score::{EventStream, HORIZON, Root, Score};
use crate::text::Problem;

use bindings::Mind;
use clocked::Clocked;
pub use crossed::Callings;
use crossed::Crossed;
use hands::Hands;
pub use hands::{MidiCounts, PORTS};
pub use heard::{Happening, Heard, Listener, Origin};
use here::Here;
pub use note::Note;
pub use outlet::Outlet;
pub use patterns::MOST_RUNS;
use pickup::Pickups;
use run::Run;
use stopping::{Sent, Stop};
use stream::Stream;
pub use touch::Touch;
pub use when::When;
use whence::Whence;

/// Opens events files for the score, by their path as written in the patch.
pub type OpenEvents = Box<dyn FnMut(&str) -> Result<EventStream<'static>, Problem> + Send>;

/// Plays a patch on a rig.
pub struct Performer {
    plan: Plan,
    patch: Arc<Patch>,
    rig: Arc<Rig>,
    finder: Arc<Finder>,
    instruments: Vec<Option<u32>>,
    /// Places of voices in the patch: by name, and by instrument.
    voices: HashMap<String, usize>,
    voice_of: Vec<usize>,
    /// By the patch's voice: whether it reads the frequency of its event.
    pitched: Vec<bool>,
    /// By instrument: which motions it hears.
    hears: Vec<[bool; 3]>,
    files: Arc<Mutex<OpenEvents>>,
    runs: Vec<Run>,
    /// What plays from the beginning by its own count, by its place in the patch.
    roots: Vec<usize>,
    /// Which of those were stopped, by their names.
    stopped: BTreeSet<String>,
    clocked: Clocked,
    length: Option<f64>,
    cut: bool,
    trouble: Option<Problem>,
    /// What has kept patterns from going on and is yet to be told.
    troubles: Vec<(Problem, u64)>,
    met: Option<Problem>,
    /// What the program played, and patterns it started, and those that too many others kept from it.
    played: u64,
    started: u64,
    turned_away: u64,
    /// Patterns without end that triggers have started, other than keys that hold them: by their names, the serial number.
    endless: BTreeMap<String, u64>,
    /// Which voices that are always on were let go of, by their names.
    asleep: BTreeSet<String>,
    /// The signal that is done now; 0 for none.
    cause: u64,
    /// What lets go and found no room.
    owed: VecDeque<Event>,
    /// Patterns that were set off in the engine and have not begun yet, and how many have.
    crossed: Vec<Crossed>,
    crossings: u64,
    /// What is to stop when it has been fed so far.
    stops: Vec<Stop>,
    /// What the patterns of the beginning have sent and is not over yet.
    ahead: VecDeque<Sent>,
    /// Whether a control was sent somewhere since this was asked last.
    moved: bool,
    /// One for each port of MIDI.
    hands: Vec<Hands>,
    /// Messages that are played from a file, in order of time; `None` lets go of all keys.
    song: VecDeque<(f64, Option<Message>)>,
    /// How many of them were played.
    sung: u64,
    /// What moves controls now.
    mind: Mind,
    /// By binding.
    pickups: Vec<Pickups>,
    /// Where each control of the patch was sent last.
    targets: Vec<f64>,
    /// Of those that are streams.
    streams: Vec<Option<Stream>>,
    record: Option<Vec<(f64, Play)>>,
    moves: Option<Vec<(f64, Move)>>,
    listener: Option<Listener>,
    /// What was played before anything was computed, for a listener who comes then.
    first: Vec<(When, Play)>,
    /// Seconds up to which patterns have been fed.
    fed: f64,
    /// Where the engine stood when it was fed last, seconds.
    clock: f64,
    /// Seconds after which what plays from the beginning begins.
    lead: f64,
}

/// What stopped patterns is kept of so many until somebody asks.
const MOST_TROUBLES: usize = 256;

impl Performer {
    /// For a patch compiled for a rig. What plays from the beginning is ready to be fed.
    ///
    /// # Errors
    /// What is wrong with the patterns that play from the beginning.
    pub fn new(scene: Scene, patch: Arc<Patch>, rig: Arc<Rig>, files: OpenEvents) -> Result<Self, Problem> {
        let mut performer = Self::bare(scene, patch, rig, files);
        performer.lead_in(0.0)?;
        Ok(performer)
    }

    /// What plays from the beginning, patterns, triggers and a song, begins so many seconds after the engine; voices that are always on
    /// do not wait. Before anything is fed.
    ///
    /// # Errors
    /// As [`Performer::new`].
    pub fn lead_in(&mut self, seconds: f64) -> Result<(), Problem> {
        self.lead = seconds;
        self.begin_anew()
    }

    /// What plays from the beginning begins there.
    fn begin_anew(&mut self) -> Result<(), Problem> {
        let run = self.beginning()?;
        self.length = run.length();
        self.runs.retain(|run| run.serial != 0);
        self.runs.push(run);
        Ok(())
    }

    /// What plays from the beginning.
    fn beginning(&self) -> Result<Run, Problem> {
        let roots: Vec<Root> = self.roots.iter().map(|&p| Root::at(p, self.lead)).collect();
        let score = self.score(&roots, self.plan.seed)?;
        Ok(Run::new(0, roots, score))
    }

    /// Without anything that plays.
    fn bare(scene: Scene, patch: Arc<Patch>, rig: Arc<Rig>, files: OpenEvents) -> Self {
        let Scene { plan, instruments, patterns: roots } = scene;
        // Where two voices share a name, the first has it.
        let voices = patch.voices.iter().enumerate().rev().map(|(i, v)| (v.name.clone(), i)).collect();
        let mut voice_of = vec![usize::MAX; plan.instruments.len()];
        for (voice, instrument) in instruments.iter().enumerate() {
            if let Some(slot) = instrument.and_then(|i| voice_of.get_mut(i as usize)) {
                *slot = voice;
            }
        }
        let finder = Arc::new(Finder::with(&rig, &patch));
        let hears = touch::heard(&plan);
        let targets = patch.controls.iter().map(|control| control.default).collect();
        let stream = |seconds: f64| (seconds > 0.0).then(|| Stream::new(seconds));
        let streams = patch.controls.iter().map(|control| stream(control.stream)).collect();
        let pickups = vec![Pickups::default(); patch.binds.len()];
        let pitched = patch.voices.iter().map(Voice::reads_frequency).collect();
        Self {
            plan,
            patch,
            rig,
            finder,
            instruments,
            voices,
            voice_of,
            pitched,
            hears,
            files: Arc::new(Mutex::new(files)),
            runs: Vec::new(),
            roots,
            stopped: BTreeSet::new(),
            clocked: Clocked::default(),
            length: Some(0.0),
            cut: false,
            trouble: None,
            troubles: Vec::new(),
            met: None,
            played: 0,
            started: 0,
            turned_away: 0,
            endless: BTreeMap::new(),
            asleep: BTreeSet::new(),
            cause: 0,
            owed: VecDeque::new(),
            crossed: Vec::new(),
            crossings: 0,
            stops: Vec::new(),
            ahead: VecDeque::new(),
            moved: true,
            hands: Vec::new(),
            song: VecDeque::new(),
            sung: 0,
            mind: Mind::Hand,
            pickups,
            targets,
            streams,
            record: None,
            moves: None,
            listener: None,
            first: Vec::new(),
            fed: 0.0,
            clock: 0.0,
            lead: 0.0,
        }
    }

    fn score(&self, roots: &[Root], seed: u64) -> Result<Score<'static>, Problem> {
        let (rig, finder) = (Arc::clone(&self.rig), Arc::clone(&self.finder));
        let places = Here { rig, finder, spread: self.plan.spread.clone() };
        let files = Arc::clone(&self.files);
        // Whoever panicked while a file was opened has left nothing half-done here.
        let open = move |path: &str| (files.lock().unwrap_or_else(PoisonError::into_inner))(path);
        Score::of(&self.patch, places, roots, seed, open)
    }

    /// The seed of what is drawn in a pattern that was started.
    fn seed_of(&self, serial: u64) -> u64 {
        random::stream(self.plan.seed, serial, 0)
    }

    /// Voices with a trigger `start` sound at the beginning.
    ///
    /// # Errors
    /// What a trigger sets that cannot be.
    pub fn begin(&mut self, outlet: &mut dyn Outlet) -> Result<(), Problem> {
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
                        "felt" => note.felt = Some(value),
                        "duration" => note.duration = Some(value),
                        _ => note.fields.push((field.clone(), value)),
                    }
                }
                self.play(self.when(self.lead), &trigger.play, &note, outlet)
                    .map_err(|problem| Problem { span: Some(trigger.span.clone()), ..problem })?;
            }
        }
        Ok(())
    }

    /// What the engine runs.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The patch.
    pub fn patch(&self) -> &Arc<Patch> {
        &self.patch
    }

    /// Seconds until the last event of what plays from the beginning has ended, where that is known beforehand.
    pub fn length(&self) -> Option<f64> {
        self.length
    }

    /// Whether something of the patterns was left out so far because it lies past [`HORIZON`].
    pub fn is_cut(&self) -> bool {
        self.cut || self.runs.iter().any(Run::is_cut)
    }

    /// Whether all patterns have ended, and a song if there is one.
    pub fn is_over(&self) -> bool {
        self.runs.iter().all(Run::is_over)
            && self.crossed.is_empty()
            && self.song.is_empty()
            && self.clocked.begin.is_none()
    }

    /// Plays messages of MIDI, each at its time in seconds from the beginning, in order of time.
    pub fn play_song(&mut self, messages: impl IntoIterator<Item = (f64, Message)>, seconds: f64) {
        let lead = self.lead;
        self.song.extend(messages.into_iter().map(|(at, message)| (lead + at, Some(message))));
        self.song.push_back((lead + seconds, None));
        self.length = self.length.map(|length| length.max(lead + seconds));
    }

    /// What stopped a pattern before its end, if something did: an events file with a bad line. Of several the first; others go on.
    pub fn trouble(&self) -> Option<&Problem> {
        self.trouble.as_ref()
    }

    /// What stopped patterns since this was asked last.
    pub fn take_troubles(&mut self) -> Vec<(Problem, u64)> {
        std::mem::take(&mut self.troubles)
    }

    /// Something stops a pattern before its end.
    fn meet(&mut self, problem: Problem) {
        // What happens again and again is told once.
        if self.troubles.len() < MOST_TROUBLES && self.met.as_ref() != Some(&problem) {
            self.troubles.push((problem.clone(), self.cause));
        }
        self.trouble.get_or_insert_with(|| problem.clone());
        self.met = Some(problem);
    }

    /// Keeps what is played from now on, in seconds, for a reference.
    pub fn record(&mut self) {
        self.record.get_or_insert_default();
        self.moves.get_or_insert_default();
    }

    /// What was played since [`Performer::record`].
    pub fn recorded(&self) -> &[(f64, Play)] {
        self.record.as_deref().unwrap_or_default()
    }

    /// Tells `listener` of every event from now on, as it is given to the outlet, and of those that were played at the
    /// beginning if nothing was fed yet. Voices that are always on are no events.
    pub fn listen(&mut self, listener: Listener) {
        self.listener = Some(listener);
        for (at, play) in std::mem::take(&mut self.first) {
            self.tell_play(at, None, &play);
        }
    }

    /// Plays a voice. Gives an id to release it by.
    ///
    /// # Errors
    /// A voice that the patch does not have or the plan left out, a field it does not declare, a place the rig does not have,
    /// a number that is not finite, a time before the beginning or past [`HORIZON`], or no room at the outlet.
    pub fn play(
        &mut self,
        at: When,
        voice: &str,
        note: &Note,
        outlet: &mut dyn Outlet,
    ) -> Result<u64, Problem> {
        self.play_by(at, voice, note, Whence::HERE, outlet)
    }

    /// Seconds until a voice that is played so is released; infinite where somebody has to.
    pub fn lasts(&self, voice: &str, note: &Note) -> f64 {
        let own = || {
            self.voices.get(voice).and_then(|voice| self.patch.voices.get(*voice)).map(|voice| voice.duration)
        };
        note.duration.or_else(own).unwrap_or(f64::INFINITY)
    }

    /// The same for somebody.
    fn play_by(
        &mut self,
        at: When,
        voice: &str,
        note: &Note,
        whence: Whence,
        outlet: &mut dyn Outlet,
    ) -> Result<u64, Problem> {
        in_time(at)?;
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
        if note.level.is_some() && note.felt.is_some() {
            let what = format!("voice `{}` cannot be played with `level` and `felt` at once", voice.name);
            return Err(Problem::of_file(what).help("leave one of them out".to_string()));
        }
        let ((level, felt), duration) =
            (voice.strength(note.level, note.felt), note.duration.unwrap_or(voice.duration));
        let mut fields = vec![("level", level), ("duration", duration)];
        fields.extend(note.felt.map(|felt| ("felt", felt)));
        fields.extend(note.fields.iter().map(|(name, value)| (name.as_str(), *value)));
        let own = self.plan.play(&voice.name, &fields)?.own;
        let place = note.place.as_ref().or(voice.place.as_ref());
        let place = self.rig.resolve_by(&self.finder, place, &(0..0))?;
        let id = whence.voice(self.played + 1);
        let play = Play { instrument, place, level, felt, duration, own, id };
        self.plan.check_felt(&play)?;
        if outlet.room(Source::Program) == 0 || !self.send(at, Source::Program, play, outlet) {
            return Err(full());
        }
        self.played += 1;
        if self.listener.is_none() && outlet.clock() == 0 {
            self.first.push((at, play));
        }
        self.tell_play(at, None, &play);
        Ok(id)
    }

    /// Sends a control to a value; it arrives after its smoothing. The control's range holds.
    ///
    /// # Errors
    /// A control that the patch does not have, a value that is not finite, or no room at the outlet.
    pub fn set(
        &mut self,
        at: When,
        control: &str,
        value: f64,
        outlet: &mut dyn Outlet,
    ) -> Result<(), Problem> {
        self.set_by(at, at, control, value, outlet)
    }

    /// The same of a value of `at`, which came so late that nothing before `now` can be changed any more: a stream still reaches it at its time.
    ///
    /// # Errors
    /// As [`Performer::set`].
    pub fn set_by(
        &mut self,
        at: When,
        now: When,
        control: &str,
        value: f64,
        outlet: &mut dyn Outlet,
    ) -> Result<(), Problem> {
        let number = self.patch.controls.iter().position(|c| c.name == control);
        let index = match self.plan.control(control) {
            Ok(index) => Some(index),
            // Nothing reads it, but it stands somewhere all the same.
            Err(_) if number.is_some() => None,
            Err(unknown) => return Err(unknown),
        };
        if !value.is_finite() {
            let what = format!("control `{control}` cannot be set to {value}");
            return Err(Problem::of_file(what).help("give a finite number".to_string()));
        }
        let stream = number.and_then(|number| self.streams.get_mut(number)?.as_mut());
        let glide = stream.map(|stream| stream.take(at.seconds, now.seconds));
        let happening = Happening::Control(control, value);
        let Some(index) = index else {
            self.tell(at, None, None, happening);
            self.aim(number, value);
            return Ok(());
        };
        let (at, event) = match glide {
            Some(glide) => (self.when(glide.begin), Event::Glide(index, value, glide.seconds)),
            None => (at, Event::Control(index, value)),
        };
        if !self.order(at, event, None, happening, outlet) {
            return Err(full());
        }
        self.aim(number, value);
        Ok(())
    }

    /// Remembers where a control was sent.
    fn aim(&mut self, number: Option<usize>, value: f64) {
        if let Some(number) = number
            && let (Some(target), Some(control)) =
                (self.targets.get_mut(number), self.patch.controls.get(number))
        {
            *target = value.clamp(control.range[0], control.range[1]);
            self.moved = true;
        }
    }

    /// What brings controls that nothing reads here to where they were sent, in a scene that reads them, with its first sample.
    pub fn unread<'a>(&'a self, plan: &'a Plan, patch: &'a Patch) -> impl Iterator<Item = Event> + 'a {
        let sent = self.patch.controls.iter().zip(&self.targets);
        sent.filter(|(control, _)| self.plan.control(&control.name).is_err()).filter_map(
            |(control, target)| {
                let control = patch.controls.iter().find(|new| new.name == control.name)?;
                let value = target.clamp(control.range[0], control.range[1]);
                let index = plan.control(&control.name).ok()?;
                (value != control.default).then_some(Event::Glide(index, value, 0.0))
            },
        )
    }

    /// Where each control was sent last, by whomever, if any was since this was asked last or another patch plays.
    pub fn take_moved(&mut self) -> Option<impl Iterator<Item = (&str, f64)>> {
        let controls = self.patch.controls.iter().map(|control| &*control.name);
        std::mem::take(&mut self.moved).then(|| controls.zip(self.targets.iter().copied()))
    }

    fn order(
        &mut self,
        at: When,
        event: Event,
        id: Option<u64>,
        what: Happening<'_>,
        outlet: &mut dyn Outlet,
    ) -> bool {
        let sent = outlet.send(at.instant, Source::Program, event);
        if sent {
            self.tell(at, None, id, what);
        }
        sent
    }

    /// Lets the voices that are always on and were let go of sound again. Says whether there was room.
    pub fn wake(&mut self, at: When, outlet: &mut dyn Outlet) -> bool {
        let mut sent = true;
        for play in self.plan.always() {
            let name = self.plan.instruments.get(play.instrument as usize).map_or("", |i| &*i.name);
            if self.asleep.contains(name) {
                let woken = outlet.send(at.instant, Source::Program, Event::Play(play));
                sent &= woken;
                // One that found no room may be woken once more.
                woken.then(|| self.asleep.remove(name));
            }
        }
        sent
    }

    fn when(&self, seconds: f64) -> When {
        When::of_seconds(seconds, self.plan.engine_rate())
    }

    fn send(&mut self, at: When, source: Source, play: Play, outlet: &mut dyn Outlet) -> bool {
        let taken = outlet.send(at.instant, source, Event::Play(play));
        if let Some(record) = self.record.as_mut().filter(|_| taken) {
            record.push((at.seconds, play));
        }
        taken
    }

    /// Tells the listener of a voice.
    fn tell_play(&mut self, at: When, from: Option<Stand>, play: &Play) {
        if self.listener.is_none() {
            return;
        }
        let (patch, rig, finder) = (Arc::clone(&self.patch), Arc::clone(&self.rig), Arc::clone(&self.finder));
        let Some(&number) = self.voice_of.get(play.instrument as usize) else { return };
        let Some((voice, &pitched)) = patch.voices.get(number).zip(self.pitched.get(number)) else { return };
        let what = Happening::Voice {
            name: &voice.name,
            place: &play.place.name(|row| finder.name_of(&rig, row)),
            level: play.level,
            felt: play.felt,
            duration: play.duration,
            fields: &voice.fields,
            own: &play.own,
            pitched,
        };
        self.tell(at, from, Some(play.id), what);
    }

    /// Tells the listener of anything.
    fn tell(&mut self, at: When, from: Option<Stand>, id: Option<u64>, what: Happening<'_>) {
        let Some(listener) = &mut self.listener else { return };
        let origin = from.map(|Stand { pattern, event, drawn }| Origin {
            pattern: self.patch.patterns.get(pattern).map_or("", |p| &p.name),
            event,
            drawn,
        });
        listener(&Heard { at: at.seconds, instant: at.instant, origin, id, what });
    }
}

fn full() -> Problem {
    Problem::of_file("the engine's queue is full; play less at once")
}

fn in_time(When { seconds: at, .. }: When) -> Result<(), Problem> {
    if (0.0..=HORIZON).contains(&at) {
        return Ok(());
    }
    let what = format!("nothing can be played at {at} s");
    Err(Problem::of_file(what).help(format!("give the seconds from the beginning, 0 to {HORIZON}")))
}

/// Where in the patterns an event stands: pattern, event and alternative, by number.
#[derive(Debug, Clone, Copy)]
struct Stand {
    pattern: usize,
    event: u64,
    drawn: Option<u32>,
}
