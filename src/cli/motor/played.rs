//! `pacinian motor RIG --patch PATCH`.

mod picture;
mod shown;

use super::super::check::json;
use super::super::failure::Failure;
use super::super::load::Scene;
use super::super::loaded::Loaded;
use super::super::problems;
use super::super::terminal::Terminal;
use super::subject::Subject;
use super::{Motor, rumble, usage};
use pacinian::actuator::driver::setup::Shaping;
use pacinian::io::out;
use pacinian::report::motion::{Played, Stretch};
use pacinian::rig::OutputKind;
use picture::{csv, picture};
use serde::Serialize;

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
    computed: Computed,
    ways: Vec<WayReport>,
}

/// How well it was computed, and what the model leaves out.
#[derive(Debug, Serialize)]
struct Computed {
    /// Null of what is exact.
    level: Option<&'static str>,
    rate: f64,
    steps: u32,
    /// Of what is felt, as a share of that at the rated drive.
    wished_error: f64,
    /// The error that is left where the wish cannot be granted; else null.
    reaches: Option<f64>,
    left_out: Vec<String>,
    assumed: Vec<String>,
}

/// What came of the patch, as an output's levels are shaped.
#[derive(Debug, Serialize)]
struct WayReport {
    shaping: Option<&'static str>,
    seconds: f64,
    /// By how much what is sent is later than the patch, by whose time all is told.
    late: f64,
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
    /// Where the mass is at the end, rad within ±π from where it hangs.
    angle: Option<f64>,
    /// On the casing about the shaft, N m.
    peak_reaction: Option<f64>,
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
    let shapings: Vec<Option<Shaping>> = match asked.shaping.as_slice() {
        [] => vec![None],
        all => all.iter().map(|shaping| Some(*shaping)).collect(),
    };
    let mut all = Vec::new();
    for shaping in &shapings {
        all.push(play(&mut loaded, output, *shaping, seconds, error)?);
    }
    Played::align(&mut all);
    let ways: Vec<(Option<Shaping>, Played)> = shapings.into_iter().zip(all).collect();
    let Some((_, first)) = ways.first() else { return Ok(()) };
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
        unit: first.unit,
        computed: Computed::new(first),
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

impl Computed {
    fn new(played: &Played) -> Self {
        let modelled = &played.modelled;
        Self {
            level: modelled.level.map(rumble::level),
            rate: played.rate,
            steps: modelled.steps,
            wished_error: modelled.error,
            reaches: modelled.reaches,
            left_out: modelled.left_out.iter().map(ToString::to_string).collect(),
            assumed: modelled.assumed.clone(),
        }
    }
}

impl WayReport {
    fn new(shaping: Option<Shaping>, played: &Played) -> Self {
        Self {
            shaping: shaping.map(Shaping::word),
            seconds: played.seconds(),
            late: played.late,
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
            angle: stretch.angle,
            peak_reaction: stretch.peak_reaction,
            energy: stretch.energy,
        }
    }
}
