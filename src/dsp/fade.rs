//! The fade of a voice that comes or goes without an envelope of its own, and of one that must make room: a definition that
//! engine and scene reference share, since it says what is to be felt, not how that is computed.

/// Seconds in which a voice that must make room falls silent, and in which one without an envelope comes and goes.
pub const FADE: f64 = 0.004;

/// Seconds in which a voice that sounds goes over into what a new plan makes of it. In 20 ms, two sawtooths of 60 and 90 Hz step 1.4 % further on
/// their way than by themselves, and a tone of 800 Hz that becomes louder 2 %, as its sidebands reach where the band limit takes less; in
/// 50 ms it is 0.3 and 0.1 %.
pub const CROSS: f64 = 0.05;

/// Seconds in which a voice falls silent that must do so at once: 5 ms later less than a hundredth of it is left, of a tone up to 200 Hz
/// (of 500 Hz 10 ms later, of 800 Hz 30). One that went faster would make the band limit ring for longer.
pub const HUSH: f64 = 0.003;

/// Gain of a voice that falls silent, `seconds` after it began to: 1 − (10 x³ − 15 x⁴ + 6 x⁵) with x = `seconds` / [`FADE`], 1
/// before and 0 after. It is the polynomial of least degree whose slope and curvature are 0 at both ends.
pub fn fade(seconds: f64) -> f64 {
    let x = (seconds / FADE).clamp(0.0, 1.0);
    1.0 - x * x * x * (10.0 - x * (15.0 - 6.0 * x))
}

#[cfg(test)]
mod tests {
    use super::{FADE, fade};

    #[test]
    fn it_goes_from_one_to_zero_and_stays() {
        for early in [f64::NEG_INFINITY, -1.0, -1e-9, 0.0] {
            assert_eq!(fade(early), 1.0);
        }
        for late in [FADE, 0.005, 1.0, f64::INFINITY] {
            assert_eq!(fade(late), 0.0);
        }
        // By hand: 10/64 − 15/256 + 6/1024 = 106/1024 at a quarter.
        assert_eq!(fade(0.25 * FADE), 1.0 - 106.0 / 1024.0);
        assert_eq!(fade(0.5 * FADE), 0.5);
    }

    #[test]
    fn what_comes_and_what_goes_add_up_to_one() {
        for i in 0..=1000 {
            let x = f64::from(i) / 1000.0;
            assert!((fade(x * FADE) + fade((1.0 - x) * FADE) - 1.0).abs() < 1e-14, "{x}");
        }
    }

    #[test]
    fn its_slope_is_that_of_the_closed_form() {
        // d/dx of x³ (10 − 15 x + 6 x²) is 30 x² (1 − x)²: 0 at both ends, as is its own slope.
        let h = 1e-6;
        for i in 0..=100 {
            let x = f64::from(i) / 100.0;
            let slope = (fade((x + h) * FADE) - fade((x - h) * FADE)) / (2.0 * h);
            let wanted = -30.0 * (x * (1.0 - x)).powi(2);
            assert!((slope - wanted).abs() < 1e-8, "{x}: {slope} for {wanted}");
        }
    }
}
