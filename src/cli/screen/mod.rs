//! What a person sees while a session plays: a screen where there is a terminal for it, and lines of a log elsewhere.

mod bar;
mod controls;
mod dial;
mod draw;
mod echo;
mod fold;
pub mod happened;
mod head;
mod keys;
mod line;
mod lines;
mod meter;
mod meters;
mod moves;
mod panel;
mod players;
mod post;
mod saved;
mod snapshot;
pub mod tty;
mod window;

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use crossterm::event::Event;
use pacinian::io::device::keeper::Fate;
use pacinian::io::session::Session;
use pacinian::live::board::Board;
use pacinian::live::gate::RAMP_IN;
use pacinian::live::signal::Signal;
use pacinian::live::torque::Torque;
use pacinian::text::Problems;

use super::device_queue;
use super::failure::Failure;
use super::loaded::Loaded;
use super::priority;
use super::terminal::Terminal;
use controls::Controls;
use echo::Echo;
use happened::{Happened, Mood};
use keys::{Act, Keys};
use lines::Lines;
pub use lines::cut_short;
use meter::Meter;
use moves::Moves;
use players::Players;
pub use post::Post;
use post::{PostBox, State, post};
use saved::title;
pub use snapshot::Latency;
use snapshot::{Figures, Snapshot};
use window::Screen;

/// From one drawing to the next.
const FRAME: Duration = Duration::from_millis(50);

/// So often it is looked whether somebody has typed or asked to stop.
const LOOK: Duration = Duration::from_millis(20);

/// From one line that says how things stand to the next, seconds.
const STATUS: f64 = 10.0;

/// Events that are kept for the screen, and problems for after it.
const KEPT: usize = 200;
const TROUBLES: usize = 20;

/// What is played on what.
pub struct Scenery<'a> {
    /// Patch and rig.
    pub loaded: &'a Loaded,
    /// The patterns that play from the beginning.
    pub first: &'a [usize],
    /// The device.
    pub device: &'a str,
    /// Frames a second.
    pub rate: u32,
    /// Full level, or -20 dB.
    pub armed: bool,
    /// Seconds that it is to last.
    pub duration: Option<f64>,
    /// The control that keys move at first.
    pub control: Option<&'a str>,
}

/// Why a session is to end.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// Somebody wants it to, with this exit code if not with success.
    Asked(Option<u8>),
    /// The terminal is closed.
    Closed,
}

enum Out {
    Screen(Screen),
    Lines(Lines),
}

/// Shows a session.
pub struct Show {
    out: Out,
    snapshot: Snapshot,
    players: Players,
    controls: Controls,
    keys: Keys,
    fetch: PostBox,
    events: VecDeque<Happened>,
    troubles: VecDeque<Happened>,
    echo: Echo,
    moves: Moves,
    heard: f64,
    told: f64,
    /// The highest of all channels since the last line that said how things stand.
    highest: f32,
    panicked: bool,
    torque: Torque,
    xruns: u64,
    /// How much of the periodic work rests.
    shed: u64,
    /// Gaps of the input, by what made them.
    gaps: [u64; 4],
    /// The loop's latency, as the rig has it.
    beyond: Option<f64>,
    /// Whether a frame is due now.
    due: bool,
    /// Whether it was said that the system gives no priority.
    humble: bool,
    /// Warnings that were shown, and why what was saved last does not play, in full.
    warned: Vec<Problems>,
    stale: String,
    terminal: Terminal,
    held: tty::Held,
}

impl Show {
    /// Ready to show what comes by post. The terminal is taken over by [`Show::begin`].
    ///
    /// # Errors
    /// A thread that the system does not give.
    pub fn new(scenery: &Scenery<'_>, terminal: &Terminal) -> Result<(Self, Post), Failure> {
        let loaded = scenery.loaded;
        let players = Players::new(&loaded.patch, scenery.first);
        let snapshot = Snapshot {
            title: title(loaded),
            device: scenery.device.into(),
            rate: scenery.rate,
            duration: scenery.duration,
            armed: scenery.armed,
            tactors: loaded.tactors().into_iter().map(|name| (name, Meter::default())).collect(),
            fancy: tty::is_fancy(|name| std::env::var(name).ok()),
            ..Snapshot::default()
        };
        let no_thread = |error: std::io::Error| Failure::no_thread("what is shown", &error);
        let out = match tty::is_fit(terminal) {
            true => Out::Screen(Screen::new(terminal.out.0).map_err(no_thread)?),
            false => Out::Lines(Lines::begin(*terminal).map_err(no_thread)?),
        };
        let (post, fetch) = post();
        let mut controls = Controls::new(&loaded.patch);
        scenery.control.into_iter().for_each(|name| controls.choose_named(name));
        let show = Self {
            out,
            snapshot,
            players,
            controls,
            keys: Keys::default(),
            fetch,
            events: VecDeque::new(),
            troubles: VecDeque::new(),
            echo: Echo::default(),
            moves: Moves::default(),
            heard: 0.0,
            told: 0.0,
            highest: 0.0,
            panicked: false,
            torque: Torque::None,
            xruns: 0,
            shed: 0,
            gaps: [0; 4],
            beyond: loaded.rig.device.loop_latency,
            due: true,
            humble: false,
            warned: loaded.warnings.clone(),
            stale: String::new(),
            terminal: *terminal,
            held: tty::Held::now(),
        };
        Ok((show, post))
    }

