//! What a device has and its callback uses, and which can be taken from a device that does not give it back.

#![deny(clippy::disallowed_methods)]

use std::sync::Arc;
use std::sync::mpsc::Sender;

use crossbeam_utils::atomic::AtomicCell;

/// Where it is between two callbacks. No larger than a pointer, so that it is taken and put back without a lock.
type Slot<T> = Arc<AtomicCell<Option<Box<T>>>>;

/// What a device has. When the device drops it, it goes home.
pub struct Lent<T> {
    slot: Slot<T>,
    home: Sender<Box<T>>,
}

/// By which it is taken from a device that does not give it back: a stream whose server has died may never be done.
pub struct Recall<T> {
    slot: Slot<T>,
}

/// Lends it to a device: when the device drops it, it comes back through `home`. It can be recalled before.
pub fn lend<T>(what: Box<T>, home: Sender<Box<T>>) -> (Lent<T>, Recall<T>) {
    let slot = Arc::new(AtomicCell::new(Some(what)));
    (Lent { slot: Arc::clone(&slot), home }, Recall { slot })
}

impl<T> Recall<T> {
    /// What was lent; `None` while the device uses it, and where it has been given back. The device has nothing from here on.
    pub fn take(&self) -> Option<Box<T>> {
        self.slot.take()
    }
}

impl<T> Lent<T> {
    /// Says whether it is still there to be used.
    pub fn used(&mut self, with: impl FnOnce(&mut T)) -> bool {
        let Some(mut what) = self.slot.take() else { return false };
        with(&mut what);
        self.slot.store(Some(what));
        true
    }
}

impl<T> Drop for Lent<T> {
    fn drop(&mut self) {
        if let Some(what) = self.slot.take() {
            // Where nobody waits for it any more, the session is over.
            let _ = self.home.send(what);
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use crossbeam_utils::atomic::AtomicCell;

    use super::lend;

    #[test]
    fn it_is_taken_and_put_back_without_a_lock() {
        assert!(AtomicCell::<Option<Box<[u64; 9]>>>::is_lock_free());
    }

    #[test]
    fn it_goes_home_or_is_taken_and_is_nowhere_twice() {
        let (home, back) = channel();
        let (mut lent, recall) = lend(Box::new(1), home.clone());
        assert!(lent.used(|n| *n += 1));
        drop(lent);
        assert_eq!((back.try_recv().map(|n| *n), recall.take()), (Ok(2), None));
        let (mut lent, recall) = lend(Box::new(5), home);
        assert!(lent.used(|_| assert_eq!(recall.take(), None, "while it is used")));
        assert_eq!(recall.take().as_deref(), Some(&5));
        assert!(!lent.used(|_| unreachable!("it is not there")));
        drop(lent);
        assert!(back.try_recv().is_err());
    }
}
