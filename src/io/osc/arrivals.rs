//! Datagrams that were received and wait until something is done about them.

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use super::time::Tag;
use crate::live::stamp::Stamp;

/// Bytes of datagrams that may wait, each with what it takes to keep it.
const ROOM: usize = 1 << 23;
const EACH: usize = 128;

/// A datagram that came.
#[derive(Debug)]
pub(super) struct Arrival {
    /// From where.
    pub from: SocketAddr,
    /// When, by the session's clock and by that of the system.
    pub now: Stamp,
    pub wall: Tag,
    /// How often the brake had been pulled by then, by this one as well.
    pub pulls: u64,
    /// The number of the signal by which it pulled it, if it did.
    pub brakes: Option<u64>,
    /// `None`: it pulled the brake, and there was no room for what else is in it.
    pub datagram: Option<Box<[u8]>>,
}

impl Arrival {
    fn size(&self) -> usize {
        EACH + self.datagram.as_ref().map_or(0, |datagram| datagram.len())
    }
}

/// Those that wait, in the order in which they came.
#[derive(Debug, Default)]
pub(super) struct Arrivals {
    waiting: Mutex<Waiting>,
    came: Condvar,
}

#[derive(Debug, Default)]
struct Waiting {
    arrivals: VecDeque<Arrival>,
    bytes: usize,
    over: bool,
}

impl Arrivals {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        // What a thread that panicked has left is whole: nothing here panics half way.
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps one; if it brakes, that at least. Says whether there was room for all of it.
    pub fn add(&self, mut arrival: Arrival) -> bool {
        let mut waiting = self.lock();
        // After the end nobody takes any.
        let room = !waiting.over && waiting.bytes + arrival.size() <= ROOM;
        if !room {
            // Behind a brake that waits already, another adds nothing.
            if arrival.brakes.is_none() || waiting.arrivals.back().is_some_and(|last| last.datagram.is_none())
            {
                return false;
            }
            arrival.datagram = None;
        }
        waiting.bytes += arrival.size();
        waiting.arrivals.push_back(arrival);
        self.came.notify_one();
        room
    }

    /// The next, for which it waits no longer than `most`.
    pub fn next(&self, most: Duration) -> Option<Arrival> {
        let idle = |waiting: &mut Waiting| waiting.arrivals.is_empty() && !waiting.over;
        let waited = self.came.wait_timeout_while(self.lock(), most, idle);
        let (mut waiting, _) = waited.unwrap_or_else(PoisonError::into_inner);
        let arrival = waiting.arrivals.pop_front()?;
        waiting.bytes -= arrival.size();
        Some(arrival)
    }

    /// Nobody waits for any more. Gives how many still waited.
    pub fn end(&self) -> usize {
        let mut waiting = self.lock();
        waiting.over = true;
        waiting.bytes = 0;
        self.came.notify_one();
        std::mem::take(&mut waiting.arrivals).len()
    }
}

#[cfg(test)]
mod tests {
    use super::{Arrival, Arrivals, EACH, ROOM};
    use crate::io::osc::time::Tag;
    use crate::live::stamp::Stamp;
    use std::time::Duration;

    fn arrival(bytes: usize, now: u64, brakes: bool) -> Arrival {
        let datagram = Some(vec![0; bytes].into());
        Arrival {
            from: ([127, 0, 0, 1], 9).into(),
            now: Stamp(now),
            wall: Tag::AT_ONCE,
            pulls: 0,
            brakes: brakes.then_some(now),
            datagram,
        }
    }

    #[test]
    fn in_order_as_far_as_there_is_room_and_a_brake_always() {
        let arrivals = Arrivals::default();
        let each = 60_000;
        let fit = ROOM / (each + EACH);
        for n in 0..fit as u64 {
            assert!(arrivals.add(arrival(each, n, false)));
        }
        assert!(!arrivals.add(arrival(each, 1000, false)));
        assert!(!arrivals.add(arrival(each, 1001, true)), "only that it brakes");
        assert!(!arrivals.add(arrival(each, 1002, true)) && !arrivals.add(arrival(each, 1003, false)));
        let mut taken =
            std::iter::from_fn(|| arrivals.next(Duration::ZERO)).map(|a| (a.now.0, a.datagram.is_some()));
        assert!(taken.by_ref().take(fit).eq((0..fit as u64).map(|n| (n, true))));
        assert_eq!(taken.collect::<Vec<_>>(), [(1001, false)]);
        // As much fits again.
        assert_eq!((0..2 * fit).filter(|_| arrivals.add(arrival(each, 0, false))).count(), fit);
        assert_eq!(arrivals.end(), fit);
        assert!(!arrivals.add(arrival(each, 0, false)), "nobody takes one that comes later");
        assert!(arrivals.next(Duration::from_secs(100)).is_none(), "nothing is waited for any more");
    }
}
