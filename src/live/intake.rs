//! From the clock of a device that hears to that of one that plays.
//!
//! The two belong to crystals that differ by some 50 millionths, and hand over blocks at moments that jitter. Each side's callbacks
//! go through a delay-locked loop ([`super::clock`]); from both the play side knows, at each of its callbacks, how many frames have
//! been heard by then, as if they came one by one. A second, slow loop ([`super::tracker`]) reads them at the speed at which the
//! distance stays what it should be, through a windowed sinc that may be read at any place.
//!
//! The distance is the reader's longest block, half the kernel, and a margin for jitter. Where nothing is there in spite of it, the
//! input fades out, the margin grows, and the input fades in again as soon as it can.

#![deny(clippy::disallowed_methods)]

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use ringbuf::traits::{Consumer, Observer, Producer, Split};
use ringbuf::{HeapCons, HeapProd, HeapRb};

use super::board::Board;
use super::clock::{Follower, Moment, StreamClock};
use super::lately::Lately;
use super::stamp::{Epoch, Stamp};
use super::tracker::Tracker;
use crate::dsp::varispeed::Varispeed;
use crate::knob::angle::decoder::NOT_HEARD;

/// Seconds that may wait.
const ROOM: f64 = 1.0;

/// Seconds of margin for jitter: at first, by which it grows, and at most.
const MARGIN: f64 = 0.003;
const GROWTH: f64 = 0.001;
const WIDEST: f64 = 0.03;

/// Seconds by which the distance may be too long before it is shortened at once.
const LATE: f64 = 0.02;

/// Seconds that a device is listened to before anything of it is heard, for the loops to settle.
const FIRST: f64 = 0.1;

/// Seconds of the fades.
const FADE: f64 = 0.005;

/// What an engine hears while it plays.
pub trait Hearing: Send {
    /// Fills `frames`, interleaved frames of `channels`, with what is heard during the frames that are computed next; the first of
    /// them was due at `due`, seconds since the session began. Neither allocates nor blocks.
    fn hear(&mut self, due: f64, channels: usize, frames: &mut [f32]);

    /// From now on, what is not heard as it is on these channels (from 0) is [`NOT_HEARD`]: a knob's sensor does not fade. It may allocate.
    fn mark(&mut self, channels: &[usize]);
}

/// How a device hears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ears {
    /// Frames a second.
    pub rate: f64,
    /// Channels of a frame.
    pub channels: usize,
    /// Frames a block, as far as it is known.
    pub block: usize,
}

/// The end at the device that hears.
pub struct Intake {
    ring: HeapProd<f32>,
    follower: Follower,
    skipped: Arc<AtomicU64>,
    epoch: Epoch,
    channels: usize,
    /// Gaps of the device so far.
    gaps: u64,
    board: Arc<Board>,
}

/// The end at the device that plays, at its rate.
pub struct Feed {
    ring: HeapCons<f32>,
    clock: StreamClock,
    moment: Option<Moment>,
    skipped: Arc<AtomicU64>,
    /// How much of that is accounted for.
    known: u64,
    gaps: u64,
    /// Frames fetched.
    fetched: u64,
    stream: Varispeed,
    tracker: Tracker,
    /// From 0 to 1, between the two samples in the middle of the kernel.
    place: f64,
    /// Frames a second of both devices, and input frames for each that is played.
    rate_in: f64,
    rate: f64,
    step: f64,
    longest: Lately,
    margin: f64,
    flows: bool,
    /// Gains of what flows and of what was held when it stopped; the step from frame to frame.
    open: f32,
    hold: f32,
    fade: f32,
    input: Vec<f32>,
    value: Vec<f32>,
    last: Vec<f32>,
    held: Vec<f32>,
    /// Channels on which nothing fades.
    marked: Vec<usize>,
    board: Arc<Board>,
}

