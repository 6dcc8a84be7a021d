//! A file of events, one a line, for patterns too long to write into a patch.
//!
//! The first line names the columns: `at` and `voice` or `marker`, and as one likes `level`, `duration`, `place`, `delay` and
//! fields of the voices. Cells are divided by commas and may stand in double quotes (two of them for one within); an empty
//! cell is as if it were not there. A place is a name, a channel, or two or three coordinates with blanks between them.
//! Empty lines and lines that begin with `#` count for nothing. Lines need not be in the order of time. An events file plays
//! voices and markers, no patterns.

use std::io::{BufRead, Read};

use super::event::{Action, Event, Play, Setting};
use super::names::Names;
use super::place::{self, Place};
use crate::text::nearest::suggest;
use crate::text::reader::range;
use crate::text::{Problem, measure};

/// The longest line, bytes.
pub const MAX_LINE: u64 = 64 << 10;

/// Reads events line by line. A bad line gives a [`Problem`] that names file and line, and reading goes on behind it.
#[derive(Debug)]
pub struct EventsFile<'a, R> {
    input: R,
    name: String,
    names: Option<Names<'a>>,
    columns: Vec<Column>,
    line: u64,
    bytes: usize,
    buffer: Vec<u8>,
    ended: bool,
}

#[derive(Debug, Clone, PartialEq)]
enum Column {
    At,
    Voice,
    Marker,
    Level,
    Duration,
    Place,
    Delay,
    Field(String),
}

const COLUMNS: [(&str, Column); 7] = [
    ("at", Column::At),
    ("voice", Column::Voice),
    ("marker", Column::Marker),
    ("level", Column::Level),
    ("duration", Column::Duration),
    ("place", Column::Place),
    ("delay", Column::Delay),
];

impl<'a, R: BufRead> EventsFile<'a, R> {
    /// Reads the line of column names of the file called `name`. With `names`, voices and fields are checked as well.
    ///
    /// # Errors
    /// Says what is wrong with the columns.
    pub fn new(name: &str, input: R, names: Option<Names<'a>>) -> Result<Self, Problem> {
        let mut file = Self {
            input,
            name: name.into(),
            names,
            columns: Vec::new(),
            line: 0,
            bytes: 0,
            buffer: Vec::new(),
            ended: false,
        };
        let Some(header) = file.next_line()? else {
            return Err(Problem::of_file(format!("{name}: the file has no events")));
        };
        let cells = cells(&header).map_err(|what| file.wrong(&what, None))?;
        for cell in cells {
            let column = match COLUMNS.iter().find(|(word, _)| *word == cell) {
                Some((_, column)) => column.clone(),
                None => {
                    let known = file.names.as_ref().is_none_or(|n| n.fields().any(|f| f == cell));
                    if !known || cell.is_empty() || ["pattern", "choose", "repeat"].contains(&cell.as_str()) {
                        let fields: Vec<&str> = file.names.iter().flat_map(Names::fields).collect();
                        let help = suggest(&cell, COLUMNS.iter().map(|(w, _)| *w).chain(fields));
                        return Err(file.wrong(&format!("there is no column `{cell}`"), help));
                    }
                    Column::Field(cell)
                }
            };
            if file.columns.contains(&column) {
                return Err(file.wrong("a column stands there twice", None));
            }
            file.columns.push(column);
        }
        let has = |c: &Column| file.columns.contains(c);
        if !has(&Column::At) || !(has(&Column::Voice) || has(&Column::Marker)) {
            let help = "the first line names the columns: at,voice,level,duration,place".to_string();
            return Err(file.wrong("the columns `at` and `voice` (or `marker`) must be there", Some(help)));
        }
        Ok(file)
    }

    /// The line that was read last, from 1.
    pub fn line(&self) -> u64 {
        self.line
    }

    fn wrong(&self, what: &str, help: Option<String>) -> Problem {
        Problem::of_file(format!("{}:{}: {what}", self.name, self.line)).help(help)
    }

    /// The next line that says something.
    fn next_line(&mut self) -> Result<Option<String>, Problem> {
        loop {
            self.buffer.clear();
            self.line += 1;
            let read = (&mut self.input).take(MAX_LINE + 1).read_until(b'\n', &mut self.buffer);
            let length = read.map_err(|e| {
                self.ended = true;
                self.wrong(&format!("the file cannot be read further: {e}"), None)
            })?;
            if length == 0 {
                self.ended = true;
                return Ok(None);
            }
            self.bytes += length;
            if length as u64 > MAX_LINE {
                // Where this line ends is anyone's guess.
                self.ended = true;
                return Err(self.wrong(&format!("the line is longer than {MAX_LINE} bytes"), None));
            }
            let text =
                std::str::from_utf8(&self.buffer).map_err(|_| self.wrong("the line is not UTF-8", None))?;
            let text = if self.line == 1 { text.trim_start_matches('\u{feff}') } else { text };
            let text = text.trim();
            if !text.is_empty() && !text.starts_with('#') {
                return Ok(Some(text.into()));
            }
        }
    }

