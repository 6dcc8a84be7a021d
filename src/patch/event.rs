//! An event: something that happens at a time in a pattern. It has exactly one of `voice`, `pattern`, `marker` and `choose`;
//! [`super::pattern`] says when it sounds and what is drawn.
//!
//! ```toml
//! { at = 0.0, voice = "beat", level = 0.6, duration = 0.1, place = "top", frequency = 50 }
//! { at = 1.0, voice = "beat", delay = 0.02, repeat = { times = 4, every = 0.25 } }
//! { at = 1.5, voice = "beat", felt = 20 }
//! { at = 2.0, pattern = "walk", gain = 0.5, rate = 2.0 }
//! { at = 3.0, marker = "trial 1" }
//! { at = 3.5, voice = "beat", stroke = { path = [[0, 0], [0.1, 0]], over = 1.0 } }
//! { at = 4.0, choose = [{ voice = "beat", weight = 3 }, { pattern = "walk" }] }
//! ```

use super::motion::{self, KEYS, Motion};
use super::place::{self, Place};
use crate::text::field::{Field, Form, Table};
use crate::text::nearest::{did_you_mean, suggest};
use crate::text::reader::Reader;
use crate::text::{Problem, Span};

/// An event.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// When, in the pattern's time.
    pub at: f64,
    /// Added to `at`; apart from it so that a shuffle moves `at` alone.
    pub delay: f64,
    /// Played several times.
    pub repeat: Option<Repeat>,
    /// What happens.
    pub action: Action,
    /// Where it stands; in an events file, the line's bytes.
    pub span: Span,
}

/// Several times at equal spacing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repeat {
    /// From one onset to the next, in the pattern's time; above 0.
    pub every: f64,
    /// How often in all, at least 1; `None`: for ever, which only a pattern may say that no other plays.
    pub times: Option<u64>,
}

/// What happens in an event.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// A voice sounds.
    Voice(Play),
    /// Another pattern plays.
    Pattern {
        /// Its name.
        pattern: String,
        /// Where that stands.
        span: Span,
        /// Multiplies the level of all it plays.
        gain: f64,
        /// 2 is twice as fast, durations included.
        rate: f64,
    },
    /// A name goes into the log, and a pulse to trigger outputs.
    Marker(String),
    /// One of several, drawn anew each time.
    Choose(Vec<Alternative>),
}

impl Action {
    /// It, or where it is a choice all that may be drawn.
    pub fn each(&self) -> impl Iterator<Item = &Self> {
        let (one, several) = match self {
            Self::Choose(list) => (None, list.as_slice()),
            action => (Some(action), &[][..]),
        };
        one.into_iter().chain(several.iter().map(|alternative| &alternative.action))
    }
}

/// A voice sounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Play {
    /// Name of the voice.
    pub voice: String,
    /// Where that stands.
    pub span: Span,
    /// Share of the rated vibration; `None`: the voice's default.
    pub level: Option<f64>,
    /// In place of a level: decibels above the threshold, on every tactor; `None`: nothing is said.
    pub felt: Option<Setting>,
    /// From onset to release, in the pattern's time; `None`: the voice's default.
    pub duration: Option<f64>,
    /// Where; `None`: the voice's place.
    pub place: Option<Place>,
    /// Where that stands; the event's place where there is none.
    pub place_span: Span,
    /// Several bursts of it instead, at places of their own.
    pub motion: Option<Box<Motion>>,
    /// Fields that the voice declares, where the event gives them.
    pub fields: Vec<Setting>,
}

impl Play {
    /// Every place that it names, with where it stands.
    pub fn places(&self) -> impl Iterator<Item = (&Place, &Span)> {
        let bursts =
            self.motion.iter().flat_map(|motion| motion.places.iter().map(|place| (place, &motion.span)));
        self.place.iter().map(|place| (place, &self.place_span)).chain(bursts)
    }
}

/// A field set to a number.
#[derive(Debug, Clone, PartialEq)]
pub struct Setting {
    /// The field.
    pub name: String,
    /// What it is set to.
    pub value: f64,
    /// Where it stands.
    pub span: Span,
}

/// One of several things that may happen.
#[derive(Debug, Clone, PartialEq)]
pub struct Alternative {
    /// It is drawn with probability weight / sum of the weights.
    pub weight: f64,
    /// What happens; never another choice.
    pub action: Action,
}

