//! The thread that does what is asked, and answers.

use std::net::{SocketAddr, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::Duration;

use rosc::{OscMessage, OscPacket, OscType, encoder};

use super::agenda::Agenda;
use super::announce::{Announcer, Wants};
use super::arrivals::{Arrival, Arrivals};
use super::complaints::{Complaints, Why};
use super::counts::Counts;
use super::drops::dropped;
use super::endpoint::{BindError, Endpoint};
use super::ids::Ids;
use super::message::{Ask, ask};
use super::names::{Kind, Method, Names, Unfound};
use super::packet::{Unreadable, unpack};
use super::peers::{LIFE, Peers, What};
use super::receiver::{self, LOOK};
use super::rest::Rest;
use super::said;
use super::time::{Due, Tag};
use crate::io::device::priority;
use crate::live::signal::{Handle, Origin, Signal};
use crate::live::stamp::Stamp;
use crate::live::way::Way;
use crate::patch::{Control, Patch};

/// The session is told of what is due this long before: more than this thread can wake too late, less than patterns are fed ahead.
const AHEAD: u64 = 20_000_000;

/// Steps ([`Names::find`]) that all messages of a datagram may take together, some hundredths of a second at most: others wait behind it. And
/// what one thing that is done counts for among them.
const STEPS: u64 = 1_000_000;
const DEED: u64 = 100;

/// A server that listens until it is dropped.
pub struct Server {
    address: SocketAddr,
    counts: Arc<Counts>,
    names: Sender<Names>,
    complaints: Receiver<String>,
    stop: Arc<AtomicBool>,
    arrivals: Arc<Arrivals>,
    threads: Vec<JoinHandle<()>>,
}

impl Server {
    /// Listens at `endpoint` for a session that plays `patch`. Without an announcer nobody can be told of markers and voices.
    ///
    /// # Errors
    /// As [`Endpoint::bind`], or a system that has no thread left.
    pub fn start(
        endpoint: Endpoint,
        handle: Handle,
        patch: &Patch,
        announcer: Option<Announcer>,
    ) -> Result<Self, BindError> {
        Self::of(endpoint.bind()?, endpoint, handle, patch, announcer)
    }

    /// The same on what [`Endpoint::bind`] gave, so that an address which cannot be had is known of before a session begins.
    ///
    /// # Errors
    /// A system that has no thread left.
    pub fn of(
        socket: UdpSocket,
        endpoint: Endpoint,
        handle: Handle,
        patch: &Patch,
        announcer: Option<Announcer>,
    ) -> Result<Self, BindError> {
        let failed = |error: std::io::Error| BindError::of(endpoint.0, &error);
        let address = socket.local_addr().map_err(failed)?;
        socket.set_write_timeout(Some(LOOK)).map_err(failed)?;
        socket.set_read_timeout(Some(LOOK)).map_err(failed)?;
        let ((send, names), (complain, complaints)) = (channel(), channel());
        let socket = Arc::new(socket);
        let mut server = Self {
            address,
            counts: Arc::default(),
            names: send,
            complaints,
            stop: Arc::default(),
            arrivals: Arc::default(),
            threads: Vec::new(),
        };
        let (counts, arrivals) = (Arc::clone(&server.counts), Arc::clone(&server.arrivals));
        let receiver = receiver::Receiver {
            socket: Arc::clone(&socket),
            handle: handle.clone(),
            counts: Arc::clone(&counts),
            arrivals: Arc::clone(&arrivals),
            stop: Arc::clone(&server.stop),
        };
        let mut listener = Listener {
            socket,
            handle,
            announcer,
            counts,
            arrivals,
            to_come: names,
            names: Names::default(),
            complaints: Complaints::new(complain),
            values: Vec::new(),
            agenda: Agenda::default(),
            ids: Ids::default(),
            peer: None,
            peers: Peers::default(),
            panicked: false,
            pulls: 0,
            messages: 0,
            looked: Stamp::default(),
            rest: Rest::default(),
        };
        listener.follow(Names::of(patch));
        let stopped = Arc::clone(&server.stop);
        let listen = move || {
            priority::raise_feeding();
            while !stopped.load(Ordering::Acquire) {
                listener.turn();
            }
            listener.look();
        };
        let thread = |name: &str| std::thread::Builder::new().name(name.into());
        // The one that is there ends with the server where there is no other.
        server.threads.push(thread("osc").spawn(listen).map_err(failed)?);
        server.threads.push(thread("osc in").spawn(|| receiver.receive()).map_err(failed)?);
        Ok(server)
    }

    /// Where it listens.
    pub fn address(&self) -> SocketAddr {
        self.address
    }

    /// What came, and what became of it.
    pub fn counts(&self) -> &Arc<Counts> {
        &self.counts
    }

    /// What came to nothing since this was asked last, in a sentence for each address, of the first few; all of it is in [`Server::counts`].
    pub fn complaints(&self) -> impl Iterator<Item = String> {
        self.complaints.try_iter()
    }

    /// The session plays another patch from now on. Controls that it still has keep what is known of them; reports on controls end.
    pub fn follow(&self, patch: &Patch) {
        // Nobody hears it only where the thread has ended.
        let _ = self.names.send(Names::of(patch));
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Release);
        self.counts.crammed.add(self.arrivals.end() as u64);
        for thread in self.threads.drain(..) {
            // One that has panicked has nothing more to say.
            let _ = thread.join();
        }
    }
}

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

