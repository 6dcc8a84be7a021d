//! One MIDI message.
//!
//! Status bytes and lengths are those of the MIDI 1.0 Detailed Specification, tables I to VI.

use std::fmt;
use std::ops::Deref;

use super::channel::Channel;
use super::pitch;

/// A message of a channel, or one of the system messages that say something about playing. Data are 0 to 127 (7 bits) where nothing else is
/// said; greater values in a message made by hand lose their upper bits.
///
/// A note-on with velocity 0 is kept as it came, though it means a note-off: monitors show what was sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Message {
    /// A key goes up.
    NoteOff {
        /// On this channel.
        channel: Channel,
        /// Which key; 60 is middle C.
        note: u8,
        /// How fast, 0 to 127.
        velocity: u8,
    },
    /// A key goes down.
    NoteOn {
        /// On this channel.
        channel: Channel,
        /// Which key; 60 is middle C.
        note: u8,
        /// How fast, 1 to 127; 0 means a note-off.
        velocity: u8,
    },
    /// A single key is pressed harder or softer after it went down.
    PolyPressure {
        /// On this channel.
        channel: Channel,
        /// Which key.
        note: u8,
        /// How hard, 0 to 127.
        pressure: u8,
    },
    /// A controller moves; numbers from 120 are channel mode messages.
    Controller {
        /// On this channel.
        channel: Channel,
        /// Which controller, 0 to 127.
        number: u8,
        /// Where it stands, 0 to 127.
        value: u8,
    },
    /// Another program is chosen.
    Program {
        /// On this channel.
        channel: Channel,
        /// Which, 0 to 127.
        program: u8,
    },
    /// All keys of a channel are pressed harder or softer.
    ChannelPressure {
        /// On this channel.
        channel: Channel,
        /// How hard, 0 to 127.
        pressure: u8,
    },
    /// The pitch wheel moves.
    Bend {
        /// On this channel.
        channel: Channel,
        /// −8192 to 8191; 0 is the middle.
        bend: i16,
    },
    /// Where in the song to go on, in sixteenth notes from its beginning, 0 to 16,383.
    SongPosition {
        /// Sixteenth notes, which are six clocks each.
        sixteenths: u16,
    },
    /// A 24th of a beat has passed.
    Clock,
    /// Play from the beginning.
    Start,
    /// Play on from here.
    Continue,
    /// Stop playing.
    Stop,
    /// The cable is there.
    ActiveSensing,
    /// Everything as after switching on.
    Reset,
}

impl Message {
    /// Exactly one whole message with its status byte. `None` for everything else: too few or too many bytes, data out of place, system
    /// exclusive, and system messages that [`Message`] leaves out. Streams are for [`super::Parser`].
    pub fn parse(bytes: &[u8]) -> Option<Self> {
        let (&status, data) = bytes.split_first()?;
        if data.len() != data_bytes(status)? || data.iter().any(|d| *d > 127) {
            return None;
        }
        let at = |i: usize| data.get(i).copied().unwrap_or(0);
        Self::from_parts(status, [at(0), at(1)])
    }

    /// The message that a status byte and its data make; `None` for a status that [`Message`] leaves out.
    pub(super) fn from_parts(status: u8, [first, second]: [u8; 2]) -> Option<Self> {
        let channel = Channel::of_status(status);
        let (first, second) = (first & 127, second & 127);
        let long = u16::from(second) << 7 | u16::from(first);
        Some(match status {
            0x80..=0x8F => Self::NoteOff { channel, note: first, velocity: second },
            0x90..=0x9F => Self::NoteOn { channel, note: first, velocity: second },
            0xA0..=0xAF => Self::PolyPressure { channel, note: first, pressure: second },
            0xB0..=0xBF => Self::Controller { channel, number: first, value: second },
            0xC0..=0xCF => Self::Program { channel, program: first },
            0xD0..=0xDF => Self::ChannelPressure { channel, pressure: first },
            0xE0..=0xEF => Self::Bend { channel, bend: long as i16 - 8192 },
            0xF2 => Self::SongPosition { sixteenths: long },
            0xF8 => Self::Clock,
            0xFA => Self::Start,
            0xFB => Self::Continue,
            0xFC => Self::Stop,
            0xFE => Self::ActiveSensing,
            0xFF => Self::Reset,
            _ => return None,
        })
    }

