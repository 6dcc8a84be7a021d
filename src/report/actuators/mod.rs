//! Error against run time for the models of actuators, beside the methods that one would write first.
//!
//! | file | holds |
//! |---|---|
//! | [`problem`], [`equation`] | what is computed: parts, drive and first state; their differential equations, plainly |
//! | [`truth`] | what it comes to: Taylor series with events, no line in common with the models |
//! | [`method`], [`ours`] | what a method is and which there are; the models of [`crate::actuator`] as such |
//! | [`euler`], [`semi_implicit`], [`rk4`], [`trapezoidal`] | the plain methods |
//! | [`mod@race`] | all of them on all problems at all rates: rows, which [`cost`](super::cost) writes and draws |
//!
//! A method is given one drive a sample, held over it, and is asked for current, speed and place at the end of each. So the error is the
//! method's alone: the truth has the same held drive.
//!
//! ```
//! use pacinian::report::actuators::{Wish, listed, race};
//!
//! let wish = Wish { problems: listed()[..1].to_vec(), rates: vec![16_000.0], ..Wish::default() };
//! let rows = race(&wish, &mut |_| ())?;
//! let of = |name: &str| rows.iter().find(|row| row.method == name).expect("one that runs");
//! assert!(of("default").error < 1e-11 && of("Euler").diverged());
//! # Ok::<(), pacinian::actuator::fault::Fault>(())
//! ```

pub mod equation;
pub mod euler;
pub mod method;
pub mod ours;
pub mod problem;
pub mod race;
pub mod rk4;
pub mod semi_implicit;
mod series;
pub mod trapezoidal;
pub mod truth;

pub use super::cost::{Across, Outcome, Row, csv, text};
pub use method::Method;
pub use problem::{Problem, listed};
pub use race::{Course, Wish, race};

/// The picture of error against run time as SVG.
pub fn picture(rows: &[Row], across: Across) -> String {
    let of = "Errors: of a motor's speed as a share of the rated speed, of a coil's displacement as a share of its peak.\n\
              Methods that know smooth equations alone (Euler, RK4, solvers of a crate) get dry friction smoothed, which is an error of its own.";
    super::cost::picture(rows, across, of)
}
