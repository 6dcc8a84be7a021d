//! Who opens a client of JACK's library, and when: one after the other.
//!
//! A program's clients share a table in the library. Once one of them has heard that the server has ended, the next that is opened frees all others,
//! whoever still holds them (`JackLibGlobals::Init` of JACK 2): nobody opens one until all that are of another server than the one that runs are let go
//! of. And a client hears a moment late that another has gone, and takes that one's place out of use, which by then may be the next one's: who comes to
//! stay lets that moment pass.
//!
//! A server is known by its socket: one that comes in its place makes it anew. Without a socket nobody is dead, as with PipeWire's library of that name,
//! which has no such table.

use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use super::failure::{DeviceError, Trouble};
use super::hosts::JACK;
use super::list::Found;
use super::servers;

/// So long somebody may take to let go of a client that is dead.
const PATIENCE: Duration = Duration::from_secs(2);

/// Within this, clients have heard that another has gone.
const REST: Duration = Duration::from_millis(50);

/// From one look at who still holds one to the next.
const LOOK: Duration = Duration::from_millis(20);

/// Why no client may be opened for now.
pub(crate) const DEAD: &str = "JACK has ended, and its clients here are not closed yet";

/// The library's, as far as this program uses it.
struct Table {
    turn: Mutex<()>,
    clients: Mutex<Clients>,
    /// The socket of the server that runs.
    socket: fn() -> Option<PathBuf>,
}

static TABLE: Table = Table {
    turn: Mutex::new(()),
    clients: Mutex::new(Clients { all: Vec::new(), count: 0 }),
    socket: servers::jack_socket,
};

/// Those that stay.
struct Clients {
    all: Vec<Client>,
    count: u64,
}

struct Client {
    number: u64,
    server: Option<Server>,
    /// Has whoever holds it look whether it is dead.
    call: Box<dyn Fn() + Send>,
}

/// A socket, and what differs where another is made in its place.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Server {
    socket: PathBuf,
    made: (u64, i64, i64),
}

/// While there is one, nobody else opens a client.
pub(crate) struct Turn {
    _turn: MutexGuard<'static, ()>,
}

/// A client that stays, for as long as this is kept: let go of it first.
pub(crate) struct Stay {
    number: u64,
    table: &'static Table,
}

/// To open a client and close it at once; `None` where somebody holds one that is dead.
pub(crate) fn turn() -> Option<Turn> {
    TABLE.turn(Duration::ZERO).map(|(turn, _)| turn)
}

/// To open one that stays. `call` is called, from any thread, where it is dead and in the way.
pub(crate) fn stay(call: impl Fn() + Send + 'static) -> Option<(Turn, Stay)> {
    TABLE.stay(call)
}

/// Whether a device of ALSA is a plug-in that opens a client of JACK's library, by what it is called.
fn is_plugin(id: &str) -> bool {
    id.strip_prefix("alsa:").is_some_and(|name| name.contains(JACK))
}

/// To look at a device of ALSA, which opens a client and closes it at once where it is such a plug-in: then with a turn of its own.
///
/// # Errors
/// Somebody holds a client that is dead.
pub(super) fn look(id: &str) -> Result<Option<Turn>, DeviceError> {
    is_plugin(id).then(|| turn().ok_or_else(dead)).transpose()
}

fn dead() -> DeviceError {
    DeviceError::new(Trouble::Other, DEAD)
}

/// To open one that stays, for a stream of a device; `None` where that is not JACK's.
///
/// # Errors
/// Somebody holds a client that is dead.
pub(super) fn stream(found: &Found) -> Result<Option<(Turn, Stay)>, DeviceError> {
    if found.host() != JACK && !is_plugin(&found.id) {
        return Ok(None);
    }
    stay(|| {}).ok_or_else(dead).map(Some)
}

impl Table {
    fn turn(&'static self, rest: Duration) -> Option<(Turn, Option<Server>)> {
        let turn = Turn { _turn: self.turn.lock().unwrap_or_else(PoisonError::into_inner) };
        // Before anybody looks: a server may end at any time.
        std::thread::sleep(rest);
        let begin = Instant::now();
        loop {
            let server = (self.socket)().and_then(Server::at);
            if !self.call_the_dead(server.as_ref()) {
                return Some((turn, server));
            }
            if begin.elapsed() > PATIENCE {
                return None;
            }
            std::thread::sleep(LOOK);
        }
    }

