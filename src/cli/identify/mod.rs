//! `pacinian identify`.

mod answer;
mod figures;
mod fit;
mod late;
mod short;
mod stimulus;
mod take;
mod target;
mod text;

use super::check::json;
use super::failure::Failure;
use super::terminal::Terminal;
use answer::Answer;
use clap::{Args, ValueEnum};
use pacinian::rig::Model;
use std::path::PathBuf;
use std::str::FromStr;
use take::Take;
use target::Target;

/// Finds the figures of an actuator in a recording of what it does under a known drive, and writes them into the rig
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    pacinian identify --stimulus drive.wav --rig motors.toml --output wrist\n  \
    pacinian identify take.wav --drive drive.wav --rig motors.toml --output wrist --acceleration-scale 160\n  \
    pacinian identify take.wav --channels drive,acceleration,current --drive drive.wav --current-scale 0.5 --part coin-10mm --drive-scale 10\n\n\
    --stimulus makes a drive: steps and a slow ramp for a motor, a sweep for a resonance. Play it with any program, at full volume and its own\n\
    rate, and record the acceleration of what is shaken. The recording may begin and end when it likes: the delay is found, exactly where\n\
    the drive comes back on a channel of the recording. What it tells is printed with an interval of 95 %; what it does not, with what would\n\
    tell it. --write puts what is told into the rig, and touches nothing else there.\n\
    Of a motor the acceleration tells time constant, speed for a volt, running and starting voltage, in any unit, and the eccentric moment over\n\
    the mass that moves in m/s2; of a resonance its frequency and quality, and in m/s2 what it does for a volt. A current tells what these are\n\
    made of; a voltage at the terminals takes the place of the drive.")]
pub struct Identify {
    /// What was recorded, a WAV file
    #[arg(required_unless_present = "stimulus", conflicts_with = "stimulus")]
    recording: Option<PathBuf>,
    /// Makes a drive to play, and writes it into this WAV file; one that is there is replaced
    #[arg(long, value_name = "FILE.wav")]
    stimulus: Option<PathBuf>,
    /// What was played, a WAV file, such as --stimulus makes
    #[arg(long, value_name = "FILE.wav", conflicts_with = "stimulus")]
    drive: Option<PathBuf>,
    /// The channel of --drive that was played, from 1 [default: the only one that is not silent]
    #[arg(long, value_name = "N", requires = "drive", value_parser = clap::value_parser!(u16).range(1..=4096))]
    drive_channel: Option<u16>,
    /// What the channels of the recording hold, in order: acceleration, drive (looped back), current, voltage (at the terminals), - for
    /// nothing of use [default: acceleration, where there is one channel]
    #[arg(
        long,
        value_name = "WORD,WORD",
        value_delimiter = ',',
        conflicts_with = "stimulus",
        allow_hyphen_values = true
    )]
    channels: Vec<Holds>,
    /// Volts at the actuator for a sample of 1.0 of the drive [default: what device and amplifier of the rig make of it]
    #[arg(long, value_name = "V", value_parser = scale, allow_negative_numbers = true)]
    drive_scale: Option<f64>,
    /// m/s2 for a sample of 1.0 of the acceleration [default: not known, and not needed but for amplitudes]
    #[arg(long, value_name = "M/S2", value_parser = scale, conflicts_with = "stimulus", allow_negative_numbers = true)]
    acceleration_scale: Option<f64>,
    /// Amperes for a sample of 1.0 of the current
    #[arg(long, value_name = "A", value_parser = scale, conflicts_with = "stimulus", allow_negative_numbers = true)]
    current_scale: Option<f64>,
    /// Volts for a sample of 1.0 of the voltage
    #[arg(long, value_name = "V", value_parser = scale, conflicts_with = "stimulus", allow_negative_numbers = true)]
    voltage_scale: Option<f64>,
    /// Seconds of the recording over which the terminals of a motor are open, where there is a voltage
    #[arg(long, value_name = "FROM:TO", value_delimiter = ',', conflicts_with = "stimulus")]
    open: Vec<Open>,
    /// Seconds by which the acceleration comes later than a looped-back drive [default: 0, where one is]
    #[arg(long, value_name = "S", value_parser = delay, conflicts_with = "stimulus", allow_negative_numbers = true)]
    delay: Option<f64>,
    /// All that moves with a motor, kg; --write puts it into a rig that says none [default: `mass` where the rig itself says it]
    #[arg(long, value_name = "KG", value_parser = mass, conflicts_with = "stimulus", allow_negative_numbers = true)]
    mass: Option<f64>,
    /// What the recorded acceleration is of the one between coil and magnet, 0 to 1: 1 for a contactor in a housing that is held [default:
    /// slug over all that moves, where the rig itself says `casing_mass`]
    #[arg(long, value_name = "X", conflicts_with = "stimulus", allow_negative_numbers = true)]
    share: Option<f64>,
    /// The rig, a TOML file
    #[arg(long, value_name = "RIG")]
    rig: Option<PathBuf>,
    /// The output of the rig that drove it
    #[arg(long, value_name = "NAME", requires = "rig")]
    output: Option<String>,
    /// The actuator of the rig that it is [default: the one on --output, or the only one]
    #[arg(long, value_name = "NAME", requires = "rig")]
    actuator: Option<String>,
    /// A part to compare with, as `pacinian parts` lists them
    #[arg(long, value_name = "PART", conflicts_with = "rig")]
    part: Option<String>,
    /// What it is, where neither rig nor part says it, and --write puts it there: rumble-motor, voice-coil, inertial-motor, lra
    #[arg(long, value_name = "WORD", value_parser = model)]
    model: Option<Model>,
    /// The most volts of the stimulus [default: what it is made for, of a resonance half of that, as far as the rig lets it through]
    #[arg(long, value_name = "V", requires = "stimulus", allow_negative_numbers = true)]
    volts: Option<f64>,
    /// Samples a second of the stimulus [default: what the rig says, else 48000]
    #[arg(long, value_name = "HZ", requires = "stimulus", value_parser = clap::value_parser!(u32).range(1000..=384_000))]
    rate: Option<u32>,
    /// Writes what is told into the rig; without it, nothing is written
    #[arg(long, requires = "rig", conflicts_with = "stimulus")]
    write: bool,
    /// As JSON
    #[arg(long)]
    json: bool,
}

