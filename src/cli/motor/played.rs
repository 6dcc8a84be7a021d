//! `pacinian motor RIG --patch PATCH`.

use super::super::check::json;
use super::super::failure::Failure;
use super::super::load::{Loaded, Scene};
use super::super::paint::Paint;
use super::super::problems;
use super::super::table::Table;
use super::super::terminal::Terminal;
use super::shown::ms;
use super::subject::Subject;
use super::{Motor, usage};
use pacinian::actuator::driver::setup::Shaping;
use pacinian::io::out;
use pacinian::report::motion::{Played, Stretch};
use pacinian::report::plot::{Column, Curve, Panel, Strips};
use pacinian::rig::{Model, OutputKind};
use serde::Serialize;
use std::fmt::Write;

/// The most of a patch that is played, s.
const LONGEST: f64 = 60.0;

/// Everything there is to say.
#[derive(Debug, Serialize)]
struct Answer {
    name: String,
    title: String,
    model: &'static str,
    patch: String,
    output: String,
    unit: &'static str,
    ways: Vec<WayReport>,
}

/// What came of the patch, as an output's levels are shaped.
#[derive(Debug, Serialize)]
struct WayReport {
    shaping: Option<&'static str>,
    seconds: f64,
    stretches: Vec<StretchReport>,
}

#[derive(Debug, Serialize)]
struct StretchReport {
    at: f64,
    seconds: f64,
    voices: Vec<String>,
    rise_50: Option<f64>,
    rise_90: Option<f64>,
    peak: f64,
    peak_at: f64,
    stop: Option<f64>,
    error: Option<f64>,
    turns: Option<f64>,
    /// Joules.
    energy: Option<f64>,
}

/// Plays it and says what came of it.
pub fn run(asked: &Motor, subject: &Subject, terminal: &Terminal) -> Result<(), Failure> {
    let Some(patch) = &asked.patch else { return Ok(()) };
    let clashing = [
        (asked.drive.is_some(), "--drive"),
        (asked.turns.is_some(), "--turns"),
        (asked.level.is_some(), "--level"),
        (asked.envelope.is_some(), "--envelope"),
        (asked.volts.is_some(), "--volts"),
        (asked.tilt.is_some(), "--tilt"),
        (asked.angle.is_some(), "--angle"),
        (asked.response.is_some(), "--response"),
        (!asked.coupling.is_empty(), "--coupling"),
    ];
    if let Some((_, option)) = clashing.into_iter().find(|(given, _)| *given) {
        let what = format!("{option} is of the comparison, which --patch takes the place of");
        return Err(Failure::usage(what, format!("leave {option} or --patch out")));
    }
    let (Some(rig), Some(output)) = (subject.files.first(), &subject.output) else {
        let what = format!("{} is a part, and a patch is played on a rig", subject.name);
        return Err(Failure::usage(what, "name a rig: pacinian motor RIG --output NAME --patch PATCH"));
    };
    let seconds = asked.duration.unwrap_or(LONGEST);
    if !(seconds > 0.0 && seconds <= LONGEST) {
        let what = format!("{seconds} s is no length: it must be above 0 and at most {LONGEST} s");
        return Err(Failure::usage(what, "give another --duration"));
    }
    let scene = Scene::of_files(patch, rig, asked.pattern.clone(), asked.rate);
    let mut loaded = scene.load(false, Some(seconds))?;
    for warnings in &loaded.warnings {
        terminal.note(&problems::shown(warnings, terminal));
    }
    let turns =
        loaded.rig.outputs.iter().any(|o| o.name == *output && matches!(o.kind, OutputKind::Drive(_)));
    if !asked.shaping.is_empty() && !turns {
        let what = format!("--shaping is of outputs of kind drive, and `{output}` is none");
        return Err(Failure::usage(what, "leave it out"));
    }
    let error = asked.error.unwrap_or(1e-4);
    let mut ways: Vec<(Option<Shaping>, Played)> = Vec::new();
    let shapings: Vec<Option<Shaping>> = match asked.shaping.as_slice() {
        [] => vec![None],
        all => all.iter().map(|shaping| Some(*shaping)).collect(),
    };
    for shaping in shapings {
        ways.push((shaping, play(&mut loaded, output, shaping, seconds, error)?));
    }
    if ways.iter().all(|(_, played)| played.stretches().is_empty()) {
        let what = format!("nothing in {} is played on `{output}`", loaded.name());
        return Err(Failure::usage(what, "name another output or pattern: --output, --pattern").with_code(65));
    }
    if let Some(path) = &asked.plot {
        let title = format!("{}: {}", subject.name, subject.title);
        out::write(path, picture(&title, &loaded, subject, &ways).svg().as_bytes())?;
    }
    if let Some(path) = &asked.csv {
        out::write(path, csv(&ways).as_bytes())?;
    }
    let answer = Answer {
        name: subject.name.clone(),
        title: subject.title.clone(),
        model: subject.actuator.model.word(),
        patch: loaded.name().to_string(),
        output: output.clone(),
        unit: ways.first().map_or("", |(_, played)| played.unit),
        ways: ways.iter().map(|(shaping, played)| WayReport::new(*shaping, played)).collect(),
    };
    let text = if asked.json { json(&answer) } else { answer.text(subject, terminal.out) };
    terminal.print(&text)
}

