//! `pacinian motor`.

mod coil;
mod picture;
mod played;
mod report;
mod response;
mod rumble;
mod shown;
mod subject;
mod written;

use super::failure::Failure;
use super::place::check_made;
use super::terminal::Terminal;
use clap::{Args, ValueEnum};
use pacinian::actuator::driver::setup::Shaping;
use pacinian::actuator::fault::Fault;
use pacinian::report::motion::Envelope;
use pacinian::rig::Model;
pub use shown::ms;
use std::path::PathBuf;
use subject::Subject;
use written::{Through, Written};

/// Simulates an actuator: what it is, and what it does in the ways in which it can be driven
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  pacinian motor coin-10mm --level 0.5 --plot coin.svg\n  \
    pacinian motor coin-10mm --drive \"0.02:3, 0.01:-3, open\"\n  \
    pacinian motor coin-10mm --coupling 2,10,20,20+10\n  \
    pacinian motor rigs/motors.toml --output wrist --patch patches/30-motor.toml --plot patch.svg\n  \
    pacinian motor eai-c-mf --response response.svg\n\n\
    Rumble motors: a burst and a click in every way in which they can be driven. Voice coils, inertial motors and resonant actuators:\n\
    resonance, response, a burst plain, overdriven and braked, an equaliser. Everything is computed from figures; which of them nobody\n\
    measured is said, and `pacinian parts` says where the others are from.\n\
    Rise: until the vibration is 50 % and 90 % of what is wanted. Stop: from the end of the wish until the rotor stands. Error: root mean\n\
    square of what the vibration misses during the wish, as a share of the most that is wanted. Ahead: by how much the end of the wish must be\n\
    known before.\n\n\
    With --patch all times are the patch's, whatever shapes its levels: by how much later it is sent is said, and every way is measured by its own wish.")]
pub struct Motor {
    /// A part, as `pacinian parts` lists them, or a rig, a TOML file
    what: String,
    /// The output of the rig, where it has several
    #[arg(long, value_name = "NAME")]
    output: Option<String>,
    /// A course of one's own in place of the comparison: SECONDS:VOLTS, separated by commas, open or short in place of volts; the last may
    /// do without seconds and holds for good. Amperes where the amplifier of the rig imposes a current; units may stand behind numbers (20ms:3V,
    /// 0.02:100mA), and one that does not fit is refused
    #[arg(long, value_name = "COURSE", allow_hyphen_values = true)]
    drive: Option<Written>,
    /// A patch that is played on the rig in place of the comparison, and what it does to the actuator of the output
    #[arg(long, value_name = "PATCH")]
    patch: Option<PathBuf>,
    /// With --patch: the pattern to play [default: those that a trigger starts, else the first]
    #[arg(long, value_name = "NAME", requires = "patch")]
    pattern: Option<String>,
    /// With --patch: what levels are shaped by in place of what the rig says; several, separated by commas, are compared side by side
    #[arg(long, value_name = "WORD,WORD", value_delimiter = ',', requires = "patch")]
    shaping: Vec<Shaping>,
    /// With --patch: the most of it that is played, seconds, 60 at most [default: until it is over and all is at rest]
    #[arg(long, value_name = "S", requires = "patch", allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Turns of the click, negative backward [default: 0.25]
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    turns: Option<f64>,
    /// Level of the burst, as a share of the rated vibration, above 0 and at most 1 [default: 1]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    level: Option<f64>,
    /// Length of the burst, seconds
    #[arg(long, value_name = "S", default_value_t = 0.1, allow_negative_numbers = true)]
    seconds: f64,
    /// Course of the burst [default: rectangle]
    #[arg(long, value_name = "WORD", value_enum)]
    envelope: Option<Form>,
    /// The most volts either way [default: what reaches it through the rig, else what the part bears or is made for]
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    volts: Option<f64>,
    /// The largest error of the speed, as a share of the rated speed: it chooses how well the motor is computed [default: 0.0001]
    #[arg(long, value_name = "X", allow_negative_numbers = true)]
    error: Option<f64>,
    /// Steps a second, 1000 to 192000 [default: what the rig says, else 48000]
    #[arg(long, value_name = "HZ", value_parser = clap::value_parser!(u32).range(1000..=192_000))]
    rate: Option<u32>,
    /// By how much the plane in which the mass spins is tilted off upright, rad: 0 upright, 1.5708 level [default: what the rig says, else
    /// unknown, and gravity has no part in it]
    #[arg(long, value_name = "RAD", allow_negative_numbers = true)]
    tilt: Option<f64>,
    /// Where the mass hangs before, rad from straight down [default: 0]
    #[arg(long, value_name = "RAD", allow_negative_numbers = true)]
    angle: Option<f64>,
    /// What of the click arrives behind AC coupling at these corners, Hz; 20+10 for two in series
    #[arg(long, value_name = "HZ,HZ", value_delimiter = ',')]
    coupling: Vec<Through>,
    /// Draws drive, speed and acceleration with what is wanted into this file; one that is there is replaced
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Of a voice coil, an inertial or a resonant actuator: draws its response over frequency, as it is and with its equaliser, into this file
    #[arg(long, value_name = "FILE.svg")]
    response: Option<PathBuf>,
    /// Writes what --plot draws as a table of comma-separated values, a line for each step
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// As JSON
    #[arg(long)]
    json: bool,
}

