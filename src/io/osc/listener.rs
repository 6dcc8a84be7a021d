//! The thread that hears what was received, in its turn: finds what it asks for, and does that when it is due (`acts`).

mod acts;

use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender};
use std::time::Duration;

use rosc::OscType;

use super::agenda::Agenda;
use super::announce::Announcer;
use super::arrivals::{Arrival, Arrivals};
use super::complaints::{Complaints, Why};
use super::counts::Counts;
use super::drops::dropped;
use super::ids::Ids;
use super::message::{Ask, ask};
use super::names::{Method, Names, Unfound};
use super::packet::{Unreadable, unpack};
use super::peers::{Peers, What};
use super::receiver::LOOK;
use super::rest::Rest;
use super::said;
use super::time::{Due, Tag};
use crate::io::device::priority;
use crate::live::signal::{Handle, Origin, Signal};
use crate::live::stamp::Stamp;
use crate::patch::Control;

/// The session is told of what is due this long before: more than this thread can wake too late, less than patterns are fed ahead.
const AHEAD: u64 = 20_000_000;

/// Steps ([`Names::find`]) that all messages of a datagram may take together, some hundredths of a second at most: others wait behind it. And
/// what one thing that is done counts for among them.
const STEPS: u64 = 1_000_000;
const DEED: u64 = 100;

/// What was asked for and is not due yet.
struct Later {
    from: SocketAddr,
    /// The number of its message.
    message: u64,
    /// How often the brake had been pulled when it came.
    pulls: u64,
    origin: Origin,
    /// By how many seconds it came before its time.
    ahead: Option<f64>,
    what: Ask,
}

/// What leads to others.
pub(super) struct Ends {
    pub socket: Arc<UdpSocket>,
    pub handle: Handle,
    pub announcer: Option<Announcer>,
    pub counts: Arc<Counts>,
    pub arrivals: Arc<Arrivals>,
    /// The names of patches that take over.
    pub to_come: Receiver<Names>,
    /// Where it is said what came to nothing.
    pub complain: Sender<String>,
}

/// What the thread has.
pub(super) struct Listener {
    socket: Arc<UdpSocket>,
    handle: Handle,
    announcer: Option<Announcer>,
    counts: Arc<Counts>,
    arrivals: Arc<Arrivals>,
    to_come: Receiver<Names>,
    names: Names,
    complaints: Complaints,
    /// What each control was sent to last from here, and by which signal.
    values: Vec<(f64, u64)>,
    agenda: Agenda<Later>,
    ids: Ids,
    /// Who sent something last, and the same in words.
    peer: Option<(SocketAddr, Arc<str>)>,
    peers: Peers,
    /// Whether the brake was pulled when that was looked at last.
    panicked: bool,
    /// How often it had been, when what is done now came.
    pulls: u64,
    /// The number of the signal by which what is done now pulled it, until that is sent.
    brakes: Option<u64>,
    messages: u64,
    /// When what the system dropped was looked at last.
    looked: Stamp,
    rest: Rest,
}

impl Listener {
    /// For a patch with these names.
    pub fn new(ends: Ends, names: Names) -> Self {
        let Ends { socket, handle, announcer, counts, arrivals, to_come, complain } = ends;
        let mut listener = Self {
            socket,
            handle,
            announcer,
            counts,
            arrivals,
            to_come,
            names: Names::default(),
            complaints: Complaints::new(complain),
            values: Vec::new(),
            agenda: Agenda::default(),
            ids: Ids::default(),
            peer: None,
            peers: Peers::default(),
            panicked: false,
            pulls: 0,
            brakes: None,
            messages: 0,
            looked: Stamp::default(),
            rest: Rest::default(),
        };
        listener.follow(names);
        listener
    }

    /// Listens until it is told to stop.
    pub fn listen(mut self, stopped: &AtomicBool) {
        priority::raise_feeding();
        while !stopped.load(Ordering::Acquire) {
            self.turn();
        }
        // What is still ahead comes to nothing; nobody hears why any more.
        let ahead = self.agenda.retain(|_| false).len();
        self.counts.cancelled.add(ahead as u64);
        self.look();
    }

