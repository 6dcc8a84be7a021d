//! `pacinian error`.

use super::check::json;
use super::failure::Failure;
use super::load::{Number, Scene};
use super::loaded::Loaded;
use super::memory::Memory;
use super::named::Codes;
use super::perform::{Until, perform};
use super::place::check_picture;
use super::plan::precision;
use super::problems;
use super::progress::Progress;
use super::render::seconds;
use super::setting::{self, Setting};
use super::stop::Stop;
use super::table::Table;
use super::terminal::Terminal;
use clap::Args;
use pacinian::engine::refusal::Refusal;
use pacinian::graph::plan::{Plan, Precision};
use pacinian::io::out;
use pacinian::player::Player;
use pacinian::report::measure::RING;
use pacinian::report::plot::{Axis, Chart, Point, Series};
use pacinian::report::{Measured, Reference, Take};
use pacinian::rig::OutputKind;
use pacinian::text::Problem;
use serde::Serialize;
use std::path::PathBuf;

/// Measures error against the reference and run time, for several settings
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pacinian error patches/04-heartbeat.toml --rig rigs/belt.toml\n\n\
    The reference computes every node from its definition, in 64 bits, at 16 times the engine's rate, and goes through the\n\
    same designed response. The error is the power of the difference from 0 to 1 kHz, as a share of the reference's, after\n\
    the delay that the engine reports is taken out. It hears the same --input, through the designed response of the filter\n\
    that brings it to the engine's rate. The reference is slow: it may take some seconds.")]
pub struct Error {
    #[command(flatten)]
    scene: Scene,
    /// Numbers of taps to compare, with both number types
    #[arg(long, value_name = "N,N", value_delimiter = ',', default_values_t = [4, 6, 8], value_parser = clap::value_parser!(u8).range(4..=12))]
    compare_taps: Vec<u8>,
    /// Measures the one setting that --precision and --taps say
    #[arg(long)]
    only: bool,
    /// Seconds to measure [default: what the patch says, else until everything is over]
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Draws error against run time into this SVG file, too; one that is there is replaced
    #[arg(short, long, value_name = "FILE.svg")]
    output: Option<PathBuf>,
    /// As JSON
    #[arg(long, conflicts_with = "csv")]
    json: bool,
    /// As comma-separated values
    #[arg(long)]
    csv: bool,
}

/// One setting, measured.
#[derive(Debug, Serialize)]
pub struct Row {
    precision: &'static str,
    taps: usize,
    /// Decibels; null where both are silent.
    error_db: Option<f64>,
    /// Power above 1 kHz, decibels of all; null where there is none.
    above_db: Option<f64>,
    run_time_seconds: f64,
    times_real_time: f64,
}

#[derive(Debug, Serialize)]
struct Answer {
    seconds: f64,
    /// Controls that the command line set.
    set: Vec<Setting>,
    voices_stolen: u64,
    limited: u64,
    /// Whether something still rings so long after its release at the end that it was cut.
    rings_on: bool,
    settings: Vec<Row>,
}

