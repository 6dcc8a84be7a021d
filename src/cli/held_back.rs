//! What was held back for the sake of actuators, and what their motors could not do.

use super::table::{Table, grouped};
use pacinian::actuator::protect::counts::{Counts, Touched};
use pacinian::engine::stage::Stage;
use pacinian::graph::plan::Plan;
use serde::Serialize;

/// What became of one output.
#[derive(Debug, Serialize)]
pub struct HeldBack {
    channel: u32,
    name: String,
    /// Samples at the device's rate that left other than they came.
    samples: u64,
    /// By what, and how many samples each.
    by: Vec<By>,
    /// The warmest that the winding became by the model, kelvins above the air; null where its heat is not watched.
    warmest: Option<f64>,
    /// The farthest that it moved by the model, metres; null where that is not watched.
    farthest: Option<f64>,
    /// Of a motor: engine samples in which its limit kept it from what was played, and orders that found no room.
    short: u64,
    dropped: u64,
    /// Of a motor that turns one way: engine samples and orders that were for the other.
    backward: u64,
    /// Of a motor that is there for clicks alone: engine samples of levels and orders that were none.
    unplayed: u64,
    /// Of such a motor: clicks of which some did not get through the coupling.
    cut: u64,
}

#[derive(Debug, Serialize)]
struct By {
    bound: &'static str,
    samples: u64,
    /// The most by which it changed one, volts.
    most: f64,
}

/// Of each output whose actuator is known.
pub fn held_back(plan: &Plan, stage: &Stage) -> Vec<HeldBack> {
    let known = |output: &pacinian::graph::plan::Output| {
        let channel = output.channel as usize;
        let (bounds, motor) = (stage.protections().counts(channel), stage.drives().counts_of(channel));
        if bounds.is_none() && motor.is_none() {
            return None;
        }
        let (counts, motor) = (bounds.unwrap_or_default(), motor.unwrap_or_default());
        let watched = plan.protections.iter().find(|(at, _)| *at == output.channel).map(|(_, bounds)| bounds);
        Some(HeldBack {
            channel: output.channel + 1,
            name: output.name.to_string(),
            samples: counts.changed,
            by: by(&counts),
            warmest: watched.and_then(|bounds| bounds.heat).map(|_| counts.warmest),
            farthest: watched.and_then(|bounds| bounds.stroke).map(|_| counts.farthest),
            short: motor.limited,
            dropped: motor.dropped,
            backward: motor.backward,
            unplayed: motor.unplayed,
            cut: motor.cut,
        })
    };
    plan.outputs.iter().filter_map(known).collect()
}

fn by(counts: &Counts) -> Vec<By> {
    let all: [(&'static str, Touched); 7] = [
        ("what alternates", counts.alternating),
        ("heat", counts.heat),
        ("mean square", counts.rms),
        ("what is steady", counts.steady),
        ("peak", counts.peak),
        ("slew", counts.slew),
        ("stroke", counts.stroke),
    ];
    let acted = all.into_iter().filter(|(_, touched)| touched.samples > 0);
    acted.map(|(bound, touched)| By { bound, samples: touched.samples, most: touched.most }).collect()
}

/// As lines for people: of the outputs where something was held back; empty where nothing was.
pub fn text(all: &[HeldBack]) -> String {
    let mut table = Table::default();
    for one in all
        .iter()
        .filter(|one| one.samples + one.short + one.dropped + one.backward + one.unplayed + one.cut > 0)
    {
        let mut told: Vec<String> = one
            .by
            .iter()
            .map(|by| format!("{} {} samples by up to {:.3} V", by.bound, grouped(by.samples), by.most))
            .collect();
        told.extend(one.warmest.map(|kelvins| format!("winding {kelvins:.0} K above the air")));
        told.extend(one.farthest.map(|metres| format!("moved {:.2} mm", 1e3 * metres)));
        if one.short > 0 {
            told.push(format!(
                "the motor could not do all of what was played in {} engine samples",
                grouped(one.short)
            ));
        }
        if one.dropped > 0 {
            told.push(format!("{} orders found no room", grouped(one.dropped)));
        }
        if one.backward > 0 {
            told.push(format!(
                "{} engine samples and orders were for backward, which its rectifier does not let",
                grouped(one.backward)
            ));
        }
        if one.unplayed > 0 {
            told.push(format!(
                "{} engine samples and orders were no clicks, and nothing else is played there",
                grouped(one.unplayed)
            ));
        }
        if one.cut > 0 {
            let clicks = if one.cut == 1 { "click" } else { "clicks" };
            told.push(format!(
                "{} {clicks} came before the coupling had room again, and turned the mass less far",
                grouped(one.cut)
            ));
        }
        table.row([one.channel.to_string(), one.name.clone(), told.join("; ")]);
    }
    table.text()
}
