//! ALSA's sequencer: one client hears all ports, and what comes has the time at which the kernel had it.
//!
//! The sequencer announces ports that come and go, hands on system exclusive messages in the pieces in which they arrive, and says when it has
//! dropped something because it was not fetched in time.

use std::ffi::CStr;
use std::io::PipeWriter;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use alsa::seq::{Addr, ClientIter, PortCap, PortInfo, PortIter, PortSubscribe, PortType, Seq};
use rustix::io::Errno;

use super::bell::Bell;
use super::line::Line;
use super::source::Source;
use crate::io::parting::part_with;
use crate::live::board::Board;

mod reader;
mod times;

use reader::Reader;

/// What is listened to. The reader looks there for whom something is.
type Ears = Arc<Mutex<Vec<Ear>>>;

/// Whoever listens to a port.
struct Ear {
    addr: Addr,
    line: Line,
    /// Whether the kernel has said that it is connected; what was disconnected before was another.
    settled: bool,
    /// Whether it is not connected any more.
    lost: bool,
}

/// The sequencer, with a client of ours.
pub(super) struct System {
    control: Seq,
    /// Where everything comes in.
    inlet: Addr,
    ears: Ears,
    /// Whether connections may have been lost that nobody has told of.
    doubt: Arc<AtomicBool>,
    over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
    /// Without it the reader ends.
    hold: Option<PipeWriter>,
}

/// Why a port is not connected.
enum Trouble {
    /// It is already, or another has it for itself.
    Busy,
    Other(alsa::Error),
}

const NAME: &CStr = c"pacinian";

/// Events that may wait for the reader: as many as the kernel allows.
const POOL: u32 = 2000;

/// Bytes that are fetched at once: more than the pool holds, or a long message would never come out of it.
const BUFFER: u32 = 1 << 17;

/// ALSA's own client, of timers and announcements.
const SYSTEM: i32 = 0;

fn opened() -> Result<Seq, String> {
    crate::io::device::hush::hush();
    Seq::open(None, None, true).map_err(|error| refused(error.errno().abs()))
}

/// What is to be done where the sequencer cannot be opened.
fn refused(errno: i32) -> String {
    match Errno::from_raw_os_error(errno) {
        Errno::NOENT | Errno::NODEV | Errno::NXIO => {
            "there is no /dev/snd/seq: load the sequencer, sudo modprobe snd-seq, or plug an instrument in"
                .into()
        }
        Errno::ACCESS | Errno::PERM => {
            "no access to /dev/snd/seq: sudo usermod -aG audio $USER, and log in again".into()
        }
        other => format!("ALSA's sequencer cannot be opened: {other}"),
    }
}

/// Ports that may be listened to.
///
/// # Errors
/// Where there is no sequencer.
pub(super) fn sources() -> Result<Vec<Source>, String> {
    Ok(listed(&opened()?, &[]))
}

/// Ports of others that anybody may listen to.
fn listed(seq: &Seq, own: &[i32]) -> Vec<Source> {
    let readable = PortCap::READ | PortCap::SUBS_READ;
    let clients = ClientIter::new(seq).filter(|client| !own.contains(&client.get_client()));
    let others = clients.filter(|client| client.get_client() != SYSTEM);
    let of_client = |client: alsa::seq::ClientInfo| {
        let name = client.get_name().unwrap_or_default().to_string();
        let ports = PortIter::new(seq, client.get_client());
        let may = move |port: &PortInfo| {
            let caps = port.get_capability();
            // An endpoint of MIDI 2.0 says again what its ports say.
            let kinds = PortType::MIDI_GENERIC | PortType::SYNTH | PortType::APPLICATION;
            let is_midi = port.get_type().intersects(kinds);
            is_midi && caps.contains(readable) && !caps.contains(PortCap::NO_EXPORT)
        };
        let source = move |port: PortInfo| {
            let (id, kind) = (id(port.addr()), format!("{name}:{}", port.get_name().unwrap_or_default()));
            Source { name: format!("{kind} {id}"), id, kind }
        };
        ports.filter(may).map(source).collect::<Vec<_>>()
    };
    others.flat_map(of_client).collect()
}

fn id(addr: Addr) -> String {
    format!("{}:{}", addr.client, addr.port)
}

/// Where everything comes in, with the time of a queue, if there is one.
fn inlet(seq: &Seq, queue: Option<i32>) -> alsa::Result<Addr> {
    let mut port = PortInfo::empty()?;
    port.set_name(c"in");
    port.set_capability(PortCap::WRITE | PortCap::SUBS_WRITE);
    port.set_type(PortType::MIDI_GENERIC | PortType::APPLICATION);
    port.set_midi_channels(16);
    if let Some(queue) = queue {
        port.set_timestamping(true);
        port.set_timestamp_real(true);
        port.set_timestamp_queue(queue);
    }
    seq.create_port(&port)?;
    Ok(Addr { client: seq.client_id()?, port: port.get_port() })
}

/// Has the sequencer announce ports that come and go.
fn hear_news(seq: &Seq) -> alsa::Result<()> {
    let news = seq.create_simple_port(c"news", PortCap::WRITE | PortCap::NO_EXPORT, PortType::APPLICATION)?;
    seq.subscribe_port(&link(Addr::system_announce(), Addr { client: seq.client_id()?, port: news })?)
}

fn link(sender: Addr, dest: Addr) -> alsa::Result<PortSubscribe> {
    let link = PortSubscribe::empty()?;
    link.set_sender(sender);
    link.set_dest(dest);
    Ok(link)
}

