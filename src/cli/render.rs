//! `pacinian render`.

use super::check::json;
use super::failure::Failure;
use super::feel::Felt;
use super::form;
use super::load::Scene;
use super::loaded::Loaded;
use super::named::Codes;
use super::perform::{Until, perform};
use super::place::{check_kept, check_log, check_wav};
use super::problems;
use super::stop::Stop;
use super::summary::Summary;
use super::terminal::Terminal;
use clap::Args;
use pacinian::feel::Wish;
use pacinian::io::error::FileError;
use pacinian::io::log::{EventLog, Head};
use pacinian::io::wav::{Encoding, REFRESH, WavSpec, WavWriter};
use pacinian::player::Player;
use pacinian::text::{Problem, Severity};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Renders a patch to a WAV file with a channel for each tactor
#[derive(Debug, Args)]
#[command(
    after_help = "Example:\n  pacinian render patches/04-heartbeat.toml --rig rigs/belt.toml -o heartbeat.wav\n  \
    pacinian render patches/19-countdown.toml -o countdown.wav --log countdown.csv\n  \
    pacinian render patches/30-motor.toml --rig rigs/motors.toml -o motor.wav --feel felt.wav\n\n\
    The file plays at any time, also while it is written and when the program is stopped: Ctrl-C completes it as far as it is.\n\
    It ends when the patterns are over and nothing rings any more; patterns without end need --duration or --input.\n\n\
    The log of --log has a first line with patch, seed and rates, and set=\"CONTROL=VALUE;...\" after --set, a second with the names of the columns, and a line for each \
    event as it is scheduled: seconds, engine sample and fraction of one; voice, marker or control; the pattern, which of its \
    events (from 1, in the order of the file, so a shuffled pattern shows what landed where) and which alternative of a `choose` \
    was drawn (from 1); name, tactor, level, frequency, other fields, duration, id. Of a voice that a node has set off, the pattern \
    is what did so, `node.tap rises 0.2`, and the event how often it had; its line comes a little after those of its time. Instants are those of the events: what is felt \
    comes later by the delay in the first line. The same patch and seed give the same log."
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
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Writes every event that is played to a table too: when, which of which pattern, what was drawn
    #[arg(long, value_name = "FILE.csv")]
    log: Option<PathBuf>,
    /// Writes what is felt too: what each casing, or contactor on the skin, does by the model of its actuator, in m/s2 (floats that are figures,
    /// not sound)
    #[arg(long, value_name = "FILE.wav")]
    feel: Option<PathBuf>,
    /// The largest error of what is felt, as a share of what the rated drive makes: models leave out what that allows
    #[arg(long, value_name = "X", default_value_t = 1e-3, value_parser = share, requires = "feel", allow_negative_numbers = true)]
    feel_error: f64,
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

/// A share of what is felt.
fn share(word: &str) -> Result<f64, String> {
    let error = word.parse().map_err(|_| "it must be a number, such as 0.001".to_string())?;
    let kept = Wish { error }.check().map(|()| error);
    kept.map_err(|_| "it must be within 1e-9 and 0.5 of what is felt".into())
}

/// A log that the player and whoever renders both know.
#[derive(Debug, Clone)]
struct Log(Arc<Mutex<EventLog>>);

impl Log {
    fn create(path: &Path, loaded: &Loaded, player: &mut Player) -> Result<Self, FileError> {
        let plan = player.plan();
        let head = Head {
            patch: loaded.name().into(),
            seed: plan.seed,
            device_rate: plan.device_rate,
            engine_rate: plan.engine_rate(),
            delay: player.engine().delay().total(),
            set: loaded.settings.iter().map(|s| (s.control.clone(), s.value)).collect(),
        };
        let log = Self(Arc::new(Mutex::new(EventLog::create(path, &head)?)));
        let heard = log.clone();
        player.listen(Box::new(move |event| heard.get().hear(event)));
        Ok(log)
    }