    /// Shows that something is wrong.
    pub fn say(&mut self, trouble: &str) {
        let happened = Happened::new(self.fetch.now(), Mood::Bad, trouble);
        self.note(happened);
    }

    /// Shows what is good to know.
    pub fn tell(&mut self, what: &str) {
        let happened = Happened::new(self.fetch.now(), Mood::Told, what);
        self.note(happened);
    }

    /// Where it is a screen, which hides what was said before.
    pub fn say_on_screen(&mut self, what: &str) {
        if matches!(self.out, Out::Screen(_)) {
            self.say(what);
        }
    }

    /// Takes the terminal over, where there is to be a screen. `closing` is set at the moment at which that terminal is gone.
    ///
    /// # Errors
    /// A terminal that does not let itself be taken.
    pub fn begin(&mut self, closing: Arc<AtomicBool>) -> Result<(), Failure> {
        let Out::Screen(screen) = &mut self.out else { return Ok(()) };
        screen.begin(closing).map_err(|error| {
            Failure::said(74, format!("the terminal cannot be used ({error}); --plain does without"))
        })
    }

    /// Waits for keys for a moment, does what they say, and shows how the session stands.
    pub fn step(&mut self, session: &Session) -> Option<Ending> {
        if matches!(self.out, Out::Lines(_)) {
            std::thread::sleep(LOOK);
        }
        self.listen(session.board());
        let ending = match &mut self.out {
            Out::Screen(screen) => match screen.keys() {
                Some(typed) => typed.into_iter().find_map(|event| self.typed(&event, session)),
                None => Some(Ending::Closed),
            },
            Out::Lines(_) => self.held.is_gone().then_some(Ending::Closed),
        };
        let elapsed = self.fetch.elapsed();
        if std::mem::take(&mut self.due) || elapsed - self.heard >= FRAME.as_secs_f64() {
            self.look(session, elapsed);
            if let Out::Screen(screen) = &mut self.out {
                self.snapshot.events = self.events.iter().cloned().collect();
                self.snapshot.keys = self.players.faces();
                self.snapshot.keyless = self.players.keyless();
                self.snapshot.controls = self.controls.faces();
                self.snapshot.missed = self.fetch.missed();
                if !screen.show(&self.snapshot) {
                    return Some(Ending::Closed);
                }
            }
        }
        if elapsed - self.told >= STATUS {
            (self.told, self.snapshot.elapsed) = (elapsed, elapsed);
            let line = lines::status(&self.snapshot, self.highest);
            self.highest = 0.0;
            if let Out::Lines(lines) = &mut self.out {
                lines.put(&line);
            }
        }
        ending
    }

