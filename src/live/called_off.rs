//! Patterns that were called off while events of theirs were still on their way to the engine.

#![deny(clippy::disallowed_methods)]

use crate::engine::event::Event;
use crate::schedule::Instant;

/// Calls that may be kept at once.
const KEPT: usize = 1 << 10;

/// The engine calls off what waits there; what waits before it, as there is no room, has to be held back here. Beyond 1,024 calls
/// at once, which takes as many patterns, it is played.
#[derive(Debug)]
pub struct CalledOff {
    calls: Vec<Call>,
    /// Events that were taken so far.
    taken: u64,
}

#[derive(Debug, Clone, Copy)]
struct Call {
    id: u64,
    bits: u8,
    /// From when on nothing of it is to begin.
    from: Instant,
    /// The last event that can have been sent before it, by its number.
    last: u64,
}

impl Default for CalledOff {
    fn default() -> Self {
        Self { calls: Vec::with_capacity(KEPT), taken: 0 }
    }
}

impl CalledOff {
    /// Something is called off, where so many events wait to be taken.
    pub fn call(&mut self, (id, bits): (u64, u8), from: Instant, waiting: usize) {
        if waiting > 0 && self.calls.len() < KEPT {
            self.calls.push(Call { id, bits, from, last: self.taken + waiting as u64 });
        }
    }

    /// An event is taken that is due then. Says whether it was called off.
    pub fn take(&mut self, due: Instant, event: &Event) -> bool {
        self.taken += 1;
        if self.calls.is_empty() {
            return false;
        }
        let off = self.calls.iter().any(|call| call.from <= due && event.begins_of(call.id, call.bits));
        self.calls.retain(|call| call.last > self.taken);
        off
    }
}
