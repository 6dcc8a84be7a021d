//! Bytes of a cable, cut anywhere, into messages.

use super::message::{Message, data_bytes};

/// What came, and what could not be used. Nothing is dropped without being counted here.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Messages given out.
    pub messages: u64,
    /// System exclusive messages that began; they are skipped.
    pub exclusive: u64,
    /// Their bytes, without the bytes that begin and end them.
    pub exclusive_bytes: u64,
    /// Messages that another status byte cut short, system exclusive among them.
    pub unfinished: u64,
    /// Data bytes without a status, and ends of system exclusive without a beginning.
    pub stray: u64,
    /// Status bytes that mean nothing: 0xF4, 0xF5, 0xF9, 0xFD.
    pub undefined: u64,
    /// Whole system messages that [`Message`] leaves out: time code, song select, tune request.
    pub left_out: u64,
}

/// Reads a stream of MIDI bytes, one after another: the state is that of a cable, so it does not matter how the bytes are cut into calls.
///
/// - **Running status**: data bytes go on with the last status of a channel. System exclusive and the other system common messages end it
///   (MIDI 1.0 Detailed Specification, appendix A-1); so does a reset.
/// - **Real-time** bytes (0xF8 and up) come out at once, from the middle of other messages and of system exclusive too, and leave those as
///   they were. Only 0xFF, a reset, drops what is unfinished: it means the state after switching on.
/// - **System exclusive** of any length is skipped, in constant memory. Its end may be any status byte but a real-time one, as the
///   specification has it; an end other than 0xF7 counts as unfinished too.
///
/// It never allocates and never fails; what it cannot use is in [`Parser::counts`].
#[derive(Debug, Clone, Default)]
pub struct Parser {
    /// The status that data bytes belong to; 0 for none.
    status: u8,
    /// Whether `status` has been sent for the message that is being read, so that it is unfinished without a single data byte.
    fresh: bool,
    first: Option<u8>,
    counts: Counts,
}

const EXCLUSIVE: u8 = 0xF0;
const END: u8 = 0xF7;

impl Parser {
    /// At the beginning of a stream.
    pub fn new() -> Self {
        Self::default()
    }

    /// Takes all of `bytes` and gives out the messages that are complete with them, in their order.
    pub fn read(&mut self, bytes: &[u8], sink: &mut dyn FnMut(Message)) {
        bytes.iter().filter_map(|byte| self.push(*byte)).for_each(sink);
    }

    /// Takes one byte, and gives out the message that is complete with it.
    pub fn push(&mut self, byte: u8) -> Option<Message> {
        let message = match byte {
            0x00..=0x7F => self.data(byte),
            0x80..=0xF7 => self.begin(byte),
            0xF8..=0xFF => self.real_time(byte),
        };
        self.counts.messages += u64::from(message.is_some());
        message
    }

    /// What came and what could not be used, since the beginning.
    pub fn counts(&self) -> Counts {
        self.counts
    }

    /// Forgets running status and what is unfinished, which is counted: a cable was pulled, what comes next is another stream.
    pub fn restart(&mut self) {
        self.cut();
        self.status = 0;
    }

    fn data(&mut self, byte: u8) -> Option<Message> {
        if self.status == EXCLUSIVE {
            self.counts.exclusive_bytes += 1;
            return None;
        }
        let data = match (data_bytes(self.status), self.first) {
            (Some(1), _) => [byte, 0],
            (Some(2), Some(first)) => [first, byte],
            (Some(2), None) => {
                self.first = Some(byte);
                return None;
            }
            _ => {
                self.counts.stray += 1;
                return None;
            }
        };
        let message = Message::from_parts(self.status, data);
        self.counts.left_out += u64::from(message.is_none());
        (self.fresh, self.first) = (false, None);
        if self.status > EXCLUSIVE {
            self.status = 0;
        }
        message
    }

