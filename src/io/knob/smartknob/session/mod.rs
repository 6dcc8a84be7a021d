//! The session: wake, listen, and tell it what to be.

mod telling;

use std::hash::{BuildHasher, RandomState};
use std::sync::{Arc, Mutex, PoisonError};

use super::config::Config;
use super::frame::{Frames, pack};
use super::message::{Dialect, FromKnob, State, ToKnob, dialect};
use crate::actuator::fault::{Fault, Limit, check};
use crate::io::knob::budget::Budget;
use crate::io::knob::lost::Lost;
use crate::io::knob::servo::{News, Reading, Servo};
use crate::io::knob::session::{Counts, Session, Turn};
use crate::io::knob::trip::{RoundTrip, Trips};

/// Zeros that end its mode of plain text.
const WAKE: [u8; 8] = [0; 8];

/// What is not acknowledged is sent again after so long, seconds, and so often.
const AGAIN: f64 = 0.25;
const TRIES: u32 = 8;

/// A board that was just reset takes seconds until it hears.
const WAKE_TRIES: u32 = 20;

/// So long after a sign of life it is taken to be in the mode of frames; so long without one it is asked for one, seconds.
const ALIVE: f64 = 0.3;
const SILENT: f64 = 2.0;

/// So long what it was told to be may take until it says it back, seconds.
const IN_FORCE: f64 = 1.5;

/// The least time between two readings, seconds.
const LEAST: f64 = 1e-6;

/// States that should pass in a second, and messages and damaged bytes that may.
const RATE: f64 = 200.0;
const MOST_MESSAGES: usize = 2_000;
const SURPLUS: usize = 16_384;

/// What a session with a SmartKnob keeps to.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Where the numbers of its messages begin. The knob remembers the last one, so two runs should not begin with the same.
    pub seed: u32,
    /// What the knob is to be when it is let go of; `None`: as it was.
    pub parting: Option<Config>,
}

impl Default for Settings {
    /// A seed by chance; the knob stays as it was.
    fn default() -> Self {
        Self { seed: RandomState::new().hash_one(0_u8) as u32, parting: None }
    }
}

/// What a knob is to be, and how its angle is counted.
#[derive(Debug, Clone, PartialEq)]
pub struct Feel {
    /// What it is to be. Its `position_nonce` is given by the session.
    pub config: Config,
    /// The angle of its position 0, radians.
    pub origin: f64,
    /// Whether it stays where it is rather than take the configuration's position.
    pub stay: bool,
}

/// Tells a running knob what to be.
#[derive(Debug, Clone)]
pub struct Remote {
    slot: Arc<Mutex<Option<Feel>>>,
}

impl Remote {
    /// The knob is to be this as soon as it can. What it was to be before and is not yet is forgotten.
    ///
    /// # Errors
    /// What the knob would refuse.
    pub fn set(&self, feel: Feel) -> Result<(), Fault> {
        feel.config.check()?;
        check("origin", feel.origin, Limit::Least(f64::MIN))?;
        *self.slot.lock().unwrap_or_else(PoisonError::into_inner) = Some(feel);
        Ok(())
    }
}

/// A message until it is acknowledged.
#[derive(Debug, Clone, PartialEq)]
struct Flight {
    nonce: u32,
    message: Vec<u8>,
    sent: f64,
    tries: u32,
}

/// What it is told to be, until it is.
#[derive(Debug, Clone, PartialEq)]
struct Telling {
    feel: Feel,
    flight: Flight,
    acknowledged: Option<f64>,
}

#[derive(Debug, Clone, PartialEq)]
enum Stage {
    Off,
    /// Zeros were sent, or are to be; whether one came back.
    Waking {
        since: f64,
        sent: bool,
        zero: bool,
        frames: u64,
    },
    Ready,
    /// It is let go of.
    Leaving {
        since: f64,
    },
    Done,
    Lost(Lost),
}

