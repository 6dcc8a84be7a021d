//! Elementary functions for a step, in `f64`, the same to the bit on every machine.
//!
//! They are made of additions, multiplications and divisions alone, good to the last place or two: a platform's own may differ there. Those of
//! [`crate::dsp::elementary`] are for signals: they keep to finite numbers, and to fewer places.

/// Added and taken away, it rounds to a whole number: 1.5 × 2^52.
const ROUNDING: f64 = 6_755_399_441_055_744.0;
/// The same for halves: 1.5 × 2^51.
const HALVING: f64 = 3_377_699_720_527_872.0;
/// ln 2 in two parts; the product of the first with a whole number below 2^20 is exact.
const LN_2: (f64, f64) = (0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10);
/// Below this e^x is taken for 0.
const LEAST: f64 = -700.0;
/// Above this e^x is no larger.
const MOST: f64 = 700.0;

/// sin 2πy = y P(y²) for |y| ≤ ¼: P interpolated at Chebyshev's nodes, within 2.5e-16.
const SINE: [f64; 8] = [
    6.283_185_307_179_585,
    -41.341_702_240_398_284,
    81.605_249_275_579_77,
    -76.705_859_689_628_67,
    42.058_689_953_950_94,
    -15.094_506_140_734_29,
    3.817_365_633_469_135,
    -0.692_506_701_072_071_7,
];

/// 1 / n!
const INVERSE_FACTORIAL: [f64; 15] = {
    let (mut all, mut n) = ([1.0; 15], 1);
    while n < 15 {
        all[n] = all[n - 1] / n as f64;
        n += 1;
    }
    all
};

/// e^x within 1.2 units in the last place; 0 below −700, e^700 above 700, 0 for what is not a number.
pub fn exp(x: f64) -> f64 {
    if x.is_nan() || x < LEAST {
        return 0.0;
    }
    let x = x.min(MOST);
    let shifted = x * std::f64::consts::LOG2_E + ROUNDING;
    let whole = shifted - ROUNDING;
    let y = (x - whole * LN_2.0) - whole * LN_2.1;
    let mut sum = INVERSE_FACTORIAL[13];
    for n in (2..13).rev() {
        sum = INVERSE_FACTORIAL[n] + y * sum;
    }
    // The low bits of the shifted number are the whole part.
    let scale = f64::from_bits((shifted.to_bits() << 52).wrapping_add(1023 << 52));
    (1.0 + (y + y * y * sum)) * scale
}

/// e^x − 1, to about one unit in the last place of it for x below 0.3 and of e^x above.
///
/// Infinite above 709, −1 below −50; what is not a number gives 0.
#[inline]
pub fn exp_m1(x: f64) -> f64 {
    if x.is_nan() {
        return 0.0;
    }
    if x < -50.0 {
        return -1.0;
    }
    if x > 709.0 {
        return f64::INFINITY;
    }
    // x = k ln 2 + r with |r| at most half of ln 2.
    let k = (x * std::f64::consts::LOG2_E).round();
    let high = x - k * LN_2.0;
    let r = high - k * LN_2.1;
    let lost = (high - r) - k * LN_2.1;
    let mut tail = 0.0;
    for term in INVERSE_FACTORIAL[2..].iter().rev() {
        tail = tail * r + term;
    }
    let small = r + (r * r * tail + lost * (1.0 + r));
    if k == 0.0 {
        return small;
    }
    let power = f64::from_bits(((1023 + k as i64) as u64) << 52);
    power * small + (power - 1.0)
}

/// Natural logarithm of a positive normal number, within 2 units in the last place or 2e-16; 0 for anything else.
pub fn ln(x: f64) -> f64 {
    if !x.is_normal() || x < 0.0 {
        return 0.0;
    }
    // Mantissa within √½ and √2.
    let bits =
        x.to_bits().wrapping_add((1023_u64 << 52).wrapping_sub(std::f64::consts::FRAC_1_SQRT_2.to_bits()));
    let exponent = (bits >> 52) as i64 - 1023;
    let mantissa = f64::from_bits(x.to_bits().wrapping_sub((exponent << 52) as u64));
    let s = (mantissa - 1.0) / (mantissa + 1.0);
    let z = s * s;
    let mut sum = 1.0 / 23.0;
    for k in (1..11).rev() {
        sum = sum * z + 1.0 / (2 * k + 1) as f64;
    }
    let exponent = exponent as f64;
    exponent * LN_2.0 + (2.0 * s + (2.0 * s * z * sum + exponent * LN_2.1))
}

/// Sine of an angle in turns, within 6e-16; turns beyond 2^50 count as none.
#[inline(always)]
pub fn sine(turns: f64) -> f64 {
    let shifted = turns + HALVING;
    let y = turns - (shifted - HALVING);
    let z = y * y;
    let (two, c) = (z * z, &SINE);
    let low = (c[0] + c[1] * z) + (c[2] + c[3] * z) * two;
    let high = (c[4] + c[5] * z) + (c[6] + c[7] * z) * two;
    // The lowest bit of the shifted number tells odd half turns, which turn the sign.
    let y = f64::from_bits(y.to_bits() ^ (shifted.to_bits() << 63));
    y * low + (y * (two * two)) * high
}

