//! The journal of a session: everything that came in and everything that was done, at which sample, with what it was made of. From it a
//! session can be understood, lined up with what other programs have recorded, and played again to the bit ([`replay`]).
//!
//! It is a text file of one of two forms, by its ending: a table (`.csv`) or JSON lines (`.jsonl`). The first line, of the kind `session`,
//! is a [`Head`]; a `plan` is a [`PlanHead`], with the texts of patch and rig. In a table both stand behind `# `, as JSON. All else is a
//! [`Line`].

mod digest;
mod head;
mod line;
mod names;
pub mod reader;
pub mod remake;
pub mod replay;
mod words;
mod writer;

use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::SystemTime;

use crate::engine::event::{Event, Source};
use crate::graph::plan::Plan;
use crate::io::device::keeper::Fate;
use crate::io::error::FileError;
use crate::live::board::Board;
use crate::live::callback::{Deed, Report};
use crate::live::clock::Moment;
use crate::live::conductor::Told;
use crate::live::provenance::Provenance;
use crate::live::signal::Signal;
use crate::live::stamp::{Epoch, Stamp};
use crate::performer::{Happening, Heard};
use crate::schedule::Instant;

pub use digest::{of_bytes, of_file};
pub use head::{FORMAT, Head, PlanHead};
pub use line::{COLUMNS, Kind, Line};
pub use writer::Form;

use names::Names;
use writer::{Entry, Writer};

/// Origins of events that may wait for the callback to take them.
const PENDING: usize = 1 << 17;

/// The journal of a session that plays. Clones write into the same file.
#[derive(Debug, Clone)]
pub struct Journal(Arc<Mutex<Keeping>>);

/// What is known of a session before it begins.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The device, as it is called.
    pub device: String,
    /// Whether the output has its full level, or that for headphones.
    pub armed: bool,
    /// The recording of what is heard, by its path beside the journal.
    pub input: Option<String>,
}

#[derive(Debug)]
struct Keeping {
    writer: Writer,
    setting: Setting,
    /// What sounds, and what has not taken over yet.
    names: Names,
    next: VecDeque<Names>,
    plans: u64,
    first: Option<(PlanHead, f64, usize)>,
    /// Where events come from, by the ids of their voices; of markers, in the order in which they were sent.
    voices: BTreeMap<u64, Stand>,
    markers: VecDeque<(Instant, String, Stand)>,
    began: Option<(Epoch, SystemTime)>,
    board: Arc<Board>,
}

/// Where in the patterns an event stands, counted from 1.
#[derive(Debug, Clone)]
struct Stand {
    pattern: String,
    event: u64,
    drawn: Option<u64>,
}

impl Journal {
    /// Makes the file, or empties the one that is there, for a session that begins with `plan`.
    ///
    /// # Errors
    /// A file that cannot be made, and a name that does not end in .csv or .jsonl.
    pub fn create(
        path: &Path,
        setting: Setting,
        plan: &Plan,
        made_of: Option<&Provenance>,
    ) -> Result<Self, FileError> {
        Ok(Self(Arc::new(Mutex::new(Keeping {
            writer: Writer::create(path)?,
            setting,
            names: Names::of(plan),
            next: VecDeque::new(),
            plans: 1,
            first: Some((plan_head(0, plan, made_of), plan.device_rate, plan.channels)),
            voices: BTreeMap::new(),
            markers: VecDeque::new(),
            began: None,
            board: Arc::default(),
        }))))
    }

    fn get(&self) -> MutexGuard<'_, Keeping> {
        // Whoever panicked while it was held has lost a line at most.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// For the listener of the session.
    pub fn hear(&self, heard: &Heard<'_>) {
        let Some(origin) = heard.origin else { return };
        let (event, drawn) = (origin.event + 1, origin.drawn.map(|drawn| u64::from(drawn) + 1));
        let stand = Stand { pattern: origin.pattern.into(), event, drawn };
        let mut keeping = self.get();
        match (heard.what, heard.id) {
            (Happening::Marker(name), _) => {
                keeping.markers.push_back((heard.instant, name.into(), stand));
                if keeping.markers.len() > PENDING {
                    keeping.markers.pop_front();
                }
            }
            (_, Some(id)) => {
                keeping.voices.insert(id, stand);
                // Those of events that found no room would stay for ever.
                if keeping.voices.len() > PENDING {
                    keeping.voices.pop_first();
                }
            }
            _ => {}
        }
    }

