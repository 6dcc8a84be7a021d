//! Between a device and the callback: reads the clocks that the callback must not know.

#![deny(clippy::disallowed_methods)]

use std::sync::Arc;

use super::board::Board;
use super::callback::Callback;
use super::clock::{Follower, StreamClock};
use super::effort::Effort;
use super::gate::Order;
use super::intake::Hearing;
use super::relief::Relief;
use super::remote::Given;
use super::stamp::{Epoch, Stamp};
use super::steps::Steps;
use crate::engine::guard::Guard;
use crate::knob::angle::decoder::NOT_HEARD;

/// What a device calls to be filled. Only one device at a time has it; when that lets go of it, it goes home.
pub struct Driver {
    callback: Callback,
    follower: Follower,
    epoch: Epoch,
    rate: f64,
    board: Arc<Board>,
    /// Gaps of the device so far.
    gaps: u64,
    effort: Effort,
    relief: Relief,
    hearing: Option<Box<dyn Hearing>>,
    /// To where the torque of a knob on a line goes.
    given: Option<Given>,
    /// What is heard during the frames at hand, and when those should have been asked for.
    heard: Vec<f32>,
    due: f64,
    /// When the block at hand began, of which nothing is filled yet.
    begun: Option<Stamp>,
    /// Between what computes and the device.
    guard: Option<Guard>,
}

/// What a card may have said, [`NOT_HEARD`] as it is.
fn within(x: f32) -> f32 {
    match x {
        NOT_HEARD => x,
        _ if x.is_finite() => x.clamp(-1.0, 1.0),
        _ => 0.0,
    }
}

/// Frames that are heard at a time; a longer block is computed in parts.
pub const PART: usize = 8192;

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
        let driver = Self {
            callback,
            follower,
            epoch,
            rate,
            board,
            gaps: 0,
            effort: Effort::default(),
            relief: Relief::default(),
            hearing: None,
            given: None,
            heard: Vec::new(),
            due: 0.0,
            begun: None,
            guard: Some(Guard::default()),
        };
        (driver, clock)
    }

    /// From now on the engine hears this.
    pub fn listen(&mut self, mut hearing: Box<dyn Hearing>) {
        hearing.mark(&self.callback.sensor());
        self.heard = vec![0.0; PART * self.callback.input_channels()];
        self.hearing = Some(hearing);
    }

    /// From now on the torque of its knob goes there.
    pub fn give(&mut self, given: Given) {
        self.given = Some(given);
    }

    /// Another device takes over, which asks for blocks of `block` frames: what it plays comes in as `order` says.
    pub fn move_to(&mut self, block: usize, order: Order) {
        self.follower.forget(block as u64);
        // It may have been taken from a device in the middle of a block.
        self.follower.gave(self.callback.frames());
        self.effort.forget();
        self.callback.order(order);
    }

    /// The device that has it takes samples in these steps.
    pub(crate) fn round_to(&mut self, steps: Steps) {
        self.callback.round_to(steps);
    }

    /// Channels of a frame.
    pub fn channels(&self) -> usize {
        self.callback.channels()
    }

    /// Fills `output`, interleaved frames, which the device wants now.
    pub fn fill(&mut self, output: &mut [f32]) {
        self.begin(output.len() / self.callback.channels().max(1));
        self.go_on(output);
    }

    /// The device wants a block of `frames` now.
    pub(crate) fn begin(&mut self, frames: usize) {
        // Some servers ask for nothing now and then.
        if frames == 0 {
            return;
        }
        self.board.block.set(frames as u64);
        let begin = self.epoch.now();
        // A device that left out a block plays the next one sooner than the clock thinks.
        let gaps = self.board.xruns.get();
        let gapped = std::mem::replace(&mut self.gaps, gaps) != gaps;
        if gapped {
            self.follower.restart();
        }
        self.follower.callback(begin, frames as u64);
        if let Some(most) = self.callback.allowance() {
            let kept = match &self.given {
                Some(given) => given.in_time(),
                None => self.latency(frames) <= most,
            };
            self.callback.deadline(!gapped && kept);
        }
        (self.due, self.begun) = (self.follower.due(), Some(begin));
    }

    /// Fills `output`, the next interleaved frames of the block that began last; with silence from where something of it has panicked, as a task of
    /// somebody else's may.
    pub(crate) fn go_on(&mut self, output: &mut [f32]) {
        let Some(mut guard) = self.guard.take() else { return self.compute(output) };
        let frames = self.board.frames.get();
        guard.call(output, |output| self.compute(output));
        if guard.fault().is_latched() {
            // The clock goes on.
            self.board.frames.set(frames + (output.len() / self.callback.channels().max(1)) as u64);
            self.board.faults.set(1);
        }
        self.guard = Some(guard);
    }

    fn compute(&mut self, output: &mut [f32]) {
        let channels = self.callback.channels().max(1);
        let frames = output.len() / channels;
        if frames == 0 {
            return;
        }
        let begin = self.begun.take().unwrap_or_else(|| self.epoch.now());
        match &mut self.hearing {
            None => self.callback.process(&[], output),
            Some(hearing) => {
                let inputs = self.callback.input_channels();
                for part in output.chunks_mut(PART * channels) {
                    let frames = part.len() / channels;
                    // As many as there is room for, though a plan has never more than the first.
                    let room = self.heard.len();
                    let heard = &mut self.heard[..(frames * inputs).min(room)];
                    hearing.hear(self.due, inputs, heard);
                    // A card's full scale, so that what is kept of it is all that was heard.
                    heard.iter_mut().for_each(|x| *x = within(*x));
                    self.callback.process(heard, part);
                    self.due += frames as f64 * self.follower.frame();
                }
            }
        }
        if let Some(given) = &mut self.given {
            let (profile, wanted) = self.callback.torque();
            given.put(&profile, wanted);
        }
        let period = frames as f64 / self.rate;
        let busy = self.effort.of(self.epoch.now().since(begin), period);
        self.board.load.note(busy, period);
        if let Some(how) = self.relief.note(busy, period) {
            self.callback.relieve(how);
        }
    }

    /// Seconds from when the device that hears heard a frame to when this one plays what the engine makes of it, in blocks of `frames`.
    fn latency(&self, frames: usize) -> f64 {
        let out = match self.board.device_delay.get() {
            // One that does not say, or ran dry, plays the block behind the one that it plays now, at best.
            None | Some(0) => frames as f64 / self.rate,
            Some(nanoseconds) => nanoseconds as f64 * 1e-9,
        };
        self.board.input.latency.get() as f64 * 1e-9 + out
    }
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "a test is no audio thread")]
mod tests {
    use std::sync::Arc;

