//! What is kept of a session: its sound, and its journal.

use super::failure::Failure;
use super::loaded::Loaded;
use super::place::{check_folder, check_kept, check_new};
use super::table::{grouped, many};
use super::terminal::Terminal;
use clap::Args;
use pacinian::io::error::FileError;
use pacinian::io::journal::files::{self, Files};
use pacinian::io::journal::{Form, Journal, Setting};
use pacinian::io::osc::counts::Counts;
use pacinian::io::recorder::Recorder;
use pacinian::io::session::Session;
use pacinian::io::wav::{Encoding, WavSpec};
use pacinian::live::board::Board;
use pacinian::live::reload::Reload;
use pacinian::text::problem::escaped;
use ringbuf::HeapCons;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What is to be kept of a session.
#[derive(Debug, Clone, Default, Args)]
pub struct Keep {
    /// Keeps exactly what is sent to the card, as 32-bit samples at its rate
    #[arg(long, value_name = "FILE.wav")]
    pub record: Option<PathBuf>,
    /// Writes a journal of the session: everything that comes in and is played, when and why, with patch and rig. A table (.csv) or
    /// JSON lines (.jsonl); pacinian replay plays it again, to the bit
    #[arg(long, value_name = "FILE")]
    pub events: Option<PathBuf>,
    /// Lets --record and --events replace files that are there
    #[arg(long)]
    pub replace: bool,
}

/// How often the journal says how frames and time belong together.
const CLOCK: Duration = Duration::from_secs(1);

/// What comes from a session that is to be kept.
pub struct Sound {
    sent: Option<HeapCons<f32>>,
    heard: Option<(HeapCons<f32>, usize)>,
    channels: usize,
    rate: u32,
}

impl Sound {
    /// Of a session.
    pub fn of(session: &mut Session) -> Self {
        let (sent, heard) = (session.recording(), session.recording_input());
        Self { sent, heard, channels: session.board().channels(), rate: session.rate() as u32 }
    }
}

/// What is being kept.
#[derive(Default)]
pub struct Kept {
    sent: Option<(Recorder, PathBuf)>,
    heard: Option<(Recorder, PathBuf)>,
    journal: Option<(Journal, PathBuf)>,
    /// Recordings that are played while they may be saved anew.
    files: Option<Files>,
    /// Files that were not there before.
    made: Vec<PathBuf>,
    clock: Option<Instant>,
    /// Those of which it was said that they take no more.
    said: Vec<PathBuf>,
}

impl Keep {
    /// Where a journal has what was heard: beside it, under its name.
    fn heard(&self) -> Option<PathBuf> {
        self.events.as_ref().map(|events| events.with_extension("input.wav"))
    }

    /// Where recordings are kept that are played while they may be saved anew: beside the journal.
    pub fn files(&self) -> Option<Files> {
        self.events.as_deref().map(Files::beside)
    }

    /// Refuses files that cannot be, or that have something in them, before anything plays.
    ///
    /// # Errors
    /// As [`check_kept`] and [`check_new`].
    pub fn check(&self, loaded: &Loaded, hears: bool, watch: bool) -> Result<(), Failure> {
        let record = self.record.as_deref();
        if let Some(record) = record {
            check_kept(record, "--record", &[], Some(loaded))?;
        }
        let heard = self.heard().filter(|_| hears);
        if let Some(events) = &self.events {
            Form::of(events).map_err(|error| Failure::said(2, error.message))?;
            let others: Vec<&Path> = record.into_iter().collect();
            check_kept(events, "--events", &others, Some(loaded))?;
            if let Some(heard) = &heard {
                check_kept(heard, "--events", &others, Some(loaded))?;
            }
        }
        if let Some(folder) = self.events.as_deref().filter(|_| watch).map(files::beside) {
            check_folder(&folder, self.replace)?;
        }
        let files = [record, self.events.as_deref(), heard.as_deref()].into_iter().flatten();
        files.filter(|_| !self.replace).try_for_each(check_new)
    }

