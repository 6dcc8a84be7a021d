//! Illusions of motion: bursts of one voice, of which one event is made.
//!
//! ```toml
//! { at = 0, voice = "buzz", stroke = { path = [[0, 0], [0.1, 0.05]], over = 1.0 } }
//! { at = 2, voice = "buzz", apparent = { places = ["wrist", "elbow"], burst = 0.1 } }
//! { at = 3, voice = "tap", saltation = { places = [[0, 0], [0.1, 0]], interval = 0.05 } }
//! ```
//!
//! A voice that declares the fields `since` and `burst` hears how many seconds after the event it begins, and how many bursts come before it: so its wave
//! can go on from one to the next.
//!
//! Each burst is the voice with all that the event says, at a place and for a time of its own. When they begin and how long they are
//! is what was measured on skin, in seconds at the tempo and the rate of their pattern; whatever plays that pattern faster or slower plays them
//! faster or slower, too.

use super::place::{self, Place};
use super::way::{self, Way};
use crate::space::apparent::{self, Apparent};
use crate::space::array::Array;
use crate::space::brush::{MEASURED, Stroke};
use crate::space::fault::Fault;
use crate::space::path::{Path, Timing};
use crate::space::saltation::{self, REPORTED, Saltation};
use crate::text::Span;
use crate::text::field::{Field, Form, Table};
use crate::text::reader::Reader;

/// The keys of an event that say one, in the order of [`Kind`].
pub const KEYS: [&str; 3] = ["stroke", "apparent", "saltation"];

/// A field that tells a voice which declares it how many seconds after its event a burst begins.
pub const SINCE: &str = "since";
/// A field that tells a voice which declares it how many bursts of its event come before this one.
pub const BURST: &str = "burst";

const PLACES: Field = Field::new(
    "places",
    Form::Defined("places"),
    "",
    "Where, one after another, two or more: names, channels, positions or lists of names.",
)
.required();

/// The keys of apparent motion.
pub static APPARENT: Table = Table {
    name: "apparent",
    doc: "Bursts at one place after another, felt as one that moves: from each to the next 0.32 of its duration and 47.3 ms.",
    fields: &[
        PLACES,
        Field::new(
            "burst",
            Form::any_number(apparent::DURATIONS.0, apparent::DURATIONS.1),
            "s",
            "How long each burst is; so long that all of them take the event's duration, where nothing is said.",
        ),
    ],
    others: None,
};

/// The keys of saltation.
pub static SALTATION: Table = Table {
    name: "saltation",
    doc: "The cutaneous rabbit: short taps, a few at each of some places, that seem to hop all the way.",
    fields: &[
        PLACES,
        Field::new(
            "taps",
            Form::count(saltation::TAPS as u64, 1, saltation::MOST_TAPS as u64),
            "",
            "Taps at each place.",
        ),
        Field::new(
            "interval",
            Form::number(saltation::INTERVAL, saltation::WIDEST.0, saltation::WIDEST.1),
            "s",
            "From tap to tap, also where the place changes.",
        ),
        Field::new(
            "tap",
            Form::number(saltation::TAP, saltation::SHORTEST, saltation::WIDEST.1),
            "s",
            "How long a tap is.",
        ),
    ],
    others: None,
};

/// An illusion of motion, as written.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Which, and how.
    pub kind: Kind,
    /// Where, one after another; of a stroke, the points of its path.
    pub places: Vec<Place>,
    /// Where it stands.
    pub span: Span,
}

/// Which illusion it is.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// Tactile Brush: a stroke along a path, in bursts that overlap between tactors.
    Stroke(Box<Way>),
    /// Bursts of so many seconds; `None`: so long that all of them take as long as the event.
    Apparent(Option<f64>),
    /// Taps at each place.
    Saltation {
        /// How many.
        taps: usize,
        /// From one to the next, s.
        interval: f64,
        /// How long each is, s.
        tap: f64,
    },
}

/// One burst.
#[derive(Debug, Clone, PartialEq)]
pub struct Burst {
    /// Where.
    pub place: Place,
    /// When it begins, in seconds from the event.
    pub start: f64,
    /// How long it is, s.
    pub seconds: f64,
}

/// What an illusion consists of.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bursts {
    /// In the order in which they begin.
    pub list: Vec<Burst>,
    /// What there is to know of it: what was measured otherwise, or left out.
    pub remarks: Vec<String>,
}

