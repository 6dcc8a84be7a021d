//! What starts voices and patterns from outside.

use super::expr::Expr;
use super::place::{self, Place};
use crate::text::field::{Field, Form, Table};
use crate::text::nearest::suggest;
use crate::text::reader::{Reader, in_order};
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
    /// Where it stands.
    pub span: Span,
}

/// What sets off a trigger.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// The beginning.
    Start,
    /// A key of the computer, from 1.
    Key(u32),
    /// A note begins.
    MidiNote,
    /// An OSC message to this address.
    Osc(String),
    /// The knob passes a detent.
    KnobDetent,
    /// A shared node passes a threshold.
    Node {
        /// The shared node.
        node: String,
        /// Upwards; else downwards.
        rises: bool,
        /// The threshold.
        threshold: f64,
    },
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
            "start, key.1, midi.note, osc./address, knob.detent, node.NAME rises 0.3 or node.NAME falls 0.3.",
        )
        .required(),
        Field::new("play", Form::Text, "", "The voice or pattern it plays.").required(),
        Field::new("set", Form::Defined("set"), "", "Fields of the event it makes: numbers or expressions."),
        Field::new("place", Form::Defined("place"), "", "Where; the voice's place where nothing is said."),
    ],
    others: None,
};

const SOURCES: &[&str] =
    &["start", "key.1", "midi.note", "osc./address", "knob.detent", "node.NAME rises 0.3"];

impl Source {
    /// Reads what stands at `on`.
    ///
    /// # Errors
    /// Says what it cannot be.
    pub fn parse(text: &str) -> Result<Self, String> {
        match text {
            "start" => return Ok(Self::Start),
            "midi.note" => return Ok(Self::MidiNote),
            "knob.detent" => return Ok(Self::KnobDetent),
            _ => {}
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
                Err("an OSC address begins with `/`: osc./hit".into())
            };
        }
        if let Some(node) = text.strip_prefix("node.") {
            let words: Vec<&str> = node.split_whitespace().collect();
            return match words.as_slice() {
                [node, way @ ("rises" | "falls"), threshold] => match threshold.parse::<f64>() {
                    Ok(x) if x.is_finite() => {
                        Ok(Self::Node { node: (*node).into(), rises: *way == "rises", threshold: x })
                    }
                    _ => Err(format!("`{threshold}` is no threshold")),
                },
                _ => Err("a node sets it off like this: node.NAME rises 0.3, or falls".into()),
            };
        }
        Err("nothing like that sets off a trigger".into())
    }
    /// What the expressions in `set` may read.
    pub fn names(&self) -> &'static [&'static str] {
        match self {
            Self::MidiNote => &["note", "velocity"],
            Self::Osc(_) | Self::Node { .. } => &["value"],
            Self::Start | Self::Key(_) | Self::KnobDetent => &[],
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
    Some(Trigger {
        place: place::read(reader, "place"),
        play: reader.text("play")?.into(),
        play_span: reader.span_of("play"),
        on: on?,
        on_span: reader.span_of("on"),
        set,
        span: reader.span.clone(),
    })
}