    /// For its audience.
    pub fn told(&self, told: &Told<'_>) {
        let mut keeping = self.get();
        match told {
            Told::Began(epoch, board) => keeping.begin(*epoch, board),
            Told::Came(stamp, signal) => keeping.came(*stamp, signal),
            Told::Report(report, moment) => keeping.report(report, *moment),
            Told::Reloading(reload) => {
                let plan = &reload.scene.plan;
                let head = plan_head(keeping.plans, plan, reload.provenance.as_deref());
                keeping.plans += 1;
                keeping.next.push_back(Names::of(plan));
                keeping.writer.put(Entry::Plan(Box::new(head)));
            }
            Told::Refused(_) | Told::Playing(_) | Told::Reloaded | Told::Kept(_) => {}
        }
    }

    /// For what becomes of the device.
    pub fn fate(&self, fate: &Fate) {
        let (name, message) = match fate {
            Fate::Lost(why) => ("lost", Some(why.clone())),
            Fate::Back => ("back", None),
            Fate::Moved => ("moved", None),
            Fate::Said(what) => ("said", Some(what.clone())),
        };
        let mut keeping = self.get();
        let line = Line { name: Some(name.into()), message, ..keeping.now(Kind::Device) };
        keeping.writer.put(Entry::Line(Box::new(line)));
    }

    /// Writes how frames and time belong together, and what was counted so far; to be called now and then.
    pub fn clock(&self, moment: Option<Moment>) {
        let mut keeping = self.get();
        let mut line = keeping.now(Kind::Clock);
        if let Some(moment) = moment {
            (line.frame, line.seconds) = (Some(moment.frames), Some(moment.time));
            line.utc = keeping.date(moment.time);
            line.fields.insert("rate".into(), 1.0 / moment.frame);
        }
        line.fields.extend(counters(&keeping.board));
        keeping.writer.put(Entry::Line(Box::new(line)));
    }

    /// Whether the file takes no more; [`Journal::finish`] says why.
    pub fn has_failed(&self) -> bool {
        self.get().writer.has_failed()
    }

    /// Writes the end, when the session has stopped. Gives how many lines are missing.
    ///
    /// # Errors
    /// What went wrong with the file.
    pub fn finish(&self) -> Result<u64, FileError> {
        let mut keeping = self.get();
        let mut line = keeping.now(Kind::End);
        line.frame = Some(keeping.board.frames.get());
        line.fields.extend(counters(&keeping.board));
        keeping.writer.put(Entry::Line(Box::new(line)));
        let untold = keeping.board.untold.get();
        keeping.writer.finish().map(|lost| lost + untold)
    }
}

fn plan_head(number: u64, plan: &Plan, made_of: Option<&Provenance>) -> PlanHead {
    PlanHead { plan: number, seed: plan.seed, engine_rate: plan.engine_rate(), made_of: made_of.cloned() }
}

/// What was counted so far, by name.
fn counters(board: &Board) -> BTreeMap<String, f64> {
    let counted = [
        ("voices", board.started.get()),
        ("stolen", board.stolen.get()),
        ("late", board.late.get()),
        ("dropped", board.dropped.get()),
        ("refused", board.refused.get()),
        ("xruns", board.xruns.get()),
        ("unrecorded", board.unrecorded.get()),
        ("untold", board.untold.get()),
        ("masked", board.masked.get()),
        ("clamped", board.clamped.get()),
        ("limited", board.limited.get()),
        ("over", board.load.over()),
    ];
    let mut named: BTreeMap<String, f64> =
        counted.into_iter().map(|(name, count)| (name.into(), count as f64)).collect();
    named.insert("load".into(), board.load.mean());
    named.insert("device_delay".into(), board.device_delay.get() as f64 * 1e-9);
    named
}

