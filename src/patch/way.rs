//! A path in a patch: points, and how long it takes to go along them.

use super::place::position_of;
use crate::space::path::{Path, Route, Timing};
use crate::text::field::{Field, Form, Table};
use crate::text::reader::{At, Reader};
use toml::de::DeTable;

/// The words of the time laws, the usual one first.
const TIMINGS: [&str; 2] = ["linear", "smooth"];

/// Seconds that a path takes, at least and at most.
const LASTS: (f64, f64) = (1e-3, 1e6);

/// Its keys.
pub static TABLE: Table = Table {
    name: "path",
    doc: "A path that a voice goes along.",
    fields: &[
        Field::new(
            "path",
            Form::Defined("points"),
            "m",
            "Its points, two or more: [[x, y], ...] or [[x, y, z], ...].",
        )
        .required(),
        Field::new(
            "over",
            Form::any_number(LASTS.0, LASTS.1),
            "s",
            "How long it takes; as long as the event, from onset to release, where nothing is said.",
        ),
        Field::new(
            "timing",
            Form::Word(&TIMINGS),
            "",
            "At one speed, or from rest to rest: of the time x it has then gone 3x² − 2x³ of the way.",
        ),
        Field::new(
            "times",
            Form::Defined("times"),
            "s",
            "Instead of both: when it is at each point, rising; two points at one place are a rest.",
        ),
    ],
    others: None,
};

/// A path, as written: `{ path = [[0, 0], [0.1, 0]], over = 0.5 }`.
#[derive(Debug, Clone, PartialEq)]
pub struct Way {
    route: Route,
}

impl Way {
    /// Through points (m) within some seconds, or within the event's duration where those are not said.
    ///
    /// # Errors
    /// As [`Path::new`].
    pub fn new(
        points: &[[f64; 3]],
        over: Option<f64>,
        timing: Timing,
    ) -> Result<Self, crate::space::fault::Fault> {
        let stretched = over.is_none() && !matches!(timing, Timing::At(_));
        Ok(Self { route: Route { path: Path::new(points, over.unwrap_or(1.0), timing)?, stretched } })
    }

    /// What is gone along.
    pub fn route(&self) -> &Route {
        &self.route
    }
}

