//! CPU time of a step: the least of several runs, on this thread's own clock.

use std::time::Duration;

use cpu_time::ThreadTime;

/// A measurement lasts this long at least; the least of so many counts, or of as many as fit into a time, but of some.
const LEAST: Duration = Duration::from_micros(150);
const MOST_RUNS: usize = 40;
const ENOUGH: Duration = Duration::from_millis(15);
const FEWEST_RUNS: usize = 5;

/// Nanoseconds a step of something that takes `steps` of them each time it is run: some 15 ms of runs, and more where a single one is
/// longer. Others on the machine make it larger, never smaller, so the least run counts.
pub fn nanoseconds(steps: usize, mut all: impl FnMut()) -> f64 {
    let mut run = |times: usize| {
        let begin = ThreadTime::now();
        (0..times).for_each(|_| all());
        begin.elapsed()
    };
    let first = run(1).max(Duration::from_nanos(100));
    let times = (LEAST.as_nanos() / first.as_nanos()) as usize + 1;
    let (mut least, mut sum) = (Duration::MAX, Duration::ZERO);
    for done in 0..MOST_RUNS {
        if done >= FEWEST_RUNS && sum > ENOUGH {
            break;
        }
        let one = run(times);
        (least, sum) = (least.min(one), sum + one);
    }
    least.as_nanos() as f64 / (times * steps.max(1)) as f64
}

#[cfg(test)]
mod tests {
    use super::nanoseconds;
    use std::hint::black_box;

    #[test]
    fn twice_the_work_takes_longer_and_nothing_takes_little() {
        let work =
            |n: u64| {
                move || {
                    black_box((0..n).fold(black_box(1u64), |x, k| {
                        x.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(k)
                    }));
                }
            };
        let (one, ten) = (nanoseconds(1, work(2_000)), nanoseconds(1, work(20_000)));
        assert!(ten > 3.0 * one && one > 0.0, "{one} {ten}");
        assert!(nanoseconds(0, || ()) < 1e5);
    }
}
