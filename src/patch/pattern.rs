//! A pattern: events in time.
//!
//! # When an event sounds
//!
//! Times of a pattern are counted in its own unit (seconds, or beats of its own tempo) and divided by its rate and by the
//! rates of all events that play it. Playing number k (from 0) of a pattern that repeats begins at k × `every`; repetitions
//! may overlap. Repetition j of an event has its onset at `at` + `delay` + j × `every` after that. Durations are counted in
//! the same unit and divided by the same rates; the default duration of a voice counts in the same unit. The level
//! of an event is multiplied by the gain of its pattern, of the event that plays the pattern, and so on outwards.
//!
//! # What is drawn
//!
//! All random numbers come from the seed, the pattern, the number of the playing, the event and its repetition, so that one
//! draw never moves another.
//!
//! - `shuffle`: once for each playing, a permutation of the pattern's events is drawn, all equally likely. The onsets (`at`)
//!   stay in their order; which event lands on which is what changes. An event takes everything but its `at` along.
//! - `choose`: for each repetition of the event in each playing, one alternative is drawn with probability weight / sum of
//!   the weights. An event with `choose` has itself only `at`, `delay` and `repeat`; level, place and the rest stand in the
//!   alternatives, which do not choose again.
//! - `jitter`: for each repetition of each event in each playing. `at` = a moves the onset by a × u; every other key is a
//!   share s by which a field is multiplied, 1 + s × u. Each has its own u, evenly distributed from −1 to 1. An onset never
//!   comes before the start of its playing. Only events that play a voice are moved in level, duration and fields.
//!
//! Events at the same instant happen in the order of the list. A file of events is never shuffled.

use super::Permissions;
use super::event::{self, Event, Repeat, Setting};
use crate::text::Span;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;

/// A pattern, `[pattern.NAME]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Pattern {
    /// Its name.
    pub name: String,
    /// In what its times are counted.
    pub time: TimeBase,
    /// Whether a MIDI clock, or the tempo of a song, counts its beats and starts and stops it.
    pub follows: bool,
    /// What it plays.
    pub events: Events,
    /// The whole pattern again and again.
    pub repeat: Option<Repeat>,
    /// Multiplies the level of all it plays.
    pub gain: f64,
    /// 2 is twice as fast, durations included.
    pub rate: f64,
    /// Whether the events change places: each time the pattern plays, its onsets stay and what lands on them is permuted.
    pub shuffle: bool,
    /// Random deviations, drawn for each event each time.
    pub jitter: Option<Jitter>,
    /// Where it stands.
    pub span: Span,
}

/// In what a pattern counts time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TimeBase {
    /// Seconds.
    Seconds,
    /// Beats, at so many a minute.
    Beats(f64),
}

impl TimeBase {
    /// Seconds in one unit of it.
    pub fn seconds(self) -> f64 {
        match self {
            Self::Seconds => 1.0,
            Self::Beats(tempo) => 60.0 / tempo,
        }
    }
}

/// Where a pattern's events stand.
#[derive(Debug, Clone, PartialEq)]
pub enum Events {
    /// In the patch.
    Inline(Vec<Event>),
    /// In a file beside it; read it with [`super::events_file::EventsFile`].
    File(String, Span),
}

/// Random deviations.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Jitter {
    /// Onsets move by up to so much to either side, in the pattern's time, evenly distributed; never before its start.
    pub at: f64,
    /// A field (`level`, `duration` or a voice's own) is multiplied by 1 + u × fraction, u evenly distributed from −1 to 1.
    pub fractions: Vec<Setting>,
}

/// Its keys.
pub static TABLE: Table = Table {
    name: "pattern",
    doc: "Events in time.",
    fields: &[
        Field::new("time", Form::Word(&["seconds", "beats"]), "", "In what its times are counted."),
        Field::new("tempo", Form::number(120.0, 1.0, 10_000.0), "1/min", "Beats in a minute."),
        Field::new(
            "clock",
            Form::Word(&["own", "midi"]),
            "",
            "Who counts its beats: its own tempo, or a MIDI clock, which starts and stops it, too.",
        ),
        Field::new("events", Form::Defined("events"), "", "A list of events, or the name of a file of them.")
            .required(),
        Field::new("repeat", Form::One(&event::REPEAT), "", "The whole pattern again and again."),
        Field::new("gain", Form::number(1.0, 0.0, 100.0), "", "Multiplies the level of all it plays."),
        Field::new("rate", Form::number(1.0, 1e-3, 1e3), "", "2 is twice as fast, durations included."),
        Field::new(
            "shuffle",
            Form::Flag(false),
            "",
            "Each time it plays, its onsets stay and what lands on them is permuted.",
        ),
        Field::new("jitter", Form::One(&JITTER), "", "Random deviations, drawn for each event each time."),
    ],
    others: None,
};

