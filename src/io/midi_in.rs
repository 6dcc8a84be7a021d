//! Ports of MIDI: all that there are, or those that are named, as they come and go.
//!
//! A system says nothing when a cable is pulled, so ports are looked for once a second. What came through one that is gone is let go.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use midir::{Ignore, MidiInput, MidiInputConnection};

use super::device::priority;
use crate::live::board::Board;
use crate::live::signal::{Handle, Signal};
use crate::midi::{Message, Parser};

#[cfg(all(target_os = "linux", feature = "midi-jack"))]
mod gaps;
mod roster;
mod unknown;

#[cfg(all(target_os = "linux", feature = "midi-jack"))]
use gaps::Gaps;
use roster::Roster;
pub use unknown::Unknown;
use unknown::fits;

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

/// How often it looks whether it is to stop.
const GLANCE: Duration = Duration::from_millis(50);

struct Open {
    id: String,
    name: Arc<str>,
    number: u16,
    _connection: MidiInputConnection<Line>,
}

/// Hears what comes through a port, by its number and its name; `None` where the port is gone.
pub type Ear = Arc<dyn Fn(u16, &Arc<str>, Option<Message>) + Send + Sync>;

/// What a port's callback has.
struct Line {
    number: u16,
    name: Arc<str>,
    parser: Parser,
    ear: Ear,
    /// Where it counts what it cannot use.
    board: Option<Arc<Board>>,
    /// Whether its thread has asked for priority.
    raised: bool,
}

impl Line {
    fn hear(&mut self, bytes: &[u8]) {
        // In the thread of the port, which is the system's.
        if !std::mem::replace(&mut self.raised, true) {
            priority::raise_feeding();
        }
        let (ear, number, name) = (&self.ear, self.number, &self.name);
        let before = self.parser.counts();
        self.parser.read(bytes, &mut |message| ear(number, name, Some(message)));
        if let Some(board) = &self.board {
            board.midi.parsed(&self.parser.counts(), &before);
        }
    }
}

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
    pub fn listen(
        handle: &Handle,
        wanted: Option<String>,
        news: Box<dyn FnMut(PortNews) + Send>,
    ) -> std::io::Result<Self> {
        let handle = handle.clone();
        let board = Arc::clone(handle.board());
        let ear = move |number: u16, name: &Arc<str>, message: Option<Message>| {
            let signal = message.map_or(Signal::MidiGone(number), |message| Signal::Midi(number, message));
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
        mut news: Box<dyn FnMut(PortNews) + Send>,
    ) -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let look = move || {
            let mut open: Vec<Open> = Vec::new();
            let mut refused: Vec<String> = Vec::new();
            let mut roster = Roster::default();
            let (mut without, mut known) = (false, false);
            #[cfg(all(target_os = "linux", feature = "midi-jack"))]
            let mut gaps = None;
            while !stopped.load(Ordering::Acquire) {
                match input() {
                    Ok(input) => {
                        without = false;
                        #[cfg(all(target_os = "linux", feature = "midi-jack"))]
                        if let Some(board) =
                            board.as_ref().filter(|_| gaps.as_ref().is_none_or(Gaps::is_over))
                        {
                            gaps = Gaps::count(board);
                        }
                        let state = |number, name: &str| Line {
                            number,
                            name: name.into(),
                            parser: Parser::new(),
                            ear: Arc::clone(&ear),
                            board: board.clone(),
                            raised: false,
                        };
                        release(&input, &mut open, &mut roster, &ear, &mut news);
                        search(&input, &wanted, &mut open, &mut refused, &mut roster, &state, &mut news);
                        known |= !open.is_empty();
                        let unknown = wanted.as_ref().filter(|_| !known);
                        if let Some(unknown) = unknown.and_then(|name| Unknown::of(name, &usable(&input))) {
                            known = true;
                            news(PortNews::Unknown(unknown));
                        }
                    }
                    Err(error) => {
                        #[cfg(all(target_os = "linux", feature = "midi-jack"))]
                        drop(gaps.take());
                        if !std::mem::replace(&mut without, true) {
                            news(PortNews::None(error));
                        }
                    }
                }
                let mut waited = Duration::ZERO;
                while waited < EVERY && !stopped.load(Ordering::Acquire) {
                    std::thread::sleep(GLANCE);
                    waited += GLANCE;
                }
            }
        };
        let thread = std::thread::Builder::new().name("midi ports".into()).spawn(look)?;
        Ok(Self { stop, thread: Some(thread) })
    }
}

