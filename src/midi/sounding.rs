//! The notes that sound.

use super::channel::Channel;
use super::gesture::Expression;

/// Most notes that sound at a time, on all channels of a cable. One more ends the oldest.
pub const MOST: usize = 256;

/// One sounding of a note.
#[derive(Debug, Clone, Copy)]
pub(super) struct Note {
    pub key: u32,
    pub channel: Channel,
    pub note: u8,
    /// How fast its key went up, where a pedal holds it since; `None` while the key is down.
    pub released: Option<f64>,
    /// Whether its key was down when the sostenuto pedal went down.
    pub caught: bool,
    pub poly_pressure: u8,
    /// As it was said last.
    pub said: Expression,
}

/// All of them, the oldest first. Their room is there from the beginning.
#[derive(Debug)]
pub(super) struct Sounding {
    notes: Vec<Note>,
    next: u32,
}

impl Sounding {
    pub fn new() -> Self {
        Self { notes: Vec::with_capacity(MOST), next: 0 }
    }

    /// Where one more begins, with the key it got and the note that had to end for it.
    pub fn begin(&mut self, channel: Channel, note: u8, said: Expression) -> (u32, Option<Note>) {
        let ended = if self.notes.len() >= MOST { Some(self.notes.remove(0)) } else { None };
        // After four thousand million notes the keys begin anew; one that still sounds keeps its own.
        while self.notes.iter().any(|n| n.key == self.next) {
            self.next = self.next.wrapping_add(1);
        }
        let key = self.next;
        self.next = self.next.wrapping_add(1);
        self.notes.push(Note { key, channel, note, released: None, caught: false, poly_pressure: 0, said });
        (key, ended)
    }

    /// The oldest of a note whose key is down.
    pub fn down(&mut self, channel: Channel, note: u8) -> Option<&mut Note> {
        self.iter_mut().find(|n| (n.channel, n.note) == (channel, note) && n.released.is_none())
    }

    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut Note> {
        self.notes.iter_mut()
    }

    /// Ends those that `ends` says, the oldest first.
    pub fn end(&mut self, mut ends: impl FnMut(&Note) -> bool) {
        self.notes.retain(|note| !ends(note));
    }

    pub fn count(&self) -> usize {
        self.notes.len()
    }
}

#[cfg(test)]
mod tests {
    use super::{Channel, Expression, MOST, Sounding};

    #[test]
    fn keys_are_unique_even_after_they_begin_anew() {
        let mut sounding = Sounding::new();
        let (first, _) = sounding.begin(Channel::FIRST, 1, Expression::REST);
        sounding.next = u32::MAX;
        let more: Vec<u32> = (0..3).map(|_| sounding.begin(Channel::FIRST, 1, Expression::REST).0).collect();
        assert_eq!((first, more), (0, vec![u32::MAX, 1, 2]));
    }

    #[test]
    fn the_oldest_makes_room_without_new_memory() {
        let mut sounding = Sounding::new();
        let room = sounding.notes.capacity();
        for i in 0..2 * MOST {
            let (key, ended) = sounding.begin(Channel::FIRST, 1, Expression::REST);
            assert_eq!(key as usize, i);
            assert_eq!(ended.map(|n| n.key as usize), i.checked_sub(MOST));
        }
        assert_eq!((sounding.count(), sounding.notes.capacity()), (MOST, room));
    }
}
