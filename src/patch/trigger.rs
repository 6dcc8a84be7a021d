//! What starts voices and patterns from outside.

use super::expr::{Expr, Reads};
use super::place::{self, Place};
use crate::midi::pitch;
use crate::text::field::{Field, Form, Table};
use crate::text::nearest::suggest;
use crate::text::reader::{At, Reader, in_order};
use crate::text::{Problem, Span};

/// A trigger, `[[trigger]]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Trigger {
    /// What sets it off.
    pub on: Source,
    /// Where that stands.
    pub on_span: Span,
    /// The voice or pattern it plays.
    pub play: String,
    /// Where that stands.
    pub play_span: Span,
    /// Fields of the event it makes, computed from what set it off: see [`Source::names`].
    pub set: Vec<(String, Expr, Span)>,
    /// Where; `None`: the voice's place.
    pub place: Option<Place>,
    /// The MIDI channel, from 1, that sets it off; `None`: any.
    pub channel: Option<u8>,
    /// The lowest and the highest note that set it off; `None`: any.
    pub notes: Option<[u8; 2]>,
    /// Whether what it plays goes to different tactors.
    pub spread: Spread,
    /// Seconds after it was set off by a node during which that does not set it off again; 0: none.
    pub hold: f64,
    /// What a node must come back to before it can set it off again; `None`: the threshold.
    pub rearm: Option<f64>,
    /// Where it stands.
    pub span: Span,
}

impl Trigger {
    /// Whether what it plays depends on that name of what sets it off.
    pub fn reads(&self, name: &str) -> bool {
        let mut reads = false;
        for (_, expr, _) in &self.set {
            expr.visit(&mut |read, _| reads |= matches!(read, Reads::Name(read) if read == name));
        }
        reads
    }
}

/// How what a trigger plays is spread over the tactors of a rig, in their order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Spread {
    /// Not at all.
    #[default]
    Off,
    /// By note: those of [`Trigger::notes`] from the first tactor to the last; without such, round and round.
    Notes,
    /// By MIDI channel: channel 1 on the first tactor, and round and round.
    Channels,
    /// By where this MIDI controller, 0 to 119, stands on the channel: from the first tactor to the last.
    Controller(u8),
}

/// The longest [`Trigger::hold`], seconds.
pub(super) const MOST_HOLD: f64 = 3600.0;

/// What sets off a trigger.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// The beginning.
    Start,
    /// A key of the computer, from 1.
    Key(u32),
    /// A note begins.
    MidiNote,
    /// A program is chosen, 0 to 127.
    MidiProgram(u8),
    /// A controller (0 to 119) passes a position from 0 to 1.
    MidiController {
        /// Which.
        number: u8,
        /// Upwards; else downwards.
        rises: bool,
        /// The position.
        threshold: f64,
    },
    /// An OSC message to this address.
    Osc(String),
    /// Something happens at the knob.
    Knob {
        /// What.
        what: Happening,
        /// The effect that it happens to; `None`: any.
        effect: Option<String>,
    },
    /// A shared node, or a control, passes a threshold.
    Node {
        /// The shared node or control.
        node: String,
        /// Upwards; else downwards.
        rises: bool,
        /// The threshold.
        threshold: f64,
    },
}

/// What happens at a knob.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Happening {
    /// It passes a detent.
    Detent,
    /// It runs into a wall.
    Wall,
}

impl Happening {
    /// The words for it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Detent => "knob.detent",
            Self::Wall => "knob.wall",
        }
    }

    /// What expressions may read of it, in this order: where the knob is (rad), how fast (rad/s, without a sign), and, 1 or -1, which way it
    /// turns; of a detent also its number, counted from the one at rest.
    pub fn names(self) -> &'static [&'static str] {
        match self {
            Self::Detent => &["angle", "speed", "way", "index"],
            Self::Wall => &["angle", "speed", "way"],
        }
    }
}

/// Its keys.
pub static TABLE: Table = Table {
    name: "trigger",
    doc: "What starts a voice or a pattern.",
    fields: &[
        Field::new(
            "on",
            Form::Text,
            "",
            "start, key.1, midi.note, midi.program 3, midi.controller 80 rises 0.5, osc./address, knob.detent or knob.wall (of any effect, or \
             of one: knob.wall ENDS), or node.NAME rises 0.3 (or falls).",
        )
        .required(),
        Field::new("play", Form::Text, "", "The voice or pattern it plays.").required(),
        Field::new("set", Form::Defined("set"), "", "Fields of the event it makes: numbers or expressions."),
        Field::new("place", Form::Defined("place"), "", "Where; the voice's place where nothing is said."),
        Field::new(
            "channel",
            Form::any_count(1, 16),
            "",
            "The MIDI channel that sets it off; any where nothing is said.",
        ),
        Field::new(
            "notes",
            Form::Defined("notes"),
            "",
            "The lowest and the highest note that set it off, as numbers or names: [36, \"D#3\"]; any where nothing is said.",
        ),
        Field::new(
            "spread",
            Form::Word(&["off", "notes", "channels", "controller"]),
            "",
            "Spreads what it plays over the tactors of the rig, in their order, by note, by MIDI channel, or by where a controller stands then.",
        ),
        Field::new(
            "controller",
            Form::any_count(0, 119),
            "",
            "The MIDI controller by which it is spread: from 0, the first tactor, to the last; on the channel that sets it off.",
        ),
        Field::new(
            "hold",
            Form::number(0.0, 0.0, MOST_HOLD),
            "s",
            "For a node: so long after it has set this off, it does not do so again.",
        ),
        Field::new(
            "rearm",
            Form::any_number(-1e9, 1e9),
            "",
            "For a node: what it must come back to, below (or above) its threshold, before it can set this off again; the threshold where \
             nothing is said.",
        ),
    ],
    others: None,
};