impl Keeping {
    fn begin(&mut self, epoch: Epoch, board: &Arc<Board>) {
        let utc =
            SystemTime::now().checked_sub(epoch.instant(Stamp(0)).elapsed()).unwrap_or(SystemTime::now());
        let monotonic = monotonic().map(|now| now - epoch.now().seconds());
        (self.began, self.board) = (Some((epoch, utc)), Arc::clone(board));
        let Some((plan, rate, channels)) = self.first.take() else { return };
        let head = Head {
            format: FORMAT.into(),
            pacinian: env!("CARGO_PKG_VERSION").into(),
            device: self.setting.device.clone(),
            rate,
            channels,
            gain: f64::from(if self.setting.armed { 1.0 } else { crate::live::gate::UNARMED }),
            delay: self.delay(),
            utc: date(utc),
            monotonic,
            input: self.setting.input.clone(),
        };
        self.writer.put(Entry::Head(Box::new(head)));
        self.writer.put(Entry::Plan(Box::new(plan)));
    }

    /// Seconds of the engine's delay.
    fn delay(&self) -> f64 {
        self.board.engine_delay.get() as f64 * 1e-9
    }

    fn date(&self, seconds: f64) -> Option<String> {
        let (_, utc) = self.began?;
        let since = std::time::Duration::try_from_secs_f64(seconds).ok()?;
        utc.checked_add(since).map(date)
    }

    /// A line of something that is noticed now.
    fn now(&self, kind: Kind) -> Line {
        let seconds = self.began.map(|(epoch, _)| epoch.now().seconds());
        Line { seconds, utc: seconds.and_then(|seconds| self.date(seconds)), ..Line::new(kind) }
    }

    fn report(&mut self, report: &Report, moment: Option<Moment>) {
        let mut line = match &report.deed {
            Deed::Event { at, due, source, event } => self.event(*at, *due, *source, event, moment),
            Deed::Order(order) => {
                let (name, value) = words::of_order(*order);
                Line { name: Some(name.into()), value, ..Line::new(Kind::Gate) }
            }
            Deed::Swap => {
                if let Some(names) = self.next.pop_front() {
                    self.names = names;
                }
                Line::new(Kind::Swap)
            }
        };
        line.frame = Some(report.frame);
        if line.seconds.is_none()
            && let Some(moment) = moment
        {
            line.seconds = Some(moment.time_of(report.frame as f64));
            line.utc = line.seconds.and_then(|seconds| self.date(seconds));
        }
        self.writer.put(Entry::Line(Box::new(line)));
    }

    fn event(
        &mut self,
        at: Instant,
        due: Instant,
        source: Source,
        event: &Event,
        moment: Option<Moment>,
    ) -> Line {
        let mut line = self.names.line(event);
        let fraction = |instant: Instant| f64::from(instant.fraction) / 4_294_967_296.0;
        line.source = Some(words::of_source(source).into());
        (line.sample, line.fraction) = (Some(at.sample), Some(fraction(at)));
        (line.due_sample, line.due_fraction) = (Some(due.sample), Some(fraction(due)));
        let stand = match event {
            Event::Play(play) => self.voices.remove(&play.id),
            Event::Marker(_) => {
                let found = self.markers.iter().position(|(instant, ..)| *instant == due);
                found.and_then(|found| self.markers.remove(found)).map(|(_, name, stand)| {
                    line.name = Some(name);
                    stand
                })
            }
            _ => None,
        };
        if let Some(Stand { pattern, event, drawn }) = stand {
            (line.pattern, line.event, line.drawn) = (Some(pattern), Some(event), drawn);
        }
        if let Some(moment) = moment {
            let frame = at.since(Instant::default()) * self.names.ratio;
            let seconds = moment.time_of(frame) + self.delay() + self.board.device_delay.get() as f64 * 1e-9;
            (line.seconds, line.utc) = (Some(seconds), self.date(seconds));
        }
        line
    }

    fn came(&mut self, stamp: Stamp, signal: &Signal) {
        let (source, name, message) = words::of_signal(signal);
        let seconds = Some(stamp.seconds());
        let utc = self.date(stamp.seconds());
        let line = Line { source: Some(source.into()), name, message, seconds, utc, ..Line::new(Kind::In) };
        self.writer.put(Entry::Line(Box::new(line)));
    }
}

fn date(time: SystemTime) -> String {
    humantime::format_rfc3339_nanos(time).to_string()
}

/// The clock that programs of this machine share.
fn monotonic() -> Option<f64> {
    #[cfg(unix)]
    {
        let now = rustix::time::clock_gettime(rustix::time::ClockId::Monotonic);
        Some(now.tv_sec as f64 + now.tv_nsec as f64 * 1e-9)
    }
    #[cfg(not(unix))]
    None
}