/// A session with a SmartKnob.
#[derive(Debug)]
pub struct SmartKnob {
    settings: Settings,
    slot: Arc<Mutex<Option<Feel>>>,
    stage: Stage,
    frames: Frames,
    surplus: Budget,
    messages: Budget,
    trips: Trips,
    counts: Counts,
    nonce: u32,
    dialect: Option<Dialect>,
    /// The question whether it is there.
    ping: Option<Flight>,
    /// What it is to be next, is being told to be, and is.
    waiting: Option<Feel>,
    telling: Option<Telling>,
    current: Option<Feel>,
    /// Since when it says that it is something else.
    strays: Option<f64>,
    press: Option<u8>,
    log: String,
    alive: f64,
    /// The newest angle that the servo has not got yet, and when it got one last.
    angle: Option<f64>,
    read: Option<f64>,
}

impl SmartKnob {
    /// With these settings, and what tells it what to be.
    ///
    /// # Errors
    /// A parting that the knob would refuse.
    pub fn new(settings: Settings) -> Result<(Self, Remote), Fault> {
        settings.parting.as_ref().map_or(Ok(()), Config::check)?;
        let slot = Arc::new(Mutex::new(None));
        let remote = Remote { slot: Arc::clone(&slot) };
        let session = Self {
            nonce: settings.seed,
            settings,
            slot,
            stage: Stage::Off,
            frames: Frames::default(),
            surplus: Budget::new(SURPLUS),
            messages: Budget::new(MOST_MESSAGES),
            trips: Trips::new(),
            counts: Counts::default(),
            dialect: None,
            ping: None,
            waiting: None,
            telling: None,
            current: None,
            strays: None,
            press: None,
            log: String::new(),
            alive: f64::NEG_INFINITY,
            angle: None,
            read: None,
        };
        Ok((session, remote))
    }

    /// The next number, which is never 0, as that would not be on the wire.
    fn count(&mut self) -> u32 {
        self.nonce = self.nonce.wrapping_add(0x9e37_79b9);
        if self.nonce == 0 {
            self.nonce = 0x9e37_79b9;
        }
        self.nonce
    }

    /// A question for its state, whose frame has no byte that a knob in plain text would take for a command.
    fn question(&mut self, now: f64) -> Flight {
        let is_mute =
            |nonce: u32| !pack(&ToKnob::State.encode(nonce)).iter().any(|b| (0x20..0x7f).contains(b));
        // One in sixty is such a number; 7 is.
        let nonce = (0..10_000).map(|_| self.count()).find(|nonce| is_mute(*nonce)).unwrap_or(7);
        Flight { nonce, message: ToKnob::State.encode(nonce), sent: now, tries: 1 }
    }

    fn end(&mut self, why: Lost) {
        if !matches!(self.stage, Stage::Lost(_) | Stage::Done | Stage::Off) {
            self.stage = Stage::Lost(why);
            self.counts.lost += 1;
        }
    }

    fn is_alive(&self, now: f64) -> bool {
        now - self.alive <= ALIVE
    }

    fn message(&mut self, bytes: &[u8], now: f64, servo: &mut dyn Servo) {
        let asked = self.ping.as_ref().is_some_and(|ping| ping.message == bytes);
        let told = self.telling.as_ref().is_some_and(|telling| telling.flight.message == bytes);
        if asked || told {
            return self.end(Lost::Echo("a frame".into()));
        }
        if let Stage::Waking { frames, .. } = &mut self.stage {
            *frames += 1;
            let Some(ping) = &self.ping else { return };
            let Some(found) = dialect(bytes, ping.nonce) else {
                if let Ok(FromKnob::Version(version)) = FromKnob::decode(bytes, Dialect::Original) {
                    self.end(Lost::Dialect(format!("frames of version {version}, and 1 is known")));
                }
                return;
            };
            if ping.tries == 1 {
                self.trips.push(now - ping.sent);
            }
            (self.dialect, self.ping, self.stage) = (Some(found), None, Stage::Ready);
            self.alive = now;
            let of = if found == Dialect::Original { "its first firmware" } else { "SeedLabs's firmware" };
            return servo.news(&News::Ready(format!("SmartKnob with {of}")));
        }
        let Some(known) = self.dialect else { return };
        match FromKnob::decode(bytes, known) {
            Err(_) => return self.counts.unexpected += 1,
            Ok(FromKnob::Version(version)) => {
                return self.end(Lost::Dialect(format!("frames of version {version}, and 1 is known")));
            }
            Ok(FromKnob::Ack(nonce)) => self.acknowledged(nonce, now),
            Ok(FromKnob::Log(line)) => self.log = line,
            Ok(FromKnob::State(state)) => self.state(&state, now, servo),
            Ok(FromKnob::Other) => {}
        }
        self.alive = now;
        // Whatever it says, it is there.
        if self.ping.as_ref().is_some_and(|ping| now > ping.sent) {
            self.ping = None;
        }
    }

