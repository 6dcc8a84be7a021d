//! The exponential function from sums and products alone, so that every machine finds the same bits.

/// ln 2 in two parts, the first so short that its multiples are exact (Cody & Waite, 1980).
const LN_2: [f64; 2] = [6.931_471_803_691_238e-1, 1.908_214_929_270_587_7e-10];
/// 1 / k!, from k = 1.
const FACTORIALS: [f64; 14] = reciprocals();

const fn reciprocals() -> [f64; 14] {
    let (mut all, mut product, mut k) = ([1.0; 14], 1.0, 0);
    while k < 14 {
        product *= (k + 1) as f64;
        all[k] = 1.0 / product;
        k += 1;
    }
    all
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
    let high = x - k * LN_2[0];
    let r = high - k * LN_2[1];
    let lost = (high - r) - k * LN_2[1];
    let mut tail = 0.0;
    for term in FACTORIALS[1..].iter().rev() {
        tail = tail * r + term;
    }
    let small = r + (r * r * tail + lost * (1.0 + r));
    if k == 0.0 {
        return small;
    }
    let power = f64::from_bits(((1023 + k as i64) as u64) << 52);
    power * small + (power - 1.0)
}

#[cfg(test)]
mod tests {
    use super::exp_m1;

    fn exp(x: f64) -> f64 {
        exp_m1(x) + 1.0
    }

    #[test]
    fn it_is_the_exponential_function() {
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
        assert!((1..700).all(|n| (exp(f64::from(n)) / f64::from(n).exp() - 1.0).abs() < 4e-16));
    }

    #[test]
    fn no_argument_is_too_wild() {
        assert_eq!((exp_m1(0.0), exp_m1(f64::NAN), exp(f64::NEG_INFINITY)), (0.0, 0.0, 0.0));
        assert_eq!((exp(1e300), exp(-1e300), exp(-745.0)), (f64::INFINITY, 0.0, 0.0));
        assert!(exp(709.0).is_finite());
        assert_eq!(exp_m1(1e-310), 1e-310);
    }
}
