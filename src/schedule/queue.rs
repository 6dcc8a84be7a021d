//! What is due, in order of time, then of source, then of arrival. Bounded: it never allocates after it was made.

use std::cmp::Ordering;
use std::collections::BinaryHeap;

use super::instant::Instant;

/// Something that is due at an instant.
#[derive(Debug, Clone, Copy)]
pub struct Entry<T> {
    /// When.
    pub at: Instant,
    /// Ties go to the lower source.
    pub source: u16,
    serial: u64,
    /// What.
    pub what: T,
}

impl<T> Entry<T> {
    fn key(&self) -> (Instant, u16, u64) {
        (self.at, self.source, self.serial)
    }
}

impl<T> PartialEq for Entry<T> {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}
impl<T> Eq for Entry<T> {}
impl<T> PartialOrd for Entry<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}
impl<T> Ord for Entry<T> {
    // Reversed: the heap's greatest is the earliest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.key().cmp(&self.key())
    }
}

/// A bounded queue of what is due.
#[derive(Debug)]
pub struct Queue<T> {
    heap: BinaryHeap<Entry<T>>,
    capacity: usize,
    serial: u64,
}

impl<T> Queue<T> {
    /// Room for `capacity` entries, taken now.
    pub fn new(capacity: usize) -> Self {
        Self { heap: BinaryHeap::with_capacity(capacity), capacity, serial: 0 }
    }

    /// Puts `what` in its place.
    ///
    /// # Errors
    /// Gives it back when the queue is full.
    pub fn push(&mut self, at: Instant, source: u16, what: T) -> Result<(), T> {
        if self.heap.len() >= self.capacity {
            return Err(what);
        }
        self.serial += 1;
        self.heap.push(Entry { at, source, serial: self.serial, what });
        Ok(())
    }

    /// When the next entry is due, if there is one.
    pub fn first(&self) -> Option<Instant> {
        self.heap.peek().map(|e| e.at)
    }

    /// The engine sample at which the next entry takes effect, if there is one.
    pub fn next(&self) -> Option<u64> {
        self.first().map(Instant::ceiling)
    }

    /// The next entry that takes effect at engine sample `clock` or before it.
    pub fn pop_due(&mut self, clock: u64) -> Option<Entry<T>> {
        if self.next()? <= clock { self.heap.pop() } else { None }
    }

    /// Changes what waits, in no particular order, and forgets what `keep` says no to. Times stay. Allocates nothing.
    pub fn edit(&mut self, mut keep: impl FnMut(&mut T) -> bool) {
        let mut entries = std::mem::take(&mut self.heap).into_vec();
        entries.retain_mut(|entry| keep(&mut entry.what));
        self.heap = BinaryHeap::from(entries);
    }

    /// Whether nothing waits.
    pub fn is_empty(&self) -> bool {
        self.heap.is_empty()
    }

    /// Entries that still fit.
    pub fn room(&self) -> usize {
        self.capacity - self.heap.len()
    }
}

#[cfg(test)]
mod tests {
    use super::{Instant, Queue};

    #[test]
    fn order_is_time_then_source_then_arrival() {
        let mut queue = Queue::new(8);
        let at = Instant::of_samples;
        for (when, source, name) in
            [(2.0, 1, 'c'), (1.5, 9, 'b'), (2.0, 0, 'a'), (2.0, 1, 'd'), (0.0, 5, 'z')]
        {
            queue.push(at(when), source, name).unwrap();
        }
        let order: String = std::iter::from_fn(|| queue.pop_due(10)).map(|e| e.what).collect();
        assert_eq!(order, "zbacd");
    }

    #[test]
    fn what_waits_can_be_changed() {
        let mut queue = Queue::new(4);
        for (at, what) in [(3.0, 3), (1.0, 1), (2.0, 2)] {
            queue.push(Instant::of_samples(at), 0, what).unwrap();
        }
        queue.edit(|what| {
            *what *= 10;
            *what != 20
        });
        assert_eq!(queue.pop_due(9).map(|e| e.what), Some(10));
        assert_eq!(queue.pop_due(9).map(|e| e.what), Some(30));
        assert!(queue.is_empty());
    }

    #[test]
    fn nothing_comes_before_its_sample_and_a_full_queue_says_so() {
        let mut queue = Queue::new(2);
        queue.push(Instant::of_samples(3.25), 0, 1).unwrap();
        queue.push(Instant::of_samples(9.0), 0, 2).unwrap();
        assert_eq!(queue.push(Instant::of_samples(1.0), 0, 3), Err(3));
        assert!(queue.pop_due(3).is_none());
        assert_eq!(queue.next(), Some(4));
        assert_eq!(queue.pop_due(4).unwrap().what, 1);
        assert_eq!(queue.room(), 1);
    }
}
