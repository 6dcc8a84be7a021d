//! A motor on which a course is tried before it is given.

use crate::actuator::motor::{Drive, Level, Motor, Parameters, Plan};

use super::root::root;
use super::unreachable::Unreachable;

/// Steps a second of a trial, where nothing speaks for others.
pub const RATE: f64 = 48_000.0;

/// Seconds after which a motor is taken not to get anywhere.
pub const PATIENCE: f64 = 10.0;

/// Where the mass of a motor hangs, rad from straight down, whole turns included.
pub fn angle(motor: &Motor) -> f64 {
    let reading = motor.reading();
    reading.angle + std::f64::consts::TAU * reading.turns
}

/// A motor and its time.
#[derive(Debug, Clone)]
pub struct Trial {
    /// The motor.
    pub motor: Motor,
    /// Its steps a second.
    rate: f64,
    /// Seconds since it began.
    pub time: f64,
}

impl Trial {
    /// At rest, with its mass at an angle (rad), at so many steps a second.
    pub fn new(parameters: &Parameters, angle: f64, rate: f64) -> Result<Self, Unreachable> {
        let mut plan = Plan::whole(Level::Fine);
        plan.casing = false;
        let mut motor = Motor::new(parameters, &plan, rate)?;
        motor.place(angle, 0.0);
        Ok(Self { motor, rate, time: 0.0 })
    }

    /// Radians since angle 0, whole turns included.
    pub fn angle(&self) -> f64 {
        angle(&self.motor)
    }

    /// Drives it for so many seconds.
    pub fn run(&mut self, seconds: f64, drive: Drive) {
        self.motor.drive(drive);
        let steps = (seconds * self.rate).max(0.0);
        (0..steps as usize).for_each(|_| self.motor.step());
        self.motor.part(steps.fract());
        self.time += seconds;
    }

    /// Drives it until `left`, which is above 0 now, is not any more, and gives the seconds that took; `None` where it lasts longer
    /// than `most`.
    pub fn until(&mut self, drive: Drive, most: f64, left: impl Fn(&Motor) -> f64) -> Option<f64> {
        self.motor.drive(drive);
        if left(&self.motor) <= 0.0 {
            return Some(0.0);
        }
        let begin = self.time;
        while self.time - begin <= most {
            let before = self.motor.clone();
            self.motor.step();
            if left(&self.motor) > 0.0 {
                self.time += 1.0 / self.rate;
                continue;
            }
            let at = |share: f64| {
                let mut tried = before.clone();
                tried.part(share);
                left(&tried)
            };
            let to = root((0.0, left(&before)), (1.0, left(&self.motor)), at);
            self.motor = before;
            self.motor.part(to);
            self.time += to / self.rate;
            return Some(self.time - begin);
        }
        None
    }
}
