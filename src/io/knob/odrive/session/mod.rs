//! The session: settle, set up, drive, and let go.

mod drive;
mod set_up;

use std::f64::consts::TAU;

use super::lines::{Lines, Piece};
use super::settings::Settings;
use super::setup::{Errors, WATCHED};
use super::text::{self, command};
use crate::actuator::fault::Fault;
use crate::io::knob::budget::Budget;
use crate::io::knob::lost::Lost;
use crate::io::knob::servo::Servo;
use crate::io::knob::session::{Counts, Session, Turn};
use crate::io::knob::trip::{RoundTrip, Trips};

/// Closed loop, as the board counts its states, and idle.
const CLOSED: i64 = 8;
const IDLE: i64 = 1;

/// So long the line is quiet before set-up begins, and before a lost thread is taken up, seconds.
const SETTLED: f64 = 0.02;
const QUIET: f64 = 0.005;

/// So long an answer may take in set-up, and so often it is asked again.
const SLOW: f64 = 0.25;
const TRIES: u8 = 3;

/// So long a loop may take to close, and so long it may go on talking before it is asked anything.
const CLOSING: f64 = 2.0;

/// So often it is asked for its state while it is driven, seconds.
const GLANCE: f64 = 0.1;

/// The least time between two readings, seconds.
const LEAST: f64 = 1e-6;

/// Bytes a second that nobody asked for.
const SURPLUS: usize = 4096;

/// Where it stands.
#[derive(Debug, Clone, PartialEq)]
enum Stage {
    /// Nothing has begun.
    Off,
    /// Waits until what was said before has been said.
    Settling { since: f64 },
    /// A step of set-up.
    Setup(Setup),
    /// Exchange by exchange.
    Driven,
    /// Why did it leave closed loop?
    Diagnosing { state: i64 },
    /// Torque falls.
    Falling { since: f64, from: f64 },
    /// It was let go.
    Done,
    /// It is lost.
    Lost(Lost),
}

/// A step of set-up, under way.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Setup {
    /// Which.
    at: usize,
    /// By which of its names.
    name: usize,
    /// Whether it was asked, and is now set.
    set: bool,
    /// How often it was tried.
    tries: u8,
    /// Whether it said what it is.
    named: bool,
    /// Since when a loop closes.
    since: Option<f64>,
    /// Not before.
    after: f64,
}

/// What was asked.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Question {
    /// Where the knob is.
    Feedback,
    /// In which state the axis is.
    State,
    /// Anything else.
    Other,
}

/// A session with an ODrive.
#[derive(Debug)]
pub struct ODrive {
    settings: Settings,
    stage: Stage,
    lines: Lines,
    surplus: Budget,
    trips: Trips,
    counts: Counts,
    /// The last write, to know it again where it is echoed.
    sent: Vec<u8>,
    /// The question that was asked last, and when, while it has no answer.
    awaited: Option<(Question, f64)>,
    /// Since when the thread is lost, and whether torque is to be taken away at once.
    drain: Option<f64>,
    release: bool,
    /// What is asked next, so that its answer cannot be a late one; and whether that was asked.
    probe: Option<Question>,
    flushing: bool,
    heard: f64,
    /// When it gave an answer last, a reading last, and was last asked for its state.
    answered: f64,
    read: Option<f64>,
    glanced: f64,
    /// When the next exchange is due.
    next: f64,
    /// When its watchdog was fed last.
    fed: f64,
    torque: f64,
    /// Whether it was read since torque was taken away.
    felt: bool,
    /// Whether torque was taken away while an answer is awaited.
    eased: bool,
    /// What it is, how it tells its errors and whether it tells its state.
    identity: Vec<String>,
    errors: Option<Errors>,
    tells_state: bool,
}

