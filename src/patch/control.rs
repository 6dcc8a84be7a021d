//! A live parameter: what MIDI, OSC or a program may move while a patch plays.

use crate::text::Span;

/// A control, `[control.NAME]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Control {
    /// Its name, by which nodes read it.
    pub name: String,
    /// Value at the start.
    pub default: f64,
    /// Least and most.
    pub range: [f64; 2],
    /// Its unit, shown to people; may be empty.
    pub unit: String,
    /// How a position between 0 and 1 maps to the range.
    pub curve: Curve,
    /// Time constant in seconds with which it follows what moves it.
    pub smoothing: f64,
    /// Where it stands.
    pub span: Span,
}

/// How a position from 0 to 1 maps to a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Curve {
    /// Equal steps are equal differences.
    Linear,
    /// Equal steps are equal ratios; the range lies above 0.
    Exponential,
}