    fn stay(&'static self, call: impl Fn() + Send + 'static) -> Option<(Turn, Stay)> {
        let (turn, server) = self.turn(REST)?;
        let mut clients = self.clients();
        let number = clients.count;
        clients.count += 1;
        clients.all.push(Client { number, server, call: Box::new(call) });
        Some((turn, Stay { number, table: self }))
    }

    /// Whether there are any, where that server runs.
    fn call_the_dead(&self, server: Option<&Server>) -> bool {
        let clients = self.clients();
        let dead =
            clients.all.iter().filter(|client| client.server.is_some() && client.server.as_ref() != server);
        dead.map(|client| (client.call)()).count() > 0
    }

    fn clients(&self) -> MutexGuard<'_, Clients> {
        self.clients.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Server {
    #[cfg(unix)]
    fn at(socket: PathBuf) -> Option<Self> {
        use std::os::unix::fs::MetadataExt;
        let file = std::fs::metadata(&socket).ok()?;
        Some(Self { socket, made: (file.ino(), file.ctime(), file.ctime_nsec()) })
    }

    #[cfg(not(unix))]
    fn at(_: PathBuf) -> Option<Self> {
        None
    }
}

impl Stay {
    /// Whether another server is there in place of its own.
    #[cfg(any(test, all(feature = "midi-jack", target_os = "linux")))]
    pub fn is_dead(&self) -> bool {
        let clients = self.table.clients();
        let server = clients.all.iter().find(|client| client.number == self.number);
        let there = |server: &Server| Server::at(server.socket.clone()).as_ref() == Some(server);
        !server.and_then(|client| client.server.as_ref()).is_none_or(there)
    }
}

impl Drop for Stay {
    fn drop(&mut self) {
        self.table.clients().all.retain(|client| client.number != self.number);
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::net::UnixListener;
    use std::path::{Path, PathBuf};
    use std::sync::Mutex;
    use std::sync::mpsc::channel;
    use std::time::Duration;

    use super::{Clients, Table, is_plugin};

    #[test]
    fn plug_ins_of_alsa_are_known_by_their_names() {
        assert!(is_plugin("alsa:jack") && is_plugin("alsa:jackcard"));
        assert!(!is_plugin("jack:output") && !is_plugin("alsa:hw:CARD=Device,DEV=0"));
    }

    fn socket() -> PathBuf {
        std::env::temp_dir().join(format!("pacinian-turn-{}", std::process::id()))
    }

    /// As JACK's makes it.
    fn server(at: &Path) -> UnixListener {
        let _ = std::fs::remove_file(at);
        UnixListener::bind(at).unwrap()
    }

    #[test]
    fn nobody_opens_one_until_the_dead_are_let_go_of() {
        let answers = || Some(socket()).filter(|at| std::os::unix::net::UnixStream::connect(at).is_ok());
        let clients = Mutex::new(Clients { all: Vec::new(), count: 0 });
        let table: &'static Table =
            Box::leak(Box::new(Table { turn: Mutex::new(()), clients, socket: answers }));
        let at = socket();
        let first = server(&at);
        let (called, calls) = channel();
        let (turn, midi) = table.stay(move || _ = called.send(())).unwrap();
        drop(turn);
        let (turn, card) = table.stay(|| {}).unwrap();
        drop(turn);
        // While the server runs, anybody may.
        assert!(table.turn(Duration::ZERO).is_some());
        assert!(!midi.is_dead() && !card.is_dead());
        // It is killed: its socket is there still, and nobody hears it.
        drop(first);
        drop(card);
        assert!(table.turn(Duration::ZERO).is_none(), "one is held");
        assert!(calls.try_iter().count() > 1, "and called");
        // And another comes in its place.
        let _second = server(&at);
        assert!(midi.is_dead());
        let letting_go = std::thread::spawn(move || {
            std::thread::sleep(Duration::from_millis(200));
            drop(midi);
        });
        let (turn, again) = table.stay(|| {}).unwrap();
        assert!(letting_go.is_finished());
        drop(turn);
        assert!(!again.is_dead() && table.turn(Duration::ZERO).is_some());
        let _ = std::fs::remove_file(at);
    }
}
