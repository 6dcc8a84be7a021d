//! A sound card that is not there: it keeps real time and plays to nobody.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::priority;
use crate::live::board::Board;
use crate::live::driver::Driver;
use crate::live::lent::Lent;

/// A card that asks for blocks when they would be due, until it is dropped.
///
/// It has room for two blocks, as the cards of sound servers have: while one is played the next is asked for, and has to be there when
/// that ends. One that comes later is an xrun, after which the card begins anew.
pub struct VirtualCard {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// Frames that are filled at a time: between two of them it may stop.
const PART: usize = 512;

impl VirtualCard {
    /// Begins to ask for blocks of `block` frames of `channels`, at `rate` frames a second. `board` counts its xruns, and has what it holds, unless it
    /// stands in for a card that is away: what that one says of itself stays.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub fn start(
        mut driver: Lent<Driver>,
        channels: usize,
        rate: f64,
        block: usize,
        board: Arc<Board>,
        stands_in: bool,
    ) -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let mut frames = vec![0.0_f32; channels * block];
        let play = move || {
            priority::raise();
            let period = block as f64 / rate;
            let mut pace = Pace::begin(Instant::now(), period);
            while !stopped.load(Ordering::Acquire) {
                // The block before this one begins to play when this is asked for.
                if !stands_in {
                    board.device_delay.note((period * 1e9) as u64);
                }
                driver.used(|driver| driver.begin(block));
                for part in frames.chunks_mut(PART * channels.max(1)) {
                    // Of a block that takes for ever the rest is left out.
                    if !stopped.load(Ordering::Acquire) {
                        driver.used(|driver| driver.go_on(part));
                    }
                }
                match pace.filled(Instant::now()) {
                    Next::In(wait) => std::thread::sleep(wait),
                    Next::Xrun => board.gap(),
                }
            }
        };
        let thread = std::thread::Builder::new().name("virtual card".into()).spawn(play)?;
        Ok(Self { stop, thread: Some(thread) })
    }
}

/// When blocks are due.
#[derive(Debug)]
struct Pace {
    /// Seconds of a block.
    period: f64,
    /// When the block that is played now began, if they were played without a gap from the first to it; and the blocks since.
    begin: Instant,
    blocks: u64,
    /// Whether anything is played yet.
    plays: bool,
}

/// What follows a block that was filled.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    /// The next one is asked for when so much time has passed.
    In(Duration),
    /// It was too late, and the next one is asked for at once.
    Xrun,
}

impl Pace {
    fn begin(now: Instant, period: f64) -> Self {
        Self { period, begin: now, blocks: 0, plays: false }
    }

    /// A block was filled, and it is `now`.
    fn filled(&mut self, now: Instant) -> Next {
        self.blocks += 1;
        let due = self.begin + Duration::from_secs_f64(self.blocks as f64 * self.period);
        // Nothing plays before the first block is there, so that one is never late.
        let plays = std::mem::replace(&mut self.plays, true);
        match due.checked_duration_since(now) {
            Some(wait) => Next::In(wait),
            None => {
                // This one plays from now on, and the next has to be there when it ends.
                (self.begin, self.blocks) = (now, 0);
                if plays { Next::Xrun } else { Next::In(Duration::ZERO) }
            }
        }
    }
}

impl Drop for VirtualCard {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // One that has panicked has nothing more to say.
            let _ = thread.join();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::{Next, Pace};

    const MS: Duration = Duration::from_millis(1);

    #[test]
    fn blocks_are_asked_for_evenly_and_one_that_is_late_is_an_xrun_after_which_the_card_begins_anew() {
        let begin = Instant::now();
        let mut pace = Pace::begin(begin, 0.010);
        // The first may take its time: nothing is played before it is there.
        let mut now = begin + 25 * MS;
        assert_eq!(pace.filled(now), Next::In(Duration::ZERO));
        // Of those that follow each has the time of a block, wherever within it it is filled.
        for late in [0, 9, 3, 10] {
            assert_eq!(pace.filled(now + late * MS), Next::In(10 * MS - late * MS));
            now += 10 * MS;
        }
        // One that is not there when the one before it ends leaves a gap.
        now += 10 * MS + Duration::from_nanos(1);
        assert_eq!(pace.filled(now), Next::Xrun);
        assert_eq!(pace.filled(now + 2 * MS), Next::In(8 * MS));
        // However long it is late, it is one.
        now += Duration::from_secs(3600);
        assert_eq!(pace.filled(now), Next::Xrun);
        assert_eq!(pace.filled(now), Next::In(10 * MS));
        // Where all are late, each is one.
        for _ in 0..5 {
            now += 21 * MS;
            assert_eq!(pace.filled(now), Next::Xrun);
        }
        assert_eq!(pace.filled(now + 4 * MS), Next::In(6 * MS));
    }

    #[test]
    fn days_do_not_drift() {
        // A seventh of a second is no number of nanoseconds.
        let begin = Instant::now();
        let mut pace = Pace::begin(begin, 1.0 / 7.0);
        let mut now = begin;
        for _ in 0..7 * 3600 * 24 {
            match pace.filled(now) {
                Next::In(wait) => now += wait,
                Next::Xrun => panic!("nothing was late"),
            }
        }
        let off = (now - begin).as_secs_f64() - 3600.0 * 24.0;
        assert!(off.abs() < 1e-6, "{off} s");
    }
}
