//! The conductor: one thread that hears of everything and leads the performer.
//!
//! It turns the moments at which signals arrived into frames, lets the performer make events of them, and sends those to the
//! callback ahead of their time. It compiles nothing and waits for nothing but signals.

mod voices;

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;
use std::time::Duration;

use ringbuf::traits::{Consumer, Observer, Producer};

use super::board::Board;
use super::cables::Watch;
use super::callback::{Cue, Deed, Report, Rings, SOURCES};
use super::clock::{Moment, StreamClock};
use super::gate::UNARMED;
use super::queues::{Inbox, queues};
use super::reload::Reload;
use super::sequence::Sequence;
use super::signal::{Handle, Signal, Stamped};
use super::stamp::{Epoch, Stamp};
use super::way::{WAYS, Way};
use crate::engine::event::{Event, Source};
use crate::engine::exchange::Director;
use crate::performer::{Callings, Outlet, Performer, When};
use crate::schedule::Instant;
use crate::text::Problem;
use voices::{Known, Voices};

/// Seconds that patterns are sent ahead, beyond the block that is computed next.
const AHEAD: f64 = 0.05;

/// How often patterns are fed at most before anything sounds, a millisecond's work each time.
const AT_FIRST: u32 = 5000;

/// How often it looks whether patterns must be fed, where no signal comes.
const EVERY: Duration = Duration::from_millis(5);

/// The same where nodes or a knob may set off patterns, whose time is short ([`crate::graph::answer::TELLING`]).
const OFTEN: Duration = Duration::from_millis(1);

/// The same where they have more to send than they were let at once.
const BREATH: Duration = Duration::from_micros(100);

/// How long a callback may take to shut the gate at the end; one whose device stands still never does.
const LAST: Duration = Duration::from_millis(500);
const BLOCKS: f64 = 4.0;

/// Room in each ring to the callback that is for what lets go alone.
const LETTING_GO: usize = 1 << 10;

