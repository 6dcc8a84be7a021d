//! What is wrong with a file, and where.

use std::borrow::Cow;
use std::fmt;
use std::ops::Range;
use std::sync::Arc;

/// A place in a file, in bytes. Empty at 0 for what was made in code and stands in no file.
pub type Span = Range<usize>;

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth saying; the file still works.
    Warning,
    /// The file is refused.
    Error,
}

/// One thing that is wrong. `Debug` shows what `Display` does, since that is what a `main` that fails prints.
#[derive(Clone, PartialEq, Eq)]
pub struct Problem {
    /// How bad it is.
    pub severity: Severity,
    /// Where, in bytes; `None` for the file as a whole.
    pub span: Option<Span>,
    /// What, in one sentence, with names, values and limits.
    pub what: String,
    /// What to do about it.
    pub help: Option<String>,
}

impl Problem {
    /// An error at a place.
    pub fn error(span: &Span, what: impl Into<String>) -> Self {
        Self { severity: Severity::Error, span: Some(span.clone()), what: what.into(), help: None }
    }
    /// A warning at a place.
    pub fn warning(span: &Span, what: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(span, what) }
    }
    /// An error of the file as a whole.
    pub fn of_file(what: impl Into<String>) -> Self {
        Self { severity: Severity::Error, span: None, what: what.into(), help: None }
    }
    /// The same with advice, which may be missing.
    #[must_use]
    pub fn help(mut self, help: impl Into<Option<String>>) -> Self {
        self.help = help.into();
        self
    }
    /// Whether it refuses the file.
    pub fn is_error(&self) -> bool {
        self.severity == Severity::Error
    }
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&shown(&self.what))?;
        self.help.iter().try_for_each(|help| write!(f, "\n  help: {}", shown(help)))
    }
}

impl fmt::Debug for Problem {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Problem {}

/// A file that something was read from, so that what turns out later can still be shown at its line.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Origin {
    /// The file's name, as the person wrote it; empty for what was made in code.
    pub file: Arc<str>,
    /// What stands in it.
    pub source: Arc<str>,
}

impl Origin {
    /// Problems of the file, by line; what concerns it as a whole first.
    pub fn problems(&self, list: Vec<Problem>) -> Problems {
        let mut problems = Problems { file: self.file.to_string(), source: self.source.to_string(), list };
        problems.sort();
        problems
    }
}

/// Everything that is wrong with one file, in the order of its lines. `Debug` shows what `Display` does.
#[derive(Clone, PartialEq, Eq, Default)]
pub struct Problems {
    /// The file's name, as the person wrote it; empty for what was made in code.
    pub file: String,
    /// What stands in it, so that lines can be shown; empty where it could not be read as text, or was made in code.
    pub source: String,
    /// The problems.
    pub list: Vec<Problem>,
}

impl Problems {
    /// Whether one of them refuses the file.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(Problem::is_error)
    }
    /// Line and column of a byte, both from 1; the column counts characters.
    pub fn position(&self, byte: usize) -> (usize, usize) {
        self.positions().of(byte)
    }
    /// Lines and columns of many bytes; see [`Positions`].
    pub fn positions(&self) -> Positions<'_> {
        Positions { source: &self.source, at: 0, line: 1, column: 1 }
    }
    /// By line; what concerns the whole file first.
    pub(crate) fn sort(&mut self) {
        self.list.sort_by_key(|p| p.span.as_ref().map(|s| s.start + 1).unwrap_or(0));
    }
}

/// Lines and columns in a text, from 1. Asked for places in their order, it reads the text once.
#[derive(Debug, Clone)]
pub struct Positions<'a> {
    source: &'a str,
    at: usize,
    line: usize,
    column: usize,
}

impl Positions<'_> {
    /// Of a byte; the column counts characters.
    pub fn of(&mut self, byte: usize) -> (usize, usize) {
        if byte < self.at {
            (self.at, self.line, self.column) = (0, 1, 1);
        }
        for c in self.source.get(self.at..).unwrap_or_default().chars() {
            if self.at + c.len_utf8() > byte {
                break;
            }
            self.at += c.len_utf8();
            (self.line, self.column) =
                if c == '\n' { (self.line + 1, 1) } else { (self.line, self.column + 1) };
        }
        (self.line, self.column)
    }
}

/// Characters of a name or text in quotes that are shown at its beginning and at its end, where it has more than [`MOST`].
const SHOWN: (usize, usize) = (40, 15);
/// A name in quotes that has more characters is shown in part; a path is shown whole.
const MOST: usize = 60;

/// A message as it may be shown: on one line, without what moves a cursor, and with long names in quotes cut short.
pub fn shown(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(begin) = rest.find(['`', '"']) {
        let (before, quoted) = rest.split_at(begin);
        let quote = quoted.get(..1).unwrap_or_default();
        let Some((name, behind)) = quoted.get(1..).and_then(|inner| inner.split_once(quote)) else { break };
        let (first, last) = SHOWN;
        let count = if name.len() > MOST { name.chars().count() } else { 0 };
        out += &escaped(before);
        out += quote;
        if count > MOST && !name.contains('/') {
            out += &escaped(&name.chars().take(first).collect::<String>());
            out += "...";
            out += &escaped(&name.chars().skip(count - last).collect::<String>());
        } else {
            out += &escaped(name);
        }
        out += quote;
        rest = behind;
    }
    out + &escaped(rest)
}

