//! A session: a patch on a rig on a device, until it is stopped.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use ringbuf::HeapCons;
use ringbuf::HeapRb;
use ringbuf::traits::Split;

use super::device::capture;
use super::device::card::Shape;
use super::device::choose::Chosen;
use super::device::failure::{DeviceError, Trouble};
use super::device::keeper::{BLOCK, Fate, Keeper};
use super::device::list::Found;
use super::device::listening::Listening;
use super::device::priority;
use super::input::{Heard, Input};
use crate::engine::exchange::exchange;
use crate::engine::refusal::Refusal;
use crate::engine::task::Task;
use crate::engine::{Delay, Duty};
use crate::knob::local_model::link::Slow;
use crate::live::board::Board;
use crate::live::callback::Callback;
use crate::live::clock::StreamClock;
use crate::live::conductor::{Audience, Conductor};
use crate::live::driver::{Driver, PART};
use crate::live::gate::{Gate, RAMP_IN, RAMP_OUT, UNARMED};
use crate::live::intake::{Ears, Hearing, bridge};
use crate::live::reload::Reload;
use crate::live::remote;
use crate::live::signal::{Handle, Signal};
use crate::live::stamp::{self, Epoch};
use crate::midi::file::Song;
use crate::performer::{Listener, Performer};
use crate::text::Problem;

/// How a session begins.
pub struct Beginning {
    /// What is played.
    pub scene: Reload,
    /// On what.
    pub device: Chosen,
    /// Frames a block; `None`: [`Chosen::usual_block`].
    pub block: Option<u32>,
    /// Whether the output has its full level, or that for headphones, -20 dB.
    pub armed: bool,
    /// What it hears.
    pub input: Ear,
    /// The knob that is on a line: its angle is heard beside `input`, and its torque goes back.
    pub knob: Option<Box<remote::Heard>>,
    /// Whether a slow thread sends worlds to the knob, and sees it, through [`Session::linked_knob`].
    pub link_knob: bool,
    /// Whether everything that goes out is to be fetched through [`Session::recording`].
    pub record: bool,
    /// Whether everything that it hears is to be fetched through [`Session::recording_input`].
    pub record_input: bool,
    /// Periodic tasks that run with it, on the audio thread.
    pub tasks: Vec<Box<dyn Task>>,
    /// A song that plays it from the beginning.
    pub song: Option<Arc<Song>>,
    /// Hears of every event as it is made, in the conductor's thread, which it must not keep: what takes time is handed over.
    pub listener: Option<Listener>,
    /// Hears what the conductor tells of, in its thread likewise. One that panics closes the gate.
    pub audience: Audience,
    /// Hears what becomes of the device.
    pub fate: Box<dyn FnMut(Fate) + Send>,
}

/// What a session hears, if what it plays listens at all.
#[expect(clippy::large_enum_variant, reason = "there is one, for a moment")]
pub enum Ear {
    /// Silence.
    Nothing,
    /// A file, from the beginning on.
    File(Arc<Input>),
    /// A device.
    Device {
        /// Which, and what it offers.
        device: (cpal::Device, Found),
        /// Hears what becomes of it.
        fate: Box<dyn FnMut(Fate) + Send>,
    },
}

impl Beginning {
    /// Of what is played, on what, as most sessions begin: hearing nothing and heard by nobody. A card plays at -20 dB until [`Handle::arm`], as
    /// headphones may hang on it: where a person has named it, `armed` is [`Chosen::is_meant`]. The virtual card plays at full level.
    pub fn of(scene: Reload, device: Chosen) -> Self {
        Self {
            armed: matches!(device, Chosen::Virtual(_)),
            scene,
            device,
            block: None,
            input: Ear::Nothing,
            knob: None,
            link_knob: false,
            record: false,
            record_input: false,
            tasks: Vec::new(),
            song: None,
            listener: None,
            audience: Box::new(|_| {}),
            fate: Box::new(|_| {}),
        }
    }
}

/// A session that plays. It stops when it is dropped.
pub struct Session {
    handle: Handle,
    board: Arc<Board>,
    keeper: Option<Keeper>,
    listening: Option<Listening>,
    input_delay: f64,
    conductor: Option<JoinHandle<()>>,
    recording: Option<HeapCons<f32>>,
    recording_input: Option<(HeapCons<f32>, usize)>,
    linked: Option<Slow>,
    clock: StreamClock,
    duties: Vec<Arc<Duty>>,
    rate: f64,
    delay: Delay,
}

/// Seconds of recording that may wait to be fetched.
const RECORDED: f64 = 4.0;

