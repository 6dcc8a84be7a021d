//! What starts voices and patterns from outside.

use super::expr::Expr;
use super::place::Place;
use crate::text::Span;

/// A trigger, `[[trigger]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Trigger {
    /// What sets it off.
    pub on: Source,
    /// The voice or pattern it plays.
    pub play: String,
    /// Fields of the event it makes, computed from what set it off.
    pub set: Vec<(String, Expr)>,
    /// Where; `None`: the voice's place.
    pub place: Option<Place>,
    /// Where it stands.
    pub span: Span,
}

/// What sets off a trigger.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// The beginning.
    Start,
    /// A key of the computer, from 1.
    Key(u32),
    /// A note begins.
    MidiNote,
    /// An OSC message to this address.
    Osc(String),
    /// The knob passes a detent.
    KnobDetent,
    /// A shared node passes a threshold.
    Node {
        /// The shared node.
        node: String,
        /// Upwards; else downwards.
        rises: bool,
        /// The threshold.
        threshold: f64,
    },
}