/// Keys of an event, which no field of a voice can be called.
pub const RESERVED: &[&str] = &[
    "at",
    "voice",
    "pattern",
    "marker",
    "choose",
    "weight",
    "level",
    "felt",
    "duration",
    "place",
    "delay",
    "repeat",
    "gain",
    "rate",
    "stroke",
    "apparent",
    "saltation",
];

const VOICE: Field = Field::new("voice", Form::Text, "", "The voice that sounds.");
const PATTERN: Field = Field::new("pattern", Form::Text, "", "The pattern that plays.");
const MARKER: Field =
    Field::new("marker", Form::Text, "", "A name for the log, and a pulse for trigger outputs.");
const LEVEL: Field = Field::new(
    "level",
    Form::any_number(LEVELS[0], LEVELS[1]),
    "",
    "Share of the actuator's rated vibration. The voice's default, else 1.",
);
const FELT: Field = Field::new(
    "felt",
    Form::any_number(LEAST_FELT, MOST_FELT),
    "dB",
    "In place of a level: so far above the threshold, on every tactor by its calibration.",
);
const DURATION: Field = Field::new(
    "duration",
    Form::any_number(DURATIONS[0], DURATIONS[1]),
    "s or beats",
    "From onset to release. The voice's default, else 0.1 s.",
);
const PLACE: Field =
    Field::new("place", Form::Defined("place"), "", "Where; the voice's place where nothing is said.");
const STROKE: Field = Field::new(
    "stroke",
    Form::One(&super::way::TABLE),
    "",
    "A stroke along a path, in bursts that overlap where it passes between tactors (Tactile Brush).",
);
const APPARENT_MOTION: Field = Field::new(
    "apparent",
    Form::One(&motion::APPARENT),
    "",
    "Bursts at places one after another, felt as one that moves.",
);
const SALTATION: Field = Field::new(
    "saltation",
    Form::One(&motion::SALTATION),
    "",
    "The cutaneous rabbit: taps that hop from place to place.",
);
const FREQUENCY: Field = Field::new(
    "frequency",
    Form::any_number(VALUES[0], VALUES[1]),
    "Hz",
    "What nodes read as event.frequency. The voice's default, else 250 Hz.",
);
const GAIN: Field = Field::new(
    "gain",
    Form::number(1.0, 0.0, 100.0),
    "",
    "Multiplies the level of all that the pattern plays.",
);
const RATE: Field = Field::new(
    "rate",
    Form::number(1.0, 1e-3, 1e3),
    "",
    "2 plays the pattern twice as fast, durations included.",
);
const OWN: Field =
    Field::new("", Form::any_number(VALUES[0], VALUES[1]), "", "A field that the voice declares.");

/// The least and the most that `felt` may say, dB.
pub const LEAST_FELT: f64 = -60.0;
/// See there.
pub const MOST_FELT: f64 = 120.0;
/// The least and the most that `level` may say.
const LEVELS: [f64; 2] = [0.0, 100.0];
/// The least and the most that `duration` may say, seconds or beats.
const DURATIONS: [f64; 2] = [0.0, 1e6];
/// The least and the most that a field of a voice's own may say.
const VALUES: [f64; 2] = [-1e9, 1e9];

/// The least and the most that an event may say of `level`, `felt`, `duration` or a field of its voice's own.
pub fn limits(field: &str) -> [f64; 2] {
    match field {
        "level" => LEVELS,
        "felt" => [LEAST_FELT, MOST_FELT],
        "duration" => DURATIONS,
        _ => VALUES,
    }
}

/// Its keys.
pub static TABLE: Table = Table {
    name: "event",
    doc: "Something that happens: a voice, another pattern, a marker, or a choice among them.",
    fields: &[
        Field::new("at", Form::any_number(0.0, 1e9), "s or beats", "When.").required(),
        Field::new(
            "delay",
            Form::number(0.0, 0.0, 1e9),
            "s or beats",
            "Added to `at`; a shuffle moves it along with the event.",
        ),
        Field::new("repeat", Form::One(&REPEAT), "", "Several times at equal spacing."),
        VOICE,
        PATTERN,
        MARKER,
        Field::new("choose", Form::Many(&ALTERNATIVE), "", "One of these, drawn anew each time."),
        LEVEL,
        FELT,
        DURATION,
        PLACE,
        STROKE,
        APPARENT_MOTION,
        SALTATION,
        FREQUENCY,
        GAIN,
        RATE,
    ],
    others: Some(&OWN),
};

