//! Messages on their way to the servo: bounded, in order, and coalesced when there is no room.
//!
//! A model makes the one before it obsolete, an impulse does not: so when the queue is full its last message takes the new model and the sum
//! of both impulses. What arrives is then what would have arrived, less models that were never felt; how many is counted.

use super::model::LocalModel;

/// What the slow thread says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Message {
    /// The world from now on.
    pub model: LocalModel,
    /// A kick besides, N m s.
    pub impulse: f64,
    /// How many messages this one stands for.
    pub stands_for: u32,
}

impl Message {
    /// A message of its own.
    pub fn new(model: LocalModel, impulse: f64) -> Self {
        Self { model, impulse, stands_for: 1 }
    }

    /// This one and a later one as one.
    #[must_use]
    pub fn then(self, later: &Self) -> Self {
        Self {
            model: later.model,
            impulse: self.impulse + later.impulse,
            stands_for: self.stands_for.saturating_add(later.stands_for),
        }
    }
}

/// At most `N` messages, 1 or more.
#[derive(Debug, Clone, PartialEq)]
pub struct Pending<const N: usize> {
    ring: [Option<Message>; N],
    first: usize,
    length: usize,
    coalesced: u64,
}

impl<const N: usize> Default for Pending<N> {
    fn default() -> Self {
        const { assert!(N > 0) };
        Self { ring: [None; N], first: 0, length: 0, coalesced: 0 }
    }
}

impl<const N: usize> Pending<N> {
    /// Adds a message, or joins it to the last. Returns whether it was joined.
    pub fn push(&mut self, message: Message) -> bool {
        let full = self.length == N;
        let at = (self.first + self.length - usize::from(full)) % N;
        self.ring[at] = match &self.ring[at] {
            Some(last) if full => Some(last.then(&message)),
            _ => Some(message),
        };
        self.length += usize::from(!full);
        self.coalesced += u64::from(full);
        full
    }

    /// The oldest message.
    pub fn pop(&mut self) -> Option<Message> {
        let message = self.ring[self.first].take()?;
        self.first = (self.first + 1) % N;
        self.length -= 1;
        Some(message)
    }

    /// All messages as one: what the servo takes at a tick.
    pub fn drain(&mut self) -> Option<Message> {
        let mut all = self.pop()?;
        while let Some(next) = self.pop() {
            all = all.then(&next);
        }
        Some(all)
    }

    /// Messages waiting.
    pub fn len(&self) -> usize {
        self.length
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// Messages that were joined to another because there was no room, ever.
    pub fn coalesced(&self) -> u64 {
        self.coalesced
    }
}
