//! Plays a journal again: the same plans, the same events, at the same frames. What comes out is what the session gave its device, to
//! the bit, whatever the machine did meanwhile.

use std::collections::{HashMap, VecDeque};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::Path;

use super::head::Head;
use super::kind::Kind;
use super::line::Line;
use super::reader::{Item, Reader};
use super::recorded::Recorded;
use super::remake::{Recordings, RemakeError, remake};
use super::{INPUT_FRAMES, INPUT_UNRECORDED, UNTOLD, files, words, world};
use crate::engine::event::{Event, Move, Play};
use crate::engine::exchange::{Director, Stagehand, exchange};
use crate::engine::knob::followed::Followed;
use crate::graph::plan::Plan;
use crate::io::error::FileError;
use crate::live::gate::Gate;
use crate::live::provenance::Provenance;
use crate::live::steps::Steps;
use crate::node::motion::Motion;
use crate::schedule::Instant;
use crate::space::spot::Spot;
use crate::text::Problem;
use crate::text::measure::number;

/// Frames of a block.
const BLOCK: usize = 4096;

/// Seconds between two lines with a frame, at most: a session writes one a second. What says more has been edited, and would be played
/// for ever.
const APART: f64 = 3600.0;

/// Plans that may wait for their turn. Two are under way in a session, and their ways are told a little later.
const WAITING: usize = 16;

/// Why a journal cannot be played, or no further.
#[derive(Debug, Clone, PartialEq)]
pub enum ReplayError {
    /// The journal, at one of its lines; or a file beside it.
    File(FileError),
    /// A scene of it.
    Scene(RemakeError),
}

impl std::fmt::Display for ReplayError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(error) => error.fmt(f),
            Self::Scene(error) => error.fmt(f),
        }
    }
}

impl std::error::Error for ReplayError {}

impl From<FileError> for ReplayError {
    fn from(error: FileError) -> Self {
        Self::File(error)
    }
}

/// What was met on the way.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Met {
    /// Frames of all channels.
    pub frames: u64,
    /// Events given to the engine.
    pub events: u64,
    /// Voices that began, those that nodes set off among them.
    pub voices: u64,
    /// Plans that took over from another.
    pub swaps: u64,
    /// Lines that the journal lacks: from the first of them on, what is played may differ from what was.
    pub lost: u64,
    /// Whether the journal goes to the session's end.
    pub ended: bool,
    /// The frame at which the recording of what was heard ends, where the session goes on: silence is heard from there on.
    pub deaf_from: Option<u64>,
    /// Frames that were heard, but found no room in the recording: they are silence in it.
    pub unheard: u64,
}

/// A journal that is played again.
pub struct Replay<R> {
    reader: Reader<R>,
    head: Head,
    recordings: Recordings,
    director: Director,
    stagehand: Stagehand,
    gate: Gate,
    names: Numbers,
    next: VecDeque<Provenance>,
    pending: Option<Box<Line>>,
    input: Option<Recorded>,
    frames: Vec<f32>,
    heard: Vec<f32>,
    met: Met,
    /// The furthest frame that a line tells of.
    furthest: u64,
    /// Things done that the last line with counters misses.
    untold: u64,
}

/// The numbers of a plan's names.
struct Numbers {
    plan: Plan,
    places: HashMap<String, Spot>,
}

impl Numbers {
    fn of(plan: Plan) -> Self {
        let names = plan.outputs.iter().map(|output| &output.name).chain(&plan.together);
        let rows = names.take(plan.places.len()).enumerate();
        let mut places = HashMap::new();
        for (number, name) in rows {
            places.entry(name.to_string()).or_insert(Spot::Row(number as u32));
        }
        Self { plan, places }
    }
}

impl Replay<BufReader<File>> {
    /// Opens a journal, and beside it the recording of what was heard, if there is one. Recordings that are not what was played are looked for
    /// beside it as well.
    ///
    /// # Errors
    /// Files that cannot be read, a first scene that cannot be made again, and a recording that is not as the session heard.
    pub fn open(path: &Path, recordings: Recordings) -> Result<Self, ReplayError> {
        let kept = recordings.kept.unwrap_or_else(|| files::beside(path));
        let recordings = Recordings { kept: Some(kept), ..recordings };
        let mut replay = Self::new(Reader::open(path)?, recordings)?;
        if let Some(input) = &replay.head.input {
            if Path::new(input).file_name() != Some(input.as_ref()) {
                let what =
                    format!("what was heard is beside the journal, and `{input}` is no name of a file there");
                return Err(replay.reader.unwritten(&what).into());
            }
            let beside = path.parent().unwrap_or(Path::new("")).join(input);
            let channels = replay.stagehand.engine().input_channels();
            replay.input = Some(Recorded::open(beside, replay.head.rate, channels)?);
        }
        Ok(replay)
    }
}