/// The keys of `jitter`.
pub static JITTER: Table = Table {
    name: "jitter",
    doc: "Random deviations, drawn for each event each time the pattern plays.",
    fields: &[
        Field::new(
            "at",
            Form::number(0.0, 0.0, 1e9),
            "s or beats",
            "Onsets move by up to so much to either side, never before the start.",
        ),
        Field::new("level", Form::number(0.0, 0.0, 1.0), "", "The level changes by up to this share of it."),
        Field::new(
            "duration",
            Form::number(0.0, 0.0, 1.0),
            "",
            "The duration changes by up to this share of it.",
        ),
    ],
    others: Some(&Field::new(
        "",
        Form::number(0.0, 0.0, 1.0),
        "",
        "A field changes by up to this share of it.",
    )),
};

pub(crate) fn read(name: &str, reader: &Reader, options: &Permissions) -> Pattern {
    let beats = reader.word("time") == 1;
    let tempo = reader.number_or_default("tempo");
    if reader.has("tempo") && !beats {
        let what = format!("{} has a tempo but counts in seconds", reader.who);
        reader.sink.error_help(
            &reader.span_of("tempo"),
            what,
            "write time = \"beats\", or leave the tempo out",
        );
    }
    let follows = reader.word("clock") == 1;
    if follows && !beats {
        let what = format!("{} follows a MIDI clock but counts in seconds", reader.who);
        reader.sink.error_help(
            &reader.span_of("clock"),
            what,
            "write time = \"beats\", or leave the clock out",
        );
    }
    let events = match reader.at("events").map(|v| (v, v.text())) {
        Some((value, Some(path))) => {
            let path = options.path(path, &value.span(), &reader.who, reader.sink).unwrap_or_default();
            Events::File(path, value.span())
        }
        Some((value, None)) => {
            let mut events = Vec::new();
            for (i, value) in reader.list("events").into_iter().enumerate() {
                let who = format!("event {} of {}", i + 1, reader.who);
                match value.table() {
                    Some(entries) => {
                        let reader = Reader::new(&event::TABLE, entries, value.span(), who, reader.sink);
                        events.extend(event::read(&reader));
                    }
                    None => reader.mistaken("events", &value, "a list of tables { at, voice, ... }"),
                }
            }
            if value.list().is_some_and(|l| l.len() == 0) {
                reader.sink.error(&value.span(), format!("{} has no events", reader.who));
            }
            Events::Inline(events)
        }
        None => Events::Inline(Vec::new()),
    };
    let shuffle = reader.flag("shuffle");
    if shuffle && matches!(events, Events::File(..)) {
        let what = format!("{} shuffles a file of events, which is read as it plays", reader.who);
        reader.sink.error_help(
            &reader.span_of("shuffle"),
            what,
            "write the events into the patch, or leave out `shuffle`",
        );
    }
    let jitter = reader.one("jitter", format!("`jitter` of {}", reader.who)).map(|jitter| {
        let mut fractions = Vec::new();
        for key in ["level", "duration"] {
            if let Some(value) = jitter.number(key).filter(|v| *v > 0.0) {
                fractions.push(Setting { name: key.into(), value, span: jitter.span_of(key) });
            }
        }
        for (key, span, value) in jitter.others() {
            if let Some(value) = jitter.number_in(key, &value, 0.0, 1.0) {
                fractions.push(Setting { name: key.into(), value, span });
            }
        }
        Jitter { at: jitter.number_or_default("at"), fractions }
    });
    Pattern {
        name: name.into(),
        time: if beats { TimeBase::Beats(tempo) } else { TimeBase::Seconds },
        follows: follows && beats,
        events,
        repeat: reader.has("repeat").then(|| event::read_repeat(reader)).flatten(),
        gain: reader.number_or_default("gain"),
        rate: reader.number_or_default("rate"),
        shuffle,
        jitter,
        span: reader.span.clone(),
    }
}
