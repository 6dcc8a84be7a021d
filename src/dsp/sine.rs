//! Sine of a phase given as a 64-bit fraction of a turn.
//!
//! sin 2πx = x (1 − 4x²) P(x²) on [−½, ½], so that the zeros at 0 and ±½ are exact; P interpolates at Chebyshev nodes.
//! Largest error of the formula: 3.4e-9 with six coefficients, 7e-18 with ten; rounding then decides.

// The coefficients are near multiples of π, but they are not those.
#[allow(clippy::approx_constant, clippy::excessive_precision)]
const SINGLE: [f32; 6] = [6.283_185_3, -16.208_956, 16.769_156, -9.623_957_7, 3.512_360_9, -0.790_312_46];

#[allow(clippy::approx_constant, clippy::excessive_precision)]
const DOUBLE: [f64; 10] = [
    6.283_185_307_179_586_440_6,
    -16.208_961_011_681_385_245,
    16.769_405_229_345_556_608,
    -9.628_238_835_467_018_443_9,
    3.545_738_597_119_716_726_3,
    -0.911_688_091_207_806_433_94,
    0.173_199_214_654_433_386_13,
    -0.025_318_698_603_408_372_422,
    0.002_925_037_243_714_913_393_8,
    -0.000_251_426_782_564_849_367_58,
];

/// For half the sine, in powers of 4x²: scaled by powers of two, which are exact.
const HALF: [f32; 6] = {
    let (mut scaled, mut k, mut scale) = (SINGLE, 0, 0.5);
    while k < 6 {
        scaled[k] *= scale;
        scale /= 4.0;
        k += 1;
    }
    scaled
};

/// Sine of `phase` (2^64 is one turn), within 3e-7.
#[inline(always)]
pub fn sine32(phase: u64) -> f32 {
    let twice = ((phase >> 32) as u32 as i32) as f32 * (1.0 / 2_147_483_648.0);
    let z = twice * twice;
    let mut p = HALF[5];
    p = p * z + HALF[4];
    p = p * z + HALF[3];
    p = p * z + HALF[2];
    p = p * z + HALF[1];
    p = p * z + HALF[0];
    (twice - twice * z) * p
}

/// Sine of `phase` (2^64 is one turn), within 1e-15.
#[inline(always)]
pub fn sine64(phase: u64) -> f64 {
    let x = (phase as i64) as f64 * (1.0 / 18_446_744_073_709_551_616.0);
    let z = x * x;
    let mut p = DOUBLE[9];
    for c in DOUBLE[..9].iter().rev() {
        p = p * z + c;
    }
    (x - x * (z * 4.0)) * p
}

#[cfg(test)]
mod tests {
    use super::{sine32, sine64};

    #[test]
    fn both_follow_the_sine_over_a_turn() {
        for k in 0..100_000_u64 {
            let phase = k.wrapping_mul(0x9E37_79B9_7F4A_7C15);
            let exact = (phase as i64 as f64 / 2f64.powi(64) * std::f64::consts::TAU).sin();
            assert!((f64::from(sine32(phase)) - exact).abs() < 3e-7, "sine32 at {phase:#x}");
            assert!((sine64(phase) - exact).abs() < 1e-15, "sine64 at {phase:#x}");
        }
    }

    #[test]
    fn the_quarters_are_exact() {
        assert_eq!(sine32(0), 0.0);
        assert_eq!(sine64(1 << 63), 0.0);
        assert!((sine64(1 << 62) - 1.0).abs() < 1e-15);
    }
}
