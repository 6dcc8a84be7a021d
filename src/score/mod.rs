//! The score: the patterns of a patch unrolled in time, as lazily as they are asked for.
//!
//! Every playing of a pattern is a cursor that walks the pattern's events, which are sorted once and shared; the cursors
//! stand in a heap by the time of what they play next. So a repetition without end, a million events or a file longer than
//! memory cost what is sounding, not what there is. What happens where is a function of the patch, the roots and the
//! seed alone: every draw is named by the playing, the event and the repetition it is for.

mod book;
mod entry;
mod keys;
mod length;
mod playing;
mod sheet;
#[cfg(test)]
mod tests;
mod unroll;
mod walk;

use std::sync::Arc;

use crate::patch::{Event, Patch, Place};
use crate::space::array::Array;
use crate::space::spot::Spot;
use crate::text::Problem;

pub use crate::graph::start::FIELDS;

/// Seconds after which a score ends, come what may: some 31 years.
pub const HORIZON: f64 = 1e9;

/// How deep patterns may play patterns.
pub const MOST_DEEP: u32 = 64;

/// How many things may be under way at once: playings, repeated events, events that jitter or a delay holds back.
pub const MOST_AT_ONCE: usize = 1 << 21;

/// The most events of a file that are held in memory. A longer file is read anew by every playing, through a window of so
/// many: it cannot be shuffled, and no line of it may stand more than so many lines behind one with a later `at`.
pub const MOST_HELD: usize = 1 << 16;

/// The events of a file, in the order of its lines. Its problems should name file and line: they come out as they are, at
/// the place where the patch names the file, after what stands before them if the file is long, else when it is opened.
pub type EventStream<'a> = Box<dyn Iterator<Item = Result<Event, Problem>> + Send + 'a>;

/// Finds where the places of a patch are.
pub trait Places {
    /// The output for a place; of nothing it is asked for the rig's first tactor.
    ///
    /// # Errors
    /// What the rig lacks.
    fn spot(&mut self, place: Option<&Place>) -> Result<Spot, Problem>;

    /// The tactors that share points, which say where a stroke passes between them; `None`: then a stroke is one burst as long as all of it.
    fn array(&self) -> Option<&Array> {
        None
    }
}

impl<F: FnMut(Option<&Place>) -> Result<Spot, Problem>> Places for F {
    fn spot(&mut self, place: Option<&Place>) -> Result<Spot, Problem> {
        self(place)
    }
}

/// What happens, and when.
#[derive(Debug, Clone, PartialEq)]
pub struct Timed {
    /// Seconds, from 0 to [`HORIZON`].
    pub at: f64,
    /// Its serial number in the score, from 0.
    pub id: u64,
    /// Which of the score's roots it comes from, from 0.
    pub root: usize,
    /// The pattern it comes from, by its place in [`Patch::patterns`].
    pub pattern: usize,
    /// Which of that pattern's events it is, from 0, in the order of the file. In a shuffled pattern, the event that landed
    /// here.
    pub event: u64,
    /// Which of the alternatives of a `choose` was drawn, from 0.
    pub drawn: Option<u32>,
    /// What happens.
    pub what: What,
}

/// What happens.
#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// A voice sounds.
    Play(Note),
    /// A name goes into the log, and a pulse to trigger outputs.
    Marker(Arc<str>),
}

/// How a voice sounds.
#[derive(Debug, Clone, PartialEq)]
pub struct Note {
    /// The voice, by its place in [`Patch::voices`].
    pub voice: usize,
    /// Level: the event's or the voice's, times the gains of all patterns around it. Finite.
    pub level: f64,
    /// Decibels above the threshold that the level multiplies; `None`: by its level alone.
    pub felt: Option<f64>,
    /// Seconds from onset to release, from 0 to [`HORIZON`].
    pub duration: f64,
    /// Where, as the resolver of places said.
    pub place: Spot,
    /// The voice's own fields in its order, defaults filled in; 0 past the last.
    pub own: [f64; FIELDS],
}

