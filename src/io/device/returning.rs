//! A device that seems to be back. It plays silence until it has asked for some; only then is it given what there is to play, so that one
//! that takes a stream and never asks for anything does not hold up the session. PulseAudio must go on asking: a sink that was idle asks for a
//! block or two, and then plays two seconds of its own silence.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::Receiver;
use std::time::Instant;

use cpal::Device;
use ringbuf::traits::{Consumer, Producer, Split};
use ringbuf::{HeapCons, HeapProd, HeapRb};

use super::card::{Card, Fill, News, Shape};
use super::failure::DeviceError;
use super::list::Found;
use super::minder::{Bell, PATIENCE, RUSH_FOR};
use crate::live::board::Board;
use crate::live::driver::Driver;
use crate::live::lent::Lent;
use crate::live::steps::Steps;

/// Looks, a few hundredths of a second apart, at which one must have asked for more that may yet pause.
const GOES_ON: u32 = 4;

/// What fills a device's frames: silence, until the driver comes.
struct Waiting {
    driver: Option<Lent<Driver>>,
    comes: HeapCons<Lent<Driver>>,
    steps: Steps,
    /// Blocks that were asked for.
    asked: Arc<AtomicU32>,
}

impl Fill for Waiting {
    fn round_to(&mut self, steps: Steps) {
        self.steps = steps;
    }

    fn begin(&mut self, frames: usize, callback: f64, delay: f64) {
        if self.driver.is_none() {
            self.driver = self.comes.try_pop();
            self.driver.iter_mut().for_each(|driver| driver.round_to(self.steps));
        }
        if let Some(driver) = &mut self.driver {
            driver.begin(frames, callback, delay);
        }
    }

    fn fill(&mut self, output: &mut [f32]) {
        match &mut self.driver {
            Some(driver) => driver.fill(output),
            None => output.fill(0.0),
        }
        if !output.is_empty() {
            self.asked.fetch_add(1, Ordering::Relaxed);
        }
    }
}

/// A device that was opened again.
pub(super) struct Returning {
    card: Card,
    driver: HeapProd<Lent<Driver>>,
    asked: Arc<AtomicU32>,
    /// Whether it was let go of since it kept no time.
    rushed: bool,
    /// Blocks that had been asked for at the last look, and at how many looks there were more.
    last: u32,
    more: u32,
    /// At how many there must be.
    due: u32,
    since: Instant,
    news: Receiver<News>,
    /// What it has said of itself, but that it is lost.
    said: Vec<News>,
}

/// How it stands with it.
pub(super) enum Stand {
    /// It has not asked for anything yet, or not often enough.
    Waits,
    /// It has.
    Plays,
    /// It is gone again, or was waited for long enough: why.
    Fails(String),
}

impl Returning {
    /// Opens a device; one that has `rushed` must keep time first.
    ///
    /// # Errors
    /// As [`Card::open`].
    pub fn open(
        device: &Device,
        found: &Found,
        shape: Shape,
        rushed: bool,
        board: &Arc<Board>,
        bell: &Bell,
    ) -> Result<Self, DeviceError> {
        let (driver, comes) = HeapRb::new(1).split();
        let asked = Arc::<AtomicU32>::default();
        let waiting = Waiting { driver: None, comes, steps: Steps::FLOAT, asked: Arc::clone(&asked) };
        let (tell, news) = bell.news();
        let card = Card::open(device, found, shape.again(found.output.as_ref()), waiting, board, tell)?;
        let due = if found.pulse().is_some() { GOES_ON } else { 1 };
        let since = Instant::now();
        Ok(Self { card, driver, asked, rushed, last: 0, more: 0, due, since, news, said: Vec::new() })
    }

    /// How it stands at a moment.
    pub fn stand(&mut self, now: Instant) -> Stand {
        while let Ok(news) = self.news.try_recv() {
            match news {
                News::Lost(why) | News::Broke(why) => return Stand::Fails(why),
                other => self.said.push(other),
            }
        }
        if self.card.rushes() {
            self.since = now;
            return Stand::Waits;
        }
        if self.rushed && now.saturating_duration_since(self.since) < RUSH_FOR {
            return Stand::Waits;
        }
        let asked = self.asked.load(Ordering::Relaxed);
        self.more += u32::from(asked != self.last);
        self.last = asked;
        let waited = now.saturating_duration_since(self.since) > PATIENCE;
        if self.more >= self.due || (waited && asked > 0) {
            Stand::Plays
        } else if waited {
            Stand::Fails("it is there, and does not ask for anything".into())
        } else {
            Stand::Waits
        }
    }

    /// Gives it what there is to play, and what it has said of itself; what it says further comes through the other end.
    pub fn play(mut self, driver: Lent<Driver>) -> (Card, Vec<News>, Receiver<News>) {
        // There is room for one, and there is only one.
        let _ = self.driver.try_push(driver);
        (self.card, self.said, self.news)
    }
}
