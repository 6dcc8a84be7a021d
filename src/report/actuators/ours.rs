//! The project's own models as methods.

use super::equation::State;
use super::method::Method;
use super::problem::{Problem, Subject};
use crate::actuator::coil::large::Large;
use crate::actuator::coil::model::{self, Model};
use crate::actuator::drive;
use crate::actuator::fault::{Fault, Limit};
use crate::actuator::motor::{Drive, Level, Motor, Plan};

/// The rumble motor, all its parts.
#[derive(Debug, Clone)]
pub struct Rumble {
    motor: Motor,
}

impl Rumble {
    /// Of a problem, at a level, `rate` samples a second.
    ///
    /// # Errors
    /// A parameter or rate that cannot be; a problem without a motor.
    pub fn new(problem: &Problem, level: Level, rate: f64) -> Result<Self, Fault> {
        let Subject::Motor(parameters) = &problem.subject else { return Err(other("motor")) };
        Ok(Self { motor: Motor::new(parameters, &Plan::whole(level), rate)? })
    }
}

impl Method for Rumble {
    fn restart(&mut self) {
        self.motor.drive(Drive::SHORT);
        self.motor.place(0.0, 0.0);
    }

    fn step(&mut self, drive: f64) {
        self.motor.drive(Drive::Voltage(drive));
        self.motor.step();
    }

    fn state(&self) -> State {
        let now = self.motor.reading();
        [now.current, now.speed, now.angle + std::f64::consts::TAU * now.turns]
    }

    fn run(&mut self, drives: &[f64]) {
        self.motor.run(drives, |_, _, _| ());
    }
}

/// The linear model of a coil.
#[derive(Debug, Clone)]
pub struct Exact {
    model: Model,
}

impl Exact {
    /// Of a problem, `rate` samples a second.
    ///
    /// # Errors
    /// A parameter or rate that cannot be; a problem without a coil.
    pub fn new(problem: &Problem, rate: f64) -> Result<Self, Fault> {
        let Some((plant, bounds)) = problem.plant()? else { return Err(other("coil")) };
        Ok(Self { model: Model::bounded(&plant, rate, drive::Drive::Voltage, &bounds)? })
    }
}

impl Method for Exact {
    fn restart(&mut self) {
        self.model.set_state(&model::State::default());
    }

    fn step(&mut self, drive: f64) {
        self.model.advance(drive);
    }

    fn state(&self) -> State {
        seen(&self.model)
    }

    fn run(&mut self, drives: &[f64]) {
        self.model.run(drives, |_| ());
    }
}

/// The model of a coil in large motion, so many steps a sample.
#[derive(Debug, Clone)]
pub struct Split {
    large: Large,
    steps: u8,
}

impl Split {
    /// Of a problem, `rate` samples a second, each in `steps` steps.
    ///
    /// # Errors
    /// A parameter or rate that cannot be; a problem without large motion.
    pub fn new(problem: &Problem, steps: u8, rate: f64) -> Result<Self, Fault> {
        let (Some((plant, bounds)), Subject::Large(_, _, shape)) = (problem.plant()?, &problem.subject)
        else {
            return Err(other("large motion"));
        };
        let rate = rate * f64::from(steps);
        Ok(Self { large: Large::new(&plant, rate, drive::Drive::Voltage, &bounds, shape)?, steps })
    }
}

impl Method for Split {
    fn restart(&mut self) {
        self.large.set_state(&model::State::default());
    }

    fn step(&mut self, drive: f64) {
        for _ in 0..self.steps {
            self.large.step(drive);
        }
    }

    fn state(&self) -> State {
        seen(self.large.model())
    }
}

fn seen(model: &Model) -> State {
    let now = model.state();
    [now.current, now.velocity, now.displacement]
}

/// A method on a problem that is not its own.
fn other(wants: &'static str) -> Fault {
    Fault { field: "problem", value: f64::NAN, limit: Limit::Absent, because: Some(wants) }
}
