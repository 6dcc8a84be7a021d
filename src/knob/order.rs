//! The smaller and the larger of two numbers, one instruction each.
//!
//! [`f64::min`] and [`f64::max`] pass over what is no number on either side, which costs them half a dozen. These pass over a second that is
//! none; a first that is none stays.

/// `b` if it is below `a`, and `a` otherwise.
#[inline(always)]
pub(crate) fn smaller(a: f64, b: f64) -> f64 {
    if b < a { b } else { a }
}

/// `b` if it is above `a`, and `a` otherwise.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b > a { b } else { a }
}

/// `x`, but no less than `least` and no more than `most`. Unlike [`f64::clamp`] it does not ask which of these is the larger.
#[inline(always)]
pub(crate) fn between(x: f64, least: f64, most: f64) -> f64 {
    smaller(larger(x, least), most)
}

#[cfg(test)]
mod tests {
    use super::{between, larger, smaller};

    #[test]
    fn numbers_are_ordered_as_the_standard_library_has_it() {
        let all = [f64::NEG_INFINITY, -2.0, -f64::MIN_POSITIVE, 0.0, 1e-300, 1.0, f64::MAX, f64::INFINITY];
        for a in all {
            for b in all {
                assert_eq!((smaller(a, b), larger(a, b)), (a.min(b), a.max(b)));
                if a <= b {
                    all.iter().for_each(|x| assert_eq!(between(*x, a, b), x.clamp(a, b)));
                }
            }
            assert!(smaller(f64::NAN, a).is_nan() && larger(f64::NAN, a).is_nan());
            assert_eq!((smaller(a, f64::NAN), larger(a, f64::NAN)), (a, a));
        }
    }
}
