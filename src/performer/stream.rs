//! A stream of values from outside, such as those of a sensor, brought onto the engine's clock.
//!
//! Values come when they come, some hundred a second, and the engine needs one for each of its samples. Played a fixed time later than
//! they came, or than they say that they were sampled, each can be reached in a straight line from the one before, because the next is
//! known by then: what is heard is the polygon through the values at their own times, delayed. A value that takes longer than that delay
//! to come finds the line at its end; from there it is reached by the end of its own delay.

/// A stream at work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stream {
    /// Seconds by which it is later than what comes.
    delay: f64,
    last: Option<Last>,
}

/// The last value.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Last {
    /// Of when it counts, in seconds.
    of: f64,
    /// When the line to it begins.
    begin: f64,
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

    /// A value of `at` seconds, where nothing can begin before `now` any more. One that is older than the delay counts as coming now. One that is
    /// older than the last, as clocks of senders may say, counts as coming with it; but where that one counted from when it came and its
    /// line is under way, this one is on time all the same.
    pub fn take(&mut self, at: f64, now: f64) -> Glide {
        let of = if at + self.delay > now { at } else { now };
        let first = of.max(now);
        let (of, begin) = match self.last {
            Some(last) if of < last.of && last.begin <= now => (of, first),
            Some(last) => (of.max(last.of), (last.of + self.delay).max(first)),
            None => (of, first),
        };
        self.last = Some(Last { of, begin });
        Glide { begin, seconds: (of + self.delay - begin).max(0.0) }
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
                let glide = stream.take(t, t);
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
        let first = stream.take(1.0, 1.0);
        assert_eq!((first.begin, (first.seconds * 1e6).round()), (1.0, 20_000.0));
        let late = stream.take(5.0, 5.0);
        assert_eq!((late.begin, (late.seconds * 1e6).round()), (5.0, 20_000.0));
        // What claims to be older comes with the last.
        let old = stream.take(4.0, 5.0);
        assert!((old.begin - 5.02).abs() < 1e-12 && old.seconds.abs() < 1e-12);
    }

    /// A sine of 1 Hz and 0.8, sampled a hundred times a second, that takes 2 to 12 ms to come: the error of the polygon is h^2 / 8 of its second
    /// derivative at most, 0.0004.
    #[test]
    fn what_says_when_it_was_sampled_is_heard_as_of_then() {
        let (mut stream, delay) = (Stream::new(0.03), 0.03);
        let curve = |t: f64| 0.8 * (std::f64::consts::TAU * t).sin();
        let mut came = 0.0_f64;
        let glides: Vec<_> = (0..300)
            .map(|n| {
                let t = 0.01 * f64::from(n);
                came = came.max(t + 0.002 + 0.001 * f64::from(n * 7 % 11));
                let glide = stream.take(t, came);
                assert!(glide.begin >= came && glide.seconds >= 0.0, "{n}: {glide:?}");
                (glide.begin, glide.seconds, curve(t))
            })
            .collect();
        for n in 100..2900 {
            let t = 0.001 * f64::from(n);
            let off = heard(&glides, t + delay) - curve(t);
            assert!(off.abs() < 4e-4, "{off} at {t}");
        }
    }

    #[test]
    fn what_is_too_old_counts_as_coming_now_and_holds_up_nothing_behind_it() {
        let mut stream = Stream::new(0.03);
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        stream.take(1.0, 1.01);
        // 31 ms old, as the line has come to its end.
        let late = stream.take(1.01, 1.041);
        near(late.begin, 1.041);
        near(late.seconds, 0.03);
        // What comes behind it on time is where it belongs, and so is the next.
        let (next, last) = (stream.take(1.02, 1.045), stream.take(1.03, 1.05));
        near(next.begin, 1.045);
        near(next.begin + next.seconds, 1.05);
        near(last.begin, 1.05);
        near(last.begin + last.seconds, 1.06);
        // A sender whose clock is behind by more is as one without tags.
        let lines = [2.0, 2.01, 2.02].map(|t| stream.take(t - 0.5, t));
        near(lines[1].begin, 2.03);
        near(lines[2].begin, 2.04);
        near(lines[2].begin + lines[2].seconds, 2.05);
    }

    #[test]
    fn values_in_another_order_than_their_tags_keep_that_in_which_they_came() {
        let mut stream = Stream::new(0.03);
        let (mut begun, mut now, mut state) = (0.0, 0.0, 7_u64);
        for _ in 0..10_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let (step, age) = ((state >> 33) % 20, (state >> 45) % 40);
            now += 0.001 * step as f64;
            let glide = stream.take(now - 0.001 * age as f64, now);
            assert!(glide.begin >= begun && glide.begin >= now, "{glide:?} after {begun}");
            // No later than a value that says nothing.
            assert!((0.0..=0.03 + 1e-9).contains(&glide.seconds), "{glide:?}");
            assert!(glide.begin + glide.seconds <= now + 0.03 + 1e-9, "{glide:?} at {now}");
            begun = glide.begin;
        }
    }
}