    use ringbuf::HeapRb;
    use ringbuf::traits::{Consumer, Split};

    use super::{Driver, Hearing, PART};
    use crate::engine::event::Event;
    use crate::engine::exchange::exchange;
    use crate::graph::scene::{Options, scene};
    use crate::live::board::Board;
    use crate::live::callback::{Callback, Deed};
    use crate::live::gate::Gate;
    use crate::live::stamp::Epoch;
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;

    /// Counts frames.
    struct Counting(f32);

    impl Hearing for Counting {
        fn hear(&mut self, _due: f64, channels: usize, frames: &mut [f32]) {
            assert_eq!(channels, 2);
            for frame in frames.chunks_exact_mut(channels) {
                self.0 += 1.0;
                // Within a card's full scale.
                frame.copy_from_slice(&[self.0 / 65_536.0, -self.0 * 1e-6]);
            }
        }

        fn mark(&mut self, _channels: &[usize]) {}
    }

    /// What a card adds to an event beyond one of its blocks, as long as its callbacks come evenly: of every rate below 1.7 ms.
    #[test]
    fn an_event_takes_less_than_1_7_ms_beyond_a_block_at_every_rate() {
        for rate in [44_100.0, 48_000.0, 88_200.0, 96_000.0, 176_400.0, 192_000.0] {
            let (callback, board, delay) = at_rate(rate, 1);
            let (_driver, clock) = Driver::new(callback, rate, 64, Epoch::begin(), board);
            let beyond = (clock.ahead() - 64) as f64 / rate + delay;
            assert!((1.6e-3..1.7e-3).contains(&beyond), "{rate} Hz: {beyond} s");
        }
    }

    /// A callback of one channel that passes on what is heard on an input channel (from 1).
    fn passing_on(channel: u32) -> (Callback, Arc<Board>) {
        let (callback, board, _) = at_rate(48_000.0, channel);
        (callback, board)
    }

    /// The same at a rate of the device, with the seconds by which the engine delays what it plays.
    fn at_rate(rate: f64, channel: u32) -> (Callback, Arc<Board>, f64) {
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nstart = \"always\"\noutput = \"i\"\n\
             [voice.v.nodes]\ni = {{ type = \"input\", channel = {channel} }}\n"
        );
        let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let options = Options { rate: Some(rate), live: true, ..Options::default() };
        let scene =
            scene(&patch, &Rig::default_for(1), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
        let (_director, mut stagehand) = exchange(&scene.plan).unwrap();
        let board = Arc::new(Board::new(1));
        let delay = stagehand.engine().delay().total();
        (Callback::new(stagehand, Gate::new(rate, 1.0), Arc::clone(&board)).0, board, delay)
    }

