//! JACK's ports: one client hears all of them, in the server's own callback, where each message has its frame within the period.
//!
//! What comes within a period is handed on at its beginning. It counts as having come at its frame all the same, so that a period adds to the
//! latency, and not to the jitter.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use jack::{
    AsyncClient, Client, ClientOptions, ClientStatus, Control, MidiIn, NotificationHandler, Port, PortFlags,
    PortId, ProcessHandler, ProcessScope,
};
use ringbuf::traits::{Consumer, Producer, Split};
use ringbuf::{HeapCons, HeapProd, HeapRb};

use super::bell::Bell;
use super::line::Line;
use super::source::Source;
use crate::io::device::jack_turn::{DEAD, Stay, stay, turn};
use crate::live::board::Board;
use crate::performer::PORTS;

/// A client of the server, as long as that runs.
pub(super) struct System {
    client: AsyncClient<Watcher, Ears>,
    open: Vec<Open>,
    asks: HeapProd<Ask>,
    back: HeapCons<Ear>,
    lost: Arc<Mutex<Vec<u64>>>,
    over: Arc<AtomicBool>,
    broken: Arc<AtomicBool>,
    /// Ports that were opened so far.
    count: u64,
    /// Dropped last.
    stay: Stay,
}

/// A port that is listened to.
struct Open {
    id: String,
    /// Of ours.
    number: u64,
}

/// One of our ports, and whoever hears it.
struct Ear {
    number: u64,
    port: Port<MidiIn>,
    line: Line,
}

/// What the callback is to do.
enum Ask {
    Hear(Ear),
    /// Give back what has this number.
    Part(u64),
}

/// The callback.
struct Ears {
    ears: Vec<Ear>,
    asks: HeapCons<Ask>,
    back: HeapProd<Ear>,
    /// Whether whoever listens has panicked: nothing is told any more.
    broken: Arc<AtomicBool>,
}

/// Room for what is asked of it in a period: all ports to be opened, and all to be let go of.
const ROOM: usize = 2 * PORTS;

/// So long a callback may take to give a port back.
const PATIENCE: Duration = Duration::from_millis(500);

/// What our ports are called, before their numbers.
const PORT: &str = "in ";

const MIDI: &str = "8 bit raw midi";

struct Watcher {
    /// Where it counts what is left out.
    board: Option<Arc<Board>>,
    over: Arc<AtomicBool>,
    /// Which of our ports nothing is connected to any more.
    lost: Arc<Mutex<Vec<u64>>>,
    bell: Arc<Bell>,
    /// What the names of our ports begin with, up to their numbers.
    own: String,
}

impl NotificationHandler for Watcher {
    // SAFETY: JACK calls it where nothing but what is safe in a signal handler may be done: a flag is set.
    unsafe fn shutdown(&mut self, _: ClientStatus, _: &str) {
        self.over.store(true, Ordering::Release);
    }

    fn xrun(&mut self, _: &Client) -> Control {
        if let Some(board) = &self.board {
            board.midi.gaps.add(1);
        }
        Control::Continue
    }

    fn port_registration(&mut self, client: &Client, port: PortId, _: bool) {
        let Some(port) = client.port_by_id(port) else { return };
        if port.flags().contains(PortFlags::IS_OUTPUT) {
            self.bell.ring();
        }
    }

    fn ports_connected(&mut self, client: &Client, _: PortId, to: PortId, are_connected: bool) {
        let name = client.port_by_id(to).filter(|_| !are_connected).and_then(|port| port.name().ok());
        let number = name.and_then(|name| name.strip_prefix(&self.own)?.parse().ok());
        if let Some(number) = number {
            self.lost.lock().unwrap_or_else(PoisonError::into_inner).push(number);
            self.bell.ring();
        }
    }
}

impl ProcessHandler for Ears {
    fn process(&mut self, client: &Client, scope: &ProcessScope) -> Control {
        if self.broken.load(Ordering::Acquire) {
            return Control::Continue;
        }
        // JACK would end the thread that calls, while another closes the client.
        if let Err(panic) = catch_unwind(AssertUnwindSafe(|| self.hear(client, scope))) {
            std::mem::forget(panic);
            self.broken.store(true, Ordering::Release);
        }
        Control::Continue
    }
}

impl Ears {
    /// What came in a period.
    fn hear(&mut self, client: &Client, scope: &ProcessScope) {
        while let Some(ask) = self.asks.try_pop() {
            match ask {
                // There is room for all that may be open.
                Ask::Hear(ear) if self.ears.len() < self.ears.capacity() => self.ears.push(ear),
                Ask::Hear(ear) => give_back(&mut self.back, ear),
                Ask::Part(number) => {
                    if let Some(at) = self.ears.iter().position(|ear| ear.number == number) {
                        let ear = self.ears.swap_remove(at);
                        give_back(&mut self.back, ear);
                    }
                }
            }
        }
        if self.ears.is_empty() {
            return;
        }
        let begin = client.frames_to_time(scope.last_frame_time());
        let rate = f64::from(client.sample_rate().max(1));
        let (now, here) = (client.time(), Instant::now());
        for Ear { port, line, .. } in &mut self.ears {
            for message in port.iter(scope) {
                let micros = f64::from(message.time) / rate * 1e6;
                line.hear(message.bytes, at(here, now, begin, micros));
            }
        }
    }
}

/// Hands something to the thread that may free it. There is room for everything that there is.
fn give_back(back: &mut HeapProd<Ear>, ear: Ear) {
    if let Err(ear) = back.try_push(ear) {
        std::mem::forget(ear);
    }
}

