//! Where a performer's events go.

use crate::engine::Engine;
use crate::engine::event::{Event, Source};
use crate::schedule::Instant;

/// Takes events: an engine, or a ring that leads to one.
pub trait Outlet {
    /// The next engine sample to be computed, as far as is known here.
    fn clock(&self) -> u64;

    /// How many more events of a source it takes.
    fn room(&self, source: Source) -> usize;

    /// What is sent from now on is sent because of a signal of that number; 0 for none.
    fn because(&mut self, _cause: u64) {}

    /// An event at an instant. Says whether there was room.
    fn send(&mut self, at: Instant, source: Source, event: Event) -> bool;
}

/// Room in an engine's queue that patterns leave, so that the program can always release and set something.
pub(crate) const FOR_PROGRAM: usize = 1024;

/// Room that what the program plays leaves, so that it never keeps patterns waiting.
const FOR_PATTERNS: usize = 2 * FOR_PROGRAM;

impl Outlet for Engine {
    fn clock(&self) -> u64 {
        Engine::clock(self)
    }

    fn room(&self, source: Source) -> usize {
        let left = match source {
            Source::Pattern => FOR_PROGRAM,
            Source::Stop | Source::Program | Source::Knob => FOR_PATTERNS,
        };
        Engine::room(self).saturating_sub(left)
    }

    fn send(&mut self, at: Instant, source: Source, event: Event) -> bool {
        self.schedule(at, source, event)
    }
}
