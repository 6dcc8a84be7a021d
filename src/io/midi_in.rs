//! Ports of MIDI: all that there are, or those that are named, as they come and go.
//!
//! A system says nothing when a cable is pulled, so ports are looked for once a second. What came through one that is gone is let go. A cable
//! that has promised to stay, and says nothing any more, shuts the session's output: nobody is there who could stop what it moves.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use midir::{Ignore, MidiInput, MidiInputConnection};

use super::device::priority;
use crate::live::board::Board;
use crate::live::signal::{Handle, Origin, Signal};
use crate::midi::sensing::Sensing;
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
    /// A cable that had promised to stay (active sensing) is lost, with its port or without it.
    Silent(String),
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
    cable: Arc<Cable>,
    connection: MidiInputConnection<Line>,
}

/// What comes through a port.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Word {
    /// A message.
    Message(Message),
    /// Nothing, though the cable had promised to say something: it is lost.
    Silence,
    /// Nothing any more: the port is gone.
    End,
}

/// Hears what comes through a port, by its number and its name.
pub type Ear = Arc<dyn Fn(u16, &Arc<str>, Word) + Send + Sync>;

/// Whether a port's cable is there, and since when its times are counted.
#[derive(Debug)]
struct Cable {
    sensing: Sensing,
    begin: Instant,
}

impl Cable {
    fn new() -> Arc<Self> {
        Arc::new(Self { sensing: Sensing::default(), begin: Instant::now() })
    }

    fn heard(&self) {
        self.sensing.heard(self.begin.elapsed());
    }

    fn is_lost(&self) -> bool {
        self.sensing.is_lost(self.begin.elapsed())
    }
}