impl<R: BufRead> Replay<R> {
    /// Of a journal that hears nothing.
    ///
    /// # Errors
    /// As [`Replay::open`].
    pub fn new(mut reader: Reader<R>, recordings: Recordings) -> Result<Self, ReplayError> {
        let Some(Item::Session(head)) = reader.read()? else {
            return Err(reader.unwritten("this is no journal of a session").into());
        };
        let first = match reader.read()? {
            Some(Item::Plan(first)) => first,
            Some(_) => return Err(reader.unwritten("a plan must follow the first line").into()),
            None => {
                let what = "it breaks off before it says what was played, so nothing can be played again";
                return Err(reader.wrong(what).into());
            }
        };
        let Some(made_of) = first.made_of else { return Err(unmade(&reader)) };
        let plan = remake(&made_of, &recordings).map_err(|why| unmakeable(&reader, why))?.plan;
        let wrong = |what: String| ReplayError::from(reader.unwritten(&what));
        if plan.channels != head.channels || plan.device_rate != head.rate {
            return Err(wrong(format!(
                "the session had {} channels at {} Hz, its plan has {} at {} Hz",
                head.channels, head.rate, plan.channels, plan.device_rate
            )));
        }
        if !(0.0..=1.0).contains(&head.gain) {
            return Err(wrong(format!("the gain of an output is from 0 to 1, not {}", number(head.gain))));
        }
        let (director, mut stagehand) = exchange(&plan).map_err(|why| wrong(why.to_string()))?;
        let gate = Gate::new(plan.device_rate, head.gain as f32);
        let gate = gate.before(plan.channels, stagehand.engine().stage());
        Ok(Self {
            reader,
            head: *head,
            recordings,
            director,
            stagehand,
            gate,
            names: Numbers::of(plan),
            next: VecDeque::new(),
            pending: None,
            input: None,
            frames: Vec::new(),
            heard: Vec::new(),
            met: Met::default(),
            furthest: 0,
            untold: 0,
        })
    }

    /// What the journal says of its session.
    pub fn head(&self) -> &Head {
        &self.head
    }

    /// What was met so far.
    pub fn met(&self) -> Met {
        self.met
    }

    /// The next frames, interleaved; `None` at the end. A journal that breaks off ends at the furthest frame that it tells of.
    ///
    /// # Errors
    /// A line that cannot be, or what cannot be made again.
    pub fn block(&mut self) -> Result<Option<&[f32]>, ReplayError> {
        while !self.met.ended {
            let Some(line) = self.pending.take() else {
                match self.reader.read()? {
                    None => {
                        self.met.lost = self.met.lost.saturating_add(std::mem::take(&mut self.untold));
                        return self.compute(self.furthest.saturating_sub(self.met.frames));
                    }
                    Some(item) => self.pending = self.take(item)?,
                }
                continue;
            };
            let Some(frame) = line.frame else {
                let what = format!("a line `{}` must have a frame", line.kind.word());
                return Err(self.reader.unwritten(&what).into());
            };
            let Some(frames) = frame.checked_sub(self.met.frames) else {
                let what = format!("frame {frame} has passed: {} have been given out", self.met.frames);
                return Err(self.reader.unwritten(&what).into());
            };
            if frames > 0 {
                self.pending = Some(line);
                return self.compute(frames);
            }
            match line.kind {
                Kind::End => {
                    self.end(&line)?;
                    if self.reader.read()?.is_some() {
                        return Err(self.reader.unwritten("something follows the end of the session").into());
                    }
                }
                Kind::Swap => self.swap()?,
                _ => self.act(&line).map_err(|what| self.reader.unwritten(&what))?,
            }
        }
        Ok(None)
    }