/// A patch on an output, which shapes levels in a way.
fn play(
    loaded: &mut Loaded,
    output: &str,
    shaping: Option<Shaping>,
    seconds: f64,
    error: f64,
) -> Result<Played, Failure> {
    for described in loaded.rig.outputs.iter_mut().filter(|described| described.name == output) {
        if let (OutputKind::Drive(turning), Some(shaping)) = (&mut described.kind, shaping) {
            turning.shaping = shaping;
        }
    }
    let mut player = loaded.player()?;
    let played =
        Played::new(&mut player, &loaded.rig, output, seconds, error).map_err(|fault| usage(&fault))?;
    if let Some(trouble) = player.trouble() {
        return Err(Failure::usage(trouble.to_string(), "see the patch").with_code(65));
    }
    played.ok_or_else(|| {
        let what = format!("of `{output}` it is not known what it moves");
        Failure::usage(
            what,
            "`pacinian render PATCH --rig RIG -o out.wav --feel felt.wav` says what is missing",
        )
        .with_code(78)
    })
}

/// The word for a way.
fn word(shaping: Option<Shaping>) -> &'static str {
    shaping.map_or("as the rig has it", Shaping::word)
}

impl WayReport {
    fn new(shaping: Option<Shaping>, played: &Played) -> Self {
        Self {
            shaping: shaping.map(Shaping::word),
            seconds: played.seconds(),
            stretches: played.stretches().into_iter().map(StretchReport::new).collect(),
        }
    }
}

impl StretchReport {
    fn new(stretch: Stretch) -> Self {
        let [rise_50, rise_90] = stretch.rise;
        Self {
            at: stretch.from,
            seconds: stretch.to - stretch.from,
            voices: stretch.voices,
            rise_50,
            rise_90,
            peak: stretch.peak,
            peak_at: stretch.peak_at,
            stop: stretch.stop,
            error: stretch.error,
            turns: stretch.turns,
            energy: stretch.energy,
        }
    }
}

impl Answer {
    fn text(&self, subject: &Subject, paint: Paint) -> String {
        let mut text = format!("{}: {}\n", paint.bold(&self.name), self.title);
        let mut table = Table::default();
        let assumed = match subject.known.assumed.as_slice() {
            [] => String::new(),
            assumed => format!("; nobody measured {}", assumed.join(", ")),
        };
        table.row(["model".into(), self.model.to_string()]);
        table.row(["figures".into(), format!("{}{assumed}", subject.known.text())]);
        text += &table.text();
        for way in &self.ways {
            let shaped = way.shaping.map_or(String::new(), |shaping| format!(", levels shaped by {shaping}"));
            let _ = write!(text, "\n{} of {:.2} s{shaped}\n", paint.bold(&self.patch), way.seconds);
            let mut table = Table::default();
            let peak = format!("peak {}", self.unit);
            let heads =
                ["at", "lasts", "to 50 %", "to 90 %", &peak, "at", "stop", "error", "turns", "mJ in", ""];
            table.row(heads.map(|head| paint.dim(head)));
            let or_none = |value: Option<String>| value.unwrap_or_else(|| "-".into());
            let is_motor = subject.actuator.model == Model::RumbleMotor;
            for stretch in &way.stretches {
                table.row([
                    format!("{:.3} s", stretch.at),
                    ms(stretch.seconds),
                    or_none(stretch.rise_50.map(ms)),
                    or_none(stretch.rise_90.map(ms)),
                    format!("{:.3}", stretch.peak),
                    format!("{:.3} s", stretch.peak_at),
                    stretch.stop.map_or(if is_motor { "goes on" } else { "-" }.into(), ms),
                    or_none(stretch.error.map(|error| format!("{:.1} %", 100.0 * error))),
                    or_none(stretch.turns.map(|turns| format!("{turns:.2}"))),
                    or_none(stretch.energy.map(|energy| format!("{:.3}", 1e3 * energy))),
                    stretch.voices.join(", "),
                ]);
            }
            text += &table.text();
        }
        text
    }
}

