//! A stream of values from outside, such as those of a sensor, brought onto the engine's clock.
//!
//! Values come when they come, some hundred a second, and the engine needs one for each of its samples. Played a fixed time later than
//! they came, each can be reached in a straight line from the one before, because the next is known by then: what is heard is the
//! polygon through the values at their own times, delayed. A value that takes longer than that delay to come finds the line at its
//! end; from there it is reached in the delay.

/// A stream at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stream {
    /// Seconds by which it is later than what comes.
    delay: f64,
    /// When the last value came.
    last: Option<f64>,
}

/// A straight line from wherever the stream stands to a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Glide {
    /// When it begins, in seconds.
    pub begin: f64,
    /// How long it takes.
    pub seconds: f64,
}

impl Stream {
    /// One that is so many seconds later than what comes.
    pub fn new(delay: f64) -> Self {
        Self { delay, last: None }
    }

    /// A value came at `at` seconds. One that came before the last, as clocks of senders may say, counts as coming with it.
    pub fn take(&mut self, at: f64) -> Glide {
        let at = self.last.map_or(at, |last| at.max(last));
        let before = self.last.replace(at);
        // Where the last line ends.
        let begin = before.map_or(at, |before| (before + self.delay).max(at));
        Glide { begin, seconds: at + self.delay - begin }
    }

    /// Goes on where `other` was.
    pub fn go_on(&mut self, other: &Self) {
        self.last = other.last;
    }
}

#[cfg(test)]
mod tests {
    use super::Stream;

    /// What the engine makes of glides: where it stands at a time.
    fn heard(glides: &[(f64, f64, f64)], time: f64) -> f64 {
        let mut stands = 0.0;
        for (n, &(begin, seconds, value)) in glides.iter().enumerate() {
            let until = glides.get(n + 1).map_or(f64::INFINITY, |next| next.0).min(time);
            if until <= begin {
                break;
            }
            let share = if seconds > 0.0 { ((until - begin) / seconds).min(1.0) } else { 1.0 };
            stands += (value - stands) * share;
        }
        stands
    }

    #[test]
    fn it_is_the_polygon_through_the_values_a_delay_later() {
        let delay = 0.03;
        let mut stream = Stream::new(delay);
        let curve = |t: f64| (t * 7.0).sin();
        // A hundred a second, more or less.
        let times: Vec<f64> = (0..200).map(|n| 0.01 * f64::from(n) + 0.0015 * f64::from(n * 7 % 5)).collect();
        let glides: Vec<_> = times
            .iter()
            .map(|&t| {
                let glide = stream.take(t);
                assert!(glide.begin >= t, "nothing is wanted before it is known");
                (glide.begin, glide.seconds, curve(t))
            })
            .collect();
        for (a, b) in times.iter().zip(&times[1..]).skip(1) {
            for share in [0.0, 0.3, 0.5, 0.9] {
                let t = a + share * (b - a);
                let polygon = curve(*a) + share * (curve(*b) - curve(*a));
                let heard = heard(&glides, t + delay);
                assert!((heard - polygon).abs() < 1e-9, "{heard} for {polygon} at {t}");
            }
        }
    }

    #[test]
    fn after_a_pause_it_goes_there_in_its_delay() {
        let mut stream = Stream::new(0.02);
        let first = stream.take(1.0);
        assert_eq!((first.begin, (first.seconds * 1e6).round()), (1.0, 20_000.0));
        let late = stream.take(5.0);
        assert_eq!((late.begin, (late.seconds * 1e6).round()), (5.0, 20_000.0));
        // What claims to be older comes with the last.
        let old = stream.take(4.0);
        assert!((old.begin - 5.02).abs() < 1e-12 && old.seconds.abs() < 1e-12);
    }
}