    /// Takes what comes next; gives what is to be done at its frame.
    fn take(&mut self, item: Item) -> Result<Option<Box<Line>>, ReplayError> {
        let line = match item {
            Item::Session(_) => return Err(self.reader.unwritten("a second session begins here").into()),
            Item::Plan(plan) => {
                let Some(made_of) = plan.made_of else { return Err(unmade(&self.reader)) };
                if self.next.len() >= WAITING {
                    let what = format!("more than {WAITING} plans wait here");
                    return Err(self.reader.unwritten(&what).into());
                }
                self.next.push_back(made_of);
                return Ok(None);
            }
            Item::Line(line) => line,
        };
        if let Some(frame) = line.frame {
            let apart = frame.saturating_sub(self.furthest.max(self.met.frames)) as f64 / self.head.rate;
            if apart > APART {
                let what = format!(
                    "frame {frame} is {:.1} hours after all that was told before, and a session tells of itself every second",
                    apart / 3600.0
                );
                return Err(self.reader.unwritten(&what).into());
            }
            // What is noticed beside the callback may be ahead of what that has told.
            if !matches!(line.kind, Kind::Xrun | Kind::Device) {
                self.furthest = self.furthest.max(frame);
            }
        }
        // Numbers that no counter has become the nearest that one could.
        let count = |name: &str| line.fields.get(name).map(|count| *count as u64);
        match line.kind {
            Kind::Lost => {
                self.met.lost = self.met.lost.saturating_add(line.value.unwrap_or(1.0) as u64);
                Ok(None)
            }
            Kind::Clock | Kind::End => {
                self.untold = count(UNTOLD).unwrap_or(self.untold);
                self.met.unheard = count(INPUT_UNRECORDED).unwrap_or(self.met.unheard);
                Ok(Some(line).filter(|line| line.kind == Kind::End))
            }
            // What signals set off they set off here as well, and what always sounds begins.
            kind => Ok(Some(line)
                .filter(|line| kind.is_played() && !line.source.as_deref().is_some_and(words::by_itself))),
        }
    }

    fn end(&mut self, line: &Line) -> Result<(), ReplayError> {
        self.met.ended = true;
        self.met.lost = self.met.lost.saturating_add(self.untold);
        if let (Some(input), Some(frames), Some(sha256)) =
            (self.input.take(), line.fields.get(INPUT_FRAMES), &line.message)
        {
            input.check(*frames as u64, sha256)?;
        }
        Ok(())
    }

    /// So many frames, or as many of them as make a block.
    fn compute(&mut self, frames: u64) -> Result<Option<&[f32]>, ReplayError> {
        let frames = frames.min(BLOCK as u64) as usize;
        if frames == 0 {
            return Ok(None);
        }
        let ears = self.stagehand.engine().input_channels();
        match &mut self.input {
            Some(input) => {
                let missing = input.next(frames, &mut self.heard)?;
                if missing > 0 {
                    let from = self.met.frames + frames as u64 - missing;
                    self.met.deaf_from.get_or_insert(from);
                }
            }
            None => {
                self.heard.clear();
                self.heard.resize(ears * frames, 0.0);
            }
        }
        self.frames.clear();
        self.frames.resize(frames * self.head.channels, 0.0);
        self.stagehand.compute(&self.heard, &mut self.frames);
        self.met.voices = self.stagehand.engine().counters().started;
        self.gate.pass(&mut self.frames, self.head.channels);
        self.met.frames += frames as u64;
        Ok(Some(&self.frames))
    }