    fn acknowledged(&mut self, nonce: u32, now: f64) {
        if let Some(ping) = self.ping.take_if(|ping| ping.nonce == nonce) {
            if ping.tries == 1 {
                self.trips.push(now - ping.sent);
            }
        } else if let Some(telling) = self.telling.as_mut().filter(|telling| telling.flight.nonce == nonce) {
            if telling.acknowledged.is_none() && telling.flight.tries == 1 {
                self.trips.push(now - telling.flight.sent);
            }
            telling.acknowledged.get_or_insert(now);
        } else {
            self.counts.late += 1;
        }
    }

    fn state(&mut self, state: &State, now: f64, servo: &mut dyn Servo) {
        if let Some(telling) = self.telling.take_if(|telling| telling.feel.config.is_in_force(&state.config))
        {
            servo.news(&News::InForce(telling.feel.config.text.clone()));
            (self.current, self.strays) = (Some(telling.feel), None);
        } else if let (Some(current), None, None) = (&self.current, &self.telling, &self.waiting) {
            if current.config.is_in_force(&state.config) {
                self.strays = None;
            } else if now - *self.strays.get_or_insert(now) > ALIVE {
                servo.news(&News::Note("the knob has become something else; it is told again".into()));
                (self.waiting, self.strays) = (Some(current.clone()), None);
            }
        }
        if let Some(before) = self.press.replace(state.press_nonce)
            && before != state.press_nonce
        {
            servo.news(&News::Press(state.press_nonce.wrapping_sub(before)));
        }
        let Some(angle) = state.angle() else {
            self.counts.unexpected += 1;
            return;
        };
        self.angle = Some(self.current.as_ref().map_or(0.0, |feel| feel.origin) + angle);
    }

    /// Hands the newest angle on. Of states that come together only the last one says anything.
    fn reading(&mut self, now: f64, servo: &mut dyn Servo) {
        let Some(angle) = self.angle.take() else { return };
        let dt = self.read.map_or(1.0 / RATE, |last| (now - last).max(LEAST));
        self.read = Some(now);
        self.counts.readings += 1;
        // The knob makes its own torque.
        servo.tick(&Reading { angle, velocity: None, dt, round_trip: self.trips.sum_up() });
    }

    fn turn_ready(&mut self, now: f64, servo: &mut dyn Servo, out: &mut Vec<u8>) -> Turn {
        if let Some(feel) = self.slot.lock().unwrap_or_else(PoisonError::into_inner).take() {
            self.waiting = Some(feel);
        }
        if let Some(why) = self.tell_again(now, out)
            && let Some(telling) = self.telling.take()
        {
            servo.news(&News::Refused(telling.feel.config.text, why));
        }
        if self.ask_again(TRIES, now, out) {
            self.end(Lost::Stalled(now - self.alive));
            return self.step(now, servo, out);
        }
        let owes = self.telling.as_ref().is_some_and(|telling| match telling.acknowledged {
            None => now - telling.flight.sent >= AGAIN,
            Some(since) => now - since >= 2.0 * AGAIN && now - self.read.unwrap_or(since) >= 2.0 * AGAIN,
        });
        let wanted = self.waiting.is_some() && self.telling.is_none();
        if wanted && self.is_alive(now) {
            self.log.clear();
            if let Some(feel) = self.waiting.take() {
                self.tell(feel, now, out);
            }
        } else if self.ping.is_none()
            && ((wanted || owes) && !self.is_alive(now) || now - self.alive > SILENT)
        {
            self.ask(now, out);
        }
        Turn::Until { time: now + 0.01, awaits: true }
    }

