//! What is kept of a session: its sound, and its journal.

use super::failure::Failure;
use super::load::Loaded;
use super::place::check_kept;
use super::table::grouped;
use super::terminal::Terminal;
use clap::Args;
use pacinian::io::error::FileError;
use pacinian::io::journal::{Form, Journal, Setting};
use pacinian::io::recorder::Recorder;
use pacinian::io::session::Session;
use pacinian::io::wav::{Encoding, WavSpec};
use pacinian::live::reload::Reload;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What is to be kept of a session.
#[derive(Debug, Clone, Args)]
pub struct Keep {
    /// Keeps exactly what is sent to the card, as 32-bit samples at its rate
    #[arg(long, value_name = "FILE.wav")]
    pub record: Option<PathBuf>,
    /// Writes a journal of the session: everything that comes in and is played, when and why, with patch and rig. A table (.csv) or
    /// JSON lines (.jsonl); pacinian replay plays it again, to the bit
    #[arg(long, value_name = "FILE")]
    pub events: Option<PathBuf>,
}

/// How often the journal says how frames and time belong together.
const CLOCK: Duration = Duration::from_secs(1);

/// What is being kept.
pub struct Kept {
    /// With words for people.
    recorders: Vec<(Recorder, PathBuf, &'static str)>,
    journal: Option<(Journal, PathBuf)>,
    clock: Instant,
    said: bool,
}

impl Keep {
    /// Where a journal has what was heard: beside it, under its name.
    fn heard(&self) -> Option<PathBuf> {
        self.events.as_ref().map(|events| events.with_extension("input.wav"))
    }

    /// Refuses files that cannot be, before anything plays.
    ///
    /// # Errors
    /// As [`check_kept`].
    pub fn check(&self, loaded: &Loaded) -> Result<(), Failure> {
        let record = self.record.as_deref();
        if let Some(record) = record {
            check_kept(record, "--record", &[], Some(loaded))?;
        }
        if let Some(events) = &self.events {
            Form::of(events).map_err(|error| Failure::said(2, error.message))?;
            let others: Vec<&Path> = record.into_iter().collect();
            check_kept(events, "--events", &others, Some(loaded))?;
            if let Some(heard) = self.heard() {
                check_kept(&heard, "--events", &others, Some(loaded))?;
            }
        }
        Ok(())
    }

    /// The journal, where one is wanted.
    ///
    /// # Errors
    /// A file that cannot be made.
    pub fn journal(&self, reload: &Reload, device: &str, armed: bool) -> Result<Option<Journal>, FileError> {
        let hears = !reload.scene.plan.inputs().is_empty();
        let input = self.heard().filter(|_| hears);
        let input = input.and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
        let setting = Setting { device: device.into(), armed, input };
        let create = |path: &PathBuf| {
            Journal::create(path, setting.clone(), &reload.scene.plan, reload.provenance.as_deref())
        };
        self.events.as_ref().map(create).transpose()
    }

    /// Begins to keep what a session sends.
    ///
    /// # Errors
    /// A file that cannot be made.
    pub fn begin(
        &self,
        session: &mut Session,
        journal: Option<Journal>,
        loaded: &Loaded,
    ) -> Result<Kept, FileError> {
        let mut recorders = Vec::new();
        if let Some((path, ring)) = self.record.as_ref().zip(session.recording()) {
            let mut spec = WavSpec::new(session.board().channels(), session.rate() as u32, Encoding::F32);
            spec.title.clone_from(&loaded.patch.title);
            spec.tactors = loaded.tactors();
            recorders.push((Recorder::start(ring, path, spec)?, path.clone(), "as they were sent"));
        }
        if let Some((path, (ring, channels))) = self.heard().zip(session.recording_input()) {
            let spec = WavSpec::new(channels, session.rate() as u32, Encoding::F32);
            recorders.push((Recorder::start(ring, &path, spec)?, path, "as they were heard"));
        }
        let journal = journal.zip(self.events.clone());
        Ok(Kept { recorders, journal, clock: Instant::now(), said: false })
    }
}

impl Kept {
    /// To be called often. What goes wrong is said once; playing goes on.
    pub fn look(&mut self, session: &Session) -> Option<String> {
        if self.clock.elapsed() >= CLOCK {
            self.clock = Instant::now();
            if let Some((journal, _)) = &self.journal {
                journal.clock(session.clock().moment());
            }
        }
        let failed = |path: &Path| Some(format!("`{}` takes no more; the rest is not kept", path.display()));
        let recorder = self.recorders.iter().find(|(recorder, ..)| recorder.has_failed());
        let trouble = match (recorder, &self.journal) {
            _ if self.said => None,
            (Some((_, path, _)), _) => failed(path),
            (_, Some((journal, path))) if journal.has_failed() => failed(path),
            _ => None,
        };
        self.said |= trouble.is_some();
        trouble
    }

    /// Completes the files, after the session has stopped.
    ///
    /// # Errors
    /// What went wrong with them.
    pub fn finish(self, terminal: &Terminal) -> Result<(), Failure> {
        let mut failure = Failure::default();
        for (recorder, path, words) in self.recorders {
            match recorder.finish() {
                Ok(written) => terminal.note(&format!(
                    "{}: {} frames, {words}\n",
                    path.display(),
                    grouped(written.frames)
                )),
                Err(error) => failure.join(error.into()),
            }
        }
        if let Some((journal, path)) = self.journal {
            match journal.finish() {
                Ok(0) => {
                    let path = path.display();
                    terminal.note(&format!("{path}: the journal; pacinian replay {path} plays it again\n"));
                }
                Ok(lost) => {
                    let lines = grouped(lost);
                    terminal.note(&format!("{}: the journal, which lacks {lines} lines\n", path.display()));
                }
                Err(error) => failure.join(error.into()),
            }
        }
        if failure.is_none() { Ok(()) } else { Err(failure) }
    }
}