/// The keys of one of several things that may happen.
pub static ALTERNATIVE: Table = Table {
    name: "alternative",
    doc: "One of several things that may happen.",
    fields: &[
        Field::new(
            "weight",
            Form::number(1.0, 1e-9, 1e9),
            "",
            "It is drawn with probability weight / sum of the weights.",
        ),
        VOICE,
        PATTERN,
        MARKER,
        LEVEL,
        FELT,
        DURATION,
        PLACE,
        STROKE,
        APPARENT_MOTION,
        SALTATION,
        FREQUENCY,
        GAIN,
        RATE,
    ],
    others: Some(&OWN),
};

/// The keys of a repetition.
pub static REPEAT: Table = Table {
    name: "repeat",
    doc: "Several times at equal spacing.",
    fields: &[
        Field::new("every", Form::any_number(1e-6, 1e9), "s or beats", "From one onset to the next.")
            .required(),
        Field::new(
            "times",
            Form::any_count(1, 1_000_000_000),
            "",
            "How often in all; a pattern without it repeats for ever.",
        ),
    ],
    others: None,
};

pub(crate) fn read(reader: &Reader) -> Option<Event> {
    let at = reader.number("at");
    let delay = reader.number("delay");
    let repeat = reader.has("repeat").then(|| read_repeat(reader));
    if let Some(Some(Repeat { times: None, .. })) = repeat {
        let what = format!("`repeat` of {} lacks `times`", reader.who);
        reader.sink.error_help(&reader.span_of("repeat"), what, "only a pattern may repeat for ever");
    }
    let action = if reader.has("choose") {
        let who = |n: usize| format!("alternative {n} of {}", reader.who);
        refuse(reader, &["choose"], &["voice", "pattern", "marker"], "a choice");
        refuse(reader, &["choose"], &[&SOUNDS[..], &KEYS, &["gain", "rate"]].concat(), "a choice");
        for (word, span, _) in reader.others() {
            unknown(reader, word, &span);
        }
        let readers = reader.many("choose", who);
        if readers.is_empty() && reader.at("choose").is_some_and(|v| v.list().is_some_and(|l| l.len() == 0)) {
            reader
                .sink
                .error(&reader.span_of("choose"), format!("`choose` of {} has no alternatives", reader.who));
        }
        // Whatever is wrong with one, the others are read as well.
        let alternative =
            |r: &Reader| Some(Alternative { weight: r.number_or_default("weight"), action: read_action(r)? });
        Some(Action::Choose(readers.iter().filter_map(alternative).collect()))
    } else {
        read_action(reader)
    };
    // What is missing or wrong has been reported; the rest is read on, for what else there is to say.
    Some(Event {
        at: at.unwrap_or(0.0),
        delay: delay.unwrap_or(0.0),
        repeat: repeat.flatten(),
        action: action?,
        span: reader.span.clone(),
    })
}

/// What an event has where its marker cannot be called so, and what to do.
pub(super) fn misnamed(marker: &str) -> Option<(&'static str, &'static str)> {
    let help = "give it a name of letters, numbers, signs and spaces: logs and other programs read it";
    marker.contains(char::is_control).then_some(("a control character in its marker", help))
}

