//! `pacinian knob`.

mod answer;
pub mod figures;
mod record;
mod set_off;
mod turn;
pub mod turning;

use super::check::json;
use super::failure::Failure;
use super::load::Scene;
use super::place::{check_made, check_sound};
use super::play::Play;
use super::problems;
use super::render::seconds;
use super::terminal::Terminal;
use answer::Answer;
use clap::Args;
use figures::Figures;
use pacinian::actuator::fault::Fault;
use pacinian::io::gesture::Gesture;
use pacinian::io::out;
use pacinian::report::knob::curve::Curve;
use pacinian::report::knob::map::Map;
use std::path::PathBuf;
use turn::{Turn, Turned};

/// Turns a simulated force-feedback knob under a patch, and says what it did
#[derive(Debug, Args)]
#[command(
    name = "knob",
    after_help = "Examples:\n  pacinian knob patches/35-knob.toml\n  \
    pacinian knob patches/35-knob.toml --rig rigs/knob.toml --plot knob.svg --csv knob.csv\n  \
    pacinian knob patches/35-knob.toml --hand knob.csv -o turned.wav\n\n\
    The patch says what the knob feels like, [knob]; the rig says what it is, and where it says nothing a small one is taken. A hand\n\
    that holds it turns it: --hand names a table with the columns time (s) and hand_angle (rad) or hand_torque (N m), such as --csv writes;\n\
    without one it goes a turn forth and back in three seconds. With --keys you turn it yourself, in real time: the arrows move the hand, and a dial
\
    shows angle, speed and torque. pacinian play shows the same of any patch with a knob."
)]
pub struct KnobCommand {
    #[command(flatten)]
    scene: Scene,
    /// What the hand does, a table: time, and hand_angle or hand_torque or both [default: a turn forth and back]
    #[arg(long, value_name = "FILE.csv")]
    hand: Option<PathBuf>,
    /// Seconds [default: until the hand is done, and half a second]
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Writes angle, speed, torque and energy of every engine sample as a table; one that is there is replaced
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
    /// Draws angle, speed, torque and energy over time, speed over angle, and what the knob set off, into this file
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Draws torque over angle of a slow turn forth and back, and the energy that its place holds
    #[arg(long, value_name = "FILE.svg")]
    curve: Option<PathBuf>,
    /// Draws the stability map: stiffness over damping, the edge beyond which it swings by itself, what the governor grants, and the effects
    #[arg(long, value_name = "FILE.svg")]
    map: Option<PathBuf>,
    /// Writes what leaves the channels meanwhile
    #[arg(short, long, value_name = "FILE.wav")]
    output: Option<PathBuf>,
    /// Turns it by keys in the terminal, in real time and on no sound card: left and right, with Shift further; q ends it
    #[arg(long, conflicts_with_all = ["hand", "csv", "plot", "curve", "map", "output", "json"])]
    keys: bool,
    /// As JSON
    #[arg(long)]
    json: bool,
}

/// Points of the curve of torque over angle.
const CURVE: usize = 4001;

impl KnobCommand {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let scene = Scene { simulated: true, ..self.scene.clone() };
        let loaded = scene.load(false, self.duration)?;
        for warnings in loaded.warnings.iter().filter(|_| !self.keys) {
            terminal.note(&problems::shown(warnings, terminal));
        }
        if loaded.patch.knob.is_none() {
            let what = format!("`{}` has no knob", loaded.name());
            let help = "say what it feels like: [knob.effects] notches = { type = \"detents\", count = 24, torque = 0.02 }";
            return Err(Failure::usage(what, help).with_code(65));
        }
        if self.keys {
            return Play::turned(self.scene.clone(), self.duration).run(terminal);
        }
        let mut own = loaded.files.clone();
        own.extend(self.hand.clone());
        let made = [
            (&self.csv, "--csv", "csv"),
            (&self.plot, "--plot", "svg"),
            (&self.curve, "--curve", "svg"),
            (&self.map, "--map", "svg"),
        ];
        let mut named: Vec<&PathBuf> = Vec::new();
        for (path, option, extension) in made {
            let Some(path) = path else { continue };
            check_made(path, option, extension, &own)?;
            if named.contains(&path) {
                let what = format!("`{}` is named twice", path.display());
                return Err(Failure::usage(what, format!("choose another file for {option}")));
            }
            named.push(path);
        }
        self.output.as_ref().map_or(Ok(()), |path| check_sound(path, "--output", &own))?;
        let gesture = self.hand.as_deref().map(Gesture::open).transpose()?;
        let turn = Turn {
            gesture: gesture.unwrap_or_else(turn::forth_and_back),
            seconds: self.duration,
            output: self.output.as_deref(),
            table: self.csv.as_deref(),
        };
        let turned = turn.run(&loaded, terminal)?;
        self.draw(&loaded.patch.title, &turned)?;
        let (plan, knob) = (turned.player.plan(), turned.player.knob());
        let figures = knob.and_then(|knob| Figures::new(plan, knob));
        let tally = knob.map(|knob| knob.tally()).unwrap_or_default();
        let answer = Answer::new(loaded.name(), figures, plan.engine_rate(), &tally, turned.set_off);
        terminal.print(&if self.json { json(&answer) } else { answer.text(terminal.out) })?;
        turned.ending
    }

    /// Pictures that were asked for.
    fn draw(&self, title: &str, turned: &Turned) -> Result<(), Failure> {
        if let Some(path) = &self.plot {
            out::write(path, turned.record.course.svg(title).as_bytes())?;
        }
        let Some(setup) = turned.player.plan().knob.as_ref().map(|knob| &knob.setup) else { return Ok(()) };
        let impossible = |fault: Fault| Failure::said(78, fault.to_string());
        if let Some(path) = &self.curve {
            let [least, most] = turned.player.knob().map(|knob| knob.tally()).unwrap_or_default().angle;
            let range = if most > least { [least, most] } else { [-1.0, 1.0] };
            let curve =
                Curve::new(setup.effects.clone(), range, CURVE).map_err(|(_, fault)| impossible(fault))?;
            out::write(path, curve.svg(title).as_bytes())?;
        }
        if let Some(path) = &self.map {
            let ask = turned.player.knob().map(|knob| knob.servo().demand());
            let map = Map::new(&setup.device, setup.margin, ask).map_err(impossible)?;
            out::write(path, map.svg(title).as_bytes())?;
        }
        Ok(())
    }
}