/// What a terminal would act on rather than show: control characters, and those that turn the direction of writing, break lines or are not seen
/// (Unicode's general categories Cc, Cf, Zl and Zp, blanks that count as letters, and tags).
pub fn is_hidden(c: char) -> bool {
    c.is_control()
        || matches!(
            c,
            '\u{ad}'
                | '\u{600}'..='\u{605}'
                | '\u{61c}' | '\u{6dd}' | '\u{70f}'
                | '\u{890}'..='\u{891}'
                | '\u{8e2}'
                | '\u{115f}'..='\u{1160}'
                | '\u{180b}'..='\u{180f}'
                | '\u{200b}'..='\u{200f}'
                | '\u{2028}'..='\u{202e}'
                | '\u{2060}'..='\u{206f}'
                | '\u{3164}' | '\u{feff}' | '\u{ffa0}'
                | '\u{fff0}'..='\u{fffb}'
                | '\u{110bd}' | '\u{110cd}'
                | '\u{13430}'..='\u{1343f}'
                | '\u{1bca0}'..='\u{1bca3}'
                | '\u{1d173}'..='\u{1d17a}'
                | '\u{e0000}'..='\u{e0fff}'
        )
}

/// On one line, and without what moves a cursor: such characters as in a program's text, `\\n`.
pub fn escaped(text: &str) -> Cow<'_, str> {
    if !text.contains(is_hidden) {
        return text.into();
    }
    let escape = |c: char| if is_hidden(c) { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(escape).collect::<String>().into()
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (file, mut positions) = (escaped(&self.file), self.positions());
        for (i, problem) in self.list.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            if !file.is_empty() {
                write!(f, "{file}:")?;
            }
            if let Some(span) = problem.span.as_ref().filter(|_| !self.source.is_empty()) {
                let (line, column) = positions.of(span.start);
                write!(f, "{line}:{column}:")?;
            }
            let word = if problem.is_error() { "error" } else { "warning" };
            let gap = if file.is_empty() { "" } else { " " };
            write!(f, "{gap}{word}: {problem}")?;
        }
        Ok(())
    }
}

impl fmt::Debug for Problems {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for Problems {}

/// What was read without errors, with the warnings it gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked<T> {
    /// What was read.
    pub value: T,
    /// Warnings; may be empty.
    pub warnings: Problems,
}

#[cfg(test)]
mod tests {
    use super::{Origin, Problem, Problems, shown};

    #[test]
    fn lines_and_columns_count_from_one_in_characters() {
        let source = "a\nµµ x\n".to_string();
        let list = vec![
            Problem::error(&(7..8), "no x").help("write y".to_string()),
            Problem::of_file("all of it"),
            Problem::warning(&(0..1), "an a"),
        ];
        let mut problems = Problems { file: "f.toml".into(), source, list };
        problems.sort();
        assert_eq!(
            problems.to_string(),
            "f.toml: error: all of it\nf.toml:1:1: warning: an a\nf.toml:2:4: error: no x\n  help: write y"
        );
        assert_eq!(problems.position(3), (2, 1), "a byte within a character");
        assert_eq!(problems.position(999), (3, 1), "past the end");
    }

    #[test]
    fn a_main_that_fails_shows_the_lines_and_not_the_source() {
        let source = format!("a\nb{}", "x".repeat(10_000));
        let list = vec![Problem::error(&(2..3), "no b").help("write c".to_string())];
        let problems = Problems { file: "f.toml".into(), source, list };
        assert_eq!(format!("{problems:?}"), "f.toml:2:1: error: no b\n  help: write c");
        assert_eq!(format!("{:?}", problems.list[0]), "no b\n  help: write c");
    }

    #[test]
    fn what_stands_in_no_file_is_said_without_a_place() {
        let list = vec![Problem::error(&(0..0), "no x"), Problem::of_file("all").help("do y".to_string())];
        let error: Box<dyn std::error::Error> = Origin::default().problems(list).into();
        assert_eq!(error.to_string(), "error: all\n  help: do y\nerror: no x");
        let one: Box<dyn std::error::Error> = Problem::of_file("all").help("do y".to_string()).into();
        assert_eq!(one.to_string(), "all\n  help: do y");
    }

    #[test]
    fn places_are_the_same_in_any_order() {
        let source: String = "aµ\n\nxyz é\n".repeat(9);
        let problems = Problems { source: source.clone(), ..Problems::default() };
        let mut forwards = problems.positions();
        for byte in (0..source.len()).chain([3, 2, 40, 7]) {
            let before: Vec<&str> =
                (0..=byte).rev().find_map(|b| source.get(..b)).unwrap().split('\n').collect();
            let expected = (before.len(), before.last().unwrap().chars().count() + 1);
            assert_eq!(forwards.of(byte), expected, "{byte}");
            assert_eq!(problems.position(byte), expected, "{byte}");
        }
    }

    #[test]
    fn a_name_cannot_forge_a_line_or_fill_the_screen() {
        let long = "n".repeat(1_000);
        let cut = format!("no `{}...{}`; there is \"b\"", "n".repeat(40), "n".repeat(15));
        assert_eq!(shown(&format!("no `{long}`; there is \"b\"")), cut);
        let path = format!("`{long}/x.wav` is not there");
        assert_eq!(shown(&path), path, "a path is shown whole");
        assert_eq!(shown("`a\nf.toml:1:1: error: b\u{1b}[2J`"), "`a\\nf.toml:1:1: error: b\\u{1b}[2J`");
        assert_eq!(shown("an odd ` quote"), "an odd ` quote");
        let list = vec![Problem::of_file("x\ny").help("do\nz".to_string())];
        let problems = Problems { file: "f\ng".into(), source: String::new(), list };
        assert_eq!(problems.to_string(), "f\\ng: error: x\\ny\n  help: do\\nz");
    }
}