    /// Takes what has come by post, and what the board says by itself.
    fn listen(&mut self, board: &Board) {
        let seconds = board.frames.get() as f64 / f64::from(self.snapshot.rate.max(1));
        let unfelt = match board.absence() {
            (_, true) => Some("the device is away"),
            _ => board.is_panicked().then_some("the output is shut"),
        };
        let events = self.fetch.events(board.clock.get(), seconds, unfelt);
        // All of it was before now, so what is told as of now comes behind it.
        events.into_iter().for_each(|happened| self.note(happened));
        if let Out::Lines(lines) = &mut self.out {
            lines.missed(self.fetch.missed());
        }
        let now = self.fetch.now();
        self.controls.hear(&self.fetch.moved());
        let states: Vec<State> = self.fetch.states().collect();
        for state in states {
            match state {
                State::Device(fate) => {
                    match fate {
                        Fate::Lost(_) => self.snapshot.lost = true,
                        Fate::Back => self.snapshot.lost = false,
                        Fate::Lowered => self.snapshot.armed = false,
                        Fate::Moved | Fate::Said(_) => {}
                    }
                    self.note(Happened::fate(now, fate));
                }
                State::Armed(armed) => {
                    self.snapshot.armed = armed;
                    let text = if armed { "armed: full level" } else { "at -20 dB" };
                    self.note(Happened::new(now, Mood::Told, text));
                }
                State::SetOff(name) => {
                    if matches!(self.out, Out::Lines(_)) {
                        self.players.set_off(name);
                    }
                }
                State::Playing(playing) => {
                    // The screen shows it at its keys.
                    if matches!(self.out, Out::Lines(_)) {
                        for (at_first, what) in self.players.changes(&playing) {
                            // What is ready before the output is open begins when it is.
                            let at = if at_first { now.max(RAMP_IN) } else { now };
                            self.note(Happened::new(at, Mood::Told, what));
                        }
                    }
                    self.players.play(playing.into_iter().map(|(_, name)| name).collect());
                }
            }
        }
        if let (Some(held), Out::Lines(lines)) = (self.echo.due(now), &mut self.out) {
            lines.put(&lines::event(&held));
        }
        self.say_moves(now);
        let panicked = board.is_panicked();
        if panicked != std::mem::replace(&mut self.panicked, panicked) {
            let (mood, text) = match panicked {
                true => (Mood::Bad, format!("panic: the output is shut; {}", device_queue::told(board))),
                false => (Mood::Good, self.players.after_panic(matches!(self.out, Out::Screen(_)))),
            };
            self.note(Happened::new(now, mood, text));
        }
        self.snapshot.panicked = panicked;
        self.snapshot.knob = board.knob();
        let torque = board.torque();
        self.snapshot.torque = (torque != Torque::None).then(|| torque.is_wanted());
        let before = std::mem::replace(&mut self.torque, torque);
        // One that is simulated begins with it.
        if torque != before && torque != Torque::None && (before, torque) != (Torque::None, Torque::Simulated)
        {
            let mood = match torque {
                Torque::Fallen(_) => Mood::Bad,
                Torque::On | Torque::Simulated => Mood::Good,
                Torque::None | Torque::Off | Torque::Asked => Mood::Told,
            };
            self.note(Happened::new(now, mood, torque.to_string()));
        }
        if !self.humble
            && let Some(text) = priority::told()
        {
            self.humble = true;
            self.note(Happened::new(now, Mood::Told, text));
        }
    }

    /// Writes where controls have come to, of which not every move was written.
    fn say_moves(&mut self, now: f64) {
        if let Out::Lines(lines) = &mut self.out {
            self.moves.due(now).iter().for_each(|happened| lines.put(&lines::event(happened)));
        }
    }

    /// Shows that something happened; where the same happens again and again, how often.
    fn note(&mut self, happened: Happened) {
        if let Out::Lines(lines) = &mut self.out {
            if let Some(happened) = self.moves.take(happened) {
                self.echo.take(happened).for_each(|happened| lines.put(&lines::event(&happened)));
            }
            return;
        }
        if happened.mood == Mood::Bad {
            if self.troubles.len() >= TROUBLES {
                self.troubles.pop_front();
            }
            self.troubles.push_back(happened.clone());
            if let Some(last) = self.events.back_mut().filter(|last| last.text == happened.text) {
                (last.at, last.again) = (happened.at, last.again + 1);
                return;
            }
        }
        if self.events.len() >= KEPT {
            self.events.pop_front();
        }
        self.events.push_back(happened);
    }

    /// Reads the board.
    fn look(&mut self, session: &Session, elapsed: f64) {
        let (board, since) = (session.board(), elapsed - self.heard);
        self.heard = elapsed;
        for (channel, (_, meter)) in self.snapshot.tactors.iter_mut().enumerate() {
            let peak = board.take_peak(channel);
            meter.hear(peak, since);
            self.highest = self.highest.max(peak);
        }
        self.snapshot.elapsed = elapsed;
        self.snapshot.latency = Latency::of(session, self.beyond);
        self.snapshot.refused = board.refused.words();
        self.snapshot.figures = Figures {
            mean: board.load.mean(),
            p999: board.load.quantile(0.999),
            over: board.load.over(),
            xruns: board.xruns.get(),
            late: board.late.get(),
            lost: board.dropped.get() + board.refused.get(),
            limited: board.limited.get(),
            clamped: board.clamped.get(),
            masked: board.masked.get(),
            held_back: board.held_back.get(),
            midi: board.midi.unused(),
            voices: board.voices.get(),
            started: board.started.get(),
            stolen: board.stolen.get(),
        };
        let (heard, now) = (&board.input, self.fetch.now());
        let gaps = [
            ("an input xrun", heard.xruns.get()),
            ("the input came too late: a gap", heard.dry.get()),
            ("too much input waited: a part is left out", heard.jumps.get()),
            ("input found no room", u64::from(heard.lost.get() > 0)),
        ];
        for ((text, count), before) in gaps.into_iter().zip(self.gaps) {
            if count > before {
                self.note(Happened::new(now, Mood::Bad, text));
            }
        }
        self.gaps = gaps.map(|(_, count)| count);
        let shed = board.shed.get();
        // Meters rest first.
        self.snapshot.blind = shed > 0;
        if std::mem::replace(&mut self.shed, shed) != shed {
            let resting = session.duties().iter().filter(|duty| duty.is_resting());
            let names = resting.map(|duty| duty.name()).collect::<Vec<_>>().join(", ");
            let happened = match shed {
                0 => Happened::new(now, Mood::Good, "there is time enough again, and nothing rests"),
                _ => Happened::new(now, Mood::Bad, format!("too much to do: rests: {names}")),
            };
            self.note(happened);
        }
        let xruns = self.snapshot.figures.xruns;
        let before = std::mem::replace(&mut self.xruns, xruns);
        if xruns > before {
            let text =
                if xruns - before == 1 { "an xrun".into() } else { format!("{} xruns", xruns - before) };
            self.note(Happened::new(now, Mood::Bad, text));
        }
    }