/// How it is spread. A controller goes with `spread = "controller"` and nothing else.
fn spread(reader: &Reader) -> Spread {
    let controller = reader.count("controller").and_then(|n| u8::try_from(n).ok());
    match (reader.word("spread"), controller) {
        (1, None) => Spread::Notes,
        (2, None) => Spread::Channels,
        (3, Some(number)) => Spread::Controller(number),
        (0, None) => Spread::Off,
        (3, None) => {
            let what = format!("`spread` of {} does not say by which controller", reader.who);
            reader.sink.push(
                Problem::error(&reader.span_of("spread"), what)
                    .help("add controller = 10, or another".to_string()),
            );
            Spread::Off
        }
        (_, Some(number)) => {
            let what = format!("`controller` of {} goes with spread = \"controller\"", reader.who);
            let problem = Problem::error(&reader.span_of("controller"), what);
            reader
                .sink
                .push(problem.help("say that, or take it out; a control is moved by a [[bind]]".to_string()));
            Spread::Controller(number)
        }
        _ => Spread::Off,
    }
}

const SOURCES: &[&str] = &[
    "start",
    "key.1",
    "midi.note",
    "midi.program 3",
    "midi.controller 80 rises 0.5",
    "osc./address",
    "knob.detent",
    "knob.wall",
    "node.NAME rises 0.3",
];

impl Source {
    /// Reads what stands at `on`.
    ///
    /// # Errors
    /// Says what it cannot be.
    pub fn parse(text: &str) -> Result<Self, String> {
        match text {
            "start" => return Ok(Self::Start),
            "midi.note" => return Ok(Self::MidiNote),
            _ => {}
        }
        for what in [Happening::Detent, Happening::Wall] {
            match text.strip_prefix(what.word()) {
                Some("") => return Ok(Self::Knob { what, effect: None }),
                Some(effect) if effect.starts_with(' ') => {
                    return Ok(Self::Knob { what, effect: Some(effect.trim().into()) });
                }
                _ => {}
            }
        }
        if let Some(key) = text.strip_prefix("key.") {
            return match key.parse() {
                Ok(n) if n >= 1 => Ok(Self::Key(n)),
                _ => Err(format!("`{key}` is no number of a key; they count from 1")),
            };
        }
        if let Some(address) = text.strip_prefix("osc.") {
            return if address.starts_with('/') && !address.contains(char::is_whitespace) {
                Ok(Self::Osc(address.into()))
            } else {
                Err("an OSC address begins with `/` and has no blanks: osc./hit".into())
            };
        }
        if let Some(program) = text.strip_prefix("midi.program ") {
            return match program.trim().parse() {
                Ok(program) if program <= 127 => Ok(Self::MidiProgram(program)),
                _ => Err(format!("`{program}` is no program; they count from 0 to 127")),
            };
        }
        if let Some(controller) = text.strip_prefix("midi.controller ") {
            let (number, rises, threshold) = crossing(controller)
                .ok_or("a controller sets it off like this: midi.controller 80 rises 0.5, or falls")??;
            return match number.parse() {
                Ok(number) if number <= 119 && (0.0..=1.0).contains(&threshold) => {
                    Ok(Self::MidiController { number, rises, threshold })
                }
                Ok(number) if number <= 119 => Err("a controller stands between 0 and 1".into()),
                _ => Err(format!("`{number}` is no controller; they count from 0 to 119")),
            };
        }
        if let Some(node) = text.strip_prefix("node.") {
            let (node, rises, threshold) =
                crossing(node).ok_or("a node sets it off like this: node.NAME rises 0.3, or falls")??;
            return Ok(Self::Node { node: node.into(), rises, threshold });
        }
        Err("nothing like that sets off a trigger".into())
    }

    /// What is known beforehand of what [`Source::names`] says: a node stands at its threshold as it passes it.
    pub(crate) fn known(&self, name: &str) -> Option<f64> {
        match (self, name) {
            (Self::Node { threshold, .. }, "value") => Some(*threshold),
            _ => None,
        }
    }

