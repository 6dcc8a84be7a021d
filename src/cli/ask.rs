//! Lines that somebody types, fetched without waiting for them.

use std::io::{BufRead, IsTerminal, stderr, stdin};
use std::sync::mpsc::{Receiver, TryRecvError, sync_channel};

/// What somebody types, line by line.
pub struct Typed(Receiver<String>);

/// What was typed since it was asked last.
#[derive(Debug, PartialEq, Eq)]
pub enum Said {
    /// Nothing yet.
    Nothing,
    /// A line, without blanks around it.
    Line(String),
    /// Nobody will type anything any more.
    End,
}

impl Typed {
    /// Of a person at a terminal; `None` where there is none.
    ///
    /// # Errors
    /// What the system says where it gives no thread.
    pub fn listen() -> std::io::Result<Option<Self>> {
        if !stdin().is_terminal() || !stderr().is_terminal() {
            return Ok(None);
        }
        let (say, said) = sync_channel(16);
        // It waits for a line for as long as the program runs.
        std::thread::Builder::new().name("lines".into()).spawn(move || {
            for line in stdin().lock().lines() {
                let Ok(line) = line else { break };
                if say.send(line.trim().to_string()).is_err() {
                    break;
                }
            }
        })?;
        Ok(Some(Self(said)))
    }

    /// What was typed.
    pub fn said(&self) -> Said {
        match self.0.try_recv() {
            Ok(line) => Said::Line(line),
            Err(TryRecvError::Empty) => Said::Nothing,
            Err(TryRecvError::Disconnected) => Said::End,
        }
    }

    /// Forgets what was typed before it was asked for.
    pub fn forget(&self) {
        self.0.try_iter().for_each(drop);
    }
}
