//! What other threads want of the gate: a few values of which the last counts, so that none is ever lost for lack of room.

#![deny(clippy::disallowed_methods)]

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};

use super::gate::Order;

/// What is wanted of the gate.
#[derive(Debug, Default)]
pub struct Lever {
    /// How often the brake was pulled, and the last of those that was taken back.
    pulls: AtomicU64,
    taken_back: AtomicU64,
    open: AtomicBool,
    close: Arc<AtomicBool>,
    /// How often a latch was taken back.
    releases: AtomicU32,
    /// The bits of a gain, and below them the number of the signal that asked for it, as far as 32 bits go; 0 while nobody has said one,
    /// since no gain below 0 is wanted.
    gain: AtomicU64,
    asked: Asked,
}

/// The numbers of the signals that asked for each last; 0 where it was none. Each is there before what it asks for.
#[derive(Debug, Default)]
struct Asked {
    brake: AtomicU64,
    release: AtomicU64,
    close: AtomicU64,
}

/// What the gate was told of it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Obeyed {
    panic: bool,
    open: bool,
    close: bool,
    releases: u32,
    gain: u32,
}

/// Marks a gain that somebody has said, also one of 0.
const SAID: u32 = 1 << 31;

impl Lever {
    /// Pulls the emergency brake: the next callback closes the gate, and it stays closed until [`Lever::calm`]. `cause` is the number of the
    /// signal that asks for it, here and below; 0 for none.
    pub fn panic(&self, cause: u64) {
        // Of several, the first has closed it.
        if !self.is_panicked() {
            self.asked.brake.store(cause, Ordering::Release);
        }
        self.pulls.fetch_add(1, Ordering::AcqRel);
    }

    /// How often the brake was pulled so far.
    pub fn pulls(&self) -> u64 {
        self.pulls.load(Ordering::Acquire)
    }

    /// Takes the brake back. The gate opens only at [`Lever::release`].
    pub fn calm(&self) {
        self.take_back(self.pulls());
    }

    /// The same, as somebody wants it who knows of so many pulls: one that came later holds.
    pub fn take_back(&self, pulls: u64) {
        self.taken_back.fetch_max(pulls, Ordering::AcqRel);
    }

    /// Whether the brake is pulled.
    pub fn is_panicked(&self) -> bool {
        // In this order: what is taken back was pulled before.
        let taken_back = self.taken_back.load(Ordering::Acquire);
        taken_back < self.pulls()
    }

    /// The gate opens for the first time.
    pub fn open(&self) {
        self.open.store(true, Ordering::Release);
    }

    /// The next callback closes the gate for good: the session comes to its end.
    pub fn close(&self, cause: u64) {
        self.asked.close.store(cause, Ordering::Release);
        self.close.store(true, Ordering::Release);
    }

    /// Whether that is asked for.
    pub fn closes(&self) -> bool {
        self.close.load(Ordering::Acquire)
    }

    /// The same for who can do no more than set a flag, as a signal's handler.
    pub fn closing(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.close)
    }

    /// What the brake had shut opens again.
    pub fn release(&self, cause: u64) {
        self.asked.release.store(cause, Ordering::Release);
        self.releases.fetch_add(1, Ordering::AcqRel);
    }

    /// The gain of the open gate, 0 to 1; what is no number is 0.
    pub fn gain(&self, gain: f32, cause: u64) {
        let gain = if gain > 0.0 { gain.min(1.0) } else { 0.0 };
        let said = u64::from(gain.to_bits() | SAID) << 32;
        self.gain.store(said | (cause & u64::from(u32::MAX)), Ordering::Release);
    }

    /// What is wanted that the gate was not told of yet, and which signal asked for it.
    pub(super) fn orders(&self, obeyed: &mut Obeyed) -> impl Iterator<Item = (Order, u64)> + use<> {
        // Before the brake is looked at: what is released was taken back before.
        let releases = self.releases.load(Ordering::Acquire);
        let panic = self.is_panicked();
        let latch = (panic && !obeyed.panic).then_some(Order::Latch);
        let open = (self.open.load(Ordering::Acquire) && !obeyed.open).then_some(Order::Open);
        let said = self.gain.load(Ordering::Acquire);
        let (gain, levelled) = ((said >> 32) as u32, said & u64::from(u32::MAX));
        let level = (gain != obeyed.gain).then_some(Order::Gain(f32::from_bits(gain & !SAID)));
        // A brake pulled in the meantime is stronger, and one that was taken back before anybody looked is none.
        let release = (releases != obeyed.releases && !panic && obeyed.panic).then_some(Order::Release);
        let close = (self.close.load(Ordering::Acquire) && !obeyed.close).then_some(Order::Close);
        *obeyed = Obeyed {
            panic: panic || (obeyed.panic && release.is_none()),
            open: obeyed.open || open.is_some(),
            close: obeyed.close || close.is_some(),
            releases,
            gain,
        };
        let by = |cause: &AtomicU64| cause.load(Ordering::Acquire);
        let Asked { brake, release: released, close: closed } = &self.asked;
        let causes = [by(brake), 0, levelled, by(released), by(closed)];
        let orders = [latch, open, level, release, close].into_iter().zip(causes);
        orders.filter_map(|(order, cause)| Some((order?, cause)))
    }
}

