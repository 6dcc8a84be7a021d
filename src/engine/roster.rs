//! The periodic tasks of an engine: which are due, which rest, and what each has cost.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::task::{Task, Values};

/// What is known of a task, for any thread.
#[derive(Debug)]
pub struct Duty {
    name: String,
    cost: f64,
    rank: u8,
    runs: AtomicU64,
    skipped: AtomicU64,
    overruns: AtomicU64,
    /// Picoseconds.
    longest: AtomicU64,
    resting: AtomicBool,
}

impl Duty {
    /// Of work of this name, which says that a run takes so many seconds, and rests in the turn of its rank (see [`Task`]).
    pub(crate) fn new(name: &str, cost: f64, rank: u8) -> Self {
        Self {
            name: name.into(),
            cost,
            rank,
            runs: AtomicU64::new(0),
            skipped: AtomicU64::new(0),
            overruns: AtomicU64::new(0),
            longest: AtomicU64::new(0),
            resting: AtomicBool::new(false),
        }
    }

    /// Does `work`, which is so many runs in a row, and counts them; by a clock that gives nanoseconds, how long a run took on average, too.
    #[inline]
    pub(crate) fn timed(&self, runs: u64, clock: Option<fn() -> u64>, work: impl FnOnce()) {
        let begin = clock.map(|clock| clock());
        work();
        self.runs.fetch_add(runs, Ordering::Relaxed);
        if let (Some(begin), Some(clock)) = (begin, clock) {
            let taken = clock().saturating_sub(begin).saturating_mul(1000) / runs.max(1);
            self.longest.fetch_max(taken, Ordering::Relaxed);
            let over = self.cost > 0.0 && taken as f64 * 1e-12 > self.cost;
            self.overruns.fetch_add(u64::from(over), Ordering::Relaxed);
        }
    }

    /// It was due, and rested.
    pub(crate) fn skip(&self, runs: u64) {
        self.skipped.fetch_add(runs, Ordering::Relaxed);
    }

    /// It rests from here on, or runs again.
    pub(crate) fn rest(&self, rests: bool) {
        self.resting.store(rests, Ordering::Relaxed);
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Seconds that a run may take, as the task says; 0 where it says nothing.
    pub fn cost(&self) -> f64 {
        self.cost
    }

    /// How soon it rests when there is too much to do, see [`Task::rank`].
    pub fn rank(&self) -> u8 {
        self.rank
    }

    /// How often it ran.
    pub fn runs(&self) -> u64 {
        self.runs.load(Ordering::Relaxed)
    }

    /// How often it was due while it rested.
    pub fn skipped(&self) -> u64 {
        self.skipped.load(Ordering::Relaxed)
    }

    /// How often it took longer than it says. Counted where the engine has a clock: [`super::Engine::time_tasks`].
    pub fn overruns(&self) -> u64 {
        self.overruns.load(Ordering::Relaxed)
    }

    /// Seconds of its longest run, where the engine has a clock.
    pub fn longest(&self) -> f64 {
        self.longest.load(Ordering::Relaxed) as f64 * 1e-12
    }

    /// Whether it rests.
    pub fn is_resting(&self) -> bool {
        self.resting.load(Ordering::Relaxed)
    }
}

struct Entry {
    task: Box<dyn Task>,
    duty: Arc<Duty>,
    resting: bool,
}

/// The tasks of an engine, in the order in which they were added, which is that of their runs at the same sample.
#[derive(Default)]
pub(crate) struct Roster {
    entries: Vec<Entry>,
    /// Gives nanoseconds.
    clock: Option<fn() -> u64>,
}

impl Roster {
    /// Adds a task; not for the audio thread.
    pub fn add(&mut self, task: Box<dyn Task>) -> Arc<Duty> {
        let duty = Arc::new(Duty::new(task.name(), task.cost(), task.rank()));
        self.entries.push(Entry { task, duty: Arc::clone(&duty), resting: false });
        duty
    }

    /// Times every run from now on.
    pub fn time(&mut self, clock: fn() -> u64) {
        self.clock = Some(clock);
    }

    /// The next sample at or after `clock` before which one runs.
    pub fn next(&self, clock: u64) -> u64 {
        self.entries.iter().map(|entry| entry.task.beat().next(clock)).min().unwrap_or(u64::MAX)
    }

    /// Runs those that are due before sample `clock`.
    pub fn run(&mut self, clock: u64, values: &mut dyn Values) {
        for Entry { task, duty, resting } in &mut self.entries {
            if !task.beat().is_due(clock) {
                continue;
            }
            match *resting {
                true => duty.skip(1),
                false => duty.timed(1, self.clock, || task.run(values)),
            }
        }
    }

    /// Lets those above a rank rest, and the others run.
    pub fn shed(&mut self, above: u8) {
        for Entry { task, duty, resting } in &mut self.entries {
            let rests = duty.rank > above;
            if rests != std::mem::replace(resting, rests) {
                duty.rest(rests);
                task.rest(rests);
            }
        }
    }

    /// The highest rank below `rank` that a task has, if it is not 0, which never rests.
    pub fn rank_below(&self, rank: u16) -> Option<u8> {
        let ranks = self.entries.iter().map(|entry| entry.duty.rank);
        ranks.filter(|r| u16::from(*r) < rank && *r > 0).max()
    }

    /// The lowest rank above `rank` that a task has.
    pub fn rank_above(&self, rank: u8) -> Option<u8> {
        self.entries.iter().map(|entry| entry.duty.rank).filter(|r| *r > rank).min()
    }
}
