//! The instant at which something smooth becomes negative.

/// Steps of the search: more than bisection of any interval to the last place takes.
const MOST: usize = 80;

/// Newton's method converges from here on, if it ever does.
const NEAR: f64 = 1e-12;

/// A value and its slope at a time.
pub(super) type Point = (f64, f64);

/// Where `of` falls through 0 between `from` and `to`: 0 or more at the first, below 0 at the second. Newton's method, kept within
/// its bracket (Press et al., Numerical Recipes, 9.4).
pub(super) fn falls(from: f64, to: f64, of: impl Fn(f64) -> Point) -> f64 {
    let (mut low, mut high) = (from, to);
    if of(from).0 <= 0.0 {
        return from;
    }
    let mut at = 0.5 * (low + high);
    let (mut last, mut straight) = (high - low, false);
    for _ in 0..MOST {
        let (value, slope) = of(at);
        if value > 0.0 {
            low = at;
        } else if value < 0.0 {
            high = at;
        } else {
            return at;
        }
        let newton = at - value / slope;
        let step = (newton - at).abs();
        // Where Newton's steps are that short and shorten no more, what is left is rounding of the value.
        if step <= f64::EPSILON * to || (straight && step > 0.5 * last && last <= NEAR * to) {
            return at;
        }
        // Halves where Newton leaves the bracket or slows down; so is what is no number.
        straight = newton > low && newton < high && step <= 0.5 * last;
        let next = if straight { newton } else { 0.5 * (low + high) };
        last = (next - at).abs();
        if last <= f64::EPSILON * 0.5 * to || next == at {
            return next;
        }
        at = next;
    }
    at
}

/// The first time between `from` and `to` at which `of` becomes negative, if it has at most one minimum there.
pub(super) fn dips(from: f64, to: f64, of: impl Fn(f64) -> Point) -> Option<f64> {
    let (start, end) = (of(from), of(to));
    if end.0 < 0.0 {
        return Some(falls(from, to, of));
    }
    if start.1 >= 0.0 || end.1 <= 0.0 {
        return None;
    }
    let (mut low, mut high) = (from, to);
    for _ in 0..MOST {
        let middle = 0.5 * (low + high);
        let (value, slope) = of(middle);
        if value < 0.0 {
            return Some(falls(from, middle, of));
        }
        if slope < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
        if high - low <= f64::EPSILON * to {
            break;
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::{dips, falls};

    #[test]
    fn it_finds_the_first_zero_to_the_last_place() {
        for root in [1e-12, 1e-3, 0.3, 0.999_999] {
            let at = falls(0.0, 1.0, |t| (root * root * root - t * t * t, -3.0 * t * t));
            assert!((at - root).abs() < 3e-16 * 8.0, "{root} {at}");
        }
        assert_eq!(falls(0.25, 1.0, |t| (0.25 - t, -1.0)), 0.25);
    }

    /// Values with rounding of their own: no time further off than that is.
    #[test]
    fn rounding_does_not_lead_it_astray() {
        for n in 1..2000 {
            let (root, from) = (f64::from(n) * 2.5e-7, 1.75 + f64::from(n) * 1e-3);
            for rate in [4.0, 60_000.0] {
                let of = |t: f64| {
                    let fast = (-rate * t).exp();
                    let moved = 4.0 * t + 1e-3 * (1.0 - fast);
                    ((from + moved) - (from + (4.0 * root + 1e-3 * (1.0 - (-rate * root).exp()))), 0.0)
                };
                let slope = |t: f64| 4.0 + 1e-3 * rate * (-rate * t).exp();
                let at = falls(0.0, 5.1e-4, |t| (-of(t).0, -slope(t)));
                assert!((at - root).abs() < 4.0 * f64::EPSILON * from / 4.0, "{n} {rate}: {at} {root}");
            }
        }
    }

    #[test]
    fn a_dip_between_two_positive_ends_is_seen() {
        let deep = |depth: f64| move |t: f64| ((t - 0.5) * (t - 0.5) - depth, 2.0 * (t - 0.5));
        let at = dips(0.0, 1.0, deep(1e-10)).unwrap();
        assert!((at - (0.5 - 1e-5)).abs() < 1e-12, "{at}");
        assert_eq!(dips(0.0, 1.0, deep(-1e-10)), None);
        assert_eq!(dips(0.0, 0.25, deep(0.0)), None);
    }
}
