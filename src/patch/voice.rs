//! A voice: a node graph that sounds once for every event.

use super::Permissions;
use super::event::{LEAST_FELT, MOST_FELT, RESERVED, Setting};
use super::node::{self, Node};
use super::place::{self, Place};
use crate::perception::threshold::RANGE;
use crate::space::law::Law;
use crate::text::Span;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::{Reader, in_order};
use crate::text::sink::Sink;
use toml::de::DeTable;

/// A voice, `[voice.NAME]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Voice {
    /// Its name.
    pub name: String,
    /// How many may sound at once.
    pub voices: u32,
    /// Name of the node that is heard.
    pub output: String,
    /// Where `output` stands.
    pub output_span: Span,
    /// What starts it.
    pub start: Start,
    /// Seconds to sound on after its envelopes have ended, for what rings; `None`: as long as the nodes say.
    pub tail: Option<f64>,
    /// Where it sounds unless its event says so; `None`: the rig's first tactor.
    pub place: Option<Place>,
    /// By which law the tactors about a position share it.
    pub law: Law,
    /// How far a position spreads, m.
    pub width: f64,
    /// Where that stands; the voice's place where there is none.
    pub place_span: Span,
    /// Level of an event that gives none.
    pub level: f64,
    /// In place of that: decibels above the threshold; `None`: it has a level.
    pub felt: Option<Setting>,
    /// The frequency at which `felt` holds, Hz; `None`: that of the event.
    pub felt_at: Option<f64>,
    /// Duration, in seconds, of an event that gives none.
    pub duration: f64,
    /// Further fields of its events with their defaults, in the order of the file; `frequency` is always the first.
    pub fields: Vec<(String, f64)>,
    /// Its nodes, in the order of the file.
    pub nodes: Vec<Node>,
    /// Where it stands.
    pub span: Span,
}

/// The words of the laws, the usual one first.
const LAWS: [&str; 4] = ["energy", "logarithmic", "linear", "nearest"];

/// What starts a voice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Start {
    /// Events.
    Event,
    /// It sounds from the first sample to the last, with its defaults.
    Always,
}

impl Voice {
    /// A voice with no nodes and all defaults, whose output is the node `output`.
    pub fn new(name: &str, output: &str) -> Self {
        Self {
            name: name.into(),
            voices: 8,
            output: output.into(),
            output_span: 0..0,
            start: Start::Event,
            tail: None,
            place: None,
            law: Law::Energy,
            width: 0.0,
            place_span: 0..0,
            level: 1.0,
            felt: None,
            felt_at: None,
            duration: 0.1,
            fields: vec![("frequency".into(), DEFAULT_FREQUENCY)],
            nodes: Vec::new(),
            span: 0..0,
        }
    }
    /// The default of a field of its events: `level`, `duration`, `frequency` or one that it declares.
    pub fn field(&self, name: &str) -> Option<f64> {
        match name {
            "level" => Some(self.level),
            "duration" => Some(self.duration),
            _ => self.fields.iter().find(|(n, _)| n == name).map(|(_, v)| *v),
        }
    }
}

/// The most fields, other than `level` and `duration`, that the events of a voice may have.
pub const MOST_FIELDS: usize = 8;
/// How many of one voice may sound at once.
pub const MOST_VOICES: u32 = 4096;

/// `event.frequency` where neither the event nor the voice says any, Hz: where the skin feels vibration best.
pub const DEFAULT_FREQUENCY: f64 = 250.0;

/// Its keys.
pub static TABLE: Table = Table {
    name: "voice",
    doc: "A node graph that sounds once for every event.",
    fields: &[
        Field::new("voices", Form::count(8, 1, MOST_VOICES as u64), "", "How many may sound at once."),
        Field::new("output", Form::Text, "", "Name of the node that is heard.").required(),
        Field::new(
            "start",
            Form::Word(&["event", "always"]),
            "",
            "What starts it: events, or it sounds all the time.",
        ),
        Field::new(
            "tail",
            Form::any_number(0.0, 3600.0),
            "s",
            "How long it sounds on after its envelopes have ended.",
        ),
        Field::new(
            "place",
            Form::Defined("place"),
            "",
            "Where it sounds unless its event says so; the first tactor where nothing is said.",
        ),
        Field::new(
            "law",
            Form::Word(&LAWS),
            "",
            "By which law the tactors about a position share it. With the share w of a tactor, its gain is √w (energy: the power stays), log₂(1 + w) (logarithmic) or w (linear); nearest: the nearest has all of it.",
        ),
        Field::new(
            "width",
            Form::number(0.0, 0.0, 10.0),
            "m",
            "How far a position spreads: the standard deviation of a Gaussian of weights; 0: no farther than the tactors about it.",
        ),
        Field::new(
            "felt_at",
            Form::any_number(RANGE[0], RANGE[1]),
            "Hz",
            "At which frequency `felt` holds; at that of the event where nothing is said, if the voice reads event.frequency.",
        ),
        Field::new(
            "defaults",
            Form::One(&DEFAULTS),
            "",
            "Fields of its events: what an event that does not give them has.",
        ),
        Field::new("nodes", Form::Defined("nodes"), "", "Its nodes, by name."),
    ],
    others: None,
};