impl Session {
    /// Begins to play.
    ///
    /// Where PipeWire is the system, it may link a stream to another device when its own goes, until the session notices. A program that does
    /// not want that asks for it before it has a second thread, by the environment variable `PIPEWIRE_PROPS`, as the program `pacinian` does:
    /// `{ node.dont-reconnect = true }`.
    ///
    /// # Errors
    /// A device that cannot be opened, or a plan that no engine can be built for.
    pub fn start(beginning: Beginning) -> Result<Self, SessionError> {
        let Beginning {
            scene: reload,
            device,
            block,
            armed,
            input,
            knob,
            link_knob,
            record,
            record_input,
            tasks,
            song,
            listener,
            audience,
            fate,
        } = beginning;
        let Reload { scene, patch, rig, files, .. } = reload;
        let (rate, channels) = (scene.plan.device_rate, scene.plan.channels);
        let (director, mut stagehand) = exchange(&scene.plan)?;
        let mut performer = Performer::new(scene, patch, rig, files)?;
        if let Some(listener) = listener {
            performer.listen(listener);
        }
        // The first that is felt is not to be weaker than the others.
        performer.lead_in(RAMP_IN)?;
        if let Some(song) = song {
            performer.play_song(song.messages.iter().copied(), song.seconds);
            performer.follow_song(&song.tempi, song.seconds)?;
        }
        performer.await_clock()?;
        let delay = stagehand.engine().delay();
        let linked = if link_knob { stagehand.engine().link_knob() } else { None };
        // The clock is asked once here, so that the audio thread finds it running.
        stamp::nanoseconds();
        let mut duties: Vec<_> = tasks.into_iter().map(|task| stagehand.engine().add_task(task)).collect();
        let (inputs, input_delay) = (stagehand.engine().input_channels(), stagehand.engine().input_delay());
        let board = Arc::new(Board::new(channels));
        board.engine_delay.set((delay.total() * 1e9).round() as u64);
        let gate = Gate::new(rate, if armed { 1.0 } else { UNARMED });
        let (mut callback, rings) = Callback::new(stagehand, gate, Arc::clone(&board));
        callback.time(stamp::nanoseconds);
        duties.extend(callback.duties());
        let ring = |channels: usize| HeapRb::new((RECORDED * rate) as usize * channels).split();
        let recording = record.then(|| {
            let (out, back) = ring(channels);
            callback.record(out);
            back
        });
        let recording_input = (record_input && inputs > 0).then(|| {
            let (heard, back) = ring(inputs);
            callback.record_input(heard);
            (back, inputs)
        });
        let epoch = Epoch::begin();
        let exact = block.is_some();
        let block = block.or_else(|| device.usual_block());
        let expected = block.map_or(BLOCK, |block| block as usize);
        let (mut driver, clock) = Driver::new(callback, rate, expected, epoch, Arc::clone(&board));
        // A knob on a line is heard behind all else.
        let others = knob.as_ref().map_or(inputs, |knob| knob.first());
        let mut listening = None;
        let hearing: Option<Box<dyn Hearing>> = match input {
            // What nothing listens to is not opened.
            _ if others == 0 => None,
            Ear::Nothing => None,
            Ear::File(input) => Some(Box::new(Heard::new(input))),
            Ear::Device { device, fate } => {
                if let Some(block) = block.filter(|block| *block as usize > PART) {
                    let what = format!("nothing can be heard in blocks of {block} frames");
                    let help = format!("give {PART} at most, or listen to nothing");
                    return Err(DeviceError::new(Trouble::Unfit, what).help(help).into());
                }
                let shape = capture::shape(&device.1, others, rate as u32, block)?;
                let block = shape.block.map_or(BLOCK, |block| block as usize);
                let ears = Ears { rate: f64::from(shape.rate), channels: shape.channels, block };
                let (intake, feed) = bridge(ears, rate, expected, epoch, &board);
                listening = Some(Listening::start(intake, device, shape, &board, fate)?);
                Some(Box::new(feed))
            }
        };
        match (knob.filter(|_| inputs > 0), hearing) {
            (Some(knob), hearing) => {
                driver.give(knob.given());
                driver.listen(match hearing {
                    Some(other) => Box::new(knob.beside(other)),
                    None => knob,
                });
            }
            (None, Some(hearing)) => driver.listen(hearing),
            (None, None) => {}
        }
        let (mut conductor, handle) =
            Conductor::new(performer, director, rings, clock.clone(), epoch, &board, audience);
        // What plays from the beginning is there before the device asks for it, so that it plays as it would be rendered.
        conductor.begin();
        let shape = Shape { channels, rate: rate as u32, block, exact };
        let keeper = Keeper::start(driver, device, shape, &board, fate)?;
        let conductor = std::thread::Builder::new()
            .name("conductor".into())
            .spawn(move || {
                priority::raise_feeding();
                conductor.lead();
            })
            .map_err(|error| SessionError::Thread(error.to_string()))?;
        let (keeper, conductor) = (Some(keeper), Some(conductor));
        Ok(Self {
            handle,
            board,
            keeper,
            listening,
            input_delay,
            conductor,
            recording,
            recording_input,
            linked,
            clock,
            duties,
            rate,
            delay,
        })
    }

