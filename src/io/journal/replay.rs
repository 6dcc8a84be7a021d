//! Plays a journal again: the same plans, the same events, at the same frames. What comes out is what the session gave its device, to
//! the bit, whatever the machine did meanwhile.

use std::collections::{HashMap, VecDeque};
use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use super::head::Head;
use super::line::{Kind, Line};
use super::reader::{Item, Reader};
use super::remake::{RemakeError, remake};
use super::words;
use crate::engine::event::{Event, Move, Play};
use crate::engine::exchange::{Director, Stagehand, exchange};
use crate::graph::plan::Plan;
use crate::io::error::FileError;
use crate::io::wav::WavReader;
use crate::live::gate::Gate;
use crate::node::motion::Motion;
use crate::schedule::Instant;

/// Frames of a block.
const BLOCK: usize = 4096;

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
    /// Plans that took over from another.
    pub swaps: u64,
    /// Lines that the journal lacks: from the first of them on, what is played may differ from what was.
    pub lost: u64,
    /// Whether the journal goes to the session's end.
    pub ended: bool,
}

/// A journal that is played again.
pub struct Replay<R> {
    reader: Reader<R>,
    head: Head,
    folder: Option<PathBuf>,
    director: Director,
    stagehand: Stagehand,
    gate: Gate,
    names: Numbers,
    next: VecDeque<Plan>,
    pending: Option<Box<Line>>,
    /// What was heard, a vector a channel.
    input: Vec<Vec<f32>>,
    frames: Vec<f32>,
    heard: Vec<f32>,
    met: Met,
}

/// The numbers of a plan's names.
struct Numbers {
    plan: Plan,
    places: HashMap<String, u32>,
}

impl Numbers {
    fn of(plan: Plan) -> Self {
        let outputs = plan.outputs.iter().take(plan.places.len()).enumerate();
        let places = outputs.map(|(number, output)| (output.name.to_string(), number as u32)).collect();
        Self { plan, places }
    }
}

impl Replay<BufReader<File>> {
    /// Opens a journal. Recordings that its patches name are looked for in `folder`; `None`: where they were.
    ///
    /// # Errors
    /// One that cannot be read, or whose first scene cannot be made again.
    pub fn open(path: &Path, folder: Option<&Path>) -> Result<Self, ReplayError> {
        let mut replay = Self::new(Reader::open(path)?, folder)?;
        if let Some(input) = &replay.head.input {
            let beside = path.parent().unwrap_or(Path::new("")).join(input);
            replay.input = WavReader::open(beside)?.channels()?;
        }
        Ok(replay)
    }
}

