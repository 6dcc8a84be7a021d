//! Error against run time as rows: what came of a method on a problem at a rate.
//!
//! | file | holds |
//! |---|---|
//! | [`row`] | a row |
//! | [`clock`] | CPU time of a step |
//! | [`table`], [`mod@picture`] | rows as text, comma-separated values, and SVG |
//!
//! [`actuators`](crate::report::actuators) and [`knob`](crate::report::knob) fill them.

pub mod clock;
pub mod picture;
pub mod row;
pub mod table;

pub use picture::{Across, picture};
pub use row::{Outcome, Row};
pub use table::{csv, text};
