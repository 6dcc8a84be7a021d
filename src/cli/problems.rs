//! Problems, shown to people (with the lines they are about) and to programs.

use super::paint::Paint;
use super::terminal::Terminal;
use miette::{
    Diagnostic, LabeledSpan, MietteHandler, MietteHandlerOpts, NamedSource, ReportHandler, SourceCode,
};
use pacinian::text::problem::{self as message, Positions, escaped, is_hidden};
use pacinian::text::{Problem, Problems, Severity};
use serde::Serialize;
use std::fmt;
use std::sync::Arc;

/// A source longer than this is not shown line by line.
const LONG_SOURCE: usize = 1 << 20;
/// Nor is a line longer than this.
const LONG_LINE: usize = 400;

/// All problems of a file, as text.
pub fn shown(problems: &Problems, terminal: &Terminal) -> String {
    let mut text = String::new();
    if terminal.pictured {
        let source = Arc::new(clean(&problems.source));
        let handler = handler(terminal.err);
        let mut positions = problems.positions();
        for problem in &problems.list {
            let picture = Picture::new(problems, problem, &source, &mut positions);
            text += Debugged { handler: &handler, picture: &picture }.to_string().trim_start_matches('\n');
            text.push('\n');
        }
    } else {
        // Which leaves control characters nowhere but between problems.
        text = problems.to_string();
        text.push('\n');
    }
    text
}

/// One that belongs to no file.
pub fn sentence(problem: &Problem, terminal: &Terminal) -> String {
    let word = match problem.severity {
        Severity::Error => terminal.err.red("error"),
        Severity::Warning => terminal.err.yellow("warning"),
    };
    let help = problem.help.as_ref().map_or(String::new(), |help| format!("  help: {}\n", escaped(help)));
    format!("{word}: {}\n{help}", escaped(&problem.what))
}

/// How many there are: "2 errors and 1 warning".
pub fn counted(all: &[Problems]) -> String {
    let list = || all.iter().flat_map(|p| &p.list);
    let errors = list().filter(|p| p.is_error()).count();
    let warnings = list().count() - errors;
    let word = |n: usize, word: &str| format!("{n} {word}{}", if n == 1 { "" } else { "s" });
    match (errors, warnings) {
        (_, 0) => word(errors, "error"),
        (0, _) => word(warnings, "warning"),
        _ => format!("{} and {}", word(errors, "error"), word(warnings, "warning")),
    }
}

/// A problem, for programs.
#[derive(Debug, Serialize)]
pub struct Listed {
    severity: &'static str,
    file: Option<String>,
    line: Option<usize>,
    column: Option<usize>,
    message: String,
    help: Option<String>,
}

/// All problems, for programs.
pub fn listed(all: &[Problems]) -> Vec<Listed> {
    let mut list = Vec::new();
    for problems in all {
        let mut positions = problems.positions();
        for problem in &problems.list {
            let place = span(problems, problem).map(|span| positions.of(span.start));
            list.push(Listed {
                severity: if problem.is_error() { "error" } else { "warning" },
                file: Some(problems.file.clone()).filter(|f| !f.is_empty()),
                line: place.map(|p| p.0),
                column: place.map(|p| p.1),
                message: message::shown(&problem.what),
                help: problem.help.as_deref().map(message::shown),
            });
        }
    }
    list
}

/// Where it stands, if it stands in the source.
fn span(problems: &Problems, problem: &Problem) -> Option<std::ops::Range<usize>> {
    problem.span.clone().filter(|s| !problems.source.is_empty() && *s != (0..0))
}

/// Without what would move a terminal's cursor or change its colours; no byte moves.
fn clean(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '\n' | '\t' => out.push(c),
            '\r' => out.push(' '),
            // As many bytes as it has.
            _ if is_hidden(c) => out.push_str(["?", "·", "•", "··"][c.len_utf8() - 1]),
            _ => out.push(c),
        }
    }
    out
}

fn handler(paint: Paint) -> MietteHandler {
    let options = MietteHandlerOpts::new().terminal_links(false).force_graphical(true).unicode(true);
    options.color(paint.0).context_lines(1).break_words(false).build()
}

/// A problem as miette sees it.
#[derive(Debug)]
struct Picture {
    problem: Problem,
    what: String,
    source: Option<(NamedSource<Arc<String>>, std::ops::Range<usize>)>,
}

