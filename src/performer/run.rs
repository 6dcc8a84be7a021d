//! A pattern that plays.

use crate::score::{Root, Score, Timed};
use crate::text::Problem;

/// A score that plays, and what it says next.
pub(super) struct Run {
    /// 0 for what plays from the beginning; then as they were started.
    pub serial: u64,
    /// What was started; `None` for what plays from the beginning.
    pub root: Option<Root>,
    score: Score<'static>,
    ahead: Option<Timed>,
    over: bool,
}

impl Run {
    pub fn new(serial: u64, root: Option<Root>, score: Score<'static>) -> Self {
        Self { serial, root, score, ahead: None, over: false }
    }

    /// When it says something next; `None` when it has ended.
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