    /// Waits for one datagram, or until something is due.
    fn turn(&mut self) {
        let epoch = self.handle.epoch();
        if let Some(Arrival { from, now, wall, pulls, brakes, datagram }) =
            self.arrivals.next(self.patience(epoch.now()))
        {
            (self.pulls, self.brakes) = (pulls, brakes);
            if let Some(datagram) = datagram {
                self.hear(&datagram, from, now, wall);
            }
            // What else was in it may have left no room for what had pulled the brake.
            if self.brakes.is_some() {
                self.act(now, from, self.messages, Ask::Panic);
            }
            self.rest.after_one(epoch.now());
        }
        while let Ok(names) = self.to_come.try_recv() {
            self.follow(names);
        }
        self.go_on(epoch.now());
    }

    /// How long it may wait for something to come, until something is due.
    fn patience(&self, now: Stamp) -> Duration {
        let due = self.agenda.next().map(|at| Stamp(at.0.saturating_sub(AHEAD)));
        let due = due.into_iter().chain(self.peers.next()).min();
        due.map_or(LOOK, |at| Duration::from_nanos(at.0.saturating_sub(now.0)).min(LOOK))
    }

    fn follow(&mut self, names: Names) {
        let known = |control: &Control| {
            let at = self.names.controls.iter().position(|c| c.name == control.name)?;
            self.values.get(at).copied()
        };
        let value = |control: &Control| known(control).unwrap_or((control.default, 0));
        let within = |c: &Control, (value, id): (f64, u64)| (value.clamp(c.range[0], c.range[1]), id);
        self.values = names.controls.iter().map(|c| within(c, value(c))).collect();
        // What waits for its time means the control that had that name.
        let become_of = |control: usize| {
            let name = &self.names.controls.get(control)?.name;
            names.controls.iter().position(|c| c.name == *name)
        };
        let forgotten = self.agenda.retain(|later| later.what.renumber(become_of));
        self.counts.unknown.add(forgotten.len() as u64);
        let now = self.handle.epoch().now();
        for later in forgotten {
            let why = self.complaints.forgotten(now);
            self.write_of(later, why);
        }
        self.names = names;
        self.peers.forget_controls();
    }

    /// Does what a datagram asks for, which came at `now`, or `wall` by the clock of the system.
    fn hear(&mut self, datagram: &[u8], from: SocketAddr, now: Stamp, wall: Tag) {
        let messages = match unpack(datagram) {
            Ok(messages) => messages,
            Err(unreadable) => {
                let counts = &self.counts;
                match unreadable {
                    Unreadable::Malformed => counts.malformed.add(1),
                    Unreadable::Deep => counts.deep.add(1),
                }
                return;
            }
        };
        let mut steps = STEPS;
        for (tag, message) in messages {
            self.messages += 1;
            self.counts.messages.add(1);
            let origin = said::origin(&message);
            let peer = self.peer_of(from);
            let due = tag.due(now, wall);
            let ahead = match due {
                Due::At(at) => Some(at.seconds() - now.seconds()),
                Due::Late(ago) => Some(-(ago as f64 * 1e-9)),
                Due::AtOnce | Due::Far => None,
            };
            self.handle = self.handle.from(origin.clone()).by(&peer).ahead(ahead);
            let methods = match self.names.find(&message.addr, &mut steps) {
                Ok(methods) if methods.is_empty() => {
                    self.counts.unknown.add(1);
                    let why = self.complaints.unknown(now, &message.addr, &self.names);
                    self.write(why);
                    continue;
                }
                Ok(methods) => methods,
                Err(unfound) => {
                    match unfound {
                        Unfound::NoPattern => self.counts.malformed.add(1),
                        Unfound::Costly => self.counts.refused.add(1),
                    }
                    let why = self.complaints.unfound(now, unfound);
                    self.write(why);
                    continue;
                }
            };
            let of = |method: &Method| self.sampled(method, due, now);
            let late = matches!(due, Due::Late(_)) && methods.iter().any(|method| of(method).is_none());
            self.counts.late.add(u64::from(late));
            if let Due::Late(ago) = due
                && late
            {
                self.complaints.late(&peer, ago as f64 * 1e-9);
            }
            for method in methods {
                let costly = steps == 0;
                steps = steps.saturating_sub(DEED);
                let sampled = self.sampled(&method, due, now);
                match (ask(&method, &message.args), due) {
                    (Err(_), _) => {
                        self.counts.wrong.add(1);
                        let why = self.complaints.wrong(now, &message.addr, &message.args, &method);
                        self.write(why);
                    }
                    // A brake waits for nothing.
                    (Ok(Ask::Panic), _) => self.act(now, from, self.messages, Ask::Panic),
                    (Ok(_), _) if costly => {
                        self.counts.refused.add(1);
                        let why = self.complaints.unfound(now, Unfound::Costly);
                        self.write(why);
                    }
                    (Ok(_), Due::Far) => {
                        self.counts.far.add(1);
                        let why = self.complaints.far(now, &peer);
                        self.write(why);
                    }
                    (Ok(what), Due::At(at)) => {
                        let (message, pulls, origin) = (self.messages, self.pulls, origin.clone());
                        let later = Later { from, message, pulls, origin, ahead, what };
                        if !self.agenda.add(at, later) {
                            self.counts.refused.add(1);
                            let why = self.complaints.crammed(now);
                            self.write(why);
                        }
                    }
                    (Ok(what), Due::AtOnce | Due::Late(_)) => {
                        self.act(sampled.unwrap_or(now), from, self.messages, what);
                    }
                }
            }
        }
    }