    /// Whether it comes from outside while a patch plays: a key, MIDI, OSC.
    pub fn is_live(&self) -> bool {
        match self {
            Self::Key(_)
            | Self::MidiNote
            | Self::MidiProgram(_)
            | Self::MidiController { .. }
            | Self::Osc(_) => true,
            Self::Start | Self::Knob { .. } | Self::Node { .. } => false,
        }
    }

    /// Whether it is known before anything plays, or worked out as it plays, so that nobody need be there.
    pub(crate) fn is_known(&self) -> bool {
        !self.is_live()
    }

    /// What nodes and a knob do, in the words of a patch; `None` for all else.
    pub fn by_itself(&self) -> Option<String> {
        match self {
            Self::Node { node, rises, threshold } => {
                Some(format!("node.{node} {} {threshold}", if *rises { "rises" } else { "falls" }))
            }
            Self::Knob { what, effect: Some(effect) } => Some(format!("{} {effect}", what.word())),
            Self::Knob { what, effect: None } => Some(what.word().into()),
            _ => None,
        }
    }

    /// What the expressions in `set` may read.
    pub fn names(&self) -> &'static [&'static str] {
        match self {
            Self::MidiNote => &["note", "velocity", "pitch", "channel", "bend", "pressure", "timbre"],
            Self::MidiProgram(_) => &["program", "channel"],
            Self::MidiController { .. } => &["value", "channel"],
            Self::Osc(_) | Self::Node { .. } => &["value"],
            Self::Knob { what, .. } => what.names(),
            Self::Start | Self::Key(_) => &[],
        }
    }
}

/// `NAME rises 0.3`: name, way and threshold; `None` where it is nothing of the kind.
fn crossing(text: &str) -> Option<Result<(&str, bool, f64), String>> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let [name, way @ ("rises" | "falls"), threshold] = words[..] else { return None };
    Some(match threshold.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok((name, way == "rises", x)),
        _ => Err(format!("`{threshold}` is no threshold")),
    })
}

/// Two notes, as numbers or names.
fn notes(reader: &Reader) -> Option<[u8; 2]> {
    let value = reader.at("notes")?;
    let note = |value: &At| match (value.count(), value.text()) {
        (Some(number), _) => u8::try_from(number).ok().filter(|number| *number <= 127),
        (_, Some(name)) => pitch::note(name),
        _ => None,
    };
    let notes: Option<Vec<u8>> = value.list().and_then(|list| list.map(|v| note(&v)).collect());
    match notes.as_deref() {
        Some(&[least, most]) if least <= most => Some([least, most]),
        Some(&[_, _]) => {
            reader.wrong("notes", &value, "the lower note must stand first");
            None
        }
        _ => {
            reader.wrong(
                "notes",
                &value,
                "it must be two notes, as numbers from 0 to 127 or names: [36, \"D#3\"]",
            );
            None
        }
    }
}

pub(crate) fn read(reader: &Reader) -> Option<Trigger> {
    let on = reader.text("on").and_then(|text| match Source::parse(text) {
        Ok(on) => Some(on),
        Err(why) => {
            let problem = Problem::error(
                &reader.span_of("on"),
                format!("`on` of {} cannot be \"{text}\": {why}", reader.who),
            );
            reader.sink.push(problem.help(suggest(text, SOURCES.iter().copied())));
            None
        }
    });
    let mut set = Vec::new();
    for (field, span, value) in reader.table("set").map(|(t, _)| in_order(t)).unwrap_or_default() {
        let expr = match (value.number(), value.text()) {
            (Some(x), _) if x.is_finite() => Some(Expr::Number(x)),
            (_, Some(text)) => Expr::parse(text, &value.span()).map_err(|p| reader.sink.push(p)).ok(),
            _ => {
                reader.mistaken(field, &value, "a number or an expression");
                None
            }
        };
        set.extend(expr.map(|e| (field.to_string(), e, span)));
    }
    let place = place::read(reader, "place");
    let Some(on) = on else {
        // What it plays and where can be looked at all the same; what it sets depends on what sets it off.
        return Some(Trigger {
            on: Source::Start,
            on_span: reader.span_of("on"),
            play: reader.text("play")?.into(),
            play_span: reader.span_of("play"),
            set: Vec::new(),
            place,
            channel: None,
            notes: None,
            spread: Spread::Off,
            hold: 0.0,
            rearm: None,
            span: reader.span.clone(),
        });
    };
    Some(Trigger {
        place,
        channel: reader.count("channel").and_then(|n| u8::try_from(n).ok()),
        notes: notes(reader),
        spread: spread(reader),
        hold: reader.number("hold").unwrap_or(0.0),
        rearm: reader.number("rearm"),
        play: reader.text("play")?.into(),
        play_span: reader.span_of("play"),
        on,
        on_span: reader.span_of("on"),
        set,
        span: reader.span.clone(),
    })
}
