//! A pattern that plays.

use super::whence::Whence;
use crate::score::{Next as Ahead, Root, Score, Timed};
use crate::text::Problem;

/// A score that plays, and what it says next.
pub(super) struct Run {
    /// 0 for what plays from the beginning; then as they were started.
    pub serial: u64,
    /// The run whose draws are drawn again: its own, but where a song goes on.
    pub draws: u64,
    /// Who started it.
    pub whence: Whence,
    /// The signal that started it; 0 for none.
    pub cause: u64,
    /// What was started: one pattern, or all that play from the beginning.
    pub roots: Vec<Root>,
    /// Where it follows a clock: the beat with which it begins, and its own beats a second.
    pub follows: Option<(f64, f64)>,
    /// When the last voice of each of the roots is released, seconds, as far as they have begun.
    pub ends: Vec<f64>,
    score: Score<'static>,
    ahead: Option<Timed>,
    /// What it would say before is left out, by its own count; `None` once it has come there.
    from: Option<f64>,
    /// Whether it has not come there at once.
    behind: bool,
    over: bool,
    steps: usize,
}

/// What a run says next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Next {
    /// Something, at this time by its own count.
    At(f64),
    /// That is not known yet: it has to leave out more than it may at once, or its score has much to do until something happens.
    Later,
    /// Nothing more.
    Over,
}

impl Run {
    pub fn new(serial: u64, roots: Vec<Root>, score: Score<'static>) -> Self {
        Self {
            serial,
            draws: serial,
            whence: Whence::HERE,
            cause: 0,
            ends: vec![f64::NEG_INFINITY; roots.len()],
            roots,
            follows: None,
            score,
            ahead: None,
            from: None,
            behind: false,
            over: false,
            steps: usize::MAX,
        }
    }

    /// The same, started by somebody, because of a signal.
    pub fn by(self, whence: Whence, cause: u64) -> Self {
        Self { whence, cause, ..self }
    }

    /// The same, which draws what another drew.
    pub fn drawing(self, draws: u64) -> Self {
        Self { draws, ..self }
    }

    /// The same, counted by a clock: it begins with `beat`, and has itself so many `beats` a second.
    pub fn following(self, beat: f64, beats: f64) -> Self {
        Self { follows: Some((beat, beats)), ..self }
    }

    /// The same, without what it would have said before, by its own count.
    pub fn from(self, from: f64) -> Self {
        Self { from: Some(from), ..self }
    }

    /// So many steps its score may take until this is said again.
    pub fn may_take(&mut self, steps: usize) {
        self.steps = steps;
    }

    /// When it says something next. Each event that it leaves out is taken off `work`, and each step that its score takes off what it [may
    /// take](Self::may_take); when one of them is used up, it goes on from there the next time. After an error it says what else there is.
    pub fn next(&mut self, work: &mut usize) -> Result<Next, Problem> {
        loop {
            if self.ahead.is_none() && !self.over {
                match self.score.next_within(&mut self.steps)? {
                    Ahead::Happens(timed) => self.ahead = Some(timed),
                    Ahead::Over => (self.over, self.from, self.behind) = (true, None, false),
                    Ahead::NotYet => {
                        self.behind = true;
                        return Ok(Next::Later);
                    }
                }
            }
            let Some(timed) = &self.ahead else { return Ok(Next::Over) };
            self.behind = false;
            if self.from.is_none_or(|from| timed.at >= from) {
                (self.from, self.behind) = (None, false);
                return Ok(Next::At(timed.at));
            }
            if *work == 0 {
                self.behind = true;
                return Ok(Next::Later);
            }
            *work -= 1;
            self.ahead = None;
        }
    }

    /// Whether it could not come at once to what it says next.
    pub fn is_behind(&self) -> bool {
        self.behind
    }

    /// Leaves out, while it is behind, what it would say before, as well: what has gone by meanwhile, by its own count.
    pub fn leave_out(&mut self, before: f64) {
        self.from = self.from.map(|from| from.max(before));
    }

    /// What it says next.
    pub fn take(&mut self) -> Option<Timed> {
        self.ahead.take()
    }

    /// Something of one of its roots sounds until so many seconds.
    pub fn sounds_until(&mut self, root: usize, seconds: f64) {
        if let Some(end) = self.ends.get_mut(root) {
            *end = end.max(seconds);
        }
    }

    /// Whether it has said all.
    pub fn is_over(&self) -> bool {
        self.over && self.ahead.is_none()
    }

    /// Whether a voice of it is not released before so many seconds.
    pub fn sounds(&self, seconds: f64) -> bool {
        self.ends.iter().any(|end| *end > seconds)
    }

    /// The patterns of it that still play, by their places in the patch: those that have more to say, or whose last voice is not released before
    /// so many seconds.
    pub fn playing(&self, seconds: f64) -> impl Iterator<Item = usize> {
        let plays = move |number: usize| {
            self.score.plays(number)
                || self.ahead.as_ref().is_some_and(|timed| timed.root == number)
                || self.ends.get(number).is_some_and(|end| *end > seconds)
        };
        self.roots.iter().enumerate().filter(move |(number, _)| plays(*number)).map(|(_, root)| root.pattern)
    }

    /// Plays no more of a pattern that it began with.
    pub fn stop(&mut self, pattern: usize) {
        for number in (0..self.roots.len()).filter(|number| self.roots[*number].pattern == pattern) {
            self.score.stop(number);
            self.ahead.take_if(|timed| timed.root == number);
            self.ends[number] = f64::NEG_INFINITY;
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