/// When something came, or will have come, that lies `micros` behind `begin`, on a clock that shows `now` while it is `here`.
fn at(here: Instant, now: u64, begin: u64, micros: f64) -> Instant {
    let since = (begin as i64).wrapping_sub(now as i64) as f64 + micros;
    let away = Duration::from_secs_f64((since.abs() * 1e-6).min(1.0));
    match since >= 0.0 {
        true => here + away,
        false => here.checked_sub(away).unwrap_or(here),
    }
}

fn loaded() -> Result<(), String> {
    crate::io::device::hush::hush_jack()
        .map_err(|why| format!("JACK's library is missing ({why}): sudo apt install libjack-jackd2-0"))
}

fn client(name: &str) -> Result<Client, String> {
    let (client, _) = Client::new(name, ClientOptions::NO_START_SERVER).map_err(|error| {
        format!("no JACK server answers ({error}): start it, jackd -d alsa, or the program under pw-jack")
    })?;
    Ok(client)
}

/// Ports that may be listened to.
///
/// # Errors
/// Where no server answers.
pub(super) fn sources() -> Result<Vec<Source>, String> {
    loaded()?;
    let _turn = turn().ok_or(DEAD)?;
    Ok(listed(&client("pacinian_list")?))
}

fn listed(client: &Client) -> Vec<Source> {
    let names = client.ports(None, Some(MIDI), PortFlags::IS_OUTPUT);
    names.into_iter().map(|name| Source { id: name.clone(), kind: name.clone(), name }).collect()
}

impl System {
    /// A client that hears nothing so far. It rings when ports come or go.
    ///
    /// # Errors
    /// Where no server answers.
    pub fn open(board: Option<&Arc<Board>>, bell: &Arc<Bell>) -> Result<Self, String> {
        loaded()?;
        let rings = Arc::clone(bell);
        let (_turn, stay) = stay(move || rings.ring()).ok_or(DEAD)?;
        let client = client("pacinian_midi")?;
        let (lost, over) = (Arc::<Mutex<Vec<u64>>>::default(), Arc::<AtomicBool>::default());
        let (asks, asked) = HeapRb::new(ROOM).split();
        let (given, back) = HeapRb::new(ROOM).split();
        let watcher = Watcher {
            board: board.cloned(),
            over: Arc::clone(&over),
            lost: Arc::clone(&lost),
            bell: Arc::clone(bell),
            own: format!("{}:{PORT}", client.name()),
        };
        let broken = Arc::<AtomicBool>::default();
        let ears =
            Ears { ears: Vec::with_capacity(PORTS), asks: asked, back: given, broken: Arc::clone(&broken) };
        let client = client.activate_async(watcher, ears).map_err(|error| error.to_string())?;
        Ok(Self { client, open: Vec::new(), asks, back, lost, over, broken, count: 0, stay })
    }

    /// Ports that may be listened to.
    ///
    /// # Errors
    /// None, here.
    pub fn sources(&self) -> Result<Vec<Source>, String> {
        Ok(listed(self.client.as_client()))
    }

    /// Whether nothing comes any more.
    pub fn is_over(&self) -> bool {
        self.broken.load(Ordering::Acquire) || self.is_without_server()
    }

    fn is_without_server(&self) -> bool {
        self.over.load(Ordering::Acquire) || self.stay.is_dead()
    }

    /// How far ahead of now what it hands on may be: a period.
    pub fn ahead(&self) -> Duration {
        let client = self.client.as_client();
        Duration::from_secs_f64(f64::from(client.buffer_size()) / f64::from(client.sample_rate().max(1)))
    }

    /// Ports that were connected and are not any more, though another may have their names.
    pub fn lost(&self) -> Vec<String> {
        let lost = std::mem::take(&mut *self.lost.lock().unwrap_or_else(PoisonError::into_inner));
        self.open.iter().filter(|open| lost.contains(&open.number)).map(|open| open.id.clone()).collect()
    }

    /// Listens to a port.
    ///
    /// # Errors
    /// One that is gone, or a server that has no room.
    pub fn connect(&mut self, source: &Source, line: Line) -> Result<(), String> {
        self.count += 1;
        let (number, client) = (self.count, self.client.as_client());
        let port =
            client.register_port(&format!("{PORT}{number}"), MidiIn::default()).map_err(|e| e.to_string())?;
        let own = port.name().map_err(|error| error.to_string())?;
        if let Err(Ask::Hear(Ear { port, .. })) = self.asks.try_push(Ask::Hear(Ear { number, port, line })) {
            let _ = client.unregister_port(port);
            return Err("JACK's callback does not run".into());
        }
        self.open.push(Open { id: source.id.clone(), number });
        client.connect_ports_by_name(&source.id, &own).map_err(|error| {
            self.disconnect(&source.id);
            error.to_string()
        })
    }

    /// Listens to it no more; nothing of it is heard from here on, unless the server stands still.
    pub fn disconnect(&mut self, id: &str) {
        let Some(at) = self.open.iter().position(|open| open.id == id) else { return };
        let number = self.open.swap_remove(at).number;
        if self.asks.try_push(Ask::Part(number)).is_err() {
            return;
        }
        let begin = Instant::now();
        while begin.elapsed() < PATIENCE && !self.is_over() {
            let mut parted = false;
            while let Some(Ear { number: given, port, .. }) = self.back.try_pop() {
                parted |= given == number;
                // It goes with the client in any case.
                let _ = self.client.as_client().unregister_port(port);
            }
            if parted {
                return;
            }
            std::thread::sleep(Duration::from_millis(1));
        }
    }

    /// Where the server has ended, JACK's library crashes when one takes leave of it: the client stays.
    pub fn abandon(self) {
        if !self.is_without_server() {
            return;
        }
        let Self { client, stay, .. } = self;
        std::mem::forget(client);
        drop(stay);
    }
}
