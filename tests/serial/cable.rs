//! A clock of its own, and a cable with a delay between a session and a device.

use std::collections::VecDeque;

use pacinian::io::knob::lost::Lost;
use pacinian::io::knob::session::{Session, Turn};

use crate::hand::Hand;

/// A device: bytes and times in, bytes out.
pub trait Device {
    /// Takes bytes.
    fn hear(&mut self, bytes: &[u8], now: f64);
    /// Lets time pass, and gives what it says meanwhile.
    fn pass(&mut self, now: f64) -> Vec<u8>;
}

/// Seconds of a step.
pub const STEP: f64 = 1e-4;

/// A session, a cable and a device.
pub struct Cable<S, D> {
    pub session: S,
    pub device: D,
    pub hand: Hand,
    pub now: f64,
    /// Seconds that a byte takes, each way.
    pub delay: f64,
    /// Bytes that arrive together at most; 0 for no limit.
    pub pieces: usize,
    /// Bytes arrive at times that are multiples of this, seconds; 0 for whenever.
    pub merged: f64,
    /// Everything that went to the device.
    pub said: Vec<(f64, Vec<u8>)>,
    out: VecDeque<(f64, Vec<u8>)>,
    back: VecDeque<(f64, u8)>,
    due: f64,
}

impl<S: Session, D: Device> Cable<S, D> {
    /// Plugged in at time 0.
    pub fn new(session: S, device: D) -> Self {
        let mut cable = Self {
            session,
            device,
            hand: Hand::default(),
            now: 0.0,
            delay: 2e-4,
            pieces: 0,
            merged: 0.0,
            said: Vec::new(),
            out: VecDeque::new(),
            back: VecDeque::new(),
            due: 0.0,
        };
        cable.session.begin(0.0);
        cable
    }

    /// A step; why it ended, if it did.
    pub fn step(&mut self) -> Option<Turn> {
        self.now += STEP;
        let now = self.now;
        while self.out.front().is_some_and(|(at, _)| *at <= now) {
            let (_, bytes) = self.out.pop_front().unwrap();
            self.device.hear(&bytes, now);
        }
        for byte in self.device.pass(now) {
            self.back.push_back((now + self.delay, byte));
        }
        let mut heard = Vec::new();
        let gate = self.merged == 0.0 || (now / self.merged).floor() != ((now - STEP) / self.merged).floor();
        while gate
            && self.back.front().is_some_and(|(at, _)| *at <= now)
            && (self.pieces == 0 || heard.len() < self.pieces)
        {
            heard.push(self.back.pop_front().unwrap().1);
        }
        if !heard.is_empty() {
            self.session.hear(&heard, now, &mut self.hand);
        }
        if heard.is_empty() && now < self.due {
            return None;
        }
        let mut out = Vec::new();
        let turn = self.session.turn(now, &mut self.hand, &mut out);
        if !out.is_empty() {
            self.said.push((now, out.clone()));
            self.out.push_back((now + self.delay, out));
        }
        match turn {
            Turn::Until { time, .. } => {
                assert!(time.is_finite());
                self.due = time;
                None
            }
            other => Some(other),
        }
    }

    /// So many seconds, or until it ends.
    pub fn run(&mut self, seconds: f64) -> Option<Turn> {
        let until = self.now + seconds;
        while self.now < until {
            if let Some(end) = self.step() {
                return Some(end);
            }
        }
        None
    }

    /// So many seconds, in which nothing may end.
    pub fn lives(&mut self, seconds: f64) {
        let end = self.run(seconds);
        assert_eq!(end, None, "at {} s: {:?}", self.now, self.hand.news);
    }

    /// So many seconds at most, in which it must be lost. What the session wrote last has arrived.
    pub fn loses(&mut self, seconds: f64) -> Lost {
        match self.run(seconds) {
            Some(Turn::Lost(why)) => {
                self.quiet(2.0 * self.delay + STEP);
                why
            }
            other => panic!("{other:?} at {} s", self.now),
        }
    }

    /// Time passes, and the session does nothing.
    pub fn quiet(&mut self, seconds: f64) {
        let until = self.now + seconds;
        while self.now < until {
            self.now += STEP;
            while self.out.front().is_some_and(|(at, _)| *at <= self.now) {
                let (_, bytes) = self.out.pop_front().unwrap();
                self.device.hear(&bytes, self.now);
            }
            self.device.pass(self.now);
        }
    }

    /// Begins anew, with what was on the cable lost.
    pub fn begin(&mut self) {
        self.back.clear();
        self.due = self.now;
        self.session.begin(self.now);
    }

    /// Everything that went to the device, as text.
    pub fn text(&self) -> String {
        self.said.iter().map(|(_, bytes)| String::from_utf8_lossy(bytes)).collect()
    }
}
