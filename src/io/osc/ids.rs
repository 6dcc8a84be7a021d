//! Ids under which senders play voices, and the session's numbers for those.

use std::collections::{HashMap, VecDeque};

/// So many voices are kept under ids.
pub(super) const MOST: usize = 4096;

/// Ids, whoever gave them: one program may play and another release.
#[derive(Debug, Default)]
pub(super) struct Ids {
    /// With the message that gave it, by its number.
    numbers: HashMap<i64, (u64, Vec<u64>)>,
    /// In the order in which they came; an id that was given again or released may stand here still.
    order: VecDeque<(i64, u64)>,
}

impl Ids {
    /// Keeps a voice under an id. One message may play several under one id; a later message takes it over, and what it stood for goes
    /// on. Gives how many ids were forgotten for it.
    pub fn keep(&mut self, id: i64, message: u64, number: u64) -> u64 {
        let (from, numbers) = self.numbers.entry(id).or_default();
        if *from != message || numbers.is_empty() {
            (*from, *numbers) = (message, Vec::new());
            self.order.push_back((id, message));
        }
        numbers.push(number);
        let mut forgotten = 0;
        while self.order.len() > MOST {
            let Some((id, message)) = self.order.pop_front() else { break };
            if self.numbers.get(&id).is_some_and(|(from, _)| *from == message) {
                self.numbers.remove(&id);
                forgotten += 1;
            }
        }
        forgotten
    }

    /// The voices of an id.
    pub fn get(&self, id: i64) -> Option<&[u64]> {
        self.numbers.get(&id).map(|(_, numbers)| &numbers[..])
    }

    /// The voices of an id, which is free then.
    pub fn take(&mut self, id: i64) -> Option<Vec<u64>> {
        self.numbers.remove(&id).map(|(_, numbers)| numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::{Ids, MOST};

    #[test]
    fn several_of_one_message_and_the_last_message() {
        let mut ids = Ids::default();
        ids.keep(7, 1, 10);
        ids.keep(7, 1, 11);
        assert_eq!((ids.take(7), ids.take(7)), (Some(vec![10, 11]), None));
        ids.keep(7, 2, 12);
        ids.keep(7, 3, 13);
        assert_eq!(ids.take(7), Some(vec![13]));
    }

    #[test]
    fn the_oldest_are_forgotten_and_counted() {
        let mut ids = Ids::default();
        let most = MOST as u64;
        let forgotten: u64 = (0..most + 5).map(|n| ids.keep(n as i64, n + 1, n)).sum();
        assert_eq!((forgotten, ids.take(4), ids.take(5)), (5, None, Some(vec![5])));
        // The same id again and again forgets only the others.
        let forgotten: u64 = (0..2 * most).map(|n| ids.keep(-1, most + 10 + n, n)).sum();
        assert_eq!((forgotten, ids.take(-1), ids.numbers.len()), (most - 1, Some(vec![2 * most - 1]), 0));
        assert!(ids.order.len() <= MOST);
    }
}
