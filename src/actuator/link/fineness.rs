//! How finely what a converter gives between its samples is followed before diodes.
//!
//! A motor's steps hold what is before the diodes for a part of a frame each. A half-wave in few such parts has another mean above what stands against
//! it than a smooth one: its share of the amplitude goes with the square of the turns that pass in a part.

use super::converter::MOST_PARTS;

/// The error of a motor's speed, as a share of the rated one, is at most this times the square of the turns of the carrier in a part. Without a coil and
/// with such as keep their current for up to 40 turns, at 2.2 to 24 samples a turn, it is 0.001 to 4.1: the most for one that runs beyond its rated
/// speed.
const LAW: f64 = 5.0;

/// What is left of that error however small the parts: converters are within 2e-6 of a carrier's amplitude, and what stands against it makes more of that.
const CONVERTER: f64 = 1e-5;

/// Steps of a motor in a second, at most.
const MOST_RATE: f64 = 1e8;

/// Parts of a frame for a carrier (Hz) at so many frames a second and an error of the speed (a share of the rated one): a power of 2, at most [`MOST_PARTS`]; and
/// the error that is left.
pub fn parts(hertz: f64, rate: f64, error: f64) -> (u32, f64) {
    let mut parts = 1;
    loop {
        let turned = hertz / rate / f64::from(parts);
        let left = LAW * turned * turned + CONVERTER;
        if left <= error || parts >= MOST_PARTS || 2.0 * rate * f64::from(parts) > MOST_RATE {
            return (parts, left);
        }
        parts *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::{CONVERTER, LAW, MOST_PARTS, MOST_RATE, parts};

    #[test]
    fn a_wish_gets_as_many_parts_as_it_takes() {
        assert_eq!(parts(4000.0, 48_000.0, 0.1).0, 1);
        let (count, left) = parts(4000.0, 48_000.0, 5e-4);
        let at = |count: u32| LAW * (4000.0 / 48_000.0 / f64::from(count)).powi(2) + CONVERTER;
        assert!(count == 16 && (left - at(16)).abs() < 1e-12 && at(8) > 5e-4, "{count} {left}");
        assert_eq!(parts(21_600.0, 48_000.0, 1e-9).0, MOST_PARTS);
        for rate in [1e6, 3.3e6, 1e7] {
            let (count, left) = parts(40_000.0, rate, 1e-9);
            assert!(f64::from(count) * rate <= MOST_RATE && left >= CONVERTER, "{rate} {count}");
        }
    }
}