    fn get(&self) -> MutexGuard<'_, EventLog> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Render {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let loaded = self.scene.load(false, self.duration)?;
        for warnings in &loaded.warnings {
            terminal.note(&problems::shown(warnings, terminal));
        }
        let wav = Wav {
            output: &self.output,
            format: self.format,
            duration: self.duration,
            record: false,
            log: self.log.as_deref(),
            felt: self.feel.as_deref().map(|path| Felt { path, error: self.feel_error }),
        };
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
    /// Where every event goes, if anywhere.
    pub log: Option<&'a Path>,
    /// Where what is felt goes, if anywhere.
    pub felt: Option<Felt<'a>>,
}

/// A WAV file that was written.
pub struct Rendered {
    /// What it turned out to be.
    pub summary: Summary,
    /// Why it ended early, if it did.
    pub ending: Result<(), Failure>,
    /// The player at its end.
    pub player: Player,
    /// Whether somebody has asked to stop, then and later.
    pub stop: Stop,
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
        let Self { output, format, duration, record, log, felt } = self;
        check_wav(output, loaded)?;
        log.map_or(Ok(()), |log| check_log(log, output, loaded))?;
        if let Some(felt) = felt {
            let others: Vec<&Path> = log.into_iter().chain([output]).collect();
            check_kept(felt.path, "--feel", &others, Some(loaded))?;
        }
        let mut player = loaded.player()?;
        if record {
            player.record();
        }
        form::check(player.plan(), format)?;
        let until = Until::of(loaded, &player, duration)?;
        let rate = player.plan().device_rate as u32;
        let mut spec = WavSpec::new(player.plan().channels, rate, format);
        spec.seed = player.plan().seed;
        spec.title.clone_from(&loaded.patch.title);
        spec.tactors = loaded.tactors();
        let felt = felt.map(|felt| felt.prepare(loaded, player.plan())).transpose()?;
        let stop = Stop::listen()?;
        // Last, as it empties the file that may be there.
        let log = log.map(|path| Log::create(path, loaded, &mut player)).transpose()?;
        // What may fail more easily goes first.
        let mut felt = felt.map(|felt| felt.create()).transpose()?;
        let mut writer = WavWriter::create(output, spec)?;
        let shown = output.display().to_string();
        let mut refreshed = 0;
        let performed = perform(&mut player, loaded, until, &stop, terminal, |_, block| {
            also(block);
            writer.write(block)?;
            let rests = match &mut felt {
                Some(felt) => felt.write(block)?,
                None => true,
            };
            let Some(log) = &log else { return Ok(rests) };
            // As often as the WAV file, so that the log of one that is killed goes as far.
            let now = writer.frames() / (REFRESH * u64::from(rate));
            if std::mem::replace(&mut refreshed, now) == now {
                log.get().check()
            } else {
                log.get().flush()
            }?;
            Ok(rests)
        });
        let performed = performed.map_err(|(error, frames): (FileError, u64)| {
            let mut failure = Failure::from(error);
            if frames > 0 {
                let seconds = frames as f64 / f64::from(rate);
                failure.join(Failure::said(74, format!("`{shown}` plays, but ends before {seconds:.1} s")));
            }
            failure
        })?;
        let written = writer.finish()?;
        log.map_or(Ok(()), |log| log.get().flush())?;
        let also_shown = felt.as_ref().map(|felt| felt.shown());
        let feel = felt.map(|felt| felt.finish(loaded)).transpose()?;
        let seconds = written.frames as f64 / f64::from(rate);
        let ending = if let Some(code) = performed.stopped {
            let problem = Problem {
                severity: Severity::Warning,
                ..Problem::of_file(match also_shown {
                    None => format!("stopped; `{shown}` is complete up to {seconds:.3} s"),
                    Some(also) => {
                        format!("stopped; `{shown}` and `{also}` are complete up to {seconds:.3} s")
                    }
                })
            };
            terminal.note(&problems::sentence(&problem, terminal));
            Err(Failure::told(code))
        } else if let Some(trouble) = player.trouble() {
            let mut failure = loaded.refuse(vec![trouble.clone()], &Codes::new());
            failure.join(Failure::said(65, format!("`{shown}` holds the {seconds:.3} s before that")));
            Err(failure)
        } else {
            Ok(())
        };
        let mut summary = Summary::new(loaded, shown, format, &player, &performed, &written);
        summary.feel = feel;
        Ok(Rendered { summary, ending, player, stop })
    }
}
