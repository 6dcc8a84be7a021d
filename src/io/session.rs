//! A session: a patch on a rig on a device, until it is stopped.

use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Duration;

use ringbuf::HeapCons;
use ringbuf::HeapRb;
use ringbuf::traits::Split;

use super::device::card::Shape;
use super::device::choose::Chosen;
use super::device::failure::DeviceError;
use super::device::keeper::{BLOCK, Fate, Keeper};
use crate::engine::Delay;
use crate::engine::exchange::exchange;
use crate::live::board::Board;
use crate::live::callback::Callback;
use crate::live::conductor::{Audience, Conductor};
use crate::live::driver::Driver;
use crate::live::gate::{Gate, RAMP_OUT, UNARMED};
use crate::live::reload::Reload;
use crate::live::signal::{Handle, Refused, Signal};
use crate::live::stamp::Epoch;
use crate::midi::file::Song;
use crate::performer::{Listener, Performer};

/// How a session begins.
pub struct Beginning {
    /// What is played.
    pub scene: Reload,
    /// On what.
    pub device: Chosen,
    /// Frames a block; `None`: as the device likes.
    pub block: Option<u32>,
    /// Whether the output has its full level, or that for headphones, -20 dB.
    pub armed: bool,
    /// Whether everything that goes out is to be fetched through [`Session::recording`].
    pub record: bool,
    /// A song that plays it from the beginning.
    pub song: Option<Arc<Song>>,
    /// Hears of every event as it is made.
    pub listener: Option<Listener>,
    /// Hears what the conductor tells of.
    pub audience: Audience,
    /// Hears what becomes of the device.
    pub fate: Box<dyn FnMut(Fate) + Send>,
}

/// A session that plays. It stops when it is dropped.
pub struct Session {
    handle: Handle,
    board: Arc<Board>,
    keeper: Option<Keeper>,
    conductor: Option<JoinHandle<()>>,
    recording: Option<HeapCons<f32>>,
    rate: f64,
    delay: Delay,
}

/// Seconds of recording that may wait to be fetched.
const RECORDED: f64 = 4.0;

impl Session {
    /// Begins to play.
    ///
    /// # Errors
    /// A device that cannot be opened, or a plan that no engine can be built for.
    pub fn start(beginning: Beginning) -> Result<Self, SessionError> {
        let Beginning { scene: reload, device, block, armed, record, song, listener, audience, fate } =
            beginning;
        let Reload { scene, patch, rig, files } = reload;
        let (rate, channels) = (scene.plan.device_rate, scene.plan.channels);
        let (director, mut stagehand) =
            exchange(&scene.plan).map_err(|why| SessionError::Plan(why.to_string()))?;
        let mut performer =
            Performer::new(scene, patch, rig, files).map_err(|why| SessionError::Plan(why.to_string()))?;
        if let Some(listener) = listener {
            performer.listen(listener);
        }
        if let Some(song) = song {
            performer.play_song(song.messages.iter().copied(), song.seconds);
            let counted = performer.follow_song(&song.tempi, song.seconds);
            counted.map_err(|why| SessionError::Plan(why.to_string()))?;
        }
        performer.await_clock().map_err(|why| SessionError::Plan(why.to_string()))?;
        let delay = stagehand.engine().delay();
        let board = Arc::new(Board::new(channels));
        let gate = Gate::new(rate, if armed { 1.0 } else { UNARMED });
        let (mut callback, rings) = Callback::new(stagehand, gate, Arc::clone(&board));
        let recording = record.then(|| {
            let (out, back) = HeapRb::new((RECORDED * rate) as usize * channels).split();
            callback.record(out);
            back
        });
        let epoch = Epoch::begin();
        let expected = block.map_or(BLOCK, |block| block as usize);
        let (driver, clock) = Driver::new(callback, rate, expected, epoch, Arc::clone(&board));
        let (mut conductor, handle) =
            Conductor::new(performer, director, rings, clock, epoch, &board, audience);
        // What plays from the beginning is there before the device asks for it, so that it plays as it would be rendered.
        conductor.begin();
        let shape = Shape { channels, rate: rate as u32, block };
        let keeper = Keeper::start(driver, device, shape, &board, fate).map_err(SessionError::Device)?;
        let conductor = std::thread::Builder::new()
            .name("conductor".into())
            .spawn(move || conductor.lead())
            .map_err(|error| SessionError::Plan(format!("no thread for the conductor: {error}")))?;
        Ok(Self { handle, board, keeper: Some(keeper), conductor: Some(conductor), recording, rate, delay })
    }

    /// By which other threads reach it.
    pub fn handle(&self) -> &Handle {
        &self.handle
    }

    /// How it stands.
    pub fn board(&self) -> &Arc<Board> {
        &self.board
    }

    /// The delay of the engine that it began with.
    pub fn delay(&self) -> Delay {
        self.delay
    }

    /// What has gone out and was not fetched yet, interleaved frames, if it is recorded. Whoever takes it must fetch it several
    /// times a second.
    pub fn recording(&mut self) -> Option<HeapCons<f32>> {
        self.recording.take()
    }

    /// Closes the gate, waits until the device has been given silence, and lets go of it.
    pub fn stop(&mut self) {
        // Whoever floods the session cannot keep it from ending.
        while self.conductor.is_some() && self.handle.send(Signal::End) == Err(Refused::Busy) {
            std::thread::sleep(Duration::from_millis(1));
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
    /// What it is to play.
    Plan(String),
}

impl std::fmt::Display for SessionError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Device(error) => error.fmt(f),
            Self::Plan(what) => f.write_str(what),
        }
    }
}

impl std::error::Error for SessionError {}
