//! From which amplitude on a vibration is felt.

use super::site::Site;
use crate::actuator::elementary::ln;

/// The frequencies between which thresholds are given, Hz. Slopes are quoted up to [`QUOTED`]; above, they are a judgement on the hand, and
/// above [`FAR`] an extrapolation everywhere.
pub const RANGE: [f64; 2] = [10.0, 1000.0];

/// Up to here slopes are quoted, Hz.
pub const QUOTED: f64 = 250.0;

/// No threshold above this was at hand, Hz: from here on slopes only go on.
pub const FAR: f64 = 600.0;

/// By how much more a threshold may be off for each octave above [`QUOTED`], dB: by as much as slopes of 9 and 12 dB differ, which were both given.
const STEEPER: f64 = 3.0;

/// By how much more it may be off above [`FAR`], dB.
const FARTHER: f64 = 3.0;

/// The area of the contactor for which the figures of sites are, m².
pub const CONTACTOR: f64 = 2.9e-4;

/// Areas between which the Pacinian threshold falls by 3 dB with each doubling, m²: below, it stays (summation begins somewhere from 0.02 to 0.05 cm²,
/// Verrillo 1963), and above is beyond the contactors with which that was measured.
pub const SUMMED: [f64; 2] = [2e-6, 5e-4];

/// By how much more a threshold may be off under a contactor outside of [`SUMMED`], dB.
const UNSUMMED: f64 = 3.0;

/// Decibels of a micrometre over those of a metre.
pub const MICRO: f64 = -120.0;

/// The threshold at a site, under a contactor.
///
/// T(f) = min(P(f), N): P(f) = P₀ − 10 log₁₀(A / 2.9 cm²) + 40 log₁₀(f₀ / f) below f₀, and r log₂(f / f₀) in place of the last term above; N is that of
/// the other channels. Verrillo 1963 and 1966 for slopes, corners and areas; figures by [`Site`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Threshold {
    site: &'static Site,
    area: f64,
    /// At the corner, for the area.
    pacinian: f64,
}

impl Threshold {
    /// At a site, under a contactor of an area (m²).
    pub fn new(site: &'static Site, area: f64) -> Self {
        let summed = area.clamp(SUMMED[0], SUMMED[1]);
        Self { site, area, pacinian: site.pacinian - decibels(summed / CONTACTOR) * 0.5 }
    }

    /// The site.
    pub fn site(&self) -> &'static Site {
        self.site
    }

    /// The contactor's area, m².
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Of the Pacinian channel, dB above 1 µm.
    fn pacinian(&self, hertz: f64) -> f64 {
        let octaves = ln(hertz / self.site.corner) / std::f64::consts::LN_2;
        let slope = if octaves < 0.0 { -2.0 * DOUBLED } else { self.site.rise };
        self.pacinian + slope * octaves
    }

    /// The least displacement (peak) that is felt, dB above 1 m, at a frequency (Hz) within [`RANGE`].
    pub fn metres(&self, hertz: f64) -> f64 {
        MICRO + self.pacinian(hertz).min(self.site.other)
    }

    /// By how much that may be off there, dB either way, for an average of adults.
    pub fn error(&self, hertz: f64) -> f64 {
        let octaves = (ln(hertz / QUOTED) / std::f64::consts::LN_2).max(0.0);
        let above = STEEPER * octaves + if hertz > FAR { FARTHER } else { 0.0 };
        if self.pacinian(hertz) >= self.site.other {
            return self.site.other_error + above;
        }
        let summed = (SUMMED[0]..=SUMMED[1]).contains(&self.area);
        self.site.pacinian_error + above + if summed { 0.0 } else { UNSUMMED }
    }
}

/// What a doubling of an amplitude comes to, dB.
const DOUBLED: f64 = 6.020_599_913_279_624;

/// 20 log₁₀ of a ratio of amplitudes, above 0.
pub fn decibels(ratio: f64) -> f64 {
    ln(ratio) * (20.0 / std::f64::consts::LN_10)
}

#[cfg(test)]
mod tests {
    use super::{CONTACTOR, MICRO, SUMMED, Threshold, decibels};
    use crate::perception::site::{SITES, THENAR, find};

