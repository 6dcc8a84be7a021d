//! The patch: what people write about sound and time. Voices are node graphs, patterns are events in time, triggers start
//! either.
//!
//! A [`Patch`] is a plain description with no state, and may as well be built in code; [`Patch::check`] finds what is wrong
//! with it. [`Patch::parse`] reads it from a file's bytes and reports every problem at once, each at its place.

pub(crate) mod advice;
pub mod bind;
mod check;
pub(crate) mod control;
mod crossing;
mod cycle;
pub(crate) mod event;
pub(crate) mod events_file;
pub(crate) mod expr;
pub(crate) mod felt;
mod keyed;
pub mod knob;
pub mod motion;
pub(crate) mod names;
pub(crate) mod node;
pub(crate) mod pattern;
pub(crate) mod place;
pub mod reference;
mod schema;
pub(crate) mod scope;
mod steered;
pub(crate) mod trigger;
pub(crate) mod voice;
mod way;

pub use bind::{Bind, Mover};
pub use control::{Control, Curve};
pub use event::{Action, Alternative, Event, Play, Repeat, Setting};
pub use events_file::EventsFile;
pub use expr::{Expr, Function, Operator};
pub use felt::Pitch;
pub use knob::Knob;
pub use motion::Motion;
pub use names::Names;
pub use node::{Argument, Node, Value};
pub use pattern::{Events, Jitter, Pattern, TimeBase};
pub use place::Place;
pub use schema::schema;
pub(crate) use scope::{Scope, Target};
pub use trigger::{Happening, Source, Spread, Trigger};
pub use voice::{Start, Voice};
pub use way::Way;

use crate::midi::{Channel, Claims};
use crate::text::document;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;
use crate::text::sink::Sink;
use crate::text::{Checked, Origin, Problem, Problems, Span};

/// A patch.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Patch {
    /// What it is called.
    pub title: String,
    /// What it is about; may be empty.
    pub description: String,
    /// What MIDI, OSC or a program may move while it plays.
    pub controls: Vec<Control>,
    /// Voices, in the order of the file.
    pub voices: Vec<Voice>,
    /// Nodes that run once for the whole engine.
    pub shared: Vec<Node>,
    /// Patterns, in the order of the file.
    pub patterns: Vec<Pattern>,
    /// What starts voices and patterns.
    pub triggers: Vec<Trigger>,
    /// What moves controls.
    pub binds: Vec<Bind>,
    /// What a force-feedback knob feels like.
    pub knob: Option<Knob>,
    /// How to render it where the person says nothing else.
    pub render: Render,
    /// The file that it was read from.
    pub origin: Origin,
}

/// Defaults for rendering.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Render {
    /// Length in seconds; `None`: until everything has ended.
    pub duration: Option<f64>,
    /// From which all random numbers come; `None` is 0.
    pub seed: Option<u64>,
    /// Seconds to go on after the last voice has ended.
    pub tail: Option<f64>,
}

/// The format that this version reads and writes.
pub const FORMAT: &str = "pacinian-patch/1";

/// What a patch may do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Permissions {
    /// Whether paths in it may leave its folder.
    pub allow_outside: bool,
}

impl Permissions {
    /// A path as written, if it may be opened: relative, forward slashes, not leaving the folder unless that is allowed.
    pub(crate) fn path(self, path: &str, span: &Span, who: &str, sink: &Sink) -> Option<String> {
        let rooted = path.starts_with('/') || path.starts_with('\\') || path.get(1..2) == Some(":");
        let leaves = path.split(['/', '\\']).any(|part| part == "..");
        if path.is_empty() || path.contains('\0') {
            sink.error(span, format!("a file of {who} has no name"));
        } else if (rooted || leaves) && !self.allow_outside {
            sink.error_help(
                span,
                format!("{who}: the path \"{path}\" leaves the folder of the patch"),
                "put the file beside the patch and write its path from there, or allow it with --allow-outside",
            );
        } else {
            return Some(path.into());
        }
        None
    }
}

/// Its keys.
pub(crate) static TABLE: Table = Table {
    name: "patch",
    doc: "Voices are node graphs, patterns are events in time, triggers start either.",
    fields: &[
        Field::new("format", Form::Defined("format"), "", "The format and its version.").required(),
        Field::new("title", Form::Text, "", "What it is called.").required(),
        Field::new("description", Form::Text, "", "What it is about."),
        Field::new(
            "control",
            Form::Named(&control::TABLE),
            "",
            "What MIDI, OSC or a program may move while it plays, by name.",
        ),
        Field::new("voice", Form::Named(&voice::TABLE), "", "Voices, by name."),
        Field::new("shared", Form::One(&SHARED), "", "What runs once for the whole engine."),
        Field::new("pattern", Form::Named(&pattern::TABLE), "", "Patterns, by name."),
        Field::new("trigger", Form::Many(&trigger::TABLE), "", "What starts voices and patterns."),
        Field::new("bind", Form::Many(&bind::TABLE), "", "What moves controls from outside."),
        Field::new("knob", Form::One(&knob::TABLE), "", "What a force-feedback knob feels like."),
        Field::new("render", Form::One(&RENDER), "", "How to render it where the person says nothing else."),
    ],
    others: None,
};

