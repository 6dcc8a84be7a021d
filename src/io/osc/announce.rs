//! What is played, told to other programs as it is played: every marker, and to those who ask for more, every voice. Each goes out in a
//! bundle whose time tag is that at which it leaves the converter.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, UdpSocket};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType, encoder};

use super::endpoint::BindError;
use super::peers::{LIFE, MOST_PEERS};
use super::time::Tag;
use crate::graph::plan::Plan;
use crate::io::journal::chronicle::Chronicle;
use crate::io::journal::{Kind, Line};
use crate::live::board::Figure;
use crate::live::conductor::Told;
use crate::live::signal::Stamped;
use crate::performer::Heard;

/// Announcements that may wait to be sent.
const WAITING: usize = 1 << 12;

/// Of so many signals is it known what their senders call what they play.
const TAGS: usize = 1 << 14;

/// So long a system may take to send one.
const PATIENCE: Duration = Duration::from_millis(50);

/// Which announcements somebody wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Wants {
    /// Markers, and what the gate does, without which nobody knows whether they went with anything that was felt.
    Markers,
    /// The same, and voices as they begin and are released.
    All,
}

/// Tells other programs what is played. Clones tell the same programs.
#[derive(Debug, Clone)]
pub struct Announcer(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    chronicle: Mutex<Chronicle>,
    /// What senders call what they play, by the numbers of their signals.
    tags: Mutex<BTreeMap<u64, i64>>,
    guests: Mutex<Vec<Guest>>,
    out: Mutex<Option<SyncSender<Announcement>>>,
    thread: Mutex<Option<JoinHandle<()>>>,
    lost: Arc<Lost>,
}

/// Where something goes in vain, and why, where the system has a reason other than that nobody listens there.
pub type InVain = (SocketAddr, Option<String>);

/// Of so many addresses that is told.
const MOST_IN_VAIN: usize = 64;

/// What did not get where it was to go.
#[derive(Debug, Default)]
struct Lost {
    /// Announcements.
    unsent: Figure,
    /// Where it goes in vain, and how many of those have been told.
    unheard: Mutex<(Vec<InVain>, usize)>,
}

impl Lost {
    /// A system has said that nobody was there for what went to a connected socket last.
    fn refused(&self, socket: &UdpSocket) {
        self.unsent.add(1);
        if let Ok(to) = socket.peer_addr() {
            self.fails(to, None);
        }
    }

    /// It goes there in vain.
    fn fails(&self, to: SocketAddr, why: Option<String>) {
        let mut unheard = locked(&self.unheard);
        if unheard.0.len() < MOST_IN_VAIN && unheard.0.iter().all(|(known, _)| *known != to) {
            unheard.0.push((to, why));
        }
    }
}

#[derive(Debug, Clone)]
struct Guest {
    to: SocketAddr,
    socket: Arc<UdpSocket>,
    /// Whether it hears of markers for good.
    for_good: bool,
    /// Until when it wants markers, and until when all: it may ask for one and for the other, and each ends by itself.
    markers: Option<Instant>,
    all: Option<Instant>,
    /// Whether the socket leads there alone.
    connected: bool,
}

impl Guest {
    /// Whether it hears of what is for those who want so much.
    fn hears(&self, wanted: Wants, now: Instant) -> bool {
        let lasts = |until: Option<Instant>| until.is_some_and(|until| until > now);
        lasts(self.all) || wanted == Wants::Markers && (self.for_good || lasts(self.markers))
    }

    fn invite(&mut self, wants: Wants, until: Instant) {
        match wants {
            Wants::Markers => self.markers = Some(until),
            Wants::All => self.all = Some(until),
        }
    }
}