impl ODrive {
    /// With these settings.
    ///
    /// # Errors
    /// The first setting beyond its limits.
    pub fn new(settings: Settings) -> Result<Self, Fault> {
        settings.check()?;
        Ok(Self {
            settings,
            stage: Stage::Off,
            lines: Lines::new(),
            surplus: Budget::new(SURPLUS),
            trips: Trips::new(),
            counts: Counts::default(),
            sent: Vec::with_capacity(256),
            awaited: None,
            drain: None,
            release: false,
            probe: None,
            flushing: false,
            heard: 0.0,
            answered: 0.0,
            read: None,
            glanced: 0.0,
            next: 0.0,
            fed: 0.0,
            torque: 0.0,
            felt: false,
            eased: false,
            identity: Vec::new(),
            errors: None,
            tells_state: false,
        })
    }

    fn period(&self) -> f64 {
        1.0 / self.settings.rate
    }

    /// Whether its watchdog runs, or may.
    fn is_watched(&self) -> bool {
        match &self.stage {
            Stage::Setup(setup) => setup.at >= WATCHED,
            Stage::Driven | Stage::Diagnosing { .. } | Stage::Falling { .. } => true,
            _ => false,
        }
    }

    fn end(&mut self, why: Lost) {
        if !matches!(self.stage, Stage::Lost(_) | Stage::Done | Stage::Off) {
            // Where its motor may be on it is told, in case it hears; its watchdog does the rest.
            self.release = self.is_watched();
            self.stage = Stage::Lost(why);
            self.counts.lost += 1;
            (self.torque, self.awaited, self.drain) = (0.0, None, None);
        }
    }

    /// The thread is lost: no torque until the next reading, and no question until the line is quiet.
    fn drop_thread(&mut self, now: f64) {
        // Readings that are still on their way come before the answer to this, and an old state does no harm.
        self.probe = Some(if self.tells_state { Question::State } else { Question::Feedback });
        (self.torque, self.awaited, self.drain, self.release) = (0.0, None, Some(now), true);
        self.felt = false;
    }

    fn line(&mut self, line: &[u8], now: f64, servo: &mut dyn Servo) {
        if self.sent.split(|byte| *byte == b'\n').any(|sent| sent == line) {
            return self.end(Lost::Echo(shown(line)));
        }
        let Some(text) = text::answer(line) else {
            if !matches!(self.stage, Stage::Settling { .. }) {
                self.counts.bad_checksum += 1;
                self.puzzled(line, now);
            }
            return;
        };
        let Some((question, asked)) = self.awaited else {
            // What another program had asked says nothing.
            if !matches!(self.stage, Stage::Settling { .. }) {
                let late = self.drain.is_some() && text::feedback(text).is_some();
                *(if late { &mut self.counts.late } else { &mut self.counts.unexpected }) += 1;
            }
            return;
        };
        match self.stage.clone() {
            Stage::Setup(setup) => {
                self.surplus.credit(line.len() + 2);
                self.setup_answer(setup, text, now, servo);
            }
            Stage::Diagnosing { state } => self.diagnosed(state, text::value(text).unwrap_or(0.0) as u64),
            _ => match (question, text::feedback(text), text::value(text)) {
                (Question::Feedback, Some((turns, speed)), _) => {
                    self.surplus.credit(line.len() + 2);
                    self.reading(turns * TAU, speed * TAU, now, asked, servo);
                }
                (Question::State, None, Some(state)) => {
                    self.surplus.credit(line.len() + 2);
                    (self.awaited, self.answered, self.flushing) = (None, now, false);
                    if state as i64 != CLOSED {
                        self.left(state as i64);
                    }
                }
                (_, Some(_), _) | (_, _, Some(_)) if self.flushing => self.counts.late += 1,
                _ => {
                    self.counts.unexpected += 1;
                    self.puzzled(line, now);
                }
            },
        }
    }

    /// It said what cannot be understood.
    fn puzzled(&mut self, line: &[u8], now: f64) {
        match &mut self.stage {
            Stage::Setup(setup) => {
                setup.tries += 1;
                setup.after = now + SETTLED;
                self.awaited = None;
                if setup.tries >= TRIES {
                    self.end(Lost::Dialect(shown(line)));
                }
            }
            Stage::Driven | Stage::Falling { .. } => self.drop_thread(now),
            _ => {}
        }
    }

