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
                if say.send(plain(&line)).is_err() {
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

/// Without blanks around it, and without what keys leave behind that move a cursor.
fn plain(line: &str) -> String {
    let (mut out, mut rest) = (String::new(), line.chars());
    while let Some(c) = rest.next() {
        if c == '\u{1b}' {
            // ECMA-48: a bracket, parameters, and a letter; some keys have another sign and a letter.
            if matches!(rest.next(), Some('[' | 'O')) {
                let _ = rest.find(|c| ('@'..='~').contains(c));
            }
        } else if !c.is_control() {
            out.push(c);
        }
    }
    out.trim().to_string()
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn keys_that_move_a_cursor_leave_nothing_behind() {
        for (typed, line) in [
            (" left ", "left"),
            ("\x1b[C", ""),
            ("le\x1b[1;5Dft\x1bOP", "left"),
            ("µ\t", "µ"),
            ("\x1b", ""),
            ("\x1b[", ""),
        ] {
            assert_eq!(plain(typed), line, "{typed:?}");
        }
    }
}