/// The course of a burst.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Form {
    /// At its level all the time
    Rectangle,
    /// Up and down, at its level in the middle
    RaisedCosine,
}

impl Form {
    fn envelope(self) -> Envelope {
        match self {
            Self::Rectangle => Envelope::Rectangle,
            Self::RaisedCosine => Envelope::RaisedCosine,
        }
    }
}

impl Motor {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let subject = Subject::find(&self.what, self.output.as_deref(), terminal)?;
        let made = [
            (&self.plot, "--plot", "svg"),
            (&self.response, "--response", "svg"),
            (&self.csv, "--csv", "csv"),
        ];
        for (path, option, extension) in made {
            path.as_ref().map_or(Ok(()), |path| check_made(path, option, extension, &subject.files))?;
        }
        if self.plot.is_some() && self.plot == self.csv {
            return Err(Failure::usage("picture and table cannot be one file", "choose another for --csv"));
        }
        if self.response.is_some() && (self.response == self.plot || self.response == self.csv) {
            let what = "two pictures, or a picture and the table, cannot be one file";
            return Err(Failure::usage(what, "choose another for --response"));
        }
        match subject.actuator.model {
            Model::RumbleMotor | Model::VoiceCoil | Model::InertialMotor | Model::Lra
                if self.patch.is_some() =>
            {
                played::run(self, &subject, terminal)
            }
            Model::RumbleMotor => rumble::run(self, &subject, terminal),
            Model::VoiceCoil | Model::InertialMotor | Model::Lra => coil::run(self, &subject, terminal),
            model @ (Model::Generic | Model::Piezo) => {
                let what = format!(
                    "{} is of model {}, of which there is no motion to simulate",
                    subject.name,
                    model.word()
                );
                let help = "rumble-motor, voice-coil, inertial-motor and lra are simulated; `pacinian parts` lists some";
                Err(Failure::usage(what, help).with_code(78))
            }
        }
    }

    /// Steps a second.
    fn rate(&self, subject: &Subject) -> f64 {
        // As far as it makes sense to compute every sample of the rig's.
        self.rate.map(f64::from).or(subject.rate).unwrap_or(48_000.0).clamp(1000.0, 192_000.0)
    }

    /// The most volts either way.
    fn limit(&self, subject: &Subject) -> Result<f64, Failure> {
        let limit = self.volts.or(subject.limit);
        limit.ok_or_else(|| {
            let what = format!("nothing says how many volts {} bears", subject.name);
            Failure::usage(what, "say it: --volts V, or `rated_volts` under its [actuator]")
        })
    }

    /// What is said of a limit that is beyond what is known to be borne.
    fn beyond(&self, subject: &Subject) -> Option<String> {
        let (volts, bears) = (self.volts?, subject.limit?);
        (volts > bears).then(|| {
            format!("{volts} V are more than the {bears} V that are known to be borne, or to reach it")
        })
    }
}

/// A number of the command line that is beyond its limits.
fn usage(fault: &Fault) -> Failure {
    let option = match fault.field {
        "length" => "seconds",
        "most" | "volts" | "limit" => "volts",
        "high_pass" => "coupling",
        other => other,
    };
    Failure::usage(fault.to_string(), format!("give another --{option}"))
}
