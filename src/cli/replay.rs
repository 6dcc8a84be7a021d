//! `pacinian replay`.

use super::against::{Comparison, compare};
use super::check::json;
use super::failure::Failure;
use super::place::{check_kept, check_own};
use super::progress::Progress;
use super::stop::Stop;
use super::table::{Table, dbfs, grouped};
use super::terminal::Terminal;
use clap::Args;
use pacinian::io::error::FileError;
use pacinian::io::journal::files;
use pacinian::io::journal::reader::{Item, Reader};
use pacinian::io::journal::remake::{Recordings, RemakeError};
use pacinian::io::journal::replay::{Replay as Player, ReplayError};
use pacinian::io::wav::{Encoding, WavSpec, WavWriter};
use pacinian::live::provenance::RigText;
use pacinian::text::problem::escaped;
use serde::Serialize;
use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// Plays the journal of a session again, to the bit
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pacinian play patches/04-heartbeat.toml --record heard.wav --events heard.csv --duration 5\n  \
    pacinian replay heard.csv --against heard.wav\n  pacinian replay heard.csv -o again.wav\n\n\
    A journal holds patch and rig as they were, also those that were saved in between, and every event with its sample; so the same \
    version of pacinian gives the same samples on any machine. Recordings that the patch names must still be where they were, or in \
    --folder, and be the same, or in the folder beside the journal that play --watch has made; what the session heard must still be beside the journal.\n\
    A journal that breaks off is played as far as it tells of.\n\
    With --against, the exit code is 1 where anything differs, be it the length."
)]
pub struct Replay {
    /// The journal: what pacinian play --events has written
    journal: PathBuf,
    /// The WAV file to write; one that is there is replaced
    #[arg(short, long, value_name = "FILE.wav")]
    output: Option<PathBuf>,
    /// A recording of the same session, by play --record, to compare with bit by bit
    #[arg(long, value_name = "FILE.wav")]
    against: Option<PathBuf>,
    /// The folder that the patch's recordings are in [default: where they were]
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
    /// Lets recordings lie outside that folder, as play --allow-outside did
    #[arg(long)]
    allow_outside: bool,
    /// The summary as one JSON object
    #[arg(long)]
    json: bool,
}

/// The exit code where something differs.
const DIFFERENT: u8 = 1;

impl From<ReplayError> for Failure {
    fn from(error: ReplayError) -> Self {
        match error {
            ReplayError::File(error) | ReplayError::Scene(RemakeError::File(error)) => error.into(),
            ReplayError::Scene(RemakeError::Journal(what)) => {
                Self::usage(what, "play the journal as it was written").with_code(65)
            }
            ReplayError::Scene(RemakeError::Scene(problems)) => Self::of(65, problems),
        }
    }
}

/// What a replay turned out to be.
#[derive(Debug, Serialize)]
struct Summary {
    journal: String,
    device: String,
    began: String,
    version: String,
    rate: f64,
    channels: usize,
    frames: u64,
    seconds: f64,
    events: u64,
    /// Voices that began, those that nodes set off among them.
    voices: u64,
    reloads: u64,
    /// Lines that the journal lacks.
    lost: u64,
    /// Whether the journal goes to the session's end.
    whole: bool,
    /// The frame at which the recording of what was heard ends, where the session goes on.
    #[serde(skip_serializing_if = "Option::is_none")]
    deaf_from: Option<u64>,
    /// Frames of what was heard that are silence in the recording of it.
    unheard: u64,
    peaks: Vec<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    comparison: Option<Comparison>,
}

/// A replay, whose frames go where they are wanted.
pub struct Run<'a> {
    /// What plays.
    pub player: Player<BufReader<File>>,
    writer: Option<WavWriter<pacinian::io::out::OutputFile>>,
    peaks: Vec<f32>,
    stop: &'a Stop,
    progress: Progress,
}

impl Run<'_> {
    /// The next frames; none at the end, or when somebody has asked to stop.
    ///
    /// # Errors
    /// A journal that cannot be played, and an output that cannot be written.
    pub fn block(&mut self, to: &mut Vec<f32>) -> Result<(), Failure> {
        to.clear();
        if self.stop.asked().is_some() {
            return Ok(());
        }
        if let Some(frames) = self.player.block()? {
            to.extend_from_slice(frames);
        }
        if let Some(writer) = &mut self.writer {
            writer.write(to)?;
        }
        let channels = self.peaks.len().max(1);
        for frame in to.chunks(channels) {
            for (peak, sample) in self.peaks.iter_mut().zip(frame) {
                *peak = peak.max(sample.abs());
            }
        }
        self.progress.at(self.player.met().frames as f64 / self.player.head().rate);
        Ok(())
    }
}

