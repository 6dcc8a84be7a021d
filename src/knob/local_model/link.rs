//! Between a slow thread and the servo's: models one way, the newest reading the other.
//!
//! Models go through a queue that loses none: what finds it full is joined to what waits on the slow side, and goes with the next look. Readings
//! go through a cell that holds the newest alone (Hayward & MacLean 2007, figure 10: a lossless link and a lossy one). Neither side
//! ever waits for the other.

use super::pending::{Message, Pending};
use ringbuf::traits::{Consumer, Observer, Producer, Split};
use ringbuf::{HeapCons, HeapProd, HeapRb};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering, fence};

/// Messages that may be under way.
pub const UNDER_WAY: usize = 16;

/// What the slow thread sees of the knob.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Seen {
    /// Ticks of the servo so far; 0: it has not ticked yet.
    pub tick: u64,
    /// Radians.
    pub angle: f64,
    /// Radians a second, as estimated.
    pub velocity: f64,
    /// Newton metres that were given.
    pub torque: f64,
}

/// A cell that one thread writes and another reads, neither of which ever waits: a sequence number, odd while it is being written.
#[derive(Debug)]
pub(crate) struct Cell<const N: usize = 4> {
    sequence: AtomicU64,
    words: [AtomicU64; N],
}

impl<const N: usize> Default for Cell<N> {
    fn default() -> Self {
        Self { sequence: AtomicU64::new(0), words: [const { AtomicU64::new(0) }; N] }
    }
}

impl<const N: usize> Cell<N> {
    pub(crate) fn write_words(&self, words: &[u64; N]) {
        let sequence = self.sequence.load(Ordering::Relaxed);
        self.sequence.store(sequence.wrapping_add(1), Ordering::Relaxed);
        fence(Ordering::Release);
        for (word, value) in self.words.iter().zip(words) {
            word.store(*value, Ordering::Relaxed);
        }
        self.sequence.store(sequence.wrapping_add(2), Ordering::Release);
    }

    /// What was written last; `None` while it is being written.
    pub(crate) fn read_words(&self) -> Option<[u64; N]> {
        let before = self.sequence.load(Ordering::Acquire);
        let words = std::array::from_fn(|n| self.words[n].load(Ordering::Relaxed));
        fence(Ordering::Acquire);
        let still = before == self.sequence.load(Ordering::Relaxed) && before.is_multiple_of(2);
        still.then_some(words)
    }
}

impl Cell {
    pub(crate) fn write(&self, seen: &Seen) {
        let Seen { tick, angle, velocity, torque } = *seen;
        self.write_words(&[tick, angle.to_bits(), velocity.to_bits(), torque.to_bits()]);
    }

    pub(crate) fn read(&self) -> Option<Seen> {
        let [tick, angle, velocity, torque] = self.read_words()?;
        let [angle, velocity, torque] = [angle, velocity, torque].map(f64::from_bits);
        Some(Seen { tick, angle, velocity, torque })
    }
}

/// The slow thread's end.
pub struct Slow {
    out: HeapProd<Message>,
    waiting: Pending<1>,
    cell: Arc<Cell>,
    seen: Seen,
}

/// The servo's end. Nothing of it allocates, locks or waits.
pub struct Fast {
    new: HeapCons<Message>,
    cell: Arc<Cell>,
}

/// Both ends.
pub fn link() -> (Slow, Fast) {
    let (out, new) = HeapRb::new(UNDER_WAY).split();
    let cell = Arc::new(Cell::default());
    (
        Slow { out, waiting: Pending::default(), cell: Arc::clone(&cell), seen: Seen::default() },
        Fast { new, cell },
    )
}

impl Slow {
    /// Sends a model. Where the queue is full it is joined to what waits: then `false`.
    pub fn send(&mut self, message: Message) -> bool {
        self.flush();
        self.waiting.push(message);
        self.flush()
    }

