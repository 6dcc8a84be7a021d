//! What reaches a session from outside.

use std::sync::{Arc, atomic::AtomicU64, atomic::Ordering};

use super::board::Board;
use super::queues::Inlet;
use super::reload::Reload;
use super::stamp::{Epoch, Stamp};
use super::way::Way;
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
    /// A port of MIDI is gone: what it holds is released. Where its cable had promised to stay, that is a panic.
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
    /// Nothing is done: somebody wants to have it in the journal.
    Note(String),
    /// Nothing is done either: something was asked for that cannot be done, and why. A journal has both.
    Vain(String, String),
    /// End the session: the gate closes.
    End,
}

impl Signal {
    /// Whether something is lost where it is not taken: what was asked for in vain was counted by whoever refused it.
    pub(super) fn counts(&self) -> bool {
        !matches!(self, Self::Vain(..))
    }
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
    /// From the system: the name of its signal (`SIGINT`), or `time` where that of the session is over.
    System(Arc<str>),
}

impl Origin {
    /// Of what is not known to have come otherwise than by this way.
    pub(super) fn unnamed(way: Way) -> Self {
        match way {
            Way::Osc => Self::Osc("".into(), "".into()),
            Way::Key => Self::Key("".into()),
            Way::Midi | Way::Program => Self::Program,
        }
    }
}

/// A signal with the moment at which it arrived.
#[derive(Debug)]
pub struct Stamped {
    /// Its number within the session: from 1, as signals were sent. Those that were refused have theirs, too.
    pub id: u64,
    /// When it arrived.
    pub stamp: Stamp,
    /// By which way.
    pub origin: Origin,
    /// From whom, where that is known: the name of a port, the address of a sender.
    pub peer: Option<Arc<str>>,
    /// How often the brake had been pulled when it was sent.
    pub pulls: u64,
    /// By how many seconds it came before the time for which it was meant, of what names one; less than 0 where it came behind that.
    pub ahead: Option<f64>,
    /// What its sender calls what is played by it.
    pub tag: Option<i64>,
    /// What it is.
    pub signal: Signal,
}

/// Where signals go in: cheap to clone, for any thread but that of the audio callback, and never in its way. Each [`Way`] has a queue of its
/// own. What lets go (a key that goes up, a release, a stop, a panic, a port that is gone) is never refused for lack of room: where its queue
/// is full it is noted, and done behind what waits there.
#[derive(Debug, Clone)]
pub struct Handle {
    inlet: Arc<Inlet>,
    epoch: Epoch,
    board: Arc<Board>,
    numbers: Arc<AtomicU64>,
    origin: Origin,
    peer: Option<Arc<str>>,
    ahead: Option<f64>,
    tag: Option<i64>,
}

