//! How much of what nobody asked for is borne.

/// Bytes or messages in a second.
#[derive(Debug, Clone)]
pub(super) struct Budget {
    most: usize,
    since: f64,
    spent: usize,
}

impl Budget {
    /// As much a second.
    pub fn new(most: usize) -> Self {
        Self { most, since: f64::NEG_INFINITY, spent: 0 }
    }

    /// Counts `more` at a time (seconds); how much it was, where it is too much.
    pub fn spend(&mut self, more: usize, now: f64) -> Option<usize> {
        if now - self.since >= 1.0 {
            (self.since, self.spent) = (now, 0);
        }
        self.spent = self.spent.saturating_add(more);
        (self.spent > self.most).then_some(self.spent)
    }

    /// Takes back what was asked for after all.
    pub fn credit(&mut self, asked: usize) {
        self.spent = self.spent.saturating_sub(asked);
    }
}
