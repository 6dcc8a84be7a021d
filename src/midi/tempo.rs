//! The tempo of a MIDI clock, which comes 24 times a beat.

/// Clocks a beat: MIDI 1.0 Detailed Specification, "Timing Clock".
pub const CLOCKS_A_BEAT: usize = 24;
/// The line goes through the clocks of one beat.
const MOST: usize = CLOCKS_A_BEAT + 1;
/// And through those of half a beat at least.
const FEWEST: usize = CLOCKS_A_BEAT / 2 + 1;
/// A silence of so many intervals means that clocks were lost or stood still.
const GAP_INTERVALS: f64 = 2.5;
/// So does one of so many seconds, which would be ten beats a minute.
const GAP_SECONDS: f64 = 0.25;
/// No tempo above, in beats a minute: what claims more is not a clock.
const FASTEST: f64 = 1_000.0;
/// Of a tempo: smaller changes are not said.
const CHANGE: f64 = 1e-4;

/// Finds the tempo as the slope of the least-squares line through the times of the clocks of the last beat.
///
/// Jitter of standard deviation s on each time leaves √(12 / (25³ − 25)) s = 0.028 s on the interval: for ±2 ms, evenly spread, 0.03 ms
/// of 20.8 ms at 120 beats a minute, or 0.16 %. A new tempo is said only where it differs from the last by more than twice the
/// line's own standard error, and by more than 0.01 %. As the line is one beat long, it lies wholly in a new tempo after one beat. Where
/// clocks are missing (a silence of more than 2.5 intervals, or of 250 ms), a new line begins; nothing is said for less than half a beat.
#[derive(Debug, Clone, Copy)]
pub(super) struct Clocks {
    times: [f64; MOST],
    count: usize,
    /// The interval of the tempo that was said last.
    said: Option<f64>,
}

impl Default for Clocks {
    fn default() -> Self {
        Self { times: [0.0; MOST], count: 0, said: None }
    }
}

impl Clocks {
    /// Takes the time of a clock, in seconds, not before the last one. Gives the tempo in beats a minute, where there is one to say.
    pub fn clock(&mut self, now: f64) -> Option<f64> {
        let seen = self.times.get(..self.count).unwrap_or_default();
        if let (Some(first), Some(last)) = (seen.first(), seen.last()) {
            let mean = (last - first) / (self.count - 1).max(1) as f64;
            let gap = now - last;
            if gap > GAP_SECONDS || (self.count > 2 && gap > GAP_INTERVALS * mean) {
                self.count = 0;
            }
        }
        if self.count == MOST {
            self.times.rotate_left(1);
            self.count -= 1;
        }
        if let Some(slot) = self.times.get_mut(self.count) {
            *slot = now;
            self.count += 1;
        }
        let (interval, error) = line(self.times.get(..self.count).filter(|t| t.len() >= FEWEST)?);
        let beats_per_minute = 60.0 / (CLOCKS_A_BEAT as f64 * interval);
        if !(interval > 0.0 && beats_per_minute <= FASTEST) {
            return None;
        }
        if self.said.is_some_and(|said| (interval - said).abs() <= f64::max(2.0 * error, CHANGE * said)) {
            return None;
        }
        self.said = Some(interval);
        Some(beats_per_minute)
    }
}

/// Slope of the least-squares line through `times` over their index, and its standard error.
fn line(times: &[f64]) -> (f64, f64) {
    let n = times.len() as f64;
    let origin = times.first().copied().unwrap_or(0.0);
    let middle = (n - 1.0) / 2.0;
    let mean = times.iter().map(|t| t - origin).sum::<f64>() / n;
    let points = || times.iter().enumerate().map(|(i, t)| (i as f64 - middle, t - origin - mean));
    let spread: f64 = points().map(|(x, _)| x * x).sum();
    let slope = points().map(|(x, y)| x * y).sum::<f64>() / spread;
    let rest: f64 = points().map(|(x, y)| (y - slope * x).powi(2)).sum();
    (slope, (rest / (n - 2.0) / spread).sqrt())
}

#[cfg(test)]
mod tests {
    use super::{CLOCKS_A_BEAT, Clocks, FEWEST, line};
    use proptest::prelude::{prop_assert, proptest};

    fn interval(bpm: f64) -> f64 {
        60.0 / bpm / CLOCKS_A_BEAT as f64
    }

