//! `pacinian demo`.

use super::check::json;
use super::error::{decibels, reservation};
use super::failure::Failure;
use super::load::Scene;
use super::place::check_picture;
use super::plot::{collector, style};
use super::problems;
use super::progress::Progress;
use super::render::Wav;
use super::stop::Stop;
use super::summary::Summary;
use super::terminal::Terminal;
use clap::Args;
use pacinian::io::error::FileError;
use pacinian::io::out;
use pacinian::io::wav::Encoding;
use pacinian::player::Player;
use pacinian::report::{Comparison, Take};
use pacinian::text::Problem;
use serde::Serialize;
use std::path::PathBuf;
use std::time::Instant;

/// Renders a built-in showcase on 16 tactors: a WAV file, a picture, and how exact it is
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pacinian demo -o /tmp\n\n\
    No hardware is needed. The patch and the rig are patches/demo.toml and rigs/demo-16.toml of the project.")]
pub struct Demo {
    /// The folder to write pacinian-demo.wav and pacinian-demo.svg to; made where it is not there
    #[arg(short, long, value_name = "DIR", default_value = ".")]
    output: PathBuf,
    /// The summary as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Answer {
    #[serde(flatten)]
    summary: Summary,
    picture: String,
    error_db: Option<f64>,
    above_db: Option<f64>,
}

const PATCH: (&str, &str) = ("patches/demo.toml", include_str!("../../patches/demo.toml"));
const RIG: (&str, &str) = ("rigs/demo-16.toml", include_str!("../../rigs/demo-16.toml"));
const RECORDINGS: &[(&str, &[u8])] = &[
    ("recordings/corduroy.wav", include_bytes!("../../patches/recordings/corduroy.wav")),
    ("recordings/felt.wav", include_bytes!("../../patches/recordings/felt.wav")),
];

impl Demo {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let loaded = Scene::of_texts(PATCH, RIG, RECORDINGS)?;
        if !self.output.as_os_str().is_empty() {
            std::fs::create_dir_all(&self.output).map_err(|e| FileError::creating(&self.output, &e))?;
        }
        let (wav_path, svg_path) =
            (self.output.join("pacinian-demo.wav"), self.output.join("pacinian-demo.svg"));
        check_picture(&svg_path, &loaded)?;
        let mut picture = collector(&loaded, None);
        let wav = Wav {
            output: &wav_path,
            format: Encoding::F32,
            duration: None,
            record: true,
            log: None,
            felt: None,
        };
        let rendered = wav.write(&loaded, terminal, |block| picture.push(block))?;
        out::write(&svg_path, picture.svg(&style(&loaded)).as_bytes())?;
        let paint = terminal.out;
        let drawn = svg_path.display().to_string();
        if !self.json {
            let drawn = paint.bold(&drawn);
            let head = format!("\n{drawn}\n  what every tactor did, and the spectrum\n");
            terminal.print(&(rendered.summary.text(paint) + &head))?;
        }
        rendered.ending?;
        let player = rendered.player;
        let begin = Instant::now();
        // The summary does not wait for what takes longest.
        let measured = self.measure(&player, picture.seconds(), &rendered.stop, terminal);
        let (error, ending) = match measured {
            Ok(error) => (Some(error), Ok(())),
            Err(failure) => (None, Err(failure)),
        };
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let answer = Answer {
            summary: rendered.summary,
            picture: drawn,
            error_db: error.and_then(|error| finite(error.error_db)),
            above_db: error.and_then(|error| finite(error.above_db)),
        };
        if self.json {
            terminal.print(&json(&answer))?;
            return ending;
        }
        ending?;
        let mut text = format!("\n{}\n", paint.bold("error"));
        text +=
            &format!("  {} of the vibration, 0 to 1 kHz, against the reference\n", decibels(answer.error_db));
        text += &format!("  power above 1 kHz: {} of the total\n", decibels(answer.above_db));
        text += &format!(
            "  measuring took {:.0} s: the reference computes everything again, in 64 bits at 16 times the rate\n",
            begin.elapsed().as_secs_f64()
        );
        if let Some(reservation) = reservation(&player) {
            text += &format!("  {}\n", paint.yellow(&reservation));
        }
        text += "\nNow open the picture in a browser. `pacinian nodes` shows what patches are made of; in the project's folder,\n\
            `pacinian check patches/demo.toml --rig rigs/demo-16.toml` shows what this one runs.\n";
        terminal.print(&text)
    }

    /// The error of what was played, as long as nobody asks to stop.
    fn measure(
        &self,
        player: &Player,
        seconds: f64,
        stop: &Stop,
        terminal: &Terminal,
    ) -> Result<Comparison, Failure> {
        let take = Take { events: player.recorded(), moves: player.recorded_moves(), input: &[], seconds };
        let progress = Progress::new(terminal, Some(seconds));
        let asked = |what: &str, share: f64| {
            progress.says(what, share * seconds);
            stop.asked().map_or(Ok(()), |code| Err(Failure::told(code)))
        };
        let mut watch =
            |share: f64| asked(&format!("reference {:.0} of {seconds:.0} s", share * seconds), 0.95 * share);
        let measured = take.reference_watched(player.plan(), &mut watch).and_then(|ideal| {
            let mut watch = |share: f64| asked("comparing with the reference", 0.95 + 0.05 * share);
            take.measure_watched(player.plan(), &ideal, &mut watch)
        });
        progress.ends();
        if stop.asked().is_some() {
            let what = "stopped; the WAV file and the picture are complete, the error was not measured";
            terminal.note(&problems::sentence(&Problem::warning(&(0..0), what), terminal));
        }
        Ok(measured?.comparison)
    }
}