impl Motion {
    /// The key that says it.
    pub fn key(&self) -> &'static str {
        match self.kind {
            Kind::Stroke(_) => KEYS[0],
            Kind::Apparent(_) => KEYS[1],
            Kind::Saltation { .. } => KEYS[2],
        }
    }

    /// The key that says how long it takes, whatever its event says of that; `None` where it takes as long as that.
    pub fn lasts(&self) -> Option<&'static str> {
        match &self.kind {
            Kind::Stroke(way) if way.route().stretched => None,
            Kind::Stroke(way) if way.route().path.times().is_empty() => Some("`over`"),
            Kind::Stroke(_) => Some("`times`"),
            Kind::Apparent(burst) => burst.map(|_| "`burst`"),
            Kind::Saltation { .. } => Some("`interval`"),
        }
    }

    /// The longest that one of its bursts may be, s, for an event of some seconds.
    pub(super) fn longest(&self, seconds: f64) -> f64 {
        match &self.kind {
            Kind::Stroke(way) if way.route().stretched => seconds,
            Kind::Stroke(way) => way.route().path.seconds(),
            Kind::Apparent(Some(burst)) => *burst,
            Kind::Apparent(None) => {
                Apparent::lasting(self.places.len(), seconds).map_or(seconds, |motion| motion.duration())
            }
            Kind::Saltation { tap, .. } => *tap,
        }
    }

    /// Its bursts, for an event of some seconds, on an array.
    ///
    /// Where no array is known, a stroke is one burst as long as all of it, at the first point of its path.
    ///
    /// # Errors
    /// What is too fast, or takes too little time for so many places.
    pub fn bursts(&self, seconds: f64, array: Option<&Array>) -> Result<Bursts, Fault> {
        match &self.kind {
            Kind::Stroke(way) => {
                let route = way.route();
                let path =
                    if route.stretched { stretched(&route.path, seconds)? } else { route.path.clone() };
                let Some(array) = array else {
                    let place = Place::Position(path.point(0.0));
                    let list = vec![Burst { place, start: 0.0, seconds: path.seconds() }];
                    return Ok(Bursts { list, remarks: Vec::new() });
                };
                let stroke = Stroke::new(array, &path)?;
                let burst = |burst: &crate::space::brush::Burst| Burst {
                    place: Place::Position(burst.place),
                    start: burst.start,
                    seconds: burst.seconds(),
                };
                let list = stroke.bursts.iter().map(burst).collect();
                Ok(Bursts { list, remarks: remarks_of(&stroke, array.spacing()) })
            }
            Kind::Apparent(burst) => {
                let count = self.places.len();
                let motion = match burst {
                    Some(burst) => Apparent::new(count, *burst)?,
                    None => Apparent::lasting(count, seconds)?,
                };
                let seconds = motion.duration();
                let burst = |(place, start): (&Place, f64)| Burst { place: place.clone(), start, seconds };
                let list = self.places.iter().zip(motion.starts()).map(burst).collect();
                Ok(Bursts {
                    list,
                    remarks: unmeasured(count, count, (seconds, seconds)).into_iter().collect(),
                })
            }
            Kind::Saltation { taps, interval, tap } => {
                let hops = Saltation::with(self.places.len(), *taps, *interval, *tap)?;
                let burst = |(site, start): (usize, f64)| {
                    Some(Burst { place: self.places.get(site)?.clone(), start, seconds: hops.tap() })
                };
                let remark = format!(
                    "taps every {} ms: the rabbit was reported at {} to {} ms",
                    shown(*interval),
                    shown(REPORTED.0),
                    shown(REPORTED.1)
                );
                let remarks = if hops.reported() { Vec::new() } else { vec![remark] };
                Ok(Bursts { list: hops.taps().filter_map(burst).collect(), remarks })
            }
        }
    }
}

/// The same path within other seconds.
fn stretched(path: &Path, seconds: f64) -> Result<Path, Fault> {
    let timing = if path.is_smooth() { Timing::Smooth } else { Timing::Linear };
    Path::new(path.points(), seconds, timing)
}

fn remarks_of(stroke: &Stroke, spacing: f64) -> Vec<String> {
    let mut remarks = Vec::new();
    if !stroke.left_out.is_empty() {
        remarks.push(format!(
            "the stroke is too fast for {} of the {} points at which it passes between tactors: they are left out",
            stroke.left_out.len(),
            stroke.left_out.len() + stroke.bursts.len()
        ));
    }
    remarks.extend(unmeasured(stroke.unmeasured(), stroke.bursts.len(), stroke.range()));
    if stroke.outside > 0.5 * spacing {
        remarks.push(format!(
            "the stroke leaves the tactors by {:.3} m: what is outside is felt at the rim",
            stroke.outside
        ));
    }
    remarks
}

