//! Ports where midir leads to them: macOS, Windows and others. Nobody says when one comes or goes.

use std::sync::Arc;
use std::time::{Duration, Instant};

use midir::{Ignore, MidiInput, MidiInputConnection};

use super::bell::Bell;
use super::line::Line;
use super::source::Source;
use crate::live::board::Board;

/// The system's MIDI.
pub(super) struct System {
    open: Vec<(String, MidiInputConnection<Line>)>,
}

fn input() -> Result<MidiInput, String> {
    MidiInput::new("pacinian").map_err(|error| error.to_string())
}

/// Ports that may be listened to.
///
/// # Errors
/// A system without MIDI.
pub(super) fn sources() -> Result<Vec<Source>, String> {
    let input = input()?;
    let source = |port: &midir::MidiInputPort| {
        let name = input.port_name(port).unwrap_or_default();
        Source { id: port.id(), kind: name.clone(), name }
    };
    Ok(input.ports().iter().map(source).collect())
}

impl System {
    /// Nothing is heard so far.
    ///
    /// # Errors
    /// A system without MIDI.
    pub fn open(_board: Option<&Arc<Board>>, _bell: &Arc<Bell>) -> Result<Self, String> {
        input().map(|_| Self { open: Vec::new() })
    }

    /// Ports that may be listened to.
    ///
    /// # Errors
    /// A system without MIDI.
    pub fn sources(&self) -> Result<Vec<Source>, String> {
        sources()
    }

    /// Never.
    pub fn is_over(&self) -> bool {
        false
    }

    /// How far ahead of now what it hands on may be.
    pub fn ahead(&self) -> Duration {
        Duration::ZERO
    }

    /// Nobody says.
    pub fn lost(&self) -> Vec<String> {
        Vec::new()
    }

    /// Listens to a port.
    ///
    /// # Errors
    /// One that is gone, or that another program has.
    pub fn connect(&mut self, source: &Source, line: Line) -> Result<(), String> {
        let mut input = input()?;
        input.ignore(Ignore::None);
        let port = input.ports().into_iter().find(|port| port.id() == source.id);
        let port = port.ok_or("it is gone")?;
        let hear = |_, bytes: &[u8], line: &mut Line| line.hear(bytes, Instant::now());
        let connection = input.connect(&port, "in", hear, line).map_err(|error| error.to_string())?;
        self.open.push((source.id.clone(), connection));
        Ok(())
    }

    /// Listens to it no more.
    pub fn disconnect(&mut self, id: &str) {
        self.open.retain(|(open, _)| open != id);
    }

    /// All of it.
    pub fn abandon(self) {}
}
