//! What is computed: a motor or a coil, its drive, from rest.

use std::f64::consts::TAU;

use super::equation::Equation;
use crate::actuator::coil::bounds::{Bounds, EndStop};
use crate::actuator::coil::large::Shape;
use crate::actuator::coil::parameters::{Coil, Inertial, Skin, Spring, Tissue, VoiceCoil};
use crate::actuator::coil::plant::Plant;
use crate::actuator::fault::Fault;
use crate::actuator::motor::{Casing, GRAVITY, Parameters};

/// A problem. All begin at rest, without current; a mass hangs.
#[derive(Debug, Clone, PartialEq)]
pub struct Problem {
    /// The model it is for: "rumble motor".
    pub model: &'static str,
    /// A word or two: "full".
    pub name: &'static str,
    /// What happens in it, in a line.
    pub about: &'static str,
    /// What is moved.
    pub subject: Subject,
    /// Volts at its terminals.
    pub signal: Signal,
    /// Until when it is looked at.
    pub seconds: f64,
}

/// What is moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Subject {
    /// A rumble motor with an inductance; what its casing does is not looked at.
    Motor(Parameters),
    /// A tactor with an inductance on a skin of at most one branch.
    Tactor(VoiceCoil),
    /// An inertial motor with an inductance that no hand holds.
    Inertial(Inertial),
    /// Such a tactor in large motion, before an end stop, within the reach of its shape.
    Large(VoiceCoil, EndStop, Shape),
}

/// Volts over time.
#[derive(Debug, Clone, PartialEq)]
pub enum Signal {
    /// Until which second, how many.
    Pieces(Vec<(f64, f64)>),
    /// A sine that swells and fades: volts × sin² πt/T × sin 2πft until T, then nothing.
    Burst {
        /// At its largest.
        volts: f64,
        /// f.
        hertz: f64,
        /// T.
        seconds: f64,
    },
}

impl Signal {
    /// Volts at a time.
    pub fn at(&self, time: f64) -> f64 {
        match self {
            // An instant that rounding puts just before the end of a piece belongs to the next.
            Self::Pieces(pieces) => {
                pieces.iter().find(|(until, _)| time < until - 1e-9).map_or(0.0, |(_, volts)| *volts)
            }
            Self::Burst { volts, hertz, seconds } if time < *seconds => {
                volts * (0.5 - 0.5 * (TAU * time / seconds).cos()) * (TAU * hertz * time).sin()
            }
            Self::Burst { .. } => 0.0,
        }
    }
}

impl Problem {
    /// What is held over each sample: the signal where the sample begins.
    pub fn drives(&self, rate: f64) -> Vec<f64> {
        let samples = (self.seconds * rate).round().max(1.0) as usize;
        (0..samples).map(|n| self.signal.at(n as f64 / rate)).collect()
    }

    /// Its differential equations.
    pub fn equation(&self) -> Equation {
        match &self.subject {
            Subject::Motor(p) => Equation::motor(p),
            Subject::Tactor(v) => Equation::tactor(v),
            Subject::Inertial(m) => Equation::inertial(m),
            Subject::Large(v, stop, shape) => Equation::tactor(v).in_large(&v.suspension, shape, stop),
        }
    }

    /// For the models of coils: the plant and what bounds it; `None` for a motor.
    ///
    /// # Errors
    /// The first parameter that cannot be.
    pub fn plant(&self) -> Result<Option<(Plant, Bounds)>, Fault> {
        let free = Bounds::default();
        Ok(match &self.subject {
            Subject::Motor(_) => None,
            Subject::Tactor(v) => Some((Plant::voice_coil(v)?, free)),
            Subject::Inertial(m) => Some((Plant::inertial(m)?, free)),
            Subject::Large(v, stop, _) => {
                Some((Plant::voice_coil(v)?, Bounds { end_stop: Some(*stop), ..free }))
            }
        })
    }

    /// Whether errors are of the speed as a share of the rated speed, and of the angle; else of the displacement as a share of its peak.
    pub fn spins(&self) -> bool {
        matches!(self.subject, Subject::Motor(_))
    }
}