    fn typed(&mut self, event: &Event, session: &Session) -> Option<Ending> {
        let act = match event {
            Event::Key(key) => self.keys.press(*key, Instant::now(), session.board().is_panicked())?,
            Event::Resize(..) => Act::Redraw,
            _ => return None,
        };
        let handle = session.handle().from(keys::origin(event));
        let number = || handle.number();
        let signals = match act {
            Act::End(code) => return Some(Ending::Asked(code)),
            Act::Panic => {
                handle.panic();
                Ok(Vec::new())
            }
            Act::Calm => Ok(vec![Signal::Calm]),
            Act::Arm => Ok(vec![Signal::Arm(!self.snapshot.armed)]),
            Act::Torque => Ok(vec![Signal::Torque(!session.board().torque().is_wanted())]),
            Act::Digit(digit) => self.players.digit(digit, number),
            Act::All => self.players.all(number),
            Act::Turn(by) => Ok(self.turn(by)),
            Act::Choose(by) | Act::Move(by) if self.controls.is_empty() => Ok(self.turn(by.signum())),
            Act::Choose(by) => {
                self.controls.choose(by);
                Ok(Vec::new())
            }
            Act::Move(by) => Ok(sent_to(self.controls.step(by))),
            Act::Reset if self.controls.is_empty() => Err("this patch has no controls".into()),
            Act::Reset => Ok(sent_to(self.controls.reset())),
            Act::Form => {
                (self.snapshot.paged, self.snapshot.page) = (!self.snapshot.paged, 0);
                Ok(Vec::new())
            }
            Act::Redraw => {
                if let Out::Screen(screen) = &self.out {
                    screen.redraw();
                }
                Ok(Vec::new())
            }
        };
        let sent = signals.and_then(|signals| {
            signals.into_iter().try_for_each(|s| handle.send(s)).map_err(|refused| refused.to_string())
        });
        if let Err(why) = sent {
            self.note(Happened::new(self.fetch.now(), Mood::Bad, why));
        }
        // What was asked for is to be seen at once.
        self.due = true;
        None
    }

    /// Other pages of the meters.
    fn turn(&mut self, by: i32) -> Vec<Signal> {
        if let Out::Screen(screen) = &self.out {
            let pages = screen.pages();
            let page = self.snapshot.page.min(pages - 1) + pages;
            self.snapshot.page = page.saturating_add_signed(by as isize) % pages;
        }
        Vec::new()
    }

    /// Gives the terminal back, and says what went wrong while the screen was there. Gives the highest magnitude of each channel.
    pub fn end(mut self, board: &Board, terminal: &Terminal) -> Vec<f32> {
        self.listen(board);
        self.say_moves(f64::INFINITY);
        if let (Some(held), Out::Lines(lines)) = (self.echo.release(self.fetch.now()), &mut self.out) {
            lines.put(&lines::event(&held));
        }
        let peak =
            |(channel, (_, meter)): (usize, &(String, Meter))| meter.most.max(board.take_peak(channel));
        let peaks = self.snapshot.tactors.iter().enumerate().map(peak).collect();
        let screen = matches!(self.out, Out::Screen(_));
        drop(self.out);
        let troubles: String = self.troubles.iter().map(|trouble| lines::event(trouble) + "\n").collect();
        // Where there is nothing to say, nobody waits for who does not read.
        if !troubles.is_empty() {
            terminal.note(&troubles);
        }
        if screen && !self.stale.is_empty() {
            terminal.note(&format!("what was saved last was not played:\n{}", self.stale));
        }
        peaks
    }
}

/// A control is sent there.
fn sent_to(moved: Option<(String, f64)>) -> Vec<Signal> {
    moved.into_iter().map(|(name, value)| Signal::Set(name, value)).collect()
}
