//! What is simulated: an output of a rig, or a part.

use super::super::failure::Failure;
use super::super::parts;
use super::super::terminal::Terminal;
use pacinian::actuator::drive::Drive as Imposes;
use pacinian::actuator::link::Chain;
use pacinian::actuator::link::amplifier::Amplifier;
use pacinian::actuator::link::coupling::Corners;
use pacinian::actuator::motor::Parameters;
use pacinian::io::text;
use pacinian::rig::part::{self, Origin, Part};
use pacinian::rig::{Actuator, Model, Output, OutputKind, Rig, Terminals};
use pacinian::text::{Problem, Problems, nearest};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// An actuator, and what reaches it.
#[derive(Debug)]
pub struct Subject {
    /// The output of the rig; none of a part.
    pub output: Option<String>,
    /// As people call it: the part's name, or output and rig.
    pub name: String,
    /// What it is.
    pub title: String,
    /// Its figures.
    pub actuator: Actuator,
    /// The most that reaches it, V; `None`: nobody said.
    pub limit: Option<f64>,
    /// Where the amplifier imposes a current: the most, A, and the volts that it has for that.
    pub current: Option<[f64; 2]>,
    /// From a sample to the terminals, where something steady is let through.
    pub chain: Option<Chain>,
    /// How its volts come about.
    pub terminals: Terminals,
    /// Tilt of the plane of rotation off upright, rad, where it is known.
    pub tilt: Option<f64>,
    /// What was read for it.
    pub files: Vec<PathBuf>,
    /// Samples a second of the rig's device.
    pub rate: Option<f64>,
    /// What is known, and how.
    pub known: Known,
}

/// How figures came to be known.
#[derive(Debug, Default)]
pub struct Known {
    /// How many by each origin of the part's.
    pub origins: BTreeMap<&'static str, usize>,
    /// Those that the rig says.
    pub by_rig: usize,
    /// Those that nobody measured.
    pub assumed: Vec<&'static str>,
}

impl Known {
    fn of(actuator: &Actuator, part: Option<&Part>) -> Self {
        let mut known = Self::default();
        for (key, value) in &actuator.values {
            match part.and_then(|part| part.values.get(key)).filter(|of| of.value == *value) {
                Some(of) => {
                    *known.origins.entry(of.origin.word()).or_default() += 1;
                    known.assumed.extend((of.origin == Origin::Assumed).then_some(*key));
                }
                None => known.by_rig += 1,
            }
        }
        known
    }

    /// "3 from the rig, 7 assumed".
    pub fn text(&self) -> String {
        let rig = (self.by_rig > 0).then(|| format!("{} from the rig", self.by_rig));
        let part = Some(parts::counted(&self.origins)).filter(|text| !text.is_empty());
        rig.into_iter().chain(part).collect::<Vec<_>>().join(", ")
    }
}

impl Subject {
    /// What the command line names: a part, or else a rig and maybe an output of it.
    ///
    /// # Errors
    /// What is neither, a rig that is wrong, an output that is not there or of which several would do.
    pub fn find(what: &str, output: Option<&str>, terminal: &Terminal) -> Result<Self, Failure> {
        let path = Path::new(what);
        if let Some(part) = part::find(what) {
            return match output {
                Some(name) => {
                    let said = format!("`{what}` is a part, which has no output `{name}`");
                    Err(Failure::usage(said, "name a rig, or leave --output out"))
                }
                None => Ok(Self::of_part(part)),
            };
        }
        if !path.exists()
            && !text::is_stream(path)
            && !what.contains(['/', '\\'])
            && path.extension().is_none()
        {
            let said = format!("`{what}` is no part, and no rig of that name is there");
            return Err(Failure::usage(said, parts::advice(what)).with_code(66));
        }
        let name = if what == "-" { "stdin".into() } else { what.to_string() };
        let bytes = text::read(path)?;
        let checked = Rig::parse(&name, &bytes).map_err(|problems| Failure::of(78, problems))?;
        if !checked.warnings.list.is_empty() {
            terminal.note(&super::super::problems::shown(&checked.warnings, terminal));
        }
        let source =
            Problems { file: name, source: String::from_utf8_lossy(&bytes).into_owned(), list: Vec::new() };
        let rig = checked.value;
        let chosen = choose(&rig, output)?;
        Self::of_output(&rig, chosen, path, source)
    }

    fn of_part(part: &'static Part) -> Self {
        let actuator = Actuator::of_part(part);
        let limit = actuator.most_volts();
        let chain = limit.map(|volts| {
            let amplifier = Amplifier {
                gain: volts,
                inverted: false,
                drive: Imposes::Voltage,
                volts: Some(volts),
                amperes: None,
            };
            Chain { full_scale: 1.0, corners: Corners::none(), amplifier }
        });
        Self {
            output: None,
            name: part.name.into(),
            title: part.title.clone(),
            limit,
            current: None,
            chain,
            terminals: Terminals::Straight,
            tilt: None,
            files: Vec::new(),
            rate: None,
            known: Known::of(&actuator, Some(part)),
            actuator,
        }
    }

