//! The cutaneous rabbit: taps at a few sites that seem to hop from one to the next.
//!
//! Geldard & Sherrick, "The cutaneous 'rabbit': a perceptual illusion", Science 178, 1972: five taps of 2 ms at each of two or three sites
//! of the forearm, 10 cm apart, 40 to 80 ms from tap to tap, with no longer gap where the site changes (as told by Brooks & Trojan, "The
//! Cutaneous Rabbit Effect", Scholarpedia 12(12):52363, 2017).

use super::fault::{Fault, bursts, within};

/// What a tap lasts, in seconds.
pub const TAP: f64 = 2e-3;
/// Taps at each site.
pub const TAPS: usize = 5;
/// From tap to tap, in seconds, unless something else is wanted.
pub const INTERVAL: f64 = 0.05;
/// Intervals of the first report, in seconds (Geldard & Sherrick 1972).
pub const REPORTED: (f64, f64) = (0.04, 0.08);
/// Intervals at which taps are still felt out of their places, in seconds (Geldard, "Cutaneous stimuli, vibratory and saltatory", 1977).
pub const WIDEST: (f64, f64) = (0.02, 0.26);
/// The most taps at each site.
pub const MOST_TAPS: usize = 100;
/// The shortest tap, in seconds.
pub const SHORTEST: f64 = 1e-4;

/// Taps at sites one after another, evenly in time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Saltation {
    sites: usize,
    taps: usize,
    interval: f64,
    tap: f64,
}

impl Saltation {
    /// With taps at each site, an interval and the duration of a tap in seconds.
    ///
    /// # Errors
    /// Fewer than two sites; taps outside 1 to 100; an interval outside [`WIDEST`]; a tap that is not above 0 and within the interval.
    pub fn with(sites: usize, taps: usize, interval: f64, tap: f64) -> Result<Self, Fault> {
        if sites < 2 {
            return Err(Fault::FewPlaces(sites));
        }
        within("taps", taps as f64, 1.0, MOST_TAPS as f64)?;
        within("interval", interval, WIDEST.0, WIDEST.1)?;
        within("tap", tap, SHORTEST, interval)?;
        bursts(sites.saturating_mul(taps))?;
        Ok(Self { sites, taps, interval, tap })
    }

    /// Whether the interval is one of the first report.
    pub fn reported(&self) -> bool {
        (REPORTED.0..=REPORTED.1).contains(&self.interval)
    }

    /// What a tap lasts, in seconds.
    pub fn tap(&self) -> f64 {
        self.tap
    }

    /// Every tap: the number of its site from 0, and when it begins, in seconds.
    pub fn taps(&self) -> impl Iterator<Item = (usize, f64)> + use<> {
        let Self { sites, taps, interval, .. } = *self;
        (0..sites * taps).map(move |k| (k / taps, k as f64 * interval))
    }

    /// What all of it takes, in seconds.
    pub fn seconds(&self) -> f64 {
        (self.sites * self.taps - 1) as f64 * self.interval + self.tap
    }
}

#[cfg(test)]
mod tests {
    use super::{INTERVAL, Saltation, TAP, TAPS, WIDEST};
    use crate::space::fault::Fault;

    #[test]
    fn taps_are_even_and_change_their_site_after_five() {
        let rabbit = Saltation::with(3, TAPS, INTERVAL, TAP).unwrap();
        let taps: Vec<(usize, f64)> = rabbit.taps().collect();
        assert_eq!(taps.len(), 15);
        for (k, (site, start)) in taps.iter().enumerate() {
            assert_eq!(*site, [0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2][k]);
            // No longer gap where the site changes.
            assert!((start - 0.05 * k as f64).abs() < 1e-15);
        }
        assert!(rabbit.reported() && (rabbit.seconds() - 0.702).abs() < 1e-15 && rabbit.tap() == 0.002);
        assert!(!Saltation::with(2, 3, 0.1, 0.002).unwrap().reported());
    }

    #[test]
    fn what_does_not_hop_is_refused() {
        assert_eq!(Saltation::with(1, TAPS, INTERVAL, TAP).unwrap_err(), Fault::FewPlaces(1));
        let name = |fault: Result<Saltation, Fault>| match fault {
            Err(Fault::Range(name, ..)) => name,
            other => panic!("{other:?}"),
        };
        for bad in [0.0, f64::NAN, 1.0, WIDEST.0 - 1e-9, WIDEST.1 + 1e-9] {
            assert_eq!(name(Saltation::with(2, 5, bad, 0.002)), "interval");
        }
        for bad in [0.0, f64::NAN, 0.051, -1.0] {
            assert_eq!(name(Saltation::with(2, 5, 0.05, bad)), "tap");
        }
        assert_eq!(Saltation::with(60, 100, 0.05, 0.002).unwrap_err(), Fault::TooManyBursts(6000, 4096));
        assert_eq!(
            (name(Saltation::with(2, 0, 0.05, 0.002)), name(Saltation::with(2, 101, 0.05, 0.002))),
            ("taps", "taps")
        );
    }
}
