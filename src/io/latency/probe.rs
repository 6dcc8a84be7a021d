//! The sound that is sent round.

use std::f64::consts::{PI, TAU};

/// Seconds that it lasts, and the frequencies that it sweeps through, Hz: those that tactors have in common.
pub const SECONDS: f64 = 0.08;
const LOW: f64 = 60.0;
const HIGH: f64 = 900.0;

/// Its value `t` seconds after it began: a sweep, swelling and fading with a squared sine, so that it begins and ends without a corner.
pub fn at(t: f64) -> f64 {
    if !(0.0..=SECONDS).contains(&t) {
        return 0.0;
    }
    let swell = (PI * t / SECONDS).sin().powi(2);
    swell * (TAU * (LOW + 0.5 * (HIGH - LOW) * t / SECONDS) * t).sin()
}

#[cfg(test)]
mod tests {
    use super::{SECONDS, at};

    #[test]
    fn it_ends_where_it_begins_and_is_nowhere_steep() {
        assert_eq!((at(-1e-9), at(SECONDS + 1e-9), at(f64::NAN)), (0.0, 0.0, 0.0));
        let all: Vec<f64> = (0..4000).map(|n| at(f64::from(n) / 48_000.0)).collect();
        assert!(all.iter().any(|x| x.abs() > 0.99) && all.iter().all(|x| x.abs() <= 1.0));
        // 900 Hz at full level: 2 pi 900 / 48000 a frame.
        assert!(all.windows(2).all(|w| (w[1] - w[0]).abs() < 0.118));
    }
}
