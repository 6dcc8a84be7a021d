//! Where an axis has its ticks and how they are written.

/// From values to pixels along one direction, linear or by decades.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::report) struct Scale {
    from: f64,
    to: f64,
    low: f64,
    high: f64,
    log: bool,
}

impl Scale {
    /// `from` to `to` (equal or not finite counts as 0 to 1) lie at the pixels `low` to `high`.
    pub fn linear([from, to]: [f64; 2], low: f64, high: f64) -> Self {
        let sound = from.is_finite() && to.is_finite() && to - from > 0.0 && (to - from).is_finite();
        let [from, to] = if sound { [from, to] } else { [0.0, 1.0] };
        Self { from, to, low, high, log: false }
    }

    /// The same by decades; both ends must be above 0, or 1 to 10 is taken.
    pub fn log([from, to]: [f64; 2], low: f64, high: f64) -> Self {
        let sound = from.is_finite() && to.is_finite() && from > 0.0 && to > from;
        let [from, to] = if sound { [from, to] } else { [1.0, 10.0] };
        Self { from, to, low, high, log: true }
    }

    /// The pixel of a value.
    pub fn at(&self, value: f64) -> f64 {
        let share = if self.log {
            (value.log10() - self.from.log10()) / (self.to.log10() - self.from.log10())
        } else {
            (value - self.from) / (self.to - self.from)
        };
        self.low + (self.high - self.low) * share
    }

    /// The value at a pixel.
    pub fn value(&self, pixel: f64) -> f64 {
        let share = (pixel - self.low) / (self.high - self.low);
        if self.log {
            10f64.powf(self.from.log10() + (self.to.log10() - self.from.log10()) * share)
        } else {
            self.from + (self.to - self.from) * share
        }
    }

    /// Labelled ticks, at most about `most`, with what is written at them.
    pub fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        if !self.log {
            return steps(self.from, self.to, most);
        }
        let decades = self.to.log10() - self.from.log10();
        let digits: &[f64] = if decades * 3.0 <= most as f64 { &[1.0, 2.0, 5.0] } else { &[1.0] };
        let every = (decades / most.max(1) as f64).ceil().max(1.0) as i32;
        let (first, last) = (self.from.log10().floor() as i32, self.to.log10().ceil() as i32);
        (first..=last)
            .filter(|d| d.rem_euclid(every) == 0)
            .flat_map(|d| digits.iter().map(move |n| n * 10f64.powi(d)))
            .filter(|v| *v >= self.from * (1.0 - 1e-9) && *v <= self.to * (1.0 + 1e-9))
            .map(|v| (v, short(v)))
            .collect()
    }

    /// Ticks without labels between those of a log axis.
    pub fn minor(&self) -> Vec<f64> {
        if !self.log {
            return Vec::new();
        }
        let (first, last) = (self.from.log10().floor() as i32, self.to.log10().ceil() as i32);
        if last - first > 12 {
            return Vec::new();
        }
        (first..=last)
            .flat_map(|d| (1..10).map(move |n| f64::from(n) * 10f64.powi(d)))
            .filter(|v| *v > self.from && *v < self.to)
            .collect()
    }
}

/// Multiples of 1, 2 or 5 times a power of ten within a range, at most `most` or one more, with as many decimals as they need.
fn steps(from: f64, to: f64, most: usize) -> Vec<(f64, String)> {
    let step = nice((to - from) / most.max(1) as f64);
    let decimals = (-step.log10().floor()).clamp(0.0, 12.0) as usize;
    let first = (from / step - 1e-9).ceil();
    (0..=most + 1)
        .map(|i| (first + i as f64) * step)
        .take_while(|v| *v <= to + step * 1e-9)
        .map(|v| {
            let v = if v == 0.0 { 0.0 } else { v };
            let text = if v.abs() >= 1e7 { format!("{v:e}") } else { format!("{v:.decimals$}") };
            (v, signed(text))
        })
        .collect()
}

/// The least of 1, 2 and 5 times a power of ten that is not below `x`.
pub(in crate::report) fn nice(x: f64) -> f64 {
    if !(x > 0.0 && x.is_finite()) {
        return 1.0;
    }
    let exponent = x.log10().floor().clamp(-300.0, 300.0) as i32;
    // Powers of ten below 1 are not exact; their reciprocals are.
    let scaled = |n: f64, e: i32| if e < 0 { n / 10f64.powi(-e) } else { n * 10f64.powi(e) };
    [(1.0, 0), (2.0, 0), (5.0, 0), (1.0, 1)]
        .map(|(n, up)| scaled(n, exponent + up))
        .into_iter()
        .find(|v| *v >= x * (1.0 - 1e-12))
        .unwrap_or(x)
}

