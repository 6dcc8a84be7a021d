//! Between a device and the callback: reads the clocks that the callback must not know.

use std::sync::Arc;
use std::sync::mpsc::Sender;

use cpu_time::ThreadTime;

use super::board::Board;
use super::callback::Callback;
use super::clock::{Follower, StreamClock};
use super::gate::Order;
use super::intake::Hearing;
use super::relief::Relief;
use super::stamp::Epoch;

/// What a device calls to be filled. Only one device at a time has it; when that lets go of it, it goes home.
pub struct Driver {
    callback: Callback,
    follower: Follower,
    epoch: Epoch,
    rate: f64,
    board: Arc<Board>,
    relief: Relief,
    hearing: Option<Box<dyn Hearing>>,
    /// What is heard during the frames at hand.
    heard: Vec<f32>,
}

/// Frames that are heard at a time; a longer block is computed in parts.
const PART: usize = 8192;

impl Driver {
    /// For a device of `rate` frames a second that is expected to ask for blocks of `block` frames.
    pub fn new(
        callback: Callback,
        rate: f64,
        block: usize,
        epoch: Epoch,
        board: Arc<Board>,
    ) -> (Self, StreamClock) {
        let (follower, clock) = Follower::new(rate, block as u64);
        let (hearing, heard, relief) = (None, Vec::new(), Relief::default());
        (Self { callback, follower, epoch, rate, board, relief, hearing, heard }, clock)
    }

    /// From now on the engine hears this.
    pub fn listen(&mut self, hearing: Box<dyn Hearing>) {
        self.heard = vec![0.0; PART * self.callback.input_channels()];
        self.hearing = Some(hearing);
    }

    /// Another device takes over, which asks for blocks of `block` frames: what it plays comes in as `order` says.
    pub fn move_to(&mut self, block: usize, order: Order) {
        self.follower.forget(block as u64);
        self.callback.order(order);
    }

    /// Channels of a frame.
    pub fn channels(&self) -> usize {
        self.callback.channels()
    }

    /// Fills `output`, interleaved frames, which the device wants now.
    pub fn fill(&mut self, output: &mut [f32]) {
        let channels = self.callback.channels().max(1);
        let frames = output.len() / channels;
        let begin = ThreadTime::now();
        self.follower.callback(self.epoch.now(), frames as u64);
        match &mut self.hearing {
            None => self.callback.process(&[], output),
            Some(hearing) => {
                let (mut due, inputs) = (self.follower.due(), self.callback.input_channels());
                for part in output.chunks_mut(PART * channels) {
                    let frames = part.len() / channels;
                    // As many as there is room for, though a plan has never more than the first.
                    let room = self.heard.len();
                    let heard = &mut self.heard[..(frames * inputs).min(room)];
                    hearing.hear(due, inputs, heard);
                    // A card's full scale, so that what is kept of it is all that was heard.
                    heard.iter_mut().for_each(|x| *x = if x.is_finite() { x.clamp(-1.0, 1.0) } else { 0.0 });
                    self.callback.process(heard, part);
                    due += frames as f64 * self.follower.frame();
                }
            }
        }
        let (busy, period) = (begin.elapsed().as_secs_f64(), frames as f64 / self.rate);
        self.board.load.note(busy, period);
        if let Some(how) = self.relief.note(busy, period) {
            self.callback.relieve(how);
        }
    }

    /// To lend it to a device: when the device drops it, it comes back through `home`.
    pub fn lend(self, home: Sender<Box<Driver>>) -> Lent {
        Lent { driver: Some(Box::new(self)), home }
    }
}

/// A driver that a device has.
pub struct Lent {
    driver: Option<Box<Driver>>,
    home: Sender<Box<Driver>>,
}

impl Lent {
    /// As [`Driver::fill`].
    pub fn fill(&mut self, output: &mut [f32]) {
        match &mut self.driver {
            Some(driver) => driver.fill(output),
            None => output.fill(0.0),
        }
    }
}

impl Drop for Lent {
    fn drop(&mut self) {
        if let Some(driver) = self.driver.take() {
            // Where nobody waits for it any more, the session is over.
            let _ = self.home.send(driver);
        }
    }
}
