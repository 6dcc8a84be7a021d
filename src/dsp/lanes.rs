//! Lanes: the voices of an instrument run side by side, eight to a group.
//!
//! Kernels are plain loops over `[R; LANES]`, which the compiler turns into vector instructions. `R` is `f32` or `f64`
//! (a plan option). Nothing here contracts a multiply and an add, so every instruction set gives the same bits.

use super::sine;

/// Voices that a kernel runs side by side.
pub const LANES: usize = 8;

/// The number a kernel computes with: `f32` or `f64`.
pub trait Real:
    Copy
    + Default
    + PartialOrd
    + Send
    + Sync
    + std::fmt::Debug
    + std::ops::Add<Output = Self>
    + std::ops::Sub<Output = Self>
    + std::ops::Mul<Output = Self>
    + std::ops::Div<Output = Self>
    + std::ops::Neg<Output = Self>
    + std::ops::AddAssign
    + std::ops::SubAssign
    + std::ops::MulAssign
    + 'static
{
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// The nearest value of this type.
    fn of(value: f64) -> Self;
    /// As `f64`, exactly.
    fn wide(self) -> f64;
    /// Absolute value.
    fn abs(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// The greater of two; the other one where one is not a number.
    fn max(self, other: Self) -> Self;
    /// The smaller of two; the other one where one is not a number.
    fn min(self, other: Self) -> Self;
    /// Neither infinite nor not-a-number.
    fn is_finite(self) -> bool;
    /// Whether all values are finite.
    fn all_finite(rows: &[[Self; LANES]]) -> bool;
    /// Sine of a phase in turns (2^64 is one turn).
    fn sine(phase: u64) -> Self;
    /// Rows in single precision: themselves, or else copies in `scratch`, which must be as long.
    fn singles<'a>(rows: &'a mut [[Self; LANES]], scratch: &'a mut [[f32; LANES]]) -> &'a mut [[f32; LANES]];
}

macro_rules! real {
    ($t:ty, $sine:path, $singles:path) => {
        impl Real for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            #[inline(always)]
            fn of(value: f64) -> Self {
                value as $t
            }
            #[inline(always)]
            fn wide(self) -> f64 {
                self as f64
            }
            #[inline(always)]
            fn abs(self) -> Self {
                self.abs()
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                self.sqrt()
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other || other.is_nan() { self } else { other }
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other || other.is_nan() { self } else { other }
            }
            #[inline(always)]
            fn is_finite(self) -> bool {
                self.is_finite()
            }
            #[inline(always)]
            fn all_finite(rows: &[[Self; LANES]]) -> bool {
                // The exponents of all, or-ed, are all ones if one of them is not finite; seldom otherwise.
                let exponent = <$t>::INFINITY.to_bits();
                let mut bits = [0; LANES];
                // An unknown stride keeps the compiler to one row at a time: it would take eight and shuffle them.
                let step = std::hint::black_box(1);
                for frame in 0..rows.len() {
                    let row = &rows[frame * step];
                    for l in 0..LANES {
                        bits[l] |= row[l].to_bits();
                    }
                }
                let mut wild = false;
                for l in 0..LANES {
                    wild |= bits[l] & exponent == exponent;
                }
                !wild || rows.iter().flatten().all(|x| x.is_finite())
            }
            #[inline(always)]
            fn sine(phase: u64) -> Self {
                $sine(phase)
            }
            #[inline(always)]
            fn singles<'a>(
                rows: &'a mut [[Self; LANES]],
                scratch: &'a mut [[f32; LANES]],
            ) -> &'a mut [[f32; LANES]] {
                $singles(rows, scratch)
            }
        }
    };
}

fn same<'a>(rows: &'a mut [[f32; LANES]], _scratch: &'a mut [[f32; LANES]]) -> &'a mut [[f32; LANES]] {
    rows
}

fn rounded<'a>(rows: &'a mut [[f64; LANES]], scratch: &'a mut [[f32; LANES]]) -> &'a mut [[f32; LANES]] {
    for (to, from) in scratch.iter_mut().zip(rows.iter()) {
        for l in 0..LANES {
            to[l] = from[l] as f32;
        }
    }
    scratch
}

real!(f32, sine::sine32, same);
real!(f64, sine::sine64, rounded);
