//! Ports of MIDI: all that there are, or those that are named, as they come and go.
//!
//! A system says nothing when a cable is pulled, so ports are looked for once a second. What came through one that is gone is let go. Whether cables that
//! had promised to stay are there, the session sees to.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use midir::MidiInput;

use crate::io::parting::part_with;
use crate::live::board::Board;
use crate::live::signal::{Handle, Signal};
use crate::midi::Message;

mod line;
mod overruns;
mod ports;
mod roster;
#[cfg(all(target_os = "linux", feature = "midi-jack"))]
#[path = "midi_in/jack_server.rs"]
mod server;
#[cfg(not(all(target_os = "linux", feature = "midi-jack")))]
#[path = "midi_in/no_server.rs"]
mod server;
mod unknown;

pub use overruns::count_overruns;
use ports::Ports;
use server::Server;
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

/// Ports that are listened to until this is dropped.
pub struct MidiPorts {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

/// How often ports are looked for.
const EVERY: Duration = Duration::from_millis(1000);

/// So long a system may take to answer in the end.
const PATIENCE: Duration = Duration::from_secs(2);

/// How often it looks whether it is to stop.
const GLANCE: Duration = Duration::from_millis(50);

/// What comes through a port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Word {
    /// A message.
    Message(Message),
    /// Bytes that make no message yet, as those in the middle of a long system exclusive.
    Bytes,
    /// Nothing any more: the port is gone.
    End,
}

/// Hears what comes through a port, by its number and its name.
pub type Ear = Arc<dyn Fn(u16, &Arc<str>, Word) + Send + Sync>;

/// Hears what becomes of ports.
pub type Newsreader = Box<dyn FnMut(PortNews) + Send>;

/// What leads to the ports. Where ALSA's sequencer is missing, its library would say so on standard error each time it is asked.
fn input() -> Result<MidiInput, String> {
    let sequencer = std::path::Path::new("/dev/snd/seq");
    if cfg!(all(target_os = "linux", not(feature = "midi-jack"))) && !sequencer.exists() {
        return Err(
            "there is no /dev/snd/seq: load the sequencer, sudo modprobe snd-seq, or plug an instrument in"
                .into(),
        );
    }
    crate::io::device::hush::hush();
    #[cfg(all(target_os = "linux", feature = "midi-jack"))]
    crate::io::device::hush::hush_jack()
        .map_err(|why| format!("JACK's library is missing ({why}): sudo apt install libjack-jackd2-0"))?;
    MidiInput::new("pacinian").map_err(|error| match cfg!(all(target_os = "linux", feature = "midi-jack")) {
        true => {
            format!("no JACK server answers ({error}): start it, jackd -d alsa, or the program under pw-jack")
        }
        false => error.to_string(),
    })
}

/// The names of all ports, or why there are none.
///
/// # Errors
/// A system without MIDI.
pub fn names() -> Result<Vec<String>, String> {
    let input = input()?;
    Ok(input.ports().iter().filter_map(|port| input.port_name(port).ok()).collect())
}

impl MidiPorts {
    /// Listens to every port whose name contains `wanted` (to all, where nothing is wanted), those that come later too, and gives a
    /// session what comes.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub fn listen(handle: &Handle, wanted: Option<String>, news: Newsreader) -> std::io::Result<Self> {
        let handle = handle.clone();
        let board = Arc::clone(handle.board());
        let ear = move |number: u16, name: &Arc<str>, word: Word| {
            let signal = match word {
                Word::Message(message) => Signal::Midi(number, message),
                Word::Bytes => return handle.heard(number),
                Word::End => Signal::MidiGone(number),
            };
            // What finds no room is counted there.
            let _ = handle.by(name).send(signal);
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
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let look = move || {
            let (mut server, mut ports) = (Server::new(), Ports::new(ear, board.clone(), wanted, news));
            while !stopped.load(Ordering::Acquire) {
                let input = input();
                if server.has_ended(input.is_ok(), board.as_ref()) {
                    ports.abandon();
                }
                ports.look(input, &server.anew());
                // Those that were opened now are as they were opened.
                server.anew();
                let mut waited = Duration::ZERO;
                while waited < EVERY && !stopped.load(Ordering::Acquire) {
                    board.iter().for_each(|board| board.midi.gaps.add(overruns::taken()));
                    std::thread::sleep(GLANCE);
                    waited += GLANCE;
                }
            }
            if server.has_ended(false, None) {
                ports.abandon();
            }
        };
        let thread = std::thread::Builder::new().name("midi ports".into()).spawn(look)?;
        Ok(Self { stop, thread: Some(thread) })
    }
}

impl Drop for MidiPorts {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        self.thread.take().into_iter().for_each(|thread| _ = part_with(thread, PATIENCE));
    }
}
