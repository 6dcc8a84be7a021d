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
    recorder: Option<(Recorder, PathBuf)>,
    journal: Option<(Journal, PathBuf)>,
    clock: Instant,
    said: bool,
}

impl Keep {
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
        }
        Ok(())
    }

    /// The journal, where one is wanted.
    ///
    /// # Errors
    /// A file that cannot be made.
    pub fn journal(&self, reload: &Reload, device: &str, armed: bool) -> Result<Option<Journal>, FileError> {
        let setting = Setting { device: device.into(), armed, input: None };
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
        let mut recorder = None;
        if let Some((path, ring)) = self.record.as_ref().zip(session.recording()) {
            let mut spec = WavSpec::new(session.board().channels(), session.rate() as u32, Encoding::F32);
            spec.title.clone_from(&loaded.patch.title);
            spec.tactors = loaded.tactors();
            recorder = Some((Recorder::start(ring, path, spec)?, path.clone()));
        }
        let journal = journal.zip(self.events.clone());
        Ok(Kept { recorder, journal, clock: Instant::now(), said: false })
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
        let trouble = match (&self.recorder, &self.journal) {
            _ if self.said => None,
            (Some((recorder, path)), _) if recorder.has_failed() => failed(path),
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
        if let Some((recorder, path)) = self.recorder {
            match recorder.finish() {
                Ok(written) => terminal.note(&format!(
                    "{}: {} frames, as they were sent\n",
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
