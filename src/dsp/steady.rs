//! What the limiter leaves of a steady tone.

/// Frequencies (Hz), and the share of `max_level` up to which a steady tone that begins at once passes limiter and band limit as it is. Up to 475 Hz it is
/// a round figure, a little below what passes. Above, a tone is held to where the band limit keeps to the ceiling when it stops dead, and its onset holds it
/// up to 0.4 dB lower still; from 850 Hz on the band limit takes it away. Measured on an engine at 8 kHz. By the limiter's predictions it is the same up to
/// 12 kHz within 0.1 dB up to 850 Hz, and up to 0.3 dB less at 6 kHz.
const SHARES: [[f64; 2]; 14] = [
    [475.0, 0.9],
    [500.0, 0.89],
    [550.0, 0.86],
    [600.0, 0.85],
    [650.0, 0.8],
    [700.0, 0.765],
    [750.0, 0.74],
    [800.0, 0.688],
    [825.0, 0.67],
    [850.0, 0.67],
    [875.0, 0.48],
    [900.0, 0.24],
    [950.0, 0.031],
    [1000.0, 0.001],
];

/// The share of `max_level` up to which the limiter lets a steady tone of a frequency (Hz) pass as it is. For the audio thread.
pub fn steady(hertz: f64) -> f64 {
    let next = SHARES.partition_point(|[at, _]| *at < hertz);
    let Some([after, high]) = SHARES.get(next) else { return SHARES[SHARES.len() - 1][1] };
    let Some([before, low]) = next.checked_sub(1).and_then(|before| SHARES.get(before)) else { return *high };
    low + (high - low) * (hertz - before) / (after - before)
}

#[cfg(test)]
mod tests {
    use super::{SHARES, steady};

    #[test]
    fn it_goes_through_its_points_and_is_straight_between_them() {
        for [hertz, share] in SHARES {
            assert!((steady(hertz) - share).abs() < 1e-12, "{hertz}");
        }
        assert!((steady(625.0) - 0.5 * (0.85 + 0.8)).abs() < 1e-12);
        assert_eq!((steady(10.0), steady(f64::NAN), steady(2000.0)), (0.9, 0.9, 0.001));
    }
}