    /// Sends what waits, if there is room now; whether nothing waits any more.
    pub fn flush(&mut self) -> bool {
        let room = self.out.vacant_len() > 0;
        if room && let Some(message) = self.waiting.pop() {
            // There is room, and nobody else takes it.
            let _ = self.out.try_push(message);
        }
        self.waiting.is_empty()
    }

    /// Messages that were joined to another for want of room, ever.
    pub fn coalesced(&self) -> u64 {
        self.waiting.coalesced()
    }

    /// The newest reading; and what waits is sent, if there is room.
    pub fn look(&mut self) -> Seen {
        self.flush();
        // While it is being written it is the one before.
        self.seen = self.cell.read().unwrap_or(self.seen);
        self.seen
    }
}

impl Fast {
    /// All that came, as one.
    #[inline]
    pub fn take(&mut self) -> Option<Message> {
        let mut all: Option<Message> = None;
        for _ in 0..UNDER_WAY {
            let Some(message) = self.new.try_pop() else { break };
            all = Some(all.map_or(message, |before| before.then(&message)));
        }
        all
    }

    /// Puts the newest reading into the cell.
    #[inline]
    pub fn put(&self, seen: &Seen) {
        self.cell.write(seen);
    }
}

impl std::fmt::Debug for Slow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Slow").field("seen", &self.seen).finish_non_exhaustive()
    }
}

impl std::fmt::Debug for Fast {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Fast").finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::{Message, Seen, UNDER_WAY, link};
    use crate::knob::local_model::model::LocalModel;
    use std::sync::atomic::{AtomicBool, Ordering};

    fn message(n: u64) -> Message {
        Message::new(LocalModel { stamp: n, stiffness: n as f64, ..LocalModel::FREE }, 1.0)
    }

    #[test]
    fn nothing_is_lost_where_there_is_no_room_and_what_is_joined_is_counted() {
        let (mut slow, mut fast) = link();
        let sent: Vec<bool> = (1..=40).map(|n| slow.send(message(n))).collect();
        assert!(sent[..UNDER_WAY].iter().all(|sent| *sent) && sent[UNDER_WAY..].iter().all(|sent| !*sent));
        assert_eq!(slow.coalesced(), 40 - UNDER_WAY as u64 - 1);
        let first = fast.take().unwrap();
        assert_eq!((first.stands_for, first.impulse), (UNDER_WAY as u32, UNDER_WAY as f64));
        assert_eq!(fast.take(), None);
        slow.look();
        let rest = fast.take().unwrap();
        assert_eq!((rest.stands_for, rest.model.stamp), (40 - UNDER_WAY as u32, 40));
        assert_eq!(first.impulse + rest.impulse, 40.0, "no kick is lost");
    }

    /// Two threads: what is read was written as a whole, and never goes back; every kick arrives once.
    #[test]
    fn both_ways_hold_between_threads() {
        const KICKS: u64 = 20_000;
        let (mut slow, mut fast) = link();
        let done = AtomicBool::new(false);
        let (kicks, last) = std::thread::scope(|scope| {
            let servo = scope.spawn(|| {
                let (mut kicks, mut tick) = (0.0, 0_u64);
                loop {
                    let over = done.load(Ordering::Acquire);
                    if let Some(message) = fast.take() {
                        kicks += message.impulse;
                    }
                    tick += 1;
                    let x = tick as f64;
                    fast.put(&Seen { tick, angle: x, velocity: -x, torque: 2.0 * x });
                    if over {
                        return (kicks, tick);
                    }
                }
            });
            let mut before = 0;
            for n in 0..KICKS {
                slow.send(message(n));
                let seen = slow.look();
                let x = seen.tick as f64;
                assert_eq!((seen.angle, seen.velocity, seen.torque), (x, -x, 2.0 * x));
                assert!(seen.tick >= before);
                before = seen.tick;
            }
            while !slow.flush() {
                std::hint::spin_loop();
            }
            done.store(true, Ordering::Release);
            servo.join().unwrap()
        });
        assert_eq!(kicks, KICKS as f64);
        assert!(slow.look().tick == last);
    }
}
