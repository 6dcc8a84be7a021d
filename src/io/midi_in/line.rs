//! What a port's callback has.

use std::sync::Arc;

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
            raised: false,
        }
    }

    /// Bytes came. In the thread of the port, which is the system's.
    pub fn hear(&mut self, bytes: &[u8]) {
        if !std::mem::replace(&mut self.raised, true) {
            priority::raise_feeding();
        }
        let (ear, number, name, before) = (&self.ear, self.number, &self.name, self.parser.counts());
        let mut said = false;
        self.parser.read(bytes, &mut |message| {
            said = true;
            ear(number, name, Word::Message(message));
        });
        if !said {
            ear(number, name, Word::Bytes);
        }
        if let Some(board) = &self.board {
            board.midi.parsed(&self.parser.counts(), &before);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Arc, Board, Line, Word};
    use std::sync::Mutex;

    #[test]
    fn what_comes_cut_anywhere_is_heard_and_what_makes_no_message_is_counted() {
        let heard: Arc<Mutex<Vec<(u16, Word)>>> = Arc::default();
        let (board, keeps) = (Arc::new(Board::new(1)), Arc::clone(&heard));
        let ear: super::Ear =
            Arc::new(move |number, _: &Arc<str>, word| keeps.lock().unwrap().push((number, word)));
        let mut line = Line { raised: true, ..Line::new(3, &"Keys".into(), &ear, Some(&board)) };
        // Running status across packets, a system exclusive message in a hundred of them with a clock within, and a stray byte.
        [&[0x90][..], &[60], &[1, 61], &[2], &[0xF0]].into_iter().for_each(|bytes| line.hear(bytes));
        (0..100).for_each(|_| line.hear(&[1; 100]));
        [&[0xF8][..], &[7; 9], &[0xF7, 5], &[0x80, 60, 0]].into_iter().for_each(|bytes| line.hear(bytes));
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
