//! Where something that sounds was started, as its voices' ids say.
//!
//! A voice is known to the engine by its id alone. So that what a channel or a port of MIDI has started can fall silent at one word,
//! whether it is still held, dies away or comes from a pattern, ids tell it in their upper bits. Those of what signals set off in the
//! engine are [another's](crate::graph::watch::id).

use crate::midi::Channel;

/// Bits of an id below those that tell whence.
const BELOW: u32 = 50;

/// Of those that tell whence, the lower ones, for the channel.
const CHANNELS: u32 = 5;

/// Bits of an id that count what one run of a pattern plays.
pub(super) const OF_RUN: u32 = 32;

/// Set in ids of voices that no pattern plays, so that they share no random numbers with those of patterns.
const PROGRAM: u64 = 1 << 62;

/// Who started something: the patch or the program, or a channel of a port of MIDI, or a port itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Whence(u16);

impl Whence {
    /// The patch, or the program.
    pub const HERE: Self = Self(0);

    /// What the engine set off by itself: a channel of no port.
    pub const CROSSED: Self = Self(1);

    /// A port, or one of its channels.
    pub fn midi(port: usize, channel: Option<Channel>) -> Self {
        let port = (port + 1) as u16 & 0x7F;
        Self(port << CHANNELS | channel.map_or(0, |channel| u16::from(channel.number())))
    }

    /// Whether this is that port, where `channel` says so on that channel.
    pub fn is_of(self, port: usize, channel: Option<Channel>) -> bool {
        let of = Self::midi(port, channel);
        if channel.is_some() { self == of } else { self.0 >> CHANNELS == of.0 >> CHANNELS }
    }

    /// The id of the voice of that number that no pattern plays.
    pub fn voice(self, number: u64) -> u64 {
        PROGRAM | u64::from(self.0) << BELOW | number & ((1 << BELOW) - 1)
    }

    /// The id of what a run plays. There are fewer ids than runs; none but what plays from the beginning has those of 0.
    pub fn of_run(self, serial: u64, number: u64) -> u64 {
        let most = (1 << (BELOW - OF_RUN)) - 1;
        let serial = if serial == 0 { 0 } else { (serial - 1) % most + 1 };
        u64::from(self.0) << BELOW | serial << OF_RUN | number & ((1 << OF_RUN) - 1)
    }

    /// All ids of a port, or of a channel of it: those of its voices, and those of its patterns, each with how many of the lowest bits
    /// differ.
    pub fn all(port: usize, channel: Option<Channel>) -> [(u64, u8); 2] {
        let of = u64::from(Self::midi(port, channel).0) << BELOW;
        let bits = if channel.is_some() { BELOW } else { BELOW + CHANNELS };
        [(PROGRAM | of, bits as u8), (of, bits as u8)]
    }
}

#[cfg(test)]
mod tests {
    use super::Whence;
    use crate::engine::event::Play;
    use crate::graph::watch;
    use crate::midi::Channel;

    #[test]
    fn no_run_has_the_ids_of_the_beginning() {
        let of = |serial: u64| Whence::HERE.of_run(serial, 0);
        assert_eq!(of(0), 0);
        for serial in [1, (1 << 18) - 1, 1 << 18, (1 << 18) + 1, 3 << 18, (1 << 40) - 1, 1 << 40, u64::MAX] {
            assert!(of(serial) != 0 && of(serial) < 1 << 50, "{serial}");
        }
        assert!((1..(1 << 18) - 1).all(|serial| of(serial) != of(serial + 1)));
    }

    #[test]
    fn ids_tell_whence_they_are() {
        let channel = |index| Channel::new(index);
        let all = [
            Whence::HERE,
            Whence::CROSSED,
            Whence::midi(0, None),
            Whence::midi(0, channel(0)),
            Whence::midi(0, channel(15)),
            Whence::midi(1, channel(0)),
            Whence::midi(63, channel(15)),
        ];
        for (n, whence) in all.into_iter().enumerate() {
            let ids = [
                whence.voice(0),
                whence.voice(1 << 40),
                whence.of_run(3, 9),
                whence.of_run(1 << 20, 1 << 40),
            ];
            for (port, of) in [(0, None), (0, channel(0)), (0, channel(15)), (1, None), (63, channel(15))] {
                let expected = match (port, of.map(Channel::index)) {
                    (0, None) => (2..=4).contains(&n),
                    (0, Some(0)) => n == 3,
                    (0, _) => n == 4,
                    (1, _) => n == 5,
                    _ => n == 6,
                };
                assert_eq!(whence.is_of(port, of), expected, "{n} of {port} {of:?}");
                for id in ids {
                    let play = Play { id, ..Play::default() };
                    let falls = Whence::all(port, of).iter().any(|(id, bits)| play.is_of(*id, *bits));
                    assert_eq!(falls, expected, "{id:x} of {port} {of:?}");
                }
            }
        }
        // What always sounds has the highest ids of all, and what signals set off those between.
        for id in [u64::MAX - 1, watch::id(0, 0), watch::id(usize::MAX, u64::MAX)] {
            let other = Play { id, ..Play::default() };
            let falls =
                |port: usize| Whence::all(port, None).iter().any(|(id, bits)| other.is_of(*id, *bits));
            assert!(!falls(0) && !falls(63), "{id:x}");
            assert!(
                all.iter()
                    .all(|whence| whence.voice(0) >> 62 != id >> 62 && whence.of_run(0, 0) >> 62 != id >> 62)
            );
        }
        assert_eq!((Whence::HERE.of_run(0, 7), Whence::HERE.voice(7)), (7, (1 << 62) + 7));
    }
}
