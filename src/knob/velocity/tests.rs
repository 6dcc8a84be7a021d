use super::Estimator;
use super::adaptive::{Adaptive, Fit};
use super::decimated::Decimated;
use super::difference::Difference;
use super::edges::Edges;
use super::error::{Error, Motion, measure};
use super::filtered::Filtered;
use super::kalman::Kalman;
use super::window::Window;
use crate::dsp::random::uniform;

const COUNT: f64 = std::f64::consts::TAU / 4000.0;

fn steady(speed: f64, e: &mut impl Estimator, rate: f64) -> Error {
    measure(e, Motion::Steady(speed), COUNT, 1.0 / rate, 4.0)
}

/// Figures of a table that was computed elsewhere: difference, filtered at 100 Hz, adaptive with end and best fit, Kalman.
#[test]
fn the_errors_are_those_of_the_published_comparison() {
    let cases: [(Motion, f64, usize, [f64; 5]); 7] = [
        (Motion::Steady(0.5), 1e3, 16, [0.73, 0.060, 0.029, 0.019, 0.0037]),
        (Motion::Steady(0.5), 1e4, 64, [2.8, 0.072, 0.046, 0.049, 0.0041]),
        (Motion::Swing(5.0, 2.0), 1e3, 16, [0.62, 0.17, 0.24, 0.34, 0.18]),
        (Motion::Swing(5.0, 2.0), 48e3, 256, [15.0, 0.11, 0.18, 0.12, 0.17]),
        (Motion::Swing(20.0, 10.0), 1e3, 16, [0.79, 2.4, 1.2, 1.7, 0.90]),
        (Motion::Swing(20.0, 10.0), 48e3, 256, [28.0, 2.0, 0.93, 1.5, 0.88]),
        (Motion::Swing(2.0, 50.0), 1e3, 16, [0.83, 1.2, 0.71, 1.1, 0.80]),
    ];
    for (motion, rate, window, expected) in cases {
        let t = 1.0 / rate;
        let peak = match motion {
            Motion::Steady(_) => 2.0,
            Motion::Swing(v, f) => v * f * std::f64::consts::TAU,
        };
        let got = [
            measure(&mut Difference::new(t).unwrap(), motion, COUNT, t, 4.0),
            measure(&mut Filtered::new(100.0, t).unwrap(), motion, COUNT, t, 4.0),
            measure(&mut Adaptive::new(Fit::End, window, COUNT, t).unwrap(), motion, COUNT, t, 4.0),
            measure(&mut Adaptive::new(Fit::Best, window, COUNT, t).unwrap(), motion, COUNT, t, 4.0),
            measure(&mut Kalman::new(peak, COUNT, t).unwrap(), motion, COUNT, t, 4.0),
        ]
        .map(|e| e.rms);
        // Fractions above and below the published figure; Kalman's there has a wider bound on acceleration.
        let bands = [(0.1, 0.1), (0.1, 0.1), (0.25, 0.25), (0.1, 0.4), (0.1, 1.0)];
        for ((got, expected), (above, below)) in got.into_iter().zip(expected).zip(bands) {
            let ratio = got / expected;
            assert!(
                (1.0 - below..1.0 + above).contains(&ratio),
                "{motion:?} {rate}: {got:.4} against {expected}"
            );
        }
    }
}

#[test]
fn a_difference_errs_as_its_closed_form_says() {
    for (speed, rate) in [(0.5, 1e3), (0.5, 1e4), (3.3, 48e3), (-7.7, 1e3)] {
        let got = steady(speed, &mut Difference::new(1.0 / rate).unwrap(), rate);
        let exact = Difference::steady_error(COUNT, 1.0 / rate, speed);
        assert!((got.rms / exact - 1.0).abs() < 0.01, "{speed} {rate}: {got:?} {exact}");
        assert!(got.worst <= COUNT * rate);
    }
}