/// That bursts are shorter or longer than those for which the law of onsets is held to be measured; `so_many` of all, if any.
fn unmeasured(so_many: usize, of_all: usize, (least, most): (f64, f64)) -> Option<String> {
    let outside = least < MEASURED.0 || most > MEASURED.1;
    (so_many > 0 && outside).then(|| {
        let range = if shown(least) == shown(most) {
            shown(least)
        } else {
            format!("{} to {}", shown(least), shown(most))
        };
        format!(
            "{so_many} of {of_all} bursts {} outside what the law of onsets is told to be measured for, about {} to {} ms: here they are {range} ms",
            if so_many == 1 { "is" } else { "are" },
            shown(MEASURED.0),
            shown(MEASURED.1)
        )
    })
}

/// Seconds in milliseconds, to a tenth.
fn shown(seconds: f64) -> String {
    format!("{:.1}", 1e3 * seconds).trim_end_matches(".0").to_string()
}

/// Reads the one that an event says; what is wrong with it is said.
pub(super) fn read(reader: &Reader) -> Option<Motion> {
    let key = KEYS.into_iter().find(|key| reader.has(key))?;
    let span = reader.span_of(key);
    let who = format!("`{key}` of {}", reader.who);
    if key == KEYS[0] {
        let value = reader.at(key)?;
        let Some(table) = value.table() else {
            reader.mistaken(key, &value, "a path, { path = [[0, 0], [0.1, 0]], over = 1.0 }");
            return None;
        };
        let way = way::read(table, &value, reader)?;
        let places = way.route().path.points().iter().copied().map(Place::Position).collect();
        return Some(Motion { kind: Kind::Stroke(Box::new(way)), places, span });
    }
    let keys = reader.one(key, who)?;
    let kind = if key == KEYS[1] {
        Kind::Apparent(keys.number("burst"))
    } else {
        let taps = keys.count("taps").map_or(saltation::TAPS, |taps| taps as usize);
        Kind::Saltation {
            taps,
            interval: keys.number_or_default("interval"),
            tap: keys.number_or_default("tap"),
        }
    };
    let value = keys.at("places")?;
    let places: Option<Vec<Place>> =
        value.list().and_then(|list| list.map(|at| place::at_rest(&at)).collect());
    let Some(places) = places else {
        keys.wrong(
            "places",
            &value,
            "it must be a list of tactors' names, channels and positions, [\"left\", [0.1, 0]]",
        );
        return None;
    };
    let motion = Motion { kind, places, span };
    // What no array can mend is said where it stands; an event's duration is known later.
    let settled = match motion.kind {
        Kind::Stroke(_) => None,
        Kind::Apparent(burst) => Apparent::new(motion.places.len(), burst.unwrap_or(MEASURED.1)).err(),
        Kind::Saltation { taps, interval, tap } => {
            Saltation::with(motion.places.len(), taps, interval, tap).err()
        }
    };
    if let Some(fault) = settled {
        let span = if matches!(fault, Fault::FewPlaces(_)) { value.span() } else { motion.span };
        keys.sink.error(&span, format!("{}: {fault}", keys.who));
        return None;
    }
    Some(motion)
}

#[cfg(test)]
mod tests {
    use super::{Kind, Motion};
    use crate::patch::{Action, Events, Patch, Place};

