//! What the thread has computed, counted: a test of cost that no busy machine can fail.

use std::cell::Cell;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Work {
    /// Points of the unit circle at which an edge was looked for.
    pub points: u64,
    /// The most eigenvalues that were computed at once.
    pub eigenvalues: usize,
}

thread_local! {
    static DONE: Cell<Work> = Cell::default();
}

pub(crate) fn of<T>(task: impl FnOnce() -> T) -> (T, Work) {
    DONE.take();
    (task(), DONE.take())
}

pub(super) fn point() {
    DONE.set(Work { points: DONE.get().points + 1, ..DONE.get() });
}

pub(super) fn eigenvalues(count: usize) {
    DONE.set(Work { eigenvalues: DONE.get().eigenvalues.max(count), ..DONE.get() });
}