fn read_action(reader: &Reader) -> Option<Action> {
    let named: Vec<&str> = ["voice", "pattern", "marker"].into_iter().filter(|k| reader.has(k)).collect();
    let kind = match named.as_slice() {
        [kind] => *kind,
        [] => {
            let others: Vec<_> = reader.others();
            let near = others.iter().find_map(|(k, ..)| {
                crate::text::nearest::nearest(k, ["voice", "pattern", "marker"]).map(|n| (k, n))
            });
            let help = match near {
                Some((key, name)) => format!("did you mean `{name}` instead of `{key}`?"),
                None => {
                    let choose = if reader.describes("choose") { ", or choose = [{ ... }]" } else { "" };
                    format!(
                        "say what happens: voice = \"...\", pattern = \"...\" or marker = \"...\"{choose}"
                    )
                }
            };
            reader.sink.error_help(&reader.span, format!("{} has no voice", reader.who), &help);
            // Other keys may be fields of whatever voice was meant, unless they are hardly anything but a slip.
            let meant = near.map(|(key, _)| *key);
            for (word, span, _) in &others {
                if Some(*word) != meant && did_you_mean(word, TABLE.keys()).is_some() {
                    unknown(reader, word, span);
                }
            }
            return None;
        }
        several => {
            let what = format!("{} has {} at once", reader.who, crate::text::nearest::listed(several));
            reader.sink.error_help(&reader.span_of(several[1]), what, "make two events of it");
            return None;
        }
    };
    if kind != "voice" {
        refuse(reader, &[kind], &[&SOUNDS[..], &KEYS].concat(), &format!("a {kind}"));
        for (word, span, _) in reader.others() {
            unknown(reader, word, &span);
        }
    }
    if kind != "pattern" {
        refuse(reader, &[kind], &["gain", "rate"], &format!("a {kind}"));
    }
    let name = reader.text(kind)?.to_string();
    let span = reader.span_of(kind);
    if let Some((what, help)) = misnamed(&name).filter(|_| kind == "marker") {
        reader.sink.error_help(&span, format!("{} has {what}", reader.who), help);
    }
    match kind {
        "voice" => {
            let (level, duration, place) =
                (reader.number("level"), reader.number("duration"), place::read(reader, "place"));
            let (motion, is_well) = read_motion(reader);
            let felt = reader.number("felt").map(|value| setting(reader, "felt", value));
            let mut fields = Vec::new();
            if let Some(value) = reader.number("frequency") {
                fields.push(setting(reader, "frequency", value));
            }
            for (word, span, value) in reader.others() {
                // A word or a list near a key of the event is that key, mistyped; all else may be a field, which is a number
                // and is checked later.
                if value.number().is_none() && did_you_mean(word, TABLE.keys()).is_some() {
                    unknown(reader, word, &span);
                } else {
                    let value = reader.number_in(word, &value, -1e9, 1e9);
                    fields.extend(value.map(|value| Setting { name: word.into(), value, span }));
                }
            }
            let place_span = reader.span_of("place");
            let play = Play { voice: name, span, place_span, level, felt, duration, place, motion, fields };
            is_well.then_some(Action::Voice(play))
        }
        "pattern" => Some(Action::Pattern {
            pattern: name,
            span,
            gain: reader.number_or_default("gain"),
            rate: reader.number_or_default("rate"),
        }),
        _ => Some(Action::Marker(name)),
    }
}

/// What an event of a voice says of how it sounds.
const SOUNDS: [&str; 5] = ["level", "felt", "duration", "place", "frequency"];

/// The illusion of motion that an event says, and whether all is well with it.
fn read_motion(reader: &Reader) -> (Option<Box<Motion>>, bool) {
    let said: Vec<&str> = KEYS.into_iter().filter(|key| reader.has(key)).collect();
    let Some(key) = said.first() else { return (None, true) };
    if let Some(other) = said.get(1) {
        let what = format!("{} has {} at once", reader.who, crate::text::nearest::listed(&said));
        reader.sink.error_help(&reader.span_of(other), what, "make an event of each");
        return (None, false);
    }
    if reader.has("place") {
        let what = format!("{} has both `place` and `{key}`", reader.who);
        let help = "leave `place` out: each burst has a place of its own";
        reader.sink.error_help(&reader.span_of("place"), what, help);
    }
    let Some(motion) = motion::read(reader) else { return (None, false) };
    if reader.has("duration")
        && let Some(because) = motion.lasts()
    {
        let what = format!("{} has both `duration` and `{key}` with {because}", reader.who);
        let help = format!("leave `duration` out: {because} says how long it takes");
        reader.sink.error_help(&reader.span_of("duration"), what, &help);
    }
    (Some(Box::new(motion)), true)
}

fn setting(reader: &Reader, key: &str, value: f64) -> Setting {
    Setting { name: key.into(), value, span: reader.span_of(key) }
}

/// Reads `repeat`.
pub(crate) fn read_repeat(reader: &Reader) -> Option<Repeat> {
    let inner = reader.one("repeat", format!("`repeat` of {}", reader.who))?;
    let times = inner.count("times");
    if inner.has("times") && times.is_none() {
        return None;
    }
    Some(Repeat { every: inner.number("every")?, times })
}

fn refuse(reader: &Reader, because: &[&str], keys: &[&str], what: &str) {
    for key in keys.iter().filter(|k| reader.has(k) && !because.contains(k)) {
        let help = match *key {
            _ if what == "a choice" => Some("give it to the alternatives".to_string()),
            "level" if what == "a pattern" => Some("did you mean `gain`?".to_string()),
            _ => None,
        };
        let problem = Problem::error(&reader.span_of(key), format!("{}: {what} has no `{key}`", reader.who));
        reader.sink.push(problem.help(help));
    }
}

fn unknown(reader: &Reader, word: &str, span: &Span) {
    let problem = Problem::error(span, format!("{} has no key `{word}`", reader.who));
    reader.sink.push(problem.help(suggest(word, TABLE.keys())));
}