impl Drop for MidiPorts {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // One that has panicked has nothing more to say.
            let _ = thread.join();
        }
    }
}

/// Lets go of ports that are gone.
fn release(
    input: &MidiInput,
    open: &mut Vec<Open>,
    roster: &mut Roster,
    ear: &Ear,
    news: &mut Box<dyn FnMut(PortNews) + Send>,
) {
    let ports = input.ports();
    open.retain(|port| {
        let stays = ports.iter().any(|there| there.id() == port.id);
        if !stays {
            roster.leave(&port.id);
            ear(port.number, &port.name, None);
            news(PortNews::Gone(port.name.to_string()));
        }
        stays
    });
}

/// What the program itself offers, or the system's loop-back, would answer to itself.
fn is_through(name: &str) -> bool {
    name.starts_with("Midi Through")
}

/// The names of the ports that may be listened to.
fn usable(input: &MidiInput) -> Vec<String> {
    let names = input.ports().into_iter().filter_map(|port| input.port_name(&port).ok());
    names.filter(|name| !is_through(name)).collect()
}

/// Opens ports that are new.
fn search(
    input: &MidiInput,
    wanted: &Option<String>,
    open: &mut Vec<Open>,
    refused: &mut Vec<String>,
    roster: &mut Roster,
    line: &dyn Fn(u16, &str) -> Line,
    news: &mut Box<dyn FnMut(PortNews) + Send>,
) {
    let ports = input.ports();
    refused.retain(|id| ports.iter().any(|there| there.id() == *id));
    for port in &ports {
        let (id, name) = (port.id(), input.port_name(port).unwrap_or_default());
        let fits = wanted.as_ref().is_none_or(|part| fits(part, &name));
        let known = roster.has(&id) || refused.contains(&id);
        if !fits || known || is_through(&name) {
            continue;
        }
        let Ok(mut input) = self::input() else { continue };
        input.ignore(Ignore::None);
        let number = roster.seat(&id, &name);
        match input.connect(port, "in", |_, bytes, line| line.hear(bytes), line(number, &name)) {
            Ok(connection) => {
                open.push(Open { id, name: name.as_str().into(), number, _connection: connection });
                news(PortNews::Opened(name));
            }
            Err(error) => {
                roster.leave(&id);
                refused.push(id);
                news(PortNews::Refused(name, error.to_string()));
            }
        }
    }
}

#[cfg(test)]
mod tests {

    use super::{Arc, Board, Line, Message, Parser};
    use std::sync::Mutex;

    #[test]
    fn what_comes_cut_anywhere_is_heard_and_what_makes_no_message_is_counted() {
        let heard: Arc<Mutex<Vec<(u16, Message)>>> = Arc::default();
        let (board, keeps) = (Arc::new(Board::new(1)), Arc::clone(&heard));
        let ear = move |number, _: &Arc<str>, message: Option<Message>| {
            keeps.lock().unwrap().extend(message.map(|message| (number, message)));
        };
        let mut line = Line {
            number: 3,
            name: "Keys".into(),
            parser: Parser::new(),
            ear: Arc::new(ear),
            board: Some(Arc::clone(&board)),
            raised: true,
        };
        // Running status across packets, a system exclusive message in a hundred of them with a clock within, and a stray byte.
        [&[0x90][..], &[60], &[1, 61], &[2], &[0xF0]].into_iter().for_each(|bytes| line.hear(bytes));
        (0..100).for_each(|_| line.hear(&[1; 100]));
        [&[0xF8][..], &[7; 9], &[0xF7, 5], &[0x80, 60, 0]].into_iter().for_each(|bytes| line.hear(bytes));
        let heard = heard.lock().unwrap();
        assert_eq!(heard.len(), 4);
        assert!(heard.iter().all(|(number, _)| *number == 3));
        let counts = [&board.midi.malformed, &board.midi.skipped].map(|figure| figure.get());
        assert_eq!(counts, [1, 1]);
    }
}
