//! A motor on which drives are tried, and what it did.

use std::f64::consts::TAU;

use crate::actuator::fault::{Fault, within};
use crate::actuator::motor::{Casing, Drive, Energy, Motor, Parameters, Plan};
use crate::actuator::shape::Course;

/// A motor at rest, how well it is computed, and where its mass hangs.
#[derive(Debug, Clone, Copy)]
pub struct Bench {
    /// The motor.
    pub parameters: Parameters,
    /// What of it is computed.
    pub plan: Plan,
    /// Steps a second.
    pub rate: f64,
    /// Where the mass hangs before, rad from straight down.
    pub angle: f64,
}

/// What is done to the terminals.
#[derive(Debug, Clone, PartialEq)]
pub enum Given {
    /// Drives that change at exact instants.
    Course(Course),
    /// Volts, a step each, and a short circuit behind them.
    Samples(Vec<f64>),
}

/// What a motor's vibration is told in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Felt {
    /// Acceleration of what it shakes, m/s².
    Acceleration,
    /// Force on what holds it, N: where nothing moves.
    Force,
}

impl Felt {
    /// The unit, as it is printed.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Acceleration => "m/s2",
            Self::Force => "N",
        }
    }
}

/// What a motor did, at the end of each step.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Traces {
    /// At the terminals, V.
    pub volts: Vec<f64>,
    /// A.
    pub amperes: Vec<f64>,
    /// rad/s.
    pub speeds: Vec<f64>,
    /// Magnitude of what is felt ([`Felt`]), that of the rotor's own acceleration included.
    pub felt: Vec<f64>,
    /// By how much the mass has turned since it hung straight down, whole turns included, rad.
    pub angles: Vec<f64>,
    /// What coil and friction do to the casing about the shaft, N m.
    pub reactions: Vec<f64>,
}

/// What a motor did under a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Steps a second.
    pub rate: f64,
    /// Over time.
    pub traces: Traces,
    /// What came in and where it went.
    pub energy: Energy,
    /// What is still stored at the end, J.
    pub stored: f64,
    /// From when on it stands, s; `None`: it still moved when it was given up.
    pub stands: Option<f64>,
    /// By how much the mass turned altogether, turns.
    pub turns: f64,
}

/// Seconds that it must stand to stand for good, and after which nobody waits for it any more.
const STAYS: f64 = 0.02;
const PATIENCE: f64 = 5.0;
/// Time constants that a drive without end is watched for.
const SETTLED: f64 = 10.0;
/// Without dry friction a rotor never stands; below this share of the rated speed it counts as standing.
const STILL: f64 = 1e-3;

impl Bench {
    /// A bench at `rate` steps a second, 1e3 to 1e6; the mass within ±1e6 rad of straight down.
    ///
    /// # Errors
    /// The first number beyond its limits.
    pub fn new(parameters: &Parameters, plan: Plan, rate: f64, angle: f64) -> Result<Self, Fault> {
        parameters.check()?;
        within("rate", rate, (1e3, 1e6), "steps a second")?;
        within("angle", angle, (-1e6, 1e6), "rad")?;
        Ok(Self { parameters: *parameters, plan, rate, angle })
    }

    /// What its vibration is told in.
    pub fn felt(&self) -> Felt {
        self.parameters.casing.mass().map_or(Felt::Force, |_| Felt::Acceleration)
    }

    /// What is felt for each (rad/s)² of speed: m_e r/M_t, or m_e r where nothing moves.
    pub fn per_square(&self) -> f64 {
        self.parameters.eccentric / self.parameters.casing.mass().unwrap_or(1.0)
    }

    /// What is felt at the rated speed.
    pub fn rated(&self) -> f64 {
        self.per_square() * self.parameters.rated_speed().powi(2)
    }

    /// What the motor does under a drive: at least for `least` seconds, and until it stands.
    ///
    /// # Errors
    /// None that [`Bench::new`] did not find.
    pub fn run(&self, given: &Given, least: f64) -> Result<Run, Fault> {
        let mut motor = Motor::<true>::new(&self.parameters, &self.plan, self.rate)?;
        motor.place(self.angle, 0.0);
        let begin = turned(&motor);
        let (driven, at_last) = match given {
            Given::Course(course) => (course.duration(), course.last()),
            Given::Samples(volts) => (volts.len() as f64 / self.rate, Drive::SHORT),
        };
        let rests = matches!(at_last, Drive::Open) || at_last == Drive::SHORT;
        let watched =
            if rests { PATIENCE } else { (SETTLED * self.parameters.mechanical_time()).min(PATIENCE) };
        let least = driven.max(least);
        let [least, most, stays] = [least, least + watched, STAYS].map(|s| (s * self.rate).ceil() as usize);
        let (mut traces, mut moved, mut n) = (Traces::default(), 0, 0);
        let still = STILL * self.parameters.rated_speed();
        let mut see = |motor: &Motor<true>| {
            let now = motor.reading();
            traces.volts.push(now.voltage);
            traces.reactions.push(now.reaction);
            traces.angles.push(motor.turned());
            traces.amperes.push(motor.current());
            traces.speeds.push(motor.speed());
            traces.felt.push(self.shaken(motor));
            n += 1;
            let moves =
                if self.parameters.stiction > 0.0 { !motor.is_stuck() } else { motor.speed().abs() > still };
            if moves {
                moved = n;
            }
            n >= most || (n >= least && n - moved >= stays)
        };
        match given {
            Given::Course(course) => follow(course, &mut motor, self.rate, &mut see),
            Given::Samples(volts) => {
                let all = volts.iter().copied().chain(std::iter::repeat(0.0));
                for volts in all {
                    motor.drive(Drive::Voltage(volts));
                    motor.step();
                    if see(&motor) {
                        break;
                    }
                }
            }
        }
        Ok(Run {
            rate: self.rate,
            energy: motor.energy(),
            stored: motor.stored(),
            stands: (n - moved >= stays).then(|| moved as f64 / self.rate),
            turns: (turned(&motor) - begin) / TAU,
            traces,
        })
    }

    /// Magnitude of what is felt: |a| = (m_e r/M_t) √(ω⁴ + α²), unless springs have their say.
    fn shaken(&self, motor: &Motor<true>) -> f64 {
        match self.parameters.casing {
            Casing::Suspended { .. } if self.plan.casing => {
                let [x, y] = motor.acceleration();
                x.hypot(y)
            }
            _ => {
                let square = motor.speed() * motor.speed();
                self.per_square() * square.hypot(motor.angular_acceleration())
            }
        }
    }
}

impl Run {
    /// The time of the end of a step, s.
    pub fn time(&self, step: usize) -> f64 {
        (step + 1) as f64 / self.rate
    }
}

/// Whole turns included, rad.
fn turned(motor: &Motor<true>) -> f64 {
    let reading = motor.reading();
    reading.angle + TAU * reading.turns
}

/// Drives a motor along a course until `see` has seen enough.
fn follow(course: &Course, motor: &mut Motor<true>, rate: f64, see: &mut impl FnMut(&Motor<true>) -> bool) {
    let driven = (course.duration() * rate).ceil() as usize;
    let mut enough = false;
    course.play(motor, rate, driven, |motor| enough = see(motor));
    motor.drive(course.last());
    while !enough {
        motor.step();
        enough = see(motor);
    }
}
