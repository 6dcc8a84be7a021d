//! Exact intervals for work that comes back: meters, motor drives, a knob's servo.

/// When a periodic task runs: before engine samples `phase`, `phase + period`, and so on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Beat {
    /// Engine samples between two runs, at least 1.
    pub period: u32,
    /// The first run, less than the period.
    pub phase: u32,
}

impl Beat {
    /// A beat of `period` samples (0 counts as 1) that starts at engine sample 0.
    pub fn every(period: u32) -> Self {
        Self { period: period.max(1), phase: 0 }
    }

    /// Whether the task runs before engine sample `clock`.
    pub fn is_due(self, clock: u64) -> bool {
        self.next(clock) == clock
    }

    /// The first engine sample at or after `clock` before which it runs.
    pub fn next(self, clock: u64) -> u64 {
        let (period, phase) = (u64::from(self.period.max(1)), u64::from(self.phase));
        if clock <= phase {
            return phase;
        }
        phase + (clock - phase).div_ceil(period) * period
    }
}

#[cfg(test)]
mod tests {
    use super::Beat;

    #[test]
    fn beats_fall_on_their_grid() {
        let beat = Beat { period: 80, phase: 3 };
        let due: Vec<u64> = (0..400).filter(|&n| beat.is_due(n)).collect();
        assert_eq!(due, [3, 83, 163, 243, 323]);
        assert_eq!(beat.next(84), 163);
        assert!((0..50).all(|n| Beat::every(1).is_due(n)));
        assert!(Beat::every(0).is_due(7));
    }
}
