//! A sound card that is not there: it keeps real time and plays to nobody.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use super::priority;
use crate::live::driver::Driver;
use crate::live::lent::Lent;

/// A card that further asks for blocks when they would be due, until it is dropped.
pub struct VirtualCard {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// A card that was stopped for longer goes on from there, as a real one does after a gap.
const LOST: Duration = Duration::from_millis(100);

impl VirtualCard {
    /// Begins to ask for blocks of `block` frames of `channels`, at `rate` frames a second.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub fn start(
        mut driver: Lent<Driver>,
        channels: usize,
        rate: f64,
        block: usize,
    ) -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let mut frames = vec![0.0_f32; channels * block];
        let play = move || {
            priority::raise();
            let mut begin = Instant::now();
            let mut blocks = 0_u32;
            while !stopped.load(Ordering::Acquire) {
                driver.used(|driver| driver.fill(&mut frames));
                blocks += 1;
                let due = begin + Duration::from_secs_f64(f64::from(blocks) * block as f64 / rate);
                let now = Instant::now();
                if let Some(wait) = due.checked_duration_since(now) {
                    std::thread::sleep(wait);
                }
                if now.saturating_duration_since(due) > LOST || blocks == u32::MAX {
                    (begin, blocks) = (Instant::now(), 0);
                }
            }
        };
        let thread = std::thread::Builder::new().name("virtual card".into()).spawn(play)?;
        Ok(Self { stop, thread: Some(thread) })
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
