//! Ports of MIDI: all that there are, or those that are named, as they come and go.
//!
//! A system says nothing when a cable is pulled, so ports are looked for once a second. What came through one that is gone is let go.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use midir::{Ignore, MidiInput, MidiInputConnection};

use crate::live::signal::{Handle, Signal};
use crate::midi::{Message, Parser};

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
    name: String,
    number: u16,
    _connection: MidiInputConnection<Line>,
}

/// Hears what comes through a port, by its number and its name; `None` where the port is gone.
pub type Ear = Arc<dyn Fn(u16, &str, Option<Message>) + Send + Sync>;

/// What a port's callback has.
struct Line {
    number: u16,
    name: String,
    parser: Parser,
    ear: Ear,
}

impl Line {
    fn hear(&mut self, bytes: &[u8]) {
        let (ear, number, name) = (&self.ear, self.number, &self.name);
        self.parser.read(bytes, &mut |message| ear(number, name, Some(message)));
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
    MidiInput::new("pacinian").map_err(|error| error.to_string())
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
        let ear = move |number: u16, _: &str, message: Option<Message>| {
            let signal = message.map_or(Signal::MidiGone(number), |message| Signal::Midi(number, message));
            // What finds no room is counted there.
            let _ = handle.send(signal);
        };
        Self::hear(Arc::new(ear), wanted, news)
    }

    /// The same for any listener.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub fn hear(
        ear: Ear,
        wanted: Option<String>,
        mut news: Box<dyn FnMut(PortNews) + Send>,
    ) -> std::io::Result<Self> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopped = Arc::clone(&stop);
        let look = move || {
            let mut open: Vec<Open> = Vec::new();
            let mut refused: Vec<String> = Vec::new();
            let mut without = false;
            while !stopped.load(Ordering::Acquire) {
                match input() {
                    Ok(input) => {
                        without = false;
                        search(&input, &wanted, &mut open, &mut refused, &ear, &mut news);
                    }
                    Err(error) => {
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

/// Lets go of ports that are gone, and opens those that are new.
fn search(
    input: &MidiInput,
    wanted: &Option<String>,
    open: &mut Vec<Open>,
    refused: &mut Vec<String>,
    ear: &Ear,
    news: &mut Box<dyn FnMut(PortNews) + Send>,
) {
    let ports = input.ports();
    let there: Vec<(String, String)> =
        ports.iter().map(|port| (port.id(), input.port_name(port).unwrap_or_default())).collect();
    open.retain(|port| {
        let stays = there.iter().any(|(id, _)| *id == port.id);
        if !stays {
            ear(port.number, &port.name, None);
            news(PortNews::Gone(port.name.clone()));
        }
        stays
    });
    refused.retain(|id| there.iter().any(|(there, _)| there == id));
    for (port, (id, name)) in ports.iter().zip(&there) {
        let fits = wanted.as_ref().is_none_or(|part| name.to_lowercase().contains(&part.to_lowercase()));
        // What the program itself offers, or the system's loop-back, would answer to itself.
        let known = open.iter().any(|port| port.id == *id) || refused.contains(id);
        if !fits || known || name.starts_with("Midi Through") {
            continue;
        }
        let Ok(mut line) = self::input() else { continue };
        line.ignore(Ignore::None);
        // Lowest first, so that a port that comes back has the number it had.
        let number = (0..u16::MAX).find(|n| open.iter().all(|port| port.number != *n)).unwrap_or(u16::MAX);
        let state = Line { number, name: name.clone(), parser: Parser::new(), ear: Arc::clone(ear) };
        match line.connect(port, "in", |_, bytes, line| line.hear(bytes), state) {
            Ok(connection) => {
                open.push(Open { id: id.clone(), name: name.clone(), number, _connection: connection });
                news(PortNews::Opened(name.clone()));
            }
            Err(error) => {
                refused.push(id.clone());
                news(PortNews::Refused(name.clone(), error.to_string()));
            }
        }
    }
}
