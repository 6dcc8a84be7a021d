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

    /// How many there are from 0 to 1.
    fn count(self) -> f64 {
        self.bits().map_or(f64::INFINITY, |bits| (1_u64 << (bits - 1)) as f64)
    }
}

/// Rounds what leaves channels to steps.
#[derive(Debug)]
pub struct Rounding {
    steps: Steps,
    /// The most that leaves each channel, in steps, and the last whole one of those.
    ceilings: Vec<(f64, f64)>,
    levels: Vec<f32>,
}

impl Rounding {
    /// Changes nothing of so many channels.
    pub fn none(width: usize) -> Self {
        Self {
            steps: Steps::FLOAT,
            ceilings: vec![(f64::INFINITY, f64::INFINITY); width],
            levels: vec![1.0; width],
        }
    }

    /// From now on, to these steps.
    pub fn to(&mut self, steps: Steps) {
        self.steps = steps;
        self.raise();
    }

    /// From now on, no more than this leaves each channel, and rounding adds nothing to that.
    pub fn below(&mut self, levels: &[f32]) {
        self.levels.iter_mut().zip(levels).for_each(|(most, level)| *most = *level);
        self.raise();
    }

    fn raise(&mut self) {
        let count = self.steps.count();
        for (ceiling, level) in self.ceilings.iter_mut().zip(&self.levels) {
            let most = f64::from(*level) * count;
            *ceiling = (most, most.floor());
        }
    }

    /// Rounds interleaved frames to the nearest steps; what is beyond the last becomes that, which is one short of 1. What keeps to the level of its
    /// channel does so afterwards: there it is the last step within it. Zero stays zero. No noise is added, as silence is to be silence, so what
    /// is far below a step is not felt.
    pub fn round(&self, frames: &mut [f32]) {
        if self.steps == Steps::FLOAT {
            return;
        }
        let one = self.steps.count();
        let (least, most, step) = (-one, one - 1.0, 1.0 / one);
        for frame in frames.chunks_mut(self.ceilings.len().max(1)) {
            for (sample, (ceiling, last)) in frame.iter_mut().zip(&self.ceilings) {
                let exact = f64::from(*sample) * one;
                let whole = (exact + WHOLE) - WHOLE;
                // Where a plan takes over, what is left of the one before may be above what leaves the new one.
                let bound = if exact.abs() <= *ceiling { *last } else { one };
                let within = whole.min(bound).max(-bound).clamp(least, most);
                // What is no number stays none, and the device takes it as 0.
                *sample = if exact.is_nan() { *sample } else { (within * step) as f32 };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Rounding, Steps};
    use proptest::prelude::*;

    fn rounded_below(bits: u8, level: f32, x: f32) -> f32 {
        let mut rounding = Rounding::none(2);
        rounding.below(&[1.0, level]);
        rounding.to(Steps::of(bits).unwrap());
        let mut samples = [0.7, x];
        rounding.round(&mut samples);
        samples[1]
    }

    fn rounded(bits: u8, x: f32) -> f32 {
        rounded_below(bits, 1.0, x)
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
        Rounding::none(1).round(&mut same);
        assert_eq!((same, Steps::FLOAT.bits()), ([0.1, -0.3, f32::MIN_POSITIVE], None));
    }

    /// Of what leaves at a level that is no step, rounding would make more than that.
    #[test]
    fn no_more_than_its_level_leaves_a_channel() {
        let step = 0.5_f32.powi(15);
        assert_eq!((rounded_below(16, 0.0003, 0.0003), rounded(16, 0.0003)), (9.0 * step, 10.0 * step));
        assert_eq!(rounded_below(16, 0.0003, -0.0003), -9.0 * step);
        // Below the last step within it, to the nearest as anywhere.
        assert_eq!(rounded_below(16, 0.0003, 8.6 * step), 9.0 * step);
        assert_eq!(rounded_below(16, 1e-5, 1e-5), 0.0);
        // What is above was let through by a plan that goes.
        assert_eq!(rounded_below(16, 0.0003, 0.5), 0.5);
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

        #[test]
        fn what_keeps_to_a_level_does_so_afterwards(bits in 2_u8..=32, level in 0.0_f32..=1.0, part in -1.0_f32..=1.0) {
            let (x, step) = (level * part, 0.5_f64.powi(i32::from(bits) - 1));
            let is = rounded_below(bits, level, x);
            prop_assert!(is.abs() <= level);
            prop_assert!((f64::from(is) - f64::from(x)).abs() <= step);
        }
    }
}
