//! How much weaker what is short is felt.
//!
//! Thresholds are measured with tones of about 1 s. Of shorter ones the Pacinian channel feels less: it sums over time, as it does over the skin. The other
//! channels do not (Gescheider 1976, abstract: thenar, at high and not at low frequencies, at the threshold and above it).
//!
//! How much is not well known. The rule is 3 dB for each halving below 1 s: a judgement, and the most there is to it. An exponential of time constant
//! [`CONSTANT`], after Zwislocki's theory of 1960, which Gescheider et al. (1994, abstract) found to predict thresholds at 250 and 500 Hz, comes to 4 dB
//! where the rule comes to 10. The theory was not at hand, and its constant is a judgement, too. What is true lies somewhere from one to the other.

use crate::actuator::elementary::{exp, ln};

/// From here on nothing more is summed, s.
pub const WHOLE: f64 = 1.0;

/// Above this frequency the Pacinian channel is taken to decide, Hz.
pub const ABOVE: f64 = 60.0;

/// Durations below this are taken for it, s: shorter tones have no frequency to speak of.
pub const LEAST: f64 = 0.01;

/// Time constant of the exponential, s.
pub const CONSTANT: f64 = 0.2;

/// By how many dB a tone of some seconds is felt weaker than one of [`WHOLE`], at most: 10 log₁₀(1 s / duration). 0 where nothing is summed.
pub fn loss(seconds: f64, hertz: f64) -> f64 {
    summed(seconds, hertz).map_or(0.0, |seconds| power(WHOLE / seconds))
}

/// The same by the exponential: at least.
pub fn least_loss(seconds: f64, hertz: f64) -> f64 {
    let filled = |seconds: f64| 1.0 - exp(-seconds / CONSTANT);
    summed(seconds, hertz).map_or(0.0, |seconds| power(filled(WHOLE) / filled(seconds)))
}

/// The duration that counts, where any does.
fn summed(seconds: f64, hertz: f64) -> Option<f64> {
    (hertz > ABOVE && seconds < WHOLE).then(|| seconds.max(LEAST))
}

/// 10 log₁₀ of a ratio.
fn power(ratio: f64) -> f64 {
    ln(ratio) * (10.0 / std::f64::consts::LN_10)
}

#[cfg(test)]
mod tests {
    use super::{ABOVE, LEAST, least_loss, loss};

    #[test]
    fn each_halving_below_a_second_takes_three_decibels() {
        for seconds in [0.01, 0.02, 0.1, 0.25, 0.5, 0.9] {
            let due = 10.0 * (1.0_f64 / seconds).log10();
            assert!((loss(seconds, 250.0) - due).abs() < 1e-9, "{seconds}");
        }
        assert!((loss(0.1, 250.0) - 10.0).abs() < 1e-9);
        assert!((loss(0.2, 250.0) - loss(0.4, 250.0) - 10.0 * 2f64.log10()).abs() < 1e-9);
    }

    #[test]
    fn the_exponential_is_what_its_constant_says_and_less_than_the_rule() {
        let due = 10.0 * ((1.0 - (-5.0f64).exp()) / (1.0 - (-0.5f64).exp())).log10();
        assert!((least_loss(0.1, 250.0) - due).abs() < 1e-9 && (due - 4.02).abs() < 0.01, "{due}");
        for seconds in [0.01, 0.03, 0.1, 0.3, 0.99] {
            assert!(least_loss(seconds, 250.0) < loss(seconds, 250.0), "{seconds}");
            assert!(least_loss(seconds, 250.0) > 0.0, "{seconds}");
        }
    }

    #[test]
    fn long_tones_and_low_ones_lose_nothing_and_no_number_is_too_odd() {
        for of in [loss, least_loss] {
            assert_eq!((of(1.0, 250.0), of(7.0, 250.0), of(0.1, ABOVE), of(0.1, 20.0)), (0.0, 0.0, 0.0, 0.0));
            assert_eq!((of(f64::NAN, 250.0), of(0.1, f64::NAN), of(f64::INFINITY, 250.0)), (0.0, 0.0, 0.0));
            assert_eq!((of(0.0, 250.0), of(-3.0, 250.0)), (of(LEAST, 250.0), of(LEAST, 250.0)));
        }
    }
}
