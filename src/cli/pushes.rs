//! What clicks through a carrier come to, for people and for programs.

use pacinian::actuator::driver::reach::Way;
use pacinian::actuator::link::carrier::Carrier;
use pacinian::graph::plan::{Clicks, Drive, Plan};
use serde::Serialize;

/// Levels at which it is tried, beside the weakest that there is.
const LEVELS: [f64; 4] = [1.0, 0.6, 0.3, 0.1];

/// When clicks begin, in engine samples after one of them.
const INSTANTS: [f64; 4] = [0.0, 0.3, 0.55, 0.8];

/// By how much of what was ordered a click may be off, and nothing is said.
const NEAR: f64 = 0.05;

/// What clicks of so many turns come to.
#[derive(Debug, Serialize)]
pub struct Push {
    turns: f64,
    /// The least and the most turns that the mass makes, over levels and instants.
    reaches: [f64; 2],
    /// The levels with which that is.
    levels: [f64; 2],
    #[serde(skip)]
    full_wave: bool,
}

impl Push {
    /// Those of a motor of a plan, whose amplifier gives so many volts at most.
    pub fn all(plan: &Plan, drive: &Drive, carrier: &Carrier, peak: Option<f64>) -> Vec<Self> {
        let output = plan.outputs.iter().find(|output| output.channel == drive.channel);
        let way = Way {
            carrier: *carrier,
            rate: plan.device_rate,
            per_sample: drive.per_sample,
            most: output.map_or(1.0, |output| output.max_level),
            peak,
        };
        let own = plan.clicks.iter().filter(|clicks| plan.drives.get(clicks.drive) == Some(drive));
        own.filter_map(|clicks| Self::of(&way, drive, clicks)).collect()
    }

    /// `None` where it cannot be told.
    fn of(way: &Way, drive: &Drive, clicks: &Clicks) -> Option<Self> {
        let mut push: Option<Self> = None;
        let weakest = clicks.book.weakest();
        for level in LEVELS.into_iter().filter(|level| *level > weakest).chain([weakest]) {
            let click = clicks.book.at(level)?;
            for instant in INSTANTS {
                let turns = way.turns(&drive.setup, &click, instant).ok()?;
                let push = push.get_or_insert(Self {
                    turns: clicks.turns,
                    reaches: [turns; 2],
                    levels: [level; 2],
                    full_wave: way.carrier.rectifier.full_wave,
                });
                if turns < push.reaches[0] {
                    (push.reaches[0], push.levels[0]) = (turns, level);
                }
                if turns > push.reaches[1] {
                    (push.reaches[1], push.levels[1]) = (turns, level);
                }
            }
        }
        push
    }

    /// In words, where it is far from what is ordered.
    pub fn text(&self) -> Option<String> {
        let Self { turns, reaches, levels, full_wave } = self;
        if reaches.iter().all(|reached| (reached / turns - 1.0).abs() <= NEAR) {
            return None;
        }
        let [least, most] = reaches.map(digits);
        let [weak, strong] = levels.map(digits);
        let more = if *full_wave { "" } else { "; a full-wave rectifier comes nearer" };
        Some(format!(
            "; a click of {turns} turns reaches {least} of them (at level {weak}) to {most} (at level {strong}){more}"
        ))
    }
}

/// Three digits that count.
fn digits(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap_or(x)
}