    fn step(&mut self, now: f64, out: &mut Vec<u8>) -> Turn {
        match self.stage.clone() {
            Stage::Off | Stage::Done => Turn::Done,
            Stage::Settling { since } => {
                let quiet = since.max(self.heard) + SETTLED;
                if self.sent.is_empty() {
                    // Ends what another program may have begun.
                    out.push(b'\n');
                } else if now - since > CLOSING {
                    self.end(Lost::Dialect("it never stops to talk".into()));
                    return self.step(now, out);
                } else if now >= quiet {
                    self.lines.forget();
                    self.stage = Stage::Setup(Setup::default());
                    return self.step(now, out);
                }
                Turn::Until { time: quiet, awaits: true }
            }
            Stage::Setup(setup) => self.turn_setup(setup, now, out),
            Stage::Driven | Stage::Falling { .. } => self.turn_driven(now, out),
            Stage::Diagnosing { state } => self.turn_diagnosing(state, now, out),
            Stage::Lost(why) => {
                if std::mem::take(&mut self.release) {
                    let axis = self.settings.axis;
                    command(out, format_args!("c {axis} 0"));
                    command(out, format_args!("w axis{axis}.requested_state {IDLE}"));
                }
                Turn::Lost(why)
            }
        }
    }
}

/// A line as it can be shown.
fn shown(line: &[u8]) -> String {
    let text: String = String::from_utf8_lossy(line).chars().take(40).collect();
    format!("`{}`", text.escape_debug())
}

impl Session for ODrive {
    fn begin(&mut self, now: f64) {
        self.stage = Stage::Settling { since: now };
        self.lines.forget();
        self.sent.clear();
        self.identity.clear();
        self.surplus = Budget::new(SURPLUS);
        (self.awaited, self.drain, self.release, self.read) = (None, None, false, None);
        (self.errors, self.tells_state, self.torque, self.felt) = (None, false, 0.0, false);
        (self.heard, self.answered, self.fed) = (now, now, now);
    }

    fn hear(&mut self, bytes: &[u8], now: f64, servo: &mut dyn Servo) {
        if bytes.is_empty() || matches!(self.stage, Stage::Off | Stage::Done | Stage::Lost(_)) {
            return;
        }
        self.heard = now;
        for byte in bytes {
            if let Some(spent) = self.surplus.spend(1, now) {
                self.end(Lost::Flood(spent));
            }
            if matches!(self.stage, Stage::Lost(_)) {
                return;
            }
            match self.lines.push(*byte) {
                Some(Piece::Line(line)) => self.line(&line, now, servo),
                Some(Piece::TooLong) => {
                    self.counts.unexpected += 1;
                    self.puzzled(b"a line without end", now);
                }
                None => {}
            }
        }
    }

    fn turn(&mut self, now: f64, servo: &mut dyn Servo, out: &mut Vec<u8>) -> Turn {
        let before = out.len();
        self.refresh(now, servo);
        let eased = self.ease(now, out);
        let turn = self.step(now, out);
        if out.len() > before {
            // What is awaited may still be said back.
            if !eased {
                self.sent.clear();
            }
            self.sent.extend_from_slice(&out[before..]);
        }
        turn
    }

    fn lose(&mut self, why: &Lost) {
        self.end(why.clone());
    }

    fn stop(&mut self, now: f64) {
        match self.stage {
            Stage::Driven => self.stage = Stage::Falling { since: now, from: self.torque },
            Stage::Lost(_) | Stage::Done | Stage::Off | Stage::Falling { .. } => {}
            // Torque is 0; its loop may be closing.
            _ if self.is_watched() => self.stage = Stage::Falling { since: f64::NEG_INFINITY, from: 0.0 },
            _ => self.stage = Stage::Done,
        }
    }

    fn torque(&self) -> f64 {
        self.torque
    }

    fn is_ready(&self) -> bool {
        self.stage == Stage::Driven && self.read.is_some()
    }

    fn counts(&self) -> Counts {
        self.counts
    }

    fn round_trip(&self) -> RoundTrip {
        self.trips.sum_up()
    }
}