/// What goes out, and to whom.
type Announcement = (Vec<u8>, Vec<(Arc<UdpSocket>, Option<SocketAddr>)>);

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Whoever panicked while it was held has lost an announcement at most.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Announcer {
    /// For a session that begins with `plan`. It tells nobody anything yet.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub fn new(plan: &Plan) -> std::io::Result<Self> {
        let (out, announcements) = sync_channel(WAITING);
        let lost = Arc::new(Lost::default());
        let missed = Arc::clone(&lost);
        let thread = std::thread::Builder::new()
            .name("osc out".into())
            .spawn(move || send(&announcements, &missed))?;
        Ok(Self(Arc::new(Shared {
            chronicle: Mutex::new(Chronicle::of(plan)),
            tags: Mutex::default(),
            guests: Mutex::default(),
            out: Mutex::new(Some(out)),
            thread: Mutex::new(Some(thread)),
            lost,
        })))
    }

    /// Markers go to this address as long as the session lasts.
    ///
    /// # Errors
    /// A system that gives no socket.
    pub fn always(&self, to: SocketAddr) -> Result<(), BindError> {
        let failed = |error: std::io::Error| BindError::of(to, &error);
        let any: SocketAddr = match to {
            SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
            SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
        };
        let socket = UdpSocket::bind(any).map_err(failed)?;
        socket.set_write_timeout(Some(PATIENCE)).map_err(failed)?;
        // Who names an address of many means them.
        socket.set_broadcast(true).map_err(failed)?;
        // Of such a one alone systems tell that nobody was there. Beyond this machine the way, and with it one's own address, may change.
        let connected = to.ip().is_loopback();
        if connected {
            socket.connect(to).map_err(failed)?;
        }
        locked(&self.0.guests).push(Guest {
            to,
            socket: Arc::new(socket),
            for_good: true,
            markers: None,
            all: None,
            connected,
        });
        Ok(())
    }

    /// For the next [`LIFE`] seconds `to` hears from `socket` of what it wants. Says whether there was room.
    pub(super) fn invite(&self, to: SocketAddr, socket: &Arc<UdpSocket>, wants: Wants) -> bool {
        let now = Instant::now();
        let mut guests = locked(&self.0.guests);
        guests.retain(|guest| guest.hears(Wants::Markers, now));
        let until = now + Duration::from_secs(LIFE);
        if let Some(known) = guests.iter_mut().find(|guest| guest.to == to && !guest.for_good) {
            known.invite(wants, until);
            return true;
        }
        let room = guests.len() < MOST_PEERS;
        if room {
            let socket = Arc::clone(socket);
            let mut guest = Guest { to, socket, for_good: false, markers: None, all: None, connected: false };
            guest.invite(wants, until);
            guests.push(guest);
        }
        room
    }

    /// `to` hears of nothing that it has asked for any more.
    pub(super) fn dismiss(&self, to: SocketAddr) {
        locked(&self.0.guests).retain(|guest| guest.to != to || guest.for_good);
    }

    /// For the listener of the session.
    pub fn hear(&self, heard: &Heard<'_>) {
        locked(&self.0.chronicle).hear(heard);
    }

    /// For its audience.
    pub fn told(&self, told: &Told<'_>) {
        // What came in is not announced; it need not be put into words.
        if let Told::Came(Stamped { id, tag, .. }) = told {
            if let Some(tag) = tag {
                let mut tags = locked(&self.0.tags);
                tags.insert(*id, *tag);
                if tags.len() > TAGS {
                    tags.pop_first();
                }
            }
            return;
        }
        let mut chronicle = locked(&self.0.chronicle);
        let Some(line) = chronicle.told(told) else { return };
        let wanted = match line.kind {
            Kind::Marker | Kind::Cancel | Kind::Gate => Wants::Markers,
            Kind::Voice | Kind::Release | Kind::ReleaseAll | Kind::Silence | Kind::Stolen => Wants::All,
            _ => return,
        };
        let now = Instant::now();
        let guests = locked(&self.0.guests);
        let to: Vec<_> = guests
            .iter()
            .filter(|guest| guest.hears(wanted, now))
            .map(|guest| (Arc::clone(&guest.socket), (!guest.connected).then_some(guest.to)))
            .collect();
        drop(guests);
        if to.is_empty() {
            return;
        }
        let time = line.seconds.and_then(|seconds| chronicle.time(seconds));
        drop(chronicle);
        let tag = line.cause.and_then(|cause| locked(&self.0.tags).get(&cause).copied());
        let number = to.len() as u64;
        let sent = packet(&line, tag, time.map_or(Tag::AT_ONCE, Tag::of)).is_some_and(|bytes| {
            locked(&self.0.out).as_ref().is_some_and(|out| out.try_send((bytes, to)).is_ok())
        });
        self.0.lost.unsent.add(if sent { 0 } else { number });
    }

    /// Where [always](Self::always) something goes in vain, as far as this has not been asked before: on this machine where nobody listens, or where
    /// the system does not send it, with its reason.
    pub fn unheard(&self) -> Vec<InVain> {
        let (at, told) = &mut *locked(&self.0.lost.unheard);
        let new = at.get(*told..).unwrap_or_default().to_vec();
        *told = at.len();
        new
    }

    /// Sends what still waits. Gives how many announcements could not be sent, or went where nobody listened.
    pub fn finish(&self) -> u64 {
        drop(locked(&self.0.out).take());
        if let Some(thread) = locked(&self.0.thread).take() {
            // One that has panicked has nothing more to say.
            let _ = thread.join();
        }
        for guest in locked(&self.0.guests).iter().filter(|guest| guest.connected) {
            if let Ok(Some(_)) = guest.socket.take_error() {
                self.0.lost.refused(&guest.socket);
            }
        }
        self.0.lost.unsent.get()
    }
}