impl Replay {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let (folder, kept) = (self.folder.clone(), Some(files::beside(&self.journal)));
        let recordings = Recordings { folder, allow_outside: self.allow_outside, kept };
        if let Some(output) = &self.output {
            let others: Vec<_> = [Some(&self.journal), self.against.as_ref()].into_iter().flatten().collect();
            let others: Vec<_> = others.into_iter().map(PathBuf::as_path).collect();
            check_kept(output, "-o", &others, None)?;
            if output.exists() {
                check_own(output, "-o", &self.own(&recordings)?)?;
            }
        }
        let player = Player::open(&self.journal, recordings)?;
        let head = player.head().clone();
        if head.pacinian != env!("CARGO_PKG_VERSION") {
            let (then, now) = (escaped(&head.pacinian), env!("CARGO_PKG_VERSION"));
            terminal
                .note(&format!("pacinian {then} has played this; pacinian {now} may play it otherwise\n"));
        }
        let spec = WavSpec::new(head.channels, head.rate as u32, Encoding::F32);
        let stop = Stop::listen()?;
        let mut run = Run {
            player,
            writer: self.output.as_ref().map(|output| WavWriter::create(output, spec)).transpose()?,
            peaks: vec![0.0; head.channels],
            stop: &stop,
            progress: Progress::new(terminal, None),
        };
        let comparison = match &self.against {
            Some(recording) => Some(compare(&mut run, recording)?),
            None => {
                let mut frames = Vec::new();
                while {
                    run.block(&mut frames)?;
                    !frames.is_empty()
                } {}
                None
            }
        };
        let met = run.player.met();
        if let Some((writer, output)) = run.writer.zip(self.output.as_ref()) {
            let frames = grouped(writer.finish()?.frames);
            terminal.note(&format!("{}: {frames} frames, as they were sent\n", output.display()));
        }
        let summary = Summary {
            journal: self.journal.display().to_string(),
            device: head.device,
            began: head.utc,
            version: head.pacinian,
            rate: head.rate,
            channels: head.channels,
            frames: met.frames,
            seconds: met.frames as f64 / head.rate,
            events: met.events,
            voices: met.voices,
            reloads: met.swaps,
            lost: met.lost,
            whole: met.ended,
            deaf_from: met.deaf_from,
            unheard: met.unheard,
            peaks: run.peaks,
            comparison,
        };
        if let Some(code) = stop.asked() {
            terminal.note("stopped\n");
            return Err(Failure::told(code));
        }
        terminal.print(&if self.json { json(&summary) } else { summary.text(terminal) })?;
        match &summary.comparison {
            Some(comparison) if !comparison.identical => Err(Failure::told(DIFFERENT)),
            _ => Ok(()),
        }
    }

    /// The files that the session is made of, as far as the journal names them.
    fn own(&self, recordings: &Recordings) -> Result<Vec<PathBuf>, FileError> {
        let beside = |name: &str| self.journal.parent().unwrap_or(Path::new("")).join(name);
        let mut reader = Reader::open(&self.journal)?;
        let mut files = Vec::new();
        while let Some(item) = reader.read()? {
            match item {
                Item::Session(head) => {
                    files.extend(head.input.as_deref().map(beside));
                    if let Some(recording) = head.recording.as_ref().map(Path::new) {
                        files.push(recording.to_owned());
                        files.extend(recording.file_name().map(|name| beside(&name.to_string_lossy())));
                    }
                }
                Item::Plan(plan) => {
                    let Some(made_of) = plan.made_of else { continue };
                    let folder = recordings.folder(&made_of);
                    files.extend(made_of.files.iter().map(|file| folder.root().join(&file.path)));
                    let kept = recordings.kept.as_deref();
                    let copy = |sha256: &str| files::copy_in(kept?, sha256);
                    files.extend(made_of.files.iter().filter_map(|file| copy(&file.sha256)));
                    files.push(made_of.patch.name.into());
                    if let RigText::Text(rig) = made_of.rig {
                        files.push(rig.name.into());
                    }
                }
                Item::Line(_) => {}
            }
        }
        Ok(files)
    }
}

impl Summary {
    fn text(&self, terminal: &Terminal) -> String {
        let paint = terminal.out;
        let mut table = Table::default();
        table.row(["session".into(), format!("{}, on {}", escaped(&self.began), escaped(&self.device))]);
        table.row(["channels".into(), format!("{} at {} Hz", self.channels, self.rate)]);
        table.row(["length".into(), format!("{:.3} s, {} frames", self.seconds, grouped(self.frames))]);
        table.row(["events".into(), grouped(self.events)]);
        table.row(["voices".into(), grouped(self.voices)]);
        if self.reloads > 0 {
            table.row(["reloads".into(), grouped(self.reloads)]);
        }
        let mut text = format!("{}\n{}", paint.bold(&self.journal), table.text());
        let mut peaks = Table::default();
        for (channel, peak) in self.peaks.iter().enumerate().filter(|(_, peak)| **peak > 0.0) {
            peaks.row([(channel + 1).to_string(), dbfs(*peak)]);
        }
        text += &format!("\n{}\n{}", paint.bold("peaks"), peaks.text());
        if !self.whole {
            let what = "the journal breaks off before the session's end; it was played as far as it tells of";
            text += &format!("\n{}\n", paint.yellow(what));
        }
        if let Some(frame) = self.deaf_from {
            let what = format!(
                "the recording of what was heard ends at frame {}: silence was heard from there on",
                grouped(frame)
            );
            text += &format!("\n{}\n", paint.yellow(&what));
        }
        if self.unheard > 0 {
            let what = format!(
                "{} frames of what was heard could not be recorded and were silence here, so this is not all that was played",
                grouped(self.unheard)
            );
            text += &format!("\n{}\n", paint.yellow(&what));
        }
        if self.lost > 0 {
            let what =
                format!("the journal lacks {} lines, so this is not all that was played", grouped(self.lost));
            text += &format!("\n{}\n", paint.yellow(&what));
        }
        if let Some(comparison) = &self.comparison {
            text += &format!("\n{}\n{}\n", paint.bold(&comparison.recording), comparison.text());
        }
        text
    }
}
