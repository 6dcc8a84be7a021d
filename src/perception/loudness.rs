//! How strong a vibration seems.
//!
//! The sensation grows as a power of the amplitude, and the exponent depends on the frequency: Stevens lists 0.95 at 60 Hz and 0.6 at 250 Hz on the
//! finger (and found in 1968 about 1 at 60 Hz, the largest near 30 Hz and about half of that near 250 Hz). So curves of equal strength lie closer
//! together than those of equal amplitude: L(f) = T(f) + S / β(f). Verrillo 1970 found one exponent, 0.89, for all frequencies up to 350 Hz, with which they
//! would all run alongside the threshold: between the two, 20 dB at 250 Hz are 12.6 or 20 dB at 60 Hz. That is why `felt` counts decibels above the
//! threshold, and no strength.

use crate::actuator::elementary::ln;

/// Frequencies (Hz) and exponents, on the finger: Stevens' list of exponents.
pub const EXPONENTS: [(f64, f64); 2] = [(60.0, 0.95), (250.0, 0.6)];

/// The exponent at a frequency (Hz), straight over its logarithm; `None` beyond what was measured.
pub fn exponent(hertz: f64) -> Option<f64> {
    let [(low, at_low), (high, at_high)] = EXPONENTS;
    if !(low..=high).contains(&hertz) {
        return None;
    }
    let share = ln(hertz / low) / ln(high / low);
    Some(at_low + (at_high - at_low) * share)
}

/// Decibels above the threshold at one frequency (Hz) that seem as strong as `felt` of them at another; `None` beyond what was measured.
pub fn as_strong(felt: f64, at: f64, hertz: f64) -> Option<f64> {
    Some(felt * exponent(at)? / exponent(hertz)?)
}

#[cfg(test)]
mod tests {
    use super::{as_strong, exponent};

    #[test]
    fn exponents_are_those_that_were_measured_and_nothing_beyond() {
        assert_eq!((exponent(60.0), exponent(59.9), exponent(250.1)), (Some(0.95), None, None));
        assert!((exponent(250.0).unwrap() - 0.6).abs() < 1e-12);
        assert_eq!(exponent(f64::NAN), None);
        // Half way on a logarithm.
        assert!((exponent(15_000f64.sqrt()).unwrap() - 0.775).abs() < 1e-12);
    }

    #[test]
    fn curves_of_equal_strength_lie_closer_together_where_the_exponent_is_larger() {
        let low = as_strong(20.0, 250.0, 60.0).unwrap();
        assert!((low - 20.0 * 0.6 / 0.95).abs() < 1e-9);
        assert!((as_strong(low, 60.0, 250.0).unwrap() - 20.0).abs() < 1e-9);
        assert_eq!(as_strong(0.0, 250.0, 100.0), Some(0.0), "at the threshold they are the threshold");
        assert_eq!(as_strong(20.0, 250.0, 30.0), None);
    }
}
