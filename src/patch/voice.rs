//! A voice: a node graph that sounds once for every event.

use super::node::Node;
use super::place::Place;
use crate::text::Span;

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
    /// Level of an event that gives none.
    pub level: f64,
    /// Duration in seconds (beats in a pattern of beats) of an event that gives none.
    pub duration: f64,
    /// Further fields of its events with their defaults, in the order of the file; `frequency` is always the first.
    pub fields: Vec<(String, f64)>,
    /// Its nodes, in the order of the file.
    pub nodes: Vec<Node>,
    /// Where it stands.
    pub span: Span,
}

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
            level: 1.0,
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

/// `event.frequency` where neither the event nor the voice says any, Hz: where the skin feels vibration best.
pub const DEFAULT_FREQUENCY: f64 = 250.0;