fn send(announcements: &Receiver<Announcement>, lost: &Lost) {
    for (bytes, guests) in announcements {
        for (socket, to) in guests {
            let sent = match to {
                Some(to) => socket.send_to(&bytes, to),
                None => socket.send(&bytes).or_else(|error| {
                    if error.kind() != ErrorKind::ConnectionRefused {
                        return Err(error);
                    }
                    // That is said of what went before, in place of sending this.
                    lost.refused(&socket);
                    socket.send(&bytes)
                }),
            };
            if let Err(error) = sent {
                lost.unsent.add(1);
                if let Some(to) = to.or_else(|| socket.peer_addr().ok()) {
                    lost.fails(to, Some(error.to_string()));
                }
            }
        }
    }
}

/// A bundle with one message, of what its sender calls `called`.
fn packet(line: &Line, called: Option<i64>, tag: Tag) -> Option<Vec<u8>> {
    let text = |text: &Option<String>| OscType::String(text.clone().unwrap_or_default());
    let number = |number: Option<u64>| OscType::Long(number.unwrap_or(0) as i64);
    let real = |number: Option<f64>, missing: f64| OscType::Double(number.unwrap_or(missing));
    let name = text(&line.name);
    let (sample, seconds) = (number(line.sample), real(line.seconds, 0.0));
    let (pattern, event) = (text(&line.pattern), number(line.event));
    let cause = number(line.cause);
    let bits = OscType::Int(line.value.unwrap_or(0.0) as i32);
    let (addr, args) = match line.kind {
        Kind::Marker => ("/marker", vec![name, sample, seconds, pattern, event, number(line.id), cause]),
        Kind::Cancel => ("/cancel", vec![number(line.id), bits, sample, seconds]),
        Kind::Silence => ("/event/silence", vec![number(line.id), bits, sample, seconds]),
        Kind::ReleaseAll => ("/event/release-all", vec![sample, seconds]),
        Kind::Gate => {
            let gain = line.value.map(OscType::Double);
            ("/gate", [name, number(line.frame), seconds, cause].into_iter().chain(gain).collect())
        }
        Kind::Voice => {
            let (level, duration) = (real(line.level, 0.0), real(line.duration, f64::INFINITY));
            let (id, place) = (number(line.id), text(&line.place));
            let (gains, felt) = (text(&line.gains), real(line.felt, f64::NAN));
            let called = OscType::Long(called.unwrap_or(0));
            let stands = [name, id, sample, seconds, place, level, duration, pattern, event];
            ("/event/voice", stands.into_iter().chain([gains, felt, cause, called]).collect())
        }
        Kind::Stolen => ("/event/stolen", vec![number(line.id), sample, seconds, text(&line.message)]),
        _ => ("/event/release", vec![number(line.id), sample, seconds]),
    };
    let message = OscPacket::Message(OscMessage { addr: addr.into(), args });
    let timetag = OscTime { seconds: (tag.0 >> 32) as u32, fractional: tag.0 as u32 };
    encoder::encode(&OscPacket::Bundle(OscBundle { timetag, content: vec![message] })).ok()
}

#[cfg(test)]
mod tests {
    use super::{Lost, send};
    use std::net::UdpSocket;
    use std::sync::Arc;
    use std::sync::mpsc::channel;

    /// More than a datagram has room for.
    #[test]
    fn what_the_system_does_not_send_is_told_with_its_reason_once() {
        let socket = Arc::new(UdpSocket::bind("127.0.0.1:0").unwrap());
        let to = socket.local_addr().unwrap();
        let (lost, (tell, told)) = (Lost::default(), channel());
        for length in [70_000, 10, 70_000] {
            tell.send((vec![0; length], vec![(Arc::clone(&socket), Some(to))])).unwrap();
        }
        drop(tell);
        send(&told, &lost);
        assert_eq!(lost.unsent.get(), 2);
        let vain = lost.unheard.lock().unwrap();
        assert!(matches!(&vain.0[..], [(at, Some(why))] if *at == to && !why.is_empty()), "{vain:?}");
    }
}
