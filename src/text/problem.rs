//! What is wrong with a file, and where.

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
        f.write_str(&self.what)?;
        self.help.iter().try_for_each(|help| write!(f, "\n  help: {help}"))
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
    /// A single error of a file as a whole.
    pub fn of_file(file: &str, what: impl Into<String>) -> Self {
        Self { file: file.into(), source: String::new(), list: vec![Problem::of_file(what)] }
    }
    /// Whether one of them refuses the file.
    pub fn has_errors(&self) -> bool {
        self.list.iter().any(Problem::is_error)
    }
    /// Line and column of a byte, both from 1; the column counts characters.
    pub fn position(&self, byte: usize) -> (usize, usize) {
        let before = self.source.as_bytes().get(..byte).unwrap_or(self.source.as_bytes());
        let line = before.iter().filter(|b| **b == b'\n').count() + 1;
        let begin = before.iter().rposition(|b| *b == b'\n').map_or(0, |b| b + 1);
        (line, self.column(begin, byte))
    }
    /// The character of a line that begins at `begin` in which a byte lies, from 1.
    fn column(&self, begin: usize, byte: usize) -> usize {
        let line = self.source.get(begin..).unwrap_or("");
        line.char_indices().take_while(|(i, c)| begin + i + c.len_utf8() <= byte).count() + 1
    }
    /// By line; what concerns the whole file first.
    pub(crate) fn sort(&mut self) {
        self.list.sort_by_key(|p| p.span.as_ref().map(|s| s.start + 1).unwrap_or(0));
    }
}

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let breaks: Vec<usize> =
            self.source.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i).collect();
        for (i, problem) in self.list.iter().enumerate() {
            if i > 0 {
                writeln!(f)?;
            }
            if !self.file.is_empty() {
                write!(f, "{}:", self.file)?;
            }
            if let Some(span) = problem.span.as_ref().filter(|_| !self.source.is_empty()) {
                let before = breaks.partition_point(|b| *b < span.start);
                let begin = before.checked_sub(1).and_then(|i| breaks.get(i)).map_or(0, |b| b + 1);
                let (line, column) = (before + 1, self.column(begin, span.start));
                write!(f, "{line}:{column}:")?;
            }
            let word = if problem.is_error() { "error" } else { "warning" };
            let gap = if self.file.is_empty() { "" } else { " " };
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
    use super::{Origin, Problem, Problems};

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
}