/// The two ends between a device that hears as `ears` say and one that plays `rate` frames a second in blocks of about `block`.
pub fn bridge(ears: Ears, rate: f64, block: usize, epoch: Epoch, board: &Arc<Board>) -> (Intake, Feed) {
    let Ears { rate: rate_in, channels, block: block_in } = ears;
    let channels = channels.max(1);
    let (filled, ring) = HeapRb::new((ROOM * rate_in) as usize * channels).split();
    let (follower, clock) = Follower::new(rate_in, block_in as u64);
    let skipped = Arc::<AtomicU64>::default();
    let intake = Intake {
        ring: filled,
        follower,
        skipped: Arc::clone(&skipped),
        epoch,
        channels,
        gaps: 0,
        board: Arc::clone(board),
    };
    let frame = || vec![0.0; channels];
    let feed = Feed {
        ring,
        clock,
        moment: None,
        skipped,
        known: 0,
        gaps: 0,
        fetched: 0,
        stream: Varispeed::new(rate_in, rate, channels),
        tracker: Tracker::default(),
        place: 0.0,
        rate_in,
        rate,
        step: rate_in / rate,
        longest: Lately::new(block as u64),
        margin: MARGIN,
        flows: false,
        open: 0.0,
        hold: 0.0,
        fade: (1.0 / (FADE * rate)) as f32,
        input: frame(),
        value: frame(),
        last: frame(),
        held: frame(),
        marked: Vec::new(),
        board: Arc::clone(board),
    };
    (intake, feed)
}

impl Intake {
    /// Channels of a frame.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The device hands over `frames`, interleaved, the first of which it heard `delay` seconds ago, as far as it says.
    pub fn hear(&mut self, delay: f64, frames: &[f32]) {
        self.take(self.epoch.now(), delay, frames);
    }

    /// As [`Intake::hear`], at a moment.
    pub fn take(&mut self, at: Stamp, delay: f64, frames: &[f32]) {
        let count = (frames.len() / self.channels) as u64;
        if count == 0 {
            return;
        }
        let whole = &frames[..count as usize * self.channels];
        if self.ring.vacant_len() < whole.len() {
            self.skipped.fetch_add(count, Ordering::Release);
            self.board.input.lost.add(count);
        } else {
            self.ring.push_slice(whole);
        }
        let gaps = self.board.input.xruns.get();
        if std::mem::replace(&mut self.gaps, gaps) != gaps {
            self.follower.restart();
        }
        // What the clock shows is there already.
        self.follower.callback(at, count);
        // A device that does not say has had the block, at least.
        let delay = if delay > 0.0 { delay } else { count as f64 * self.follower.frame() };
        self.board.input.device_delay.set((delay * 1e9) as u64);
        self.board.input.frames.add(count);
    }

    /// The device was away: what comes next begins anew, in blocks of about `block` frames.
    pub fn forget(&mut self, block: usize) {
        self.follower.forget(block as u64);
    }
}

impl Feed {
    /// The next frame of the ring has this number, from the first that was heard on.
    fn next(&self) -> u64 {
        self.fetched + self.known
    }

    /// Takes the next frame out of the ring. Says whether there was one.
    fn fetch(&mut self) -> bool {
        if self.ring.occupied_len() < self.input.len() {
            return false;
        }
        self.ring.pop_slice(&mut self.input);
        self.fetched += 1;
        self.stream.take(&self.input);
        true
    }

    /// Leaves out so many frames of the ring.
    fn leave_out(&mut self, frames: u64) {
        let most = self.ring.occupied_len() / self.input.len();
        let frames = most.min(usize::try_from(frames).unwrap_or(most));
        self.ring.skip(frames * self.input.len());
        self.fetched += frames as u64;
    }

    /// What flowed does so no longer: it fades out from where it is.
    fn stop(&mut self) {
        self.flows = false;
        self.held.copy_from_slice(&self.last);
        (self.hold, self.open) = (1.0, 0.0);
        self.board.input.latency.set(0);
    }

