//! The events of a track.

use midly::{EventIter, MetaMessage, MidiMessage, TrackEventKind};

use crate::midi::channel::Channel;
use crate::midi::message::Message;
use crate::text::Problem;

use super::{MOST_EVENTS, Warnings};

/// One chunk of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Track<'a> {
    pub index: usize,
    /// Where in the file its bytes begin.
    pub at: usize,
    pub bytes: &'a [u8],
    /// Whether the file ends before it does, which has been said.
    pub cut: bool,
}

/// What no cut makes of a file.
const FOUR: &str = "a number has more than four bytes";

/// The longest event with a length of its own: a time, a status and two bytes.
const LONGEST: usize = 7;

/// What tracks contain, by ticks from their beginning.
#[derive(Debug, Default)]
pub(super) struct Contents {
    pub messages: Vec<(u64, Message)>,
    /// Microseconds of a quarter note.
    pub tempi: Vec<(u64, u32)>,
    pub marks: Vec<Mark>,
    pub exclusive: u64,
    /// The longest time between two events of a track.
    pub pause: Option<Pause>,
    /// The last end of a track.
    pub end: u64,
    /// Most messages, tempi and marks.
    most: usize,
}

impl Contents {
    /// Nothing yet, and at most so many messages, tempi and marks.
    pub fn with_room(most: usize) -> Self {
        Self { most, ..Self::default() }
    }
    /// How many more there may be.
    pub fn room(&self) -> usize {
        self.most.saturating_sub(self.messages.len() + self.tempi.len() + self.marks.len())
    }
}

/// Time between two events.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pause {
    pub ticks: [u64; 2],
    /// Where the second of them stands: the track, from 0, and the byte of the file.
    pub track: usize,
    pub at: usize,
}

#[derive(Debug)]
pub(super) struct Mark {
    pub tick: u64,
    pub track: usize,
    pub cue: bool,
    pub text: String,
}

impl Track<'_> {
    /// Adds the track to `contents`; gives its name.
    pub fn read(self, contents: &mut Contents, warnings: &mut Warnings) -> Result<Option<String>, Problem> {
        let mut events = EventIter::new(self.bytes);
        let (mut tick, mut name, mut ended, mut damaged) = (0_u64, None, false, false);
        let mut warn = |at: usize, what: &str, help: &str| {
            warnings.push(at, format!("byte {at}, track {}: {what}", self.index + 1), help);
        };
        while !events.unread().is_empty() && !ended {
            let at = self.at + self.bytes.len() - events.unread().len();
            let wrong = damage(events.unread());
            let left = events.unread().len();
            let event = events.next().and_then(Result::ok).filter(|_| wrong.is_none());
            let Some(event) = event else {
                damaged = true;
                // The file ends within it.
                if self.cut && (wrong.is_some_and(|wrong| wrong != FOUR) || left < LONGEST) {
                    break;
                }
                let what = wrong.unwrap_or("this is no event that a file may have");
                warn(at, what, "what follows in this track is left out; export the file anew");
                break;
            };
            let takes_room = matches!(
                event.kind,
                TrackEventKind::Midi { .. }
                    | TrackEventKind::Meta(
                        MetaMessage::Tempo(_) | MetaMessage::Marker(_) | MetaMessage::CuePoint(_)
                    )
            );
            if takes_room && contents.room() == 0 {
                let what =
                    format!("byte {at}: there are more than {MOST_EVENTS} events, the most that are read");
                return Err(Problem::error(&(at..at), what).help("split the file".to_string()));
            }
            let before = tick;
            tick += u64::from(event.delta.as_int());
            if contents.pause.is_none_or(|longest| longest.ticks[1] - longest.ticks[0] < tick - before) {
                contents.pause = Some(Pause { ticks: [before, tick], track: self.index, at });
            }
            match event.kind {
                TrackEventKind::Midi { channel, message } => {
                    let message = translate(Channel::of_status(channel.as_int()), message);
                    contents.messages.push((tick, message));
                }
                TrackEventKind::SysEx(_) | TrackEventKind::Escape(_) => contents.exclusive += 1,
                TrackEventKind::Meta(MetaMessage::EndOfTrack) => ended = true,
                TrackEventKind::Meta(MetaMessage::TrackName(text)) if name.is_none() => {
                    name = Some(decoded(text))
                }
                TrackEventKind::Meta(MetaMessage::Marker(text)) => {
                    contents.marks.push(Mark { tick, track: self.index, cue: false, text: decoded(text) });
                }
                TrackEventKind::Meta(MetaMessage::CuePoint(text)) => {
                    contents.marks.push(Mark { tick, track: self.index, cue: true, text: decoded(text) });
                }
                TrackEventKind::Meta(MetaMessage::Tempo(length)) if length.as_int() > 0 => {
                    contents.tempi.push((tick, length.as_int()));
                }
                TrackEventKind::Meta(MetaMessage::Tempo(_) | MetaMessage::Unknown(0x51, _)) => {
                    warn(at, "a tempo without a length of its beats is left out", "write the tempo anew");
                }
                TrackEventKind::Meta(MetaMessage::MidiPort(port)) if port.as_int() > 0 => {
                    let what = format!(
                        "this track is for port {}, and plays on the first one's channels",
                        port.as_int() + 1
                    );
                    warn(at, &what, "give its notes channels that other tracks do not use");
                }
                TrackEventKind::Meta(_) => (),
            }
        }
        contents.end = contents.end.max(tick);
        let (left, end) = (events.unread().len(), self.at + self.bytes.len());
        if ended && left > 0 {
            let what = format!("{left} bytes behind the end of the track are left out");
            warn(end - left, &what, "if something is missing, export the file anew");
        } else if !(ended || damaged || self.cut) {
            warn(
                end,
                "there is no end of track",
                "the track ends with its last event; if something is missing, get the file anew",
            );
        }
        Ok(name)
    }
}

