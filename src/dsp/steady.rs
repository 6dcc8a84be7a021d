//! What the limiter leaves of a steady tone.

/// Frequencies (Hz), and the share of `max_level` up to which a steady tone passes the limiter and the band limit as it is. Up to 500 Hz it is a round
/// figure, 0.1 to 0.4 dB below what passes. Above, such a tone is held to where the band limit still keeps to the ceiling when it stops dead, and above
/// 850 Hz the band limit takes it away. Worked out at 8 kHz from the limiter's predictions; from 8 to 12 kHz they differ by 0.1 dB up to 850 Hz, and at
/// 6 kHz up to 0.3 dB less passes.
const SHARES: [[f64; 2]; 13] = [
    [500.0, 0.9],
    [550.0, 0.895],
    [600.0, 0.875],
    [650.0, 0.841],
    [700.0, 0.802],
    [750.0, 0.762],
    [800.0, 0.709],
    [825.0, 0.69],
    [850.0, 0.681],
    [875.0, 0.484],
    [900.0, 0.241],
    [950.0, 0.033],
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
        assert!((steady(625.0) - 0.5 * (0.875 + 0.841)).abs() < 1e-12);
        assert_eq!((steady(10.0), steady(f64::NAN), steady(2000.0)), (0.9, 0.9, 0.001));
    }
}