    #[test]
    fn a_line_has_its_slope_and_a_kink_its_error() {
        let (slope, error) = line(&[1.0, 1.5, 2.0, 2.5]);
        assert!((slope - 0.5).abs() < 1e-15 && error < 1e-15);
        // y = 0, 1, 0: slope 0, residuals 1/3, 2/3, 1/3, one degree of freedom, spread 2.
        let (slope, error) = line(&[0.0, 1.0, 0.0]);
        assert!(slope.abs() < 1e-15 && (error - (6.0_f64 / 9.0 / 2.0).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn an_exact_clock_is_said_once_after_half_a_beat() {
        for bpm in [20.0, 60.0, 120.0, 333.0] {
            let mut clocks = Clocks::default();
            let said: Vec<(usize, f64)> =
                (0..200).filter_map(|i| Some((i, clocks.clock(7.0 + i as f64 * interval(bpm))?))).collect();
            assert_eq!(said.len(), 1, "{said:?}");
            assert_eq!(said[0].0, FEWEST - 1);
            assert!((said[0].1 / bpm - 1.0).abs() < 1e-9, "{said:?}");
        }
    }

    #[test]
    fn a_jump_is_followed_within_a_beat() {
        for (before, after) in [(120.0, 90.0), (90.0, 180.0), (60.0, 200.0), (200.0, 60.0)] {
            let (mut clocks, mut now, mut said) = (Clocks::default(), 0.0, 0.0);
            for i in 0..100 + CLOCKS_A_BEAT {
                now += interval(if i < 100 { before } else { after });
                said = clocks.clock(now).unwrap_or(said);
            }
            assert!((said / after - 1.0_f64).abs() < 1e-3, "{before} to {after}: {said}");
        }
    }

    #[test]
    fn a_small_change_is_heard_through_jitter() {
        let (mut clocks, mut now, mut said) = (Clocks::default(), 0.0, 0.0);
        for i in 0..100 + 2 * CLOCKS_A_BEAT {
            now += interval(if i < 100 { 120.0 } else { 121.2 });
            said = clocks.clock(now + if i % 2 == 0 { 0.001 } else { -0.001 }).unwrap_or(said);
        }
        assert!((said / 121.2_f64 - 1.0).abs() < 0.003, "{said}");
    }

    #[test]
    fn what_is_no_clock_has_no_tempo() {
        let mut clocks = Clocks::default();
        assert!((0..100).all(|_| clocks.clock(1.0).is_none()), "all at once");
        let mut clocks = Clocks::default();
        assert!((0..100).all(|i| clocks.clock(f64::from(i)).is_none()), "2.5 beats a minute");
        let mut clocks = Clocks::default();
        assert!((0..100).all(|i| clocks.clock(f64::from(i) * 0.002).is_none()), "1,250 beats a minute");
        let mut clocks = Clocks::default();
        for i in 0..12 {
            assert_eq!(clocks.clock(f64::from(i) * 0.02), None, "too few");
        }
    }

    #[test]
    fn clocks_that_stood_still_do_not_count_as_slow() {
        let mut clocks = Clocks::default();
        let said: Vec<f64> = (0..100)
            .filter_map(|i| clocks.clock(f64::from(i) * interval(120.0) + if i < 50 { 0.0 } else { 0.08 }))
            .collect();
        assert!(said.iter().all(|bpm| (bpm - 120.0).abs() < 1e-6), "{said:?}");
    }

    proptest! {
        #[test]
        fn jitter_of_two_milliseconds_hardly_matters(
            jitter in proptest::collection::vec(-0.002_f64..0.002, 240),
            bpm in 60.0_f64..180.0,
        ) {
            let mut clocks = Clocks::default();
            let mut last = 0.0_f64;
            let mut said = 0;
            for (i, j) in jitter.iter().enumerate() {
                last = last.max(1.0 + i as f64 * interval(bpm) + j);
                if let Some(found) = clocks.clock(last) {
                    let bound = if i < CLOCKS_A_BEAT { 0.04 } else { 0.012 };
                    prop_assert!((found / bpm - 1.0).abs() < bound, "{} at {}: {}", bpm, i, found);
                    said += 1;
                }
            }
            prop_assert!((1..120).contains(&said), "{}", said);
        }
    }
}
