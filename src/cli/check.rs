//! `pacinian check`.

use super::failure::Failure;
use super::form;
use super::load::Scene;
use super::plan::PlanReport;
use super::problems::{self, Listed};
use super::terminal::Terminal;
use clap::Args;
use serde::Serialize;

/// Shows everything that is wrong with a patch and a rig, or what they will run
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  pacinian check patches/04-heartbeat.toml --rig rigs/belt.toml\n\n\
    Every problem is shown at once, at its line. Where there is none, the plan is shown: rates, delay, voices,\n\
    patterns and their length, channels, and what was left out and why. A voice runs as ops (its nodes, folded and pruned)\n\
    on buffers (rows between them) for groups of 8 lanes (voices computed abreast).")]
pub struct Check {
    #[command(flatten)]
    scene: Scene,
    /// One JSON object on standard output, problems included
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Answer {
    ok: bool,
    problems: Vec<Listed>,
    plan: Option<PlanReport>,
}

impl Check {
    /// Runs it.
    pub fn run(&self, terminal: &Terminal) -> Result<(), Failure> {
        let result = self.scene.load(true, None).and_then(|mut loaded| {
            let player = loaded.player()?;
            form::foresee(player.plan(), &mut loaded)?;
            Ok((loaded, player))
        });
        let (loaded, player) = match result {
            Ok(both) => both,
            Err(failure) if self.json => {
                let problems = problems::listed(&failure.problems());
                terminal.print(&json(&Answer { ok: false, problems, plan: None }))?;
                return Err(Failure::told(failure.code()));
            }
            Err(failure) => {
                failure.show(terminal);
                let all = failure.problems();
                if all.iter().map(|p| p.list.len()).sum::<usize>() > 1 {
                    terminal.note(&format!("{}\n", problems::counted(&all)));
                }
                return Err(Failure::told(failure.code()));
            }
        };
        let report = PlanReport::new(&loaded, &player);
        if self.json {
            let problems = problems::listed(&loaded.warnings);
            return terminal.print(&json(&Answer { ok: true, problems, plan: Some(report) }));
        }
        for warnings in &loaded.warnings {
            terminal.note(&problems::shown(warnings, terminal));
        }
        let paint = terminal.out;
        let verdict = match loaded.warnings.is_empty() {
            true => paint.green("nothing is wrong"),
            false => paint.yellow(&problems::counted(&loaded.warnings)),
        };
        let head = format!("{}: {verdict}\n", paint.bold(loaded.name()));
        terminal.print(&(head + &report.text(player.plan(), paint)))
    }
}

/// One JSON object, on lines of its own.
pub fn json(value: &impl Serialize) -> String {
    // Nothing that is shown has keys that are no strings, which alone could fail.
    serde_json::to_string_pretty(value).map_or_else(|error| error.to_string(), |text| text + "\n")
}
