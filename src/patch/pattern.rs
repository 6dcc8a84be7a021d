//! A pattern: events in time.

use super::event::{Event, Repeat};
use crate::text::Span;

/// A pattern, `[pattern.NAME]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// Its name.
    pub name: String,
    /// In what its times are counted.
    pub time: TimeBase,
    /// What it plays.
    pub events: Events,
    /// The whole pattern again and again.
    pub repeat: Option<Repeat>,
    /// Multiplies the level of all it plays.
    pub gain: f64,
    /// 2 is twice as fast, durations included.
    pub rate: f64,
    /// Whether the events change places: each time the pattern plays, its onsets stay and what lands on them is permuted.
    pub shuffle: bool,
    /// Random deviations, drawn for each event each time.
    pub jitter: Option<Jitter>,
    /// Where it stands.
    pub span: Span,
}

/// In what a pattern counts time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeBase {
    /// Seconds.
    Seconds,
    /// Beats, at so many a minute.
    Beats(f64),
}

impl TimeBase {
    /// Seconds in one unit of it.
    pub fn seconds(self) -> f64 {
        match self {
            Self::Seconds => 1.0,
            Self::Beats(tempo) => 60.0 / tempo,
        }
    }
}

/// Where a pattern's events stand.
#[derive(Debug, Clone, PartialEq)]
pub enum Events {
    /// In the patch.
    Inline(Vec<Event>),
    /// In a file beside it; read it with [`super::events_file::EventsFile`].
    File(String, Span),
}

/// Random deviations.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Jitter {
    /// Onsets move by up to so much to either side, in the pattern's time, evenly distributed; never before its start.
    pub at: f64,
    /// A field (`level`, `duration` or a voice's own) is multiplied by 1 + u × fraction, u evenly distributed from −1 to 1.
    pub fractions: Vec<(String, f64)>,
}