/// Whatever is not the encoder's doing is lag: a steady speed without counts is told exactly, an accelerating one too late by the lag.
#[test]
fn without_counts_each_is_late_by_its_lag() {
    let t = 1e-4;
    let fine = COUNT * 1e-9;
    let lag = |e: &mut dyn Estimator, speed: f64, slope: f64| {
        let mut last = 0.0;
        for k in 0..20_000 {
            let time = f64::from(k) * t;
            last = speed + slope * time - e.push(speed * time + 0.5 * slope * time * time);
        }
        last / if slope == 0.0 { 1.0 } else { slope }
    };
    for slope in [0.0, 5.0] {
        let late = |seconds: f64| if slope == 0.0 { 0.0 } else { seconds };
        assert!((lag(&mut Difference::new(t).unwrap(), 2.0, slope) - late(0.5 * t)).abs() < 1e-9);
        let filter = std::f64::consts::SQRT_2 / (200.0 * std::f64::consts::PI);
        let got = lag(&mut Filtered::new(100.0, t).unwrap(), 2.0, slope);
        assert!((got - late(0.5 * t + filter)).abs() < 2e-6, "{got}");
        // A tolerance so fine that an acceleration leaves two readings, and a steady speed all of them.
        let mut adaptive = Adaptive::new(Fit::End, 30, fine, t).unwrap();
        let got = lag(&mut adaptive, 2.0, slope);
        assert!((got - late(0.5 * t)).abs() < 1e-9 && (slope > 0.0 || adaptive.window() == 30), "{got}");
    }
}

/// The window against its definition, reading by reading: the longest whose line passes within a count of all in it.
#[test]
fn the_window_is_the_longest_that_a_line_explains() {
    // Whatever is left where readings are looked at by eights.
    for (longest, most) in [(24, 4.0), (1, 4.0), (7, 1.0), (8, 1.0), (9, 1.0), (100, 0.2)] {
        let used = explained(longest, most);
        assert!(used.contains(&longest) && (longest < 9 || used.len() > longest / 2), "{longest}: {used:?}");
    }
}

/// At up to so many rad/s; the lengths that came.
fn explained(longest: usize, most: f64) -> std::collections::BTreeSet<usize> {
    let (t, mut used) = (1e-3, std::collections::BTreeSet::new());
    let mut e = Adaptive::new(Fit::End, longest, COUNT, t).unwrap();
    let mut best = Adaptive::new(Fit::Best, longest, COUNT, t).unwrap();
    let mut all: Vec<f64> = Vec::new();
    let mut angle = 0.0;
    for k in 0..3000 {
        let speed = most * ((f64::from(k) * 0.004).sin() + 0.25 * uniform(5, k as u64));
        angle += speed * t;
        all.push(COUNT * (angle / COUNT).floor());
        let newest = all[all.len() - 1];
        let explains = |n: usize| {
            let slope = (newest - all[all.len() - 1 - n]) / n as f64;
            (1..n).all(|i| {
                let line = newest - slope * i as f64;
                (line - all[all.len() - 1 - i]).abs() <= COUNT * (1.0 + 1e-6)
            })
        };
        let n = (1..=longest.min(all.len() - 1)).take_while(|n| explains(*n)).last().unwrap_or(0);
        let got = e.push(newest);
        let slope = best.push(newest);
        assert_eq!(e.window(), n, "{k}");
        used.insert(n);
        if n > 0 {
            assert!((got - (newest - all[all.len() - 1 - n]) / (n as f64 * t)).abs() < 1e-9);
            // Least squares by its normal equation.
            let window = &all[all.len() - 1 - n..];
            let mean = window.iter().sum::<f64>() / window.len() as f64;
            let middle = n as f64 / 2.0;
            let rise: f64 = window.iter().enumerate().map(|(i, y)| (i as f64 - middle) * (y - mean)).sum();
            let run: f64 = (0..=n).map(|i| (i as f64 - middle).powi(2)).sum();
            assert!((slope - rise / run / t).abs() < 1e-9);
        }
    }
    used
}

/// The closed form against the recursion of the filter's variance.
#[test]
fn the_gains_are_those_at_which_the_filter_settles() {
    for (acceleration, rate) in [(1.0, 48e3), (60.0, 1e3), (1e4, 1e3), (1e6, 500.0)] {
        let t = 1.0 / rate;
        let (noise, drive) = (COUNT * COUNT / 12.0, acceleration * acceleration);
        let mut p = [noise, 0.0, noise * rate * rate];
        let mut gain = [0.0; 2];
        for _ in 0..200_000 {
            let q = [0.25 * drive * t.powi(4), 0.5 * drive * t.powi(3), drive * t * t];
            let m = [p[0] + 2.0 * t * p[1] + t * t * p[2] + q[0], p[1] + t * p[2] + q[1], p[2] + q[2]];
            gain = [m[0] / (m[0] + noise), m[1] / (m[0] + noise)];
            p = [(1.0 - gain[0]) * m[0], (1.0 - gain[0]) * m[1], m[2] - gain[1] * m[1]];
        }
        let (alpha, beta) = Kalman::new(acceleration, COUNT, t).unwrap().gains();
        assert!(
            (alpha / gain[0] - 1.0).abs() < 1e-6 && (beta / (gain[1] * t) - 1.0).abs() < 1e-6,
            "{alpha} {beta} {gain:?}"
        );
    }
}

