//! Which ports are there, and which of them are open.

use std::sync::Arc;
use std::time::{Duration, Instant};

use super::line::Line;
use super::roster::Roster;
use super::source::Source;
use super::unknown::{Unknown, fits};
use super::{Ear, Newsreader, PortNews, System, Word};
use crate::live::board::Board;
use crate::performer::PORTS;

/// A port that is listened to.
struct Open {
    source: Source,
    shared: Arc<str>,
    number: u16,
}

/// One that could not be opened. That is tried again: another program may have let go of it by then, or it has not begun yet.
struct Refused {
    id: String,
    /// Since when.
    since: Instant,
    /// When it is tried again, once it was told.
    again: Option<Instant>,
}

/// All of them.
pub(super) struct Ports {
    ear: Ear,
    board: Option<Arc<Board>>,
    wanted: Option<String>,
    news: Newsreader,
    open: Vec<Open>,
    refused: Vec<Refused>,
    roster: Roster,
    /// How far ahead of now what comes may be.
    ahead: Duration,
    /// Whether it was told that there is no MIDI.
    without: bool,
    /// Whether it was told that none has the name, or one had it.
    known: bool,
}

/// From one try to open a port to the next.
const AGAIN: Duration = Duration::from_secs(10);

/// How long it is tried at each look before it is told that it cannot be opened: a program's ports are there before it begins.
const GRACE: Duration = Duration::from_millis(250);

impl Ports {
    /// None so far.
    pub fn new(ear: Ear, board: Option<Arc<Board>>, wanted: Option<String>, news: Newsreader) -> Self {
        Self {
            ear,
            board,
            wanted,
            news,
            open: Vec::new(),
            refused: Vec::new(),
            roster: Roster::default(),
            ahead: Duration::ZERO,
            without: false,
            known: false,
        }
    }

    /// The system does not answer. It is told once.
    pub fn without(&mut self, why: String) {
        if !std::mem::replace(&mut self.without, true) {
            (self.news)(PortNews::None(why));
        }
    }

    /// Lets go of ports that are gone, or were, whoever has their ids now, and opens those that are new.
    pub fn look(&mut self, system: &mut System) {
        self.ahead = system.ahead();
        let lost = system.lost();
        let there = match system.sources() {
            Ok(there) => there,
            Err(why) => return self.without(why),
        };
        self.without = false;
        // ALSA gives the number of one that has gone to the next that comes.
        let stays = |open: &Open| there.contains(&open.source) && !lost.contains(&open.source.id);
        let (stay, gone) = std::mem::take(&mut self.open).into_iter().partition(stays);
        self.open = stay;
        for port in gone {
            system.disconnect(&port.source.id);
            self.let_go(port);
        }
        self.search(system, &there);
        self.known |= !self.open.is_empty();
        let usable: Vec<String> =
            there.into_iter().map(|source| source.name).filter(|name| !is_through(name)).collect();
        let unknown = self.wanted.as_ref().filter(|_| !self.known);
        if let Some(unknown) = unknown.and_then(|name| Unknown::of(name, &usable)) {
            self.known = true;
            (self.news)(PortNews::Unknown(unknown));
        }
    }

    /// Whether a port may open in a moment.
    pub fn hurries(&self) -> bool {
        self.refused.iter().any(|refused| refused.again.is_none())
    }

    /// The system that they were of has ended, and all of them with it.
    pub fn abandon(&mut self) {
        std::mem::take(&mut self.open).into_iter().for_each(|port| self.let_go(port));
    }

    /// Nobody listens to them any more, which is no news.
    pub fn close(&self) {
        for port in &self.open {
            (self.ear)(port.number, &port.shared, Word::Closed, self.end());
        }
    }

    /// When what comes has come: a key that went up before it went down would sound for ever.
    fn end(&self) -> Instant {
        Instant::now() + self.ahead
    }

    /// Tells that a port is gone.
    fn let_go(&mut self, port: Open) {
        self.roster.leave(&port.source.id);
        (self.ear)(port.number, &port.shared, Word::End, self.end());
        (self.news)(PortNews::Gone(port.source.name));
    }

    /// Opens ports that are new.
    fn search(&mut self, system: &mut System, there: &[Source]) {
        self.refused.retain(|refused| there.iter().any(|source| source.id == refused.id));
        let now = Instant::now();
        for source in there {
            let Source { id, name, kind } = source;
            let fits = self.wanted.as_ref().is_none_or(|part| fits(part, name));
            let refused = self.refused.iter().find(|refused| refused.id == *id);
            let waits = refused.and_then(|refused| refused.again).is_some_and(|again| now < again);
            let known = self.roster.has(id) || waits;
            if !fits || known || is_through(name) {
                continue;
            }
            let shared: Arc<str> = name.as_str().into();
            let opened = match self.roster.seat(id, kind) {
                None => Err(format!("{PORTS} ports are open already; --midi-in NAME chooses among them")),
                Some(number) => {
                    let line = Line::new(number, &shared, &self.ear, self.board.as_ref());
                    system.connect(source, line).map(|()| number)
                }
            };
            match opened {
                Ok(number) => {
                    self.refused.retain(|refused| refused.id != *id);
                    self.open.push(Open { source: source.clone(), shared, number });
                    (self.news)(PortNews::Opened(name.clone()));
                }
                Err(error) => {
                    self.roster.leave(id);
                    if self.refuse(id, now) {
                        (self.news)(PortNews::Refused(name.clone(), error));
                    }
                }
            }
        }
    }

    /// One could not be opened. Says whether that is to be told.
    fn refuse(&mut self, id: &str, now: Instant) -> bool {
        let Some(refused) = self.refused.iter_mut().find(|refused| refused.id == id) else {
            self.refused.push(Refused { id: id.into(), since: now, again: None });
            return false;
        };
        let first = refused.again.is_none();
        let is_over = now - refused.since >= GRACE;
        if is_over {
            refused.again = Some(now + AGAIN);
        }
        first && is_over
    }
}

/// ALSA's loop-back: what somebody sends there comes from there, and again from wherever they play.
fn is_through(name: &str) -> bool {
    name.starts_with("Midi Through")
}