    /// The journal, where one is wanted, which says this of the session, and what is kept of it. Its file is made by [`Keep::begin`].
    ///
    /// # Errors
    /// A name that no journal has.
    pub fn journal(&self, reload: &Reload, setting: Setting) -> Result<Option<Journal>, FileError> {
        let hears = !reload.scene.plan.inputs().is_empty();
        let input = self.heard().filter(|_| hears);
        let input = input.and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
        let recording = self.record.as_ref().map(|record| record.display().to_string());
        let setting = Setting { input, recording, ..setting };
        let new = |path: &PathBuf| {
            Journal::new(path, setting.clone(), &reload.scene.plan, reload.provenance.as_deref())
        };
        self.events.as_ref().map(new).transpose()
    }

    /// Begins to keep what a session sends, hears and does; to be called when all else is ready. The files are made here.
    ///
    /// # Errors
    /// A file that cannot be made; the others are as they were then.
    pub fn begin(
        &self,
        sound: Sound,
        journal: Option<Journal>,
        files: Option<Files>,
        loaded: &Loaded,
    ) -> Result<Kept, FileError> {
        let mut kept = Kept { files, ..Kept::default() };
        match self.make(&mut kept, sound, journal, loaded) {
            Ok(()) => Ok(kept),
            Err(error) => {
                kept.abandon();
                Err(error)
            }
        }
    }

    fn make(
        &self,
        kept: &mut Kept,
        sound: Sound,
        journal: Option<Journal>,
        loaded: &Loaded,
    ) -> Result<(), FileError> {
        // Whether it takes its first bytes or not.
        let mut made = |path: &PathBuf| kept.made.extend((!path.exists()).then(|| path.clone()));
        if let Some((path, ring)) = self.record.as_ref().zip(sound.sent) {
            let mut spec = WavSpec::new(sound.channels, sound.rate, Encoding::F32);
            spec.title.clone_from(&loaded.patch.title);
            spec.tactors = loaded.tactors();
            made(path);
            kept.sent = Some((Recorder::start(ring, path, spec)?, path.clone()));
        }
        if let Some((path, (ring, channels))) = self.heard().zip(sound.heard) {
            // What was not heard of a knob's sensor is kept as what it is.
            let spec = WavSpec { unbounded: true, ..WavSpec::new(channels, sound.rate, Encoding::F32) };
            made(&path);
            kept.heard = Some((Recorder::start_with_digest(ring, &path, spec)?, path.clone()));
        }
        if let Some((journal, path)) = journal.zip(self.events.as_ref()) {
            made(path);
            journal.open()?;
            if self.replace {
                files::clear(path)?;
            }
            kept.journal = Some((journal, path.clone()));
        }
        Ok(())
    }
}

impl Kept {
    /// To be called often. What goes wrong is said once; playing goes on.
    pub fn look(&mut self, session: &Session) -> Option<String> {
        if let Some((journal, _)) = &self.journal {
            journal.gaps();
        }
        if self.clock.is_none_or(|clock| clock.elapsed() >= CLOCK) {
            self.clock = Some(Instant::now());
            if let Some((journal, _)) = &self.journal {
                journal.clock(session.clock().moment());
            }
        }
        let failed = |path: &Path| Some(format!("`{}` takes no more; the rest is not kept", shown(path)));
        let recorders = self.sent.iter().chain(&self.heard);
        let recorders = recorders.filter(|(recorder, _)| recorder.has_failed()).map(|(_, path)| path);
        let journal = self.journal.iter().filter(|(journal, _)| journal.has_failed()).map(|(_, path)| path);
        let files = self.files.iter().filter(|files| files.has_failed()).map(Files::folder);
        let path = recorders
            .map(PathBuf::as_path)
            .chain(journal.map(PathBuf::as_path))
            .chain(files)
            .find(|path| self.said.iter().all(|said| said != path))?
            .to_path_buf();
        let trouble = failed(&path);
        self.said.push(path);
        trouble
    }

    /// Forgets a session that has not begun: files that are new are gone again.
    pub fn abandon(self) {
        // Nobody waits for what they would have said.
        for (recorder, _) in self.sent.into_iter().chain(self.heard) {
            let _ = recorder.finish();
        }
        if let Some((journal, _)) = self.journal {
            let _ = journal.finish();
        }
        if let Some(files) = self.files {
            let _ = files.finish();
        }
        for path in self.made {
            let _ = std::fs::remove_file(path);
        }
    }

