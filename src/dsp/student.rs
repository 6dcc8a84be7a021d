//! How far an estimate may be off, where its spread is itself an estimate: Student's distribution.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

/// The quantile of 97.5 % of the standard normal distribution.
const NORMAL: f64 = 1.959_963_984_540_054;

/// From so many degrees of freedom on, the series by their reciprocal is exact to 1e-9.
const MANY: usize = 200;

/// Student's quantile of 97.5 %: within so many standard errors of the estimate lies the truth 95 times in 100. Of no degrees of
/// freedom it is infinite. Relative error below 1e-9 (the finite sums and the asymptotic series of Abramowitz and Stegun, Handbook of Mathematical
/// Functions, 26.7.3, 26.7.4 and 26.7.5).
pub(crate) fn quantile(degrees: usize) -> f64 {
    if degrees == 0 {
        return f64::INFINITY;
    }
    if degrees >= MANY {
        let (x, n) = (NORMAL, degrees as f64);
        let power = |k| x.powi(k);
        return x
            + (power(3) + x) / (4.0 * n)
            + (5.0 * power(5) + 16.0 * power(3) + 3.0 * x) / (96.0 * n * n)
            + (3.0 * power(7) + 19.0 * power(5) + 17.0 * power(3) - 15.0 * x) / (384.0 * n * n * n);
    }
    // By the angle whose tangent is t / sqrt(degrees), of which the share within rises from 0 to 1.
    let (mut low, mut high) = (0.0, FRAC_PI_2);
    while high - low > 1e-15 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        *(if within(middle, degrees) < 0.95 { &mut low } else { &mut high }) = middle;
    }
    low.tan() * (degrees as f64).sqrt()
}

/// The share of the distribution that lies between -t and t.
fn within(angle: f64, degrees: usize) -> f64 {
    let (sine, cosine) = angle.sin_cos();
    let odd = degrees % 2 == 1;
    // Each term is the one before by the squared cosine and (k - 1) / k.
    let (mut term, mut sum, mut k) = if odd { (cosine, 0.0, 1) } else { (1.0, 0.0, 0) };
    while k + 2 <= degrees {
        sum += term;
        k += 2;
        term *= cosine * cosine * (k - 1) as f64 / k as f64;
    }
    if odd { FRAC_2_PI * (angle + sine * sum) } else { sine * sum }
}

#[cfg(test)]
mod tests {
    use super::{MANY, quantile};

    /// The closed forms of one and two degrees: tan(0.475 π), and t = √(2 p² / (1 − p²)) with p = 0.95; the others are as tables have them.
    #[test]
    fn quantiles_are_those_of_the_closed_forms_and_of_tables() {
        let near = |degrees, due: f64, off: f64| {
            let is = quantile(degrees);
            assert!((is / due - 1.0).abs() < off, "{degrees}: {is}, {due}");
        };
        near(1, (0.475 * std::f64::consts::PI).tan(), 1e-12);
        near(2, (2.0 * 0.95 * 0.95 / (1.0 - 0.95 * 0.95_f64)).sqrt(), 1e-12);
        for (degrees, due) in [
            (3, 3.182_446),
            (4, 2.776_445),
            (5, 2.570_582),
            (10, 2.228_139),
            (23, 2.068_658),
            (30, 2.042_272),
            (60, 2.000_298),
            (120, 1.979_930),
        ] {
            near(degrees, due, 2.5e-7);
        }
        assert_eq!(quantile(0), f64::INFINITY);
    }

    #[test]
    fn they_fall_towards_the_normal_one_and_the_two_ways_agree() {
        (1..400).for_each(|n| assert!(quantile(n) > quantile(n + 1), "{n}"));
        let [before, at] = [MANY - 1, MANY].map(quantile);
        let step = quantile(MANY - 2) - before;
        assert!((before - at - step).abs() < 0.02 * step, "{before} {at} {step}");
        assert!((quantile(usize::MAX) - 1.959_963_985).abs() < 1e-9);
    }
}