    fn begin(&mut self, status: u8) -> Option<Message> {
        let ends = status == END && self.status == EXCLUSIVE;
        if !ends {
            self.cut();
        }
        let data = data_bytes(status);
        // What needs no data is done, and what means nothing leaves nothing behind.
        let waits = status == EXCLUSIVE || data.is_some_and(|n| n > 0);
        (self.status, self.fresh, self.first) = (if waits { status } else { 0 }, waits, None);
        match status {
            EXCLUSIVE => self.counts.exclusive += 1,
            END => self.counts.stray += u64::from(!ends),
            _ if data.is_none() => self.counts.undefined += 1,
            _ if data == Some(0) => self.counts.left_out += 1,
            _ => (),
        }
        None
    }

    fn real_time(&mut self, status: u8) -> Option<Message> {
        let message = Message::from_parts(status, [0; 2]);
        if message == Some(Message::Reset) {
            self.restart();
        }
        self.counts.undefined += u64::from(message.is_none());
        message
    }

    /// Counts what is unfinished.
    fn cut(&mut self) {
        let unfinished = self.fresh || self.first.is_some();
        self.counts.unfinished += u64::from(unfinished);
        (self.fresh, self.first) = (false, None);
    }
}

#[cfg(test)]
mod tests {
    use super::super::message::tests::messages;
    use super::{Counts, Message, Parser};
    use crate::midi::Channel;
    use proptest::prelude::{Just, Strategy, any, prop_assert_eq, prop_oneof, proptest};

    fn all(bytes: &[u8]) -> (Vec<Message>, Counts) {
        let (mut parser, mut out) = (Parser::new(), Vec::new());
        parser.read(bytes, &mut |m| out.push(m));
        (out, parser.counts())
    }

    fn on(note: u8, velocity: u8) -> Message {
        Message::NoteOn { channel: Channel::FIRST, note, velocity }
    }

    #[test]
    fn running_status_goes_on_until_a_system_message() {
        let (out, counts) = all(&[0x90, 60, 1, 61, 2, 0xF8, 62, 0xFE, 3, 0xF6, 63, 4]);
        let expected = [on(60, 1), on(61, 2), Message::Clock, Message::ActiveSensing, on(62, 3)];
        assert_eq!(out, expected);
        assert_eq!(counts, Counts { messages: 5, left_out: 1, stray: 2, ..Counts::default() });
        for ends in
            [&[0xF0, 0xF7][..], &[0xF1, 1], &[0xF2, 1, 1], &[0xF3, 1], &[0xF4], &[0xF5], &[0xF7], &[0xFF]]
        {
            let (out, counts) = all(&[&[0x90, 60, 1], ends, &[61, 2]].concat());
            assert!(!out.contains(&on(61, 2)), "{ends:X?}");
            assert!(counts.stray >= 2, "{ends:X?}");
        }
        for keeps in [0xF8, 0xF9, 0xFA, 0xFB, 0xFC, 0xFD, 0xFE] {
            assert!(all(&[0x90, 60, 1, keeps, 61, 2]).0.contains(&on(61, 2)), "{keeps:X}");
            assert!(all(&[0x90, keeps, 61, keeps, 2]).0.contains(&on(61, 2)), "{keeps:X}");
        }
    }

    #[test]
    fn system_exclusive_is_skipped_at_any_length() {
        let mut parser = Parser::new();
        let mut out = Vec::new();
        parser.read(&[0xF0], &mut |m| out.push(m));
        for _ in 0..1_000 {
            parser.read(&[0x55; 1_000], &mut |m| out.push(m));
            parser.read(&[0xF8], &mut |m| out.push(m));
        }
        parser.read(&[0xF7, 0x90, 60, 1], &mut |m| out.push(m));
        assert_eq!(out.pop(), Some(on(60, 1)));
        assert_eq!(out, vec![Message::Clock; 1_000]);
        let expected =
            Counts { messages: 1_001, exclusive: 1, exclusive_bytes: 1_000_000, ..Counts::default() };
        assert_eq!(parser.counts(), expected);
    }