/// Why a signal was not taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Refused {
    /// Too many of its way wait; it is counted, and shown with the session.
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
    pub(crate) fn new(inlet: Inlet, epoch: Epoch, board: Arc<Board>) -> Self {
        Self {
            inlet: Arc::new(inlet),
            epoch,
            board,
            numbers: Arc::default(),
            origin: Origin::Program,
            peer: None,
            ahead: None,
            tag: None,
        }
    }

    /// The same handle for signals that come another way.
    pub fn from(&self, origin: Origin) -> Self {
        Self { origin, ..self.clone() }
    }

    /// The same handle for signals from somebody.
    pub fn by(&self, peer: &Arc<str>) -> Self {
        Self { peer: Some(Arc::clone(peer)), ..self.clone() }
    }

    /// The same handle for signals that come so many seconds before the time for which they are meant.
    pub(crate) fn ahead(&self, seconds: Option<f64>) -> Self {
        Self { ahead: seconds, ..self.clone() }
    }

    /// The same handle for what its sender calls by a number.
    pub(crate) fn tagged(&self, tag: Option<i64>) -> Self {
        Self { tag, ..self.clone() }
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
        self.send_numbered(stamp, signal).map(drop)
    }

    /// The same. Gives the number of the signal within the session.
    pub(crate) fn send_numbered(&self, stamp: Stamp, signal: Signal) -> Result<u64, Refused> {
        self.send_knowing(stamp, signal, self.board.lever.pulls())
    }

    /// The same, of somebody who knew of so many pulls of the brake.
    pub(crate) fn send_knowing(&self, stamp: Stamp, signal: Signal, pulls: u64) -> Result<u64, Refused> {
        self.send_as(0, stamp, signal, pulls)
    }

    /// The same, under a number that was asked for before; 0 for the next.
    fn send_as(&self, id: u64, stamp: Stamp, signal: Signal, pulls: u64) -> Result<u64, Refused> {
        let way = Way::of(&signal, &self.origin);
        let (origin, peer) = (self.origin.clone(), self.peer.clone());
        let now = self.epoch.now();
        if let Signal::Midi(port, message) = &signal {
            self.board.cables.message(*port, now, *message);
        }
        let (ahead, tag) = (self.ahead, self.tag);
        let counts = signal.counts();
        let sent = self.inlet.send(now, Stamped { id, stamp, origin, peer, pulls, ahead, tag, signal });
        self.board.refused.of(way).add(u64::from(counts && sent == Err(Refused::Busy)));
        sent
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

    /// Stops all that a pattern of that name plays, however it was started.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn stop_named(&self, pattern: &str) -> Result<(), Refused> {
        self.send(Signal::StopNamed(pattern.into()))
    }

    /// Releases everything.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn release_all(&self) -> Result<(), Refused> {
        self.send(Signal::ReleaseAll)
    }

    /// Gives the output its full level, or that for headphones, -20 dB.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn arm(&self, full: bool) -> Result<(), Refused> {
        self.send(Signal::Arm(full))
    }

    /// Has another patch or rig take over, at the next moment at which it can. What becomes of it the session tells.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn reload(&self, reload: Reload) -> Result<(), Refused> {
        self.send(Signal::Reload(Box::new(reload)))
    }

    /// Puts a text into the journal, with its time: a response, the number of a trial.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn note(&self, text: &str) -> Result<(), Refused> {
        self.send(Signal::Note(text.into()))
    }

    /// Takes back a panic: the gate opens.
    ///
    /// # Errors
    /// A signal that was not taken.
    pub fn calm(&self) -> Result<(), Refused> {
        self.send(Signal::Calm)
    }

    /// Closes the gate with the next callback, whatever else waits; it stays closed until [`Handle::calm`].
    pub fn panic(&self) {
        let number = self.brake();
        // The brake is pulled, even where the session has ended.
        let _ = self.send_panic(self.epoch.now(), number);
    }

    /// The number of a signal that is still to be sent.
    pub(crate) fn signal_number(&self) -> u64 {
        self.inlet.number()
    }

    /// Pulls the brake for a signal that is still to be sent, and gives its number.
    pub(crate) fn brake(&self) -> u64 {
        let number = self.signal_number();
        self.board.lever.panic(number);
        number
    }

    /// Sends the signal of that number, for which the brake was pulled.
    pub(crate) fn send_panic(&self, stamp: Stamp, number: u64) -> Result<u64, Refused> {
        self.send_as(number, stamp, Signal::Panic, self.board.lever.pulls())
    }

    /// Ends the session: the gate closes with the next callback, whatever else waits, and even where the session has ended.
    pub fn end(&self) {
        let number = self.signal_number();
        self.board.lever.close(number);
        let _ = self.send_as(number, self.epoch.now(), Signal::End, self.board.lever.pulls());
    }

    /// Bytes came through a port of MIDI that make no message yet, as those in the middle of a long system exclusive: its cable is there. One that
    /// had promised to stay (active sensing) and says nothing any more is lost, and that is a panic.
    pub fn heard(&self, port: u16) {
        self.board.cables.heard(port, self.epoch.now());
    }

    /// A number that nobody else has.
    pub fn number(&self) -> u64 {
        self.numbers.fetch_add(1, Ordering::Relaxed) + 1
    }
}
