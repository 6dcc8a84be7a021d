//! What was held back for the sake of actuators, and what their motors could not do.

use super::table::{Table, grouped};
use pacinian::actuator::drive::Drive;
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
    /// Of a motor: what of all the speed that levels asked for it could not do, as a share.
    missed: f64,
    dropped: u64,
    /// Of a motor that turns one way: engine samples and orders that were for the other.
    backward: u64,
    /// Of a motor that is there for clicks alone: engine samples of levels and orders that were none.
    unplayed: u64,
    /// Of a motor that cannot be brought home: orders to go there.
    homeless: u64,
    /// Of a motor that is there for clicks alone: clicks of which some did not get through the coupling.
    cut: u64,
    /// Of a motor that was warm: clicks that began weaker than they were ordered, and clicks that were not begun.
    weakened: u64,
    refused: u64,
}

#[derive(Debug, Serialize)]
struct By {
    bound: &'static str,
    samples: u64,
    /// The most by which it changed one, in this unit.
    most: f64,
    unit: &'static str,
}

/// Of each output whose actuator is known.
pub fn held_back(plan: &Plan, stage: &Stage) -> Vec<HeldBack> {
    let known = |output: &pacinian::graph::plan::Output| {
        let channel = output.channel as usize;
        let (bounds, motor) = (stage.protections().counts(channel), stage.drives().counts_of(channel));
        if bounds.is_none() && motor.is_none() {
            return None;
        }
        let drive = plan.drives.iter().find(|drive| drive.channel == output.channel);
        let imposes = drive.map_or(Drive::Voltage, |drive| drive.setup.imposes);
        let counts = bounds.or_else(|| stage.drives().held_back(channel)).unwrap_or_default();
        let motor = motor.unwrap_or_default();
        let watched = plan.protections.iter().find(|(at, _)| *at == output.channel).map(|(_, bounds)| bounds);
        let bears = drive.and_then(|drive| drive.bears);
        let heat = watched.and_then(|bounds| bounds.heat).or(bears.and_then(|bears| bears.heat));
        Some(HeldBack {
            channel: output.channel + 1,
            name: output.name.to_string(),
            samples: counts.changed,
            by: by(&counts, if imposes == Drive::Voltage { "V" } else { "A" }),
            warmest: heat.map(|_| counts.warmest),
            farthest: watched.and_then(|bounds| bounds.stroke).map(|_| counts.farthest),
            short: motor.limited,
            missed: if motor.played > 0.0 { motor.missed / motor.played } else { 0.0 },
            dropped: motor.dropped,
            backward: motor.backward,
            unplayed: motor.unplayed,
            homeless: motor.homeless,
            cut: motor.cut,
            weakened: motor.weakened,
            refused: motor.refused,
        })
    };
    plan.outputs.iter().filter_map(known).collect()
}

fn by(counts: &Counts, unit: &'static str) -> Vec<By> {
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
    acted.map(|(bound, touched)| By { bound, samples: touched.samples, most: touched.most, unit }).collect()
}

/// As lines for people: of the outputs where something was held back; empty where nothing was.
pub fn text(all: &[HeldBack]) -> String {
    let mut table = Table::default();
    let is_told = |one: &&HeldBack| {
        let counts = [
            one.short,
            one.dropped,
            one.backward,
            one.unplayed,
            one.homeless,
            one.cut,
            one.weakened,
            one.refused,
        ];
        one.samples + counts.iter().sum::<u64>() > 0
    };
    for one in all.iter().filter(is_told) {
        let mut told: Vec<String> = one
            .by
            .iter()
            .map(|by| {
                let (samples, unit) = (grouped(by.samples), by.unit);
                format!("{} {samples} samples by up to {:.3} {unit}", by.bound, by.most)
            })
            .collect();
        told.extend(one.warmest.map(|kelvins| format!("winding {kelvins:.0} K above the air")));
        told.extend(one.farthest.map(|metres| format!("moved {:.2} mm", 1e3 * metres)));
        if one.short > 0 {
            let by = match (100.0 * one.missed).round() {
                0.0 => String::new(),
                percent => format!(": {percent} % of the speed was out of its reach"),
            };
            let samples = grouped(one.short);
            told.push(format!(
                "the motor could not do all of what was played in {samples} engine samples{by}"
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
        if one.homeless > 0 {
            let orders = if one.homeless == 1 { "order" } else { "orders" };
            told.push(format!(
                "{} {orders} to go home did nothing: `pacinian check` says why its mass cannot be brought there",
                grouped(one.homeless)
            ));
        }
        if one.cut > 0 {
            let clicks = if one.cut == 1 { "click" } else { "clicks" };
            told.push(format!(
                "{} {clicks} asked for more room than the coupling had, or had again yet, and turned the mass less far",
                grouped(one.cut)
            ));
        }
        if one.weakened > 0 {
            let clicks = if one.weakened == 1 { "click" } else { "clicks" };
            told.push(format!(
                "{} {clicks} began weaker than ordered, as the motor was warm, and turned the mass less far",
                grouped(one.weakened)
            ));
        }
        if one.refused > 0 {
            let clicks = if one.refused == 1 { "click was" } else { "clicks were" };
            told.push(format!(
                "{} {clicks} not begun: the motor was too warm for them",
                grouped(one.refused)
            ));
        }
        table.row([one.channel.to_string(), one.name.clone(), told.join("; ")]);
    }
    table.text()
}
