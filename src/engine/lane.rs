//! A voice on its lane.

use super::event::Play;
use crate::schedule::Instant;

/// Who is on a lane, and since when.
#[derive(Debug, Clone, Copy, Default)]
pub struct Lane {
    /// The event.
    pub play: Play,
    /// Its onset.
    pub born: Instant,
    /// Its order among all voices.
    pub serial: u64,
    /// How loud it may be: the event's level times what folding made gain.
    pub level: f64,
    /// Engine samples it has been silent since its envelopes ended.
    pub quiet: u64,
    /// What it is doing.
    pub status: Status,
}

/// What a lane is doing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Status {
    /// Nothing; it may be taken.
    #[default]
    Free,
    /// It sounds and was not released.
    Held,
    /// It was released.
    Released,
    /// It falls silent from this instant on.
    Fading(Instant),
}
