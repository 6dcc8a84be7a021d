//! A deadline for each of a fixed number of slots, and which comes next. It never allocates after it was made.

use super::instant::Instant;

/// At most one deadline a slot: a heap of slots that knows where each stands in it, so that a deadline is set, changed and
/// taken back in logarithmic time.
#[derive(Debug)]
pub struct Deadlines {
    /// Slots with a deadline; none is later than those at twice its place and one or two more.
    heap: Vec<u32>,
    /// By slot: its place in the heap, or [`NOWHERE`].
    place: Vec<u32>,
    /// By slot: its deadline, and the name it was set under.
    due: Vec<(Instant, u64)>,
}

const NOWHERE: u32 = u32::MAX;

impl Deadlines {
    /// None yet, with room for all of `slots`.
    pub fn new(slots: usize) -> Self {
        Self {
            heap: Vec::with_capacity(slots),
            place: vec![NOWHERE; slots],
            due: vec![(Instant::NEVER, 0); slots],
        }
    }

    /// Sets the deadline of a slot, under a name, in place of the one it may have. A slot that is not there is passed over.
    pub fn set(&mut self, slot: usize, at: Instant, name: u64) {
        let Some(due) = self.due.get_mut(slot) else { return };
        *due = (at, name);
        let place = match self.place[slot] {
            NOWHERE => {
                self.heap.push(slot as u32);
                self.place[slot] = self.heap.len() as u32 - 1;
                self.heap.len() - 1
            }
            place => place as usize,
        };
        self.restore(place);
    }

    /// Takes back the deadline of a slot: when it was and its name.
    pub fn clear(&mut self, slot: usize) -> Option<(Instant, u64)> {
        let due = self.get(slot)?;
        let place = std::mem::replace(&mut self.place[slot], NOWHERE) as usize;
        self.heap.swap_remove(place);
        if let Some(&moved) = self.heap.get(place) {
            self.place[moved as usize] = place as u32;
            self.restore(place);
        }
        Some(due)
    }

    /// The deadline of a slot and its name.
    pub fn get(&self, slot: usize) -> Option<(Instant, u64)> {
        let there = self.place.get(slot).is_some_and(|place| *place != NOWHERE);
        there.then(|| self.due[slot])
    }

    /// The earliest deadline.
    pub fn next(&self) -> Option<Instant> {
        self.heap.first().map(|slot| self.due[*slot as usize].0)
    }

    /// Takes the earliest deadline: its slot, when it was, and its name. Of those that fall together, the lower name.
    pub fn pop(&mut self) -> Option<(usize, Instant, u64)> {
        let slot = *self.heap.first()? as usize;
        self.clear(slot).map(|(at, name)| (slot, at, name))
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.heap.is_empty()
    }

    /// Moves what stands at `place`, and is the only one that may stand wrong, to where it belongs.
    fn restore(&mut self, mut place: usize) {
        while place > 0 && self.comes_before(place, (place - 1) / 2) {
            self.swap(place, (place - 1) / 2);
            place = (place - 1) / 2;
        }
        loop {
            let below = 2 * place + 1;
            if below >= self.heap.len() {
                return;
            }
            let other =
                below + usize::from(below + 1 < self.heap.len() && self.comes_before(below + 1, below));
            if !self.comes_before(other, place) {
                return;
            }
            self.swap(place, other);
            place = other;
        }
    }

    fn comes_before(&self, a: usize, b: usize) -> bool {
        self.due[self.heap[a] as usize] < self.due[self.heap[b] as usize]
    }

    fn swap(&mut self, a: usize, b: usize) {
        self.heap.swap(a, b);
        for place in [a, b] {
            self.place[self.heap[place] as usize] = place as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Deadlines, Instant};

    /// Numbers that look random.
    fn mixed(n: u64) -> u64 {
        let n = (n ^ (n >> 31)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (n ^ (n >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9) >> 20
    }

    #[test]
    fn it_agrees_with_a_list_that_is_searched() {
        const SLOTS: usize = 37;
        let mut deadlines = Deadlines::new(SLOTS);
        let mut list: Vec<Option<(Instant, u64)>> = vec![None; SLOTS];
        for n in 0..20_000_u64 {
            let (slot, what) = (mixed(3 * n) as usize % SLOTS, mixed(3 * n + 1) % 8);
            // Few different instants, so that many fall together.
            let at = Instant { sample: mixed(3 * n + 2) % 20, fraction: mixed(n) as u32 & (1 << 31) };
            match what {
                0..=4 => {
                    deadlines.set(slot, at, n);
                    list[slot] = Some((at, n));
                }
                5 => assert_eq!(deadlines.clear(slot), list[slot].take()),
                _ => {
                    let first = (0..SLOTS).filter(|s| list[*s].is_some()).min_by_key(|s| list[*s]);
                    let expected = first.and_then(|s| list[s].take().map(|(at, name)| (s, at, name)));
                    assert_eq!(deadlines.pop(), expected);
                }
            }
            assert_eq!(deadlines.next(), list.iter().flatten().min().map(|(at, _)| *at));
            assert_eq!(deadlines.is_empty(), list.iter().all(Option::is_none));
            assert_eq!(deadlines.get(slot), list[slot]);
        }
    }

    #[test]
    fn slots_that_are_not_there_are_passed_over() {
        let mut deadlines = Deadlines::new(2);
        deadlines.set(2, Instant::default(), 1);
        assert_eq!((deadlines.clear(2), deadlines.get(9), deadlines.pop()), (None, None, None));
        assert!(Deadlines::new(0).is_empty());
    }
}
