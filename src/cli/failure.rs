//! Why a command ends without success.

use super::problems;
use super::terminal::Terminal;
use pacinian::io::device::failure::DeviceError;
use pacinian::io::error::FileError;
use pacinian::text::problem::{self as message, escaped};
use pacinian::text::{Problem, Problems};

/// Why a command ends without success: everything there is to say, and an exit code.
#[derive(Debug, Default)]
pub struct Failure {
    parts: Vec<(u8, Part)>,
}

#[derive(Debug)]
enum Part {
    /// Of a file, each with its place.
    Problems(Problems),
    /// A sentence, and what to do.
    Said(String, Option<String>),
    /// It has been told elsewhere, or nobody listens.
    Nothing,
}

impl Failure {
    /// One sentence.
    pub fn said(code: u8, what: impl Into<String>) -> Self {
        Self { parts: vec![(code, Part::Said(what.into(), None))] }
    }

    /// The system gives no thread for something.
    pub fn no_thread(what: &str, error: &std::io::Error) -> Self {
        Self::said(71, format!("no thread for {what}: {error}"))
    }

    /// What was asked for does not make sense.
    pub fn usage(what: impl Into<String>, help: impl Into<String>) -> Self {
        Self { parts: vec![(2, Part::Said(what.into(), Some(help.into())))] }
    }

    /// The same with another exit code.
    pub fn with_code(mut self, code: u8) -> Self {
        self.parts.iter_mut().for_each(|part| part.0 = code);
        self
    }

    /// With something more to do about what was said.
    #[must_use]
    pub fn and(mut self, more: &str) -> Self {
        for (_, part) in &mut self.parts {
            if let Part::Said(_, help) = part {
                *help = Some(help.take().map_or(more.into(), |help| format!("{help}; {more}")));
            }
        }
        self
    }

    /// What has been told already.
    pub fn told(code: u8) -> Self {
        Self { parts: vec![(code, Part::Nothing)] }
    }

    /// Nobody reads what is written, which is their right.
    pub fn unread() -> Self {
        Self::told(0)
    }

    /// Problems of a file.
    pub fn of(code: u8, problems: Problems) -> Self {
        Self { parts: vec![(code, Part::Problems(problems))] }
    }

    /// Adds another.
    pub fn join(&mut self, other: Self) {
        self.parts.extend(other.parts);
    }

    /// Whether nothing failed.
    pub fn is_none(&self) -> bool {
        self.parts.is_empty()
    }

    /// That of the first part.
    pub fn code(&self) -> u8 {
        self.parts.first().map_or(1, |(code, _)| *code)
    }

    /// Everything, on standard error.
    pub fn show(&self, terminal: &Terminal) {
        terminal.note(&self.text(terminal));
    }

    /// Everything, as [`Failure::show`] writes it.
    pub fn text(&self, terminal: &Terminal) -> String {
        let part = |(_, part): &(u8, Part)| match part {
            Part::Problems(list) => problems::shown(list, terminal),
            Part::Said(what, help) => {
                problems::sentence(&Problem::of_file(what.as_str()).help(help.clone()), terminal)
            }
            Part::Nothing => String::new(),
        };
        self.parts.iter().map(part).collect()
    }

    /// The first of it in a line, `FILE:LINE: MESSAGE`, and how much more there is.
    pub fn brief(&self) -> String {
        let all = self.problems();
        // Errors first; the sort keeps the order of the files.
        let mut list: Vec<_> = all.iter().flat_map(|p| p.list.iter().map(move |one| (p, one))).collect();
        list.sort_by_key(|(_, problem)| !problem.is_error());
        let Some((file, problem)) = list.first() else { return String::new() };
        let line =
            problem.span.as_ref().filter(|_| !file.source.is_empty()).map(|s| file.position(s.start).0);
        let place = match (file.file.as_str(), line) {
            ("", _) => String::new(),
            (name, None) => format!("{name}: "),
            (name, Some(line)) => format!("{name}:{line}: "),
        };
        let more = match list.len() - 1 {
            0 => String::new(),
            more => format!(" (and {more} more)"),
        };
        format!("{}{}{more}", escaped(&place), message::shown(&problem.what))
    }

    /// All problems, those without a file under an empty name.
    pub fn problems(&self) -> Vec<Problems> {
        let list = self.parts.iter().filter_map(|(_, part)| match part {
            Part::Problems(list) => Some(list.clone()),
            Part::Said(what, help) => Some(Problems {
                list: vec![Problem::of_file(what.as_str()).help(help.clone())],
                ..Problems::default()
            }),
            Part::Nothing => None,
        });
        list.collect()
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::said(error.exit_code(), error.message)
    }
}

impl From<DeviceError> for Failure {
    fn from(error: DeviceError) -> Self {
        let code = error.kind.exit_code();
        match error.help {
            Some(help) => Self::usage(error.what, help).with_code(code),
            None => Self::said(code, error.what),
        }
    }
}
