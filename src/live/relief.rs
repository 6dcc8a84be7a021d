//! Relief for a callback that has too much to do: decides when periodic tasks rest, the least important first, and when they run again.
//!
//! It only decides. What it decides enters the engine as an event with its sample, so that a replay does the same without a clock.

#![deny(clippy::disallowed_methods)]

/// Of the time that a callback has, more than this is too much.
const TOO_MUCH: f64 = 0.7;

/// Below this, there is room for more.
const ROOM: f64 = 0.35;

/// Callbacks out of [`LAST`] that must be too long before something rests: the machine itself stalls now and then.
const SEVERAL: u32 = 3;
const LAST: u32 = 8;

/// Seconds between two decisions to let something rest, so that the first can show what it does.
const SETTLING: f64 = 0.1;

/// Seconds of room before something runs again.
const CALM: f64 = 5.0;

/// What is to be done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Relieved {
    /// More tasks rest.
    More,
    /// Fewer do.
    Fewer,
}

/// Watches the callbacks' run times.
#[derive(Debug, Clone, Default)]
pub struct Relief {
    /// The last callbacks, the latest in the lowest bit: whether they were too long.
    long: u32,
    /// Seconds since the last decision, and of room since the last callback without.
    since: f64,
    room: f64,
}

impl Relief {
    /// A callback took `busy` seconds of the `period` that it had. Says whether something is to be done.
    pub fn note(&mut self, busy: f64, period: f64) -> Option<Relieved> {
        let share = busy / period;
        self.long = (self.long << 1 | u32::from(share > TOO_MUCH)) & ((1 << LAST) - 1);
        self.since += period;
        self.room = if share < ROOM { self.room + period } else { 0.0 };
        if self.long.count_ones() >= SEVERAL && self.since >= SETTLING {
            *self = Self::default();
            return Some(Relieved::More);
        }
        if self.room >= CALM {
            *self = Self::default();
            return Some(Relieved::Fewer);
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::{Relief, Relieved};

    const PERIOD: f64 = 64.0 / 48_000.0;

    #[test]
    fn single_stalls_are_borne() {
        let mut relief = Relief::default();
        for n in 0..3_000 {
            let busy = if n % 10 == 0 { 3.0 * PERIOD } else { 0.5 * PERIOD };
            assert_eq!(relief.note(busy, PERIOD), None, "{n}");
        }
    }

    #[test]
    fn too_much_is_shed_step_by_step_and_taken_back_after_a_while() {
        let mut relief = Relief::default();
        let mut decisions = Vec::new();
        for n in 0..300 {
            if let Some(Relieved::More) = relief.note(0.8 * PERIOD, PERIOD) {
                decisions.push(n);
            }
        }
        // A tenth of a second apart, which are 75 callbacks.
        assert_eq!(decisions, [74, 149, 224, 299]);
        let calm = (0..10_000).find(|_| relief.note(0.1 * PERIOD, PERIOD) == Some(Relieved::Fewer)).unwrap();
        assert!((calm as f64 * PERIOD - 5.0).abs() < 0.01, "{calm}");
        assert_eq!(relief.note(f64::NAN, PERIOD), None);
    }
}
