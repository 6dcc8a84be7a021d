//! How long an answer takes.

/// Answers that are remembered.
pub const WINDOW: usize = 128;

/// Over the last [`WINDOW`] answers, seconds from the write to the whole answer; 0 where there was none yet. It holds what the system and the
/// device add: half of it is the least delay a [`Governor`](crate::knob::governor::Governor) must reckon with, and the worst the safest.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct RoundTrip {
    /// On the mean.
    pub mean: f64,
    /// At the worst.
    pub worst: f64,
}

/// The last answers.
#[derive(Debug, Clone)]
pub(super) struct Trips {
    last: [f64; WINDOW],
    next: usize,
    held: usize,
}

impl Trips {
    /// None yet.
    pub fn new() -> Self {
        Self { last: [0.0; WINDOW], next: 0, held: 0 }
    }

    /// Adds one.
    pub fn push(&mut self, seconds: f64) {
        self.last[self.next] = seconds;
        self.next = (self.next + 1) % WINDOW;
        self.held = (self.held + 1).min(WINDOW);
    }

    /// What they come to.
    pub fn sum_up(&self) -> RoundTrip {
        let held = &self.last[..self.held];
        let mean = held.iter().sum::<f64>() / self.held.max(1) as f64;
        RoundTrip { mean, worst: held.iter().fold(0.0, |worst, trip| worst.max(*trip)) }
    }
}

#[cfg(test)]
mod tests {
    use super::{RoundTrip, Trips, WINDOW};

    #[test]
    fn the_worst_is_forgotten_after_a_window() {
        let mut trips = Trips::new();
        assert_eq!(trips.sum_up(), RoundTrip::default());
        trips.push(0.5);
        (1..WINDOW).for_each(|_| trips.push(0.001));
        assert_eq!(trips.sum_up().worst, 0.5);
        trips.push(0.001);
        let RoundTrip { mean, worst } = trips.sum_up();
        assert!((mean - 0.001).abs() < 1e-12 && worst == 0.001, "{mean} {worst}");
    }
}