    /// The message as it goes over a cable, status byte and data.
    pub fn bytes(self) -> Bytes {
        let on = |status: u8, channel: Channel| status | (channel.number() - 1);
        let (status, first, second) = match self {
            Self::NoteOff { channel, note, velocity } => (on(0x80, channel), note, velocity),
            Self::NoteOn { channel, note, velocity } => (on(0x90, channel), note, velocity),
            Self::PolyPressure { channel, note, pressure } => (on(0xA0, channel), note, pressure),
            Self::Controller { channel, number, value } => (on(0xB0, channel), number, value),
            Self::Program { channel, program } => (on(0xC0, channel), program, 0),
            Self::ChannelPressure { channel, pressure } => (on(0xD0, channel), pressure, 0),
            Self::Bend { channel, bend } => {
                let long = bend.clamp(-8192, 8191) + 8192;
                (on(0xE0, channel), (long & 127) as u8, (long >> 7) as u8)
            }
            Self::SongPosition { sixteenths } => {
                (0xF2, (sixteenths & 127) as u8, (sixteenths >> 7 & 127) as u8)
            }
            Self::Clock => (0xF8, 0, 0),
            Self::Start => (0xFA, 0, 0),
            Self::Continue => (0xFB, 0, 0),
            Self::Stop => (0xFC, 0, 0),
            Self::ActiveSensing => (0xFE, 0, 0),
            Self::Reset => (0xFF, 0, 0),
        };
        let length = 1 + data_bytes(status).unwrap_or(0);
        Bytes { bytes: [status, first & 127, second & 127], length }
    }

    /// The channel it belongs to; `None` for system messages.
    pub fn channel(self) -> Option<Channel> {
        match self {
            Self::NoteOff { channel, .. }
            | Self::NoteOn { channel, .. }
            | Self::PolyPressure { channel, .. }
            | Self::Controller { channel, .. }
            | Self::Program { channel, .. }
            | Self::ChannelPressure { channel, .. }
            | Self::Bend { channel, .. } => Some(channel),
            _ => None,
        }
    }

    /// Whether it may stand in the middle of another message (system real-time).
    pub fn is_real_time(self) -> bool {
        self.bytes().first().is_some_and(|status| *status >= 0xF8)
    }
}

/// One line for monitors and logs.
impl fmt::Display for Message {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(channel) = self.channel() {
            write!(f, "channel {channel}: ")?;
        }
        let name = |note: u8| pitch::name(note & 127).unwrap_or_default();
        match *self {
            Self::NoteOff { note, velocity, .. } => {
                write!(f, "note {note} ({}) off, velocity {velocity}", name(note))
            }
            Self::NoteOn { note, velocity, .. } => {
                write!(f, "note {note} ({}) on, velocity {velocity}", name(note))
            }
            Self::PolyPressure { note, pressure, .. } => {
                write!(f, "note {note} ({}), pressure {pressure}", name(note))
            }
            Self::Controller { number, value, .. } => write!(f, "controller {number} at {value}"),
            Self::Program { program, .. } => write!(f, "program {program}"),
            Self::ChannelPressure { pressure, .. } => write!(f, "pressure {pressure}"),
            Self::Bend { bend, .. } => write!(f, "bend {bend:+}"),
            Self::SongPosition { sixteenths } => write!(f, "song position {sixteenths}"),
            Self::Clock => f.write_str("clock"),
            Self::Start => f.write_str("start"),
            Self::Continue => f.write_str("continue"),
            Self::Stop => f.write_str("stop"),
            Self::ActiveSensing => f.write_str("active sensing"),
            Self::Reset => f.write_str("reset"),
        }
    }
}

/// How many data bytes follow a status byte. `None` for what is no status, has no fixed length (system exclusive and its end), or is
/// undefined (0xF4, 0xF5, 0xF9, 0xFD).
pub(super) fn data_bytes(status: u8) -> Option<usize> {
    match status {
        0x80..=0xBF | 0xE0..=0xEF | 0xF2 => Some(2),
        0xC0..=0xDF | 0xF1 | 0xF3 => Some(1),
        0xF6 | 0xF8 | 0xFA..=0xFC | 0xFE | 0xFF => Some(0),
        _ => None,
    }
}

/// The bytes of one message, one to three of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bytes {
    bytes: [u8; 3],
    length: usize,
}

