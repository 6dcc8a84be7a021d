//! What `pacinian motor` says of a rumble motor, as programs read it.

use super::subject::Subject;
use pacinian::actuator::motor::Parameters;
use pacinian::report::motion::{Arrival, Behind, Bench, Done, Row};
use serde::Serialize;
use std::f64::consts::TAU;

/// Everything there is to say.
#[derive(Debug, Serialize)]
pub struct Answer {
    pub name: String,
    pub title: String,
    pub model: &'static str,
    pub motor: About,
    pub figures: Figures,
    pub computed: Computed,
    pub wish: Wished,
    pub ways: Vec<WayReport>,
    pub coupling: Vec<CouplingReport>,
}

/// What the motor is. Null where it is not known.
#[derive(Debug, Serialize)]
pub struct About {
    pub rated_volts: f64,
    /// The most either way.
    pub limit_volts: f64,
    pub rated_speed: f64,
    pub turns_per_second: f64,
    pub rated_vibration: f64,
    /// That of `rated_vibration` and of every `peak`.
    pub unit: &'static str,
    pub mass: Option<f64>,
    pub mechanical_time: f64,
    pub electrical_time: f64,
    pub start_volts: f64,
    pub running_amperes: Option<f64>,
    pub standstill_amperes: Option<f64>,
    /// In the plane of rotation, m/s²; null where the posture is not known.
    pub gravity: Option<f64>,
}

/// How its figures came to be known.
#[derive(Debug, Serialize)]
pub struct Figures {
    /// By origin.
    pub origins: std::collections::BTreeMap<&'static str, usize>,
    pub from_the_rig: usize,
    /// Those that nobody measured.
    pub assumed: Vec<&'static str>,
}

/// How well it was computed.
#[derive(Debug, Serialize)]
pub struct Computed {
    pub level: &'static str,
    pub rate: f64,
    pub wished_error: f64,
    /// What gravity's interpolation leaves, as a share of the rated speed.
    pub error: f64,
    /// Whether that is within the wish.
    pub reached: bool,
    pub left_out: Vec<String>,
}

/// What was wanted.
#[derive(Debug, Serialize)]
pub struct Wished {
    pub level: f64,
    pub seconds: f64,
    pub envelope: &'static str,
    pub turns: f64,
    pub angle: f64,
    /// The course of one's own, if there is one.
    pub drive: bool,
}

/// What came of a way; but for its name null where it cannot be, and `why` says why.
#[derive(Debug, Serialize)]
pub struct WayReport {
    pub way: &'static str,
    pub rise_50: Option<f64>,
    pub rise_90: Option<f64>,
    pub peak: Option<f64>,
    pub peak_at: Option<f64>,
    pub stop: Option<f64>,
    pub stands_at: Option<f64>,
    pub felt: Option<[f64; 2]>,
    pub error: Option<f64>,
    pub turns: Option<f64>,
    /// Where the mass is at the end, rad from straight down, within ±π.
    pub angle: Option<f64>,
    /// The largest torque that the casing gets about the shaft, N m.
    pub peak_reaction: Option<f64>,
    pub look_ahead: Option<f64>,
    /// Joules.
    pub energy: Option<EnergyReport>,
    /// Of a click: seconds forward, backward, forward again.
    pub click: Option<[f64; 3]>,
    pub why: Option<String>,
}

/// What came in and where it went, joules.
#[derive(Debug, Serialize)]
pub struct EnergyReport {
    pub supplied: f64,
    pub coil_heat: f64,
    pub friction: f64,
    pub lost_when_opened: f64,
    /// Still in it at the end.
    pub stored: f64,
}

/// A click behind coupling.
#[derive(Debug, Serialize)]
pub struct CouplingReport {
    pub corners: Vec<f64>,
    pub plain: ArrivalReport,
    pub compensated: ArrivalReport,
    pub lead: f64,
    pub tail: f64,
}

/// What arrives of it.
#[derive(Debug, Serialize)]
pub struct ArrivalReport {
    /// Share of the click's volt-seconds that is missing, and the largest difference, V.
    pub missing: f64,
    pub worst_volts: f64,
    /// Volts before and after, beyond what does not matter.
    pub outside_volts: f64,
    pub turns: f64,
    /// Speed when the click is over, as a share of its largest.
    pub speed_left: f64,
    pub stop: Option<f64>,
}

impl About {
    /// Of what was computed.
    pub fn new(subject: &Subject, bench: &Bench, limit: f64, posture: bool) -> Self {
        let p: &Parameters = &bench.parameters;
        let known = |amperes: f64| subject.actuator.has_torques().then_some(amperes);
        Self {
            rated_volts: p.rated_volts,
            limit_volts: limit,
            rated_speed: p.rated_speed(),
            turns_per_second: p.rated_speed() / std::f64::consts::TAU,
            rated_vibration: bench.rated(),
            unit: bench.felt().unit(),
            mass: subject.actuator.value("mass"),
            mechanical_time: p.mechanical_time(),
            electrical_time: p.electrical_time(),
            start_volts: p.start_volts(),
            running_amperes: known(p.steady_current(p.rated_volts)),
            standstill_amperes: subject.actuator.value("resistance").map(|ohms| p.rated_volts / ohms),
            gravity: posture.then_some(p.gravity),
        }
    }
}

impl WayReport {
    /// Of what was computed, with torques and joules where they are known.
    pub fn new(row: &Row, torques: bool) -> Self {
        let done = row.done.as_ref();
        let of = done.ok();
        let figures = of.map(|done| done.figures);
        Self {
            way: row.way.word(),
            rise_50: figures.and_then(|f| f.rise[0]),
            rise_90: figures.and_then(|f| f.rise[1]),
            peak: figures.map(|f| f.peak),
            peak_at: figures.map(|f| f.peak_at),
            stop: figures.and_then(|f| f.stop),
            stands_at: of.and_then(|done| done.run.stands),
            felt: figures.and_then(|f| f.felt),
            error: figures.and_then(|f| f.error),
            turns: of.map(|done| done.run.turns),
            angle: of
                .and_then(|done| done.run.traces.angles.last())
                .map(|angle| angle - TAU * (angle / TAU).round()),
            peak_reaction: of.filter(|_| torques).map(|done| {
                done.run.traces.reactions.iter().fold(0.0, |most, torque| torque.abs().max(most))
            }),
            look_ahead: of.map(|done| done.look_ahead),
            energy: of.filter(|_| torques).map(EnergyReport::new),
            click: of.and_then(|done| done.click.as_ref()).map(|click| click.seconds),
            why: done.err().map(ToString::to_string),
        }
    }
}

impl EnergyReport {
    /// Of what was computed.
    pub fn new(done: &Done) -> Self {
        let energy = &done.run.energy;
        Self {
            supplied: energy.supplied,
            coil_heat: energy.heat,
            friction: energy.viscous + energy.dry,
            lost_when_opened: energy.opened,
            stored: done.run.stored - energy.placed,
        }
    }
}

impl CouplingReport {
    /// Of what was computed.
    pub fn new(behind: &Behind) -> Self {
        let arrival = |arrival: &Arrival| ArrivalReport {
            missing: arrival.shortfall.share,
            worst_volts: arrival.shortfall.worst,
            outside_volts: arrival.shortfall.outside,
            turns: arrival.turns,
            speed_left: arrival.left,
            stop: arrival.stop,
        };
        Self {
            corners: behind.corners.hertz().to_vec(),
            plain: arrival(&behind.plain),
            compensated: arrival(&behind.compensated),
            lead: behind.lead,
            tail: behind.tail,
        }
    }
}