/// A coin motor of 10 mm, upright on 100 g; L/R 10 µs.
const COIN: Parameters = Parameters {
    resistance: 30.0,
    inductance: 3e-4,
    gain: 0.955e-3,
    inertia: 1.8e-9,
    viscous: 2.15e-8,
    coulomb: 1.5e-5,
    stiction: 2e-5,
    eccentric: 7.3e-7,
    gravity: GRAVITY,
    casing: Casing::Free { mass: 0.1 },
    rated_volts: 3.0,
};

/// The tactor and the inertial motor whose responses are known.
const TACTOR: VoiceCoil = VoiceCoil {
    coil: Coil { resistance: 7.0, inductance: 2.5e-4, force_factor: 1.2 },
    mass: 1.5e-3,
    suspension: Spring { stiffness: 3132.7, damping: 0.6 },
    skin: Skin::One(Tissue { mass: 1e-4, spring: Spring { stiffness: 1200.0, damping: 1.5 } }),
};
const INERTIAL: Inertial = Inertial {
    coil: Coil { resistance: 6.0, inductance: 2e-4, force_factor: 1.5 },
    slug_mass: 5.5e-3,
    casing_mass: 0.10,
    suspension: Spring { stiffness: 741.0, damping: 0.983 },
    hand: Tissue { mass: 0.0, spring: Spring { stiffness: 0.0, damping: 0.0 } },
};

/// The problems that are raced.
pub fn listed() -> Vec<Problem> {
    // Ten times the inductance, so that plain methods have a chance: L/R 0.1 ms.
    let slow = Parameters { inductance: 3e-3, ..COIN };
    let linear = Parameters { gravity: 0.0, coulomb: 0.0, stiction: 0.0, ..COIN };
    let smooth = Parameters { coulomb: 0.0, stiction: 0.0, ..slow };
    let turns = |until: [f64; 3]| Signal::Pieces(until.into_iter().zip([3.0, -3.0, 0.0]).collect());
    let stop = EndStop { stroke: 4e-4, spring: Spring { stiffness: 2e4, damping: 1.0 } };
    let shape = Shape { force_falls: Some(1e-3), stiffens: Some(6e-4), reach: 8e-4 };
    let motor = "rumble motor";
    vec![
        Problem {
            model: motor,
            name: "linear",
            about: "step, reversal, short; no gravity, no dry friction; L/R 10 µs",
            subject: Subject::Motor(linear),
            signal: turns([0.04, 0.08, 0.12]),
            seconds: 0.12,
        },
        Problem {
            model: motor,
            name: "gravity",
            about: "step, reversal, short under gravity; no dry friction; L/R 100 µs",
            subject: Subject::Motor(smooth),
            signal: turns([0.06, 0.1, 0.15]),
            seconds: 0.15,
        },
        Problem {
            model: motor,
            name: "full",
            about: "step, reversal, short until it sticks; gravity and dry friction; L/R 100 µs",
            subject: Subject::Motor(slow),
            signal: turns([0.06, 0.09, 0.15]),
            seconds: 0.15,
        },
        Problem {
            model: "tactor",
            name: "burst",
            about: "3 V at 250 Hz swell and fade, another voltage at each sample; on skin",
            subject: Subject::Tactor(TACTOR),
            signal: Signal::Burst { volts: 3.0, hertz: 250.0, seconds: 0.05 },
            seconds: 0.06,
        },
        Problem {
            model: "inertial motor",
            name: "burst",
            about: "3 V at 80 Hz swell and fade, another voltage at each sample; no hand",
            subject: Subject::Inertial(INERTIAL),
            signal: Signal::Burst { volts: 3.0, hertz: 80.0, seconds: 0.08 },
            seconds: 0.12,
        },
        Problem {
            model: "tactor",
            name: "large",
            about: "18 V at 200 Hz: less force and more stiffness far out, and an end stop",
            subject: Subject::Large(TACTOR, stop, shape),
            signal: Signal::Burst { volts: 18.0, hertz: 200.0, seconds: 0.05 },
            seconds: 0.06,
        },
    ]
}