    /// By which other threads reach it.
    pub fn handle(&self) -> &Handle {
        &self.handle
    }

    /// How it stands.
    pub fn board(&self) -> &Arc<Board> {
        &self.board
    }

    /// What is known of its periodic tasks.
    pub fn duties(&self) -> &[Arc<Duty>] {
        &self.duties
    }

    /// How its frames and wall time belong together.
    pub fn clock(&self) -> &StreamClock {
        &self.clock
    }

    /// Frames a second.
    pub fn rate(&self) -> f64 {
        self.rate
    }

    /// The delay of the engine that it began with.
    pub fn delay(&self) -> Delay {
        self.delay
    }

    /// Seconds by which the engine's own filter delays what it hears.
    pub fn input_delay(&self) -> f64 {
        self.input_delay
    }

    /// What has gone out and was not fetched yet, interleaved frames, if it is recorded. Whoever takes it must fetch it several
    /// times a second.
    pub fn recording(&mut self) -> Option<HeapCons<f32>> {
        self.recording.take()
    }

    /// The same of what it hears, if that is recorded and it hears anything: frames of so many channels.
    pub fn recording_input(&mut self) -> Option<(HeapCons<f32>, usize)> {
        self.recording_input.take()
    }

    /// The end by which a slow thread sends local models to the knob and sees it, if that was asked for and the plan has a knob; patches that take over
    /// go on with it. What is sent stands in the journal, and is replayed.
    pub fn linked_knob(&mut self) -> Option<Slow> {
        self.linked.take()
    }

    /// Closes the gate, waits until the device has been given silence, and lets go of it.
    pub fn stop(&mut self) {
        if let Some(keeper) = &self.keeper {
            keeper.rest();
        }
        // Whoever floods the session cannot keep it from ending: that is never refused for lack of room. The gate closes at once, whatever
        // waits before that, and where nobody conducts any more.
        if self.board.lever.closes() {
            let _ = self.handle.send(Signal::End);
        } else {
            self.handle.end();
        }
        if let Some(conductor) = self.conductor.take() {
            let _ = conductor.join();
        }
        if let Some(keeper) = self.keeper.take() {
            // The ramp and two blocks behind it, so that what a server repeats is silence.
            let block = self.board.block.get() as f64 / self.rate;
            let until = std::time::Instant::now() + Duration::from_secs_f64(RAMP_OUT + 4.0 * block + 0.2);
            let frames = self.board.frames.get();
            let enough = frames + (RAMP_OUT * self.rate) as u64 + 3 * self.board.block.get();
            while self.board.frames.get() < enough && std::time::Instant::now() < until {
                std::thread::sleep(Duration::from_millis(1));
            }
            drop(keeper);
        }
        drop(self.listening.take());
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.stop();
    }
}

/// Why a session cannot begin.
#[derive(Debug, Clone, PartialEq)]
pub enum SessionError {
    /// The device.
    Device(DeviceError),
    /// No engine can be built for what it is to play.
    Engine(Refusal),
    /// What is wrong with its patch.
    Patch(Problem),
    /// The system has no thread left: its words.
    Thread(String),
}

impl From<DeviceError> for SessionError {
    fn from(error: DeviceError) -> Self {
        Self::Device(error)
    }
}

impl From<Refusal> for SessionError {
    fn from(refusal: Refusal) -> Self {
        Self::Engine(refusal)
    }
}

impl From<Problem> for SessionError {
    fn from(problem: Problem) -> Self {
        Self::Patch(problem)
    }
}

impl std::fmt::Display for SessionError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Device(error) => error.fmt(f),
            Self::Engine(refusal) => refusal.fmt(f),
            Self::Patch(problem) => problem.fmt(f),
            Self::Thread(why) => write!(f, "no thread for the conductor: {why}"),
        }
    }
}

impl std::error::Error for SessionError {}
