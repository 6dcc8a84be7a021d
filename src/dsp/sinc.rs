//! Between samples, as exactly as it may be: for the twins, which have time.

use std::f64::consts::PI;

/// How steeply the window falls.
const STEEP: f64 = 12.0;

/// The samples within `reach` of a place, and what each of them weighs there: a sinc in the window cosh 12√(1 − x²) / cosh 12, with x the distance as a
/// share of the reach. What is below 0.4 of the rate comes out to -100 dB and better where the reach is 48 samples.
pub fn weights(place: f64, reach: f64) -> impl Iterator<Item = (i64, f64)> {
    // Of all sines, only the sign differs.
    let near = place.round();
    let sine = (PI * (near - place)).sin();
    let most = STEEP.cosh();
    let (first, last) = ((place - reach).ceil() as i64, (place + reach).floor() as i64);
    (first..=last).map(move |index| {
        let off = index as f64 - place;
        let sign = if (index - near as i64) & 1 == 1 { -1.0 } else { 1.0 };
        let sinc = if off.abs() < 1e-9 { 1.0 } else { sign * sine / (PI * off) };
        let grown = (STEEP * (1.0 - (off / reach).powi(2)).max(0.0).sqrt()).exp();
        (index, sinc * 0.5 * (grown + 1.0 / grown) / most)
    })
}

#[cfg(test)]
mod tests {
    use super::{PI, weights};

    /// Against the formula, tap by tap.
    #[test]
    fn weights_are_those_of_the_definition() {
        for reach in [16.0, 48.0] {
            for place in [0.25, 3.0, -7.6, 1000.5, 12.999_999_7, 1e6 + 0.125] {
                let mut count = 0;
                for (index, weight) in weights(place, reach) {
                    let off = index as f64 - place;
                    let sinc = if off == 0.0 { 1.0 } else { (PI * off).sin() / (PI * off) };
                    let window = (12.0 * (1.0 - (off / reach) * (off / reach)).sqrt()).cosh() / 12_f64.cosh();
                    assert!((weight - sinc * window).abs() < 1e-13, "{place} {index}: {weight}");
                    count += 1;
                }
                assert!((count - 2 * reach as i64).abs() <= 1, "{place}: {count} samples");
            }
        }
    }

    /// A sine is what it was between its samples.
    #[test]
    fn a_sine_is_itself_between_its_samples() {
        for share in [0.01, 0.125, 0.4] {
            for place in [100.1, 200.5, 333.9] {
                let sum: f64 = weights(place, 48.0)
                    .map(|(n, weight)| weight * (2.0 * PI * share * n as f64).sin())
                    .sum();
                let is = (2.0 * PI * share * place).sin();
                assert!((sum - is).abs() < 1e-5, "{share} {place}: {:e}", sum - is);
            }
        }
    }
}
