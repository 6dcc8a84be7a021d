//! What a method is, and which there are.

use super::equation::{LARGE, LINEAR, MOTOR, State};
use super::euler::Euler;
use super::ours::{Exact, Rumble, Split};
use super::problem::{Problem, Subject};
use super::race::{Course, Measured};
use super::rk4::Rk4;
use super::semi_implicit::SemiImplicit;
use super::trapezoidal::Trapezoidal;
use crate::actuator::fault::Fault;
use crate::actuator::motor::Level;

/// Something that computes a problem sample by sample. It is made for one rate.
pub trait Method {
    /// Goes back to the beginning.
    fn restart(&mut self);

    /// Holds a drive, volts, for a sample.
    fn step(&mut self, drive: f64);

    /// Where it is.
    fn state(&self) -> State;

    /// As many samples as there are drives: what is timed.
    #[inline]
    fn run(&mut self, drives: &[f64]) {
        for drive in drives {
            self.step(*drive);
        }
    }

    /// The same, and what it comes to at the end of each.
    fn trace(&mut self, drives: &[f64], see: &mut dyn FnMut(State)) {
        for drive in drives {
            self.step(*drive);
            see(self.state());
        }
    }
}

/// A method that can be raced.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contender {
    /// The rumble motor at a level.
    Motor(Level),
    /// The linear coil model.
    Exact,
    /// The coil model in large motion, each sample in so many steps.
    Split(u8),
    /// Forward Euler, friction smoothed.
    Euler,
    /// Semi-implicit Euler, friction clamped.
    SemiImplicit,
    /// The classical Runge-Kutta method, friction smoothed.
    Rk4,
    /// The trapezoidal rule, friction clamped.
    Trapezoidal,
}

impl Contender {
    /// Those for a problem: first the project's own, from fine to economy.
    pub fn of(problem: &Problem) -> Vec<Self> {
        let own: &[Self] = match problem.subject {
            Subject::Motor(_) => {
                &[Self::Motor(Level::Fine), Self::Motor(Level::Default), Self::Motor(Level::Economy)]
            }
            Subject::Tactor(_) | Subject::Inertial(_) => &[Self::Exact],
            Subject::Large(..) => &[Self::Split(16), Self::Split(4), Self::Split(1)],
        };
        let plain = [Self::Euler, Self::SemiImplicit, Self::Rk4, Self::Trapezoidal];
        [own, &plain].concat()
    }

    /// What tables and pictures call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Motor(Level::Fine) => "fine",
            Self::Motor(Level::Default) => "default",
            Self::Motor(Level::Economy) => "economy",
            Self::Exact => "exact",
            Self::Split(1) => "split",
            Self::Split(4) => "split, 4 steps",
            Self::Split(16) => "split, 16 steps",
            Self::Split(_) => "split, more steps",
            Self::Euler => "Euler",
            Self::SemiImplicit => "semi-implicit",
            Self::Rk4 => "RK4",
            Self::Trapezoidal => "trapezoidal",
        }
    }

    /// Whether it is the project's own.
    pub fn is_own(self) -> bool {
        matches!(self, Self::Motor(_) | Self::Exact | Self::Split(_))
    }

    /// Runs a course.
    ///
    /// # Errors
    /// What keeps the method from it: parameters or a rate beyond its limits.
    pub fn run(self, course: &Course) -> Result<Measured, Fault> {
        let (problem, rate) = (&course.problem, course.rate);
        let (equation, period) = (problem.equation(), 1.0 / rate);
        macro_rules! plain {
            ($method:ident) => {
                match equation.kind() {
                    MOTOR => course.measure(&mut $method::<MOTOR>::new(&equation, period)),
                    LARGE => course.measure(&mut $method::<LARGE>::new(&equation, period)),
                    _ => course.measure(&mut $method::<LINEAR>::new(&equation, period)),
                }
            };
        }
        Ok(match self {
            Self::Motor(level) => course.measure(&mut Rumble::new(problem, level, rate)?),
            Self::Exact => course.measure(&mut Exact::new(problem, rate)?),
            Self::Split(steps) => course.measure(&mut Split::new(problem, steps, rate)?),
            Self::Euler => plain!(Euler),
            Self::SemiImplicit => plain!(SemiImplicit),
            Self::Rk4 => plain!(Rk4),
            Self::Trapezoidal => plain!(Trapezoidal),
        })
    }
}