impl Deref for Bytes {
    type Target = [u8];
    fn deref(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::{Channel, Message};
    use proptest::prelude::{Just, Strategy, any, prop_oneof, proptest};

    /// Any message at all.
    pub fn messages() -> impl Strategy<Value = Message> {
        let channel = || (0_u8..16).prop_filter_map("below 16", Channel::new);
        let data = || 0_u8..128;
        prop_oneof![
            (channel(), data(), data()).prop_map(|(channel, note, velocity)| Message::NoteOff {
                channel,
                note,
                velocity
            }),
            (channel(), data(), data()).prop_map(|(channel, note, velocity)| Message::NoteOn {
                channel,
                note,
                velocity
            }),
            (channel(), data(), data()).prop_map(|(channel, note, pressure)| Message::PolyPressure {
                channel,
                note,
                pressure
            }),
            (channel(), data(), data()).prop_map(|(channel, number, value)| Message::Controller {
                channel,
                number,
                value
            }),
            (channel(), data()).prop_map(|(channel, program)| Message::Program { channel, program }),
            (channel(), data())
                .prop_map(|(channel, pressure)| Message::ChannelPressure { channel, pressure }),
            (channel(), -8192_i16..=8191).prop_map(|(channel, bend)| Message::Bend { channel, bend }),
            (0_u16..16_384).prop_map(|sixteenths| Message::SongPosition { sixteenths }),
            Just(Message::Clock),
            Just(Message::Start),
            Just(Message::Continue),
            Just(Message::Stop),
            Just(Message::ActiveSensing),
            Just(Message::Reset),
        ]
    }

    #[test]
    fn bytes_are_those_of_the_specification() {
        let (first, last) = (Channel::FIRST, Channel::LAST);
        let cases: [(&[u8], Message); 14] = [
            (&[0x8F, 60, 64], Message::NoteOff { channel: last, note: 60, velocity: 64 }),
            (&[0x90, 60, 0], Message::NoteOn { channel: first, note: 60, velocity: 0 }),
            (&[0xA0, 1, 2], Message::PolyPressure { channel: first, note: 1, pressure: 2 }),
            (&[0xB0, 74, 127], Message::Controller { channel: first, number: 74, value: 127 }),
            (&[0xC0, 5], Message::Program { channel: first, program: 5 }),
            (&[0xD0, 9], Message::ChannelPressure { channel: first, pressure: 9 }),
            (&[0xE0, 0, 0x40], Message::Bend { channel: first, bend: 0 }),
            (&[0xE0, 0, 0], Message::Bend { channel: first, bend: -8192 }),
            (&[0xEF, 0x7F, 0x7F], Message::Bend { channel: last, bend: 8191 }),
            (&[0xE0, 1, 0x40], Message::Bend { channel: first, bend: 1 }),
            (&[0xF2, 1, 1], Message::SongPosition { sixteenths: 129 }),
            (&[0xF8], Message::Clock),
            (&[0xFE], Message::ActiveSensing),
            (&[0xFF], Message::Reset),
        ];
        for (bytes, message) in cases {
            assert_eq!(Message::parse(bytes), Some(message), "{bytes:X?}");
            assert_eq!(&*message.bytes(), bytes, "{message:?}");
        }
    }

    #[test]
    fn what_is_not_exactly_one_message_is_none() {
        let wrong: [&[u8]; 12] = [
            &[],
            &[60, 1],
            &[0x90],
            &[0x90, 60],
            &[0x90, 60, 1, 1],
            &[0x90, 0x80, 1],
            &[0xC0, 1, 1],
            &[0xF0, 1, 0xF7],
            &[0xF1, 1],
            &[0xF4],
            &[0xF8, 0],
            &[0xFD],
        ];
        for bytes in wrong {
            assert_eq!(Message::parse(bytes), None, "{bytes:X?}");
        }
    }

    #[test]
    fn monitors_show_channels_from_one_and_names_of_notes() {
        let shown = |bytes: &[u8]| Message::parse(bytes).unwrap().to_string();
        assert_eq!(shown(&[0x91, 60, 9]), "channel 2: note 60 (C4) on, velocity 9");
        assert_eq!(shown(&[0xEF, 1, 64]), "channel 16: bend +1");
        assert_eq!(shown(&[0xFE]), "active sensing");
    }

    #[test]
    fn numbers_out_of_range_make_no_status_byte() {
        let message = Message::NoteOn { channel: Channel::FIRST, note: 255, velocity: 128 };
        assert_eq!(&*message.bytes(), [0x90, 127, 0]);
        let message = Message::Bend { channel: Channel::FIRST, bend: i16::MAX };
        assert_eq!(&*message.bytes(), [0xE0, 127, 127]);
    }

    proptest! {
        #[test]
        fn bytes_read_back(message in messages()) {
            assert_eq!(Message::parse(&message.bytes()), Some(message));
            assert_eq!(message.is_real_time(), message.bytes()[0] >= 0xF8);
            assert_eq!(message.channel().is_some(), message.bytes()[0] < 0xF0);
        }

        #[test]
        fn any_bytes_that_make_a_message_are_its_bytes(bytes in proptest::collection::vec(any::<u8>(), 0..5)) {
            if let Some(message) = Message::parse(&bytes) {
                assert_eq!(&*message.bytes(), &bytes[..]);
            }
        }
    }
}
