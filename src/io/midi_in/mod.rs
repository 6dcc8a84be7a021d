//! Ports of MIDI: all that there are, or those that are named, as they come and go.
//!
//! Linux says when one comes or goes; elsewhere, and besides, they are looked for once a second. What came through one that is gone is let go. Whether
//! cables that had promised to stay are there, the session sees to.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use crate::io::parting::part_with;
use crate::live::board::Board;
use crate::live::signal::{Handle, Signal};
use crate::midi::Message;

#[cfg(all(target_os = "linux", not(feature = "midi-jack")))]
mod alsa;
mod bell;
#[cfg(not(target_os = "linux"))]
mod elsewhere;
#[cfg(all(target_os = "linux", feature = "midi-jack"))]
mod jack;
mod line;
mod ports;
mod roster;
mod source;
mod unknown;

#[cfg(all(target_os = "linux", not(feature = "midi-jack")))]
use self::alsa as system;
#[cfg(not(target_os = "linux"))]
use self::elsewhere as system;
#[cfg(all(target_os = "linux", feature = "midi-jack"))]
use self::jack as system;
use bell::Bell;
use ports::Ports;
use system::System;
pub use unknown::Unknown;

/// What becomes of ports.
#[derive(Debug, Clone, PartialEq)]
pub enum PortNews {
    /// A port is listened to.
    Opened(String),
    /// A port is gone.
    Gone(String),
    /// The system has no MIDI, or does not let us at it.
    None(String),
    /// A port that cannot be opened.
    Refused(String, String),
    /// Ports are there, and none has the name that was asked for. It is told once, and no more once one was there.
    Unknown(Unknown),
}

/// Ports that are listened to until this is dropped: then the keys that are down on them are let go of.
pub struct MidiPorts {
    stop: Arc<AtomicBool>,
    bell: Arc<Bell>,
    thread: Option<JoinHandle<()>>,
}

/// How often ports are looked for, if nobody says that one has come or gone.
const EVERY: Duration = Duration::from_secs(1);

/// How soon, where one may open in a moment.
const SOON: Duration = Duration::from_millis(50);

/// So long a system may take to answer in the end.
const PATIENCE: Duration = Duration::from_secs(2);

/// What comes through a port.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum Word {
    /// A message.
    Message(Message),
    /// Bytes that make no message yet, as those in the middle of a long system exclusive.
    Bytes,
    /// Nothing any more: the port is gone.
    End,
    /// Nobody listens to it any more. It is told when that begins, and once more when nothing comes any more.
    Closed,
}

/// Hears what comes through a port, by its number and its name, and when it came: what waits in a system for its period, that comes when it is due.
pub type Ear = Arc<dyn Fn(u16, &Arc<str>, Word, Instant) + Send + Sync>;

/// Hears what becomes of ports.
pub type Newsreader = Box<dyn FnMut(PortNews) + Send>;

/// The names of all ports, or why there are none.
///
/// # Errors
/// A system without MIDI.
pub fn names() -> Result<Vec<String>, String> {
    Ok(system::sources()?.into_iter().map(|source| source.name).collect())
}

impl MidiPorts {
    /// Listens to every port whose name contains `wanted` (to all, where nothing is wanted), those that come later too, and gives a
    /// session what comes. A session has one such listener at a time: ports are known to it by numbers that each counts from 0.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub fn listen(handle: &Handle, wanted: Option<String>, news: Newsreader) -> std::io::Result<Self> {
        let handle = handle.clone();
        let board = Arc::clone(handle.board());
        let ear = move |number: u16, name: &Arc<str>, word: Word, at: Instant| {
            let signal = match word {
                Word::Message(message) => Signal::Midi(number, message),
                Word::Bytes => return handle.heard(number),
                Word::End => Signal::MidiGone(number),
                Word::Closed => {
                    // It has broken no promise.
                    handle.board().forget_cable(number);
                    Signal::MidiGone(number)
                }
            };
            // What finds no room is counted there.
            let _ = handle.by(name).send_at(handle.epoch().at(at), signal);
        };
        Self::hear(Arc::new(ear), Some(board), wanted, news)
    }

    /// The same for any listener. What makes no message is counted on the board, where there is one.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub fn hear(
        ear: Ear,
        board: Option<Arc<Board>>,
        wanted: Option<String>,
        news: Newsreader,
    ) -> std::io::Result<Self> {
        let (stop, bell) = (Arc::<AtomicBool>::default(), Arc::<Bell>::default());
        let (stopped, rings) = (Arc::clone(&stop), Arc::clone(&bell));
        let look = move || {
            let mut ports = Ports::new(ear, board.clone(), wanted, news);
            let mut system = None;
            while !stopped.load(Ordering::Acquire) {
                if let Some(over) = system.take_if(|system: &mut System| system.is_over()) {
                    ports.abandon();
                    over.abandon();
                }
                if system.is_none() {
                    system = System::open(board.as_ref(), &rings).map_err(|why| ports.without(why)).ok();
                }
                if let Some(system) = &mut system {
                    ports.look(system);
                }
                if !stopped.load(Ordering::Acquire) {
                    rings.wait(if ports.hurries() { SOON } else { EVERY });
                }
            }
            // At once, since a cable may say nothing while a system is closed, and again behind all that came until then.
            ports.close();
            match system {
                Some(over) if over.is_over() => over.abandon(),
                system => drop(system),
            }
            ports.close();
        };
        let thread = std::thread::Builder::new().name("midi ports".into()).spawn(look)?;
        Ok(Self { stop, bell, thread: Some(thread) })
    }
}

impl Drop for MidiPorts {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        self.bell.ring();
        self.thread.take().into_iter().for_each(|thread| _ = part_with(thread, PATIENCE));
    }
}