    /// What the governor of a knob was told holds, or torque falls: of what the two devices take together, and of gaps.
    #[test]
    fn a_knob_hears_of_a_card_that_takes_longer_and_of_gaps() {
        let text = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[knob.effects]\ns = { type = \"spring\", stiffness = 0.01 }\n";
        let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let text = "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\ncoupling = \"dc\"\n[[output]]\nkind = \"torque\"\nname = \"k\"\n\
            channel = 1\n[knob]\ninertia = 1e-5\npeak_torque = 0.1\ndelay = 0.02\n\
            sensor = { type = \"voltage\", channel = 2, full_scale_volts = 5, radians_per_volt = 1 }\n";
        let rig = Rig::parse("r", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let options = Options { rate: Some(48_000.0), live: true, attached: true, ..Options::default() };
        let scene = scene(&patch, &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
        let (_director, stagehand) = exchange(&scene.plan).unwrap();
        let board = Arc::new(Board::new(1));
        let (callback, mut rings) = Callback::new(stagehand, Gate::new(48_000.0, 1.0), Arc::clone(&board));
        let (mut driver, _clock) = Driver::new(callback, 48_000.0, 96, Epoch::begin(), Arc::clone(&board));
        driver.listen(Box::new(Counting(0.0)));
        let mut told = |input_ms: u64, output_ms: u64, gap: bool| {
            board.input.latency.set(input_ms * 1_000_000);
            board.device_delay.note(output_ms * 1_000_000);
            if gap {
                board.gap();
            }
            driver.fill(&mut [0.0; 96]);
            let deeds = rings.reports.pop_iter().map(|report| report.deed);
            deeds
                .filter_map(|deed| match deed {
                    Deed::Event { event: Event::Deadline(kept), .. } => Some(kept),
                    _ => None,
                })
                .collect::<Vec<_>>()
        };
        assert!(told(12, 7, false).is_empty());
        assert_eq!(told(12, 9, false), [false]);
        assert!(told(15, 9, false).is_empty());
        assert_eq!(told(15, 4, false), [true]);
        assert_eq!(told(15, 4, true), [false]);
        assert_eq!(told(15, 4, false), [true]);
        // One that does not say plays a block later: 2 ms.
        assert_eq!((told(17, 0, false), told(19, 0, false)), (vec![], vec![false]));
    }

    /// It was taken from a device in the middle of a block: what the clock says of frames is what was given out.
    #[test]
    fn a_block_that_was_not_filled_to_its_end_is_none() {
        let (callback, board) = passing_on(1);
        let (mut driver, clock) = Driver::new(callback, 48_000.0, 96, Epoch::begin(), Arc::clone(&board));
        driver.begin(4_096);
        (0..2).for_each(|_| driver.go_on(&mut [0.0; 512]));
        driver.move_to(96, crate::live::gate::Order::Return);
        driver.fill(&mut [0.0; 96]);
        driver.fill(&mut [0.0; 96]);
        let moment = clock.moment().unwrap();
        assert_eq!((moment.frames, driver.callback.frames()), (2 * 512 + 96, 2 * 512 + 2 * 96));
    }

    /// A device that is filled in parts, as where samples are converted.
    #[test]
    fn a_block_that_is_filled_in_parts_is_one_to_the_clock_and_to_what_is_heard() {
        struct Dues(Arc<std::sync::Mutex<Vec<f64>>>);
        impl Hearing for Dues {
            fn hear(&mut self, due: f64, _channels: usize, _frames: &mut [f32]) {
                self.0.lock().unwrap().push(due);
            }
            fn mark(&mut self, _channels: &[usize]) {}
        }
        let (callback, board) = passing_on(1);
        let (mut driver, clock) = Driver::new(callback, 48_000.0, 64, Epoch::begin(), Arc::clone(&board));
        let dues = Arc::default();
        driver.listen(Box::new(Dues(Arc::clone(&dues))));
        let whole = clock.ahead();
        for _ in 0..2 {
            driver.begin(20_000);
            for frames in [8192, 8192, 0, 3616] {
                driver.go_on(&mut vec![0.0; frames]);
            }
        }
        let moment = clock.moment().unwrap();
        assert_eq!((moment.frames, moment.ahead - whole), (20_000, 20_000 - 64));
        assert_eq!((driver.callback.frames(), board.frames.get()), (40_000, 40_000));
        let dues = dues.lock().unwrap().clone();
        assert_eq!(dues.len(), 6);
        let after = |n: usize| (dues[3 + n] - moment.time) / moment.frame;
        // The last two parts are as much later as the frames before them are long.
        assert!(
            after(0).abs() < 1e-6 && (after(1) - 8192.0).abs() < 1e-3 && (after(2) - 16_384.0).abs() < 1e-3
        );
    }

    #[test]
    fn what_is_heard_is_played_and_recorded_frame_by_frame_however_long_the_blocks_are() {
        let (mut callback, board) = passing_on(2);
        let (kept, mut record) = HeapRb::new(1 << 17).split();
        callback.record_input(kept);
        let (mut driver, _clock) = Driver::new(callback, 48_000.0, 64, Epoch::begin(), Arc::clone(&board));
        driver.listen(Box::new(Counting(0.0)));
        let mut frames = 0;
        for block in [64, 7, 1, 0, 3 * PART + 5, 96, 0, 0] {
            driver.fill(&mut vec![0.0; block]);
            frames += block;
        }
        let all: Vec<f32> = record.pop_iter().collect();
        assert_eq!((all.len(), board.input.unrecorded.get()), (2 * frames, 0));
        assert!(all.chunks(2).enumerate().all(|(n, frame)| frame[0] == (n as f32 + 1.0) / 65_536.0));
        // Where nothing was asked for, nothing was done.
        assert_eq!((board.block.get(), board.frames.get()), (96, frames as u64));
        // What found no room is counted.
        driver.fill(&mut vec![0.0; 2 * PART]);
        driver.fill(&mut vec![0.0; 8 * PART]);
        assert!(board.input.unrecorded.get() > 0);
    }
}
