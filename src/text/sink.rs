//! Where problems of a file are gathered while it is read.

use std::cell::{Cell, RefCell};

use super::nearest::suggest;
use super::problem::{Problem, Problems, Span};

/// Collects problems. After [`Sink::MOST`] it only counts.
#[derive(Debug, Default)]
pub struct Sink {
    list: RefCell<Vec<Problem>>,
    further: Cell<usize>,
}

impl Sink {
    /// How many problems of one file are shown.
    pub const MOST: usize = 500;

    /// One more.
    pub fn push(&self, problem: Problem) {
        if self.is_full() {
            self.further.set(self.further.get() + 1);
        } else {
            self.list.borrow_mut().push(problem);
        }
    }
    /// An error at a place.
    pub(crate) fn error(&self, span: &Span, what: impl Into<String>) {
        self.push(Problem::error(span, what));
    }
    /// An error with advice.
    pub(crate) fn error_help(&self, span: &Span, what: impl Into<String>, help: &str) {
        self.push(Problem::error(span, what).help(help.to_string()));
    }
    /// A name that nothing has, with the nearest of those there are.
    pub(crate) fn unknown<'a>(
        &self,
        span: &Span,
        what: impl Into<String>,
        word: &str,
        names: impl IntoIterator<Item = &'a str>,
    ) {
        let help = if self.is_full() { None } else { suggest(word, names) };
        self.push(Problem::error(span, what).help(help));
    }
    /// Whether further problems are only counted.
    pub(crate) fn is_full(&self) -> bool {
        self.list.borrow().len() >= Self::MOST
    }
    /// All of them, by line.
    pub(crate) fn into_problems(self, file: &str, source: &str) -> Problems {
        let mut list = self.list.into_inner();
        if self.further.get() > 0 {
            list.push(Problem::error(
                &(source.len()..source.len()),
                format!("and {} more problems", self.further.get()),
            ));
        }
        let mut problems = Problems { file: file.into(), source: source.into(), list };
        problems.sort();
        problems
    }
}
