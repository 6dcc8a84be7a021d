//! What became of voices that no event of theirs tells: those that always sound, as they begin, and those that had to make room for others.

use super::event::Play;
use crate::schedule::Instant;

/// So much is kept until somebody asks, beside the voices that always sound.
const KEPT: usize = 1024;

/// What became of a voice, and when.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Turn {
    /// When it did.
    pub at: Instant,
    /// What did.
    pub what: Turned,
}

/// What became of a voice.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Turned {
    /// It always sounds, and began.
    Began(Play),
    /// The voice of that id fades, since another began: the id of that.
    Stolen(u64, u64),
}

/// What has become of voices since somebody asked last.
#[derive(Debug)]
pub struct Turnover {
    kept: Vec<Turn>,
}

impl Turnover {
    /// Of an engine in which so many voices sound always.
    pub fn new(always: usize) -> Self {
        Self { kept: Vec::with_capacity(KEPT + always) }
    }

    /// Keeps what became of a voice; what finds no room is counted elsewhere, as are all that are stolen.
    pub fn note(&mut self, at: Instant, what: Turned) {
        if self.kept.len() < self.kept.capacity() {
            self.kept.push(Turn { at, what });
        }
    }

    /// What is kept began at `now`, as far as `begins` says so of its instrument.
    pub fn begin_at(&mut self, now: Instant, begins: impl Fn(u32) -> bool) {
        self.kept.retain(|turn| matches!(&turn.what, Turned::Began(play) if begins(play.instrument)));
        self.kept.iter_mut().for_each(|turn| turn.at = now);
    }

    /// All of it, in its order.
    pub fn take(&mut self) -> std::vec::Drain<'_, Turn> {
        self.kept.drain(..)
    }
}