impl Error {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let mut loaded = self.scene.load(false, self.duration)?;
        if loaded.song.is_some() && !loaded.patch.binds.is_empty() {
            return Err(Failure::usage(
                "the reference knows nothing of controls that move, and `[[bind]]` lets MIDI move some",
                "leave --midi out, or render with it: pacinian render",
            ));
        }
        for warnings in &loaded.warnings {
            terminal.note(&problems::shown(warnings, terminal));
        }
        if let Some(output) = &self.output {
            check_picture(output, &loaded)?;
        }
        let mut player = loaded.player()?;
        let until = Until::of(&loaded, &player, self.duration)?;
        player.record();
        let stop = Stop::listen()?;
        let memory = Memory::new(player.plan(), loaded.input.is_some(), self.settings().len());
        // Where the length is known, nothing is rendered first that would not fit.
        memory.check(until.expected(&player).unwrap_or(0.0), 0)?;
        let (mut frames, rate) = (0, player.plan().device_rate);
        let performed = perform(&mut player, &loaded, until, &stop, terminal, |player, block| {
            frames += block.len() / player.plan().channels.max(1);
            memory.check(frames as f64 / rate, player.recorded().len()).map(|()| true)
        })
        .map_err(|(failure, _)| failure)?;
        if let Some(code) = performed.stopped {
            return Err(Self::stopped(terminal, code, 0, self.settings().len()));
        }
        if let Some(trouble) = player.trouble() {
            return Err(loaded.refuse(vec![trouble.clone()], &Codes::new()));
        }
        let seconds = performed.frames as f64 / rate;
        let settings = self.settings();
        let progress = Progress::new(terminal, Some(settings.len() as f64));
        let input = loaded.input.clone();
        let take = Take {
            events: player.recorded(),
            moves: player.recorded_moves(),
            input: input.as_ref().map_or(&[], |input| input.channels()),
            seconds,
        };
        let rings = take.rings(player.plan());
        memory.check(seconds + rings, take.events.len())?;
        let mut ideals: Vec<(u8, Reference)> = Vec::new();
        let mut rows = Vec::new();
        for (i, (number, taps)) in settings.iter().enumerate() {
            let name = format!("{} with {taps} taps", precision(*number));
            let asked = || match stop.asked() {
                Some(code) => Err(Self::stopped(terminal, code, rows.len(), settings.len())),
                None => Ok(()),
            };
            loaded.options.precision = *number;
            loaded.options.taps = usize::from(*taps);
            let other = loaded.player()?;
            let plan = other.plan();
            // Settings share what they should come to, but for the filter of an input, which has as many taps as the output's.
            let ideal = match ideals.iter().position(|(of, _)| input.is_none() || of == taps) {
                Some(known) => known,
                None => {
                    let mut watch = |share: f64| {
                        let known = format!("{name}: reference {:.0} of {seconds:.0} s", share * seconds);
                        // It takes the longest by far.
                        progress.says(&known, i as f64 + 0.9 * share);
                        asked()
                    };
                    ideals.push((*taps, take.reference_watched(plan, &mut watch)?));
                    ideals.len() - 1
                }
            };
            let mut watch = |share: f64| {
                progress.says(&name, i as f64 + 0.9 + 0.1 * share);
                asked()
            };
            let measured = take.measure_watched(plan, &ideals[ideal].1, &mut watch)?;
            rows.push(Row::new(plan, &measured));
        }
        drop(progress);
        let answer = Answer {
            seconds,
            set: loaded.settings.clone(),
            voices_stolen: player.counters().stolen,
            limited: player.engine().stage().counts().limited,
            rings_on: rings >= RING,
            settings: rows,
        };
        if let Some(output) = &self.output {
            out::write(output, chart(&answer, &loaded).svg().as_bytes())?;
        }
        terminal.print(&match (self.json, self.csv) {
            (true, _) => json(&answer),
            (_, true) => csv(&answer.settings),
            _ => text(&answer, &loaded, terminal),
        })
    }

    /// Says what of it is done, which is not shown.
    fn stopped(terminal: &Terminal, code: u8, done: usize, all: usize) -> Failure {
        let what = format!("stopped; {done} of {all} settings were measured, so there is no table");
        terminal.note(&problems::sentence(&Problem::warning(&(0..0), what), terminal));
        Failure::told(code)
    }

    fn settings(&self) -> Vec<(Precision, u8)> {
        let own = match self.scene.precision {
            Number::F32 => Precision::Single,
            Number::F64 => Precision::Double,
        };
        if self.only {
            return vec![(own, self.scene.taps)];
        }
        let both = [Precision::Single, Precision::Double];
        both.iter().flat_map(|p| self.compare_taps.iter().map(|taps| (*p, *taps))).collect()
    }
}

/// A plan that no engine can be built for.
impl From<Refusal> for Failure {
    fn from(refusal: Refusal) -> Self {
        Self::said(2, refusal.to_string())
    }
}

/// What keeps the error from saying much, if something does.
pub fn reservation(player: &Player) -> Option<String> {
    let (stolen, limited) = (player.counters().stolen, player.engine().stage().counts().limited);
    match (stolen, limited) {
        (0, 0) => None,
        (0, _) => Some("the limiter acted, which the reference does not model".into()),
        _ => Some("voices were stolen, which the reference does not model".into()),
    }
}

impl Row {
    fn new(plan: &Plan, m: &Measured) -> Self {
        let run_time_seconds = m.run_time.as_secs_f64();
        Self {
            precision: precision(plan.precision),
            taps: plan.taps,
            error_db: Some(m.comparison.error_db).filter(|x| x.is_finite()),
            above_db: Some(m.comparison.above_db).filter(|x| x.is_finite()),
            run_time_seconds,
            times_real_time: m.seconds / run_time_seconds.max(1e-9),
        }
    }
}