impl System {
    /// A client that hears nothing so far. It rings when ports come or go.
    ///
    /// # Errors
    /// Where there is no sequencer, or it has no room.
    pub fn open(board: Option<&Arc<Board>>, bell: &Arc<Bell>) -> Result<Self, String> {
        let full = |error: alsa::Error| format!("ALSA's sequencer has no room for a client: {error}");
        let (control, seq) = (opened()?, opened()?);
        control.set_client_name(c"pacinian control").map_err(full)?;
        seq.set_client_name(NAME).map_err(full)?;
        // Where the kernel gives less, it holds less.
        let _ = seq.set_client_pool_input(POOL);
        seq.input().set_input_buffer_size(BUFFER).map_err(full)?;
        let queue = times::queue(&seq);
        let inlet = inlet(&seq, queue).map_err(full)?;
        hear_news(&seq).map_err(full)?;
        let (end, hold) = std::io::pipe().map_err(|error| error.to_string())?;
        let (ears, doubt, over) = (Ears::default(), Arc::default(), Arc::default());
        let reader = Reader {
            seq,
            queue,
            inlet,
            ears: Arc::clone(&ears),
            doubt: Arc::clone(&doubt),
            over: Arc::clone(&over),
            bell: Arc::clone(bell),
            board: board.cloned(),
        };
        let thread = std::thread::Builder::new().name("midi in".into()).spawn(move || reader.read(end));
        let thread = Some(thread.map_err(|error| format!("the system has no thread left: {error}"))?);
        Ok(Self { control, inlet, ears, doubt, over, thread, hold: Some(hold) })
    }

    /// Ports that may be listened to.
    ///
    /// # Errors
    /// None, here.
    pub fn sources(&self) -> Result<Vec<Source>, String> {
        let own = [self.inlet.client, self.control.client_id().unwrap_or(self.inlet.client)];
        Ok(listed(&self.control, &own))
    }

    /// Whether nothing is heard any more.
    pub fn is_over(&self) -> bool {
        self.over.load(Ordering::Acquire)
    }

    /// How far ahead of now what it hands on may be.
    pub fn ahead(&self) -> Duration {
        Duration::ZERO
    }

    /// Ports that were connected and are not any more, though another may have their ids.
    pub fn lost(&self) -> Vec<String> {
        if self.doubt.swap(false, Ordering::AcqRel) {
            self.ask_again();
        }
        self.ears().iter().filter(|ear| ear.lost).map(|ear| id(ear.addr)).collect()
    }

    /// The sequencer dropped what it had to tell: what is still connected refuses to be connected a second time.
    fn ask_again(&self) {
        for ear in &mut *self.ears() {
            ear.lost |= !matches!(self.subscribe(ear.addr), Err(Trouble::Busy));
            ear.settled = true;
        }
    }

    /// Listens to a port.
    ///
    /// # Errors
    /// One that is gone, or lets nobody listen any more.
    pub fn connect(&mut self, source: &Source, line: Line) -> Result<(), String> {
        let sender: Addr = source.id.parse().map_err(|_| format!("`{}` is no address of ALSA", source.id))?;
        self.ears().push(Ear { addr: sender, line, settled: false, lost: false });
        // Somebody else may have connected it already, which is done anew, so that the kernel says so. Otherwise another has it for itself.
        let connected = match self.subscribe(sender) {
            Err(Trouble::Busy) if self.control.unsubscribe_port(sender, self.inlet).is_ok() => {
                self.subscribe(sender)
            }
            other => other,
        };
        connected.map_err(|trouble| {
            self.ears().retain(|ear| ear.addr != sender);
            match trouble {
                Trouble::Busy => "another program has it for itself".into(),
                Trouble::Other(error) => error.to_string(),
            }
        })
    }

    fn subscribe(&self, sender: Addr) -> Result<(), Trouble> {
        let subscribed = link(sender, self.inlet).and_then(|link| self.control.subscribe_port(&link));
        subscribed.map_err(|error| match error.errno().abs() == Errno::BUSY.raw_os_error() {
            true => Trouble::Busy,
            false => Trouble::Other(error),
        })
    }

    /// Listens to it no more; nothing of it is heard from here on.
    pub fn disconnect(&mut self, id: &str) {
        let Ok(sender) = id.parse::<Addr>() else { return };
        // Where the port is gone, so is what was connected to it.
        let _ = self.control.unsubscribe_port(sender, self.inlet);
        self.ears().retain(|ear| ear.addr != sender);
    }

    /// What there was is gone with it.
    pub fn abandon(self) {}

    fn ears(&self) -> MutexGuard<'_, Vec<Ear>> {
        self.ears.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for System {
    fn drop(&mut self) {
        // Nothing is heard from here on, however much comes.
        self.ears().clear();
        self.hold = None;
        self.thread.take().into_iter().for_each(|thread| _ = part_with(thread, super::PATIENCE));
    }
}

#[cfg(test)]
mod tests {
    use super::{Errno, refused};

    #[test]
    fn what_is_to_be_done_is_said() {
        let said = |errno: Errno| refused(errno.raw_os_error());
        assert!(said(Errno::NOENT).contains("sudo modprobe snd-seq"));
        assert!(said(Errno::ACCESS).contains("sudo usermod -aG audio"));
        assert!(said(Errno::NOMEM).starts_with("ALSA's sequencer cannot be opened: "));
    }
}