impl<R: BufRead> Replay<R> {
    /// Of a journal that hears nothing.
    ///
    /// # Errors
    /// As [`Replay::open`].
    pub fn new(mut reader: Reader<R>, folder: Option<&Path>) -> Result<Self, ReplayError> {
        let Some(Item::Session(head)) = reader.read()? else {
            return Err(reader.wrong("this is no journal of a session").into());
        };
        let Some(Item::Plan(first)) = reader.read()? else {
            return Err(reader.wrong("a plan must follow the first line").into());
        };
        let Some(made_of) = first.made_of else { return Err(unmade(&reader)) };
        let plan = remake(&made_of, folder).map_err(ReplayError::Scene)?.plan;
        let wrong = |what: String| ReplayError::from(reader.wrong(&what));
        if plan.channels != head.channels || plan.device_rate != head.rate {
            return Err(wrong(format!(
                "the session had {} channels at {} Hz, its plan has {} at {} Hz",
                head.channels, head.rate, plan.channels, plan.device_rate
            )));
        }
        let (director, stagehand) = exchange(&plan).map_err(|why| wrong(why.to_string()))?;
        let gate = Gate::new(plan.device_rate, head.gain as f32);
        Ok(Self {
            reader,
            head: *head,
            folder: folder.map(Path::to_owned),
            director,
            stagehand,
            gate,
            names: Numbers::of(plan),
            next: VecDeque::new(),
            pending: None,
            input: Vec::new(),
            frames: Vec::new(),
            heard: Vec::new(),
            met: Met::default(),
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

    /// The next frames, interleaved; `None` at the end.
    ///
    /// # Errors
    /// A line that cannot be, or what cannot be made again.
    pub fn block(&mut self) -> Result<Option<&[f32]>, ReplayError> {
        loop {
            let Some(line) = self.pending.take() else {
                match self.reader.read()? {
                    None => return Ok(None),
                    Some(Item::Session(_)) => {
                        return Err(self.reader.wrong("a second session begins here").into());
                    }
                    Some(Item::Plan(plan)) => {
                        let Some(made_of) = plan.made_of else { return Err(unmade(&self.reader)) };
                        let scene = remake(&made_of, self.folder.as_deref()).map_err(ReplayError::Scene)?;
                        self.next.push_back(scene.plan);
                    }
                    Some(Item::Line(line)) if line.kind == Kind::Lost => {
                        self.met.lost += line.value.unwrap_or(1.0) as u64;
                    }
                    Some(Item::Line(line)) if line.kind.is_played() || line.kind == Kind::End => {
                        self.pending = Some(line);
                    }
                    Some(Item::Line(_)) => {}
                }
                continue;
            };
            let Some(frame) = line.frame else {
                return Err(self
                    .reader
                    .wrong(&format!("a line `{}` must have a frame", line.kind.word()))
                    .into());
            };
            let Some(frames) = frame.checked_sub(self.met.frames) else {
                let what = format!("frame {frame} has passed: {} have been given out", self.met.frames);
                return Err(self.reader.wrong(&what).into());
            };
            if frames > 0 {
                self.pending = Some(line);
                self.compute(frames.min(BLOCK as u64) as usize);
                return Ok(Some(&self.frames));
            }
            if line.kind == Kind::End {
                self.met.ended = true;
                self.met.lost += line.fields.get("untold").copied().unwrap_or(0.0) as u64;
                return Ok(None);
            }
            self.act(&line).map_err(|what| self.reader.wrong(&what))?;
        }
    }

    fn compute(&mut self, frames: usize) {
        let ears = self.stagehand.engine().input_channels();
        self.heard.clear();
        for frame in self.met.frames..self.met.frames + if ears > 0 { frames as u64 } else { 0 } {
            let sample = |channel: usize| {
                self.input
                    .get(channel)
                    .and_then(|samples| samples.get(frame as usize))
                    .copied()
                    .unwrap_or(0.0)
            };
            self.heard.extend((0..ears).map(sample));
        }
        self.frames.clear();
        self.frames.resize(frames * self.head.channels, 0.0);
        self.stagehand.compute(&self.heard, &mut self.frames);
        self.gate.pass(&mut self.frames, self.head.channels);
        self.met.frames += frames as u64;
    }

    fn act(&mut self, line: &Line) -> Result<(), String> {
        let name = line.name.as_deref().unwrap_or_default();
        let event = match line.kind {
            Kind::Gate => {
                let order =
                    words::order(name, line.value).ok_or_else(|| format!("a gate does not know `{name}`"))?;
                self.gate.order(order);
                return Ok(());
            }
            Kind::Swap => return self.swap(),
            Kind::Voice => Event::Play(self.voice(name, line)?),
            Kind::Release => Event::Release(line.id.ok_or("a release must have an id")?),
            Kind::ReleaseAll => Event::ReleaseAll,
            Kind::Silence => {
                let id = line.id.ok_or("a silence must have an id")?;
                Event::Silence(id, line.value.unwrap_or(0.0) as u8)
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
                let control = self.names.plan.control(name).map_err(|problem| problem.to_string())?;
                let value = line.value.filter(|value| value.is_finite());
                let value = value.ok_or("a control must have a value")?;
                line.duration
                    .map_or(Event::Control(control, value), |seconds| Event::Glide(control, value, seconds))
            }
            // Tasks are a program's own; none is here that could rest.
            Kind::Shed => Event::Shed(line.value.unwrap_or(f64::from(u8::MAX)) as u8),
            Kind::Marker => {
                let markers = &self.names.plan.markers;
                let number = markers.iter().position(|marker| **marker == *name);
                Event::Marker(number.map_or(u32::MAX, |number| number as u32))
            }
            Kind::In | Kind::Device | Kind::Clock | Kind::Lost | Kind::End => return Ok(()),
        };
        let at = instant(line).ok_or("an event must have a `sample` and a `fraction` from 0 to below 1")?;
        let source = line.source.as_deref().unwrap_or_default();
        let source = words::source(source)
            .ok_or_else(|| format!("events come from `pattern` or `program`, not from `{source}`"))?;
        self.met.events += 1;
        if !self.stagehand.engine().schedule(at, source, event) {
            return Err(
                "more events wait here than the engine has room for, so no session has played this".into()
            );
        }
        Ok(())
    }

    fn voice(&self, name: &str, line: &Line) -> Result<Play, String> {
        let mut fields = vec![
            ("level", line.level.ok_or("a voice must have a level")?),
            ("duration", line.duration.unwrap_or(f64::INFINITY)),
        ];
        fields.extend(line.fields.iter().map(|(name, value)| (name.as_str(), *value)));
        let play = self.names.plan.play(name, &fields).map_err(|problem| problem.to_string())?;
        let place = line.place.as_deref().unwrap_or_default();
        let place = self.names.places.get(place).ok_or_else(|| format!("there is no output `{place}`"))?;
        Ok(Play { place: *place, id: line.id.ok_or("a voice must have an id")?, ..play })
    }

    fn swap(&mut self) -> Result<(), String> {
        let plan = self.next.pop_front().ok_or("no plan was written down that could take over here")?;
        let sent = self.director.send(&plan).map_err(|mismatch| mismatch.to_string())?;
        if !sent || !self.stagehand.take_over() {
            return Err(
                "a plan cannot take over while the one before still fades, so no session has played this"
                    .into(),
            );
        }
        self.names = Numbers::of(plan);
        self.met.swaps += 1;
        Ok(())
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