    fn step(&mut self, now: f64, servo: &mut dyn Servo, out: &mut Vec<u8>) -> Turn {
        match self.stage.clone() {
            Stage::Off | Stage::Done => Turn::Done,
            Stage::Waking { sent: false, zero, frames, .. } => {
                out.extend(WAKE);
                self.stage = Stage::Waking { since: now, sent: true, zero, frames };
                Turn::Until { time: now + AGAIN, awaits: true }
            }
            Stage::Waking { since, zero, frames, .. } => {
                if self.ping.is_none() {
                    if !zero && now - since < AGAIN {
                        return Turn::Until { time: since + AGAIN, awaits: true };
                    }
                    self.ask(now, out);
                } else if self.ask_again(WAKE_TRIES, now, out) {
                    self.end(match frames {
                        0 => Lost::Silent("eight zeros and a question for its state".into()),
                        _ => Lost::Dialect("frames, of which none acknowledges a question".into()),
                    });
                    return self.step(now, servo, out);
                }
                Turn::Until { time: self.ping.as_ref().map_or(now, |ping| ping.sent + AGAIN), awaits: true }
            }
            Stage::Ready => {
                servo.rest();
                self.turn_ready(now, servo, out)
            }
            Stage::Leaving { since } => {
                let turn = self.turn_ready(now, servo, out);
                let told = self.telling.as_ref().is_none_or(|telling| telling.acknowledged.is_some());
                if (self.waiting.is_none() && told) || now - since > 4.0 * AGAIN {
                    self.stage = Stage::Done;
                    return Turn::Done;
                }
                turn
            }
            Stage::Lost(why) => Turn::Lost(why),
        }
    }
}

impl Session for SmartKnob {
    fn begin(&mut self, now: f64) {
        self.stage = Stage::Waking { since: now, sent: false, zero: false, frames: 0 };
        self.frames.forget();
        // What it was, it is to be again.
        let telling = self.telling.take().map(|telling| telling.feel);
        self.waiting = self.waiting.take().or(telling).or(self.current.clone());
        (self.ping, self.dialect, self.press, self.strays) = (None, None, None, None);
        (self.angle, self.read) = (None, None);
        (self.surplus, self.messages) = (Budget::new(SURPLUS), Budget::new(MOST_MESSAGES));
        self.alive = f64::NEG_INFINITY;
    }

    fn hear(&mut self, bytes: &[u8], now: f64, servo: &mut dyn Servo) {
        for byte in bytes {
            if matches!(self.stage, Stage::Off | Stage::Done | Stage::Lost(_)) {
                return;
            }
            if let Some(spent) = self.surplus.spend(1, now) {
                return self.end(Lost::Flood(spent));
            }
            if let Stage::Waking { zero, .. } = &mut self.stage
                && !*zero
            {
                *zero = *byte == 0;
                continue;
            }
            match self.frames.push(*byte) {
                Some(Ok(message)) => {
                    self.surplus.credit(message.len() + 8);
                    if let Some(spent) = self.messages.spend(1, now) {
                        return self.end(Lost::Flood(spent * message.len()));
                    }
                    self.message(&message, now, servo);
                }
                Some(Err(_)) => self.counts.bad_checksum += 1,
                None => {}
            }
        }
        self.reading(now, servo);
    }

    fn turn(&mut self, now: f64, servo: &mut dyn Servo, out: &mut Vec<u8>) -> Turn {
        self.step(now, servo, out)
    }

    fn lose(&mut self, why: &Lost) {
        self.end(why.clone());
    }

    fn stop(&mut self, now: f64) {
        match (&self.stage, &self.settings.parting) {
            (Stage::Ready, Some(config)) => {
                self.waiting = Some(Feel { config: config.clone(), origin: 0.0, stay: false });
                (self.telling, self.stage) = (None, Stage::Leaving { since: now });
            }
            (Stage::Lost(_), _) => {}
            _ => self.stage = Stage::Done,
        }
    }

    /// 0: the knob makes its own.
    fn torque(&self) -> f64 {
        0.0
    }

    fn is_ready(&self) -> bool {
        self.stage == Stage::Ready && self.read.is_some()
    }

    fn counts(&self) -> Counts {
        self.counts
    }

    fn round_trip(&self) -> RoundTrip {
        self.trips.sum_up()
    }
}