/// A pattern that a score begins with.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Root {
    /// Which, by its place in [`Patch::patterns`].
    pub pattern: usize,
    /// When it starts, in seconds.
    pub at: f64,
    /// Multiplies the level of all it plays; 0 to 100.
    pub gain: f64,
    /// 2 is twice as fast; 0.001 to 1000.
    pub rate: f64,
}

impl Root {
    /// A pattern as it is, from a time in seconds on.
    pub fn at(pattern: usize, at: f64) -> Self {
        Self { pattern, at, gain: 1.0, rate: 1.0 }
    }
}

/// The patterns of a patch, unrolled.
///
/// It gives what happens in order of time. At the same instant, what stands first in the file comes first, what a nested
/// pattern plays comes where it is played, and an earlier repetition comes before a later one. After an error, the pattern of its beginning that
/// it is of has ended; others go on.
pub struct Score<'a>(unroll::Unroll<'a>);

impl<'a> Score<'a> {
    /// Of the patterns `roots` (by their place in [`Patch::patterns`]), each from its start in seconds.
    ///
    /// `places` finds the output for a place. `files` opens an events
    /// file by its path as written in the patch, and may be called again for every playing.
    /// Both are called while the score is read, where an events file says so.
    ///
    /// # Errors
    /// A number that cannot be played, a name that nothing has, a pattern that contains itself, patterns nested deeper than
    /// [`MOST_DEEP`].
    pub fn new(
        patch: &Patch,
        places: impl FnMut(Option<&Place>) -> Result<Spot, Problem> + Send + 'a,
        roots: &[(usize, f64)],
        seed: u64,
        files: impl FnMut(&str) -> Result<EventStream<'a>, Problem> + Send + 'a,
    ) -> Result<Self, Problem> {
        let roots: Vec<Root> = roots.iter().map(|&(pattern, at)| Root::at(pattern, at)).collect();
        Self::of(patch, places, &roots, seed, files)
    }

    /// The same, each pattern with its gain and rate.
    ///
    /// # Errors
    /// As [`Score::new`].
    pub fn of(
        patch: &Patch,
        places: impl Places + Send + 'a,
        roots: &[Root],
        seed: u64,
        files: impl FnMut(&str) -> Result<EventStream<'a>, Problem> + Send + 'a,
    ) -> Result<Self, Problem> {
        let book = book::Book::new(patch, roots, Box::new(places), Box::new(files))?;
        Ok(Self(unroll::Unroll::new(book, roots, seed)?))
    }

    /// As its iterator, but in no more than so many steps, which are taken off: repetitions that play nothing, and what is drawn and put in order. A step
    /// takes about a microsecond, and millions may lead to nothing.
    ///
    /// # Errors
    /// What cannot be played.
    pub fn next_within(&mut self, steps: &mut usize) -> Result<Next, Problem> {
        self.0.next(steps)
    }

    /// Seconds until the last event has ended, where that is known beforehand: `None` for what repeats without end, comes
    /// from a file, or depends on draws.
    pub fn length(&self) -> Option<f64> {
        self.0.length()
    }

    /// Whether something was left out so far because it lies past the [`HORIZON`].
    pub fn cut(&self) -> bool {
        self.0.cut
    }

    /// Whether a root, by its number, has something left to play.
    pub fn plays(&self, root: usize) -> bool {
        self.0.plays(root)
    }

    /// Plays no more of a root, by its number. All others play as they would have, under other serial numbers.
    pub fn stop(&mut self, root: usize) {
        self.0.stop(root);
    }

    /// How many things are under way; memory grows with it and with nothing else.
    #[cfg(test)]
    fn under_way(&self) -> usize {
        self.0.under_way()
    }
}

impl Iterator for Score<'_> {
    type Item = Result<Timed, Problem>;

    fn next(&mut self) -> Option<Self::Item> {
        let mut all = usize::MAX;
        match self.next_within(&mut all) {
            Ok(Next::Happens(timed)) => Some(Ok(timed)),
            Ok(Next::Over | Next::NotYet) => None,
            Err(problem) => Some(Err(problem)),
        }
    }
}

/// What a score says next.
#[derive(Debug, Clone, PartialEq)]
pub enum Next {
    /// This happens.
    Happens(Timed),
    /// Nothing more.
    Over,
    /// Nothing as far as it was looked.
    NotYet,
}
