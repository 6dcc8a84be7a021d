//! A file of events, one a line, for patterns too long to write into a patch.
//!
//! The first line names the columns: `at` and `voice` or `marker`, and as one likes `level`, `duration`, `place`, `delay` and
//! fields of the voices. Cells are divided by commas and may stand in double quotes (two of them for one within); an empty
//! cell is as if it were not there. A place is a name, a channel, or two or three coordinates with blanks between them.
//! Empty lines and lines that begin with `#` count for nothing. Lines need not be in the order of time. An events file plays
//! voices and markers, no patterns.

use std::io::{BufRead, Read};

use super::event::{Action, Event, Play, Setting, limits, misnamed};
use super::names::Names;
use super::place::{self, Place};
use crate::text::cells::{Cell, cells};
use crate::text::nearest::suggest;
use crate::text::reader::range;
use crate::text::{Problem, Span, measure};

/// The longest line, bytes.
pub const MAX_LINE: u64 = 64 << 10;

/// Reads events line by line. A bad line gives a [`Problem`] that names file and line, and reading goes on behind it.
///
/// With names to check against, [`EventsFile::line_of_events`] gives all problems of a line, at their place in [`EventsFile::source`].
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
    kept: Option<Kept>,
}

/// What of a file is kept to show its problems.
#[derive(Debug, Default)]
struct Kept {
    text: String,
    /// Where the line begins that was read last.
    line: usize,
    /// Whether something is wrong with it.
    wrong: bool,
    /// Whether no more is kept.
    full: bool,
}

/// Of a file with more bytes, only the lines are kept with which something is wrong, and the ends of the others.
const SHOWN: usize = 1 << 19;
/// Where so many bytes are kept, no more are: problems behind it are told by the number of their line.
const MOST_KEPT: usize = 16 << 20;

#[derive(Debug, Clone, PartialEq)]
enum Column {
    At,
    Voice,
    Marker,
    Level,
    Felt,
    Duration,
    Place,
    Delay,
    Field(String),
}

