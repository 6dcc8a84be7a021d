//! The queues between those who send signals and the conductor: one for each way, all of a declared size.
//!
//! No sender waits: what finds no room is refused, and what lets go is kept as what is owed. The conductor takes what waits by time, then
//! by way; in one pass no more than [`SHARE`] of each, so that no flood keeps the others waiting.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, TrySendError, sync_channel};
use std::sync::{Arc, OnceLock};
use std::thread::Thread;
use std::time::Duration;

use super::owed::Owed;
use super::signal::{Origin, Refused, Stamped};
use super::stamp::Stamp;
use super::way::{WAYS, Way};

/// Signals of one way that are taken in a pass: below a millisecond's work.
pub const SHARE: usize = 256;

/// What senders and conductor share.
#[derive(Debug)]
struct Shared {
    owed: [Owed; WAYS],
    /// Signals so far, refused ones as well.
    ids: AtomicU64,
    conductor: OnceLock<Thread>,
    closed: AtomicBool,
}

/// Where signals go in, for all handles of a session.
#[derive(Debug)]
pub(crate) struct Inlet {
    lanes: [SyncSender<Stamped>; WAYS],
    shared: Arc<Shared>,
}

/// Where they come out.
#[derive(Debug)]
pub(crate) struct Inbox {
    lanes: [Lane; WAYS],
    shared: Arc<Shared>,
}

#[derive(Debug)]
struct Lane {
    way: Way,
    signals: Receiver<Stamped>,
    /// What let go and found no room; it comes behind what waited.
    debts: VecDeque<Stamped>,
    /// What comes next.
    head: Option<Stamped>,
    /// So many more in this pass.
    left: usize,
    /// Nobody can send any more.
    over: bool,
}

/// The two ends.
pub(crate) fn queues() -> (Inlet, Inbox) {
    let shared = Arc::new(Shared {
        owed: Way::ALL.map(Owed::new),
        ids: AtomicU64::new(0),
        conductor: OnceLock::new(),
        closed: AtomicBool::new(false),
    });
    let ends = Way::ALL.map(|way| (way, sync_channel(way.capacity())));
    let lanes = std::array::from_fn(|n| ends[n].1.0.clone());
    let inlet = Inlet { lanes, shared: Arc::clone(&shared) };
    let lanes = ends.map(|(way, (_, signals))| Lane {
        way,
        signals,
        debts: VecDeque::new(),
        head: None,
        left: 0,
        over: false,
    });
    (inlet, Inbox { lanes, shared })
}

impl Inlet {
    /// The number that a signal is to have which will be sent.
    pub fn number(&self) -> u64 {
        self.shared.ids.fetch_add(1, Ordering::Relaxed) + 1
    }

    /// Sends a signal, now; one that has no number yet is given the next of the session. Tells it.
    ///
    /// # Errors
    /// One that was not taken.
    pub fn send(&self, now: Stamp, mut stamped: Stamped) -> Result<u64, Refused> {
        let Shared { owed, conductor, closed, .. } = &*self.shared;
        if closed.load(Ordering::Acquire) {
            return Err(Refused::Ended);
        }
        let way = Way::of(&stamped.signal, &stamped.origin);
        let owed = &owed[way as usize];
        if stamped.id == 0 {
            stamped.id = self.number();
        }
        let id = stamped.id;
        let unsent = if owed.is_due() {
            Some(stamped)
        } else {
            match self.lanes[way as usize].try_send(stamped) {
                Ok(()) => None,
                Err(TrySendError::Full(stamped)) => Some(stamped),
                Err(TrySendError::Disconnected(_)) => return Err(Refused::Ended),
            }
        };
        unsent.iter().for_each(|unsent| owed.keep_number(unsent));
        // What is meant for later would keep all that is owed waiting.
        if unsent.is_some_and(|unsent| !owed.note(unsent.stamp.min(now), &unsent.signal)) {
            return Err(Refused::Busy);
        }
        if let Some(conductor) = conductor.get() {
            conductor.unpark();
        }
        Ok(id)
    }
}

impl Inbox {
    /// This thread is the one that senders wake.
    pub fn attend(&self) {
        self.shared.conductor.get_or_init(std::thread::current);
    }

    /// Waits until somebody has sent something, but no longer than `most`; where not all was taken in the last pass, not at all.
    pub fn wait(&self, most: Duration) {
        if !most.is_zero() && self.lanes.iter().all(|lane| lane.left > 0 && lane.head.is_none()) {
            std::thread::park_timeout(most);
        }
    }

    /// A pass begins.
    pub fn begin(&mut self) {
        self.lanes.iter_mut().for_each(|lane| lane.left = SHARE);
    }

    /// What comes next: of each way in the order in which it was sent, of several that with the earliest stamp, then by way. `None`: nothing
    /// waits, or the pass is over.
    pub fn next(&mut self) -> Option<Stamped> {
        let Shared { owed, ids, .. } = &*self.shared;
        for lane in &mut self.lanes {
            lane.look(&owed[lane.way as usize], ids);
        }
        let waiting = self.lanes.iter_mut().filter(|lane| lane.head.is_some());
        let first = waiting.min_by_key(|lane| (lane.head.as_ref().map(|head| head.stamp), lane.way))?;
        first.left -= 1;
        first.head.take()
    }

    /// From now on, whoever sends is told that nobody hears it. Gives how many signals of each way still waited.
    pub fn close(&mut self) -> [u64; WAYS] {
        self.shared.closed.store(true, Ordering::Release);
        std::array::from_fn(|way| {
            let Lane { head, debts, signals, .. } = &mut self.lanes[way];
            let waited = head.take().into_iter().chain(std::mem::take(debts)).chain(signals.try_iter());
            waited.filter(|stamped| stamped.signal.counts()).count() as u64
        })
    }

    /// Whether nobody can send anything any more, and nothing waits.
    pub fn is_over(&self) -> bool {
        self.lanes.iter().all(|lane| lane.over)
    }
}

impl Lane {
    /// Sees to it that there is a head, if anything waits that may still come in this pass.
    fn look(&mut self, owed: &Owed, ids: &AtomicU64) {
        if self.head.is_some() || self.left == 0 {
            return;
        }
        self.head = self.debts.pop_front();
        if self.head.is_some() {
            return;
        }
        // Before it is looked what waits: what is owed by then comes behind all that was sent before it.
        let due = owed.is_due();
        match self.signals.try_recv() {
            Ok(stamped) => self.head = Some(stamped),
            Err(TryRecvError::Empty) if !due => {}
            Err(error) => {
                let (way, mut debts) = (self.way, VecDeque::new());
                let taken = owed.take(&mut |stamp, signal| {
                    let id =
                        owed.take_number(&signal).unwrap_or_else(|| ids.fetch_add(1, Ordering::Relaxed) + 1);
                    let origin = Origin::unnamed(way);
                    // What is owed takes back no brake.
                    debts.push_back(Stamped {
                        id,
                        stamp,
                        origin,
                        peer: None,
                        pulls: 0,
                        ahead: None,
                        tag: None,
                        signal,
                    });
                });
                // As long as it is due, nobody sends but who had begun to before it was; what is owed may let go of that.
                self.debts.extend(self.signals.try_iter());
                owed.settle(taken);
                self.debts.append(&mut debts);
                self.head = self.debts.pop_front();
                self.over = error == TryRecvError::Disconnected && self.head.is_none() && !owed.is_due();
            }
        }
    }
}

impl Drop for Inbox {
    fn drop(&mut self) {
        self.shared.closed.store(true, Ordering::Release);
    }
}

#[cfg(test)]
mod tests;
