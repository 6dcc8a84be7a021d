//! A voice on its lane.

use super::event::Play;
use crate::schedule::Instant;

/// Who is on a lane, and since when.
#[derive(Debug, Clone, Copy, Default)]
pub struct Lane {
    /// The event.
    pub play: Play,
    /// Its onset.
    pub born: Instant,
    /// Its order among all voices.
    pub serial: u64,
    /// How loud it may be: the event's level times what folding made gain.
    pub level: f64,
    /// Engine samples it has been silent since its envelopes ended.
    pub quiet: u64,
    /// How it dies away once it was released and its envelopes have ended.
    pub dying: Dying,
    /// What it is doing.
    pub status: Status,
}

/// How a voice dies away: whether it becomes quieter from one stretch of time to the next.
#[derive(Debug, Clone, Copy)]
pub struct Dying {
    /// Engine samples of this stretch so far, and the largest magnitude in them.
    samples: u64,
    peak: f64,
    /// The largest magnitude in the stretch before.
    before: f64,
}

/// A voice that keeps more than this share of its peak from one stretch to the next does not die away: noise keeps about as much,
/// and 60 dB would take 19 minutes.
const LASTING: f64 = 0.97;

impl Default for Dying {
    fn default() -> Self {
        Self { samples: 0, peak: 0.0, before: f64::INFINITY }
    }
}

impl Dying {
    /// So many samples more with this largest magnitude, in stretches of `stretch` samples. Says whether it does not die away.
    pub fn goes_on(&mut self, samples: u64, peak: f64, stretch: u64) -> bool {
        self.samples += samples;
        self.peak = self.peak.max(peak);
        if self.samples < stretch {
            return false;
        }
        let lasts = self.peak > LASTING * self.before;
        *self = Self { before: self.peak, ..Self::default() };
        lasts
    }
}

/// What a lane is doing.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum Status {
    /// Nothing; it may be taken.
    #[default]
    Free,
    /// It sounds and was not released.
    Held,
    /// It was released.
    Released,
    /// It falls silent from this instant on, so many times as fast as [`crate::dsp::fade::fade`] has it.
    Fading(Instant, f64),
}

#[cfg(test)]
mod tests {
    use super::Dying;

    /// Stretches of ten until it is said not to die away.
    fn stretches(mut peak: impl FnMut(i32) -> f64) -> Option<i32> {
        let mut dying = Dying::default();
        (0..100_000).find(|n| dying.goes_on(1, peak(*n), 10)).map(|n| n / 10 + 1)
    }

    #[test]
    fn what_becomes_quieter_dies_away() {
        // A twentieth less in each stretch, however it swings within one.
        let swings = |n: i32| 0.95f64.powf(f64::from(n) / 10.0) * (f64::from(n) * 0.7).sin().abs();
        assert_eq!(stretches(swings), None);
        assert_eq!(stretches(|n| 0.5f64.powi(n / 10)), None);
        // Silence in between is no end.
        assert_eq!(stretches(|n| if n % 10 == 3 { 0.9f64.powi(n / 10) } else { 0.0 }), None);
        assert_eq!(stretches(|_| 0.0), None);
    }

    #[test]
    fn what_stays_or_grows_does_not() {
        assert_eq!(stretches(|_| 0.3), Some(2));
        assert_eq!(stretches(|n| 1e-5 * 1.01f64.powi(n)), Some(2));
        // It stops where the sixth stretch ends, and the eighth is as loud as the seventh.
        assert_eq!(stretches(|n| if n < 55 { 1.0 - 0.01 * f64::from(n) } else { 0.46 }), Some(8));
    }
}
