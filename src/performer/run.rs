//! A pattern that plays.

use crate::score::{Root, Score, Timed};
use crate::text::Problem;

/// A score that plays, and what it says next.
pub(super) struct Run {
    /// 0 for what plays from the beginning; then as they were started.
    pub serial: u64,
    /// What was started; `None` for what plays from the beginning.
    pub root: Option<Root>,
    /// Where it follows a clock: the beat with which it begins, and its own beats a second.
    pub follows: Option<(f64, f64)>,
    score: Score<'static>,
    ahead: Option<Timed>,
    over: bool,
}

impl Run {
    pub fn new(serial: u64, root: Option<Root>, score: Score<'static>) -> Self {
        Self { serial, root, follows: None, score, ahead: None, over: false }
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

    /// Whether something of it lies past the horizon.
    pub fn is_cut(&self) -> bool {
        self.score.cut()
    }

    /// Its length, where that is known beforehand.
    pub fn length(&self) -> Option<f64> {
        self.score.length()
    }
}