    /// Begins to flow `distance` behind what was heard, if that is there and the next `frames` as well.
    fn begin(&mut self, heard: f64, distance: f64, frames: usize) {
        let from = heard - distance;
        let last = from + self.stream.behind() as f64 + frames as f64 * self.step + 1.0;
        let there = self.next() + (self.ring.occupied_len() / self.input.len()) as u64;
        if heard < FIRST * self.rate_in || last > there as f64 || from < 0.0 {
            return;
        }
        // Behind this frame, the kernel is in place.
        let newest = from as u64 + self.stream.behind() as u64;
        let oldest = (newest + 1).saturating_sub(2 * self.stream.behind() as u64);
        if self.next() > newest + 1 {
            return;
        }
        self.leave_out(oldest.saturating_sub(self.next()));
        self.stream.clear();
        while self.next() <= newest && self.fetch() {}
        self.place = from.fract();
        self.tracker.recentre();
        self.flows = true;
    }

    /// Frames by which what is played next is behind what was heard by then; so long may the distance be.
    fn distance(&self, heard: f64) -> f64 {
        heard - (self.next() as f64 - 1.0 - self.stream.behind() as f64 + self.place)
    }

    /// The speed for the next `frames`, which were due at `due`.
    fn follow(&mut self, due: f64, frames: usize) -> f64 {
        let (skipped, gaps) = (self.skipped.load(Ordering::Acquire), self.board.input.xruns.get());
        if (skipped, gaps) != (self.known, self.gaps) {
            // What is left in the ring is from before the gap.
            self.leave_out(u64::MAX);
            (self.known, self.gaps) = (skipped, gaps);
            if self.flows {
                self.stop();
            }
        }
        self.moment = self.clock.glimpse().or(self.moment);
        let Some(moment) = self.moment else { return 1.0 };
        let heard = moment.frames as f64 + (due - moment.time) / moment.frame;
        let wanted = self.longest.hear(frames as u64, due) as f64 * self.step
            + self.stream.behind() as f64
            + self.margin * self.rate_in;
        let mut error = (self.distance(heard) - wanted) / self.rate_in;
        if self.flows && error > LATE {
            self.board.input.jumps.add(1);
            self.stop();
        }
        if !self.flows {
            self.begin(heard, wanted, frames);
            error = 0.0;
        }
        if !self.flows {
            return 1.0;
        }
        let latency = self.distance(heard) * moment.frame + self.board.input.device_delay.get() as f64 * 1e-9;
        self.board.input.latency.set((latency * 1e9).max(0.0) as u64);
        self.tracker.speed(error, frames as f64 / self.rate)
    }

    /// The next frame of the device that hears, at the other's rate.
    fn step(&mut self, speed: f64) {
        while self.flows && self.place >= 1.0 {
            self.place -= 1.0;
            if !self.fetch() {
                self.board.input.dry.add(1);
                self.margin = (self.margin + GROWTH).min(WIDEST);
                self.stop();
            }
        }
        if self.flows {
            self.stream.read(self.place, &mut self.value);
            self.place += self.step * speed;
            self.open = (self.open + self.fade).min(1.0);
        } else {
            self.value.fill(0.0);
        }
        self.hold = (self.hold - self.fade).max(0.0);
        for ((last, value), held) in self.last.iter_mut().zip(&self.value).zip(&self.held) {
            *last = value * self.open + held * self.hold;
        }
    }
}

impl Hearing for Feed {
    fn hear(&mut self, due: f64, channels: usize, frames: &mut [f32]) {
        let speed = self.follow(due, frames.len() / channels.max(1));
        for frame in frames.chunks_exact_mut(channels.max(1)) {
            self.step(speed);
            let both = frame.len().min(self.last.len());
            frame[..both].copy_from_slice(&self.last[..both]);
            frame[both..].fill(0.0);
            let is_whole = self.flows && self.open >= 1.0 && self.hold <= 0.0;
            for &channel in &self.marked {
                if let Some(value) = frame.get_mut(channel).filter(|_| !is_whole || channel >= both) {
                    *value = NOT_HEARD;
                }
            }
        }
    }

    fn mark(&mut self, channels: &[usize]) {
        self.marked = channels.to_vec();
    }
}

#[cfg(test)]
mod tests;
