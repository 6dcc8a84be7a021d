//! What each channel needs to be felt.

use std::sync::Arc;

use crate::dsp::biquad::Biquad;
use crate::dsp::blocker::CORNER;
use crate::dsp::elliptic::Elliptic;
use crate::graph::plan::Output;
use crate::perception::calibration::{Per, Quantity, Table, Unit};
use crate::perception::gauge::{Gauge, Path};
use crate::perception::threshold::{CONTACTOR, RANGE, Threshold};
use crate::rig::{self, Rig};
use crate::text::Problem;

/// What each channel needs to be felt, at the engine's rate, of what vibrates on it. Where `must`, problems are told of calibrations that are missing.
pub fn gauges(
    rig: &Rig,
    planned: &[Output],
    rate: f64,
    must: bool,
    problems: &mut Vec<Problem>,
) -> Arc<[Option<Gauge>]> {
    let mut gauges = vec![None; rig.device.channels as usize];
    for output in &rig.outputs {
        if !matches!(output.kind, rig::OutputKind::Vibration | rig::OutputKind::Raw) {
            continue;
        }
        let channel = output.channel.saturating_sub(1);
        let Some(slot) = gauges.get_mut(channel as usize) else { continue };
        let Some(planned) = planned.iter().find(|planned| planned.channel == channel) else { continue };
        match gauge(rig, output, planned, rate) {
            Ok(gauge) => *slot = Some(gauge),
            Err(problem) if must => problems.push(problem),
            Err(_) => {}
        }
    }
    gauges.into()
}

fn gauge(rig: &Rig, output: &rig::Output, planned: &Output, rate: f64) -> Result<Gauge, Problem> {
    let mut path = Path {
        gain: output.gain,
        per_sample: 1.0,
        corners: if planned.keeps_dc_off { vec![CORNER] } else { Vec::new() },
        filters: filters(output, planned, rate),
        rate,
        most: most(rig, output),
        limited: (output.kind == rig::OutputKind::Vibration).then(|| rig.max_level(output)),
    };
    if output.gain == 0.0 {
        let what = format!("output `{}` has a `gain` of 0: nothing is felt on it", output.name);
        return Err(Problem::error(&output.span, what).help("give it a `gain` above 0".to_string()));
    }
    let site = rig.site_of(output);
    let Some(calibration) = rig.calibration_of(output) else {
        let threshold = Threshold::new(site, CONTACTOR);
        return Ok(match modelled(rig, output) {
            Some(shape) => Gauge::relative(threshold, shape, path),
            None => Gauge::unknown(threshold, path),
        });
    };
    let of_file = |what: String| {
        let problem =
            Problem::of_file(format!("calibration `{}` of `{}`: {what}", calibration.name, output.name));
        problem.help("the rig is read with `pacinian::io::load::rig`".to_string())
    };
    let table = match calibration.response() {
        Some(Ok(table)) => table,
        Some(Err(fault)) => return Err(of_file(fault.to_string())),
        None => {
            let file = calibration.file.as_deref().unwrap_or_default();
            return Err(of_file(format!("its file `{file}` was not read")));
        }
    };
    path.per_sample =
        rig.per_sample(output, calibration).map_err(|problem| Problem { span: None, ..problem })?;
    // Over full scale, it was measured behind everything.
    if calibration.unit.per != Per::FullScale {
        path.behind(&rig.corners(output));
    }
    Ok(Gauge::calibrated(Threshold::new(site, calibration.area), table, path))
}

/// What is done to it on its way out: the actuator's equaliser and the band limit.
fn filters(output: &rig::Output, planned: &Output, rate: f64) -> Vec<Biquad> {
    let mut filters = planned.equaliser.clone();
    if output.kind == rig::OutputKind::Vibration {
        let Elliptic { gain, mut sections, .. } = Elliptic::band_limit(rate);
        sections.iter_mut().take(1).for_each(|section| section.b = section.b.map(|b| gain * b));
        filters.append(&mut sections);
    }
    filters
}

/// The largest sample that leaves an output as it is, by its `max_level` and by what amplifier and actuator bear.
fn most(rig: &Rig, output: &rig::Output) -> f64 {
    let amplifier = output.amplifier.as_ref().and_then(|name| rig.amplifier(name));
    let actuator = output.actuator.as_ref().and_then(|name| rig.actuator(name));
    let (volts, amperes) = (rig.volts_per_sample(output), rig.amperes_per_sample(output));
    let share = |bears: Option<f64>, scale: Option<f64>| Some(bears? / scale?);
    [
        share(actuator.and_then(rig::Actuator::most_volts), volts),
        share(amplifier.and_then(|amplifier| amplifier.max_volts), volts),
        share(actuator.and_then(|actuator| actuator.value("max_amperes")), amperes),
        share(amplifier.and_then(|amplifier| amplifier.max_amperes), amperes),
    ]
    .into_iter()
    .flatten()
    .fold(rig.max_level(output), f64::min)
}

/// Frequencies at which a model is asked, evenly spaced on a logarithm.
const ASKED: i32 = 96;

/// The shape of what an output's actuator does by its model, in no unit: the displacement of a contactor, or that of a casing. `None` without one.
fn modelled(rig: &Rig, output: &rig::Output) -> Option<Table> {
    let actuator = rig.actuator(output.actuator.as_ref()?)?;
    let plant = actuator.coil().ok()?;
    let amplifier = output.amplifier.as_ref().and_then(|name| rig.amplifier(name));
    let is_current = amplifier.is_some_and(|amplifier| amplifier.drive == rig::Drive::Current);
    let pushes = actuator.model == rig::Model::VoiceCoil;
    let does = |hertz: f64| {
        let response = if is_current { plant.per_ampere(hertz) } else { plant.per_volt(hertz) };
        if pushes { response.acceleration.abs() } else { response.casing.abs() }
    };
    let at = |n: i32| {
        if n == ASKED {
            RANGE[1]
        } else {
            RANGE[0] * (RANGE[1] / RANGE[0]).powf(f64::from(n) / f64::from(ASKED))
        }
    };
    let shape: Vec<[f64; 2]> = (0..=ASKED).map(|n| [at(n), does(at(n))]).collect();
    Table::new(&shape, Unit { quantity: Quantity::Acceleration, scale: 1.0, per: Per::Volt }).ok()
}
