//! What a port's callback has.

use std::sync::Arc;
use std::time::Instant;

use super::{Ear, Word};
use crate::io::device::priority;
use crate::live::board::Board;
use crate::midi::Parser;

/// One for each port.
pub(super) struct Line {
    number: u16,
    name: Arc<str>,
    parser: Parser,
    ear: Ear,
    /// Where it counts what it cannot use.
    board: Option<Arc<Board>>,
    /// When the last bytes came.
    last: Option<Instant>,
    /// Whether its thread has asked for priority.
    raised: bool,
}

impl Line {
    /// Of the port of that number and name.
    pub fn new(number: u16, name: &Arc<str>, ear: &Ear, board: Option<&Arc<Board>>) -> Self {
        Self {
            number,
            name: Arc::clone(name),
            parser: Parser::new(),
            ear: Arc::clone(ear),
            board: board.cloned(),
            last: None,
            raised: false,
        }
    }

    /// Bytes came at that instant. In the thread of the port, which is the system's, or one that waits for it.
    pub fn hear(&mut self, bytes: &[u8], at: Instant) {
        // Clocks of systems are estimates; a key that goes up before it goes down would sound for ever.
        let at = self.last.map_or(at, |last| at.max(last));
        self.last = Some(at);
        if !std::mem::replace(&mut self.raised, true) {
            priority::raise_feeding();
        }
        let (ear, number, name, before) = (&self.ear, self.number, &self.name, self.parser.counts());
        let mut said = false;
        self.parser.read(bytes, &mut |message| {
            said = true;
            ear(number, name, Word::Message(message), at);
        });
        if !said {
            ear(number, name, Word::Bytes, at);
        }
        if let Some(board) = &self.board {
            board.midi.parsed(&self.parser.counts(), &before);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Arc, Board, Instant, Line, Word};
    use std::sync::Mutex;
    use std::time::Duration;

    #[test]
    fn nothing_comes_before_what_came_before_it() {
        let heard: Arc<Mutex<Vec<Instant>>> = Arc::default();
        let keeps = Arc::clone(&heard);
        let ear: super::Ear = Arc::new(move |_, _: &Arc<str>, _, at| keeps.lock().unwrap().push(at));
        let mut line = Line { raised: true, ..Line::new(0, &"Keys".into(), &ear, None) };
        let begin = Instant::now();
        for ms in [5, 3, 4, 9] {
            line.hear(&[0xF8], begin + Duration::from_millis(ms));
        }
        assert_eq!(*heard.lock().unwrap(), [5, 5, 5, 9].map(|ms| begin + Duration::from_millis(ms)));
    }

    #[test]
    fn what_comes_cut_anywhere_is_heard_and_what_makes_no_message_is_counted() {
        let heard: Arc<Mutex<Vec<(u16, Word)>>> = Arc::default();
        let now = Instant::now();
        let (board, keeps) = (Arc::new(Board::new(1)), Arc::clone(&heard));
        let ear: super::Ear =
            Arc::new(move |number, _: &Arc<str>, word, _| keeps.lock().unwrap().push((number, word)));
        let mut line = Line { raised: true, ..Line::new(3, &"Keys".into(), &ear, Some(&board)) };
        // Running status across packets, a system exclusive message in a hundred of them with a clock within, and a stray byte.
        [&[0x90][..], &[60], &[1, 61], &[2], &[0xF0]].into_iter().for_each(|bytes| line.hear(bytes, now));
        (0..100).for_each(|_| line.hear(&[1; 100], now));
        [&[0xF8][..], &[7; 9], &[0xF7, 5], &[0x80, 60, 0]]
            .into_iter()
            .for_each(|bytes| line.hear(bytes, now));
        let heard = heard.lock().unwrap();
        assert!(heard.iter().all(|(number, _)| *number == 3));
        let messages = heard.iter().filter(|(_, word)| matches!(word, Word::Message(_))).count();
        assert_eq!(messages, 4);
        // Each packet shows that the cable is there.
        assert_eq!(heard.len(), 5 + 100 + 4);
        let counts = [&board.midi.malformed, &board.midi.skipped].map(|figure| figure.get());
        assert_eq!(counts, [1, 1]);
    }
}
