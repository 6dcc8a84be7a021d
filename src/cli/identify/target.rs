//! What is identified: an actuator of a rig, a part, or nothing but a model.

use super::super::failure::Failure;
use super::super::terminal::Terminal;
use super::super::{parts, problems};
use super::Identify;
use pacinian::actuator::link::coupling::Corners;
use pacinian::edit;
use pacinian::io::{out, text};
use pacinian::rig::{Actuator, Coupling, Drive, Model, Output, Rig};
use pacinian::text::nearest;
use std::path::{Path, PathBuf};

/// What is identified, and what reaches it.
#[derive(Debug)]
pub struct Target {
    /// What it is.
    pub model: Model,
    /// As people call it: "actuator `coin` of motors.toml".
    pub name: String,
    /// What is known of it so far.
    pub actuator: Option<Actuator>,
    /// The keys that the rig itself says of it.
    pub own: Vec<String>,
    /// The rig that it is of, and what stands in it.
    pub rig: Option<File>,
    /// Volts at the actuator for a sample of 1.0, where it is known.
    pub per_sample: Option<f64>,
    /// The most volts that it bears, or that reach it.
    pub limit: Option<f64>,
    /// The output's channel and how many the device has, where an output is known.
    pub channel: Option<[usize; 2]>,
    /// Samples a second of the device.
    pub rate: Option<f64>,
    /// What keeps steady voltages off.
    pub corners: Corners,
    /// The largest share of full scale that may leave the output.
    pub most: f64,
}

/// A rig's file.
#[derive(Debug)]
pub struct File {
    /// Where it is.
    pub path: PathBuf,
    /// As it was named.
    pub name: String,
    /// What stands in it.
    pub bytes: Vec<u8>,
}

impl Target {
    /// What the command line names.
    ///
    /// # Errors
    /// Nothing, what is not there, what contradicts itself, and models that there is no fit for.
    pub fn find(asked: &Identify, terminal: &Terminal) -> Result<Self, Failure> {
        let target = match (&asked.rig, &asked.part, asked.model) {
            (Some(path), ..) => Self::of_rig(asked, path, terminal)?,
            (None, Some(name), _) => Self::of(format!("part {name}"), Actuator::of_part(parts::find(name)?)),
            (None, None, Some(model)) => {
                Self { model, actuator: None, ..Self::of(model.word().into(), Actuator::generic("")) }
            }
            (None, None, None) => {
                let help = "say it: --rig RIG and --output NAME, or --part PART, or --model rumble-motor, voice-coil, inertial-motor or lra";
                return Err(Failure::usage("what it is that moves is not known", help));
            }
        };
        let target = target.with_model(asked.model)?;
        let of_others = match (target.is_motor(), asked.mass, asked.share) {
            (false, Some(_), _) => Some(("--mass", "motors")),
            (true, _, Some(_)) => Some(("--share", "coils")),
            _ => None,
        };
        if let Some((option, whose)) = of_others {
            let what =
                format!("{option} is for {whose}, and {} is of model {}", target.name, target.model.word());
            return Err(Failure::usage(what, format!("leave {option} out")));
        }
        Ok(target)
    }

    fn of(name: String, actuator: Actuator) -> Self {
        Self {
            model: actuator.model,
            name,
            limit: actuator.most_volts(),
            actuator: Some(actuator),
            own: Vec::new(),
            rig: None,
            per_sample: None,
            channel: None,
            rate: None,
            corners: Corners::none(),
            most: 1.0,
        }
    }

    fn of_rig(asked: &Identify, path: &Path, terminal: &Terminal) -> Result<Self, Failure> {
        let name = if text::is_stream(path) { "stdin".into() } else { path.display().to_string() };
        let bytes = text::read(path)?;
        let checked = Rig::draft(&name, &bytes).map_err(|problems| Failure::of(78, problems))?;
        if !checked.warnings.list.is_empty() {
            terminal.note(&problems::shown(&checked.warnings, terminal));
        }
        let rig = checked.value;
        let output = asked.output.as_deref().map(|name| find_output(&rig, name)).transpose()?;
        let actuator = choose(asked, &rig, output)?;
        // Without a name, the first output on which it hangs says what reaches it.
        let on = |output: &&Output| output.actuator.as_ref() == Some(&actuator.name);
        let output = output.or_else(|| rig.outputs.iter().find(on));
        let amplifier = output.and_then(|output| rig.amplifier(output.amplifier.as_ref()?));
        let unfit = amplifier.and_then(|amplifier| match amplifier.drive {
            Drive::Voltage => None,
            Drive::Current => Some((amplifier, "imposes a current")),
            Drive::Bridge { .. } => Some((amplifier, "is a bridge, which is given pulses")),
            Drive::Carrier(_) => Some((amplifier, "has a rectifier behind it")),
        });
        if let Some((amplifier, why)) = unfit {
            let what = format!("amplifier `{}` {why}, and figures are found under voltages", amplifier.name);
            return Err(
                Failure::usage(what, "record it behind an amplifier that imposes a voltage").with_code(78)
            );
        }
        let per_sample = output.and_then(|output| rig.volts_per_sample(output));
        let most = output.map_or(rig.device.max_level, |output| rig.max_level(output));
        let reaches = [
            actuator.most_volts(),
            amplifier.and_then(|a| a.max_volts),
            per_sample.map(|volts| volts * most),
        ];
        Ok(Self {
            per_sample,
            limit: reaches.into_iter().flatten().reduce(f64::min),
            channel: output.map(|output| [output.channel as usize, rig.device.channels as usize]),
            rate: rig.device.rate,
            corners: output.map_or_else(|| of_device(&rig), |output| rig.corners(output)),
            most,
            own: edit::keys(&bytes, &actuator.name),
            rig: Some(File { path: path.to_owned(), name: name.clone(), bytes }),
            ..Self::of(format!("actuator {} of {name}", actuator.name), actuator.clone())
        })
    }