    #[test]
    fn what_is_cut_short_is_counted() {
        let unfinished = |bytes: &[u8]| all(bytes).1.unfinished;
        assert_eq!(unfinished(&[0x90, 60, 1, 0x80, 60, 1]), 0);
        assert_eq!(unfinished(&[0x90, 0x80, 60, 1]), 1, "no data at all");
        assert_eq!(unfinished(&[0x90, 60, 0x80, 60, 1]), 1);
        assert_eq!(unfinished(&[0x90, 60, 1, 61, 0x80]), 1, "under running status");
        assert_eq!(unfinished(&[0xF0, 1, 2, 0x90, 60, 1]), 1, "system exclusive without an end");
        assert_eq!(unfinished(&[0xF0, 1, 0xF0, 1, 0xF7]), 1);
        assert_eq!(unfinished(&[0xF2, 1, 0xFF]), 1, "a reset");
        assert_eq!(all(&[0xF0, 1, 0x90, 60, 1]).0, [on(60, 1)], "what ends it is read");
        let (out, counts) = all(&[0xF4, 0xF5, 0xF9, 0xFD, 1, 0xF7]);
        assert_eq!(out, []);
        assert_eq!(counts, Counts { undefined: 4, stray: 2, ..Counts::default() });
        let mut parser = Parser::new();
        assert_eq!([0x90, 60].map(|b| parser.push(b)), [None; 2]);
        parser.restart();
        assert_eq!([60, 1].map(|b| parser.push(b)), [None; 2], "another stream");
        assert_eq!(parser.counts(), Counts { unfinished: 1, stray: 2, ..Counts::default() });
    }

    proptest! {
        #[test]
        fn any_cuts_of_any_bytes_are_the_same(
            bytes in proptest::collection::vec(prop_oneof![any::<u8>(), 0x80_u8..=0xFF, Just(0xF0)], 0..200),
            cuts in proptest::collection::vec(0_usize..200, 0..20),
        ) {
            let mut cuts: Vec<usize> = cuts.into_iter().map(|c| c.min(bytes.len())).collect();
            cuts.extend([0, bytes.len()]);
            cuts.sort_unstable();
            let (mut parser, mut out) = (Parser::new(), Vec::new());
            for pair in cuts.windows(2) {
                parser.read(&bytes[pair[0]..pair[1]], &mut |m| out.push(m));
            }
            let (expected, counts) = all(&bytes);
            prop_assert_eq!(parser.counts(), counts);
            prop_assert_eq!(counts.messages, expected.len() as u64);
            prop_assert_eq!(out, expected);
        }

        #[test]
        fn what_is_written_reads_back(
            sequence in proptest::collection::vec((messages(), any::<bool>(), real_time()), 0..60),
        ) {
            let (mut bytes, mut expected, mut running) = (Vec::new(), Vec::new(), 0);
            for (message, leave_out, inserted) in sequence {
                let whole = message.bytes();
                let status = whole[0];
                let skip = usize::from(leave_out && status == running);
                match status {
                    0xFF | 0xF2 => running = 0,
                    0x80..=0xEF => running = status,
                    _ => (),
                }
                // A real-time byte before each byte of the message.
                for byte in &whole[skip..] {
                    if let Some(inserted) = inserted {
                        bytes.extend_from_slice(&inserted.bytes());
                        expected.push(inserted);
                    }
                    bytes.push(*byte);
                }
                expected.push(message);
            }
            let count = expected.len() as u64;
            let (out, counts) = all(&bytes);
            prop_assert_eq!(out, expected);
            prop_assert_eq!(counts, Counts { messages: count, ..Counts::default() });
        }
    }

    fn real_time() -> impl Strategy<Value = Option<Message>> {
        prop_oneof![Just(None), Just(Some(Message::Clock)), Just(Some(Message::ActiveSensing))]
    }
}
