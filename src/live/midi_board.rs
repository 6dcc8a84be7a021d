//! How it stands with what comes over MIDI.

use super::board::{Figure, in_words};
use crate::midi::parser;
use crate::performer::MidiCounts;

/// Messages of all ports, and what of them could not be used.
#[derive(Debug, Default)]
pub struct MidiBoard {
    /// Messages that came, without those that are malformed or skipped.
    pub messages: Figure,
    /// Messages cut short, data bytes that belong to none, and status bytes that mean nothing.
    pub malformed: Figure,
    /// System messages that mean nothing here: system exclusive, time code, song select, tune request.
    pub skipped: Figure,
    /// Note-offs and key pressures of notes that did not sound.
    pub unmatched: Figure,
    /// Notes that ended since there were too many.
    pub stolen: Figure,
    /// Notes and programs that no trigger of the patch plays.
    pub unplayed: Figure,
    /// Values for numbered parameters of which none was chosen.
    pub unmeant: Figure,
    /// Values of numbered parameters (NRPN, RPN), which nothing in a patch can hear.
    pub unheard: Figure,
    /// Messages that concern no player.
    pub left_out: Figure,
    /// Periods that a JACK server has left out, and times that more came than ALSA keeps: their messages are lost.
    pub gaps: Figure,
}

impl MidiBoard {
    /// What a parser counted, of which it had counted `before` when it was asked last.
    pub fn parsed(&self, now: &parser::Counts, before: &parser::Counts) {
        let malformed = |c: &parser::Counts| c.unfinished + c.stray + c.undefined;
        let skipped = |c: &parser::Counts| c.exclusive + c.left_out;
        self.malformed.add(malformed(now).saturating_sub(malformed(before)));
        self.skipped.add(skipped(now).saturating_sub(skipped(before)));
    }

    /// What a performer counted so far.
    pub fn performed(&self, counts: &MidiCounts) {
        let MidiCounts { messages, unmatched, stolen, unplayed, unmeant, unheard, left_out } = *counts;
        let figures = [
            (&self.messages, messages),
            (&self.unmatched, unmatched),
            (&self.stolen, stolen),
            (&self.unplayed, unplayed),
            (&self.unmeant, unmeant),
            (&self.unheard, unheard),
            (&self.left_out, left_out),
        ];
        figures.into_iter().for_each(|(figure, count)| figure.set(count));
    }

    /// Each figure by its name in a journal, with what it counts in words.
    pub fn named(&self) -> [(&'static str, u64, &'static str); 9] {
        [
            ("midi_malformed", self.malformed.get(), "malformed"),
            ("midi_skipped", self.skipped.get(), "system messages skipped"),
            ("midi_unmatched", self.unmatched.get(), "for notes that did not sound"),
            ("midi_stolen", self.stolen.get(), "notes cut short by too many others"),
            ("midi_unplayed", self.unplayed.get(), "notes and programs that no trigger plays"),
            ("midi_unmeant", self.unmeant.get(), "values for no parameter"),
            ("midi_unheard", self.unheard.get(), "values of parameters (NRPN, RPN) that no patch can hear"),
            ("midi_left_out", self.left_out.get(), "that concern no player"),
            ("midi_gaps", self.gaps.get(), "gaps that ALSA or JACK told of, whose messages are lost"),
        ]
    }

    /// How many could not be used. System messages that are skipped are none of them, and of those that were lost on the way nobody knows.
    pub fn unused(&self) -> u64 {
        self.named().iter().map(|(_, count, _)| count).sum::<u64>() - self.skipped.get() - self.gaps.get()
    }

    /// What could not be used, in words; `None` if all could.
    pub fn trouble(&self) -> Option<String> {
        // What no parser makes a message of came as well.
        let came = self.messages.get() + self.malformed.get() + self.skipped.get();
        in_words(&self.named()).map(|told| format!("MIDI, of {came} messages: {told}"))
    }
}

impl From<MidiCounts> for MidiBoard {
    fn from(counts: MidiCounts) -> Self {
        let board = Self::default();
        board.performed(&counts);
        board
    }
}

#[cfg(test)]
mod tests {
    use super::{MidiBoard, MidiCounts};
    use crate::midi::Parser;

    #[test]
    fn what_cannot_be_used_is_told_by_its_kind() {
        let board = MidiBoard::default();
        let mut parser = Parser::new();
        let mut before = parser.counts();
        for bytes in [&[0xF4, 1][..], &[0xF0, 1, 2], &[0xF7], &[0x90, 60, 0x90], &[60, 1]] {
            parser.read(bytes, &mut |_| ());
            board.parsed(&parser.counts(), &before);
            before = parser.counts();
        }
        board.performed(&MidiCounts { messages: 9, unheard: 4, ..MidiCounts::default() });
        // A status byte that means nothing, a byte without one, a note without its velocity.
        let told = "MIDI, of 13 messages: 3 malformed, 1 system messages skipped, \
                    4 values of parameters (NRPN, RPN) that no patch can hear";
        assert_eq!(board.trouble().as_deref(), Some(told));
        assert_eq!(board.unused(), 7);
        board.performed(&MidiCounts { messages: 10, unheard: 5, ..MidiCounts::default() });
        assert_eq!(board.unused(), 8, "they are what was counted so far");
        assert_eq!(MidiBoard::from(MidiCounts { messages: 3, ..MidiCounts::default() }).trouble(), None);
    }
}
