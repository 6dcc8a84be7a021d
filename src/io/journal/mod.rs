//! The journal of a session: everything that came in and everything that was done, at which sample, with what it was made of. From it a
//! session can be understood, lined up with what other programs have recorded, and played again to the bit ([`replay`]).
//!
//! It is a text file of one of two forms, by its ending: a table (`.csv`) or JSON lines (`.jsonl`). The first line, of the kind `session`,
//! is a [`Head`]; a `plan` is a [`PlanHead`], with the texts of patch and rig. In a table both stand behind `# `, as JSON. All else is a
//! [`Line`].

pub mod chronicle;
mod digest;
pub mod files;
mod head;
mod kind;
mod line;
mod names;
pub mod reader;
mod recorded;
pub mod remake;
pub mod replay;
mod words;
mod world;
mod writer;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::graph::plan::Plan;
use crate::io::device::keeper::Fate;
use crate::io::error::FileError;
use crate::live::board::Board;
use crate::live::clock::Moment;
use crate::live::conductor::Told;
use crate::live::provenance::Provenance;
use crate::live::stamp::Epoch;
use crate::performer::Heard;

pub use digest::{Digest, of_bytes, of_file};
pub use head::{FORMAT, Head, PathHead, PlanHead};
pub use kind::Kind;
pub use line::{COLUMNS, Line};
pub use writer::Form;

use chronicle::Chronicle;
use writer::{Entry, Writer};

/// The journal of a session that plays. Clones write into the same file.
#[derive(Debug, Clone)]
pub struct Journal(Arc<Mutex<Keeping>>);

/// What is known of a session before it begins.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The device, as it is called.
    pub device: String,
    /// What names it for good, with its host.
    pub device_id: Option<String>,
    /// Whether the output has its full level, or that for headphones.
    pub armed: bool,
    /// The recording of what is heard, by its name beside the journal.
    pub input: Option<String>,
    /// The device or the file that is listened to, as it is called.
    pub heard: Option<String>,
    /// The latency of the loop, seconds, where the rig has it.
    pub loop_latency: Option<f64>,
    /// The recording of what is sent, by its path.
    pub recording: Option<String>,
}

impl Setting {
    /// On a device, of which nothing else is known.
    pub fn on(device: &str, armed: bool) -> Self {
        Self {
            device: device.into(),
            device_id: None,
            armed,
            input: None,
            heard: None,
            loop_latency: None,
            recording: None,
        }
    }
}

