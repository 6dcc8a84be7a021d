//! `pacinian render`.

use super::check::json;
use super::failure::Failure;
use super::load::{Loaded, Scene};
use super::perform::{Until, perform};
use super::problems;
use super::stop::Stop;
use super::summary::Summary;
use super::terminal::Terminal;
use clap::Args;
use pacinian::io::wav::{Encoding, WavSpec, WavWriter};
use pacinian::player::Player;
use pacinian::text::{Problem, Severity};
use std::path::{Path, PathBuf};

/// Renders a patch to a WAV file with a channel for each tactor
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pacinian render patches/04-heartbeat.toml --rig rigs/belt.toml -o heartbeat.wav\n\n\
    The file plays at any time, also while it is written and when the program is stopped: Ctrl-C completes it as far as it is.\n\
    It ends when the patterns are over and nothing rings any more; patterns without end need --duration or --input."
)]
pub struct Render {
    #[command(flatten)]
    scene: Scene,
    /// The WAV file to write; one that is there is replaced
    #[arg(short, long, value_name = "FILE.wav")]
    output: PathBuf,
    /// How samples are stored: f32, or i24 or i16 with dither
    #[arg(long, value_name = "FORMAT", default_value = "f32")]
    format: Encoding,
    /// Seconds to render [default: what the patch says, else until everything is over]
    #[arg(long, value_name = "S", value_parser = seconds)]
    duration: Option<f64>,
    /// The summary as one JSON object
    #[arg(long)]
    json: bool,
}

/// A time above zero.
pub fn seconds(word: &str) -> Result<f64, String> {
    match word.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= 1e9 => Ok(seconds),
        _ => Err("it must be a number of seconds above 0, at most 1e9".into()),
    }
}

/// Refuses to write where nothing good would come of it: to a pipe, or over a file that is read.
///
/// # Errors
/// Says which of them.
pub fn check_output(output: &Path, loaded: &Loaded) -> Result<(), Failure> {
    if output.as_os_str() == "-" {
        return Err(Failure::usage(
            "a file whose length is written last cannot go to standard output",
            "name a file: -o out.wav",
        ));
    }
    let Ok(real) = output.canonicalize() else { return Ok(()) };
    if loaded.files.iter().any(|file| file.canonicalize().is_ok_and(|file| file == real)) {
        let what = format!("`{}` is read for this rendering, so it is not written over", output.display());
        return Err(Failure::usage(what, "choose another file for -o"));
    }
    Ok(())
}

impl Render {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let loaded = self.scene.load(false)?;
        for warnings in &loaded.warnings {
            terminal.note(&problems::shown(warnings, terminal));
        }
        let wav = Wav { output: &self.output, format: self.format, duration: self.duration, record: false };
        let rendered = wav.write(&loaded, terminal, |_| {})?;
        let summary = &rendered.summary;
        terminal.print(&if self.json { json(summary) } else { summary.text(terminal.out) })?;
        rendered.ending
    }
}

/// A WAV file to be written.
#[derive(Debug, Clone, Copy)]
pub struct Wav<'a> {
    /// Where.
    pub output: &'a Path,
    /// How samples are stored.
    pub format: Encoding,
    /// Seconds, where somebody said so.
    pub duration: Option<f64>,
    /// Whether the player keeps what it plays.
    pub record: bool,
}

/// A WAV file that was written.
pub struct Rendered {
    /// What it turned out to be.
    pub summary: Summary,
    /// Why it ended early, if it did.
    pub ending: Result<(), Failure>,
    /// The player at its end.
    pub player: Player,
}

impl Wav<'_> {
    /// Renders, showing each block to `also`.
    ///
    /// # Errors
    /// When there is no file, or no complete one for want of room.
    pub fn write(
        self,
        loaded: &Loaded,
        terminal: &Terminal,
        mut also: impl FnMut(&[f32]),
    ) -> Result<Rendered, Failure> {
        let Self { output, format, duration, record } = self;
        check_output(output, loaded)?;
        let mut player = loaded.player()?;
        if record {
            player.record();
        }
        let until = Until::of(loaded, &player, duration)?;
        let rate = player.plan().device_rate as u32;
        let mut spec = WavSpec::new(player.plan().channels, rate, format);
        spec.seed = player.plan().seed;
        spec.title.clone_from(&loaded.patch.title);
        spec.tactors = loaded.tactors();
        let stop = Stop::listen()?;
        let mut writer = WavWriter::create(output, spec)?;
        let shown = output.display().to_string();
        let performed = perform(&mut player, loaded.input.as_deref(), until, &stop, terminal, |block| {
            also(block);
            writer.write(block)
        });
        let performed = performed.map_err(|(error, frames)| {
            let mut failure = Failure::from(error);
            if frames > 0 {
                let seconds = frames as f64 / f64::from(rate);
                failure.join(Failure::said(74, format!("`{shown}` plays, but ends before {seconds:.1} s")));
            }
            failure
        })?;
        let written = writer.finish()?;
        let seconds = written.frames as f64 / f64::from(rate);
        let ending = if let Some(code) = performed.stopped {
            let problem = Problem {
                severity: Severity::Warning,
                ..Problem::of_file(format!("stopped; `{shown}` is complete up to {seconds:.3} s"))
            };
            terminal.note(&problems::sentence(&problem, terminal));
            Err(Failure::told(code))
        } else if let Some(trouble) = player.trouble() {
            let mut failure = loaded.refuse(vec![trouble.clone()], &[]);
            failure.join(Failure::said(65, format!("`{shown}` holds the {seconds:.3} s before that")));
            Err(failure)
        } else {
            Ok(())
        };
        let summary = Summary::new(loaded, shown, format, &player, &performed, &written);
        Ok(Rendered { summary, ending, player })
    }
}
