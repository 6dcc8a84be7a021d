//! What a player does, once messages are understood.

use super::channel::Channel;

/// Something that happened. Fractions reach both their ends exactly: 7 bits are divided by 127, 14 bits by 16,383.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Gesture {
    /// A note begins.
    NoteOn {
        /// Names this sounding of the note until it ends; no other that sounds has it.
        key: u32,
        /// On this channel.
        channel: Channel,
        /// Which, 0 to 127; 60 is middle C.
        note: u8,
        /// How fast the key went down, above 0 and at most 1.
        velocity: f64,
        /// How it is bent and pressed from the beginning.
        expression: Expression,
    },
    /// A note ends: its key is up, and no pedal holds it.
    NoteOff {
        /// Which sounding.
        key: u32,
        /// How fast the key went up, 0 to 1; 64/127 where nothing was said.
        velocity: f64,
    },
    /// A sounding note changes.
    Move {
        /// Which sounding.
        key: u32,
        /// What of it.
        what: What,
        /// Its new value, in the units of [`Expression`].
        value: f64,
    },
    /// A controller stands somewhere else.
    Controller {
        /// On this channel.
        channel: Channel,
        /// Which, 0 to 119; of a pair of 14 bits the lower number.
        number: u8,
        /// Where it stands, 0 to 1.
        value: f64,
        /// Whether `value` has 14 bits.
        fine: bool,
    },
    /// A numbered parameter (NRPN or RPN) stands somewhere else.
    Parameter {
        /// On this channel.
        channel: Channel,
        /// Whether it is registered (RPN), with a meaning that all makers share.
        registered: bool,
        /// Which, 0 to 16,382.
        number: u16,
        /// Where it stands, 0 to 1.
        value: f64,
        /// Whether `value` has 14 bits.
        fine: bool,
    },
    /// A program is chosen.
    Program {
        /// On this channel.
        channel: Channel,
        /// From this bank, 0 to 16,383: controllers 0 and 32.
        bank: u16,
        /// Which, 0 to 127.
        program: u8,
    },
    /// The song starts or stops.
    Transport {
        /// Which of them.
        what: Transport,
    },
    /// The song stands here.
    Position {
        /// Quarter notes from its beginning.
        beats: f64,
    },
    /// Hands are off the wheel, and nothing is pressed: a reset says so, a zone that is made anew, or that the port is gone.
    Rest {
        /// On this channel.
        channel: Channel,
    },
    /// All that was started through a channel falls silent, now, what dies away already as well. Its notes are gone, those that a pedal
    /// held, too; no [`Gesture::NoteOff`] follows for them.
    Panic {
        /// Why.
        reason: Reason,
        /// Which; `None` for all channels.
        channel: Option<Channel>,
    },
}

/// How a note is bent and pressed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Expression {
    /// Semitones above the note; 0 at rest.
    pub bend: f64,
    /// 0 to 1; 0 at rest.
    pub pressure: f64,
    /// 0 to 1 (controller 74); 64/127 at rest.
    pub timbre: f64,
}

impl Expression {
    /// Of a note that is only struck.
    pub const REST: Self = Self { bend: 0.0, pressure: 0.0, timbre: 64.0 / 127.0 };
}

impl Default for Expression {
    fn default() -> Self {
        Self::REST
    }
}

/// A part of [`Expression`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum What {
    /// Semitones.
    Bend,
    /// 0 to 1.
    Pressure,
    /// 0 to 1.
    Timbre,
}

/// What a sequencer says about its song.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Transport {
    /// From the beginning.
    Start,
    /// From where it stands.
    Continue,
    /// It stays where it stands.
    Stop,
}

/// Why something falls silent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Reason {
    /// Controller 120.
    AllSoundOff,
    /// Controller 123, or one of those from 124 to 127, which imply it.
    AllNotesOff,
    /// System reset, 0xFF.
    Reset,
}