impl Picture {
    fn new(
        problems: &Problems,
        problem: &Problem,
        source: &Arc<String>,
        positions: &mut Positions<'_>,
    ) -> Self {
        let place = span(problems, problem).filter(|_| source.len() <= LONG_SOURCE);
        let place = place.filter(|span| line_length(source, span.start) <= LONG_LINE);
        let what = match (&place, span(problems, problem)) {
            (Some(_), _) => message::shown(&problem.what),
            (None, Some(span)) => {
                let (line, column) = positions.of(span.start);
                format!("{}:{line}:{column}: {}", escaped(&problems.file), message::shown(&problem.what))
            }
            (None, None) => format!("{}: {}", escaped(&problems.file), message::shown(&problem.what)),
        };
        let source = place.map(|span| (NamedSource::new(escaped(&problems.file), Arc::clone(source)), span));
        Self { problem: problem.clone(), what, source }
    }
}

fn line_length(source: &str, at: usize) -> usize {
    let at = at.min(source.len());
    let bytes = source.as_bytes();
    let before = bytes[..at].iter().rev().take_while(|b| **b != b'\n').count();
    before + bytes[at..].iter().take_while(|b| **b != b'\n').count()
}

impl fmt::Display for Picture {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.what)
    }
}

impl std::error::Error for Picture {}

impl Diagnostic for Picture {
    fn severity(&self) -> Option<miette::Severity> {
        Some(if self.problem.is_error() { miette::Severity::Error } else { miette::Severity::Warning })
    }
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.problem.help.as_ref().map(|help| Box::new(message::shown(help)) as Box<dyn fmt::Display>)
    }
    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.as_ref().map(|(source, _)| source as &dyn SourceCode)
    }
    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let (source, span) = self.source.as_ref()?;
        let text = source.inner();
        let start = span.start.min(text.len());
        // A table of many lines is pointed at by its first.
        let line = text.get(start..).map_or(0, |rest| rest.find('\n').unwrap_or(rest.len()));
        let length = span.end.saturating_sub(start).min(line).max(usize::from(line > 0));
        Some(Box::new(std::iter::once(LabeledSpan::new(None, start, length))))
    }
}

struct Debugged<'a> {
    handler: &'a MietteHandler,
    picture: &'a Picture,
}

impl fmt::Display for Debugged<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.handler.debug(self.picture, f)
    }
}

#[cfg(test)]
mod tests {
    use super::{clean, counted, is_hidden, listed, shown};
    use crate::cli::paint::Paint;
    use crate::cli::terminal::Terminal;
    use pacinian::text::{Problem, Problems};

    fn problems() -> Problems {
        let list = vec![
            Problem::error(&(4..7), "no \x1b[31mx").help("write y".to_string()),
            Problem::of_file("all of it"),
            Problem::error(&(8..500), "beyond"),
        ];
        Problems { file: "f.toml".into(), source: "abc\nxyz\x1b\nend".into(), list }
    }

    fn terminal(pictured: bool) -> Terminal {
        Terminal { out: Paint(false), err: Paint(false), lively: false, pictured }
    }

    #[test]
    fn pictures_show_the_line_and_nothing_that_moves_a_cursor() {
        let text = shown(&problems(), &terminal(true));
        for wanted in
            ["no \\u{1b}[31mx", "[f.toml:2:1]", "2 │ xyz?", "help: write y", "f.toml: all of it", "beyond"]
        {
            assert!(text.contains(wanted), "{wanted}: {text}");
        }
        assert!(!text.contains('\x1b'));
        assert!(!shown(&problems(), &terminal(false)).contains('\x1b'));
    }

    #[test]
    fn very_long_lines_are_not_drawn() {
        let source = "[".repeat(10_000);
        let list = vec![Problem::error(&(64..65), "too deep")];
        let text = shown(&Problems { file: "f".into(), source, list }, &terminal(true));
        assert!(text.len() < 200 && text.contains("f:1:65: too deep"), "{text}");
    }

    #[test]
    fn programs_get_line_and_column() {
        let list = serde_json::to_value(listed(&[problems()])).unwrap();
        assert_eq!((&list[0]["line"], &list[0]["column"]), (&2.into(), &1.into()));
        assert!(list[1]["line"].is_null());
        assert_eq!(counted(&[problems()]), "3 errors");
        assert_eq!(clean("µ\r\n\u{85}b"), "µ \n·b");
    }

    /// Else what is drawn under a line stands beside what it means.
    #[test]
    fn whatever_is_hidden_leaves_as_many_bytes_of_what_is_not() {
        let mut widths = [0; 5];
        for c in ('\0'..=char::MAX).filter(|c| is_hidden(*c) && !"\n\t\r".contains(*c)) {
            let left = clean(&c.to_string());
            assert!(left.len() == c.len_utf8() && !left.contains(is_hidden), "{c:?}: {left:?}");
            widths[c.len_utf8()] += 1;
        }
        assert!(widths[1..].iter().all(|count| *count > 0), "{widths:?}");
    }
}