    /// With the model that was asked for, where the rig says none.
    fn with_model(mut self, asked: Option<Model>) -> Result<Self, Failure> {
        if let Some(asked) = asked.filter(|asked| *asked != self.model) {
            if self.model != Model::Generic {
                let what = format!("{} is of model {}, not {}", self.name, self.model.word(), asked.word());
                return Err(Failure::usage(what, "leave --model out"));
            }
            self.model = asked;
        }
        match self.model {
            Model::Piezo => {
                let what =
                    format!("{} is of model piezo, whose figures no recording is fitted for", self.name);
                Err(Failure::usage(
                    what,
                    "motors and coils are: rumble-motor, voice-coil, inertial-motor, lra",
                )
                .with_code(78))
            }
            Model::Generic => {
                let help = "say it: model = \"lra\", say, under its [actuator], or --model lra";
                Err(Failure::usage(format!("nothing says what {} is", self.name), help).with_code(78))
            }
            _ => Ok(self),
        }
    }

    /// That the rig can be written.
    ///
    /// # Errors
    /// One that is no file, or that may not be written.
    pub fn check_writable(&self) -> Result<(), Failure> {
        let Some(rig) = &self.rig else { return Ok(()) };
        if text::is_stream(&rig.path) {
            return Err(Failure::usage("there is no file to write into", "name one: --rig RIG.toml"));
        }
        Ok(out::check(&rig.path)?)
    }

    /// A figure that is known so far.
    pub fn value(&self, key: &str) -> Option<f64> {
        self.actuator.as_ref()?.value(key)
    }

    /// A figure that the rig itself says: a part's is of what its maker had it mounted on.
    pub fn own_value(&self, key: &str) -> Option<f64> {
        self.value(key).filter(|_| self.own.iter().any(|own| own == key))
    }

    /// Whether it is a motor; else it is a resonance.
    pub fn is_motor(&self) -> bool {
        self.model == Model::RumbleMotor
    }
}

/// What a device keeps off whatever hangs on it.
fn of_device(rig: &Rig) -> Corners {
    match rig.device.coupling {
        Some(Coupling::HighPass(hertz)) => Corners::one(hertz),
        _ => Corners::none(),
    }
}

fn find_output<'a>(rig: &'a Rig, name: &str) -> Result<&'a Output, Failure> {
    rig.outputs.iter().find(|output| output.name == name).ok_or_else(|| {
        let names = rig.outputs.iter().map(|output| output.name.as_str());
        let help = nearest::suggest(name, names).unwrap_or_else(|| "see the rig".into());
        Failure::usage(format!("the rig has no output `{name}`"), help)
    })
}

/// The actuator that is named, that of the output, or the only one.
fn choose<'a>(asked: &Identify, rig: &'a Rig, output: Option<&Output>) -> Result<&'a Actuator, Failure> {
    let describe = "describe it: [actuator.NAME] with model = \"rumble-motor\", say, and rated_volts";
    if let Some(output) = output.filter(|output| output.actuator.is_none()) {
        let what = format!("output `{}` has no actuator: what it moves is not known", output.name);
        return Err(Failure::usage(what, describe).with_code(78));
    }
    let on = output.and_then(|output| output.actuator.as_deref());
    if let (Some(on), Some(named)) = (on, asked.actuator.as_deref())
        && on != named
    {
        let what = format!("on that output hangs the actuator `{on}`, not `{named}`");
        return Err(Failure::usage(what, "leave --actuator out"));
    }
    let names = || rig.actuators.iter().map(|actuator| actuator.name.as_str());
    match (on.or(asked.actuator.as_deref()), rig.actuators.as_slice()) {
        (Some(name), _) => rig.actuator(name).ok_or_else(|| {
            let help = nearest::suggest(name, names()).unwrap_or_else(|| describe.into());
            Failure::usage(format!("the rig has no actuator `{name}`"), help)
        }),
        (None, [one]) => Ok(one),
        (None, []) => Err(Failure::usage("the rig has no actuator", describe).with_code(78)),
        (None, all) => {
            let listed: Vec<&str> = names().take(12).collect();
            let what = format!("the rig has several actuators: {}", listed.join(", "));
            Err(Failure::usage(what, format!("name one: --actuator {}", all[0].name)))
        }
    }
}