/// What a channel holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Holds {
    Acceleration,
    Drive,
    Current,
    Voltage,
    /// Nothing of use
    #[value(name = "-")]
    Nothing,
}

impl Holds {
    /// The word for it.
    fn word(self) -> &'static str {
        match self {
            Self::Acceleration => "acceleration",
            Self::Drive => "drive",
            Self::Current => "current",
            Self::Voltage => "voltage",
            Self::Nothing => "-",
        }
    }
}

/// Seconds over which terminals are open.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Open {
    from: f64,
    to: f64,
}

impl FromStr for Open {
    type Err = String;

    fn from_str(word: &str) -> Result<Self, String> {
        let second = |word: &str| word.trim().parse::<f64>().ok().filter(|s| (0.0..=1e6).contains(s));
        let both = word.split_once(':').and_then(|(from, to)| Some((second(from)?, second(to)?)));
        match both {
            Some((from, to)) if to > from => Ok(Self { from, to }),
            _ => Err("it is from when to when, in seconds of the recording, such as 1.5:1.9".into()),
        }
    }
}

fn scale(word: &str) -> Result<f64, String> {
    let known =
        "it is what a sample of 1.0 stands for, from 1e-9 to 1e9, negative where the channel is upside down";
    word.parse::<f64>().ok().filter(|x| (1e-9..=1e9).contains(&x.abs())).ok_or_else(|| known.into())
}

/// Kilograms, as a rig's `mass` may be.
const MASS: (f64, f64) = (1e-9, 1e6);
/// Seconds.
const DELAY: (f64, f64) = (-1.0, 10.0);

fn mass(word: &str) -> Result<f64, String> {
    let known = "it is all that moves with the motor, itself included, from 1e-9 to 1e6 kg: weigh it, and mind that 12 g are 0.012";
    word.parse().ok().filter(|x| (MASS.0..=MASS.1).contains(x)).ok_or_else(|| known.into())
}

fn delay(word: &str) -> Result<f64, String> {
    let known = "it is by how many seconds the acceleration comes later than the drive on its channel, from -1 to 10: 3 ms are 0.003";
    word.parse().ok().filter(|x| (DELAY.0..=DELAY.1).contains(x)).ok_or_else(|| known.into())
}

fn model(word: &str) -> Result<Model, String> {
    let known = [Model::RumbleMotor, Model::VoiceCoil, Model::InertialMotor, Model::Lra];
    let words = known.map(Model::word).join(", ");
    Model::of_word(word).filter(|model| known.contains(model)).ok_or_else(|| format!("it is one of {words}"))
}

impl Identify {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let target = Target::find(self, terminal)?;
        if let Some(path) = &self.stimulus {
            return stimulus::make(self, path, &target, terminal);
        }
        let Some(path) = &self.recording else {
            return Err(Failure::usage("there is no recording", "name it"));
        };
        if self.write {
            target.check_writable()?;
        }
        let take = Take::read(self, path, &target)?;
        let found = fit::fit(self, &take, &target)?;
        let mut answer = Answer::new(self, path, &take, &found, &target);
        if self.write {
            answer.write(&target)?;
        }
        let text = if self.json { json(&answer) } else { answer.text(terminal.out) };
        terminal.print(&text)
    }
}

#[cfg(test)]
mod tests {
    use super::{Model, Open, delay, mass, model, scale};

    #[test]
    fn words_are_read_or_refused_with_what_they_should_be() {
        assert_eq!("1.5:2".parse(), Ok(Open { from: 1.5, to: 2.0 }));
        for word in ["", "1.5", "2:1", "1:1", "-1:2", "nan:2", "1:inf", "a:b"] {
            assert!(word.parse::<Open>().unwrap_err().contains("such as 1.5:1.9"), "{word}");
        }
        assert_eq!((scale("-0.5"), scale("160")), (Ok(-0.5), Ok(160.0)));
        for word in ["0", "nan", "inf", "1e10", "x"] {
            assert!(scale(word).is_err(), "{word}");
        }
        assert_eq!(
            (mass("1e-9"), mass("1e6"), delay("-1"), delay("0.003")),
            (Ok(1e-9), Ok(1e6), Ok(-1.0), Ok(0.003))
        );
        for word in ["1e-300", "9e-10", "0", "-1", "nan", "inf", "1.1e6", "x"] {
            assert!(mass(word).unwrap_err().contains("from 1e-9 to 1e6 kg: weigh it"), "{word}");
        }
        for word in ["nan", "inf", "-1.1", "11", "x"] {
            assert!(delay(word).unwrap_err().contains("from -1 to 10"), "{word}");
        }
        assert_eq!(model("lra"), Ok(Model::Lra));
        assert!(model("piezo").unwrap_err().contains("rumble-motor, voice-coil"));
    }
}
