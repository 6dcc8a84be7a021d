//! An event: something that happens once, at a time, in a pattern.

use super::place::Place;
use crate::text::Span;

/// An event.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// When, in the pattern's time.
    pub at: f64,
    /// Added to `at`; apart from it so that a shuffle moves `at` alone.
    pub delay: f64,
    /// Played several times.
    pub repeat: Option<Repeat>,
    /// What happens.
    pub action: Action,
    /// Where it stands; in an events file, the line's bytes.
    pub span: Span,
}

/// Several times at equal spacing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repeat {
    /// From one onset to the next, in the pattern's time; above 0.
    pub every: f64,
    /// How often in all, at least 1; `None`: for ever, which only a pattern may say that no other plays.
    pub times: Option<u64>,
}

/// What happens in an event.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// A voice sounds.
    Voice(Play),
    /// Another pattern plays.
    Pattern {
        /// Its name.
        pattern: String,
        /// Multiplies the level of all it plays.
        gain: f64,
        /// 2 is twice as fast, durations included.
        rate: f64,
    },
    /// A name goes into the log, and a pulse to trigger outputs.
    Marker(String),
    /// One of several, drawn anew each time.
    Choose(Vec<Alternative>),
}

/// A voice sounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Play {
    /// Name of the voice.
    pub voice: String,
    /// Share of the rated vibration; `None`: the voice's default.
    pub level: Option<f64>,
    /// From onset to release, in the pattern's time; `None`: the voice's default.
    pub duration: Option<f64>,
    /// Where; `None`: the voice's place.
    pub place: Option<Place>,
    /// Fields that the voice declares, where the event gives them.
    pub fields: Vec<(String, f64)>,
}

/// One of several things that may happen.
#[derive(Debug, Clone, PartialEq)]
pub struct Alternative {
    /// It is drawn with probability weight / sum of the weights.
    pub weight: f64,
    /// What happens; never another choice.
    pub action: Action,
}