    fn of_output(rig: &Rig, output: &Output, path: &Path, source: Problems) -> Result<Self, Failure> {
        let refuse = |problem: Problem| Failure::of(78, Problems { list: vec![problem], ..source.clone() });
        let actuator = actuator_of(rig, output).ok_or_else(|| refuse(without(output)))?.clone();
        let part = actuator.part.as_deref().and_then(part::find);
        let of = match &actuator.part {
            Some(part) => format!("part {part}"),
            None => format!("actuator {}", actuator.name),
        };
        let amplifier = output.amplifier.as_ref().and_then(|name| rig.amplifier(name));
        let full = rig.device.full_scale_volts.map(|volts| volts * rig.max_level(output));
        let through = |gain: f64, volts: Option<f64>| {
            let amplifier = Amplifier {
                gain: gain.abs(),
                inverted: gain < 0.0,
                drive: Imposes::Voltage,
                volts,
                amperes: None,
            };
            full.map(|full_scale| Chain { full_scale, corners: Corners::none(), amplifier })
        };
        let (mut limit, mut current, mut chain, mut tilt) = (actuator.most_volts(), None, None, None);
        let mut terminals = Terminals::Straight;
        match rig.wiring(output) {
            Some(wired) => {
                let wiring = wired.map_err(refuse)?;
                terminals = wiring.terminals;
                tilt = wiring.turning.tilt;
                if wiring.is_current {
                    current = Some([wiring.limit, wiring.compliance]);
                    limit = Some(limit.map_or(wiring.compliance, |most| most.min(wiring.compliance)));
                } else {
                    limit = Some(wiring.limit);
                    chain = amplifier.and_then(|amplifier| through(amplifier.gain, Some(wiring.compliance)));
                }
            }
            None => {
                let reaches = amplifier.and_then(|a| {
                    let most = full.map(|full| full * a.gain.abs());
                    [most, a.max_volts].into_iter().flatten().reduce(f64::min)
                });
                limit = [limit, reaches].into_iter().flatten().reduce(f64::min);
            }
        }
        Ok(Self {
            output: Some(output.name.clone()),
            name: format!("{} of {}", output.name, source.file),
            title: part.map_or(of.clone(), |part| format!("{of}, {}", part.title)),
            limit,
            current,
            chain,
            terminals,
            tilt,
            files: vec![if path.as_os_str() == "-" { "/dev/stdin".into() } else { path.to_owned() }],
            rate: rig.device.rate,
            known: Known::of(&actuator, part),
            actuator,
        })
    }

    /// A rumble motor, with gravity where somebody says how it is held.
    ///
    /// # Errors
    /// What is missing, or cannot be.
    pub fn motor(&self, tilt: Option<f64>) -> Result<Parameters, Failure> {
        self.complete()?;
        let mut parameters = self.actuator.rumble_motor().map_err(|lack| self.impossible(&lack))?;
        parameters.gravity = self.actuator.gravity(tilt);
        Ok(parameters)
    }

    /// That nothing is missing that the model needs.
    ///
    /// # Errors
    /// All that is missing, and where to give it.
    pub fn complete(&self) -> Result<(), Failure> {
        let lacking = self.actuator.lacking();
        if lacking.is_empty() {
            return Ok(());
        }
        let listed: Vec<String> = lacking.iter().map(|key| format!("`{key}`")).collect();
        let model = self.actuator.model.word();
        let what = format!(
            "of {} not enough is known for its model, {model}: {} is missing",
            self.name,
            listed.join(", ")
        );
        let first = lacking[0].split('`').next().unwrap_or_default();
        let help = match &self.actuator.part {
            Some(part) => {
                format!("give it in a rig: [actuator.NAME] with part = \"{part}\" and {first} = ...")
            }
            None => format!("give it under [actuator.{}]: {first} = ...", self.actuator.name),
        };
        Err(Failure::usage(what, help).with_code(78))
    }

    /// That figures contradict each other.
    pub fn impossible(&self, why: &impl std::fmt::Display) -> Failure {
        let what = format!("{} cannot be: {why}", self.name);
        Failure::usage(what, "correct it under [actuator] of a rig").with_code(78)
    }
}

fn actuator_of<'a>(rig: &'a Rig, output: &Output) -> Option<&'a Actuator> {
    output.actuator.as_ref().and_then(|name| rig.actuator(name))
}

fn without(output: &Output) -> Problem {
    let what = format!("output `{}` has no actuator: what it moves is not known", output.name);
    Problem::error(&output.span, what)
        .help("name one, actuator = \"NAME\", and describe it under [actuator.NAME]".to_string())
}

/// The output that is meant: the one that is named, the only drive, or the only one that can be simulated.
fn choose<'a>(rig: &'a Rig, name: Option<&str>) -> Result<&'a Output, Failure> {
    if let Some(name) = name {
        let names = || rig.outputs.iter().map(|output| output.name.as_str());
        let help = || nearest::suggest(name, names()).unwrap_or_else(|| "see the rig".into());
        return rig
            .outputs
            .iter()
            .find(|output| output.name == name)
            .ok_or_else(|| Failure::usage(format!("the rig has no output `{name}`"), help()));
    }
    let drives: Vec<&Output> =
        rig.outputs.iter().filter(|o| matches!(o.kind, OutputKind::Drive(_))).collect();
    let simulated = |output: &&Output| {
        actuator_of(rig, output).is_some_and(|a| !matches!(a.model, Model::Generic | Model::Piezo))
    };
    let all = if drives.is_empty() { rig.outputs.iter().filter(simulated).collect() } else { drives };
    let mut kinds: Vec<&Option<String>> = all.iter().map(|output| &output.actuator).collect();
    kinds.dedup();
    match (all.first(), kinds.len()) {
        (Some(first), 1) if all.len() == 1 || !matches!(first.kind, OutputKind::Drive(_)) => Ok(first),
        (Some(_), _) => {
            let names: Vec<&str> = all.iter().map(|output| output.name.as_str()).take(12).collect();
            let what = format!("the rig has several outputs that move something: {}", names.join(", "));
            Err(Failure::usage(what, format!("name one: --output {}", names[0])))
        }
        (None, _) => Err(Failure::usage(
            "the rig has no output of kind drive, and no actuator of a model that is simulated",
            "say what hangs on an output: actuator = \"NAME\", and under [actuator.NAME] its part or its model",
        )
        .with_code(78)),
    }
}
