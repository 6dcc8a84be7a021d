//! A line of a journal: something that came in, or that was done, or how things stood.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use serde::{Deserialize, Serialize};

use super::kind::Kind;

/// A line. What does not apply to its kind is `None`, which is an empty cell of a table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Line {
    /// What it tells of.
    pub kind: Kind,
    /// Frames that had been given out before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<u64>,
    /// Where an event comes from: `pattern` or `program`, `stop` for the stop of a pattern, or `node` for a voice that a node has set off, which a replay sets off anew; what came in: `midi`, `osc`, `key` or `program`, and `knob` or `node` for what starts a pattern by itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<String>,
    /// The id of a voice, by which it is released and its random numbers are drawn; of what came in, its number within the session.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub id: Option<u64>,
    /// Of the voice, the kind of touch, the control, the marker, of what the gate was told, of where something came in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The output on which a voice sounds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// What that means: `CHANNEL=GAIN`, with semicolons between. Channels count from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gains: Option<String>,
    /// 1 for a full voice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub level: Option<f64>,
    /// Decibels above the threshold that a level of 1 is felt like, where that was said.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub felt: Option<f64>,
    /// Seconds until the release of a voice, `None` for one that is held; seconds in which a control goes there, `None` for its own.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub duration: Option<f64>,
    /// The voice's own fields, or counters.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub fields: BTreeMap<String, f64>,
    /// Where a touch or a control goes, the gate's gain, how many lines are missing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub value: Option<f64>,
    /// When an event takes effect: the engine's sample, and the fraction of one behind it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sample: Option<u64>,
    /// See there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fraction: Option<f64>,
    /// When it was due; the same, but for one that came too late.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub due_sample: Option<u64>,
    /// See there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub due_fraction: Option<f64>,
    /// Seconds since the session began, on a clock that never goes back: of an event, when its middle at 250 Hz leaves the converter,
    /// as estimated from the callbacks and what the device says of its delay; of all else, when it came or was noticed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub seconds: Option<f64>,
    /// The same as a date, RFC 3339.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub utc: Option<String>,
    /// The pattern an event is from.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pattern: Option<String>,
    /// Of an event, the `id` of what came in and asked for it, or for the pattern that it is from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cause: Option<u64>,
    /// Of what came in, from whom: the name of the MIDI port, the address of the sender of OSC.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub peer: Option<String>,
    /// Which of its events, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub event: Option<u64>,
    /// Which alternative of a `choose` was drawn, from 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub drawn: Option<u64>,
    /// What came in: the bytes of a MIDI message in hexadecimal, the arguments of an OSC message; words of the device; why something was
    /// refused; at the end, the digest of what was heard.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
}

/// Names of the columns of a table.
pub const COLUMNS: [&str; 24] = [
    "kind",
    "frame",
    "source",
    "id",
    "name",
    "place",
    "gains",
    "level",
    "felt",
    "duration",
    "fields",
    "value",
    "sample",
    "fraction",
    "due_sample",
    "due_fraction",
    "seconds",
    "utc",
    "pattern",
    "event",
    "drawn",
    "message",
    "cause",
    "peer",
];

impl Line {
    /// With nothing but its kind.
    pub fn new(kind: Kind) -> Self {
        Self {
            kind,
            frame: None,
            source: None,
            id: None,
            name: None,
            place: None,
            gains: None,
            level: None,
            felt: None,
            duration: None,
            fields: BTreeMap::new(),
            value: None,
            sample: None,
            fraction: None,
            due_sample: None,
            due_fraction: None,
            seconds: None,
            utc: None,
            cause: None,
            peer: None,
            pattern: None,
            event: None,
            drawn: None,
            message: None,
        }
    }

    /// The cells of a table, in the order of [`COLUMNS`]. Control characters, which would break its lines, are spaces.
    pub fn cells(&self) -> [String; 24] {
        fn number<T: ToString>(value: Option<T>) -> String {
            value.map(|value| value.to_string()).unwrap_or_default()
        }
        fn text(value: Option<&String>) -> String {
            value.map(|text| text.replace(char::is_control, " ")).unwrap_or_default()
        }
        let mut fields = String::new();
        for (name, value) in &self.fields {
            let between = if fields.is_empty() { "" } else { ";" };
            // A string takes whatever it is given.
            let _ = write!(fields, "{between}{}={value}", name.replace(char::is_control, " "));
        }
        [
            self.kind.word().into(),
            number(self.frame),
            text(self.source.as_ref()),
            number(self.id),
            text(self.name.as_ref()),
            text(self.place.as_ref()),
            text(self.gains.as_ref()),
            number(self.level),
            number(self.felt),
            number(self.duration),
            fields,
            number(self.value),
            number(self.sample),
            number(self.fraction),
            number(self.due_sample),
            number(self.due_fraction),
            number(self.seconds),
            text(self.utc.as_ref()),
            text(self.pattern.as_ref()),
            number(self.event),
            number(self.drawn),
            text(self.message.as_ref()),
            number(self.cause),
            text(self.peer.as_ref()),
        ]
    }

