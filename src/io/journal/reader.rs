//! Reads a journal, line by line.

use std::fs::File;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use serde::Deserialize;

use super::head::{FORMAT, Head, PlanHead};
use super::line::Line;
use crate::io::error::{FileError, FileErrorKind};
use crate::io::open;
use crate::text::problem::shown;

/// What a journal is made of.
#[derive(Debug, Clone, PartialEq)]
pub enum Item {
    /// What the session was.
    Session(Box<Head>),
    /// What was played from there on, after the first from the next [`super::Kind::Swap`] on.
    Plan(Box<PlanHead>),
    /// Anything else.
    Line(Box<Line>),
}

/// Bytes of a line at most: a plan has the whole text of its patch.
const LONGEST: u64 = 64 << 20;

/// A journal being read, in either form.
#[derive(Debug)]
pub struct Reader<R> {
    input: R,
    name: String,
    number: u64,
    line: Vec<u8>,
    columns: Option<Vec<String>>,
}

impl Reader<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// One that cannot be read.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let file = open::open(path)?;
        Ok(Self::new(BufReader::with_capacity(1 << 16, file), &path.display().to_string()))
    }
}

impl<R: BufRead> Reader<R> {
    /// Reads what is called `name` in errors.
    pub fn new(input: R, name: &str) -> Self {
        Self { input, name: name.into(), number: 0, line: Vec::new(), columns: None }
    }

    /// An error of the line that was read last, with what to do about it.
    pub fn wrong(&self, what: &str) -> FileError {
        FileError::new(FileErrorKind::Malformed, format!("{}:{}: {}", self.name, self.number, shown(what)))
    }

    /// An error of the line that was read last, which no session can have written.
    pub fn unwritten(&self, what: &str) -> FileError {
        self.wrong(&format!("{what}; no session writes that: play the journal as it was written"))
    }

    /// What comes next; `None` at the end. A last line that breaks off is passed over.
    ///
    /// # Errors
    /// What cannot be read, and what is no journal.
    pub fn read(&mut self) -> Result<Option<Item>, FileError> {
        loop {
            self.line.clear();
            let mut limited = (&mut self.input).take(LONGEST);
            let read = limited
                .read_until(b'\n', &mut self.line)
                .map_err(|error| FileError::reading(Path::new(&self.name), &error))?;
            if read == 0 {
                return match self.number {
                    0 => Err(FileError::new(
                        FileErrorKind::Malformed,
                        format!("`{}` is empty, so it is no journal", self.name),
                    )),
                    _ => Ok(None),
                };
            }
            self.number += 1;
            if self.line.last() != Some(&b'\n') {
                if read as u64 == LONGEST {
                    return Err(self.unwritten("the line is longer than any that a journal has"));
                }
                if self.number > 1 {
                    return Ok(None);
                }
            }
            let text = std::str::from_utf8(&self.line).map_err(|_| self.unwritten("this is no text"))?;
            let text = text.trim();
            if text.is_empty() {
                continue;
            }
            let item = match (text.strip_prefix('#').map(str::trim_start), text.starts_with('{')) {
                (Some(json), _) => object(json),
                (None, true) => object(text),
                (None, false) if self.number == 1 => Err(no_journal()),
                (None, false) => match row(text) {
                    Err(what) => Err(what),
                    Ok(cells) => match &self.columns {
                        None if cells.iter().any(|cell| cell == "kind") => {
                            self.columns = Some(cells);
                            continue;
                        }
                        None => Err("there is no column `kind`".into()),
                        Some(columns) => {
                            let of = |column: &str| columns.iter().position(|known| known == column);
                            let cell =
                                |column: &str| of(column).and_then(|at| cells.get(at)).map(String::as_str);
                            Line::of_cells(cell).map(|line| Item::Line(Box::new(line)))
                        }
                    },
                },
            };
            if self.number == 1 && !matches!(&item, Ok(Item::Session(_))) {
                let what = other_format(text).unwrap_or_else(no_journal);
                return Err(self.wrong(&what));
            }
            return item.map(Some).map_err(|what| self.unwritten(&what));
        }
    }
}

fn no_journal() -> String {
    "this is no journal of a session: pacinian play --events FILE writes one".into()
}

/// What a first line is told that says that it is of another format.
fn other_format(line: &str) -> Option<String> {
    #[derive(Deserialize)]
    struct Tag {
        format: String,
    }
    let json = line.trim_start_matches('#');
    let Tag { format } = serde_json::from_str(json).ok()?;
    (format != FORMAT).then(|| format!("it has the format `{format}`; this program reads `{FORMAT}`"))
}

fn object(json: &str) -> Result<Item, String> {
    #[derive(Deserialize)]
    struct Tag {
        kind: String,
    }
    fn read<'a, T: Deserialize<'a>>(json: &'a str) -> Result<Box<T>, String> {
        serde_json::from_str(json).map(Box::new).map_err(|error| {
            // It counts lines from where it began, which was here.
            let (text, column) = (error.to_string(), error.column());
            let what = text.split(" at line ").next().unwrap_or(&text);
            format!("{what}, at character {column}")
        })
    }
    match read::<Tag>(json)?.kind.as_str() {
        "session" => {
            let head: Box<Head> = read(json)?;
            if head.format == FORMAT { Ok(Item::Session(head)) } else { Err(no_journal()) }
        }
        "plan" => read(json).map(Item::Plan),
        _ => read(json).map(Item::Line),
    }
}

/// The cells of a line of a table (RFC 4180).
fn row(text: &str) -> Result<Vec<String>, String> {
    let mut table = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(text.as_bytes());
    match table.records().next() {
        Some(Ok(record)) => Ok(record.iter().map(String::from).collect()),
        Some(Err(error)) => Err(error.to_string()),
        None => Err("there are no cells".into()),
    }
}
