//! What waits for its time. The session itself is told only shortly before, so that nothing far ahead fills the engine's queue, and what
//! the controls show is what they are.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use crate::live::stamp::Stamp;

/// So much may wait.
pub const MOST: usize = 4096;

/// What waits for its time.
#[derive(Debug)]
pub struct Agenda<T> {
    heap: BinaryHeap<Entry<T>>,
    serial: u64,
}

#[derive(Debug)]
struct Entry<T> {
    at: Stamp,
    serial: u64,
    what: T,
}

impl<T> Default for Agenda<T> {
    fn default() -> Self {
        Self { heap: BinaryHeap::new(), serial: 0 }
    }
}

impl<T> Agenda<T> {
    /// Puts something down. Says whether there was room.
    pub fn add(&mut self, at: Stamp, what: T) -> bool {
        let room = self.heap.len() < MOST;
        if room {
            self.serial += 1;
            self.heap.push(Entry { at, serial: self.serial, what });
        }
        room
    }

    /// When the first is due.
    pub fn next(&self) -> Option<Stamp> {
        self.heap.peek().map(|entry| entry.at)
    }

    /// The first, if it is due by `until`; of those at the same time, that which was put down first.
    pub fn take(&mut self, until: Stamp) -> Option<(Stamp, T)> {
        self.next().filter(|at| *at <= until)?;
        self.heap.pop().map(|entry| (entry.at, entry.what))
    }

    /// Keeps what `keeps` says yes to, which may change it. Gives what does not stay, in its order.
    pub fn retain(&mut self, mut keeps: impl FnMut(&mut T) -> bool) -> Vec<T> {
        let mut forgotten = Vec::new();
        let (mut stay, mut all) = (Vec::new(), std::mem::take(&mut self.heap));
        while let Some(mut entry) = all.pop() {
            if keeps(&mut entry.what) {
                stay.push(entry);
            } else {
                forgotten.push(entry.what);
            }
        }
        self.heap = stay.into();
        forgotten
    }
}

impl<T> Ord for Entry<T> {
    /// The heap has its largest on top; that is the earliest here.
    fn cmp(&self, other: &Self) -> Ordering {
        (other.at, other.serial).cmp(&(self.at, self.serial))
    }
}

impl<T> PartialOrd for Entry<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl<T> PartialEq for Entry<T> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl<T> Eq for Entry<T> {}

#[cfg(test)]
mod tests {
    use super::{Agenda, MOST};
    use crate::live::stamp::Stamp;

    #[test]
    fn by_time_then_as_put_down() {
        let mut agenda = Agenda::default();
        for (number, at) in [5, 3, 5, 9, 3, 1].into_iter().enumerate() {
            assert!(agenda.add(Stamp(at), number));
        }
        assert_eq!(agenda.next(), Some(Stamp(1)));
        let mut taken = Vec::new();
        while let Some((at, number)) = agenda.take(Stamp(5)) {
            taken.push((at.0, number));
        }
        assert_eq!(taken, [(1, 5), (3, 1), (3, 4), (5, 0), (5, 2)]);
        assert_eq!((agenda.retain(|_| false), agenda.next()), (vec![3], None));
    }

    #[test]
    fn what_stays_keeps_its_order_and_what_goes_has_it() {
        let mut agenda = Agenda::default();
        for (number, at) in [9, 2, 9, 2, 5, 7].into_iter().enumerate() {
            assert!(agenda.add(Stamp(at), number));
        }
        assert_eq!(agenda.retain(|number| *number % 2 == 0), [1, 3, 5]);
        let left: Vec<_> = std::iter::from_fn(|| agenda.take(Stamp(9))).map(|(_, number)| number).collect();
        assert_eq!(left, [4, 0, 2]);
    }

    #[test]
    fn it_is_bounded() {
        let mut agenda = Agenda::default();
        assert!((0..MOST).all(|_| agenda.add(Stamp(0), ())));
        assert!(!agenda.add(Stamp(0), ()));
        assert!(agenda.take(Stamp(0)).is_some() && agenda.add(Stamp(0), ()));
    }
}