    fn at(site: &str, area: f64, hertz: f64) -> f64 {
        Threshold::new(find(site).unwrap(), area).metres(hertz) - MICRO
    }

    /// The idealised curve of the thenar under a large contactor, from the slopes alone.
    #[test]
    fn the_thenar_is_flat_and_then_falls_by_twelve_decibels_an_octave() {
        let due = [
            (10.0, 11.8),
            (40.0, 11.8),
            (50.0, 7.9),
            (63.0, 3.9),
            (80.0, -0.2),
            (100.0, -4.1),
            (125.0, -8.0),
            (160.0, -12.2),
            (200.0, -16.1),
            (250.0, -20.0),
            (315.0, -16.0),
            (400.0, -11.8),
            (500.0, -8.0),
            (700.0, -2.1),
            (1000.0, 4.0),
        ];
        for (hertz, due) in due {
            assert!(
                (at("thenar", CONTACTOR, hertz) - due).abs() < 0.15,
                "{hertz}: {}",
                at("thenar", CONTACTOR, hertz)
            );
        }
    }

    #[test]
    fn the_forearm_has_the_slopes_that_were_measured_there() {
        let slope = |from: f64| at("forearm", CONTACTOR, 2.0 * from) - at("forearm", CONTACTOR, from);
        assert!(
            (slope(100.0) + 12.04).abs() < 0.01 && (slope(250.0) - 9.0).abs() < 1e-9,
            "{} {}",
            slope(100.0),
            slope(250.0)
        );
    }

    /// A doubled contactor takes 3 dB at 250 Hz and nothing at 20 Hz; beyond what was measured it takes nothing more.
    #[test]
    fn area_counts_for_the_pacinian_channel_alone() {
        let [least, most] = SUMMED;
        for area in [least, 1e-5, 1e-4, 0.5 * most] {
            let gained = at("thenar", area, 250.0) - at("thenar", 2.0 * area, 250.0);
            assert!((gained - 10.0 * 2f64.log10()).abs() < 1e-9, "{area}: {gained}");
            assert_eq!(at("thenar", area, 20.0), at("thenar", 2.0 * area, 20.0));
        }
        assert_eq!(at("thenar", least, 250.0), at("thenar", 1e-9, 250.0));
        assert_eq!(at("thenar", most, 250.0), at("thenar", 1.0, 250.0));
        let error = |area: f64| Threshold::new(THENAR, area).error(250.0);
        assert!(error(1.0) > error(1e-4) && error(1e-9) > error(1e-4));
        assert_eq!(error(1e-4), THENAR.pacinian_error);
    }

    /// Above 250 Hz slopes are a judgement, and above 600 Hz they only go on, for all channels.
    #[test]
    fn errors_grow_where_less_was_measured() {
        let error = |hertz: f64| Threshold::new(THENAR, CONTACTOR).error(hertz);
        assert_eq!((error(20.0), error(100.0), error(250.0)), (5.0, 5.0, 5.0));
        // The slopes of 9 and 12 dB differ by 3 dB at 500 and 6 dB at 1000 Hz.
        assert!((error(500.0) - 8.0).abs() < 1e-9 && (error(1000.0) - (5.0 + 6.0 + 3.0)).abs() < 1e-9);
        for site in &SITES {
            let error = |hertz: f64| Threshold::new(site, CONTACTOR).error(hertz);
            assert!(error(1000.0) >= error(250.0) + 6.9, "{}", site.word);
        }
        assert!(error(601.0) - error(600.0) > 2.9, "{} {}", error(600.0), error(601.0));
    }

    #[test]
    fn curves_have_no_steps() {
        for site in &SITES {
            let threshold = Threshold::new(site, 3e-5);
            let mut before = threshold.metres(10.0);
            for n in 1..=2000 {
                let next = threshold.metres(10.0 * 100f64.powf(f64::from(n) / 2000.0));
                assert!((next - before).abs() < 0.05 && next.is_finite(), "{} {n}", site.word);
                before = next;
            }
        }
        assert!((decibels(10.0) - 20.0).abs() < 1e-13 && (decibels(2.0) - super::DOUBLED).abs() < 1e-13);
    }
}