/// What a port's callback has.
struct Line {
    number: u16,
    name: Arc<str>,
    parser: Parser,
    ear: Ear,
    cable: Arc<Cable>,
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
        let (ear, number, name, cable) = (&self.ear, self.number, &self.name, &self.cable);
        let (before, now) = (self.parser.counts(), cable.begin.elapsed());
        cable.sensing.heard(now);
        self.parser.read(bytes, &mut |message| {
            cable.sensing.message(now, message);
            ear(number, name, Word::Message(message));
        });
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
        let ear = move |number: u16, name: &Arc<str>, word: Word| {
            let handle = handle.by(name);
            let signal = match word {
                Word::Message(message) => Signal::Midi(number, message),
                Word::Silence => {
                    handle.from(Origin::Cable(number)).panic();
                    Signal::MidiGone(number)
                }
                Word::End => Signal::MidiGone(number),
            };
            // What finds no room is counted there.
            let _ = handle.send(signal);
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
                        if gaps.as_ref().is_some_and(Gaps::is_over) {
                            // Another server answers: the ports of the one before went with it.
                            release(&mut open, &|_| false, &mut roster, &ear, &mut news, true);
                        }
                        #[cfg(all(target_os = "linux", feature = "midi-jack"))]
                        if let Some(board) =
                            board.as_ref().filter(|_| gaps.as_ref().is_none_or(Gaps::is_over))
                        {
                            gaps = Gaps::count(board);
                        }
                        let state = |number, name: &str, cable: &Arc<Cable>| Line {
                            number,
                            name: name.into(),
                            parser: Parser::new(),
                            ear: Arc::clone(&ear),
                            cable: Arc::clone(cable),
                            board: board.clone(),
                            raised: false,
                        };
                        let there = input.ports();
                        release(
                            &mut open,
                            &|port| there.iter().any(|is| is.id() == port.id),
                            &mut roster,
                            &ear,
                            &mut news,
                            false,
                        );
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
                        if let Some(gaps) = gaps.take() {
                            Gaps::server_ended(&gaps);
                        }
                        // A server that has ended took its ports with it.
                        let of_server = cfg!(all(target_os = "linux", feature = "midi-jack"));
                        release(&mut open, &|_| false, &mut roster, &ear, &mut news, of_server);
                        if !std::mem::replace(&mut without, true) {
                            news(PortNews::None(error));
                        }
                    }
                }
                let mut waited = Duration::ZERO;
                while waited < EVERY && !stopped.load(Ordering::Acquire) {
                    let (begin, before) = (Instant::now(), gaps_of(&board));
                    std::thread::sleep(GLANCE);
                    waited += GLANCE;
                    // Where the machine stood still, or the server left something out, silence says nothing.
                    if gaps_of(&board) > before {
                        open.iter().for_each(|port| port.cable.heard());
                    } else if begin.elapsed() < 2 * GLANCE {
                        miss(&open, &ear, &mut news);
                    }
                }
            }
            #[cfg(all(target_os = "linux", feature = "midi-jack"))]
            if gaps.is_some_and(|gaps| gaps.is_over()) {
                std::mem::forget(open);
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

/// Lets go of ports that are gone. `abandoned` says that their server has ended: JACK's library crashes where one takes leave of it then, so that the
/// connections stay.
fn release(
    open: &mut Vec<Open>,
    is_there: &dyn Fn(&Open) -> bool,
    roster: &mut Roster,
    ear: &Ear,
    news: &mut Box<dyn FnMut(PortNews) + Send>,
    abandoned: bool,
) {
    let (stay, gone): (Vec<Open>, Vec<Open>) = std::mem::take(open).into_iter().partition(is_there);
    *open = stay;
    for port in gone {
        roster.leave(&port.id);
        if port.cable.sensing.is_promised() {
            silence(&port, ear, news);
        }
        ear(port.number, &port.name, Word::End);
        news(PortNews::Gone(port.name.to_string()));
        if abandoned {
            std::mem::forget(port.connection);
        }
    }
}

/// Tells of cables that are lost.
fn miss(open: &[Open], ear: &Ear, news: &mut Box<dyn FnMut(PortNews) + Send>) {
    open.iter().filter(|port| port.cable.is_lost()).for_each(|port| silence(port, ear, news));
}

fn silence(port: &Open, ear: &Ear, news: &mut Box<dyn FnMut(PortNews) + Send>) {
    ear(port.number, &port.name, Word::Silence);
    news(PortNews::Silent(port.name.to_string()));
}

/// How many periods were left out so far.
fn gaps_of(board: &Option<Arc<Board>>) -> u64 {
    board.as_ref().map_or(0, |board| board.midi.gaps.get())
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
    line: &dyn Fn(u16, &str, &Arc<Cable>) -> Line,
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
        let (number, cable) = (roster.seat(&id, &name), Cable::new());
        match input.connect(port, "in", |_, bytes, line| line.hear(bytes), line(number, &name, &cable)) {
            Ok(connection) => {
                open.push(Open { id, name: name.as_str().into(), number, cable, connection });
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
    use super::{Arc, Board, Cable, Duration, Ear, Line, Message, Parser, Word};
    use std::sync::Mutex;

    fn line(ear: Ear, board: Option<Arc<Board>>) -> Line {
        let (name, cable) = ("Keys".into(), Cable::new());
        Line { number: 3, name, parser: Parser::new(), ear, cable, board, raised: true }
    }

    #[test]
    fn a_long_dump_shows_that_its_cable_is_there() {
        let mut line = line(Arc::new(|_, _: &Arc<str>, _| ()), None);
        let lost = |line: &Line, later: u64| {
            let now = line.cable.begin.elapsed() + Duration::from_millis(later);
            line.cable.sensing.is_lost(now)
        };
        line.hear(&[0xF0]);
        assert!(!lost(&line, 9_000), "nothing was promised");
        line.hear(&[0xFE]);
        (0..8).for_each(|_| {
            std::thread::sleep(Duration::from_millis(50));
            line.hear(&[1; 64]);
        });
        assert!(!line.cable.is_lost(), "400 ms later, in the middle of it");
        assert!(lost(&line, 301) && !line.cable.sensing.is_promised());
    }

    #[test]
    fn what_comes_cut_anywhere_is_heard_and_what_makes_no_message_is_counted() {
        let heard: Arc<Mutex<Vec<(u16, Message)>>> = Arc::default();
        let (board, keeps) = (Arc::new(Board::new(1)), Arc::clone(&heard));
        let ear = move |number, _: &Arc<str>, word: Word| {
            if let Word::Message(message) = word {
                keeps.lock().unwrap().push((number, message));
            }
        };
        let mut line = line(Arc::new(ear), Some(Arc::clone(&board)));
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