    fn event(&self, text: &str) -> Result<Event, Problem> {
        let cells = cells(text).map_err(|what| self.wrong(&what, None))?;
        if cells.len() != self.columns.len() {
            let what =
                format!("the line has {} cells, there are {} columns", cells.len(), self.columns.len());
            return Err(self.wrong(&what, None));
        }
        let span = self.bytes - self.buffer.len()..self.bytes;
        let (mut at, mut delay, mut level, mut duration, mut place) = (None, 0.0, None, None, None);
        let (mut voice, mut marker, mut fields) = (None, None, Vec::new());
        for (column, cell) in self.columns.iter().zip(cells).filter(|(_, cell)| !cell.is_empty()) {
            match column {
                Column::At => at = Some(self.number("at", &cell, 0.0, 1e9)?),
                Column::Delay => delay = self.number("delay", &cell, 0.0, 1e9)?,
                Column::Level => level = Some(self.number("level", &cell, 0.0, 100.0)?),
                Column::Duration => duration = Some(self.number("duration", &cell, 0.0, 1e6)?),
                Column::Place => place = Some(self.place(&cell)?),
                Column::Voice => voice = Some(cell),
                Column::Marker => marker = Some(cell),
                Column::Field(name) => {
                    let value = self.number(name, &cell, -1e9, 1e9)?;
                    fields.push(Setting { name: name.clone(), value, span: span.clone() });
                }
            }
        }
        let action = match (voice, marker) {
            (Some(voice), None) => {
                // A column may concern some voices only; a voice that lacks the field is a mistake where its cell is filled.
                let place_span = span.clone();
                Action::Voice(Play { voice, span: span.clone(), place_span, level, duration, place, fields })
            }
            (None, Some(marker)) => Action::Marker(marker),
            (None, None) => return Err(self.wrong("the event has no voice", None)),
            (Some(_), Some(_)) => return Err(self.wrong("the event has `voice` and `marker` at once", None)),
        };
        let Some(at) = at else { return Err(self.wrong("the event lacks `at`", None)) };
        let event = Event { at, delay, repeat: None, action, span };
        match self.names.as_ref().and_then(|n| n.check_event(&event).into_iter().next()) {
            Some(problem) => Err(self.wrong(&problem.what, problem.help)),
            None => Ok(event),
        }
    }

    fn number(&self, key: &str, cell: &str, least: f64, most: f64) -> Result<f64, Problem> {
        match cell.parse::<f64>() {
            Ok(x) if x.is_finite() && x >= least && x <= most => Ok(x),
            read => {
                // "4 ms" is no number; one that is out of range has no unit to take off.
                let advice = if read.is_err() { measure::advice(key, cell) } else { None };
                let help = advice.map(|help| help.replacen(&format!("{key} = "), "", 1));
                Err(self.wrong(&format!("`{key}` is \"{cell}\"; it must be {}", range(least, most)), help))
            }
        }
    }

    fn place(&self, cell: &str) -> Result<Place, Problem> {
        if let Ok(n) = cell.parse::<u64>() {
            return place::channel(n)
                .map(Place::Channel)
                .ok_or_else(|| self.wrong(&format!("`place` is {n}; channels count from 1 to 4096"), None));
        }
        let numbers: Result<Vec<f64>, _> = cell.split_whitespace().map(str::parse).collect();
        let Ok(numbers) = numbers else { return Ok(Place::Name(cell.into())) };
        place::position(&numbers).map(Place::Position).ok_or_else(|| {
            self.wrong(
                &format!("`place` is \"{cell}\"; a position is two or three coordinates in metres"),
                None,
            )
        })
    }
}

impl<R: BufRead> Iterator for EventsFile<'_, R> {
    type Item = Result<Event, Problem>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        match self.next_line() {
            Ok(Some(text)) => Some(self.event(&text)),
            Ok(None) => None,
            Err(problem) => Some(Err(problem)),
        }
    }
}

