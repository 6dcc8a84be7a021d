//! Elementary functions for kernels, the same to the bit on every machine, in `f64`.
//!
//! Argument reduction and a Taylor series each, no table; within 2e-15 of the value, relative, where the argument is small, and
//! within a rounding of a large argument elsewhere. They take any number and return a finite one.

use super::phase;
use super::sine::sine64;

/// The largest number that comes out.
pub const MOST: f64 = 1e30;

/// Added and taken away, it rounds to a whole number: 1.5 × 2^52.
const ROUNDING: f64 = 6_755_399_441_055_744.0;
/// The 2^n below which a result is 0.
const LEAST_EXPONENT: f64 = -1000.0;

/// Within ±[`MOST`]; what is not a number becomes 0.
#[inline(always)]
pub fn finite(x: f64) -> f64 {
    if x.abs() <= MOST {
        x
    } else if x > 0.0 {
        MOST
    } else if x < 0.0 {
        -MOST
    } else {
        0.0
    }
}

/// The n beyond which 2^n is no larger: just below [`MOST`].
const MOST_EXPONENT: f64 = 99.657;

/// 2^x, from 0 to [`MOST`].
#[inline(always)]
pub fn exp2(x: f64) -> f64 {
    let x = if x > LEAST_EXPONENT { x } else { LEAST_EXPONENT };
    let x = if x < MOST_EXPONENT { x } else { MOST_EXPONENT };
    let shifted = x + ROUNDING;
    let y = (x - (shifted - ROUNDING)) * std::f64::consts::LN_2;
    let mut sum = 1.0;
    for k in (1..=13).rev() {
        sum = 1.0 + y * sum * INVERSE[k];
    }
    // The low bits of the shifted number are the whole part.
    let scale = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1023 << 52));
    if x > LEAST_EXPONENT { sum * scale } else { 0.0 }
}

const INVERSE: [f64; 14] = {
    let (mut all, mut k) = ([0.0; 14], 1);
    while k < 14 {
        all[k] = 1.0 / k as f64;
        k += 1;
    }
    all
};

/// e^x, from 0 to [`MOST`].
#[inline(always)]
pub fn exp(x: f64) -> f64 {
    exp2(x * std::f64::consts::LOG2_E)
}

/// Natural logarithm; below 1e-30 that of 1e-30.
#[inline(always)]
pub fn ln(x: f64) -> f64 {
    let x = if x > 1e-30 { x } else { 1e-30 };
    let x = if x < 1e300 { x } else { 1e300 };
    // Mantissa within √½ and √2.
    let bits =
        x.to_bits().wrapping_add((1023_u64 << 52).wrapping_sub(std::f64::consts::FRAC_1_SQRT_2.to_bits()));
    let exponent = (bits >> 52) as i32 - 1023;
    let mantissa = f64::from_bits(x.to_bits().wrapping_sub((i64::from(exponent) << 52) as u64));
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let z = s * s;
    let mut sum = 1.0 / 21.0;
    for k in (0..10).rev() {
        sum = sum * z + 1.0 / (2 * k + 1) as f64;
    }
    2.0 * s * sum + f64::from(exponent) * std::f64::consts::LN_2
}

/// Sine of an angle in radians; 0 where it is beyond 1e15.
#[inline(always)]
pub fn sin(x: f64) -> f64 {
    sine64(phase_of(x * (0.5 / std::f64::consts::PI)))
}

/// Turns as a phase, without the whole turns; 0 beyond ±2^50.
#[inline(always)]
pub fn phase_of(turns: f64) -> u64 {
    phase::deviation(fraction(turns))
}

/// What is left of turns without the whole ones, within ±½; 0 beyond ±2^50.
#[inline(always)]
pub fn fraction(turns: f64) -> f64 {
    let turns = if turns.abs() < 1.1e15 { turns } else { 0.0 };
    turns - ((turns + ROUNDING) - ROUNDING)
}

/// a^b. A base of 0 gives 0 (1 for b = 0); a negative one has a power where b is whole and gives 0 elsewhere.
#[inline(always)]
pub fn power(a: f64, b: f64) -> f64 {
    if b == 0.0 {
        return 1.0;
    }
    if a == 0.0 || a.is_nan() || b.is_nan() {
        return 0.0;
    }
    let size = exp2(b * (ln(a.abs()) * std::f64::consts::LOG2_E));
    if a > 0.0 {
        return size;
    }
    let whole = if b.abs() < 1e15 { (b + ROUNDING) - ROUNDING } else { b };
    let half = if b.abs() < 1e15 { (b * 0.5 + ROUNDING) - ROUNDING } else { b * 0.5 };
    if whole != b {
        0.0
    } else if half * 2.0 == b {
        size
    } else {
        -size
    }
}

#[cfg(test)]
mod tests {
    use super::{MOST, exp, exp2, finite, ln, power, sin};
    use crate::dsp::random::uniform;

    #[test]
    fn they_follow_the_functions_of_the_standard_library() {
        for n in 0..100_000 {
            let u = uniform(1, n);
            let near = |got: f64, exact: f64, most: f64| {
                assert!((got - exact).abs() <= most * exact.abs().max(1e-30), "{u}: {got} {exact}");
            };
            near(exp2(u), u.exp2(), 2e-15);
            near(exp(60.0 * u), (60.0 * u).exp(), 1e-13);
            let x = (60.0 * u).exp();
            assert!((ln(x) - x.ln()).abs() < 2e-15 * x.ln().abs().max(1.0), "{x}");
            assert!((sin(10.0 * u) - (10.0 * u).sin()).abs() < 2e-15 * 10.0);
            near(power(x, 0.3), x.powf(0.3), 1e-13);
        }
        assert_eq!((power(-2.0, 3.0).round(), power(-2.0, 2.0).round(), power(-2.0, 0.5)), (-8.0, 4.0, 0.0));
        assert_eq!((power(0.0, 2.0), power(0.0, 0.0), power(0.0, -1.0)), (0.0, 1.0, 0.0));
        assert_eq!((exp(-1e9), ln(1.0), sin(0.0)), (0.0, 0.0, 0.0));
        assert!((exp2(5.0) - 32.0).abs() < 1e-13);
    }

    #[test]
    fn nothing_but_numbers_comes_out() {
        let wild = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, -1.0, 1e300, -1e300, 1e-310, 99.7];
        for a in wild {
            for value in [exp(a), exp2(a), ln(a), sin(a), finite(a)] {
                assert!(value.is_finite() && value.abs() <= MOST * 1.000_001, "{a}: {value}");
            }
            for b in wild {
                assert!(power(a, b).is_finite(), "{a} ^ {b}");
            }
        }
    }
}
