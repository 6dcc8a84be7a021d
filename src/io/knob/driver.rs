//! The thread that owns a line, a session and a servo.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use super::line::{Line, Trouble};
use super::lost::Lost;
use super::servo::{News, Servo};
use super::session::{Counts, Session, Turn};
use super::trip::RoundTrip;

/// Bytes that are read at a time; more wait for the next turn.
const AT_A_TIME: usize = 1024;

/// How often it looks whether it is to stop.
const GLANCE: f64 = 0.01;

/// The first pause before a lost device is tried again, and the longest: each is twice the one before, until readings come.
pub const PAUSES: (f64, f64) = (0.1, 5.0);

/// How it stands.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Standing {
    /// Whether readings come.
    pub ready: bool,
    /// Why not, once it was lost.
    pub lost: Option<Lost>,
    /// Whether the thread has ended: it was stopped, or to try again is of no use.
    pub ended: bool,
    /// What happened so far.
    pub counts: Counts,
    /// How long answers take.
    pub round_trip: RoundTrip,
    /// Times that a line was opened again.
    pub opened_again: u64,
}

/// A knob that runs until this is dropped: then its torque falls, and it is left idle.
pub struct Running {
    stop: Arc<AtomicBool>,
    standing: Arc<Mutex<Standing>>,
    thread: Option<JoinHandle<()>>,
}

/// Runs a knob on its own thread.
///
/// A lost device is tried again after a growing pause; a port that is gone is looked for by what it was on USB or by its path, and no other
/// device is ever opened in its place. Where to try again is of no use ([`Lost::is_final`]) the thread ends.
///
/// # Errors
/// A system that has no thread left.
pub fn run(
    line: impl Line + 'static,
    session: impl Session + 'static,
    servo: impl Servo + 'static,
) -> std::io::Result<Running> {
    let (stop, standing) = (Arc::new(AtomicBool::new(false)), Arc::default());
    let mut driver = Driver {
        line: Box::new(line),
        session: Box::new(session),
        servo: Box::new(servo),
        stop: Arc::clone(&stop),
        standing: Arc::clone(&standing),
        clock: Instant::now(),
        out: Vec::with_capacity(512),
        pause: PAUSES.0,
        opened_again: 0,
        told: 0.0,
    };
    let thread = thread::Builder::new().name("knob".into()).spawn(move || driver.live())?;
    Ok(Running { stop, standing, thread: Some(thread) })
}

impl Running {
    /// How it stands, as of a few milliseconds ago.
    pub fn standing(&self) -> Standing {
        self.standing.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Lets torque fall, leaves the device idle and waits for it; how it stood at the end.
    pub fn stop(mut self) -> Standing {
        self.end();
        self.standing()
    }

    fn end(&mut self) {
        self.stop.store(true, Ordering::Release);
        if let Some(thread) = self.thread.take() {
            // One that has panicked has nothing more to say.
            let _ = thread.join();
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        self.end();
    }
}

struct Driver {
    line: Box<dyn Line>,
    session: Box<dyn Session>,
    servo: Box<dyn Servo>,
    stop: Arc<AtomicBool>,
    standing: Arc<Mutex<Standing>>,
    clock: Instant,
    out: Vec<u8>,
    pause: f64,
    opened_again: u64,
    /// When it last told how it stands.
    told: f64,
}

impl Driver {
    fn now(&self) -> f64 {
        self.clock.elapsed().as_secs_f64()
    }

    fn is_to_stop(&self) -> bool {
        self.stop.load(Ordering::Acquire)
    }

    fn live(&mut self) {
        let end = loop {
            let now = self.now();
            self.session.begin(now);
            let Some(why) = self.converse() else { break None };
            self.session.lose(&why);
            self.servo.lost(&why);
            self.tell(Some(&why), false);
            if why.is_final() || !self.come_back(matches!(why, Lost::Vanished(_))) {
                break Some(why);
            }
        };
        self.tell(end.as_ref(), true);
    }

    /// Until it has ended (`None`) or is lost.
    fn converse(&mut self) -> Option<Lost> {
        let mut stopping = false;
        let mut bytes = [0; AT_A_TIME];
        loop {
            let now = self.now();
            if self.is_to_stop() && !stopping {
                self.session.stop(now);
                stopping = true;
            }
            self.out.clear();
            let turn = self.session.turn(now, &mut *self.servo, &mut self.out);
            let written = if self.out.is_empty() { Ok(()) } else { self.line.write(&self.out) };
            let (time, awaits) = match (turn, written) {
                (Turn::Done, _) => return None,
                (Turn::Lost(why), _) => return Some(why),
                (_, Err(why)) => return Some(Lost::Vanished(why)),
                (Turn::Until { time, awaits }, Ok(())) => (time, awaits),
            };
            if self.session.is_ready() {
                self.pause = PAUSES.0;
            }
            if now - self.told > GLANCE {
                self.tell(None, false);
            }
            let wait = Duration::from_secs_f64((time - self.now()).clamp(0.0, GLANCE));
            if !awaits {
                thread::sleep(wait);
            }
            match self.line.read(&mut bytes, if awaits { wait } else { Duration::ZERO }) {
                Ok(0) => {}
                Ok(count) => {
                    let now = self.now();
                    self.session.hear(&bytes[..count], now, &mut *self.servo);
                }
                Err(why) => return Some(Lost::Vanished(why)),
            }
        }
    }

    /// Waits, and opens the line again if it has to be; whether there is to be another attempt.
    fn come_back(&mut self, closed: bool) -> bool {
        let mut said = None;
        loop {
            let until = self.now() + self.pause;
            self.pause = (2.0 * self.pause).min(PAUSES.1);
            while self.now() < until {
                if self.is_to_stop() {
                    return false;
                }
                thread::sleep(Duration::from_secs_f64(GLANCE));
            }
            if !closed {
                return true;
            }
            match self.line.open_again() {
                Ok(()) => {
                    self.opened_again += 1;
                    return true;
                }
                // That it is away is known.
                Err(error) if error.kind == Trouble::Missing => {}
                Err(error) if said.as_ref() != Some(&error) => {
                    self.servo.news(&News::Note(error.to_string()));
                    said = Some(error);
                }
                Err(_) => {}
            }
        }
    }

    fn tell(&mut self, lost: Option<&Lost>, ended: bool) {
        self.told = self.now();
        let mut standing = self.standing.lock().unwrap_or_else(PoisonError::into_inner);
        let ready = self.session.is_ready() && lost.is_none() && !ended;
        if ready {
            standing.lost = None;
        } else if lost.is_some() {
            standing.lost = lost.cloned();
        }
        (standing.ready, standing.ended) = (ready, ended);
        (standing.counts, standing.round_trip) = (self.session.counts(), self.session.round_trip());
        standing.opened_again = self.opened_again;
    }
}
