//! Sources of signals, each with a queue of its own.

use super::board::Figure;
use super::signal::{Origin, Signal};

/// By which way a signal comes in. Of signals that arrived at the same moment, those of the way that stands first here go first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Way {
    /// MIDI, from whichever port.
    Midi,
    /// OSC.
    Osc,
    /// Keys of the computer.
    Key,
    /// A program that has a [`super::signal::Handle`].
    Program,
}

/// How many ways there are.
pub const WAYS: usize = Way::ALL.len();

impl Way {
    /// All ways.
    pub const ALL: [Self; 4] = [Self::Midi, Self::Osc, Self::Key, Self::Program];

    /// That of a signal.
    pub fn of(signal: &Signal, origin: &Origin) -> Self {
        match (signal, origin) {
            (Signal::Midi(..) | Signal::MidiGone(_), _) => Self::Midi,
            (Signal::Osc(..), _) | (_, Origin::Osc(..)) => Self::Osc,
            (Signal::Key(_), _) | (_, Origin::Key(_)) => Self::Key,
            (_, Origin::Program | Origin::System(_)) => Self::Program,
        }
    }

    /// Signals of it that may wait for the conductor.
    pub const fn capacity(self) -> usize {
        match self {
            Self::Midi | Self::Osc | Self::Program => 1 << 12,
            // Nobody types faster.
            Self::Key => 1 << 8,
        }
    }

    /// In a word, as journals have it.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Midi => "midi",
            Self::Osc => "osc",
            Self::Key => "key",
            Self::Program => "program",
        }
    }
}

/// What found no room, by where it came from.
#[derive(Debug, Default)]
pub struct Refusals {
    by: [Figure; WAYS],
    /// Patterns that did not play since too many did.
    pub patterns: Figure,
}

impl Refusals {
    /// All of it.
    pub fn get(&self) -> u64 {
        self.by.iter().map(Figure::get).sum::<u64>() + self.patterns.get()
    }

    /// Signals of one way.
    pub fn of(&self, way: Way) -> &Figure {
        &self.by[way as usize]
    }

    /// Each with its word.
    pub fn named(&self) -> impl Iterator<Item = (&'static str, u64)> {
        let ways = Way::ALL.into_iter().map(|way| (way.word(), self.of(way).get()));
        ways.chain([("pattern", self.patterns.get())])
    }

    /// Those of which there were any, in words: `midi 3, key 1`; empty where nothing was refused.
    pub fn words(&self) -> String {
        let some = self.named().filter(|(_, count)| *count > 0);
        some.map(|(word, count)| format!("{word} {count}")).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::{Refusals, Way};
    use crate::live::signal::{Origin, Signal};

    #[test]
    fn each_is_counted_where_it_came_from() {
        let refusals = Refusals::default();
        assert_eq!((refusals.get(), refusals.words()), (0, String::new()));
        refusals.of(Way::Osc).add(2);
        refusals.patterns.add(5);
        refusals.of(Way::Midi).add(1);
        assert_eq!((refusals.get(), refusals.words()), (8, "midi 1, osc 2, pattern 5".into()));
    }

    #[test]
    fn the_way_is_that_of_the_signal_then_that_of_the_handle() {
        let osc = Origin::Osc("/a".into(), "".into());
        assert_eq!(Way::of(&Signal::MidiGone(0), &osc), Way::Midi);
        assert_eq!(Way::of(&Signal::Osc("/a".into(), vec![]), &Origin::Program), Way::Osc);
        assert_eq!(Way::of(&Signal::Panic, &osc), Way::Osc);
        assert_eq!(Way::of(&Signal::Panic, &Origin::Key("x".into())), Way::Key);
        assert_eq!(Way::of(&Signal::Key(1), &Origin::Program), Way::Key);
        assert_eq!(Way::of(&Signal::Panic, &Origin::Program), Way::Program);
    }
}
