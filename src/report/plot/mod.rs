//! Pictures as SVG: what every tactor did, the spectrum, small charts, and curves over time.
//!
//! A picture is text of a few hundred kilobytes, the same for the same input, with real text in it and, where the reader prefers
//! it, light on dark.

pub(in crate::report) mod axis;
mod chart;
mod collector;
pub(in crate::report) mod colour;
mod extremes;
mod map;
mod panel;
pub(in crate::report) mod panels;
mod path;
mod picture;
pub mod sheet;
mod spectrum;
mod strips;
mod svg;
mod wave;

pub use chart::{Axis, Chart, Point, Series};
pub use collector::{Collector, ROWS};
pub use map::{Map, Site};
pub use picture::Style;
pub use strips::{Column, Curve, Panel, Strips};