/// "-97.3 dB".
pub fn decibels(level: Option<f64>) -> String {
    level.map_or("none".into(), |x| format!("{x:.1} dB"))
}

fn text(answer: &Answer, loaded: &Loaded, terminal: &Terminal) -> String {
    let paint = terminal.out;
    let mut table = Table::default();
    let heads = ["type", "taps", "error to 1 kHz", "above 1 kHz", "run time (wall)", "x real time"];
    table.row(heads.map(|head| paint.dim(head)));
    for row in &answer.settings {
        table.row([
            row.precision.into(),
            row.taps.to_string(),
            decibels(row.error_db),
            decibels(row.above_db),
            format!("{:.4} s", row.run_time_seconds),
            format!("{:.0}", row.times_real_time),
        ]);
    }
    let set =
        if answer.set.is_empty() { String::new() } else { format!(", {}", setting::named(&answer.set)) };
    let mut text = format!("{}: {:.3} s{set}\n{}", paint.bold(loaded.name()), answer.seconds, table.text());
    for what in answer.reservations(loaded) {
        text += &paint.yellow(&format!("  {what}\n"));
    }
    text
}

impl Answer {
    /// What keeps the figures from saying much.
    fn reservations(&self, loaded: &Loaded) -> Vec<&'static str> {
        let motors = loaded.rig.outputs.iter().any(|o| matches!(o.kind, OutputKind::Drive(_)));
        let raw = loaded.rig.outputs.iter().any(|o| o.kind == OutputKind::Raw);
        [
            (
                self.voices_stolen > 0,
                "voices were stolen, which the reference does not model: the error says little",
            ),
            (
                self.rings_on,
                "something rings for 8 s and more after the end: where it is cut counts as error",
            ),
            (motors, "motors stand still in these figures, which are of what vibrates; `pacinian motor` has theirs"),
            (raw, "raw outputs are not band-limited: what they have above 1 kHz counts, too"),
            (
                self.limited > 0,
                "the limiter acted, which the reference does not model: the error says little",
            ),
        ]
        .into_iter()
        .filter_map(|(is, what)| is.then_some(what))
        .collect()
    }
}

/// Error against run time, as the table has it: for each number type a line of errors and one of what lies above the band, a
/// point for each number of taps.
fn chart(answer: &Answer, loaded: &Loaded) -> Chart {
    let mut series: Vec<Series> = Vec::new();
    for row in &answer.settings {
        // Taps move what lies above the band, so that line has their number.
        let taps = format!("{} taps", row.taps);
        for (what, level, label) in
            [("error to 1 kHz", row.error_db, String::new()), ("above 1 kHz", row.above_db, taps)]
        {
            let name = format!("{}: {what}", row.precision);
            let at = series.iter().position(|one| one.name == name).unwrap_or_else(|| {
                series.push(Series { name, ..Series::default() });
                series.len() - 1
            });
            // Of nothing at all, the chart says that it leaves a point out.
            let y = level.unwrap_or(f64::NEG_INFINITY);
            series[at].points.push(Point { x: 1e3 / row.times_real_time, y, label });
        }
    }
    let title = if loaded.patch.title.is_empty() { loaded.name() } else { &loaded.patch.title };
    Chart {
        title: format!("{title}: error against run time, {} outputs", loaded.rig.outputs.len()),
        x: Axis { label: "run time of a second of vibration (ms)".into(), log: false, least: 0.0 },
        y: Axis { label: "dB of the vibration".into(), log: false, least: 10.0 },
        series,
        notes: answer
            .reservations(loaded)
            .iter()
            .map(|what| format!("{}{}.", what[..1].to_uppercase(), &what[1..]))
            .collect(),
    }
}

fn csv(rows: &[Row]) -> String {
    let mut text = String::from("precision,taps,error_db,above_db,run_time_s,times_real_time\n");
    let cell = |x: Option<f64>| x.map_or(String::new(), |x| format!("{x:.3}"));
    for row in rows {
        text += &format!(
            "{},{},{},{},{:.6},{:.1}\n",
            row.precision,
            row.taps,
            cell(row.error_db),
            cell(row.above_db),
            row.run_time_seconds,
            row.times_real_time
        );
    }
    text
}
