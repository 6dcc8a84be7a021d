//! Sine of a part of a turn, for effects.
//!
//! The servo waits for one value, not for many: so the polynomial is summed as a tree (Estrin), in half the time of Horner's chain.

use crate::knob::order::smaller;

/// sin 2πy = y P(y²) for |y| ≤ ¼: P interpolated at Chebyshev's nodes, within 2.5e-16.
const P: [f64; 8] = [
    6.283_185_307_179_585,
    -41.341_702_240_398_284,
    81.605_249_275_579_77,
    -76.705_859_689_628_67,
    42.058_689_953_950_94,
    -15.094_506_140_734_29,
    3.817_365_633_469_135,
    -0.692_506_701_072_071_7,
];

/// sin 2πu for |u| ≤ ½, within 1e-15.
#[inline(always)]
pub fn sine(u: f64) -> f64 {
    // Folded to the quarter next to 0: ½ − |u| beyond it.
    let away = u.abs();
    let y = smaller(away, 0.5 - away);
    let z = y * y;
    let (zz, zzzz) = (z * z, (z * z) * (z * z));
    let low = (P[0] + P[1] * z) + (P[2] + P[3] * z) * zz;
    let high = (P[4] + P[5] * z) + (P[6] + P[7] * z) * zz;
    (y * (low + high * zzzz)).copysign(u)
}

/// cos 2πu for |u| ≤ ½, within 1e-15.
#[inline(always)]
pub fn cosine(u: f64) -> f64 {
    sine(0.25 - u.abs())
}

#[cfg(test)]
mod tests {
    use super::{cosine, sine};

    #[test]
    fn they_follow_the_standard_library() {
        for k in -50_000..=50_000 {
            let u = f64::from(k) * 1e-5;
            let angle = std::f64::consts::TAU * u;
            assert!((sine(u) - angle.sin()).abs() < 1e-15 && (cosine(u) - angle.cos()).abs() < 1e-15, "{u}");
        }
        assert_eq!((sine(0.0), sine(0.5), sine(-0.5), cosine(0.25)), (0.0, 0.0, 0.0, 0.0));
    }
}