    /// When a value for a stream was sampled that came late, but within what the stream is later anyway.
    fn sampled(&self, method: &Method, due: Due, now: Stamp) -> Option<Stamp> {
        let Due::Late(ago) = due else { return None };
        (ago as f64 * 1e-9 < self.names.stream(method)).then(|| Stamp(now.0.saturating_sub(ago)))
    }

    /// Does what is due, and tells what is.
    fn go_on(&mut self, now: Stamp) {
        let panicked = self.handle.board().is_panicked();
        if panicked && !self.panicked {
            self.cancel();
        }
        self.panicked = panicked;
        while let Some((at, Later { from, message, pulls, origin, ahead, what })) =
            self.agenda.take(Stamp(now.0.saturating_add(AHEAD)))
        {
            let peer = self.peer_of(from);
            self.handle = self.handle.from(origin).by(&peer).ahead(ahead);
            self.pulls = pulls;
            self.act(at, from, message, what);
        }
        if self.peers.next().is_some_and(|next| next <= now) {
            let mut peers = std::mem::take(&mut self.peers);
            let board = self.handle.board();
            let peaks = || (0..board.channels()).map(|channel| board.take_sent_peak(channel)).collect();
            peers.tell(now, peaks, |to, what, peaks| match what {
                What::Meter => self.answer(to, "/meter", peaks.iter().map(|p| OscType::Float(*p)).collect()),
                What::Control(control) => self.tell(to, control),
            });
            self.peers = peers;
        }
        if now.0.saturating_sub(self.looked.0) > 1_000_000_000 {
            self.looked = now;
            self.look();
        }
    }

    /// A sender in words: the same as before, as a rule.
    fn peer_of(&mut self, from: SocketAddr) -> Arc<str> {
        let known = self.peer.take().filter(|(known, _)| *known == from);
        let (_, words) = self.peer.insert(known.unwrap_or_else(|| (from, from.to_string().into())));
        Arc::clone(words)
    }

    /// Forgets what waits for its time.
    fn cancel(&mut self) {
        let now = self.handle.epoch().now();
        for later in self.agenda.retain(|_| false) {
            self.counts.cancelled.add(1);
            let why = self.complaints.cancelled(now);
            self.write_of(later, why);
        }
    }

    /// Has a journal say why the message that is done now came to nothing.
    fn write(&self, why: Why) {
        self.write_by(&self.handle, why);
    }

    /// The same of one that waited for its time.
    fn write_of(&mut self, Later { from, origin, ahead, .. }: Later, why: Why) {
        let peer = self.peer_of(from);
        self.write_by(&self.handle.from(origin).by(&peer).ahead(ahead), why);
    }

    fn write_by(&self, handle: &Handle, why: Why) {
        let sent = why.is_some_and(|why| handle.send(Signal::Vain(String::new(), why)).is_ok());
        self.counts.unwritten.add(u64::from(!sent));
    }

    /// Nothing is known of what was played under an id.
    fn strange(&mut self, id: i64) {
        self.counts.unknown.add(1);
        let why = self.complaints.strange(self.handle.epoch().now(), id);
        self.write(why);
    }

    /// Looks how much the system has dropped.
    fn look(&self) {
        if let Some(missed) = self.socket.local_addr().ok().and_then(dropped) {
            self.counts.missed.set(missed);
        }
    }
}