/// The keys of `[shared]`.
pub(crate) static SHARED: Table = Table {
    name: "shared",
    doc: "What runs once for the whole engine.",
    fields: &[Field::new("nodes", Form::Defined("nodes"), "", "Nodes that every voice may read.")],
    others: None,
};

/// The keys of `[render]`.
pub(crate) static RENDER: Table = Table {
    name: "render",
    doc: "How to render the patch where the person says nothing else.",
    fields: &[
        Field::new(
            "duration",
            Form::any_number(1e-6, 1e9),
            "s",
            "Length; until everything has ended where nothing is said.",
        ),
        Field::new(
            "seed",
            Form::any_count(0, u64::MAX),
            "",
            "From which all random numbers come; 0 where nothing is said.",
        ),
        Field::new(
            "tail",
            Form::any_number(0.0, 3600.0),
            "s",
            "How long to go on after the last voice has ended.",
        ),
    ],
    others: None,
};

impl Patch {
    /// The recordings that its nodes name, and where they name them; one that is named twice comes twice.
    pub fn recordings(&self) -> impl Iterator<Item = (&str, &Span)> {
        let nodes = self.voices.iter().flat_map(|voice| &voice.nodes).chain(&self.shared);
        nodes.flat_map(|node| &node.arguments).filter_map(|argument| match &argument.value {
            Value::File(path) => Some((path.as_str(), &argument.span)),
            _ => None,
        })
    }

    /// The events files that its patterns name, and where they name them.
    pub fn events_files(&self) -> impl Iterator<Item = (&str, &Span)> {
        self.patterns.iter().filter_map(|pattern| match &pattern.events {
            Events::File(path, span) => Some((path.as_str(), span)),
            Events::Inline(_) => None,
        })
    }

    /// Reads a patch from the bytes of a file called `name`.
    ///
    /// # Errors
    /// Every problem of the file at once, each with its place.
    pub fn parse(name: &str, bytes: &[u8]) -> Result<Checked<Self>, Problems> {
        Self::parse_with(name, bytes, Permissions::default())
    }

    /// Reads a patch that may do what `options` say.
    ///
    /// # Errors
    /// Every problem of the file at once, each with its place.
    pub fn parse_with(name: &str, bytes: &[u8], options: Permissions) -> Result<Checked<Self>, Problems> {
        document::read(name, bytes, FORMAT, |document, sink| {
            let reader = Reader::new(&TABLE, document, 0..0, "the patch", sink);
            let (patch, broken) = Self::read(&reader, options);
            for problem in patch.problems(&broken) {
                sink.push(problem);
            }
            patch
        })
        .map(|mut checked| {
            // It could be read, so it is text.
            let source = std::str::from_utf8(bytes).unwrap_or_default();
            checked.value.origin = Origin { file: name.into(), source: source.into() };
            checked
        })
    }

    /// What can be read of a patch in which something is wrong, for who looks for further trouble, as in the files that it names;
    /// `None` where it is no TOML at all.
    pub fn readable(bytes: &[u8], options: Permissions) -> Option<Self> {
        let mut part = None;
        let _ = document::read("", bytes, FORMAT, |document, sink| {
            let reader = Reader::new(&TABLE, document, 0..0, "the patch", sink);
            part = Some(Self::read(&reader, options).0);
        });
        part
    }

    /// What is wrong with it as a whole: names that nothing has, cycles, patterns that contain themselves. Spans are those of
    /// the parts.
    pub fn check(&self) -> Vec<Problem> {
        self.problems(&[])
    }

    /// Whether a trigger or a binding of it hears MIDI.
    pub fn hears_midi(&self) -> bool {
        let set_off = |trigger: &Trigger| {
            matches!(trigger.on, Source::MidiNote | Source::MidiProgram(_) | Source::MidiController { .. })
        };
        self.triggers.iter().any(set_off)
            || self.binds.iter().any(|bind| !matches!(bind.from, Mover::Osc { .. }))
    }

    /// Whether a pattern of it follows the clock of MIDI.
    pub fn follows_clock(&self) -> bool {
        self.patterns.iter().any(|pattern| pattern.follows)
    }

