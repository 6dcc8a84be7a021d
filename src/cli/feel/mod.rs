//! What is felt, written beside a rendering: `--feel`.

mod report;
mod shown;

pub use report::FeelReport;

use super::failure::Failure;
use super::loaded::Loaded;
use pacinian::feel::{Feel, Wish};
use pacinian::graph::plan::Plan;
use pacinian::io::error::FileError;
use pacinian::io::out::OutputFile;
use pacinian::io::wav::{Encoding, WavSpec, WavWriter};
use pacinian::text::Problem;
use std::path::Path;
use std::time::{Duration, Instant};

/// The share of what is felt at most below which it has died away.
const DIED_AWAY: f64 = 0.01;

/// Where what is felt goes, and how well it is to be known.
#[derive(Debug, Clone, Copy)]
pub struct Felt<'a> {
    /// The WAV file.
    pub path: &'a Path,
    /// See [`Wish::error`].
    pub error: f64,
}

/// What is felt, before there is a file for it.
#[derive(Debug)]
pub struct Prepared<'a> {
    felt: Felt<'a>,
    feel: Feel,
    spec: WavSpec,
}

/// What is felt, being written.
#[derive(Debug)]
pub struct FeltFile<'a> {
    felt: Felt<'a>,
    feel: Feel,
    writer: WavWriter<OutputFile>,
    frames: Vec<f32>,
    took: Duration,
}

impl<'a> Felt<'a> {
    /// Everything that can be refused before a file is made.
    ///
    /// # Errors
    /// A wish that cannot be; a rig of which nothing is known that moves, with all that is missing; more channels than a file holds.
    pub fn prepare(self, loaded: &Loaded, plan: &Plan) -> Result<Prepared<'a>, Failure> {
        let wish = Wish { error: self.error };
        let feel = Feel::new(&loaded.rig, plan.channels, plan.device_rate, &wish).map_err(|fault| {
            let what = fault.to_string().replacen("`error`", "--feel-error", 1);
            Failure::usage(what, "give another, such as 0.001")
        })?;
        if feel.traces().is_empty() {
            return Err(nothing(loaded, &feel));
        }
        let mut spec = WavSpec::new(feel.traces().len(), plan.device_rate as u32, Encoding::F32);
        spec.unbounded = true;
        spec.title = format!("{}: what is felt, figures in m/s2 or N, not sound", loaded.patch.title);
        spec.tactors = feel.traces().iter().map(ToString::to_string).collect();
        spec.check()?;
        Ok(Prepared { felt: self, feel, spec })
    }
}

impl<'a> Prepared<'a> {
    /// Makes the file, or empties the one that is there.
    ///
    /// # Errors
    /// As the writer's.
    pub fn create(self) -> Result<FeltFile<'a>, FileError> {
        let writer = WavWriter::create(self.felt.path, self.spec)?;
        Ok(FeltFile { felt: self.felt, feel: self.feel, writer, frames: Vec::new(), took: Duration::ZERO })
    }
}

impl FeltFile<'_> {
    /// Its name, as the person wrote it.
    pub fn shown(&self) -> String {
        self.felt.path.display().to_string()
    }

    /// Frames that leave the device. Says whether what is felt has died away.
    ///
    /// # Errors
    /// As the writer's.
    pub fn write(&mut self, block: &[f32]) -> Result<bool, FileError> {
        let begin = Instant::now();
        self.feel.process(block, &mut self.frames);
        self.took += begin.elapsed();
        self.writer.write(&self.frames)?;
        Ok(self.feel.rests(DIED_AWAY))
    }

    /// Completes the file.
    ///
    /// # Errors
    /// As the writer's.
    pub fn finish(mut self, loaded: &Loaded) -> Result<FeelReport, FileError> {
        self.feel.finish(&mut self.frames);
        self.writer.write(&self.frames)?;
        let (shown, written) = (self.shown(), self.writer.finish()?);
        Ok(FeelReport::new(loaded, &self.feel, shown, &written, self.felt.error, self.took))
    }
}

/// That nothing is known of what moves, with everything that is missing.
fn nothing(loaded: &Loaded, feel: &Feel) -> Failure {
    let Some(origin) = &loaded.rig_source else {
        let what = "nothing is felt: without a rig it is not known what hangs on the outputs";
        return Failure::usage(what, "name one that says it, such as --rig rigs/motors.toml");
    };
    let what = format!("nothing is felt: of no output of {} it is known what it moves", origin.file);
    let help = "add what is missing, as told below; `pacinian parts` lists actuators of which all is known";
    let mut failure = Failure::usage(what, help).with_code(78);
    let mut list: Vec<Problem> = Vec::new();
    for problem in feel.unfelt().iter().flat_map(|unfelt| &unfelt.why) {
        if !list.contains(problem) {
            list.push(problem.clone());
        }
    }
    failure.join(Failure::of(78, origin.problems(capped(list))));
    failure
}

/// Problems told one by one, at most.
const TOLD: usize = 12;

fn capped(mut list: Vec<Problem>) -> Vec<Problem> {
    let more = list.len().saturating_sub(TOLD);
    list.truncate(TOLD);
    if more > 0 {
        list.push(Problem::of_file(format!("and {more} more of that kind")));
    }
    list
}
