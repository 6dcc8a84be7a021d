//! Apparent motion: bursts at a list of places that seem to be one that moves.
//!
//! Sherrick & Rogers, "Apparent haptic movement", 1966, found that the best time from onset to onset grows with the bursts' duration. The
//! straight line used here is that of Israr & Poupyrev ("Tactile Brush", CHI 2011): SOA = 0.32 d + 47.3 ms.

use super::fault::{Fault, bursts, within};

/// Of a burst's duration, what the onset distance grows by.
pub const SLOPE: f64 = 0.32;
/// The onset distance of bursts of no duration, in seconds.
pub const FIXED: f64 = 0.0473;
/// Durations that are taken, in seconds. Which of them were measured is [`brush::MEASURED`](super::brush::MEASURED).
pub const DURATIONS: (f64, f64) = (1e-3, 10.0);

/// From the onset of a burst of some duration to the next, in seconds.
pub fn onset(duration: f64) -> f64 {
    SLOPE * duration + FIXED
}

/// Bursts of one duration at places one after another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apparent {
    places: usize,
    duration: f64,
}

impl Apparent {
    /// Bursts of a duration in seconds.
    ///
    /// # Errors
    /// Fewer than two places; a duration outside [`DURATIONS`].
    pub fn new(places: usize, duration: f64) -> Result<Self, Fault> {
        if places < 2 {
            return Err(Fault::FewPlaces(places));
        }
        bursts(places)?;
        within("duration", duration, DURATIONS.0, DURATIONS.1)?;
        Ok(Self { places, duration })
    }

    /// Bursts so long that the whole motion takes some seconds.
    ///
    /// # Errors
    /// As [`Self::new`]; [`Fault::TooShort`] where onsets alone take longer.
    pub fn lasting(places: usize, seconds: f64) -> Result<Self, Fault> {
        let steps = places.saturating_sub(1) as f64;
        let least = steps * FIXED + (1.0 + steps * SLOPE) * DURATIONS.0;
        if places >= 2 && seconds < least {
            return Err(Fault::TooShort(places, seconds, least));
        }
        Self::new(places, (seconds - steps * FIXED) / (1.0 + steps * SLOPE))
    }

    /// What each burst lasts, in seconds.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// From one onset to the next, in seconds.
    pub fn onset(&self) -> f64 {
        onset(self.duration)
    }

    /// When the burst at each place begins, in seconds.
    pub fn starts(&self) -> impl Iterator<Item = f64> + use<> {
        let onset = self.onset();
        (0..self.places).map(move |place| place as f64 * onset)
    }

    /// What all of it takes, in seconds.
    pub fn seconds(&self) -> f64 {
        (self.places - 1) as f64 * self.onset() + self.duration
    }
}

#[cfg(test)]
mod tests {
    use super::{Apparent, onset};
    use crate::space::fault::Fault;

    #[test]
    fn onsets_are_the_published_ones() {
        for (duration, wanted) in [(0.05, 0.0633), (0.1, 0.0793), (0.2, 0.1113)] {
            assert!((onset(duration) - wanted).abs() < 1e-15);
        }
        let motion = Apparent::new(4, 0.1).unwrap();
        let starts: Vec<f64> = motion.starts().collect();
        assert_eq!(starts.len(), 4);
        assert!(starts.iter().zip([0.0, 0.0793, 0.1586, 0.2379]).all(|(a, b)| (a - b).abs() < 1e-15));
        assert!((motion.seconds() - 0.3379).abs() < 1e-15);
    }

    #[test]
    fn it_has_an_end() {
        assert!(Apparent::new(4096, 0.1).is_ok());
        assert_eq!(Apparent::new(4097, 0.1).unwrap_err(), Fault::TooManyBursts(4097, 4096));
    }

    #[test]
    fn a_time_for_all_gives_the_duration_of_each() {
        for places in 2..40 {
            let motion = Apparent::lasting(places, 3.0).unwrap();
            assert!((motion.seconds() - 3.0).abs() < 1e-12, "{places}");
        }
        // 100 places need 99 × 47.3 ms for onsets alone.
        let short = Apparent::lasting(100, 3.0);
        assert!(
            matches!(short, Err(Fault::TooShort(100, _, least)) if (4.6827..4.8).contains(&least)),
            "{short:?}"
        );
        // What is told to be enough is enough, and no more than enough.
        for places in 2..40 {
            let Err(Fault::TooShort(_, _, least)) = Apparent::lasting(places, 0.0) else {
                panic!("{places}")
            };
            assert!(Apparent::lasting(places, least * (1.0 + 1e-12)).is_ok(), "{places}");
            assert!(Apparent::lasting(places, least * 0.99).is_err(), "{places}");
        }
    }

    #[test]
    fn what_cannot_move_is_refused() {
        assert_eq!(Apparent::new(1, 0.1).unwrap_err(), Fault::FewPlaces(1));
        assert_eq!(Apparent::lasting(0, 1.0).unwrap_err(), Fault::FewPlaces(0));
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY, 11.0] {
            assert!(matches!(Apparent::new(2, bad), Err(Fault::Range("duration", ..))), "{bad}");
        }
    }
}