/// Reads a path; what is wrong with it is said.
pub(super) fn read(table: &DeTable, at: &At, reader: &Reader) -> Option<Way> {
    let of = format!("the path of {}", reader.who);
    let keys = Reader::new(&TABLE, table, at.span(), of, reader.sink);
    let value = keys.at("path")?;
    let points: Option<Vec<[f64; 3]>> =
        value.list().and_then(|list| list.map(|at| position_of(&at)).collect());
    let Some(points) = points else {
        keys.wrong(
            "path",
            &value,
            "it must be points [[x, y], ...] or [[x, y, z], ...] in metres, none farther than 1000 m from 0",
        );
        return None;
    };
    let over = keys.number("over");
    let smooth = keys.word("timing") == 1;
    let times = match keys.at("times") {
        None => None,
        Some(value) => {
            let times: Option<Vec<f64>> = value.list().and_then(|list| list.map(|x| x.number()).collect());
            if times.is_none() {
                keys.wrong("times", &value, "it must be a list of seconds, one for each point");
                return None;
            }
            let bad = times.iter().flatten().enumerate().find(|(_, time)| !(0.0..=LASTS.1).contains(*time));
            if let Some((n, time)) = bad {
                let what =
                    format!("time {} of `times` is {time:?} s, but must be within 0 and {}", n + 1, LASTS.1);
                keys.sink.error(&value.span(), format!("{}: {what}", keys.who));
                return None;
            }
            if let Some([first, .., last]) = times.as_deref()
                && last > first
                && last - first < LASTS.0
            {
                let what =
                    format!("it is gone along within {:?} s, and takes {} s at least", last - first, LASTS.0);
                keys.sink.error(&value.span(), format!("{}: {what}", keys.who));
                return None;
            }
            if let Some(other) = ["over", "timing"].into_iter().find(|key| keys.has(key)) {
                let what = format!("{} has both `times` and `{other}`", keys.who);
                keys.sink.error_help(
                    &keys.span_of(other),
                    what,
                    "leave one of them out: times say when it is where",
                );
                return None;
            }
            times
        }
    };
    let timing = match times {
        Some(times) => Timing::At(times),
        None if smooth => Timing::Smooth,
        None => Timing::Linear,
    };
    match Way::new(&points, over, timing) {
        Ok(way) => Some(way),
        Err(fault) => {
            keys.sink.error(&value.span(), format!("{}: {fault}", keys.who));
            None
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::patch::{Patch, Place};
    use crate::space::point::Point;

    fn apart(a: Point, b: Point) -> f64 {
        a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    }

    /// The place of an event, or what is wrong with it.
    fn place(written: &str) -> Result<Place, String> {
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"s\"\n[voice.v.nodes]\n\
             s = {{ type = \"sine\", frequency = 80 }}\n[pattern.p]\nevents = [{{ at = 0, voice = \"v\", place = {written} }}]\n"
        );
        let patch = Patch::parse("t.toml", text.as_bytes()).map_err(|p| p.to_string())?.value;
        let mut found = None;
        patch.each_place(|place, _| found = Some(place.clone()));
        found.ok_or_else(String::new)
    }

    #[test]
    fn a_path_takes_its_own_time_or_that_of_its_event() {
        let at = |written: &str, seconds: f64, event: f64| match place(written) {
            Ok(Place::Path(way)) => way.route().at(seconds, event),
            other => panic!("{other:?}"),
        };
        let near = |a: [f64; 3], b: [f64; 3]| assert!(apart(a, b) < 1e-15, "{a:?} {b:?}");
        near(at("{ path = [[0, 0], [0.1, 0]], over = 0.5 }", 0.25, 9.0), [0.05, 0.0, 0.0]);
        near(at("{ path = [[0, 0], [0.1, 0]] }", 0.25, 1.0), [0.025, 0.0, 0.0]);
        near(at("{ path = [[0, 0], [0.1, 0]] }", 0.25, f64::INFINITY), [0.025, 0.0, 0.0]);
        near(
            at("{ path = [[0, 0, 1], [0, 0.2, 1]], timing = \"smooth\" }", 0.25, 1.0),
            [0.0, 0.2 * 0.15625, 1.0],
        );
        near(
            at("{ path = [[0, 0], [0.1, 0], [0.1, 0.1]], times = [0, 0.1, 1] }", 0.55, 3.0),
            [0.1, 0.05, 0.0],
        );
    }

    #[test]
    fn what_is_no_path_is_said_at_its_line() {
        for (written, wanted) in [
            ("{ path = [[0, 0]] }", "two"),
            ("{ path = [] }", "two"),
            ("{ path = [[0, 0], [0, 0]] }", "lies at"),
            ("{ path = [[0, 0], [0.1]] }", "points"),
            ("{ path = [[0, 0], [inf, 0]] }", "points"),
            ("{ path = [[0, 0], [1e9, 0]] }", "1000 m"),
            ("{ path = 3 }", "points"),
            ("{ path = [[0, 0], [0.1, 0]], over = 0 }", "0.001"),
            ("{ path = [[0, 0], [0.1, 0]], over = nan }", "over"),
            ("{ path = [[0, 0], [0.1, 0]], times = [0] }", "1"),
            ("{ path = [[0, 0], [0.1, 0]], times = [1, 1] }", "rise"),
            ("{ path = [[0, 0], [0.1, 0]], times = [0, 1], over = 2 }", "both"),
            ("{ path = [[0, 0], [0.1, 0]], tming = \"smooth\" }", "timing"),
            ("{ over = 2 }", "path"),
        ] {
            let said = place(written).unwrap_err();
            assert!(said.contains("t.toml:8:") && said.contains(wanted), "{written}: {said}");
        }
    }
}
