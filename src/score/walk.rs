//! A walk through the events of one playing, in order.

use std::cmp::Ordering;
use std::collections::BinaryHeap;
use std::sync::Arc;

use super::book::Book;
use super::entry::Which;
use super::playing::Playing;
use super::sheet::{Content, Item, Sheet};
use super::{EventStream, MOST_HELD, keys};
use crate::patch::Event;
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
    /// Of a playing, from its first event. Reads as much of a file as may be held.
    pub fn new(book: &mut Book<'a>, playing: &Playing) -> Result<Self, Problem> {
        let mut file = None;
        let sheet = book.sheet(playing.sheet)?;
        let unit = sheet.unit / sheet.rate;
        if let Content::File { path, span, long } = &sheet.content {
            file = Some((path.clone(), span.clone(), *long));
        }
        if let Some((path, span, long)) = file {
            let mut lines = Lines::open(book, path.clone(), span.clone(), unit)?;
            lines.fill(book);
            if long || lines.rest.is_some() {
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
                    book.learn(playing.sheet, Content::File { path, span, long: true });
                }
                return Ok(Self { source: Source::File(Box::new(lines)) });
            }
            if let Some(problem) = lines.failed {
                return Err(problem);
            }
            let mut items: Vec<Item> = lines.window.into_iter().map(|Early(item)| item).collect();
            items.sort_by_key(|item| item.number);
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

    /// How much memory it takes, in numbers of a permutation.
    pub fn holds(&self) -> usize {
        match &self.source {
            Source::Held { permuted: Some(all), .. } => all.len(),
            Source::Held { .. } => 0,
            Source::File(_) => NUMBERS_OF_AN_EVENT * MOST_HELD,
        }
    }

    /// The next event; `None` when it is over.
    pub fn ahead(&self, sheet: &Sheet) -> Option<Ahead> {
        let (at, item) = match (&self.source, &sheet.content) {
            (Source::Held { slot, permuted }, Content::Held(items)) => {
                let landed = permuted.as_ref().map_or(Some(*slot), |p| p.get(*slot).map(|i| *i as usize))?;
                (items.get(*slot)?.at, items.get(landed)?)
            }
            (Source::File(lines), _) => match (lines.window.peek(), &lines.failed) {
                (Some(Early(item)), _) => (item.at, item),
                // What stood before the bad line has been played.
                (None, Some(_)) => {
                    let time = (lines.last - sheet.spread()).max(0.0);
                    return Some(Ahead { number: lines.read, time, exact: false });
                }
                (None, None) => return None,
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
                let Some(Early(item)) = lines.window.pop() else {
                    return lines.failed.take().map_or(Ok(None), Err);
                };
                lines.last = item.at;
                lines.fill(book);
                let at = item.at;
                Ok(Some((Which::Read(Arc::new(item)), at)))
            }
        }
    }
}

/// How much memory an event takes, in that of a number of a permutation.
const NUMBERS_OF_AN_EVENT: usize = size_of::<Item>() / size_of::<u32>();

/// Events of a file in order of `at`, as far as that can be had within a window of [`MOST_HELD`] of them.
struct Lines<'a> {
    path: Arc<str>,
    span: Span,
    /// What has not been read; `None` at the end, and behind a bad line.
    rest: Option<EventStream<'a>>,
    /// What has been read and not been taken.
    window: BinaryHeap<Early>,
    /// How many have been read.
    read: u64,
    /// The `at` that was taken last.
    last: f64,
    /// Seconds in a unit of time of its pattern.
    unit: f64,
    /// What is wrong with the line behind all in the window.
    failed: Option<Problem>,
}

impl<'a> Lines<'a> {
    fn open(book: &mut Book<'a>, path: Arc<str>, span: Span, unit: f64) -> Result<Self, Problem> {
        let rest = book.open(&path).map_err(|p| Problem { span: Some(span.clone()), ..p })?;
        let window = BinaryHeap::new();
        Ok(Self { path, span, rest: Some(rest), window, read: 0, last: 0.0, unit, failed: None })
    }

    /// Reads until the window is full.
    fn fill(&mut self, book: &mut Book<'a>) {
        while let Some(rest) = self.rest.as_mut().filter(|_| self.window.len() <= MOST_HELD) {
            let Some(event) = rest.next() else {
                self.rest = None;
                return;
            };
            let event = event.map_err(|p| Problem { span: Some(self.span.clone()), ..p });
            match event.and_then(|event| self.item(book, &event)) {
                Ok(item) if book.is_barren(&item.deed) => {}
                Ok(item) => self.window.push(Early(item)),
                Err(problem) => {
                    self.failed = Some(problem);
                    self.rest = None;
                }
            }
            self.read += 1;
        }
    }

    fn item(&self, book: &mut Book<'a>, event: &Event) -> Result<Item, Problem> {
        // It stands in the patch where the file is named, since problems have no place in a file that is not at hand.
        let named = |p: Problem| {
            let what = format!("{}, event {}: {}", self.path, self.read + 1, p.what);
            Problem { span: Some(self.span.clone()), what, ..p }
        };
        let item = book.item(event, self.read, self.unit).map_err(named)?;
        if item.at < self.last {
            let what = format!("`at` is {}, but what is at {} has been played", item.at, self.last);
            let help = format!("sort the lines by `at`: none may come more than {MOST_HELD} lines late");
            return Err(named(Problem::of_file(what).help(help)));
        }
        Ok(item)
    }
}

/// An event; the greatest is the earliest, and among those the first in the file.
struct Early(Item);

impl Ord for Early {
    fn cmp(&self, other: &Self) -> Ordering {
        other.0.at.total_cmp(&self.0.at).then_with(|| other.0.number.cmp(&self.0.number))
    }
}

impl PartialOrd for Early {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Early {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Early {}