const COLUMNS: [(&str, Column); 8] = [
    ("at", Column::At),
    ("voice", Column::Voice),
    ("marker", Column::Marker),
    ("level", Column::Level),
    ("felt", Column::Felt),
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
        let mut file = Self::unread(name, input, names);
        file.head().map(|()| file)
    }

    fn unread(name: &str, input: R, names: Option<Names<'a>>) -> Self {
        let kept = names.is_some().then(Kept::default);
        Self {
            kept,
            input,
            name: name.into(),
            names,
            columns: Vec::new(),
            line: 0,
            bytes: 0,
            buffer: Vec::new(),
            ended: false,
        }
    }

    /// As [`EventsFile::new`], with what was read to show the problem in.
    #[cfg(feature = "io")] // Files are checked there.
    pub(crate) fn checked(name: &str, input: R, names: Names<'a>) -> Result<Self, (Problem, String)> {
        let mut file = Self::unread(name, input, Some(names));
        match file.head() {
            Ok(()) => Ok(file),
            Err(problem) => Err((problem, file.source())),
        }
    }

    fn head(&mut self) -> Result<(), Problem> {
        let file = self;
        let Some((header, from)) = file.next_line()? else {
            let what = "the file has no events";
            return Err(match file.kept {
                Some(_) => Problem::of_file(what),
                None => Problem::of_file(format!("{}: {what}", file.name)),
            });
        };
        let cells = cells(&header).map_err(|what| file.wrong(&file.whole(), &what, None))?;
        if let [Cell { text, .. }] = &cells[..]
            && let Some(divider) = [';', '\t'].into_iter().find(|c| text.contains(*c))
        {
            let divider = if divider == ';' { "semicolons" } else { "tabs" };
            let what = format!("the columns are divided by {divider}");
            let help = "cells are divided by commas: at,voice,level".to_string();
            return Err(file.wrong(&file.whole(), &what, Some(help)));
        }
        for Cell { text: cell, span } in cells {
            let span = file.place_of(from, &span);
            let column = match COLUMNS.iter().find(|(word, _)| *word == cell) {
                Some((_, column)) => column.clone(),
                None => {
                    let known = file.names.as_ref().is_none_or(|n| n.fields().any(|f| f == cell));
                    if !known || cell.is_empty() || ["pattern", "choose", "repeat"].contains(&cell.as_str()) {
                        let fields: Vec<&str> = file.names.iter().flat_map(Names::fields).collect();
                        let help = suggest(&cell, COLUMNS.iter().map(|(w, _)| *w).chain(fields));
                        return Err(file.wrong(&span, &format!("there is no column `{cell}`"), help));
                    }
                    Column::Field(cell)
                }
            };
            if file.columns.contains(&column) {
                return Err(file.wrong(&span, "a column stands there twice", None));
            }
            file.columns.push(column);
        }
        let has = |c: &Column| file.columns.contains(c);
        if !has(&Column::At) || !(has(&Column::Voice) || has(&Column::Marker)) {
            let help = "the first line names the columns: at,voice,level,duration,place".to_string();
            let what = "the columns `at` and `voice` (or `marker`) must be there";
            return Err(file.wrong(&file.whole(), what, Some(help)));
        }
        Ok(())
    }

    /// The line that was read last, from 1.
    pub fn line(&self) -> u64 {
        self.line
    }

    /// What was read so far, for its problems to be shown in: the whole file where it is not large, else the lines that something is
    /// wrong with, each at its number. Empty where no names were given.
    pub fn source(&self) -> String {
        self.kept.as_ref().map(|kept| kept.text.clone()).unwrap_or_default()
    }

    /// A problem at a place of the line that was read last.
    pub(crate) fn wrong(&mut self, span: &Span, what: &str, help: Option<String>) -> Problem {
        match &mut self.kept {
            Some(kept) if !kept.full => {
                kept.wrong = true;
                Problem::error(span, what).help(help)
            }
            Some(_) => Problem::of_file(format!("line {}: {what}", self.line)).help(help),
            None => Problem::of_file(format!("{}:{}: {what}", self.name, self.line)).help(help),
        }
    }

    /// That of a line read last: in what is kept, else in the file.
    pub(crate) fn whole(&self) -> Span {
        match &self.kept {
            Some(kept) if !kept.full => kept.line..kept.text.trim_end().len().max(kept.line),
            _ => self.bytes - self.buffer.len()..self.bytes,
        }
    }

    /// That of a part of the line, which begins `from` bytes behind the line's beginning.
    fn place_of(&self, from: usize, part: &Span) -> Span {
        match &self.kept {
            Some(kept) if !kept.full => kept.line + from + part.start..kept.line + from + part.end,
            _ => self.whole(),
        }
    }

    /// Keeps the line that was read last, and of the one before only what is needed.
    fn keep(&mut self) {
        let Some(kept) = self.kept.as_mut().filter(|kept| !kept.full) else { return };
        if kept.text.len() > SHOWN && !std::mem::take(&mut kept.wrong) && kept.line < kept.text.len() {
            kept.text.truncate(kept.line);
            kept.text.push('\n');
        }
        kept.wrong = false;
        kept.full = kept.text.len() > MOST_KEPT;
        if !kept.full {
            kept.line = kept.text.len();
            let text = String::from_utf8_lossy(&self.buffer);
            let text = if self.line == 1 { text.trim_start_matches('\u{feff}') } else { &text };
            kept.text.push_str(text);
        }
    }

    /// The next line that says something, and how far behind the line's beginning it begins.
    fn next_line(&mut self) -> Result<Option<(String, usize)>, Problem> {
        loop {
            self.buffer.clear();
            self.line += 1;
            let read = (&mut self.input).take(MAX_LINE + 1).read_until(b'\n', &mut self.buffer);
            let length = read.map_err(|e| {
                self.ended = true;
                self.wrong(&self.whole(), &format!("the file cannot be read further: {e}"), None)
            })?;
            if length == 0 {
                self.ended = true;
                return Ok(None);
            }
            self.bytes += length;
            self.keep();
            if length as u64 > MAX_LINE {
                // Where this line ends is anyone's guess.
                self.ended = true;
                return Err(self.wrong(
                    &self.whole(),
                    &format!("the line is longer than {MAX_LINE} bytes"),
                    None,
                ));
            }
            let Ok(text) = std::str::from_utf8(&self.buffer) else {
                return Err(self.wrong(&self.whole(), "the line is not UTF-8", None));
            };
            let text = if self.line == 1 { text.trim_start_matches('\u{feff}') } else { text };
            let from = text.len() - text.trim_start().len();
            let text = text.trim();
            if !text.is_empty() && !text.starts_with('#') {
                return Ok(Some((text.into(), from)));
            }
        }
    }

    fn event(&mut self, text: &str, from: usize) -> Result<Event, Vec<Problem>> {
        let whole = self.whole();
        let cells = cells(text).map_err(|what| vec![self.wrong(&whole, &what, None)])?;
        if cells.len() != self.columns.len() {
            let what =
                format!("the line has {} cells, there are {} columns", cells.len(), self.columns.len());
            return Err(vec![self.wrong(&whole, &what, None)]);
        }
        let (mut at, mut delay, mut level, mut duration, mut place) = (None, 0.0, None, None, None);
        let mut felt = None;
        let (mut voice, mut marker, mut fields, mut place_span) = (None, None, Vec::new(), whole.clone());
        let mut problems = Vec::new();
        let columns = std::mem::take(&mut self.columns);
        for (column, Cell { text: cell, span }) in columns.iter().zip(cells) {
            if cell.is_empty() {
                continue;
            }
            let span = self.place_of(from, &span);
            // Something to go on with; what is wrong is reported.
            let mut number = |key: &str, [least, most]: [f64; 2]| match number(key, &cell, least, most) {
                Ok(x) => x,
                Err((what, help)) => {
                    problems.push(self.wrong(&span, &what, help));
                    0.0
                }
            };
            match column {
                Column::At => at = Some(number("at", [0.0, 1e9])),
                Column::Delay => delay = number("delay", [0.0, 1e9]),
                Column::Level => level = Some(number("level", limits("level"))),
                Column::Felt => {
                    let value = number("felt", limits("felt"));
                    felt = Some(Setting { name: "felt".into(), value, span });
                }
                Column::Duration => duration = Some(number("duration", limits("duration"))),
                Column::Place => match place_in(&cell) {
                    Ok(read) => (place, place_span) = (Some(read), span),
                    Err(what) => problems.push(self.wrong(&span, &what, None)),
                },
                Column::Voice => voice = Some((cell, span)),
                Column::Marker => {
                    if let Some((what, help)) = misnamed(&cell) {
                        problems.push(self.wrong(&span, &format!("the event has {what}"), Some(help.into())));
                    }
                    marker = Some((cell, span));
                }
                Column::Field(name) => {
                    // A column may concern some voices only; a voice that lacks the field is a mistake where its cell is filled.
                    let value = number(name, limits(name));
                    fields.push(Setting { name: name.clone(), value, span });
                }
            }
        }
        self.columns = columns;
        let action = match (voice, marker) {
            (Some((voice, span)), None) => {
                let motion = None;
                Some(Action::Voice(Play {
                    voice,
                    span,
                    place_span,
                    level,
                    felt,
                    duration,
                    place,
                    motion,
                    fields,
                }))
            }
            (None, Some((marker, _))) => Some(Action::Marker(marker)),
            (None, None) => {
                problems.push(self.wrong(&whole, "the event has no voice", None));
                None
            }
            (Some(_), Some((_, span))) => {
                problems.push(self.wrong(&span, "the event has `voice` and `marker` at once", None));
                None
            }
        };
        if at.is_none() {
            problems.push(self.wrong(&whole, "the event lacks `at`", None));
        }
        let event = action.map(|action| Event {
            at: at.unwrap_or(0.0),
            delay,
            repeat: None,
            action,
            span: whole.clone(),
        });
        let found = event.as_ref().zip(self.names.as_ref()).map(|(event, names)| names.check_event(event));
        for Problem { what, help, span, .. } in found.unwrap_or_default() {
            problems.push(self.wrong(&span.unwrap_or(whole.clone()), &what, help));
        }
        problems.sort_by_key(|p| p.span.as_ref().map_or(0, |s| s.start));
        match event {
            Some(event) if problems.is_empty() => Ok(event),
            _ => Err(problems),
        }
    }

    /// The next event, or everything that is wrong with its line; `None` at the end.
    pub fn line_of_events(&mut self) -> Option<Result<Event, Vec<Problem>>> {
        if self.ended {
            return None;
        }
        match self.next_line() {
            Ok(Some((text, from))) => Some(self.event(&text, from)),
            Ok(None) => None,
            Err(problem) => Some(Err(vec![problem])),
        }
    }
}

