//! Worlds that a slow thread sends, as a knob takes them: kept, so that a run can be repeated, and taken again from what was kept.

use crate::knob::local_model::link::{Fast, Seen};
use crate::knob::local_model::pending::Message;
use std::collections::VecDeque;

/// What has been taken and nobody has asked for yet, at most.
const KEPT: usize = 4096;

/// A world that a knob took.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Followed {
    /// The engine sample before which it was taken.
    pub sample: u64,
    /// All that had come until then, as one.
    pub message: Message,
}

/// Where worlds come from.
#[derive(Debug, Default)]
pub(super) struct Worlds {
    link: Option<Fast>,
    taken: Vec<Followed>,
    unkept: u64,
    /// Those of a run that is repeated.
    again: VecDeque<Followed>,
}

impl Worlds {
    /// From a slow thread, which sees the knob. It allocates.
    pub fn listen(&mut self, link: Fast) {
        self.taken.reserve_exact(KEPT - self.taken.len().min(KEPT));
        self.link = Some(link);
    }

    /// One that was taken in a run that is repeated; in order. It allocates.
    pub fn follow_again(&mut self, followed: Followed) {
        self.again.push_back(followed);
    }

    /// Goes on as `old`, unless somebody listens to this one already.
    pub fn adopt(&mut self, old: &mut Self) {
        if old.link.is_some() {
            std::mem::swap(self, old);
        }
        if self.again.is_empty() {
            std::mem::swap(&mut self.again, &mut old.again);
        }
    }

    /// What there is before a sample.
    #[inline]
    pub fn take(&mut self, sample: u64) -> Option<Message> {
        if !self.again.is_empty() {
            return self.take_again(sample);
        }
        let message = self.link.as_mut().and_then(Fast::take)?;
        match self.taken.len() < self.taken.capacity() {
            true => self.taken.push(Followed { sample, message }),
            false => self.unkept += 1,
        }
        Some(message)
    }

    #[cold]
    fn take_again(&mut self, sample: u64) -> Option<Message> {
        let mut all: Option<Message> = None;
        while self.again.front().is_some_and(|next| next.sample <= sample)
            && let Some(next) = self.again.pop_front()
        {
            all = Some(all.map_or(next.message, |before| before.then(&next.message)));
        }
        all
    }

    /// Lets the slow thread see the knob.
    #[inline]
    pub fn put(&self, seen: &Seen) {
        if let Some(link) = &self.link {
            link.put(seen);
        }
    }

    /// What was taken since this was asked last.
    pub fn taken(&mut self) -> std::vec::Drain<'_, Followed> {
        self.taken.drain(..)
    }

    /// How much of what was taken since this was asked last was not kept.
    pub fn take_unkept(&mut self) -> u64 {
        std::mem::take(&mut self.unkept)
    }
}
