//! Error against run time of a simulated knob: the plant, other integrators, other models of friction.
//!
//! | file | holds |
//! |---|---|
//! | [`problem`] | what is computed, and its truth |
//! | [`method`] | what steps it |
//!
//! Rows come out, which [`cost`](crate::report::cost) writes as text, comma-separated values and SVG. Bristles are another model, not another
//! method: what they give before they slip counts as their error against set-valued friction.
//!
//! ```
//! use pacinian::report::knob::race::{Wish, listed, race};
//!
//! let wish = Wish { problems: listed()[..1].to_vec(), rates: vec![4_000.0] };
//! let rows = race(&wish, &mut |_| ())?;
//! let of = |name: &str| rows.iter().find(|row| row.method == name).expect("one that runs");
//! assert!(of("exact, events").error < 1e-12 && of("Euler").error > 1e-5);
//! # Ok::<(), pacinian::actuator::fault::Fault>(())
//! ```

pub mod method;
pub mod problem;
#[cfg(test)]
mod tests;

use std::hint::black_box;

use crate::actuator::fault::{Fault, within};
use crate::report::cost::clock::nanoseconds;
use crate::report::cost::{Across, Outcome, Row};
use method::{Contender, Steps};
pub use problem::{Problem, listed};

/// The rates that errors are told at, Hz.
pub const RATES: [f64; 6] = [1e3, 4e3, 8e3, 16e3, 48e3, 192e3];

/// What errs by more than so many times the largest speed makes energy, or is no number.
const AWAY: f64 = 2.0;

/// What is raced.
#[derive(Debug, Clone, PartialEq)]
pub struct Wish {
    /// On these problems.
    pub problems: Vec<Problem>,
    /// At these rates, 100 to 1e6 steps a second.
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
        within("rate", *rate, (100.0, 1e6), "steps a second")?;
    }
    let mut rows = Vec::new();
    for problem in &wish.problems {
        let courses: Vec<Course> = wish.rates.iter().map(|rate| Course::new(problem, *rate)).collect();
        for contender in Contender::of(problem) {
            for course in &courses {
                let row = course.row(contender);
                progress(&row);
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

/// The picture of rows as SVG.
pub fn picture(rows: &[Row], across: Across) -> String {
    let of =
        "Errors: of the speed, as a share of the largest speed. LuGre and Dahl are other models of friction.";
    crate::report::cost::picture(rows, across, of)
}

/// A problem at a rate, and its truth.
#[derive(Debug, Clone)]
pub struct Course {
    problem: Problem,
    rate: f64,
    torques: Vec<f64>,
    truth: Vec<(f64, f64)>,
    /// The largest speed, rad/s.
    scale: f64,
}

impl Course {
    /// Computes the truth.
    pub fn new(problem: &Problem, rate: f64) -> Self {
        let truth = problem.truth(rate);
        let scale = truth.iter().fold(problem.start.1.abs(), |most, (_, speed)| most.max(speed.abs()));
        Self { problem: problem.clone(), rate, torques: problem.torques(rate), truth, scale }
    }

    /// Largest error of the speed as a share of the largest speed, and of the angle, rad.
    pub fn errors(&self, knob: &mut dyn Steps) -> (f64, f64) {
        knob.place(self.problem.start.0, self.problem.start.1);
        let (mut most, mut place) = (0.0f64, 0.0f64);
        for (torque, truth) in self.torques.iter().zip(&self.truth) {
            knob.step(*torque);
            let (angle, speed) = knob.state();
            let (error, off) = ((speed - truth.1).abs(), (angle - truth.0).abs());
            // Once it is no number it stays none, which a maximum would lose.
            most = if error <= most || most.is_nan() { most } else { error };
            place = if off <= place || place.is_nan() { place } else { off };
        }
        (most / self.scale, place)
    }

    /// What comes of a method.
    pub fn row(&self, contender: Contender) -> Row {
        let measured = contender.made(&self.problem, self.rate, &mut |knob| {
            let (error, angle) = self.errors(knob);
            // A comparison that what is no number fails.
            (error <= AWAY).then(|| (error, angle, self.time(knob)))
        });
        let (error, angle, ns, outcome) = match measured {
            Ok(Some((error, angle, ns))) => (error, angle, Some(ns), Outcome::Held),
            Ok(None) => (f64::NAN, f64::NAN, None, Outcome::Diverged),
            Err(_) => (f64::NAN, f64::NAN, None, Outcome::Refused),
        };
        Row {
            model: "knob",
            problem: self.problem.name,
            about: self.problem.about,
            method: contender.name(),
            own: contender.is_own(),
            rate: self.rate,
            of: "error of the speed, share of the largest speed",
            error,
            angle: Some(angle),
            ns,
            outcome,
        }
    }

    fn time(&self, knob: &mut dyn Steps) -> f64 {
        nanoseconds(self.torques.len(), || {
            knob.run(self.problem.start, black_box(&self.torques));
            black_box(knob.state());
        })
    }
}