    fn act(&mut self, line: &Line) -> Result<(), String> {
        let name = line.name.as_deref().unwrap_or_default();
        let event = match line.kind {
            Kind::Gate => {
                let order =
                    words::order(name, line.value).ok_or_else(|| format!("a gate does not know `{name}`"))?;
                self.gate.order(order);
                self.stagehand.engine().hold_motors(self.gate.holds());
                return Ok(());
            }
            Kind::Steps => {
                let bits = line.value.ok_or("steps must have a `value`")?;
                let whole = (bits.fract() == 0.0).then_some(bits as u8);
                let steps = if bits == 0.0 { Some(Steps::FLOAT) } else { whole.and_then(Steps::of) };
                let steps = steps.ok_or_else(|| {
                    format!("samples have from 2 to 32 bits, or 0 for floating point, not {}", number(bits))
                })?;
                self.gate.round_to(steps);
                return Ok(());
            }
            Kind::Model => {
                let sample = line.sample.ok_or("a model must have a `sample`")?;
                let message = world::message(&line.fields)?;
                self.stagehand.engine().follow_again(Followed { sample, message });
                return Ok(());
            }
            Kind::Voice => Event::Play(self.voice(name, line)?),
            Kind::Release => Event::Release(line.id.ok_or("a release must have an id")?),
            Kind::ReleaseAll => Event::ReleaseAll,
            Kind::Silence => {
                let id = line.id.ok_or("a silence must have an id")?;
                Event::Silence(id, line.value.unwrap_or(0.0) as u8)
            }
            Kind::Cancel => {
                let id = line.id.ok_or("what is called off must have an id")?;
                Event::Cancel(id, line.value.unwrap_or(0.0) as u8)
            }
            Kind::Touch => {
                let motion =
                    Motion::ALL.into_iter().find(|motion| Motion::WORDS.get(motion.number()) == Some(&name));
                Event::Touch(Move {
                    id: line.id.ok_or("a touch must have an id")?,
                    motion: motion.ok_or_else(|| format!("no voice is touched by `{name}`"))?,
                    value: line.value.ok_or("a touch must have a value")?,
                })
            }
            Kind::Control => {
                let control = self.names.plan.control(name).map_err(told)?;
                let value = line.value.filter(|value| value.is_finite());
                let value = value.ok_or("a control must have a value")?;
                line.duration
                    .map_or(Event::Control(control, value), |seconds| Event::Glide(control, value, seconds))
            }
            // Tasks are a program's own; none is here that could rest.
            Kind::Shed => Event::Shed(line.value.unwrap_or(f64::from(u8::MAX)) as u8),
            Kind::Push => Event::Push(line.value.ok_or("a push must have a value")?),
            Kind::Arm => Event::Arm(line.value.unwrap_or(0.0) != 0.0),
            Kind::Deadline => Event::Deadline(line.value.unwrap_or(0.0) != 0.0),
            Kind::Marker => {
                let markers = &self.names.plan.markers;
                let number = markers.iter().position(|marker| **marker == *name);
                // One of an older journal cannot be called off.
                Event::Marker(number.map_or(u32::MAX, |number| number as u32), line.id.unwrap_or(u64::MAX))
            }
            Kind::Swap
            | Kind::In
            | Kind::Refused
            | Kind::Stolen
            | Kind::Device
            | Kind::Xrun
            | Kind::Clock
            | Kind::Lost
            | Kind::End => return Ok(()),
        };
        let at = instant(line).ok_or("an event must have a `sample` and a `fraction` from 0 to below 1")?;
        let source = line.source.as_deref().unwrap_or_default();
        let source = words::source(source)
            .ok_or_else(|| format!("events come from `stop`, `pattern` or `program`, not from `{source}`"))?;
        self.met.events += 1;
        if !self.stagehand.engine().schedule(at, source, event) {
            return Err("more events wait here than the engine has room for".into());
        }
        Ok(())
    }

    fn voice(&self, name: &str, line: &Line) -> Result<Play, String> {
        let mut fields = vec![
            ("level", line.level.ok_or("a voice must have a level")?),
            ("duration", line.duration.unwrap_or(f64::INFINITY)),
        ];
        fields.extend(line.felt.map(|felt| ("felt", felt)));
        fields.extend(line.fields.iter().map(|(name, value)| (name.as_str(), *value)));
        let play = self.names.plan.played(name, &fields).map_err(told)?;
        let place = line.place.as_deref().unwrap_or_default();
        let named = self.names.places.get(place).copied().or_else(|| Spot::unnamed(place));
        let place = named.ok_or_else(|| format!("there is no output `{place}`"))?;
        Ok(Play { place, id: line.id.ok_or("a voice must have an id")?, ..play })
    }

    fn swap(&mut self) -> Result<(), ReplayError> {
        let Some(made_of) = self.next.pop_front() else {
            return Err(self.reader.unwritten("no plan was written down that could take over here").into());
        };
        let plan = remake(&made_of, &self.recordings).map_err(|why| unmakeable(&self.reader, why))?.plan;
        let sent =
            self.director.send(&plan).map_err(|mismatch| self.reader.unwritten(&mismatch.to_string()))?;
        if !sent || !self.stagehand.take_over_now() {
            let what = "a plan cannot take over while the one before still fades";
            return Err(self.reader.unwritten(what).into());
        }
        self.gate.stands_before(self.stagehand.engine().stage());
        self.names = Numbers::of(plan);
        self.met.swaps += 1;
        Ok(())
    }
}

/// In one sentence.
fn told(problem: Problem) -> String {
    problem.help.map_or(problem.what.clone(), |help| format!("{}: {help}", problem.what))
}

fn unmakeable<R: BufRead>(reader: &Reader<R>, why: RemakeError) -> ReplayError {
    match why {
        RemakeError::Journal(what) => reader.unwritten(&what).into(),
        why => ReplayError::Scene(why),
    }
}

fn unmade<R: BufRead>(reader: &Reader<R>) -> ReplayError {
    let what = "a program has put this plan together, so only that program can make it again";
    reader.wrong(what).into()
}

fn instant(line: &Line) -> Option<Instant> {
    let fraction = line.fraction.filter(|fraction| (0.0..1.0).contains(fraction))?;
    Some(Instant { sample: line.sample?, fraction: (fraction * 4_294_967_296.0) as u32 })
}
