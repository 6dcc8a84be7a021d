//! What gets through AC coupling to a motor, for people and for programs.

use super::table::hertz;
use pacinian::actuator::link::coupling::Corners;
use pacinian::graph::plan::{Clicks, Drive, Plan};
use pacinian::patch::Patch;
use pacinian::text::{Problem, Problems, Severity};
use serde::Serialize;

/// Warnings of clicks that do not get through coupling whole; `None` where there are none.
pub fn short(patch: &Patch, plan: &Plan) -> Option<Problems> {
    let told = |clicks: &Clicks| {
        let channel = plan.drives.get(clicks.drive)?.channel;
        let name = &plan.outputs.iter().find(|output| output.channel == channel)?.name;
        let (turns, arriving) = (clicks.turns, clicks.arriving);
        let what = format!(
            "a click of {turns} turns makes at most {arriving:.3} of them on `{name}`: its coupling lets no more through"
        );
        let help =
            "order a shorter one, or give it more room: a larger `max_level`, `full_scale_volts` or `gain`";
        Some(Problem { severity: Severity::Warning, ..Problem::of_file(what).help(help.to_string()) })
    };
    let short = plan.clicks.iter().filter(|clicks| (clicks.arriving / clicks.turns - 1.0).abs() > WHOLE);
    let list: Vec<Problem> = short.filter_map(told).collect();
    (!list.is_empty()).then(|| patch.origin.problems(list))
}

/// A click that is off by no more than that is whole.
const WHOLE: f64 = 0.01;

/// What of clicks gets through coupling.
#[derive(Debug, Serialize)]
pub struct Coupled {
    /// The corners, Hz.
    corners: Vec<f64>,
    clicks: Vec<Arriving>,
}

/// The strongest click of so many turns.
#[derive(Debug, Serialize)]
struct Arriving {
    turns: f64,
    /// Volts, or amperes, either way.
    amount: f64,
    /// Turns that it makes.
    arriving: f64,
}

impl Coupled {
    /// Of a motor of a plan.
    pub fn of(plan: &Plan, drive: &Drive, corners: &Corners) -> Self {
        let own = plan.clicks.iter().filter(|clicks| plan.drives.get(clicks.drive) == Some(drive));
        let arriving = |clicks: &Clicks| Arriving {
            turns: clicks.turns,
            amount: clicks.book.strongest().list[0].1.abs(),
            arriving: clicks.arriving,
        };
        Self { corners: corners.hertz().to_vec(), clicks: own.map(arriving).collect() }
    }

    /// In words, amounts in this unit.
    pub fn text(&self, unit: &str) -> String {
        let corners: Vec<String> = self.corners.iter().map(|corner| hertz(*corner)).collect();
        let clicks: String = self
            .clicks
            .iter()
            .map(|click| {
                let Arriving { turns, amount, arriving } = click;
                let arrives = match arriving == turns {
                    true => "arrives whole from rest".to_string(),
                    false => format!("makes {arriving:.3} of them, which is all that gets through"),
                };
                let amount: f64 = format!("{amount:.2e}").parse().unwrap_or(*amount);
                format!("; one of {turns} turns has at most {amount} {unit} and {arrives}")
            })
            .collect();
        format!(
            "; clicks alone, through the coupling at {}, which is made up for{clicks}",
            corners.join(" and ")
        )
    }
}
