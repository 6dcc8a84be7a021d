//! A pattern that plays.

use crate::score::{Root, Score, Timed};
use crate::text::Problem;

/// A score that plays, and what it says next.
pub(super) struct Run {
    /// 0 for what plays from the beginning; then as they were started.
    pub serial: u64,
    /// What was started: one pattern, or all that play from the beginning.
    pub roots: Vec<Root>,
    /// Where it follows a clock: the beat with which it begins, and its own beats a second.
    pub follows: Option<(f64, f64)>,
    score: Score<'static>,
    ahead: Option<Timed>,
    over: bool,
}

impl Run {
    pub fn new(serial: u64, roots: Vec<Root>, score: Score<'static>) -> Self {
        Self { serial, roots, follows: None, score, ahead: None, over: false }
    }

    /// The same, counted by a clock: it begins with `beat`, and has itself so many `beats` a second.
    pub fn following(self, beat: f64, beats: f64) -> Self {
        Self { follows: Some((beat, beats)), ..self }
    }

    /// When it says something next, by its own count; `None` when it has ended.
    pub fn next(&mut self) -> Result<Option<f64>, Problem> {
        if self.ahead.is_none() && !self.over {
            self.ahead = self.score.next().transpose().inspect_err(|_| self.over = true)?;
            self.over = self.ahead.is_none();
        }
        Ok(self.ahead.as_ref().map(|timed| timed.at))
    }

    /// What it says next.
    pub fn take(&mut self) -> Option<Timed> {
        self.ahead.take()
    }

    /// The patterns of it that still play, by their places in the patch.
    pub fn playing(&self) -> impl Iterator<Item = usize> {
        let plays = |number: usize| {
            self.score.plays(number) || self.ahead.as_ref().is_some_and(|timed| timed.root == number)
        };
        self.roots.iter().enumerate().filter(move |(number, _)| plays(*number)).map(|(_, root)| root.pattern)
    }

    /// Plays no more of a pattern that it began with.
    pub fn stop(&mut self, pattern: usize) {
        for number in (0..self.roots.len()).filter(|number| self.roots[*number].pattern == pattern) {
            self.score.stop(number);
            self.ahead.take_if(|timed| timed.root == number);
        }
    }

    /// Whether something of it lies past the horizon.
    pub fn is_cut(&self) -> bool {
        self.score.cut()
    }

    /// Its length, where that is known beforehand.
    pub fn length(&self) -> Option<f64> {
        self.score.length()
    }
}