/// What is wrong with the lengths of the event at the beginning of `bytes`.
fn damage(bytes: &[u8]) -> Option<&'static str> {
    let (_, rest) = match quantity(bytes) {
        Ok(found) => found,
        Err(what) => return Some(what),
    };
    let text = match rest {
        [0xFF, _, text @ ..] | [0xF0 | 0xF7, text @ ..] => text,
        _ => return None,
    };
    match quantity(text) {
        Ok((length, data)) if data.len() < length => Some("an event claims more bytes than its track has"),
        Ok(_) => None,
        Err(what) => Some(what),
    }
}

/// A variable-length quantity of at most four bytes, and what stands behind it.
fn quantity(bytes: &[u8]) -> Result<(usize, &[u8]), &'static str> {
    let mut value = 0;
    for (i, byte) in bytes.iter().take(4).enumerate() {
        value = value << 7 | usize::from(byte & 127);
        if *byte < 0x80 {
            return Ok((value, bytes.get(i + 1..).unwrap_or_default()));
        }
    }
    Err(if bytes.len() < 4 { "the track ends within a number" } else { FOUR })
}

fn decoded(text: &[u8]) -> String {
    match std::str::from_utf8(text) {
        Ok(text) => text.into(),
        Err(_) => text.iter().map(|byte| char::from(*byte)).collect(),
    }
}

fn translate(channel: Channel, message: MidiMessage) -> Message {
    match message {
        MidiMessage::NoteOff { key, vel } => {
            Message::NoteOff { channel, note: key.as_int(), velocity: vel.as_int() }
        }
        MidiMessage::NoteOn { key, vel } => {
            Message::NoteOn { channel, note: key.as_int(), velocity: vel.as_int() }
        }
        MidiMessage::Aftertouch { key, vel } => {
            Message::PolyPressure { channel, note: key.as_int(), pressure: vel.as_int() }
        }
        MidiMessage::Controller { controller, value } => {
            Message::Controller { channel, number: controller.as_int(), value: value.as_int() }
        }
        MidiMessage::ProgramChange { program } => Message::Program { channel, program: program.as_int() },
        MidiMessage::ChannelAftertouch { vel } => {
            Message::ChannelPressure { channel, pressure: vel.as_int() }
        }
        MidiMessage::PitchBend { bend } => Message::Bend { channel, bend: bend.as_int() },
    }
}
