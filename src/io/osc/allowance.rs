//! How much of what came to nothing a journal has lines for.

use crate::live::stamp::Stamp;

/// So many lines at once, and so many a second.
const AT_ONCE: f64 = 256.0;
const EACH_SECOND: f64 = 64.0;

/// What is left to be written.
#[derive(Debug)]
pub(super) struct Allowance {
    left: f64,
    since: Stamp,
}

impl Default for Allowance {
    fn default() -> Self {
        Self { left: AT_ONCE, since: Stamp(0) }
    }
}

impl Allowance {
    /// Whether there may be one more, which is one less.
    pub fn take(&mut self, now: Stamp) -> bool {
        let passed = now.0.saturating_sub(self.since.0) as f64 * 1e-9;
        self.since = now.max(self.since);
        self.left = (self.left + passed * EACH_SECOND).min(AT_ONCE);
        let some = self.left >= 1.0;
        if some {
            self.left -= 1.0;
        }
        some
    }
}

#[cfg(test)]
mod tests {
    use super::{AT_ONCE, Allowance, EACH_SECOND};
    use crate::live::stamp::Stamp;

    #[test]
    fn some_at_once_and_some_each_second() {
        let mut allowance = Allowance::default();
        let mut taken = |at: f64, times: usize| {
            (0..times).filter(|_| allowance.take(Stamp((at * 1e9) as u64))).count() as f64
        };
        assert_eq!(taken(1.0, 10_000), AT_ONCE);
        assert_eq!(taken(1.0, 10), 0.0);
        assert_eq!(taken(1.5, 10_000), 0.5 * EACH_SECOND);
        // A clock that was read earlier is no reason to write more.
        assert_eq!(taken(1.25, 10) + taken(1.5, 10), 0.0);
        assert_eq!(taken(1000.0, 10_000), AT_ONCE);
    }
}