#[derive(Debug)]
struct Keeping {
    writer: Writer,
    setting: Setting,
    chronicle: Chronicle,
    plans: u64,
    first: Option<(PlanHead, f64, usize)>,
    /// What came before the session began.
    early: Vec<Line>,
    heard: Option<(u64, String)>,
    /// Gaps of the device and of the input that stand there.
    gaps: [u64; 2],
    /// What others have counted.
    counted: BTreeMap<String, f64>,
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
        let journal = Self::new(path, setting, plan, made_of)?;
        journal.open().map(|()| journal)
    }

    /// As [`Journal::create`], but the file is only made by [`Journal::open`]; until then it is listened to, and kept.
    ///
    /// # Errors
    /// A name that does not end in .csv or .jsonl.
    pub fn new(
        path: &Path,
        setting: Setting,
        plan: &Plan,
        made_of: Option<&Provenance>,
    ) -> Result<Self, FileError> {
        Ok(Self(Arc::new(Mutex::new(Keeping {
            writer: Writer::new(path)?,
            setting,
            chronicle: Chronicle::of(plan),
            plans: 1,
            first: Some((plan_head(0, plan, made_of), plan.device_rate, plan.channels)),
            early: Vec::new(),
            heard: None,
            gaps: [0; 2],
            counted: BTreeMap::new(),
        }))))
    }

    /// Makes the file, or empties the one that is there.
    ///
    /// # Errors
    /// A file that cannot be made.
    pub fn open(&self) -> Result<(), FileError> {
        self.get().writer.open()
    }

    fn get(&self) -> MutexGuard<'_, Keeping> {
        // Whoever panicked while it was held has lost a line at most.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// For the listener of the session.
    pub fn hear(&self, heard: &Heard<'_>) {
        let mut keeping = self.get();
        if let Some(line) = keeping.chronicle.hear(heard) {
            keeping.put(line);
        }
    }

    /// For its audience.
    pub fn told(&self, told: &Told<'_>) {
        let mut keeping = self.get();
        let line = keeping.chronicle.told(told);
        match told {
            Told::Began(epoch, _) => keeping.begin(*epoch),
            Told::Reloading(reload, _) => {
                let head = plan_head(keeping.plans, &reload.scene.plan, reload.provenance.as_deref());
                keeping.plans += 1;
                keeping.writer.put(Entry::Plan(Box::new(head)));
            }
            _ => {}
        }
        if let Some(line) = line {
            keeping.put(line);
        }
    }

    /// For what becomes of the device.
    pub fn fate(&self, fate: &Fate) {
        self.becomes("", fate);
    }

    /// For what becomes of the device that is listened to.
    pub fn input_fate(&self, fate: &Fate) {
        self.becomes("input-", fate);
    }

    fn becomes(&self, of: &str, fate: &Fate) {
        let (name, message) = match fate {
            Fate::Lost(why) => ("lost", Some(why.clone())),
            Fate::Back => ("back", None),
            Fate::Moved => ("moved", None),
            Fate::Lowered => ("lowered", None),
            Fate::Said(what) => ("said", Some(what.clone())),
        };
        let mut keeping = self.get();
        let line = Line { name: Some(format!("{of}{name}")), message, ..keeping.chronicle.now(Kind::Device) };
        keeping.put(line);
    }

    /// Writes where blocks came too late since this was called last; to be called often.
    pub fn gaps(&self) {
        let mut keeping = self.get();
        let board = std::sync::Arc::clone(&keeping.chronicle.board);
        let all =
            [(None, &board.xruns, &board.xrun_at), (Some("input"), &board.input.xruns, &board.input.xrun_at)];
        for (n, (name, count, at)) in all.into_iter().enumerate() {
            let count = count.get();
            let new = count - std::mem::replace(&mut keeping.gaps[n], count);
            if new > 0 {
                let (frame, value) = (Some(at.get()), Some(new as f64));
                let line =
                    Line { name: name.map(String::from), frame, value, ..keeping.chronicle.now(Kind::Xrun) };
                keeping.put(line);
            }
        }
    }

    /// Writes how frames and time belong together, and what was counted so far; to be called about once a second. All that was done
    /// before that frame stands before this line, so a journal that breaks off can be played again up to there.
    pub fn clock(&self, moment: Option<Moment>) {
        let mut keeping = self.get();
        let mut line = keeping.chronicle.now(Kind::Clock);
        if let Some(moment) = moment {
            let frame = keeping.chronicle.board.told.get().min(moment.frames);
            let seconds = moment.time_of(frame as f64);
            (line.frame, line.seconds) = (Some(frame), Some(seconds));
            line.utc = keeping.chronicle.date(seconds);
            line.fields.insert("rate".into(), 1.0 / moment.frame);
        }
        line.fields.extend(counters(&keeping.chronicle.board));
        keeping.put(line);
    }

    /// What was heard has been recorded: so many frames, with this digest of their samples ([`Digest::samples`]). It is written with the
    /// end, so that a replay knows the recording again.
    pub fn heard(&self, frames: u64, sha256: String) {
        self.get().heard = Some((frames, sha256));
    }

    /// What somebody has counted who is no part of the session, by name. It is written with the end.
    pub fn counted(&self, counts: impl IntoIterator<Item = (&'static str, u64)>) {
        self.get().counted.extend(counts.into_iter().map(|(name, count)| (name.into(), count as f64)));
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
        self.gaps();
        let mut keeping = self.get();
        let mut line = keeping.chronicle.now(Kind::End);
        line.frame = Some(keeping.chronicle.board.frames.get());
        line.fields.extend(counters(&keeping.chronicle.board));
        line.fields.append(&mut keeping.counted);
        if let Some((frames, sha256)) = keeping.heard.take() {
            line.fields.insert(INPUT_FRAMES.into(), frames as f64);
            line.message = Some(sha256);
        }
        keeping.put(line);
        let untold = keeping.chronicle.board.untold.get();
        keeping.writer.finish().map(|lost| lost + untold)
    }
}

