//! `pacinian replay`.

use super::check::json;
use super::failure::Failure;
use super::place::check_kept;
use super::progress::Progress;
use super::stop::Stop;
use super::table::{Table, dbfs, grouped};
use super::terminal::Terminal;
use clap::Args;
use pacinian::io::journal::remake::RemakeError;
use pacinian::io::journal::replay::{Replay as Player, ReplayError};
use pacinian::io::wav::{Encoding, WavReader, WavSpec, WavWriter};
use pacinian::text::problem::escaped;
use serde::Serialize;
use std::fs::File;
use std::io::BufReader;
use std::path::PathBuf;

/// Plays the journal of a session again, to the bit
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pacinian play patches/04-heartbeat.toml --record heard.wav --events heard.csv --duration 5\n  \
    pacinian replay heard.csv --against heard.wav\n  pacinian replay heard.csv -o again.wav\n\n\
    A journal holds patch and rig as they were, also those that were saved in between, and every event with its sample; so the same \
    version of pacinian gives the same samples on any machine. Recordings that the patch names must still be where they were, or in \
    --folder, and be the same.\n\
    With --against, the exit code is 1 where anything differs."
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
    /// The folder in which the patch's recordings are [default: where they were]
    #[arg(long, value_name = "DIR")]
    folder: Option<PathBuf>,
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
    reloads: u64,
    /// Lines that the journal lacks.
    lost: u64,
    /// Whether the journal goes to the session's end.
    whole: bool,
    peaks: Vec<f32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    comparison: Option<Comparison>,
}

/// What is different from a recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Comparison {
    recording: String,
    identical: bool,
    frames: u64,
    /// Frames that only one of them has.
    only_in_one: u64,
    /// Samples that differ.
    different: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    first: Option<Difference>,
    /// The largest difference.
    largest: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
struct Difference {
    frame: u64,
    /// From 1.
    channel: usize,
    recorded: f32,
    replayed: f32,
}

/// A replay, whose frames go where they are wanted.
struct Run<'a> {
    player: Player<BufReader<File>>,
    writer: Option<WavWriter<pacinian::io::out::OutputFile>>,
    peaks: Vec<f32>,
    stop: &'a Stop,
    progress: Progress,
}

impl Run<'_> {
    /// The next frames; none at the end, or when somebody has asked to stop.
    fn block(&mut self, to: &mut Vec<f32>) -> Result<(), Failure> {
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
        if let Some(output) = &self.output {
            let others: Vec<_> = [Some(&self.journal), self.against.as_ref()].into_iter().flatten().collect();
            let others: Vec<_> = others.into_iter().map(PathBuf::as_path).collect();
            check_kept(output, "-o", &others, None)?;
        }
        let player = Player::open(&self.journal, self.folder.as_deref())?;
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
        if let Some(writer) = run.writer {
            writer.finish()?;
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
            reloads: met.swaps,
            lost: met.lost,
            whole: met.ended,
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
}

/// Compares every sample with those of a recording, by their bits.
fn compare(run: &mut Run<'_>, path: &PathBuf) -> Result<Comparison, Failure> {
    let mut reader = WavReader::open(path)?;
    let (info, head) = (reader.info(), run.player.head().clone());
    if info.channels != head.channels || f64::from(info.rate) != head.rate || !info.float {
        let is = |channels: usize, rate: f64| format!("{channels} channels at {rate} Hz");
        let stored = if info.float { "" } else { ", stored as integers" };
        let what = format!(
            "`{}` has {}{stored}, the session had {} as 32-bit floats",
            path.display(),
            is(info.channels, f64::from(info.rate)),
            is(head.channels, head.rate)
        );
        return Err(Failure::usage(what, "name what play --record has kept of the same session"));
    }
    let channels = head.channels.max(1);
    let mut found = Comparison {
        recording: path.display().to_string(),
        identical: true,
        frames: 0,
        only_in_one: 0,
        different: 0,
        first: None,
        largest: 0.0,
    };
    let (mut ours, mut at, mut failed) = (Vec::new(), 0, None);
    let read = reader.each_frame(|theirs| {
        if at == ours.len() {
            at = 0;
            if let Err(failure) = run.block(&mut ours) {
                failed = Some(failure);
                // It is told below, in its own words.
                return Err(String::new());
            }
        }
        let Some(frame) = ours.get(at..at + channels) else {
            found.only_in_one += 1;
            return Ok(());
        };
        at += channels;
        for (channel, (&recorded, &replayed)) in theirs.iter().zip(frame).enumerate() {
            if recorded.to_bits() != replayed.to_bits() {
                found.different += 1;
                found.largest = found.largest.max(f64::from(recorded - replayed).abs());
                let here = Difference { frame: found.frames, channel: channel + 1, recorded, replayed };
                found.first.get_or_insert(here);
            }
        }
        found.frames += 1;
        Ok(())
    });
    if let Some(failure) = failed {
        return Err(failure);
    }
    read?;
    found.only_in_one += ((ours.len() - at) / channels) as u64;
    while {
        run.block(&mut ours)?;
        !ours.is_empty()
    } {
        found.only_in_one += (ours.len() / channels) as u64;
    }
    found.identical = found.different == 0 && found.only_in_one == 0;
    Ok(found)
}

impl Summary {
    fn text(&self, terminal: &Terminal) -> String {
        let paint = terminal.out;
        let mut table = Table::default();
        table.row(["session".into(), format!("{}, on {}", self.began, self.device)]);
        table.row(["channels".into(), format!("{} at {} Hz", self.channels, self.rate)]);
        table.row(["length".into(), format!("{:.3} s, {} frames", self.seconds, grouped(self.frames))]);
        table.row(["events".into(), grouped(self.events)]);
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
            let what = "the journal breaks off before the session's end; what it has was played";
            text += &format!("\n{}\n", paint.yellow(what));
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

impl Comparison {
    fn text(&self) -> String {
        if self.identical {
            return format!("  the same, to the bit, in {} frames", grouped(self.frames));
        }
        let mut text = String::from("  different");
        if let Some(Difference { frame, channel, recorded, replayed }) = self.first {
            text += &format!(
                ": first in frame {} on channel {channel}, {recorded:e} there and {replayed:e} here; {} samples, by {:.1e} at most",
                grouped(frame),
                grouped(self.different),
                self.largest
            );
        }
        if self.only_in_one > 0 {
            text += &format!("; {} frames are only in one of them", grouped(self.only_in_one));
        }
        text
    }
}