    /// A line from the cells of a table: `cell` gives that of a column.
    ///
    /// # Errors
    /// A cell that says something else than its column may.
    pub fn of_cells<'a>(cell: impl Fn(&str) -> Option<&'a str>) -> Result<Self, String> {
        let filled = |column: &str| cell(column).filter(|cell| !cell.is_empty());
        fn number<T: std::str::FromStr>(column: &str, cell: Option<&str>) -> Result<Option<T>, String> {
            cell.map(|cell| {
                cell.parse().map_err(|_| format!("`{column}` says `{cell}`, which is no number of its kind"))
            })
            .transpose()
        }
        let whole = |column: &str| number::<u64>(column, filled(column));
        let real = |column: &str| number::<f64>(column, filled(column));
        let text = |column: &str| filled(column).map(String::from);
        let word = filled("kind").unwrap_or_default();
        let kind = Kind::ALL.into_iter().find(|kind| kind.word() == word);
        let kind = kind.ok_or_else(|| format!("there is no kind of line called `{word}`"))?;
        let mut fields = BTreeMap::new();
        for field in filled("fields").into_iter().flat_map(|cell| cell.split(';')) {
            let (name, value) =
                field.split_once('=').ok_or_else(|| format!("the field `{field}` has no value"))?;
            let value =
                value.parse().map_err(|_| format!("the field `{name}` is `{value}`, which is no number"))?;
            fields.insert(name.to_string(), value);
        }
        Ok(Self {
            kind,
            frame: whole("frame")?,
            source: text("source"),
            id: whole("id")?,
            name: text("name"),
            place: text("place"),
            gains: text("gains"),
            level: real("level")?,
            felt: real("felt")?,
            duration: real("duration")?,
            fields,
            value: real("value")?,
            sample: whole("sample")?,
            fraction: real("fraction")?,
            due_sample: whole("due_sample")?,
            due_fraction: real("due_fraction")?,
            seconds: real("seconds")?,
            utc: text("utc"),
            pattern: text("pattern"),
            event: whole("event")?,
            drawn: whole("drawn")?,
            message: text("message"),
            cause: whole("cause")?,
            peer: text("peer"),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use proptest::prelude::{Just, Strategy, any, prop, prop_assert_eq, proptest};

    use super::{COLUMNS, Kind, Line};

    fn numbers() -> impl Strategy<Value = Option<f64>> {
        let finite = prop::num::f64::NORMAL | prop::num::f64::SUBNORMAL | prop::num::f64::ZERO;
        prop::option::of(finite)
    }

    fn lines() -> impl Strategy<Value = Line> {
        let words = || prop::option::of("[a-z,\";= äß]{1,8}".prop_map(|word| word.trim().to_string()));
        let fields = prop::collection::btree_map("[a-z]{1,5}", prop::num::f64::NORMAL, 0..4);
        (
            prop::sample::select(Kind::ALL.to_vec()),
            (any::<Option<u64>>(), any::<Option<u64>>(), any::<Option<u64>>()),
            (words(), words(), words()),
            (numbers(), numbers(), numbers(), numbers()),
            fields,
            Just(()),
        )
            .prop_map(
                |(
                    kind,
                    (frame, id, sample),
                    (name, place, message),
                    (level, duration, value, fraction),
                    fields,
                    (),
                )| {
                    let word = |word: Option<String>| word.filter(|word| !word.is_empty());
                    let (name, place, message) = (word(name), word(place), word(message));
                    Line {
                        frame,
                        id,
                        name,
                        place,
                        level,
                        duration,
                        fields,
                        value,
                        sample,
                        fraction,
                        message,
                        ..Line::new(kind)
                    }
                },
            )
    }

    proptest! {
        /// Both forms give every line back to the bit.
        #[test]
        fn what_is_written_is_read(line in lines()) {
            let json = serde_json::to_string(&line).unwrap();
            prop_assert_eq!(&serde_json::from_str::<Line>(&json).unwrap(), &line);
            let cells = line.cells();
            let cell = |column: &str| COLUMNS.iter().position(|c| *c == column).map(|at| cells[at].as_str());
            prop_assert_eq!(Line::of_cells(cell).unwrap(), line);
        }
    }

    #[test]
    fn cells_that_say_something_else_are_refused() {
        let of = |cells: &[(&str, &'static str)]| {
            let cells: BTreeMap<String, &'static str> =
                cells.iter().map(|(c, t)| (c.to_string(), *t)).collect();
            Line::of_cells(|column| cells.get(column).copied()).unwrap_err()
        };
        assert_eq!(of(&[]), "there is no kind of line called ``");
        assert_eq!(
            of(&[("kind", "voice"), ("frame", "-1")]),
            "`frame` says `-1`, which is no number of its kind"
        );
        assert_eq!(of(&[("kind", "voice"), ("fields", "a=b")]), "the field `a` is `b`, which is no number");
        assert_eq!(of(&[("kind", "voice"), ("fields", "a")]), "the field `a` has no value");
    }
}