fn number(key: &str, cell: &str, least: f64, most: f64) -> Result<f64, (String, Option<String>)> {
    match cell.parse::<f64>() {
        Ok(x) if x.is_finite() && x >= least && x <= most => Ok(x),
        read => {
            // "4 ms" is no number; one that is out of range has no unit to take off.
            let advice = if read.is_err() { measure::advice(key, cell) } else { None };
            let help = advice.map(|help| help.replacen(&format!("{key} = "), "", 1));
            Err((format!("`{key}` is \"{cell}\"; it must be {}", range(least, most)), help))
        }
    }
}

fn place_in(cell: &str) -> Result<Place, String> {
    if let Ok(n) = cell.parse::<u64>() {
        return place::channel(n)
            .map(Place::Channel)
            .ok_or_else(|| format!("`place` is {n}; channels count from 1 to 4096"));
    }
    let numbers: Result<Vec<f64>, _> = cell.split_whitespace().map(str::parse).collect();
    let Ok(numbers) = numbers else { return Ok(Place::Name(cell.into())) };
    place::position(&numbers)
        .map(Place::Position)
        .ok_or_else(|| format!("`place` is \"{cell}\"; a position is two or three coordinates in metres, none farther than {} m from 0", place::MOST_METRES))
}

impl<R: BufRead> Iterator for EventsFile<'_, R> {
    type Item = Result<Event, Problem>;

    fn next(&mut self) -> Option<Self::Item> {
        // One is enough to end a performance; the others are for who checks the file.
        let first = |problems: Vec<Problem>| problems.into_iter().next();
        Some(match self.line_of_events()? {
            Ok(event) => Ok(event),
            Err(problems) => Err(first(problems)?),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::EventsFile;
    use crate::patch::{Action, Event, Patch, Place};
    use crate::text::Problem;

    fn read(text: &str) -> Vec<Result<Event, Problem>> {
        match EventsFile::new("walk.csv", text.as_bytes(), None) {
            Ok(file) => file.collect(),
            Err(problem) => vec![Err(problem)],
        }
    }

    #[test]
    fn markers_have_no_control_characters_wherever_they_are_named() {
        for (name, bad) in
            [("go \u{7}", true), ("\u{1b}[2J", true), ("a\u{85}b", true), ("Größe 3: ab", false)]
        {
            let of_file = read(&format!("at,marker\n0,{name}\n"));
            let why = of_file[0].as_ref().err().map(|problem| problem.to_string());
            assert_eq!(
                why.is_some_and(|why| why.contains("control character")),
                bad,
                "{name:?}: {of_file:?}"
            );
            let name: String = name.chars().map(|c| format!("\\u{:04x}", c as u32)).collect();
            let text = format!(
                "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[pattern.p]\nevents = [{{ at = 0, marker = \"{name}\" }}]\n"
            );
            let of_patch = Patch::parse("p", text.as_bytes());
            let why = of_patch.as_ref().err().map(|problems| problems.to_string());
            assert_eq!(why.is_some_and(|why| why.contains("control character")), bad, "{name}: {of_patch:?}");
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
}
