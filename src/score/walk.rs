//! A walk through the events of one playing, in order.

use std::sync::Arc;
use std::vec;

use super::book::Book;
use super::entry::Which;
use super::playing::Playing;
use super::sheet::{Content, Item, Sheet};
use super::{EventStream, MOST_HELD, keys};
use crate::text::{Problem, Span};

/// A walk through the events of one playing. It stands before an event, or is over.
pub(super) struct Walk<'a> {
    source: Source<'a>,
}

enum Source<'a> {
    /// Events that a sheet holds.
    Held { slot: usize, permuted: Option<Box<[u32]>> },
    /// A long file.
    File(Box<Lines<'a>>),
}

/// The event before which a walk stands.
pub(super) struct Ahead {
    /// Its place in the file.
    pub number: u64,
    /// In the pattern's time: when it happens, or, if that has yet to be drawn, before when it does not.
    pub time: f64,
    /// Whether `time` is when it happens.
    pub exact: bool,
}

impl<'a> Walk<'a> {
    /// Of a playing, from its first event. Reads a file's beginning, or all of it.
    pub fn new(book: &mut Book<'a>, playing: &Playing) -> Result<Self, Problem> {
        let mut file = None;
        if let Content::File { path, span, long } = &book.sheet(playing.sheet)?.content {
            file = Some(((path.clone(), span.clone()), *long));
        }
        if let Some(((path, span), long)) = file {
            let mut lines = Lines::open(book, path, span)?;
            let mut items = Vec::new();
            while !long && items.len() <= MOST_HELD {
                match lines.take(book)? {
                    Some(item) => items.push(item),
                    None => break,
                }
            }
            if long || items.len() > MOST_HELD {
                let sheet = book.sheet(playing.sheet)?;
                if sheet.shuffle {
                    let what = format!(
                        "pattern `{}` cannot shuffle more than {MOST_HELD} events of a file",
                        sheet.name
                    );
                    return Err(Problem::error(&sheet.span, what)
                        .help("split the file, or shuffle in it".to_string()));
                }
                if !long {
                    let content =
                        Content::File { path: lines.path.clone(), span: lines.span.clone(), long: true };
                    book.learn(playing.sheet, content);
                }
                lines.begin = items.into_iter();
                lines.step(book);
                return Ok(Self { source: Source::File(Box::new(lines)) });
            }
            book.sheet(playing.sheet)?.sort(&mut items);
            book.learn(playing.sheet, Content::Held(Arc::new(items)));
        }
        let sheet = book.sheet(playing.sheet)?;
        let permuted = match &sheet.content {
            Content::Held(items) if sheet.shuffle => Some(keys::permutation(playing.key, items.len())),
            _ => None,
        };
        Ok(Self { source: Source::Held { slot: 0, permuted } })
    }

    /// How many numbers it holds beside its place.
    pub fn holds(&self) -> usize {
        match &self.source {
            Source::Held { permuted: Some(all), .. } => all.len(),
            Source::Held { .. } | Source::File(_) => 0,
        }
    }

    /// The next event; `None` when it is over.
    pub fn ahead(&self, sheet: &Sheet) -> Option<Ahead> {
        let (at, item) = match (&self.source, &sheet.content) {
            (Source::Held { slot, permuted }, Content::Held(items)) => {
                let landed = permuted.as_ref().map_or(Some(*slot), |p| p.get(*slot).map(|i| *i as usize))?;
                (items.get(*slot)?.at, items.get(landed)?)
            }
            (Source::File(lines), _) => match lines.next.as_ref()? {
                Ok(item) => (item.at, item),
                // It comes up where it stands among the lines.
                Err(_) => {
                    let time = (lines.last - sheet.spread()).max(0.0);
                    return Some(Ahead { number: lines.read, time, exact: false });
                }
            },
            (Source::Held { .. }, Content::File { .. }) => return None,
        };
        let spread = sheet.spread();
        let sorted_by_onset = !sheet.shuffle && matches!(self.source, Source::Held { .. });
        let exact = spread == 0.0 && !sheet.shuffle && (sorted_by_onset || item.delay == 0.0);
        let time = if exact { item.onset(at, 0) } else { (at - spread).max(0.0) };
        Some(Ahead { number: item.number, time, exact })
    }

    /// Takes the next event, with the `at` on which it lands, and goes on.
    pub fn take(&mut self, book: &mut Book<'a>, playing: &Playing) -> Result<Option<(Which, f64)>, Problem> {
        match &mut self.source {
            Source::Held { slot, permuted } => {
                let Content::Held(items) = &book.sheet(playing.sheet)?.content else { return Ok(None) };
                let landed = permuted.as_ref().map_or(Some(*slot), |p| p.get(*slot).map(|i| *i as usize));
                let (Some(item), Some(landed)) = (items.get(*slot), landed) else { return Ok(None) };
                *slot += 1;
                Ok(Some((Which::Held(landed), item.at)))
            }
            Source::File(lines) => {
                let Some(item) = lines.next.take().transpose()? else { return Ok(None) };
                lines.step(book);
                let at = item.at;
                Ok(Some((Which::Read(Arc::new(item)), at)))
            }
        }
    }
}

/// Events of a file, one at a time, in order of `at`.
struct Lines<'a> {
    path: Arc<str>,
    span: Span,
    /// What was read before.
    begin: vec::IntoIter<Item>,
    rest: EventStream<'a>,
    read: u64,
    last: f64,
    next: Option<Result<Item, Problem>>,
}

impl<'a> Lines<'a> {
    fn open(book: &mut Book<'a>, path: Arc<str>, span: Span) -> Result<Self, Problem> {
        let named =
            |p: Problem| Problem { span: Some(span.clone()), what: format!("{path}: {}", p.what), ..p };
        let rest = book.open(&path).map_err(named)?;
        Ok(Self { path, span, begin: Vec::new().into_iter(), rest, read: 0, last: 0.0, next: None })
    }

    /// Reads `next`.
    fn step(&mut self, book: &mut Book<'a>) {
        self.next = match self.begin.next() {
            Some(item) => Some(Ok(item)),
            None => self.take(book).transpose(),
        };
    }

    /// The next event that is not barren.
    fn take(&mut self, book: &mut Book<'a>) -> Result<Option<Item>, Problem> {
        loop {
            let Some(event) = self.rest.next() else { return Ok(None) };
            let number = self.read;
            self.read += 1;
            let item = event.and_then(|event| book.item(&event, number)).map_err(|p| self.at(number, p))?;
            if item.at < self.last {
                let what = format!("`at` is {} after {}", item.at, self.last);
                let help = "sort the lines by `at`; what shall come later can say so by `delay`";
                return Err(self.at(number, Problem::of_file(what).help(help.to_string())));
            }
            self.last = item.at;
            if !book.is_barren(&item.deed) {
                return Ok(Some(item));
            }
        }
    }

    /// The same problem, with the event named, at the place in the patch that names the file.
    fn at(&self, number: u64, problem: Problem) -> Problem {
        let what = format!("{}, event {}: {}", self.path, number + 1, problem.what);
        Problem { span: Some(self.span.clone()), what, ..problem }
    }
}
