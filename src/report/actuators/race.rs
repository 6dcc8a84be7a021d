//! All methods on all problems at all rates.

use std::hint::black_box;

use super::equation::State;
use super::method::{Contender, Method};
use super::problem::{Problem, Subject, listed};
use super::truth::truth;
use crate::actuator::fault::{Fault, within};
use crate::report::cost::clock::nanoseconds;
use crate::report::cost::{Outcome, Row};

/// The rates that errors are told at, Hz.
pub const RATES: [f64; 6] = [1e3, 4e3, 8e3, 16e3, 48e3, 192e3];

/// What has gone beyond so many times its scale has run away.
const AWAY: f64 = 10.0;

/// What is raced.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// On these problems.
    pub problems: Vec<Problem>,
    /// At these rates, 100 to 1e6 samples a second.
    pub rates: Vec<f64>,
}

impl Default for Wish {
    /// All that are listed, at all [`RATES`]: some seconds.
    fn default() -> Self {
        Self { problems: listed(), rates: RATES.to_vec() }
    }
}

impl Wish {
    /// How many rows it comes to.
    pub fn rows(&self) -> usize {
        self.rates.len() * self.problems.iter().map(|problem| Contender::of(problem).len()).sum::<usize>()
    }
}

/// Races all, by problem, method and rate; `progress` is shown each row when it is there.
///
/// # Errors
/// A rate beyond its limits.
pub fn race(wish: &Wish, progress: &mut dyn FnMut(&Row)) -> Result<Vec<Row>, Fault> {
    for rate in &wish.rates {
        within("rate", *rate, (100.0, 1e6), "samples a second")?;
    }
    let mut rows = Vec::new();
    for problem in &wish.problems {
        let courses: Vec<Course> = wish.rates.iter().map(|rate| Course::new(problem, *rate)).collect();
        for contender in Contender::of(problem) {
            for course in &courses {
                let row = course.row(contender.name(), contender.is_own(), contender.run(course));
                progress(&row);
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

/// A problem at a rate, and its truth.
#[derive(Debug, Clone)]
pub struct Course {
    /// The problem.
    pub problem: Problem,
    /// Samples a second.
    pub rate: f64,
    /// What is held over each.
    pub drives: Vec<f64>,
    /// What it comes to at the end of each.
    pub truth: Vec<State>,
    /// What errors are shares of: rated speed or peak displacement.
    pub scale: f64,
}

/// What was measured of a method on a course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// As in [`Row`]; not finite or beyond 10 where it ran away.
    pub error: f64,
    /// Largest error of the angle or displacement, rad or m.
    pub place: f64,
    /// CPU nanoseconds a step; `None` where it ran away.
    pub ns: Option<f64>,
}

impl Course {
    /// Computes the truth.
    pub fn new(problem: &Problem, rate: f64) -> Self {
        let truth = truth(problem, rate);
        let scale = match problem.subject {
            Subject::Motor(p) => p.rated_speed(),
            _ => truth.iter().fold(0.0, |most: f64, x| most.max(x[2].abs())),
        };
        Self { problem: problem.clone(), rate, drives: problem.drives(rate), truth, scale }
    }

    /// Errors, and CPU time unless it ran away.
    pub fn measure<M: Method>(&self, method: &mut M) -> Measured {
        let (error, place) = self.errors(method);
        // A comparison that what is no number fails.
        let held = error <= AWAY;
        Measured { error, place, ns: held.then(|| self.time(method)) }
    }

    /// Largest error as a share of the scale, and of the place.
    pub fn errors<M: Method>(&self, method: &mut M) -> (f64, f64) {
        let (mut most, mut place) = (0.0f64, 0.0f64);
        let (mut truth, mut seen) = (self.truth.iter(), 0);
        method.restart();
        method.trace(&self.drives, &mut |x| {
            let Some(is) = truth.next() else { return };
            seen += 1;
            let [_, speed, at] = [0, 1, 2].map(|n| (x[n] - is[n]).abs());
            let error = if self.problem.spins() { speed } else { at };
            // Once it is no number it stays none, which a maximum would lose.
            most = if error <= most || most.is_nan() { most } else { error };
            place = if at <= place || place.is_nan() { place } else { at };
        });
        if seen < self.truth.len() { (f64::NAN, f64::NAN) } else { (most / self.scale, place) }
    }

    /// CPU nanoseconds a step, the least of several runs.
    pub fn time<M: Method>(&self, method: &mut M) -> f64 {
        nanoseconds(self.drives.len(), || {
            method.restart();
            method.run(black_box(&self.drives));
            black_box(method.state());
        })
    }

    /// A row of what was measured.
    pub fn row(&self, method: &'static str, own: bool, measured: Result<Measured, Fault>) -> Row {
        let (error, place, ns, outcome) = match measured {
            Ok(Measured { error, place, ns: Some(ns) }) => (error, place, Some(ns), Outcome::Held),
            Ok(_) => (f64::NAN, f64::NAN, None, Outcome::Diverged),
            Err(_) => (f64::NAN, f64::NAN, None, Outcome::Refused),
        };
        Row {
            model: self.problem.model,
            problem: self.problem.name,
            about: self.problem.about,
            method,
            own,
            rate: self.rate,
            of: match self.problem.spins() {
                true => "error of the speed, share of the rated speed",
                false => "error of the displacement, share of its peak",
            },
            error,
            angle: self.problem.spins().then_some(place),
            ns,
            outcome,
        }
    }
}

#[cfg(test)]
mod tests;