    /// What came over OSC and could not be used is in the journal as well.
    pub fn counted(&self, osc: &Counts) {
        if let Some((journal, _)) = &self.journal {
            let all = [("osc", osc.messages.get())];
            journal.counted(all.into_iter().chain(osc.named().map(|(name, count, _)| (name, count))));
        }
    }

    /// Completes the files, after the session has stopped.
    ///
    /// # Errors
    /// What went wrong with them.
    pub fn finish(self, board: &Board, terminal: &Terminal) -> Result<(), Failure> {
        let mut failure = Failure::default();
        let note = |path: &Path, frames: u64, missed: u64, words: &str| {
            let path = shown(path);
            let but = if missed > 0 { ", but for those that found no room" } else { "" };
            terminal.note(&format!("{path}: {} frames, as they were {words}{but}\n", grouped(frames)));
            if missed == 0 {
                return Failure::default();
            }
            let what = format!("{path}: {} frames found no room and are silence there", grouped(missed));
            Failure::usage(what, "write to a faster disk").with_code(74)
        };
        if let Some((recorder, path)) = self.sent {
            match recorder.finish() {
                Ok(written) => failure.join(note(&path, written.frames, board.unrecorded.get(), "sent")),
                Err(error) => failure.join(error.into()),
            }
        }
        if let Some((recorder, path)) = self.heard {
            match recorder.finish_with_digest() {
                Ok((written, digest)) => {
                    failure.join(note(&path, written.frames, board.input.unrecorded.get(), "heard"));
                    if let Some(((journal, _), digest)) = self.journal.as_ref().zip(digest) {
                        journal.heard(written.frames, digest);
                    }
                }
                Err(error) => failure.join(error.into()),
            }
        }
        let (mut whole, folder) = (true, self.files.as_ref().map(|files| shown(files.folder())));
        match self.files.map(|files| files.finish()).transpose() {
            Ok(None | Some(0)) => {}
            Ok(Some(count)) => {
                let recordings = many(count, "recording");
                let folder = folder.unwrap_or_default();
                terminal.note(&format!("{folder}: {recordings} of the journal, as they were played\n"));
            }
            Err(error) => {
                whole = false;
                failure.join(error.into());
            }
        }
        if let Some((journal, path)) = self.journal {
            match journal.finish() {
                Ok(0) if !whole => {
                    let lacks = "which lacks a recording that was saved anew";
                    terminal.note(&format!("{}: the journal, {lacks}\n", shown(&path)));
                }
                Ok(0) => {
                    let word = word(&path).map_or(String::new(), |word| format!(" {word}"));
                    let path = shown(&path);
                    terminal.note(&format!("{path}: the journal; pacinian replay{word} plays it again\n"));
                }
                Ok(lost) => {
                    let lines = grouped(lost);
                    terminal.note(&format!("{}: the journal, which lacks {lines} lines\n", shown(&path)));
                }
                Err(error) => failure.join(error.into()),
            }
        }
        if failure.is_none() { Ok(()) } else { Err(failure) }
    }
}

fn shown(path: &Path) -> String {
    escaped(&path.display().to_string()).into_owned()
}

/// A path as a word of a shell; `None` where it has what is not to be shown.
fn word(path: &Path) -> Option<String> {
    let path = path.display().to_string();
    let plain = |c: char| c.is_alphanumeric() || "/._-+,:@%".contains(c);
    if escaped(&path) != path {
        return None;
    }
    Some(match !path.is_empty() && path.chars().all(plain) {
        true => path,
        false => format!("'{}'", path.replace('\'', "'\\''")),
    })
}

#[cfg(all(test, unix))]
mod tests {
    use super::word;
    use std::path::Path;

    #[test]
    fn a_path_with_blanks_or_quotes_is_one_word_of_a_shell() {
        for path in ["plain/file-1.csv", "two words.csv", "it's.csv", "a;b$c.csv"] {
            let said = std::process::Command::new("sh")
                .args(["-c", &format!("printf %s {}", word(Path::new(path)).unwrap())])
                .output();
            assert_eq!(said.unwrap().stdout, path.as_bytes());
        }
        assert_eq!(word(Path::new("plain/file-1.csv")).unwrap(), "plain/file-1.csv");
        assert_eq!(word(Path::new("line\nbreak.csv")), None);
    }
}
