//! What gets through AC coupling to a motor, for people and for programs.

use super::table::hertz;
use pacinian::actuator::link::coupling::Corners;
use pacinian::graph::plan::{Clicks, Drive, Plan};
use serde::Serialize;

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
    /// Of its volt-seconds, the share that does not arrive.
    missing: f64,
}

impl Coupled {
    /// Of a motor of a plan.
    pub fn of(plan: &Plan, drive: &Drive, corners: &Corners) -> Self {
        let own = plan.clicks.iter().filter(|clicks| plan.drives.get(clicks.drive) == Some(drive));
        let arriving = |clicks: &Clicks| Arriving {
            turns: clicks.turns,
            amount: clicks.book.strongest().list[0].1.abs(),
            missing: clicks.missing,
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
                let Arriving { turns, amount, missing } = click;
                let arrives = match *missing {
                    0.0 => "whole from rest".to_string(),
                    missing if missing < 0.01 => "but for less than 1 % of it".to_string(),
                    missing => format!("but for {:.0} % of it", 100.0 * missing),
                };
                let amount: f64 = format!("{amount:.2e}").parse().unwrap_or(*amount);
                format!("; one of {turns} turns has at most {amount} {unit} and arrives {arrives}")
            })
            .collect();
        format!(
            "; clicks alone, through the coupling at {}, which is made up for{clicks}",
            corners.join(" and ")
        )
    }
}