/// The fields of a voice's events.
pub static DEFAULTS: Table = Table {
    name: "defaults",
    doc: "Fields of a voice's events with their defaults. Nodes read them as event.NAME.",
    fields: &[
        Field::new("level", Form::number(1.0, 0.0, 100.0), "", "Share of the actuator's rated vibration."),
        Field::new(
            "felt",
            Form::any_number(LEAST_FELT, MOST_FELT),
            "dB",
            "In place of a level: so far above the threshold, on every tactor by its calibration.",
        ),
        Field::new("duration", Form::number(0.1, 0.0, 1e6), "s", "From onset to release."),
        Field::new(
            "frequency",
            Form::number(DEFAULT_FREQUENCY, -1e6, 1e6),
            "Hz",
            "What nodes read as event.frequency.",
        ),
    ],
    others: Some(&Field::new("", Form::any_number(-1e9, 1e9), "", "A field of its own.")),
};

pub(crate) fn read(name: &str, reader: &Reader, options: &Permissions, broken: &mut Vec<String>) -> Voice {
    let mut voice = Voice::new(name, reader.text("output").unwrap_or(""));
    voice.output_span = reader.span_of("output");
    voice.voices = reader.count("voices").and_then(|n| u32::try_from(n).ok()).unwrap_or(8);
    voice.start = if reader.word("start") == 0 { Start::Event } else { Start::Always };
    voice.tail = reader.number("tail");
    voice.place = place::read(reader, "place");
    voice.place_span = reader.span_of("place");
    voice.law = LAWS[reader.word("law")].parse().unwrap_or_default();
    voice.width = reader.number_or_default("width");
    voice.felt_at = reader.number("felt_at");
    voice.span = reader.span.clone();
    if let Some(defaults) = reader.one("defaults", format!("`defaults` of {}", reader.who)) {
        voice.level = defaults.number_or_default("level");
        voice.felt = defaults.number("felt").map(|value| Setting {
            name: "felt".into(),
            value,
            span: defaults.span_of("felt"),
        });
        if defaults.has("felt") && defaults.has("level") {
            defaults.sink.push(super::felt::both(&defaults.span_of("felt"), &defaults.who));
        }
        voice.duration = defaults.number_or_default("duration");
        voice.fields = vec![("frequency".into(), defaults.number_or_default("frequency"))];
        for (field, span, value) in defaults.others() {
            if RESERVED.contains(&field) || !is_word(field) {
                defaults.sink.error_help(
                    &span,
                    format!("{} cannot have a field `{field}`", defaults.who),
                    "a field is a letter, then letters, digits and `_`, and no other key of an event",
                );
            }
            let value = defaults.number_in(field, &value, -1e9, 1e9).unwrap_or(0.0);
            voice.fields.push((field.into(), value));
        }
        if voice.fields.len() > MOST_FIELDS {
            let (who, count) = (&defaults.who, voice.fields.len());
            let what =
                format!("{who} declare {count} fields, `frequency` included; {MOST_FIELDS} are the most");
            defaults.sink.error(&defaults.span, what);
            voice.fields.truncate(MOST_FIELDS);
        }
    }
    if let Some((nodes, _)) = reader.table("nodes") {
        voice.nodes = read_nodes(nodes, &reader.who, options, reader.sink, broken);
    }
    if voice.nodes.is_empty() && broken.is_empty() && !voice.output.is_empty() {
        reader.sink.error_help(
            &reader.span,
            format!("{} has no nodes", reader.who),
            &format!("write them under [voice.{name}.nodes]"),
        );
        broken.push(voice.output.clone());
    }
    voice
}

/// Reads nodes by name; the names of those that cannot be read go to `broken`.
pub(crate) fn read_nodes(
    nodes: &DeTable,
    of: &str,
    options: &Permissions,
    sink: &Sink,
    broken: &mut Vec<String>,
) -> Vec<Node> {
    let mut read: Vec<Node> = Vec::with_capacity(nodes.len());
    for (name, span, value) in in_order(nodes) {
        check_node_name(name, &span, of, sink);
        match node::read(name, span, value, of, options, sink) {
            Some(node) => read.push(node),
            None => broken.push(name.into()),
        }
    }
    read
}

/// That a node or a control can be named so in an expression.
pub(crate) fn check_node_name(name: &str, span: &Span, of: &str, sink: &Sink) {
    let taken = name == "event" || super::Function::find(name).is_some();
    if taken {
        let what = format!("{of}: `{name}` has a meaning in expressions, so nothing can be called that");
        sink.error_help(span, what, "choose another name");
    } else if !is_word(name) {
        let what = format!("{of}: the name `{}` cannot be used", name.chars().take(64).collect::<String>());
        sink.error_help(span, what, "a name is a letter, then letters, digits and `_`, 64 at most");
    }
}

fn is_word(name: &str) -> bool {
    name.len() <= 64
        && name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}