fn picture(title: &str, loaded: &Loaded, subject: &Subject, ways: &[(Option<Shaping>, Played)]) -> Strips {
    let curve = |name: &str, played: &Played, values: &[f64], wanted| Curve {
        name: name.into(),
        rate: played.rate,
        values: values.to_vec(),
        wanted,
    };
    let panel = |label: String, of: &dyn Fn(&Played) -> Vec<f64>, wanted: Option<Vec<f64>>| {
        let first = ways.first().map(|(_, played)| played);
        let wanted = first.zip(wanted).filter(|(_, wanted)| wanted.iter().any(|x| *x != 0.0));
        let wanted = wanted.map(|(played, wanted)| curve("wanted", played, &wanted, true));
        let curves = ways.iter().map(|(shaping, played)| curve(word(*shaping), played, &of(played), false));
        Panel { label, curves: wanted.into_iter().chain(curves).collect() }
    };
    let unit = ways.first().map_or("", |(_, played)| played.unit);
    let felt = if unit == "N" { "force" } else { "acceleration" };
    let given = if subject.current.is_some() { "drive (A)" } else { "drive (V)" };
    let mut panels = vec![panel(given.into(), &|played| played.drives.clone(), None)];
    let wished = ways.first().map(|(_, played)| played.wished.clone());
    let per_square =
        subject.actuator.rumble_motor().ok().map(|p| p.eccentric / p.casing.mass().unwrap_or(1.0));
    if let Some(per_square) = per_square {
        panels.push(panel("speed (rad/s)".into(), &|played| played.speeds.clone(), wished.clone()));
        let wanted = wished.map(|wished| wished.iter().map(|speed| per_square * speed * speed).collect());
        panels.push(panel(format!("{felt} ({unit})"), &|played| played.felt.clone(), wanted));
    } else {
        panels.push(panel(format!("{felt} ({unit})"), &|played| played.felt.clone(), None));
    }
    let seconds = ways.iter().map(|(_, played)| played.seconds()).fold(0.0, f64::max);
    let column = Column { heading: loaded.patch.title.clone(), seconds, panels };
    let subtitle = format!("under {}; amplitudes as they are felt", loaded.name());
    Strips { title: title.into(), subtitle, columns: vec![column] }
}

/// A line for each frame of the device: time, and drive, speed, what was wished for and what was felt in each way.
fn csv(ways: &[(Option<Shaping>, Played)]) -> String {
    let mut text = String::from("seconds");
    for (shaping, played) in ways {
        let way = shaping.map_or(String::new(), |shaping| format!("{}_", shaping.word()));
        let unit = played.unit.replace('/', "_per_");
        let _ = write!(text, ",{way}drive,{way}rad_per_s,{way}wanted_rad_per_s,{way}{unit}");
    }
    text.push('\n');
    let frames = ways.iter().map(|(_, played)| played.drives.len()).max().unwrap_or(0);
    for n in 0..frames {
        let rate = ways.first().map_or(1.0, |(_, played)| played.rate);
        let _ = write!(text, "{:.9}", (n + 1) as f64 / rate);
        for (_, played) in ways {
            for values in [&played.drives, &played.speeds, &played.wished, &played.felt] {
                match values.get(n) {
                    Some(value) => drop(write!(text, ",{value:.9}")),
                    None => text.push(','),
                }
            }
        }
        text.push('\n');
    }
    text
}
