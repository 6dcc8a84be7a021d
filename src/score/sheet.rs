//! A sheet: a pattern with its names resolved and its events sorted.

use std::sync::Arc;

use crate::patch::Repeat;
use crate::space::spot::Spot;
use crate::text::Span;

/// A pattern, ready to be played.
#[derive(Debug, Clone)]
pub(super) struct Sheet {
    /// The pattern's name.
    pub name: Arc<str>,
    /// Where it stands in the patch.
    pub span: Span,
    /// Seconds in one unit of its time at rate 1.
    pub unit: f64,
    /// Multiplies levels.
    pub gain: f64,
    /// Divides times.
    pub rate: f64,
    /// Again and again.
    pub repeat: Option<Repeat>,
    /// Whether events change places.
    pub shuffle: bool,
    /// Random deviations; `None` where there are none at all.
    pub jitter: Option<Deviations>,
    /// Its events.
    pub content: Content,
    /// Whether it ever plays anything.
    pub barren: bool,
    /// Seconds until its last event has ended, played at rate 1; `None` where that is not known.
    pub length: Option<f64>,
}

/// Random deviations.
#[derive(Debug, Clone)]
pub(super) struct Deviations {
    /// Of onsets, to either side, in the pattern's time.
    pub at: f64,
    /// Of fields, as a share.
    pub fractions: Arc<[(String, f64)]>,
}

/// Where events are.
#[derive(Debug, Clone)]
pub(super) enum Content {
    /// Here, in order.
    Held(Arc<Vec<Item>>),
    /// In a file.
    File {
        /// Its path as written.
        path: Arc<str>,
        /// Where that stands.
        span: Span,
        /// Whether it is known to be too long to hold.
        long: bool,
    },
}

/// An event.
#[derive(Debug, Clone)]
pub(super) struct Item {
    /// When, in the pattern's time.
    pub at: f64,
    /// Added to it.
    pub delay: f64,
    /// Several times.
    pub repeat: Option<Box<Repeat>>,
    /// Its place in the file, from 0.
    pub number: u64,
    /// What happens.
    pub deed: Deed,
}

impl Item {
    /// How often it happens.
    pub fn times(&self) -> u64 {
        self.repeat.as_ref().map_or(1, |r| r.times.unwrap_or(u64::MAX))
    }
    /// How long after the first time the `k`th is, in the pattern's time.
    pub fn later(&self, k: u64) -> f64 {
        self.repeat.as_ref().map_or(0.0, |r| k as f64 * r.every)
    }
    /// The `k`th onset without any deviation, in the pattern's time, where the event has landed at `at`.
    pub fn onset(&self, at: f64, k: u64) -> f64 {
        at + self.delay + self.later(k)
    }
}

/// What happens.
#[derive(Debug, Clone)]
pub(super) enum Deed {
    /// A voice sounds.
    Play(Play),
    /// It sounds in several bursts.
    Motion(Arc<[Burst]>),
    /// A pattern plays.
    Pattern(Nested),
    /// A name goes into the log.
    Marker(Arc<str>),
    /// One of several: each with the sum of the weights up to it.
    Choose(Box<[(f64, Deed)]>),
}

/// One of several times that a voice sounds in one event.
#[derive(Debug, Clone)]
pub(super) struct Burst {
    /// When, after the event, in the pattern's time; none is before the one that comes before it.
    pub start: f64,
    /// How.
    pub play: Play,
}

/// A voice sounds.
#[derive(Debug, Clone)]
pub(super) struct Play {
    /// The voice, by its place in the patch.
    pub voice: u32,
    /// Where.
    pub place: Spot,
    /// Level.
    pub level: f64,
    /// Decibels above the threshold in place of that; `None`: by its level.
    pub felt: Option<f64>,
    /// Duration in the pattern's time.
    pub duration: f64,
    /// Fields that differ from the voice's defaults, by their place among them.
    pub own: Box<[(u8, f64)]>,
}

/// A pattern plays.
#[derive(Debug, Clone)]
pub(super) struct Nested {
    /// The pattern, by its place in the patch.
    pub sheet: usize,
    /// Multiplies levels.
    pub gain: f64,
    /// Divides times.
    pub rate: f64,
}

impl Sheet {
    /// How often it plays in all.
    pub fn rounds(&self) -> u64 {
        self.repeat.map_or(1, |r| r.times.unwrap_or(u64::MAX))
    }
    /// How far onsets may move, in the pattern's time.
    pub fn spread(&self) -> f64 {
        self.jitter.as_ref().map_or(0.0, |j| j.at)
    }
    /// Puts events in the order in which they are walked: by onset, where that stands before it is played, else by `at`.
    pub fn sort(&self, items: &mut [Item]) {
        if self.shuffle || self.spread() > 0.0 {
            items.sort_by(|a, b| a.at.total_cmp(&b.at));
        } else {
            items.sort_by(|a, b| (a.at + a.delay).total_cmp(&(b.at + b.delay)));
        }
    }
}
