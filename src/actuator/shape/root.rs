//! Where a continuous function passes through nothing.

/// The most evaluations.
const MOST: usize = 60;

/// Within this share of the bracket.
const CLOSE: f64 = 1.0 / (1_u64 << 44) as f64;

/// Where `f` passes through 0 between two places at which its sign differs, of which the values are known; within 2⁻⁴⁴ of their distance.
///
/// By inverse quadratic interpolation where that is safe, else by halving (T. R. Chandrupatla, Advances in Engineering Software 28, 1997).
pub fn root(from: (f64, f64), to: (f64, f64), mut f: impl FnMut(f64) -> f64) -> f64 {
    let tolerance = CLOSE * (to.0 - from.0).abs();
    // b is the newest, a brackets with it, c came before.
    let (mut b, mut a) = (from, to);
    let mut share = 0.5;
    for _ in 0..MOST {
        let x = b.0 + share * (a.0 - b.0);
        let new = (x, f(x));
        let c = if (new.1 > 0.0) == (b.1 > 0.0) { b } else { std::mem::replace(&mut a, b) };
        b = new;
        let best = if a.1.abs() < b.1.abs() { a } else { b };
        let close = tolerance / (a.0 - b.0).abs();
        if best.1 == 0.0 || close >= 0.5 || close.is_nan() {
            return best.0;
        }
        let (xi, phi) = ((b.0 - a.0) / (c.0 - a.0), (b.1 - a.1) / (c.1 - a.1));
        let safe = phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi;
        share = if safe {
            b.1 / (a.1 - b.1) * c.1 / (a.1 - c.1)
                + (c.0 - b.0) / (a.0 - b.0) * b.1 / (c.1 - b.1) * a.1 / (c.1 - a.1)
        } else {
            0.5
        };
        share = if share.is_finite() { share.clamp(close, 1.0 - close) } else { 0.5 };
    }
    b.0
}

#[cfg(test)]
mod tests {
    use super::root;

    /// Roots that are known, of functions that are steep, flat, bent and with a corner; seldom more than a dozen looks.
    #[test]
    fn known_roots_are_found() {
        type Known = (fn(f64) -> f64, f64, f64, f64);
        let known: [Known; 6] = [
            (|x| x * x - 2.0, 0.0, 2.0, std::f64::consts::SQRT_2),
            (|x| x.exp() - 1.5, -3.0, 5.0, 1.5_f64.ln()),
            (|x| (x - 0.3).powi(3), 0.0, 1.0, 0.3),
            (|x| if x < 0.7 { -1.0 } else { 1.0 }, 0.0, 1.0, 0.7),
            (|x| 1e-9 * (x - 0.25), 1.0, 0.0, 0.25),
            (|x| (x - 0.6).min(0.01 * (x - 0.6)), 0.0, 1.0, 0.6),
        ];
        let mut looks = 0;
        for (n, (f, from, to, wanted)) in known.into_iter().enumerate() {
            let found = root((from, f(from)), (to, f(to)), |x| {
                looks += 1;
                f(x)
            });
            // A triple root is known to the cube root of what its function resolves.
            let within = if n == 2 { 1e-5 } else { 1e-12 * (to - from).abs() };
            assert!((found - wanted).abs() <= within, "{n}: {found} {wanted}");
        }
        assert!(looks < 6 * 30, "{looks}");
        // No sign changes, and no numbers: some place in between, in bounded time.
        assert!((0.0..=1.0).contains(&root((0.0, 1.0), (1.0, 1.0), |_| 1.0)));
        assert!((0.0..=1.0).contains(&root((0.0, -1.0), (1.0, 1.0), |_| f64::NAN)));
    }
}