/// What a conductor tells of.
#[derive(Debug)]
pub enum Told<'a> {
    /// A session began, at this moment; its board.
    Began(Epoch, &'a Arc<Board>),
    /// Something came in; it is told before anything is done about it.
    Came(&'a Stamped),
    /// A cable of MIDI is lost that had promised to stay: the number of its port, and its name where that is known. All is shut.
    Lost(u16, Option<&'a str>),
    /// What the callback did, and how its frames and wall time belonged together a moment ago.
    Report(&'a Report, Option<Moment>),
    /// Something that was asked for and cannot be done, and the number of the signal that asked for it; 0 where it was none.
    Refused(&'a Problem, u64),
    /// Something was asked for that did not get as far as the conductor: why, and the number of the signal that says so. Whoever has refused it counts it.
    Vain(&'a str, u64),
    /// Other patterns play than before. Those that play now: number, and name; those that play from the beginning have number 0.
    Playing(&'a [(u64, &'a str)]),
    /// A new patch or rig takes over: what the callback tells of after its next [`super::callback::Deed::Swap`] is meant for it. The number of the
    /// signal that asked for it.
    Reloading(&'a Reload, u64),
    /// It plays.
    Reloaded,
    /// A new patch or rig cannot take over, and why; the old one plays on. The number of the signal that asked for it.
    Kept(&'a str, u64),
}

/// Hears what a conductor tells of, in its thread, which it must not keep: while it does, nothing that comes in takes effect.
pub type Audience = Box<dyn FnMut(Told<'_>) + Send>;

/// A new patch or rig, and the number of the signal that asked for it.
type Asked = (Box<Reload>, u64);

/// Leads a session.
pub struct Conductor {
    performer: Performer,
    director: Director,
    rings: Rings,
    clock: StreamClock,
    epoch: Epoch,
    board: Arc<Board>,
    inbox: Inbox,
    audience: Audience,
    watch: Watch,
    /// Whoever spoke last through a port of MIDI.
    ports: HashMap<u16, Arc<str>>,
    /// The performer's ids and serial numbers by those that handles gave out.
    voices: Voices,
    patterns: HashMap<u64, u64>,
    /// The serial numbers of the patterns that it told of last.
    playing: Vec<u64>,
    /// What the plan that sounds calls things, and one that was admitted and has not taken over yet.
    callings: Callings,
    next: VecDeque<Callings>,
    /// Plans that were sent after the first.
    plan: u64,
    /// One that gets ready to take over.
    offered: Option<Asked>,
    /// One that waits until the one before has taken over and the old engine has come back.
    waiting: Option<Asked>,
    rate: f64,
    ratio: f64,
    sequence: Sequence,
    /// Whether patterns have more to send than they were let at once.
    behind: bool,
    ended: bool,
}

/// The rings as an outlet.
struct ToCallback<'a> {
    rings: &'a mut Rings,
    clock: u64,
    plan: u64,
    /// The signal that asks for it; 0 for none.
    cause: u64,
}

impl Outlet for ToCallback<'_> {
    fn clock(&self) -> u64 {
        self.clock
    }

    fn room(&self, source: Source) -> usize {
        let ring = SOURCES.iter().position(|s| *s == source).and_then(|number| self.rings.cues.get(number));
        ring.map_or(0, Observer::vacant_len).saturating_sub(LETTING_GO)
    }

    fn because(&mut self, cause: u64) {
        self.cause = cause;
    }

    fn send(&mut self, at: Instant, source: Source, event: Event) -> bool {
        if !event.lets_go() && self.room(source) == 0 {
            return false;
        }
        let ring =
            SOURCES.iter().position(|s| *s == source).and_then(|number| self.rings.cues.get_mut(number));
        ring.is_some_and(|ring| ring.try_push(Cue { plan: self.plan, at, event, cause: self.cause }).is_ok())
    }
}

impl Conductor {
    /// For a callback that has its other ends.
    pub fn new(
        performer: Performer,
        director: Director,
        rings: Rings,
        clock: StreamClock,
        epoch: Epoch,
        board: &Arc<Board>,
        audience: Audience,
    ) -> (Self, Handle) {
        let (inlet, inbox) = queues();
        let handle = Handle::new(inlet, epoch, Arc::clone(board));
        let plan = performer.plan();
        let (rate, ratio) = (plan.engine_rate(), plan.ratio as f64);
        let callings = Callings::of(plan);
        let conductor = Self {
            performer,
            director,
            rings,
            clock,
            epoch,
            board: Arc::clone(board),
            inbox,
            audience,
            watch: Watch::default(),
            ports: HashMap::new(),
            voices: Voices::default(),
            patterns: HashMap::new(),
            playing: Vec::new(),
            callings,
            next: VecDeque::new(),
            plan: 0,
            offered: None,
            waiting: None,
            rate,
            ratio,
            sequence: Sequence::default(),
            behind: false,
            ended: false,
        };
        (conductor, handle)
    }

    /// Leads until it is told to end, or nobody can tell it anything any more; after [`Conductor::begin`].
    pub fn lead(mut self) {
        self.inbox.attend();
        while !self.ended {
            self.inbox.wait(match (self.behind, self.callings.has_patterns()) {
                // Others of its priority are to come to their turn, too.
                (true, _) => BREATH,
                (false, true) => OFTEN,
                (false, false) => EVERY,
            });
            self.listen();
            self.go_on();
        }
        self.see_out();
    }

    /// Does what signals ask for that wait, of each way no more than its share: patterns must not wait for ever.
    fn listen(&mut self) {
        self.inbox.begin();
        let mut taken = [0; WAYS];
        while !self.ended
            && let Some(stamped) = self.inbox.next()
        {
            let (id, way) = (stamped.id, Way::of(&stamped.signal, &stamped.origin));
            self.take(stamped);
            // A brake has its number before it is sent.
            taken[way as usize] = taken[way as usize].max(id);
        }
        self.show_values(taken);
        if self.inbox.is_over() {
            self.end(0);
        }
    }

    /// Lets others see where controls stand, and then how far that is what they have asked for.
    fn show_values(&mut self, taken: [u64; WAYS]) {
        if let Some(values) = self.performer.take_moved() {
            self.board.values.show(values);
        }
        if taken != [0; WAYS] {
            self.board.values.done(taken);
        }
    }

    /// Tells what the callback does until its gate is shut.
    fn see_out(&mut self) {
        // Blocks may be longer than that.
        let most =
            LAST.max(Duration::from_secs_f64(BLOCKS * self.clock.ahead() as f64 / (self.rate * self.ratio)));
        let begin = std::time::Instant::now();
        while self.board.shut.get() == 0 && begin.elapsed() < most {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.hear();
    }

    /// Tells that something cannot be done.
    fn refuse(&mut self, problem: &Problem, cause: u64) {
        self.board.undone.add(1);
        (self.audience)(Told::Refused(problem, cause));
    }

    /// Hears what the callback did. Says whether patterns were set off.
    fn hear(&mut self) -> bool {
        let moment = self.clock.moment();
        let mut set_off = false;
        while let Some(report) = self.rings.reports.try_pop() {
            match &report.deed {
                Deed::Swap => {
                    if let Some(callings) = self.next.pop_front() {
                        self.callings = callings;
                    }
                }
                Deed::Crossing(crossing) => set_off |= self.performer.cross(&self.callings, crossing),
                Deed::Event { .. } | Deed::Turn(_) | Deed::Followed(_) | Deed::Order(..) | Deed::Steps(_) => {
                }
            }
            (self.audience)(Told::Report(&report, moment));
        }
        // The callback at this moment had not done anything yet; what those before it did has been told.
        self.board.told.set(moment.map_or(0, |moment| moment.frames));
        set_off
    }

    /// Sends what sounds from the beginning, and opens the gate.
    pub fn begin(&mut self) {
        (self.audience)(Told::Began(self.epoch, &self.board));
        let until = self.until(0);
        let mut outlet = ToCallback { rings: &mut self.rings, clock: 0, plan: self.plan, cause: 0 };
        let begun = self.performer.begin(&mut outlet);
        // One that has millions of steps to take until something happens has given up by then.
        let fed = |_: &u32| self.performer.feed_some(until, &mut outlet);
        self.behind = (0..AT_FIRST).find(fed).is_none();
        if let Err(problem) = begun {
            self.refuse(&problem, 0);
        }
        self.hear_trouble();
        self.show_values([0; WAYS]);
        self.board.lever.open();
    }

    /// Feeds patterns, hears what the callback did, and lets a plan that waits take over if it can.
    pub fn go_on(&mut self) {
        self.settle();
        self.miss();
        self.feed();
        self.admit();
        if let Some(reload) = self.waiting.take() {
            self.reload(reload);
        }
        if self.hear() {
            self.feed();
        }
        self.tell_playing();
        self.director.collect();
    }

    /// Pedals may have become something else.
    fn settle(&mut self) {
        let at = self.now();
        let mut outlet =
            ToCallback { rings: &mut self.rings, clock: self.board.clock.get(), plan: self.plan, cause: 0 };
        if let Err(problem) = self.performer.midi_settle(at, &mut outlet) {
            self.refuse(&problem, 0);
        }
        self.board.midi.performed(&self.performer.midi_counts());
    }

    /// Cables that promised to stay may be lost.
    fn miss(&mut self) {
        let board = Arc::clone(&self.board);
        let lost = self.watch.look(&board.cables, self.epoch.now(), board.midi.gaps.get());
        for port in lost {
            self.lose(port, self.now());
        }
    }

    /// A cable is lost: nobody is there who could stop what it moves.
    fn lose(&mut self, port: u16, at: When) {
        (self.audience)(Told::Lost(port, self.ports.get(&port).map(|name| &**name)));
        self.shut(at, 0);
        let mut outlet =
            ToCallback { rings: &mut self.rings, clock: self.board.clock.get(), plan: self.plan, cause: 0 };
        if let Err(problem) = self.performer.midi_gone(at, port, &mut outlet) {
            self.refuse(&problem, 0);
        }
    }

    /// A panic: the gate closes at once, and everything stops behind it. The signal that asks for it is `cause`; 0 for none.
    fn shut(&mut self, at: When, cause: u64) {
        // As a rule, the brake has closed the gate already.
        if !self.board.is_panicked() {
            self.board.lever.panic(cause);
        }
        let clock = self.board.clock.get();
        let mut outlet = ToCallback { rings: &mut self.rings, clock, plan: self.plan, cause };
        self.performer.stop_patterns(at, &mut outlet);
        for Known { id, onset, .. } in self.voices.clear(at) {
            self.performer.release(onset, id, &mut outlet);
        }
        if self.performer.plan().sensor().is_some() {
            self.performer.torque(at, false, &mut outlet);
        }
        self.performer.release_all(at, &mut outlet);
    }

    fn tell_playing(&mut self) {
        if !self.patterns.is_empty() {
            self.patterns.retain(|_, serial| self.performer.plays(*serial));
        }
        if !self.performer.patterns().map(|(serial, _)| serial).eq(self.playing.iter().copied()) {
            let playing: Vec<_> = self.performer.patterns().collect();
            self.playing = playing.iter().map(|(serial, _)| *serial).collect();
            (self.audience)(Told::Playing(&playing));
        }
    }

    /// Up to where patterns are sent, when `clock` is the next sample to be computed.
    fn until(&self, clock: u64) -> u64 {
        let block = self.clock.ahead() as f64 / self.ratio;
        clock + (AHEAD * self.rate + block) as u64
    }

    fn feed(&mut self) {
        let clock = self.board.clock.get();
        let until = self.until(clock);
        let mut outlet = ToCallback { rings: &mut self.rings, clock, plan: self.plan, cause: 0 };
        self.behind = !self.performer.feed_some(until, &mut outlet);
        self.hear_trouble();
    }

    /// Tells what has kept patterns from going on.
    fn hear_trouble(&mut self) {
        for (problem, cause) in self.performer.take_troubles() {
            self.refuse(&problem, cause);
        }
    }

    /// When something takes effect that arrived at `stamp`: a whole block later and a little, so that no callback has computed it yet.
    fn when(&mut self, stamp: Stamp) -> When {
        let at = self.clock.moment().map(|moment| self.sequence.take(moment, stamp, self.epoch.now()));
        self.at_frame(at)
    }

    /// When something takes effect that nobody has sent.
    fn now(&self) -> When {
        let now = self.epoch.now();
        let at = self.clock.moment().map(|moment| self.sequence.see(moment, now, now));
        self.at_frame(at)
    }

    fn at_frame(&self, frame: Option<f64>) -> When {
        match frame {
            Some(frame) => When::of_instant(Instant::of_samples(frame / self.ratio), self.rate),
            None => When::of_sample(self.board.clock.get(), self.rate),
        }
    }

    /// Does what a signal asks for.
    pub fn take(&mut self, stamped: Stamped) {
        (self.audience)(Told::Came(&stamped));
        let Stamped { id, stamp, peer, pulls, signal, .. } = stamped;
        self.performer.because(id);
        let (at, now) = (self.when(stamp), self.now());
        let clock = self.board.clock.get();
        let mut outlet = ToCallback { rings: &mut self.rings, clock, plan: self.plan, cause: id };
        let outlet = &mut outlet;
        let plan = self.performer.plan();
        let has_knob = plan.knob.is_some();
        let done = match signal {
            Signal::Play(number, voice, note) => self.performer.play(at, &voice, &note, outlet).map(|id| {
                let until = at.seconds + self.performer.lasts(&voice, &note);
                self.voices.note(number, Known { id, onset: at, until }, clock as f64 / self.rate);
            }),
            Signal::Touch(number, touch) => self.voices.find(number).and_then(|known| {
                let Some(Known { id, onset, .. }) = known else { return Ok(()) };
                self.performer.touch(at.no_earlier(onset), id, touch, outlet)
            }),
            Signal::Release(number) => self.voices.take(number).map(|known| {
                // One that has yet to begin ends where it does.
                if let Some(Known { id, onset, .. }) = known {
                    self.performer.release(at.no_earlier(onset), id, outlet);
                }
            }),
            Signal::ReleaseAll => {
                self.performer.release_all(at, outlet);
                for Known { id, onset, .. } in self.voices.clear(at) {
                    self.performer.release(onset, id, outlet);
                }
                Ok(())
            }
            Signal::Set(control, value) => self.performer.set_by(at, now, &control, value, outlet),
            Signal::Start(number, name) => self.performer.start_pattern(at, &name).map(|serial| {
                self.patterns.insert(number, serial);
            }),
            Signal::Stop(number) => {
                // Those of the beginning may begin again, with a patch that takes over.
                let serial = if number == 0 { Some(0) } else { self.patterns.remove(&number) };
                if let Some(serial) = serial {
                    self.performer.stop_pattern(at, serial, outlet);
                }
                Ok(())
            }
            Signal::StopNamed(name) => {
                self.performer.stop_named(at, &name, outlet);
                Ok(())
            }
            Signal::Key(key) => self.performer.key(at, key, outlet),
            Signal::Midi(port, message) => {
                if let Some(name) = peer.filter(|name| self.ports.get(&port) != Some(name)) {
                    self.ports.insert(port, name);
                }
                self.performer.midi(at, port, message, outlet)
            }
            Signal::MidiGone(port) if self.board.cables.take_promise(port) => {
                self.lose(port, at);
                Ok(())
            }
            Signal::MidiGone(port) => self.performer.midi_gone(at, port, outlet),
            Signal::Osc(address, values) => {
                self.performer.osc_by((at, now), &address, &values, outlet).map(drop)
            }
            Signal::Panic => {
                self.shut(at, id);
                Ok(())
            }
            Signal::Calm => {
                self.board.lever.take_back(pulls);
                if self.board.is_panicked() {
                    Err(Problem::of_file("the brake was pulled after this was sent, and holds")
                        .help("take it back once more".to_string()))
                } else {
                    let woken = self.performer.wake(at, outlet);
                    self.board.lever.release(id);
                    sent(woken)
                }
            }
            Signal::Arm(armed) => {
                self.board.lever.gain(if armed { 1.0 } else { UNARMED }, id);
                Ok(())
            }
            Signal::Torque(rises) if has_knob => sent(self.performer.torque(at, rises, outlet)),
            Signal::Torque(_) => Err(Problem::of_file("the patch has no knob, so there is no torque")
                .help("say what one feels like: [knob.effects]".to_string())),
            Signal::Reload(reload) => {
                // One that still waits is out of date.
                if let Some((_, before)) = self.waiting.take() {
                    (self.audience)(Told::Kept("another one came before it could take over", before));
                }
                self.reload((reload, id));
                Ok(())
            }
            // It was told of as it came.
            Signal::Note(_) => Ok(()),
            Signal::Vain(_, why) => {
                (self.audience)(Told::Vain(&why, id));
                Ok(())
            }
            Signal::End => {
                self.end(id);
                Ok(())
            }
        };
        self.performer.because(0);
        self.board.refused.patterns.add(self.performer.take_turned_away());
        if let Err(problem) = done {
            self.refuse(&problem, id);
        }
    }

    fn end(&mut self, cause: u64) {
        self.board.lever.close(cause);
        self.ended = true;
        for (way, left) in Way::ALL.into_iter().zip(self.inbox.close()) {
            self.board.refused.of(way).add(left);
        }
    }

    /// Lets another scene take over as soon as it is ready. While one is still under way, it waits.
    fn reload(&mut self, reload: Asked) {
        match self.director.offer(&reload.0.scene.plan) {
            Ok(false) => self.waiting = Some(reload),
            Ok(true) => self.offered = Some(reload),
            Err(mismatch) => (self.audience)(Told::Kept(&mismatch.to_string(), reload.1)),
        }
        self.admit();
    }

    /// What is ready takes over: what comes from here on is meant for it.
    fn admit(&mut self) {
        if !self.director.is_ready() {
            return;
        }
        let Some((reload, cause)) = self.offered.take() else { return };
        self.plan += 1;
        // It is there when the new plan begins, and waits for that.
        let at = Instant { sample: self.board.clock.get(), fraction: 0 };
        let mut outlet = ToCallback { rings: &mut self.rings, clock: at.sample, plan: self.plan, cause };
        let brings = |event| outlet.send(at, Source::Program, event);
        let brought = sent(self.performer.unread(&reload.scene.plan, &reload.patch).all(brings));
        self.director.admit();
        self.next.push_back(Callings::of(&reload.scene.plan));
        (self.audience)(Told::Reloading(&reload, cause));
        let Reload { scene, patch, rig, files, .. } = *reload;
        // Those that play on may be called otherwise now.
        self.playing = vec![u64::MAX];
        let became = self.performer.become_of(scene, patch, rig, files);
        (self.audience)(Told::Reloaded);
        for problem in [became, brought].into_iter().filter_map(Result::err) {
            self.refuse(&problem, cause);
        }
    }
}

/// Where nobody conducts any more, nothing sounds: somebody who listens has panicked, and what is held would be for ever.
impl Drop for Conductor {
    fn drop(&mut self) {
        if !self.ended {
            self.board.lever.close(0);
        }
    }
}

fn sent(sent: bool) -> Result<(), Problem> {
    match sent {
        true => Ok(()),
        false => Err(Problem::of_file("more events came than the engine could take; play less at once")),
    }
}

#[cfg(test)]
mod tests;