/// A number as short as three digits allow: 50, 2k, 0.05, 1e−6.
pub(in crate::report) fn short(v: f64) -> String {
    let size = v.abs();
    let text = if size == 0.0 {
        "0".to_string()
    } else if (1e3..1e6).contains(&size) {
        format!("{}k", trimmed(v / 1e3))
    } else if (1e-3..1e3).contains(&size) {
        trimmed(v)
    } else {
        let exponent = size.log10().floor();
        format!("{}e{exponent}", trimmed(v / 10f64.powf(exponent)))
    };
    signed(text)
}

/// A count or a rate where there is room for all of its digits: 48000, 4096, and from ten millions on as [`short`] has it.
pub(in crate::report) fn whole(v: f64) -> String {
    if v.abs() < 1e7 && (v - v.round()).abs() < 1e-6 * v.abs() { format!("{v:.0}") } else { short(v) }
}

fn trimmed(v: f64) -> String {
    let decimals = (2.0 - v.abs().log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{v:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// With a true minus sign.
pub(in crate::report) fn signed(text: String) -> String {
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::{Scale, nice, short, whole};

    fn labels(scale: &Scale, most: usize) -> Vec<String> {
        scale.ticks(most).into_iter().map(|(_, text)| text).collect()
    }

    #[test]
    fn linear_ticks_are_round_and_few() {
        assert_eq!(
            labels(&Scale::linear([0.0, 20.0], 0.0, 1.0), 10),
            ["0", "2", "4", "6", "8", "10", "12", "14", "16", "18", "20"]
        );
        assert_eq!(labels(&Scale::linear([0.0, 0.35], 0.0, 1.0), 4), ["0.0", "0.1", "0.2", "0.3"]);
        assert_eq!(
            labels(&Scale::linear([-120.0, 0.0], 0.0, 1.0), 6),
            ["−120", "−100", "−80", "−60", "−40", "−20", "0"]
        );
        for span in [1e-9, 3e-4, 0.7, 42.0, 86_400.0, 1e300] {
            let ticks = Scale::linear([0.0, span], 0.0, 1.0).ticks(8);
            assert!((3..=10).contains(&ticks.len()), "{span}: {ticks:?}");
        }
    }

    #[test]
    fn log_ticks_follow_the_decades() {
        assert_eq!(
            labels(&Scale::log([10.0, 1e4], 0.0, 1.0), 10),
            ["10", "20", "50", "100", "200", "500", "1k", "2k", "5k", "10k"]
        );
        assert_eq!(labels(&Scale::log([1e-6, 1e2], 0.0, 1.0), 4), ["1e−6", "1e−4", "0.01", "1", "100"]);
    }

    #[test]
    fn a_pixel_and_its_value_are_inverse() {
        for scale in [Scale::log([10.0, 1e4], 100.0, 900.0), Scale::linear([-3.0, 7.0], 900.0, 100.0)] {
            for pixel in [100.0, 345.0, 900.0] {
                assert!((scale.at(scale.value(pixel)) - pixel).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn unusable_ranges_still_make_an_axis() {
        for range in [[0.0, 0.0], [f64::NAN, 1.0], [1.0, f64::INFINITY], [-f64::MAX, f64::MAX]] {
            for scale in [Scale::linear(range, 0.0, 1.0), Scale::log(range, 0.0, 1.0)] {
                assert!(scale.at(0.5).is_finite() && !scale.ticks(5).is_empty(), "{range:?}");
            }
        }
    }

    #[test]
    fn nice_is_exact_and_never_below() {
        for (x, n) in
            [(0.7, 1.0), (1.0, 1.0), (1.2, 2.0), (0.03, 0.05), (0.1, 0.1), (700.0, 1000.0), (f64::NAN, 1.0)]
        {
            assert_eq!(nice(x), n);
        }
    }

    #[test]
    fn short_numbers() {
        for (v, text) in
            [(0.0, "0"), (50.0, "50"), (2e4, "20k"), (0.05, "0.05"), (-1e-6, "−1e−6"), (1.5e9, "1.5e9")]
        {
            assert_eq!(short(v), text);
        }
        for (v, text) in [(4096.0, "4096"), (1.0 / 2.083_333_333_3e-5, "48000"), (7999.5, "8k"), (2e7, "2e7")]
        {
            assert_eq!(whole(v), text);
        }
    }
}
