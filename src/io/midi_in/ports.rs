//! Which ports are there, and which of them are open.

use std::sync::Arc;

use midir::{Ignore, MidiInput, MidiInputConnection};

use super::line::Line;
use super::roster::Roster;
use super::unknown::{Unknown, fits};
use super::{Ear, Newsreader, PortNews, Word};
use crate::live::board::Board;
use crate::performer::PORTS;

/// A port that is listened to.
struct Open {
    id: String,
    name: Arc<str>,
    number: u16,
    connection: MidiInputConnection<Line>,
}

/// All of them.
pub(super) struct Ports {
    ear: Ear,
    board: Option<Arc<Board>>,
    wanted: Option<String>,
    news: Newsreader,
    open: Vec<Open>,
    /// Those that could not be opened, with the looks until that is tried again: another program may have let go of it by then.
    refused: Vec<(String, u32)>,
    roster: Roster,
    /// Whether it was told that there is no MIDI.
    without: bool,
    /// Whether it was told that none has the name, or one had it.
    known: bool,
}

/// Looks from one try to open a port to the next.
const AGAIN: u32 = 10;

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
            without: false,
            known: false,
        }
    }

    /// Lets go of ports that are gone, or were and have come `anew`, and opens those that are new. Where the system does not answer, that is told once.
    pub fn look(&mut self, input: Result<MidiInput, String>, anew: &[String]) {
        let input = match input {
            Ok(input) => input,
            Err(error) => {
                if !std::mem::replace(&mut self.without, true) {
                    (self.news)(PortNews::None(error));
                }
                return;
            }
        };
        self.without = false;
        let ports = input.ports();
        let there: Vec<String> = ports.iter().map(midir::MidiInputPort::id).collect();
        // ALSA gives the number of one that has gone to the next that comes.
        let is_another = |at: usize, open: &Open| {
            let name = ports.get(at).and_then(|port| input.port_name(port).ok());
            name.is_some_and(|name| *name != *open.name)
        };
        let stays = |open: &Open| {
            let at = there.iter().position(|id| *id == open.id);
            at.is_some_and(|at| !is_another(at, open) && !anew.contains(&open.id))
        };
        let (stay, gone) = std::mem::take(&mut self.open).into_iter().partition(stays);
        self.open = stay;
        self.let_go(gone).into_iter().for_each(drop);
        self.search(&input, &there);
        self.known |= !self.open.is_empty();
        let unknown = self.wanted.as_ref().filter(|_| !self.known);
        if let Some(unknown) = unknown.and_then(|name| Unknown::of(name, &usable(&input))) {
            self.known = true;
            (self.news)(PortNews::Unknown(unknown));
        }
    }

    /// The server that they were of has ended, and all of them with it. JACK's library crashes where one takes leave of a server that is gone, so
    /// the connections stay.
    pub fn abandon(&mut self) {
        let gone = std::mem::take(&mut self.open);
        self.let_go(gone).into_iter().for_each(std::mem::forget);
    }

    /// Tells that ports are gone, and gives what connects to them.
    fn let_go(&mut self, gone: Vec<Open>) -> Vec<MidiInputConnection<Line>> {
        let end = |port: Open| {
            self.roster.leave(&port.id);
            (self.ear)(port.number, &port.name, Word::End);
            (self.news)(PortNews::Gone(port.name.to_string()));
            port.connection
        };
        gone.into_iter().map(end).collect()
    }

    /// Opens ports that are new.
    fn search(&mut self, input: &MidiInput, there: &[String]) {
        self.refused.retain(|(id, _)| there.contains(id));
        self.refused.iter_mut().for_each(|(_, looks)| *looks = looks.saturating_sub(1));
        for port in &input.ports() {
            let (id, name) = (port.id(), input.port_name(port).unwrap_or_default());
            let fits = self.wanted.as_ref().is_none_or(|part| fits(part, &name));
            let refused = self.refused.iter().position(|(known, _)| *known == id);
            let waits = refused.is_some_and(|at| self.refused[at].1 > 0);
            let known = self.roster.has(&id) || waits;
            if !fits || known || is_through(&name) {
                continue;
            }
            let Ok(mut input) = super::input() else { continue };
            input.ignore(Ignore::None);
            let shared: Arc<str> = name.as_str().into();
            let opened = match self.roster.seat(&id, &name) {
                None => Err(format!("{PORTS} ports are open already; --midi-in NAME chooses among them")),
                Some(number) => {
                    let line = Line::new(number, &shared, &self.ear, self.board.as_ref());
                    let connected = input.connect(port, "in", |_, bytes, line| line.hear(bytes), line);
                    connected.map(|connection| (number, connection)).map_err(|error| error.to_string())
                }
            };
            match opened {
                Ok((number, connection)) => {
                    self.refused.retain(|(known, _)| *known != id);
                    self.open.push(Open { id, name: shared, number, connection });
                    (self.news)(PortNews::Opened(name));
                }
                Err(error) => {
                    self.roster.leave(&id);
                    match refused {
                        Some(at) => self.refused[at].1 = AGAIN,
                        None => {
                            self.refused.push((id, AGAIN));
                            (self.news)(PortNews::Refused(name, error));
                        }
                    }
                }
            }
        }
    }
}

/// ALSA's loop-back: what somebody sends there comes from there, and again from wherever they play.
fn is_through(name: &str) -> bool {
    name.starts_with("Midi Through")
}

/// The names of the ports that may be listened to.
fn usable(input: &MidiInput) -> Vec<String> {
    let names = input.ports().into_iter().filter_map(|port| input.port_name(&port).ok());
    names.filter(|name| !is_through(name)).collect()
}