impl Obeyed {
    /// Whether the gate was told to close for good.
    pub fn closes(self) -> bool {
        self.close
    }
}

#[cfg(test)]
mod tests {
    use super::{Lever, Obeyed, Order};

    fn told(lever: &Lever, obeyed: &mut Obeyed) -> Vec<Order> {
        lever.orders(obeyed).map(|(order, _)| order).collect()
    }

    #[test]
    fn each_is_told_once_and_the_last_gain_counts() {
        let (lever, mut obeyed) = (Lever::default(), Obeyed::default());
        assert_eq!(told(&lever, &mut obeyed), []);
        lever.open();
        (0..1000).for_each(|n| lever.gain(n as f32 / 1000.0, 0));
        assert_eq!(told(&lever, &mut obeyed), [Order::Open, Order::Gain(0.999)]);
        assert_eq!(told(&lever, &mut obeyed), []);
        for (gain, is) in [(0.0, 0.0), (-3.0, 0.0), (7.0, 1.0), (f32::NAN, 0.0)] {
            lever.gain(gain, 0);
            let told = told(&lever, &mut obeyed);
            assert!(told == [Order::Gain(is)] || (told.is_empty() && gain == -3.0), "{gain} {told:?}");
        }
        lever.close(0);
        lever.closing().store(true, std::sync::atomic::Ordering::Relaxed);
        assert_eq!(told(&lever, &mut obeyed), [Order::Close]);
        assert!(obeyed.closes() && told(&lever, &mut obeyed).is_empty());
    }

    #[test]
    fn a_brake_holds_until_it_is_taken_back_and_released() {
        let (lever, mut obeyed) = (Lever::default(), Obeyed::default());
        lever.panic(0);
        lever.calm();
        lever.release(0);
        assert_eq!(told(&lever, &mut obeyed), [], "it was never latched");
        lever.panic(0);
        assert_eq!(told(&lever, &mut obeyed), [Order::Latch]);
        lever.release(0);
        assert_eq!(told(&lever, &mut obeyed), [], "the brake is stronger");
        lever.calm();
        assert_eq!(told(&lever, &mut obeyed), [], "and what came meanwhile is no more");
        lever.panic(0);
        assert_eq!(told(&lever, &mut obeyed), [], "it is latched still");
        lever.calm();
        lever.release(0);
        assert_eq!(told(&lever, &mut obeyed), [Order::Release]);
        // What was said before the last pull takes back none.
        (0..2).for_each(|_| lever.panic(0));
        assert_eq!(told(&lever, &mut obeyed), [Order::Latch]);
        lever.take_back(lever.pulls() - 1);
        lever.release(0);
        assert!(lever.is_panicked() && told(&lever, &mut obeyed).is_empty());
        lever.calm();
        lever.release(0);
        assert_eq!(told(&lever, &mut obeyed), [Order::Release]);
        lever.panic(0);
        assert_eq!(told(&lever, &mut obeyed), [Order::Latch]);
    }

    #[test]
    fn each_has_the_signal_that_asked_for_it() {
        let (lever, mut obeyed) = (Lever::default(), Obeyed::default());
        let mut told = || lever.orders(&mut obeyed).collect::<Vec<_>>();
        lever.open();
        lever.gain(0.25, 7);
        lever.gain(0.5, 8);
        assert_eq!(told(), [(Order::Open, 0), (Order::Gain(0.5), 8)]);
        lever.panic(9);
        lever.panic(10);
        assert_eq!(told(), [(Order::Latch, 9)], "the second found it closed");
        lever.calm();
        lever.release(11);
        assert_eq!(told(), [(Order::Release, 11)]);
        lever.panic(12);
        assert_eq!(told(), [(Order::Latch, 12)]);
        lever.closing().store(true, std::sync::atomic::Ordering::Relaxed);
        assert_eq!(told(), [(Order::Close, 0)], "nobody has said why");
    }
}