/// The cells of a line.
fn cells(line: &str) -> Result<Vec<String>, String> {
    let mut cells = Vec::new();
    let mut rest = line;
    loop {
        rest = rest.trim_start();
        let mut cell = String::new();
        if let Some(mut quoted) = rest.strip_prefix('"') {
            loop {
                let Some((text, behind)) = quoted.split_once('"') else {
                    return Err("a quote does not end on its line".into());
                };
                cell.push_str(text);
                match behind.strip_prefix('"') {
                    Some(more) => {
                        cell.push('"');
                        quoted = more;
                    }
                    None => {
                        rest = behind.trim_start();
                        break;
                    }
                }
            }
            if !rest.is_empty() && !rest.starts_with(',') {
                return Err("a comma is missing behind a quote".into());
            }
        } else {
            let end = rest.find(',').unwrap_or(rest.len());
            let (text, behind) = rest.split_at(end);
            cell.push_str(text.trim_end());
            rest = behind;
        }
        cells.push(cell);
        match rest.strip_prefix(',') {
            Some(more) => rest = more,
            None => return Ok(cells),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{EventsFile, cells};
    use crate::patch::{Action, Event, Place};
    use crate::text::Problem;

    fn read(text: &str) -> Vec<Result<Event, Problem>> {
        match EventsFile::new("walk.csv", text.as_bytes(), None) {
            Ok(file) => file.collect(),
            Err(problem) => vec![Err(problem)],
        }
    }

    #[test]
    fn reads_what_it_should() {
        let text = "\u{feff}at, voice ,level,place,depth,marker\r\n# a comment\n\n0.5,beat,0.25,top,,\n1,beat,,3,2.5,\n\
                    0, \"beat\",,0.1 -0.2,,\n2,,,,,end";
        let events: Vec<Event> = read(text).into_iter().map(Result::unwrap).collect();
        assert_eq!(events.iter().map(|e| e.at).collect::<Vec<_>>(), [0.5, 1.0, 0.0, 2.0]);
        let plays: Vec<_> = events
            .iter()
            .filter_map(|e| if let Action::Voice(p) = &e.action { Some(p) } else { None })
            .collect();
        assert!(plays.iter().all(|p| p.voice == "beat"));
        assert_eq!(plays[0].level, Some(0.25));
        assert!(plays[0].fields.is_empty());
        assert_eq!(plays[1].fields[0].value, 2.5);
        let places: Vec<_> = plays.iter().filter_map(|p| p.place.clone()).collect();
        let expected = [Place::Name("top".into()), Place::Channel(3), Place::Position([0.1, -0.2, 0.0])];
        assert_eq!(places, expected);
        assert_eq!(events[3].action, Action::Marker("end".into()));
        let line = &text.as_bytes()[events[0].span.clone()];
        assert_eq!(line, b"0.5,beat,0.25,top,,\n");
    }

    #[test]
    fn a_bad_line_is_named_and_the_next_is_read() {
        let read =
            read("at,voice,level\n0,beat,1\n1,beat,loud\n2,beat\nnan,beat,1\n3,,1\n,beat,1\n4,beat,1\n");
        let problems: Vec<String> =
            read.iter().filter_map(|r| r.as_ref().err()).map(|p| p.what.clone()).collect();
        let expected = [
            "walk.csv:3: `level` is \"loud\"; it must be a number from 0 to 100",
            "walk.csv:4: the line has 2 cells, there are 3 columns",
            "walk.csv:5: `at` is \"nan\"",
            "walk.csv:6: the event has no voice",
            "walk.csv:7: the event lacks `at`",
        ];
        assert_eq!(problems.len(), expected.len(), "{problems:?}");
        for (problem, expected) in problems.iter().zip(expected) {
            assert!(problem.starts_with(expected), "{problem}");
        }
        assert_eq!(read.iter().filter(|r| r.is_ok()).count(), 2);
    }

    #[test]
    fn units_are_taken_off() {
        let help = |cell: &str| {
            let mut read = read(&format!("at,voice,duration\n0,a,{cell}\n"));
            read.remove(0).unwrap_err().help.unwrap_or_default()
        };
        assert!(help("40 ms").starts_with("write 0.04: numbers have no unit"), "{}", help("40 ms"));
        assert_eq!(help("-1"), "");
    }

    #[test]
    fn columns_are_checked() {
        for (text, what) in [
            ("", "walk.csv: the file has no events"),
            ("voice,level\n", "walk.csv:1: the columns `at` and `voice`"),
            ("at,voice,at\n", "walk.csv:1: a column stands there twice"),
            ("at,pattern\n", "walk.csv:1: there is no column `pattern`"),
            ("at,\"voice\n", "walk.csv:1: a quote does not end"),
        ] {
            let first = read(text).remove(0).unwrap_err();
            assert!(first.what.starts_with(what), "{}", first.what);
        }
        assert!(read("at,voice\n0,\u{0}\n1,x\n").iter().all(Result::is_ok));
        let long = format!("at,voice\n0,{}\n", "x".repeat(70_000));
        assert!(read(&long)[0].as_ref().unwrap_err().what.contains("longer than"));
    }

    #[test]
    fn quotes_are_taken_off() {
        assert_eq!(cells("a,\"b,\"\"c\"\" \" , d,").unwrap(), ["a", "b,\"c\" ", "d", ""]);
        assert!(cells("\"a\"b").is_err());
    }
}
