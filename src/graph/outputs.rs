//! The outputs of a rig, as the plan has them: where they lie, what shares points, and what evens them out.

use std::sync::Arc;

use super::plan::{Output, OutputKind};
use crate::dsp::biquad::Biquad;
use crate::rig::{self, Finder, Rig};
use crate::space::array::Array;
use crate::space::spot::Spread;
use crate::text::Problem;

/// Each output, and then what sounds together.
pub(super) fn places_of(rig: &Rig, finder: &Finder, has_knob: bool) -> Vec<Vec<(u32, f64)>> {
    // What is played on a knob is for its effects, and goes nowhere where there is none.
    let place = if has_knob { place_of } else { place };
    let of =
        |all: &Vec<usize>| all.iter().filter_map(|output| rig.outputs.get(*output)).flat_map(place).collect();
    rig.outputs.iter().map(place).chain(finder.together().iter().map(of)).collect()
}

/// The tactors that share points.
pub(super) fn spread(rig: &Rig, problems: &mut Vec<Problem>) -> Option<Spread> {
    let tactors = rig.outputs.iter().filter(|output| output.kind == rig::OutputKind::Vibration);
    let (positions, channels): (Vec<_>, Vec<_>) =
        tactors.filter_map(|output| Some((output.position?, *place(output).first()?))).unzip();
    if positions.is_empty() {
        return None;
    }
    match Array::new(&positions) {
        Ok(array) => Spread::new(array, channels),
        Err(fault) => {
            problems.push(Problem::of_file(format!(
                "points cannot be shared by the tactors of the rig: {fault}"
            )));
            None
        }
    }
}

/// Where what is played on an output goes, and how strongly: nowhere, on one that gives torque.
fn place(output: &rig::Output) -> Vec<(u32, f64)> {
    if output.kind == rig::OutputKind::Torque {
        return Vec::new();
    }
    place_of(output)
}

/// The same, whatever it gives.
fn place_of(output: &rig::Output) -> Vec<(u32, f64)> {
    let gain = if output.inverted { -output.gain } else { output.gain };
    vec![(output.channel.saturating_sub(1), gain)]
}

/// An output of the rig, for an engine at `rate`; markers that it waits for get their places in `markers`.
pub(super) fn output(
    output: &rig::Output,
    rig: &Rig,
    steady: bool,
    rate: f64,
    markers: &mut Vec<Arc<str>>,
    problems: &mut Vec<Problem>,
) -> Output {
    let kind = match &output.kind {
        rig::OutputKind::Trigger { marker, pulse } => {
            let number = |name: &String| {
                let place = markers.iter().position(|m| **m == **name).unwrap_or_else(|| {
                    markers.push(name.as_str().into());
                    markers.len() - 1
                });
                place as u32
            };
            OutputKind::Trigger { marker: marker.as_ref().map(number), pulse: *pulse }
        }
        rig::OutputKind::Vibration => OutputKind::Vibration,
        rig::OutputKind::Raw => OutputKind::Raw,
        rig::OutputKind::Drive(_) => OutputKind::Drive,
        rig::OutputKind::Torque => OutputKind::Silent,
    };
    let actuator = output.actuator.as_ref().and_then(|name| rig.actuator(name));
    let equaliser = match (kind, actuator) {
        (OutputKind::Vibration, Some(actuator)) => equaliser(rig, output, actuator, rate, problems),
        _ => Vec::new(),
    };
    Output {
        name: output.name.as_str().into(),
        channel: output.channel.saturating_sub(1),
        kind,
        equaliser,
        keeps_dc_off: steady && !output.is_for_dc(),
        max_level: rig.max_level(output),
    }
}

/// The sections of an actuator's equaliser at the engine's rate: what its model asks for, and then its own filters.
fn equaliser(
    rig: &Rig,
    output: &rig::Output,
    actuator: &rig::Actuator,
    rate: f64,
    problems: &mut Vec<Problem>,
) -> Vec<Biquad> {
    let even = match rig.evened(output) {
        Some(Ok(even)) => {
            let (b, a) = even.section(rate);
            Some(Biquad { b, a })
        }
        Some(Err(problem)) => {
            let problem = Problem { span: None, ..problem };
            if !problems.contains(&problem) {
                problems.push(problem);
            }
            None
        }
        None => None,
    };
    let section = |peak: &rig::Peak| {
        if peak.frequency >= 0.5 * rate {
            let what = format!(
                "actuator `{}` has a filter at {} Hz; at an engine rate of {rate} Hz they end below {} Hz",
                actuator.name,
                peak.frequency,
                0.5 * rate
            );
            let problem = Problem::of_file(what).help("what vibrates stays below 1000 Hz".to_string());
            if !problems.contains(&problem) {
                problems.push(problem);
            }
        }
        Biquad::peaking(peak.frequency, peak.q, peak.gain_db, rate)
    };
    even.into_iter().chain(actuator.equaliser.iter().map(section)).collect()
}