    /// The controllers of MIDI that its triggers and bindings hear, on their channels.
    pub fn controllers(&self) -> Claims {
        let triggers = self.triggers.iter().filter_map(|trigger| match trigger.on {
            Source::MidiController { number, .. } => Some((number, trigger.channel)),
            _ => None,
        });
        let binds = self.binds.iter().filter_map(|bind| match bind.from {
            Mover::Controller(number) => Some((number, bind.channel)),
            _ => None,
        });
        let spreads = self.triggers.iter().filter_map(|trigger| match trigger.spread {
            Spread::Controller(number) => Some((number, trigger.channel)),
            _ => None,
        });
        let on = |channel: Option<u8>| channel.and_then(|number| Channel::new(number.wrapping_sub(1)));
        let mut claims = Claims::default();
        for (number, channel) in triggers.chain(binds).chain(spreads) {
            claims.add(number, on(channel));
        }
        for bind in self.binds.iter().filter(|bind| bind.encoder.is_some()) {
            if let Mover::Controller(number) = bind.from {
                claims.add_steps(number, on(bind.channel));
            }
        }
        claims
    }

    /// Every place that stands in it, with where it stands: of voices, of events, of triggers that are set off by the start or by a node.
    pub fn each_place(&self, mut see: impl FnMut(&Place, &Span)) {
        for voice in &self.voices {
            voice.place.iter().for_each(|place| see(place, &voice.place_span));
        }
        self.each_play(|play, _| play.places().for_each(|(place, span)| see(place, span)));
        for trigger in self.triggers.iter().filter(|t| t.on.is_known()) {
            trigger.place.iter().for_each(|place| see(place, &trigger.span));
        }
    }

    /// The pattern that a trigger plays, if it plays one: a voice of the same name goes before it.
    pub(crate) fn pattern_of<'a>(&self, trigger: &'a Trigger) -> Option<&'a str> {
        let name = trigger.play.as_str();
        let is = !self.voices.iter().any(|voice| voice.name == name)
            && self.patterns.iter().any(|pattern| pattern.name == name);
        is.then_some(name)
    }

    /// The patterns that nodes and a knob set off, each with what does so.
    pub fn set_off(&self) -> impl Iterator<Item = (&str, String)> {
        let by_itself = |trigger: &Trigger| trigger.on.by_itself();
        self.triggers.iter().filter_map(move |trigger| Some((self.pattern_of(trigger)?, by_itself(trigger)?)))
    }

    /// Every place in it, those of triggers by hand included.
    pub(crate) fn each_place_written(&self, mut see: impl FnMut(&Place)) {
        self.voices.iter().filter_map(|voice| voice.place.as_ref()).for_each(&mut see);
        self.triggers.iter().filter_map(|trigger| trigger.place.as_ref()).for_each(&mut see);
        self.each_play(|play, _| play.places().for_each(|(place, _)| see(place)));
    }

    /// Every voice that an event in it plays, alternatives included, with its pattern; those of events files are not.
    pub fn each_play<'a>(&'a self, mut see: impl FnMut(&'a Play, &'a Pattern)) {
        for pattern in &self.patterns {
            let Events::Inline(events) = &pattern.events else { continue };
            let actions = events.iter().flat_map(|event| match &event.action {
                Action::Choose(list) => list.iter().map(|a| &a.action).collect(),
                action => vec![action],
            });
            for action in actions {
                if let Action::Voice(play) = action {
                    see(play, pattern);
                }
            }
        }
    }

    /// The patch, and the names of what is in the file but cannot be read: to name it is no further mistake.
    fn read(reader: &Reader, options: Permissions) -> (Self, Vec<String>) {
        let mut broken = Vec::new();
        let mut patch = Self {
            title: reader.text("title").unwrap_or("").into(),
            description: reader.text("description").unwrap_or("").into(),
            ..Self::default()
        };
        for (name, reader) in reader.named("control", "control") {
            voice::check_node_name(&name, &reader.span, &reader.who, reader.sink);
            patch.controls.push(control::read(&name, &reader));
        }
        for (name, reader) in reader.named("voice", "voice") {
            let mut names = Vec::new();
            patch.voices.push(voice::read(&name, &reader, &options, &mut names));
            broken.append(&mut names);
        }
        if let Some((nodes, _)) = reader.one("shared", "`shared`").and_then(|r| r.table("nodes")) {
            patch.shared = voice::read_nodes(nodes, "the shared nodes", &options, reader.sink, &mut broken);
        }
        if let Some(knob) = reader.one("knob", "the knob") {
            patch.knob = Some(knob::read(&knob, &mut patch.shared));
            if !patch.controls.iter().any(|control| control.name == knob::HAND) {
                patch.controls.push(knob::hand(&knob.span));
            }
        }
        for (name, reader) in reader.named("pattern", "pattern") {
            patch.patterns.push(pattern::read(&name, &reader, &options));
        }
        let triggers = reader.many("trigger", |n| format!("trigger {n}"));
        patch.triggers = triggers.iter().filter_map(trigger::read).collect();
        patch.binds = reader.many("bind", |n| format!("binding {n}")).iter().filter_map(bind::read).collect();
        if let Some(render) = reader.one("render", "`render`") {
            patch.render = Render {
                duration: render.number("duration"),
                seed: render.count("seed"),
                tail: render.number("tail"),
            };
        }
        (patch, broken)
    }
}
