//! The most that there was of late.

#![deny(clippy::disallowed_methods)]

/// For so long at least, in seconds, something is remembered, and for no longer than twice that; what is young remembers for as long as it is old,
/// but for so long at the least.
const REMEMBERED: f64 = 30.0;
const YOUNG: f64 = 0.25;

/// The most of late: at once where it grows, and one less each time where it falls, so that what is played by it keeps its order.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Lately {
    /// Since a moment, and before it.
    most: [u64; 2],
    since: f64,
    held: u64,
}

impl Lately {
    /// Begins with so much, at 0 seconds.
    pub fn new(most: u64) -> Self {
        Self { most: [most, 0], since: 0.0, held: most }
    }

    /// There was so much, at so many seconds. Gives the most.
    pub fn hear(&mut self, much: u64, seconds: f64) -> u64 {
        if seconds - self.since > self.since.clamp(YOUNG, REMEMBERED) {
            (self.most, self.since) = ([0, self.most[0]], seconds);
        }
        self.most[0] = self.most[0].max(much);
        self.held = self.most[0].max(self.most[1]).max(self.held.saturating_sub(1));
        self.held
    }

    /// The most.
    pub fn get(&self) -> u64 {
        self.held
    }

    /// What was before counts no more.
    pub fn forget(&mut self) {
        self.most = [0; 2];
    }
}

#[cfg(test)]
mod tests {
    use super::Lately;

    #[test]
    fn what_was_most_is_remembered_for_a_while() {
        let mut lately = Lately::new(256);
        let mut at = |seconds: f64, much| lately.hear(much, seconds);
        assert_eq!((at(0.1, 300), at(0.2, 64)), (300, 300));
        // Young: a quarter of a second at least, twice that at most.
        assert_eq!((at(0.4, 64), at(0.7, 64), at(0.9, 64)), (300, 300, 299), "and then one less each time");
        let mut lately = Lately::new(0);
        let heard: Vec<u64> =
            (0..4000).map(|n| lately.hear(u64::from(n == 2000), 0.1 * f64::from(n))).collect();
        let last = heard.iter().rposition(|most| *most == 1).unwrap();
        assert!((2300..2600).contains(&last) && heard[2000..last].iter().all(|most| *most == 1), "{last}");
    }
}
