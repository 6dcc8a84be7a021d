//! The model of an actuator, as much of it as is needed.

use super::figures::Figures;
use super::heat::Heat;
use super::left::Left;
use super::now::Now;
use super::spinner::{Spinner, plan, with_coil};
use super::swinger::Swinger;
use super::trace::{Axis, Unit};
use crate::actuator::coil::plant::Plant;
use crate::actuator::drive::Drive;
use crate::actuator::fault::Fault;
use crate::actuator::link::amplifier::Amplifier;
use crate::actuator::link::carrier::Carrier;
use crate::actuator::link::fineness::parts;
use crate::actuator::motor::{Casing, GRAVITY, Level, Part};
use crate::rig::{Actuator, Model, Output, OutputKind};

/// A model that moves, and what of it was chosen.
#[derive(Debug, Clone)]
pub(super) struct Mover {
    moves: Moves,
    pub axes: &'static [Axis],
    pub unit: Unit,
    pub level: Option<Level>,
    pub steps: u32,
    pub left_out: Vec<Left>,
    /// The error that is left where it is more than the wish.
    pub reaches: Option<f64>,
}

#[derive(Debug, Clone)]
enum Moves {
    Coil(Box<Swinger>),
    /// And whether its torques and joules are real ones.
    Motor(Box<Spinner>, bool),
}

/// What an output for the skin holds nothing beyond, Hz.
const BAND: f64 = 1000.0;

impl Mover {
    /// The least that grants an error; `None` where a figure is missing.
    ///
    /// # Errors
    /// A figure that cannot be.
    pub fn new(
        actuator: &Actuator,
        output: &Output,
        amplifier: &Amplifier,
        carrier: Option<&Carrier>,
        rate: f64,
        error: f64,
    ) -> Result<Option<Self>, Fault> {
        let heat = Heat::new(actuator.cooling().as_ref(), 1.0 / rate)?;
        if actuator.model == Model::RumbleMotor {
            let Ok(mut parameters) = actuator.rumble_motor() else { return Ok(None) };
            let tilt = if let OutputKind::Drive(turning) = &output.kind { turning.tilt } else { None };
            let posture = tilt.is_some() && actuator.has_torques();
            // Where the posture, or the weight, is unknown the plan says so, and leaves it out.
            parameters.gravity = if posture { actuator.gravity(tilt) } else { GRAVITY };
            let mut chosen = plan(&parameters, rate, error, posture);
            if tilt.is_some() && !posture {
                chosen.0 = chosen.0.of_unknown_weight();
            }
            let gravity = 2.0 * chosen.0.error(&parameters, rate * f64::from(chosen.1));
            let mut left = Some(gravity).filter(|left| *left > error);
            if let Some(carrier) = carrier {
                chosen.0 = with_coil(chosen.0);
                // What is felt goes with the square of the speed.
                let (parts, off) = parts(carrier.hertz, rate, 0.5 * error);
                chosen.1 = chosen.1.max(parts);
                left = Some(gravity.max(2.0 * off)).filter(|left| *left > error);
            }
            // Where nothing moves, that is told as force.
            let left_out = chosen.0.left_out.into_iter().flatten().filter(|left| left.part != Part::Casing);
            let spinner = Spinner::new(&parameters, chosen, amplifier, carrier, rate, heat)?;
            return Ok(Some(Self {
                moves: Moves::Motor(Box::new(spinner), actuator.has_torques()),
                axes: &[Axis::Across, Axis::Upright],
                unit: if parameters.casing == Casing::Held { Unit::Force } else { Unit::Acceleration },
                level: Some(chosen.0.level),
                steps: chosen.1,
                left_out: left_out.map(Left::Motor).collect(),
                reaches: left,
            }));
        }
        let Ok(mut plant) = actuator.coil() else { return Ok(None) };
        let band = if output.kind == OutputKind::Vibration { BAND } else { 0.5 * rate };
        let left = needless(&plant, amplifier, band, error);
        if left.is_some() {
            plant = plant.without_inductance();
        }
        let swinger = Swinger::new(&plant, amplifier, rate, heat)?;
        Ok(Some(Self {
            moves: Moves::Coil(Box::new(swinger)),
            axes: if plant.shakes() { &[Axis::Casing] } else { &[Axis::Contactor] },
            unit: Unit::Acceleration,
            level: None,
            steps: 1,
            left_out: left.into_iter().collect(),
            reaches: None,
        }))
    }

    /// Holds each drive (V or A) for a sample, or those before diodes for a step each, and says what is felt on its axes over each.
    pub fn run(&mut self, drives: &[f64], felt: &mut [[f64; 2]]) {
        match &mut self.moves {
            Moves::Coil(swinger) => swinger.run(drives, felt),
            Moves::Motor(spinner, _) => spinner.run(drives, felt),
        }
    }

    /// What it does now, its drive aside.
    pub fn now(&self) -> Now {
        match &self.moves {
            Moves::Coil(swinger) => Now { energy: Some(swinger.energy()), ..Now::default() },
            Moves::Motor(spinner, torques) => Now {
                drive: 0.0,
                speed: Some(spinner.speed()),
                turned: Some(spinner.turned()),
                reaction: torques.then(|| spinner.reaction()),
                energy: torques.then(|| spinner.energy()),
            },
        }
    }

    /// Enters what only the model knows.
    pub fn fill_in(&self, figures: &mut Figures, stroke: Option<f64>) {
        let [limited, masked] = match &self.moves {
            Moves::Coil(swinger) => {
                figures.farthest = Some(swinger.farthest());
                figures.of_stroke = stroke.map(|stroke| swinger.farthest() / stroke);
                figures.energy = Some(swinger.energy());
                figures.warmest = swinger.warmest();
                swinger.counts()
            }
            Moves::Motor(spinner, torques) => {
                figures.fastest = Some(spinner.fastest());
                figures.energy = torques.then(|| spinner.energy());
                figures.warmest = spinner.warmest().filter(|_| *torques);
                spinner.counts()
            }
        };
        figures.counts.limited += limited;
        figures.counts.masked += masked;
    }
}

/// Why the inductance of a coil is not needed. With it, what a volt does is divided by 1 + s L/Z, and |Z| is no less than the resistance, as
/// what moves takes energy and gives none: so it changes that by no more than ω L/R.
fn needless(plant: &Plant, amplifier: &Amplifier, band: f64, error: f64) -> Option<Left> {
    let coil = plant.coil();
    if coil.inductance == 0.0 {
        return None;
    }
    if amplifier.drive == Drive::Current {
        return amplifier.volts.is_none().then_some(Left::Imposed);
    }
    let share = std::f64::consts::TAU * band * coil.inductance / coil.resistance;
    (share <= error).then_some(Left::Small(share))
}
