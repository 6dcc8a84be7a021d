//! What stands in the heap: something to do at a time.

use std::cmp::Ordering;
use std::sync::Arc;

use super::playing::{Leaf, Playing, order};
use super::sheet::{Burst, Item};
use super::walk::Walk;

/// An event: one of those that a sheet holds, or one from a long file.
#[derive(Debug, Clone)]
pub(super) enum Which {
    /// By its place in the sheet.
    Held(usize),
    /// Itself.
    Read(Arc<Item>),
}

/// What is to be done.
pub(super) enum Task<'a> {
    /// A round of a pattern begins, and the next one is put on the heap.
    Round,
    /// A walk's next event: it happens now if `exact`, else it may happen from now on.
    Walk { walk: Box<Walk<'a>>, exact: bool },
    /// An event's repetition may happen from now on; its onset has yet to be drawn. The slot's `at` goes with it.
    Draw { which: Which, at: f64 },
    /// An event happens. The slot's `at` goes with it.
    Happen { which: Which, at: f64 },
    /// A burst of an event sounds.
    Burst(Bursts),
}

impl Task<'_> {
    /// Numbers of permutations that it holds.
    pub fn holds(&self) -> usize {
        match self {
            Self::Walk { walk, .. } => walk.holds(),
            _ => 0,
        }
    }
}

/// What is left of the bursts of an event.
pub(super) struct Bursts {
    pub list: Arc<[Burst]>,
    /// Which is next.
    pub next: usize,
    /// Seconds: when the event happened.
    pub begin: f64,
    /// Which of the alternatives of a choice it was.
    pub drawn: Option<u32>,
}

/// Something to do at a time.
pub(super) struct Entry<'a> {
    /// Seconds.
    pub time: f64,
    /// In which playing.
    pub playing: Arc<Playing>,
    /// With which of its events; `None`: with the playing itself.
    pub leaf: Option<Leaf>,
    /// What.
    pub task: Task<'a>,
}

impl Entry<'_> {
    /// What only prepares goes before all that happens at its time.
    fn happens(&self) -> bool {
        match self.task {
            Task::Round | Task::Happen { .. } | Task::Burst(_) | Task::Walk { exact: true, .. } => true,
            Task::Draw { .. } | Task::Walk { exact: false, .. } => false,
        }
    }
}

/// The greatest entry is the one to do first.
impl Ord for Entry<'_> {
    fn cmp(&self, other: &Self) -> Ordering {
        let earlier = other.time.total_cmp(&self.time).then_with(|| other.happens().cmp(&self.happens()));
        earlier.then_with(|| order((&other.playing, other.leaf), (&self.playing, self.leaf)))
    }
}

impl PartialOrd for Entry<'_> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Entry<'_> {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Entry<'_> {}
