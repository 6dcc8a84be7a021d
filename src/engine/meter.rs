//! A meter: a periodic task that reads a signal, and what it read for another thread to see.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use super::task::{Task, Values};
use crate::schedule::Beat;

/// A periodic task that reads an engine-wide signal: a control, a shared node or an input.
///
/// It sees the signal at the samples of its beat and at no others: for a peak that misses nothing, [`Beat::every`]`(1)`.
#[derive(Debug)]
pub struct Meter {
    signal: usize,
    beat: Beat,
    level: Arc<Cells>,
}

/// What a meter has read, for any thread: neither side ever waits for the other.
#[derive(Debug, Clone)]
pub struct Level(Arc<Cells>);

#[derive(Debug, Default)]
struct Cells {
    latest: AtomicU32,
    /// Of what is never negative, the bits have the order of the numbers.
    peak: AtomicU32,
}

impl Meter {
    /// A meter for an engine-wide signal by its number (see [`crate::graph::plan::Plan::signal`]), and where to see it. Give the meter to
    /// [`super::Engine::add_task`].
    pub fn new(signal: usize, beat: Beat) -> (Self, Level) {
        let level = Arc::new(Cells::default());
        (Self { signal, beat, level: Arc::clone(&level) }, Level(level))
    }
}

impl Level {
    /// What the signal was when it was read last; 0 before that.
    pub fn latest(&self) -> f32 {
        f32::from_bits(self.0.latest.load(Ordering::Relaxed))
    }

    /// The largest magnitude that was read since this was asked last, by whichever thread; 0 where nothing was read since.
    pub fn take_peak(&self) -> f32 {
        f32::from_bits(self.0.peak.swap(0, Ordering::Relaxed))
    }
}

impl Task for Meter {
    fn beat(&self) -> Beat {
        self.beat
    }

    fn run(&mut self, board: &mut dyn Values) {
        let value = board.signal(self.signal) as f32;
        self.level.latest.store(value.to_bits(), Ordering::Relaxed);
        // Not-a-number has no size.
        if !value.is_nan() {
            self.level.peak.fetch_max(value.abs().to_bits(), Ordering::Relaxed);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Beat, Meter, Task, Values};

    struct Board(f64);

    impl Values for Board {
        fn clock(&self) -> u64 {
            0
        }
        fn signal(&self, index: usize) -> f64 {
            if index == 3 { self.0 } else { 99.0 }
        }
        fn send(&mut self, _: usize, _: f64) {}
    }

    #[test]
    fn it_keeps_the_latest_and_the_largest() {
        let (mut meter, level) = Meter::new(3, Beat::every(10));
        assert_eq!((level.latest(), level.take_peak()), (0.0, 0.0));
        for value in [0.5, -0.75, 1e-30, -0.25] {
            meter.run(&mut Board(value));
        }
        assert_eq!((level.latest(), level.take_peak(), level.take_peak()), (-0.25, 0.75, 0.0));
        meter.run(&mut Board(f64::NAN));
        assert_eq!(level.take_peak(), 0.0);
        meter.run(&mut Board(f64::NEG_INFINITY));
        assert_eq!(level.take_peak(), f32::INFINITY);
    }

    #[test]
    fn another_thread_sees_every_peak_once() {
        let (mut meter, level) = Meter::new(3, Beat::every(1));
        let sum = std::thread::scope(|scope| {
            scope.spawn(move || (1..=1000).for_each(|n| meter.run(&mut Board(f64::from(n)))));
            let mut highest = 0.0_f32;
            while highest < 1000.0 {
                highest = highest.max(level.take_peak());
            }
            highest + level.take_peak()
        });
        assert_eq!(sum, 1000.0);
    }
}
