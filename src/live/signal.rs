//! What reaches a session from outside.

use std::sync::mpsc::{SyncSender, TrySendError};
use std::sync::{Arc, atomic::AtomicU64, atomic::Ordering};

use super::board::Board;
use super::reload::Reload;
use super::stamp::{Epoch, Stamp};
use crate::midi::Message;
use crate::performer::{Note, Touch};

/// Something that a session is to do.
#[derive(Debug)]
pub enum Signal {
    /// Play a voice, under a number by which it can be released.
    Play(u64, String, Note),
    /// Move the hand that holds the voice of that number.
    Touch(u64, Touch),
    /// Release the voice of that number.
    Release(u64),
    /// Release everything.
    ReleaseAll,
    /// Send a control to a value.
    Set(String, f64),
    /// Start a pattern, under a number by which it can be stopped.
    Start(u64, String),
    /// Stop the pattern of that number; 0: what plays from the beginning.
    Stop(u64),
    /// Stop all that a pattern of that name plays, however it was started.
    StopNamed(String),
    /// A key of the computer, from 1.
    Key(u32),
    /// A message of MIDI, and the number of the port through which it came.
    Midi(u16, Message),
    /// A port of MIDI is gone.
    MidiGone(u16),
    /// An OSC message that is for the patch's triggers: its address, and its numbers.
    Osc(String, Vec<f64>),
    /// Close the gate at once and keep it closed; stop all patterns and release all voices.
    Panic,
    /// Take back a panic.
    Calm,
    /// Full level, or that for headphones.
    Arm(bool),
    /// Let the torque of a knob that is there rise, after a fault as well, or let it go at once.
    Torque(bool),
    /// Another patch or rig takes over.
    Reload(Box<Reload>),
    /// End the session: the gate closes.
    End,
}

/// By which way a signal came, where it does not say so itself. A journal has it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Origin {
    /// From a program that has a [`Handle`].
    #[default]
    Program,
    /// From a key of the computer; what stands on it.
    Key(Arc<str>),
    /// In an OSC message: its address and its arguments, as they came.
    Osc(Arc<str>, Arc<str>),
}

/// A signal with the moment at which it arrived.
#[derive(Debug)]
pub struct Stamped {
    /// When it arrived.
    pub stamp: Stamp,
    /// By which way.
    pub origin: Origin,
    /// What it is.
    pub signal: Signal,
}

/// Signals that may wait for the conductor.
pub const WAITING: usize = 1 << 12;

/// Where signals go in: cheap to clone, for any thread, and never in its way.
#[derive(Debug, Clone)]
pub struct Handle {
    out: SyncSender<Stamped>,
    epoch: Epoch,
    board: Arc<Board>,
    numbers: Arc<AtomicU64>,
    origin: Origin,
}

/// Why a signal was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// Too many wait; it is counted, and shown with the session.
    Busy,
    /// The session has ended.
    Ended,
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Busy => "more signals came than the session could take; send fewer at once",
            Self::Ended => "the session has ended",
        })
    }
}

impl std::error::Error for Refused {}

impl Handle {
    pub(crate) fn new(out: SyncSender<Stamped>, epoch: Epoch, board: Arc<Board>) -> Self {
        Self { out, epoch, board, numbers: Arc::default(), origin: Origin::Program }
    }

    /// The same handle for signals that come another way.
    pub fn from(&self, origin: Origin) -> Self {
        Self { origin, ..self.clone() }
    }

    /// Sends a signal that arrives now.
    ///
    /// # Errors
    /// One that was not taken.
    pub fn send(&self, signal: Signal) -> Result<(), Refused> {
        self.send_at(self.epoch.now(), signal)
    }

    /// Sends a signal that arrived at `stamp`, or is meant for then if that is still to come.
    ///
    /// # Errors
    /// One that was not taken.
    pub fn send_at(&self, stamp: Stamp, signal: Signal) -> Result<(), Refused> {
        let origin = self.origin.clone();
        self.out.try_send(Stamped { stamp, origin, signal }).map_err(|error| match error {
            TrySendError::Full(_) => {
                self.board.refused.add(1);
                Refused::Busy
            }
            TrySendError::Disconnected(_) => Refused::Ended,
        })
    }

    /// The clock of the session.
    pub fn epoch(&self) -> Epoch {
        self.epoch
    }

    /// How the session stands.
    pub fn board(&self) -> &Arc<Board> {
        &self.board
    }

    /// Plays a voice now. Gives a number to release it by. What is wrong with it, a name that the patch does not have, the session says.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn play(&self, voice: &str, note: Note) -> Result<u64, Refused> {
        let number = self.number();
        self.send(Signal::Play(number, voice.into(), note)).map(|()| number)
    }

    /// Bends or presses a voice now, apart from all others: its nodes read it as `touch.bend`, `touch.pressure` and `touch.timbre`.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn touch(&self, number: u64, touch: Touch) -> Result<(), Refused> {
        self.send(Signal::Touch(number, touch))
    }

    /// Releases a voice now.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn release(&self, number: u64) -> Result<(), Refused> {
        self.send(Signal::Release(number))
    }

    /// Sends a control to a value, now.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn set(&self, control: &str, value: f64) -> Result<(), Refused> {
        self.send(Signal::Set(control.into(), value))
    }

    /// Starts a pattern now. Gives a number to stop it by.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn start(&self, pattern: &str) -> Result<u64, Refused> {
        let number = self.number();
        self.send(Signal::Start(number, pattern.into())).map(|()| number)
    }

    /// Stops a pattern now.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn stop(&self, number: u64) -> Result<(), Refused> {
        self.send(Signal::Stop(number))
    }

    /// Closes the gate with the next callback, whatever else waits; it stays closed until [`Signal::Calm`].
    pub fn panic(&self) {
        self.board.panic();
        // The brake is pulled; where this finds no room, the voices go on behind it.
        let _ = self.send(Signal::Panic);
    }

    /// A number that nobody else has.
    pub fn number(&self) -> u64 {
        self.numbers.fetch_add(1, Ordering::Relaxed) + 1
    }
}
