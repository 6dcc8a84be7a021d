//! The steps in which a device takes samples. What goes out is rounded to them before it is recorded, so that what is kept is what the device was given.

#![deny(clippy::disallowed_methods)]

/// The sum of this and any whole number of steps of a sample has no bits left for parts of a step: it is rounded to the nearest, of two as
/// near to the even one.
const WHOLE: f64 = 1.5 * (1_u64 << 52) as f64;

/// Steps of a device, from -1 to 1; those of floating point change nothing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Steps {
    /// Bits of a sample; 0: floating point.
    bits: u8,
}

impl Steps {
    /// Of 32-bit floating point.
    pub const FLOAT: Self = Self { bits: 0 };

    /// Of whole numbers of so many bits, from 2 to 32; `None` for others.
    pub fn of(bits: u8) -> Option<Self> {
        (2..=32).contains(&bits).then_some(Self { bits })
    }

    /// Bits of a sample, if they are whole numbers.
    pub fn bits(self) -> Option<u8> {
        (self.bits > 0).then_some(self.bits)
    }

    /// Rounds samples to the nearest step, and those beyond the last to the last: that is one short of 1. Zero stays zero. No noise is added, as silence is to be
    /// silence, so what is far below a step is not felt.
    pub fn round(self, samples: &mut [f32]) {
        let Some(bits) = self.bits() else { return };
        let one = (1_u64 << (bits - 1)) as f64;
        let (least, most, step) = (-one, one - 1.0, 1.0 / one);
        for sample in samples {
            let whole = (f64::from(*sample) * one + WHOLE) - WHOLE;
            // What is no number stays none, and the device takes it as 0.
            *sample = (whole.clamp(least, most) * step) as f32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Steps;
    use proptest::prelude::*;

    fn rounded(bits: u8, x: f32) -> f32 {
        let mut samples = [x];
        Steps::of(bits).unwrap().round(&mut samples);
        samples[0]
    }

    #[test]
    fn ends_zeros_and_halves() {
        for bits in [2, 8, 16, 24] {
            let step = 0.5_f32.powi(i32::from(bits) - 1);
            assert_eq!(rounded(bits, 1.0), 1.0 - step, "{bits} bits: the last one");
            assert_eq!((rounded(bits, 7.0), rounded(bits, -7.0)), (1.0 - step, -1.0));
            for (x, is) in [(0.0, 0.0), (0.49, 0.0), (0.51, 1.0), (-0.51, -1.0), (-0.49, 0.0), (0.5, 0.0)] {
                assert_eq!(rounded(bits, x * step), is * step, "{bits} bits, {x} steps");
            }
        }
        // Finer than a sample of floating point near 1, where all is as it was.
        assert_eq!((rounded(32, 1.0), rounded(32, 0.999_999_94)), (1.0, 0.999_999_94));
        assert_eq!(rounded(32, 0.6 * 0.5_f32.powi(31)), 0.5_f32.powi(31));
        assert!(rounded(16, f32::NAN).is_nan());
        assert_eq!((rounded(16, f32::INFINITY), rounded(24, -1e30)), (1.0 - 0.5_f32.powi(15), -1.0));
        assert_eq!([0, 1, 33, 255].map(Steps::of), [None; 4]);
        let mut same = [0.1, -0.3, f32::MIN_POSITIVE];
        Steps::FLOAT.round(&mut same);
        assert_eq!((same, Steps::FLOAT.bits()), ([0.1, -0.3, f32::MIN_POSITIVE], None));
    }

    proptest! {
        #[test]
        fn each_is_within_half_a_step_on_a_step_and_stays_there(bits in 2_u8..=24, x in -1.0_f32..1.0) {
            let step = 0.5_f64.powi(i32::from(bits) - 1);
            let is = rounded(bits, x);
            let off = (f64::from(is) - f64::from(x)).abs();
            let most = if f64::from(x) > 1.0 - step { step } else { step / 2.0 };
            prop_assert!(off <= most, "{} from {}", off, x);
            prop_assert_eq!((f64::from(is) / step).fract(), 0.0);
            prop_assert_eq!(rounded(bits, is), is);
            // Both sides are alike, but for the last step, of which there is one side.
            prop_assert!(rounded(bits, -x) == -is || f64::from(x.abs()) > 1.0 - step);
        }
    }
}
