//! What is played in decibels above the threshold: where, what each channel needs for it, and where that cannot be had.

mod check;
mod gauges;
mod judge;
mod uses;

pub(super) use check::check;
pub(crate) use check::unfelt;
pub(super) use gauges::gauges;
pub use judge::{Judge, Verdict};
pub use uses::{Use, is_felt, uses};