/// What the thread has.
struct Listener {
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
    messages: u64,
    /// When what the system dropped was looked at last.
    looked: Stamp,
    rest: Rest,
}

impl Listener {
    /// Waits for one datagram, or until something is due.
    fn turn(&mut self) {
        let epoch = self.handle.epoch();
        if let Some(Arrival { from, now, wall, pulls, brakes, datagram }) =
            self.arrivals.next(self.patience(epoch.now()))
        {
            self.pulls = pulls;
            let panicked = datagram.is_some_and(|datagram| self.hear(&datagram, from, now, wall));
            // What else was in it may have left no room for what had pulled the brake.
            if brakes && !panicked {
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

    /// Does what a datagram asks for, which came at `now`, or `wall` by the clock of the system. Says whether a panic was among it.
    fn hear(&mut self, datagram: &[u8], from: SocketAddr, now: Stamp, wall: Tag) -> bool {
        let messages = match unpack(datagram) {
            Ok(messages) => messages,
            Err(unreadable) => {
                let counts = &self.counts;
                match unreadable {
                    Unreadable::Malformed => counts.malformed.add(1),
                    Unreadable::Deep => counts.deep.add(1),
                }
                return false;
            }
        };
        let mut panicked = false;
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
                    (Ok(Ask::Panic), _) => {
                        panicked = true;
                        self.act(now, from, self.messages, Ask::Panic);
                    }
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
        panicked
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

    fn send(&self, at: Stamp, signal: Signal) -> bool {
        self.send_numbered(at, signal).is_some()
    }

    /// The same. Gives the signal's number, if it was taken.
    fn send_numbered(&self, at: Stamp, signal: Signal) -> Option<u64> {
        self.send_by(&self.handle, at, signal)
    }

    fn send_by(&self, handle: &Handle, at: Stamp, signal: Signal) -> Option<u64> {
        let taken = handle.send_knowing(at, signal, self.pulls).ok();
        if taken.is_some() { &self.counts.taken } else { &self.counts.refused }.add(1);
        taken
    }

    /// Where a control stands: as whoever moved it last has sent it, those included that the session has not come to yet.
    fn value(&self, number: usize) -> Option<f64> {
        let (control, (own, id)) = self.names.controls.get(number).zip(self.values.get(number))?;
        Some(self.handle.board().values.since(&control.name, Way::Osc, *id).unwrap_or(*own))
    }

    /// Does what was asked for, as of `at`.
    fn act(&mut self, at: Stamp, from: SocketAddr, message: u64, what: Ask) {
        match what {
            Ask::Play(voice, note, id) => {
                let number = self.handle.number();
                let handle = self.handle.tagged(id);
                let taken = self.send_by(&handle, at, Signal::Play(number, voice, note)).is_some();
                if let (true, Some(id)) = (taken, id) {
                    self.counts.forgotten.add(self.ids.keep(id, message, number));
                }
            }
            Ask::Touch(id, touch) => match self.ids.get(id) {
                Some(numbers) => numbers.iter().for_each(|number| {
                    self.send(at, Signal::Touch(*number, touch));
                }),
                None => self.strange(id),
            },
            Ask::Release(id) => match self.ids.take(id) {
                Some(numbers) => {
                    for number in numbers {
                        if !self.send(at, Signal::Release(number)) {
                            // It can be tried again.
                            self.ids.keep(id, message, number);
                        }
                    }
                }
                None => self.strange(id),
            },
            Ask::ReleaseAll => drop(self.send(at, Signal::ReleaseAll)),
            Ask::Start(name) => drop(self.send(at, Signal::Start(self.handle.number(), name))),
            Ask::Stop(name) => drop(self.send(at, Signal::StopNamed(name))),
            Ask::Set(number, value) => self.set(at, number, value),
            Ask::Feed(values) => {
                for (number, value) in values {
                    // Which of them it is.
                    let name = self.names.controls.get(number).map_or("", |control| &control.name);
                    let origin = Origin::Osc(format!("/input/{name}").into(), value.to_string().into());
                    self.handle = self.handle.from(origin);
                    self.set(at, number, value);
                }
            }
            Ask::Get(control) => self.tell(from, control),
            Ask::Report(control, Some(every)) => {
                self.tell(from, control);
                self.subscribe(from, What::Control(control), every);
            }
            Ask::Report(control, None) => self.peers.unsubscribe(from, What::Control(control)),
            Ask::List(Kind::Controls) => self.list(from),
            Ask::List(Kind::Voices) => self.names(from, "/voices", &self.names.voices),
            Ask::List(Kind::Patterns) => self.names(from, "/patterns", &self.names.patterns),
            Ask::Panic => {
                // It was when this came, but somebody may have let it go since.
                let board = self.handle.board();
                if !board.is_panicked() {
                    board.panic();
                }
                self.pulls = board.lever.pulls();
                self.send(at, Signal::Panic);
                self.cancel();
            }
            // A brake that was pulled since then holds.
            Ask::Calm if self.handle.board().lever.pulls() != self.pulls => {
                self.counts.cancelled.add(1);
                let why = self.complaints.cancelled(self.handle.epoch().now());
                self.write(why);
            }
            Ask::Calm => drop(self.send(at, Signal::Calm)),
            Ask::Arm(armed) => drop(self.send(at, Signal::Arm(armed))),
            Ask::Torque(on) => drop(self.send(at, Signal::Torque(on))),
            Ask::Subscribe(every) => {
                if self.subscribe(from, What::Meter, every) {
                    let every = OscType::Int(every.as_millis() as i32);
                    self.answer(from, "/meter/subscribed", vec![every, OscType::Int(LIFE as i32)]);
                }
            }
            Ask::Unsubscribe => self.peers.unsubscribe(from, What::Meter),
            Ask::Invite(wants) => {
                let invite = |announcer: &Announcer| announcer.invite(from, &self.socket, wants);
                if self.announcer.as_ref().is_some_and(invite) {
                    let what = match wants {
                        Wants::Markers => "/marker/subscribed",
                        Wants::All => "/event/subscribed",
                    };
                    self.answer(from, what, vec![OscType::Int(LIFE as i32)]);
                } else {
                    self.counts.crowded.add(1);
                }
            }
            Ask::Dismiss => self.announcer.iter().for_each(|announcer| announcer.dismiss(from)),
            Ask::Status => self.status(from),
            Ask::Ping => self.answer(from, "/pong", vec![]),
            Ask::Trigger(address, numbers) => {
                self.complaints.position(&address, &numbers, &self.names);
                self.send(at, Signal::Osc(address, numbers));
            }
            Ask::Note(text) => drop(self.send(at, Signal::Note(text))),
            Ask::Nothing => {}
        }
    }

    fn set(&mut self, at: Stamp, number: usize, value: f64) {
        let Some(control) = self.names.controls.get(number) else { return };
        let (name, value) = (control.name.clone(), value.clamp(control.range[0], control.range[1]));
        if let (Some(id), Some(slot)) =
            (self.send_numbered(at, Signal::Set(name, value)), self.values.get_mut(number))
        {
            *slot = (value, id);
        }
    }

    fn subscribe(&mut self, to: SocketAddr, what: What, every: Duration) -> bool {
        let room = self.peers.subscribe(to, what, every, self.handle.epoch().now());
        self.counts.crowded.add(u64::from(!room));
        room
    }

    fn answer(&self, to: SocketAddr, addr: &str, args: Vec<OscType>) {
        let packet = OscPacket::Message(OscMessage { addr: addr.into(), args });
        let sent = encoder::encode(&packet).is_ok_and(|bytes| self.socket.send_to(&bytes, to).is_ok());
        self.counts.unsent.add(u64::from(!sent));
    }

    fn tell(&self, to: SocketAddr, control: usize) {
        if let (Some(c), Some(value)) = (self.names.controls.get(control), self.value(control)) {
            self.answer(to, &format!("/control/{}", c.name), vec![OscType::Float(value as f32)]);
        }
    }

    fn list(&self, to: SocketAddr) {
        for (number, control) in self.names.controls.iter().enumerate() {
            let Some(value) = self.value(number) else { continue };
            let [least, most] = control.range;
            let numbers = [value, least, most, control.default].map(|x| OscType::Float(x as f32));
            let args = std::iter::once(control.name.as_str().into()).chain(numbers);
            self.answer(to, "/controls", args.chain([control.unit.as_str().into()]).collect());
        }
        self.answer(to, "/controls/end", vec![count(self.values.len() as u64)]);
    }

    fn names(&self, to: SocketAddr, address: &str, names: &[String]) {
        names.iter().for_each(|name| self.answer(to, address, vec![name.as_str().into()]));
        self.answer(to, &format!("{address}/end"), vec![count(names.len() as u64)]);
    }

    fn status(&self, to: SocketAddr) {
        let board = self.handle.board();
        let mut args = vec![
            OscType::Long(i64::try_from(board.frames.get()).unwrap_or(i64::MAX)),
            count(board.voices.get()),
            OscType::Float(board.load.mean() as f32),
            count(board.xruns.get()),
            count(board.late.get()),
            count(board.dropped.get() + board.refused.get()),
        ];
        // Of those, signals and patterns that found no room, by where they came from.
        args.extend(board.refused.named().map(|(_, refused)| count(refused)));
        self.answer(to, "/status", args);
    }
}

/// As many as 32 bits hold.
fn count(n: u64) -> OscType {
    OscType::Int(i32::try_from(n).unwrap_or(i32::MAX))
}