#[test]
fn time_between_edges_is_exact_to_a_tick() {
    for (speed, rate) in [(0.5, 48e3), (-3.0, 48e3), (0.05, 10e3)] {
        let got = steady(speed, &mut Edges::new(COUNT, 0.2, 1.0 / rate).unwrap(), rate);
        // One tick in those of a count.
        let bound = speed.abs() * speed.abs() / rate / COUNT * 1.1;
        assert!(got.worst <= bound, "{speed} {rate}: {got:?} {bound}");
    }
    let mut e = Edges::new(COUNT, 0.01, 1e-3).unwrap();
    e.push(0.0);
    for k in 0..200 {
        // A knob that trembles over one edge does not move.
        assert_eq!(e.push(COUNT * f64::from(k % 2)), 0.0);
    }
    e.push(2.0 * COUNT);
    assert!(e.push(3.0 * COUNT) > 1.0);
    assert!((0..20).map(|_| e.push(3.0 * COUNT)).last() == Some(0.0));
}

#[test]
fn decimation_estimates_at_its_own_rate() {
    let (every, rate) = (24, 48e3);
    let slow = 1.0 / (rate / f64::from(every));
    let mut fast = Decimated::new(Adaptive::new(Fit::End, 16, COUNT, slow).unwrap(), every).unwrap();
    let mut plain = Adaptive::new(Fit::End, 16, COUNT, slow).unwrap();
    for k in 0..5000 {
        let angle = COUNT * (f64::from(k) * 3.0 / rate / COUNT).floor();
        let speed = fast.push(angle);
        if k % 24 == 0 {
            assert_eq!(speed, plain.push(angle));
        }
    }
}

#[test]
fn what_is_not_a_number_changes_nothing() {
    let t = 1e-3;
    let all: [Box<dyn Estimator>; 6] = [
        Box::new(Difference::new(t).unwrap()),
        Box::new(Filtered::new(100.0, t).unwrap()),
        Box::new(Adaptive::new(Fit::Best, 8, COUNT, t).unwrap()),
        Box::new(Kalman::new(50.0, COUNT, t).unwrap()),
        Box::new(Edges::new(COUNT, 0.1, t).unwrap()),
        Box::new(Decimated::new(Difference::new(3.0 * t).unwrap(), 3).unwrap()),
    ];
    for mut e in all {
        assert_eq!(e.push(5.0), 0.0);
        for k in 0..100 {
            e.push(5.0 + f64::from(k) * 2e-3);
        }
        for wild in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(e.push(wild).is_finite());
        }
        assert!((e.push(5.2) - 2.0).abs() < 1.5);
        e.reset(1.0);
        assert_eq!(e.push(1.0), 0.0);
    }
    assert!(
        Adaptive::new(Fit::End, 0, COUNT, t).is_err() && Adaptive::new(Fit::End, 5000, COUNT, t).is_err()
    );
    assert!(Difference::new(0.0).is_err() && Kalman::new(0.0, COUNT, t).is_err());
    assert!(Edges::new(f64::NAN, 1.0, t).is_err() && Decimated::new(Difference::new(t).unwrap(), 0).is_err());
}

/// At every tick a plain difference over the window that the looks found: as long as it may be of a steady speed, and shorter where
/// the speed turns.
#[test]
fn a_window_is_a_difference_over_its_ticks_at_every_tick() {
    let period = 1.0 / 48_000.0;
    let mut window = Window::new(0.01, COUNT, period).unwrap();
    let angles: Vec<f64> = (0..24_000)
        .map(|k| {
            let t = f64::from(k) * period;
            let angle = if t < 0.25 { 8.0 * t } else { 2.0 - 20.0 * (t - 0.25) };
            COUNT * (angle / COUNT).floor()
        })
        .collect();
    let mut shortest = usize::MAX;
    for (k, angle) in angles.iter().enumerate() {
        let speed = window.push(*angle);
        let n = window.ticks();
        if n > 0 {
            let difference = (angle - angles[k - n]) / (n as f64 * period);
            assert!((speed - difference).abs() < 1e-9 * difference.abs().max(1.0), "{k}");
        }
        if k == 11_999 || k == 23_999 {
            assert_eq!(n, 480);
        }
        if k > 12_100 {
            shortest = shortest.min(n);
        }
    }
    assert!(shortest < 120, "{shortest}");
    assert!((window.push(f64::NAN) + 20.0).abs() < 0.3);
    window.reset(1.0);
    assert_eq!(window.push(1.0), 0.0);
    assert!(Window::new(0.0, COUNT, period).is_err() && Window::new(1e9, COUNT, period).is_err());
}