fn plan_head(number: u64, plan: &Plan, made_of: Option<&Provenance>) -> PlanHead {
    let paths = plan.paths.iter().map(PathHead::of).collect();
    let (seed, engine_rate, made_of) = (plan.seed, plan.engine_rate(), made_of.cloned());
    PlanHead { plan: number, seed, engine_rate, paths, made_of }
}

/// What a replay reads of the counters.
const UNTOLD: &str = "untold";
const INPUT_UNRECORDED: &str = "input_unrecorded";
const INPUT_FRAMES: &str = "input_frames";

/// What was counted so far, by name.
fn counters(board: &Board) -> BTreeMap<String, f64> {
    let counted = [
        ("voices", board.started.get()),
        ("stolen", board.stolen.get()),
        ("late", board.late.get()),
        ("dropped", board.dropped.get()),
        ("refused", board.refused.get()),
        ("undone", board.undone.get()),
        ("xruns", board.xruns.get()),
        ("unrecorded", board.unrecorded.get()),
        (UNTOLD, board.untold.get()),
        (INPUT_UNRECORDED, board.input.unrecorded.get()),
        ("input_xruns", board.input.xruns.get()),
        ("input_dry", board.input.dry.get()),
        ("input_jumps", board.input.jumps.get()),
        ("input_lost", board.input.lost.get()),
        ("masked", board.masked.get()),
        ("held_back", board.held_back.get()),
        ("clamped", board.clamped.get()),
        ("limited", board.limited.get()),
        ("over", board.load.over()),
        ("midi", board.midi.messages.get()),
    ];
    let midi = board.midi.named().map(|(name, count, _)| (name, count));
    let mut named: BTreeMap<String, f64> =
        counted.into_iter().chain(midi).map(|(name, count)| (name.into(), count as f64)).collect();
    for (way, count) in board.refused.named() {
        named.insert(format!("refused_{way}"), count as f64);
    }
    named.insert("load".into(), board.load.mean());
    named.insert("device_delay".into(), board.device_delay.seconds());
    named.insert("block".into(), board.block.get() as f64);
    named
}

impl Keeping {
    fn begin(&mut self, epoch: Epoch) {
        let monotonic = monotonic().map(|now| now - epoch.now().seconds());
        let utc = self.chronicle.date(0.0).unwrap_or_default();
        let Some((plan, rate, channels)) = self.first.take() else { return };
        let head = Head {
            format: FORMAT.into(),
            pacinian: env!("CARGO_PKG_VERSION").into(),
            device: self.setting.device.clone(),
            device_id: self.setting.device_id.clone(),
            rate,
            channels,
            gain: f64::from(if self.setting.armed { 1.0 } else { crate::live::gate::UNARMED }),
            delay: self.chronicle.delay(),
            utc,
            monotonic,
            input: self.setting.input.clone(),
            heard: self.setting.heard.clone(),
            loop_latency: self.setting.loop_latency,
            recording: self.setting.recording.clone(),
        };
        self.writer.put(Entry::Head(Box::new(head)));
        self.writer.put(Entry::Plan(Box::new(plan)));
        std::mem::take(&mut self.early).into_iter().for_each(|line| self.put(line));
    }

    /// Writes a line, behind what tells of the session: a device may say something while that begins.
    fn put(&mut self, line: Line) {
        if self.first.is_some() {
            self.early.push(line);
        } else {
            self.writer.put(Entry::Line(Box::new(line)));
        }
    }
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