    /// The illusion of an event, or what is wrong with it.
    fn motion(written: &str) -> Result<Motion, String> {
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"s\"\n[voice.v.nodes]\n\
             s = {{ type = \"sine\", frequency = 80 }}\n[pattern.p]\nevents = [{{ at = 0, voice = \"v\", {written} }}]\n"
        );
        let patch = Patch::parse("t.toml", text.as_bytes()).map_err(|p| p.to_string())?.value;
        let Events::Inline(events) = &patch.patterns[0].events else { return Err("a file".into()) };
        match &events[0].action {
            Action::Voice(play) => play.motion.as_deref().cloned().ok_or_else(String::new),
            _ => Err("no voice".into()),
        }
    }

    #[test]
    fn each_kind_is_read() {
        let stroke =
            motion("stroke = { path = [[0, 0], [0.1, 0.2]], over = 2.0, timing = \"smooth\" }").unwrap();
        assert!(
            matches!(&stroke.kind, Kind::Stroke(way) if !way.route().stretched && way.route().path.is_smooth())
        );
        assert_eq!(stroke.places, [[0.0; 3], [0.1, 0.2, 0.0]].map(Place::Position));
        assert_eq!((stroke.lasts(), stroke.key()), (Some("`over`"), "stroke"));
        let apparent =
            motion("duration = 1.0, apparent = { places = [\"a\", 2, [0, 0.1], [\"b\", \"c\"]] }").unwrap();
        assert_eq!(apparent.kind, Kind::Apparent(None));
        let named = |name: &str| name.to_string();
        let places = [
            Place::Name("a".into()),
            Place::Channel(2),
            Place::Position([0.0, 0.1, 0.0]),
            Place::Names(vec![named("b"), named("c")]),
        ];
        assert_eq!(apparent.places, places);
        let rabbit = motion("saltation = { places = [1, 2, 3] }").unwrap();
        assert_eq!(rabbit.kind, Kind::Saltation { taps: 5, interval: 0.05, tap: 0.002 });
    }

    #[test]
    fn what_is_none_is_said_at_its_line() {
        for (written, wanted) in [
            ("stroke = [[0, 0], [1, 1]]", "stroke"),
            ("stroke = { path = [[0, 0]] }", "two"),
            ("stroke = { path = [[0, 0], [0, 0]] }", "lies at"),
            ("stroke = { path = [[0, 0], [nan, 0]] }", "points"),
            ("stroke = { path = [[0, 0], [1, 0]], over = 0 }", "0.001"),
            ("stroke = { path = [[0, 0], [1, 0]], over = 1 }, duration = 2", "leave `duration` out: `over`"),
            (
                "stroke = { path = [[0, 0], [1, 0]], times = [0, 1] }, duration = 2",
                "leave `duration` out: `times`",
            ),
            ("stroke = { path = [[0, 0], [1, 0]] }, place = 1", "leave `place` out"),
            ("stroke = { path = [[0, 0], [1, 0]] }, saltation = { places = [1, 2] }", "an event of each"),
            ("apparent = { places = [1] }", "two"),
            ("apparent = { places = [] }", "two"),
            ("apparent = { places = \"a\" }", "a list of tactors"),
            ("apparent = { places = [1, { path = [[0, 0], [1, 1]] }] }", "a list of tactors"),
            ("apparent = { places = [1, 0] }", "a list of tactors"),
            ("apparent = { burst = 0.1 }", "places"),
            ("apparent = { places = [1, 2], burst = 0 }", "burst"),
            ("apparent = { places = [1, 2], burst = inf }", "burst"),
            ("apparent = { places = [1, 2], brust = 0.1 }", "burst"),
            ("saltation = { places = [1, 2], taps = 0 }", "taps"),
            ("saltation = { places = [1, 2], interval = 1.0 }", "interval"),
            ("saltation = { places = [1, 2], interval = 0.05, tap = 0.06 }", "tap"),
            ("saltation = { places = [1, 2] }, duration = 1", "leave `duration` out: `interval`"),
            ("saltation = 3", "saltation"),
            (
                &format!("saltation = {{ places = [{}], taps = 100 }}", "1, 2, ".repeat(21)),
                "one event of 4200 bursts: it may have 4096",
            ),
            (&format!("apparent = {{ places = [{}] }}", "1, 2, ".repeat(2049)), "4098 bursts"),
            ("stroke = { path = [[0, 0], [1, 0]], times = [0, 1e7] }", "time 2 of `times` is 10000000.0 s"),
            ("stroke = { path = [[0, 0], [1, 0]], times = [0, 5e-324] }", "5e-324"),
            ("stroke = { path = [[0, 0], [1, 0]], times = [3, 3.0009] }", "0.001 s"),
            ("strok = { path = [[0, 0], [1, 0]] }", "stroke"),
        ] {
            let said = motion(written).unwrap_err();
            assert!(said.contains("t.toml:8:") && said.contains(wanted), "{written}: {said}");
        }
        let said = |action: &str| {
            let text = format!(
                "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[pattern.p]\nevents = [{{ at = 0, {action}, stroke = {{ path = [[0, 0], [1, 0]] }} }}]\n"
            );
            Patch::parse("t.toml", text.as_bytes()).unwrap_err().to_string()
        };
        assert!(said("marker = \"m\"").contains("a marker has no `stroke`"));
        assert!(said("choose = [{ marker = \"m\" }]").contains("a choice has no `stroke`"));
    }

    #[test]
    fn what_was_measured_otherwise_is_remarked() {
        let remarks = |written: &str| motion(written).unwrap().bursts(1.0, None).unwrap().remarks;
        assert_eq!(remarks("apparent = { places = [1, 2], burst = 0.2 }"), Vec::<String>::new());
        let long = remarks("apparent = { places = [1, 2], burst = 0.5 }");
        assert!(
            long.len() == 1 && long[0].contains("2 of 2 bursts") && long[0].contains("500 ms"),
            "{long:?}"
        );
        assert_eq!(remarks("saltation = { places = [1, 2] }"), Vec::<String>::new());
        let slow = remarks("saltation = { places = [1, 2], interval = 0.2 }");
        assert!(
            slow.len() == 1 && slow[0].contains("every 200 ms") && slow[0].contains("40 to 80 ms"),
            "{slow:?}"
        );
    }
}