/// Cosine of an angle in turns, as [`sine`].
#[inline(always)]
pub fn cosine(turns: f64) -> f64 {
    // A quarter from the nearer half turn, so that adding it rounds nothing that matters.
    sine(0.25 - turns.abs())
}

/// An angle in turns without the whole ones, within ±½, and the whole ones.
#[inline(always)]
pub fn wrapped(turns: f64) -> (f64, f64) {
    let whole = (turns + ROUNDING) - ROUNDING;
    (turns - whole, whole)
}

#[cfg(test)]
mod tests {
    use super::{cosine, exp, exp_m1, ln, sine, wrapped};

    /// Numbers within ±1 that look random.
    fn mixed(n: u64) -> f64 {
        let n = (n ^ 0x5851_f42d_4c95_7f2d).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let n = (n ^ (n >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        ((n ^ (n >> 32)) as i64) as f64 / 9_223_372_036_854_775_808.0
    }

    #[test]
    fn they_follow_the_functions_of_the_standard_library() {
        let ulp = f64::EPSILON;
        for n in 0..200_000 {
            let u = mixed(n);
            for x in [u * 650.0, u, u * 1e-3] {
                assert!((exp(x) - x.exp()).abs() <= 1.2 * ulp * x.exp(), "exp {x}");
            }
            let x = (u * 300.0).exp();
            assert!((ln(x) - x.ln()).abs() <= 2.0 * ulp * x.ln().abs(), "ln {x}");
            let x = 1.0 + 0.3 * u;
            assert!((ln(x) - x.ln()).abs() <= 2.0 * ulp * x.ln().abs(), "ln {x}");
            let (s, c) = (std::f64::consts::TAU * u * 0.5).sin_cos();
            assert!((sine(u * 0.5) - s).abs() < 8e-16 && (cosine(u * 0.5) - c).abs() < 8e-16, "sine {u}");
        }
    }

    #[test]
    fn a_sine_keeps_its_symmetries_to_the_bit() {
        for n in 0..10_000 {
            let t = mixed(n);
            assert_eq!(sine(-t), -sine(t));
            assert_eq!(cosine(-t), cosine(t));
        }
        assert_eq!((sine(0.0), sine(0.5), sine(-0.5), sine(1.0), cosine(0.25)), (0.0, 0.0, 0.0, 0.0, 0.0));
        assert!((sine(0.25) - 1.0).abs() < 6e-16 && (sine(-0.75) - 1.0).abs() < 6e-16);
        assert!((cosine(0.5) + 1.0).abs() < 6e-16 && (sine(7.25) - 1.0).abs() < 6e-16);
    }

    #[test]
    fn whole_turns_come_off_exactly() {
        assert_eq!(wrapped(0.75), (-0.25, 1.0));
        assert_eq!(wrapped(-123_456.25), (-0.25, -123_456.0));
    }

    #[test]
    fn nothing_but_numbers_comes_out() {
        for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 0.0, 1e-310, -1.0] {
            assert!(exp(x).is_finite() && ln(x).is_finite(), "{x}");
        }
        assert_eq!((exp(0.0), exp(-1e9), ln(1.0)), (1.0, 0.0, 0.0));
    }

    #[test]
    fn what_exp_m1_gives_is_the_exponential_function_less_one() {
        let mut worst: f64 = 0.0;
        for n in -60_000..=60_000 {
            let x = f64::from(n) * 1.234_567e-4;
            for x in [x, x * 1e-3, x * 1e-9] {
                let (is, wanted) = (exp_m1(x), x.exp_m1());
                // Near a carry from −1 the last place is that of e^x, not of the difference.
                let unit = f64::EPSILON * wanted.abs().max(if x < -0.3 { 1.0 } else { 0.0 });
                if x != 0.0 {
                    worst = worst.max((is - wanted).abs() / unit);
                }
            }
        }
        assert!(worst < 1.1, "{worst}");
        assert!((1..700).all(|n| ((exp_m1(f64::from(n)) + 1.0) / f64::from(n).exp() - 1.0).abs() < 4e-16));
    }

    #[test]
    fn no_argument_of_exp_m1_is_too_wild() {
        assert_eq!((exp_m1(0.0), exp_m1(f64::NAN), exp_m1(f64::NEG_INFINITY)), (0.0, 0.0, -1.0));
        assert_eq!((exp_m1(1e300), exp_m1(-1e300), exp_m1(-745.0)), (f64::INFINITY, -1.0, -1.0));
        assert!(exp_m1(709.0).is_finite());
        assert_eq!(exp_m1(1e-310), 1e-310);
    }
}
