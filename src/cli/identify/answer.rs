//! All that `pacinian identify` has to say, for programs and for people.

use super::super::failure::Failure;
use super::Identify;
use super::figures::{Figure, Lacking, contradictions, figures, lacking};
use super::fit::Found;
use super::late::Delay;
use super::take::Take;
use super::target::Target;
use pacinian::edit::{self, EditError, Entry, Given};
use pacinian::io::replace;
use pacinian::rig::Model;
use pacinian::text::Problems;
use pacinian::text::problem::escaped;
use serde::Serialize;
use std::path::Path;

/// Everything there is to say.
#[derive(Debug, Serialize)]
pub struct Answer {
    /// The recording.
    pub recording: String,
    /// What is identified.
    pub of: String,
    pub model: &'static str,
    pub seconds: f64,
    pub rate_hz: f64,
    pub signal_to_noise_db: f64,
    pub drive: String,
    pub peak_volts: f64,
    /// By which the answer is behind the drive, s; null where it is not told.
    pub delay: Option<f64>,
    /// How it was found.
    pub delay_by: &'static str,
    /// By how much more the acceleration is late than the drive on its channel, s; null where that is none to speak of, or was said.
    pub later: Option<f64>,
    /// Seconds of the recording that were left out, before and behind the drive.
    pub left_out: [f64; 2],
    /// Seconds of the drive that were not recorded, at its beginning and its end.
    pub missed: [f64; 2],
    pub told: Vec<Figure>,
    pub untold: Vec<Lacking>,
    /// What the command line says and the rig does not, which goes there too.
    pub given: Vec<Said>,
    /// The rig, where there is one.
    pub rig: Option<String>,
    /// Whether figures were written into it.
    pub written: bool,
    /// What in the rig does not go with them.
    pub contradictions: Vec<String>,
    /// What the model needs besides.
    pub missing: Vec<String>,
}

/// A key of the rig, and what the command line says of it.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Said {
    pub name: &'static str,
    pub value: Given,
}

/// What the command line says and the rig lacks: without them what was found with them would come to nothing there.
fn given(asked: &Identify, target: &Target) -> Vec<Said> {
    if target.rig.is_none() {
        return Vec::new();
    }
    let is_said = |key: &str| target.own.iter().any(|own| own == key);
    let is_known = target.actuator.as_ref().is_some_and(|actuator| actuator.model != Model::Generic);
    let model = (!is_known).then(|| Said { name: "model", value: Given::Word(target.model.word()) });
    let mass = asked.mass.filter(|_| !is_said("mass"));
    model.into_iter().chain(mass.map(|mass| Said { name: "mass", value: Given::Number(mass) })).collect()
}

impl Answer {
    /// Of what was found.
    pub fn new(asked: &Identify, path: &Path, take: &Take, found: &Found, target: &Target) -> Self {
        let told = figures(&found.all, target);
        let contradictions =
            if target.rig.is_some() { contradictions(&told, asked, target) } else { Vec::new() };
        let mut actuator = target.actuator.clone();
        if let Some(actuator) = &mut actuator {
            actuator.model = target.model;
            told.iter().filter(|figure| figure.is_kept()).for_each(|figure| {
                actuator.values.insert(figure.name, figure.value);
            });
        }
        Self {
            recording: path.display().to_string(),
            of: target.name.clone(),
            model: target.model.word(),
            seconds: take.seconds,
            rate_hz: take.rate,
            signal_to_noise_db: found.all.signal_to_noise,
            drive: take.drive_name.clone(),
            peak_volts: found.peak,
            delay: found.delay,
            later: found.later,
            delay_by: match take.lag {
                Delay::None => "one recording",
                Delay::Looped(_) => "the looped-back drive",
                Delay::Current(_) => "the current",
                Delay::Answer(_) => "the answer itself",
                Delay::Untold => "the fit alone",
            },
            left_out: found.left_out,
            missed: found.missed,
            untold: lacking(&found.all, asked),
            given: given(asked, target),
            rig: target.rig.as_ref().map(|rig| rig.name.clone()),
            written: false,
            contradictions,
            missing: match &target.rig {
                Some(_) => actuator.map_or(Vec::new(), |actuator| actuator.lacking()),
                None => Vec::new(),
            },
            told,
        }
    }

    /// Writes into the rig what goes there.
    ///
    /// # Errors
    /// A rig that cannot be written, or that would be wrong with it.
    pub fn write(&mut self, target: &Target) -> Result<(), Failure> {
        let Some(rig) = &target.rig else { return Ok(()) };
        let kept = self.told.iter().filter(|figure| figure.is_kept());
        let entries: Vec<Entry> = kept
            .map(|f| Entry::measured(f.name, f.value, f.interval, f.unit, &self.recording))
            .chain(self.given.iter().map(|said| Entry::given(said.name, said.value)))
            .collect();
        if entries.is_empty() {
            return Ok(());
        }
        let refused = |why: EditError| {
            if let EditError::Broken(problems) = why {
                return Failure::of(78, Problems { file: rig.name.clone(), ..*problems });
            }
            let lines: Vec<String> = entries.iter().map(Entry::line).collect();
            let help = format!(
                "write it yourself, under [actuator.{}]: {}",
                target.actuator_name(),
                lines.join("; ")
            );
            Failure::usage(format!("`{}` was left as it is: {why}", escaped(&rig.name)), help).with_code(78)
        };
        let before = String::from_utf8_lossy(&rig.bytes);
        let after = edit::figures(&before, target.actuator_name(), &entries).map_err(refused)?;
        replace::replace(&rig.path, &rig.bytes, after.as_bytes())?;
        self.written = true;
        Ok(())
    }
}

impl Target {
    /// The actuator's name in the rig.
    fn actuator_name(&self) -> &str {
        self.actuator.as_ref().map_or("", |actuator| &actuator.name)
    }
}
