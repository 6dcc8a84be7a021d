//! Loops whose speed comes from an estimator: its own states are among the eigenvalues.

use super::super::sampled::{Loop, Rotor, Shaft};
use super::of_shaft;
use crate::knob::plant::Plant as Model;
use crate::knob::plant::parts::Hand;
use crate::knob::test_plant::{Delay, Plant};
use crate::knob::velocity::Estimator;
use crate::knob::velocity::choice::Choice;

/// Readings as exact as they come: an adaptive window of such a count is never cut short, and a Kalman filter has gains of a
/// middling size with the acceleration scaled to it.
const COUNT: f64 = 1e-3;

/// What each estimator makes of its readings, from the one that is least late on.
fn choices(period: f64) -> Vec<(Choice, f64)> {
    let mut all = vec![
        (Choice::Difference, COUNT),
        (Choice::Filtered(400.0), COUNT),
        (Choice::Filtered(60.0), COUNT),
        (Choice::Kalman(3e4), COUNT),
        (Choice::Kalman(300.0), COUNT),
    ];
    // Whatever grows stays within a count: the window stays as long as it may be.
    all.extend([2.0, 7.0, 32.0].map(|ticks| (Choice::Adaptive(ticks * period), 1e300)));
    all.push((Choice::Adaptive(0.01), 1e300));
    all
}

fn estimated(rest: &Loop, choice: (Choice, f64)) -> Loop {
    let transfer = choice.0.transfers(choice.1, rest.period()).unwrap().pop().unwrap();
    rest.clone().estimated(transfer)
}

/// Whether a simulated knob swings more and more with a spring and a damper whose speed the estimator itself makes. What is simulated
/// knows nothing of transfer functions.
fn grows<P: FnMut(f64) -> f64>(
    mut plant: P,
    choice: (Choice, f64),
    period: f64,
    delay: usize,
    gains: (f64, f64),
    span: usize,
) -> bool {
    let (mut estimator, mut line, mut angle) =
        (choice.0.started(choice.1, period).unwrap(), Delay::new(delay), 1.0);
    estimator.reset(angle);
    (0..delay).for_each(|_| _ = line.pass(-gains.0 * angle));
    let (mut peaks, mut before) = ([0.0f64; 3], angle);
    for peak in &mut peaks {
        for _ in 0..span {
            let speed = estimator.push(angle);
            angle = plant(line.pass(-gains.0 * angle - gains.1 * speed));
            // Without a spring it is the speed that grows.
            *peak = peak.max(if gains.0 > 0.0 { angle.abs() } else { (angle - before).abs() });
            before = angle;
        }
    }
    // What has left all bounds has grown.
    peaks[2] > peaks[1] || !angle.is_finite()
}

/// Bisects the gain at which it begins to.
fn bisected<G: Fn(f64) -> bool>(near: f64, grows: G, what: &str) -> f64 {
    let (mut low, mut high) = (0.7 * near, 1.3 * near);
    assert!(grows(high) && !grows(low), "{what}: {near}");
    while high - low > 1e-3 * low {
        let middle = 0.5 * (low + high);
        if grows(middle) { high = middle } else { low = middle }
    }
    low
}

#[test]
fn a_simulated_knob_with_its_estimator_begins_to_swing_at_the_edge() {
    let rotor = Rotor { inertia: 6e-6, damping: 1e-4 };
    for (rate, delay) in [(1e3, 1), (8e3, 0), (8e3, 3), (48e3, 32), (48e3, 128)] {
        let (period, rest) = (1.0 / rate, Loop::rigid(&rotor, 1.0 / rate, delay as f64).unwrap());
        for choice in choices(period) {
            if matches!(choice.0, Choice::Filtered(hertz) if hertz > 0.3 * rate) {
                continue;
            }
            let what = format!("{rate} Hz, {delay} ticks, {choice:?}");
            let all = estimated(&rest, choice);
            let most = all.damping_edge();
            let plain = || {
                let mut plant = Plant::new(rotor.inertia, rotor.damping, 0.0, period);
                plant.angle = 1.0;
                plant
            };
            let moved = |k: f64, b: f64, hertz: f64| {
                let mut plant = plain();
                // Something for the speed to begin with.
                plant.step(0.01);
                let span = (40.0 * rate / hertz) as usize;
                let step = move |torque: f64| {
                    plant.step(torque);
                    plant.angle
                };
                grows(step, choice, period, delay, (k, b), span)
            };
            let got = bisected(most.gain, |b| moved(0.0, b, most.hertz), &what);
            assert!((got / most.gain - 1.0).abs() < 0.01, "{what}: damping {got} {most:?}");
            for share in [0.15, 0.5] {
                let b = share * most.gain;
                let edge = all.edge(b);
                let got = bisected(edge.gain, |k| moved(k, b, edge.hertz), &what);
                assert!((got / edge.gain - 1.0).abs() < 0.01, "{what}, {share}: {got} {edge:?}");
            }
        }
    }
}

#[test]
fn a_simulated_shaft_with_its_estimator_begins_to_swing_at_the_edge() {
    let (rate, delay, damping) = (10_000.0, 2, 5e-5);
    let shaft = Shaft { motor: 0.95e-6, knob: 5.05e-6, clamped: 100.0, loss: 1e-4, damping };
    let build = of_shaft(&shaft);
    let rest = Loop::shaft(&shaft, 1.0 / rate, delay as f64).unwrap();
    for choice in choices(1.0 / rate) {
        let all = estimated(&rest, choice);
        let b = 0.3 * all.damping_edge().gain;
        let edge = all.edge(b);
        let moved = |k: f64| {
            let mut model = Model::new(&build, rate).unwrap();
            model.place(1.0, 0.0).unwrap();
            let step = move |torque: f64| {
                model.step(torque, &Hand::default());
                model.angle()
            };
            grows(step, choice, 1.0 / rate, delay, (k, b), (40.0 * rate / edge.hertz) as usize)
        };
        let got = bisected(edge.gain, moved, &format!("{choice:?}"));
        assert!((got / edge.gain - 1.0).abs() < 0.01, "{choice:?}: {got} {edge:?}");
    }
}

/// The edge is found on the unit circle, the radius from all eigenvalues.
#[test]
fn the_radius_passes_1_at_the_edge() {
    let rotor = Rotor { inertia: 6e-6, damping: 1e-4 };
    for (rate, delay) in [(1e3, 1.0), (8e3, 2.4), (48e3, 40.0)] {
        let rest = Loop::rigid(&rotor, 1.0 / rate, delay).unwrap();
        for choice in choices(1.0 / rate) {
            if matches!(choice.0, Choice::Filtered(hertz) if hertz > 0.3 * rate) {
                continue;
            }
            let all = estimated(&rest, choice);
            let b = 0.3 * all.damping_edge().gain;
            let edge = all.edge(b).gain;
            let (within, beyond) = (all.radius(edge * (1.0 - 1e-5), b), all.radius(edge * (1.0 + 1e-5), b));
            assert!(within < 1.0 && beyond > 1.0, "{rate} {delay} {choice:?}: {within} {beyond}");
        }
    }
}

/// What was measured where the governor took every estimator for a plain difference: it reckoned with 123, and the true edge was 8.8 N m/rad.
#[test]
fn a_filter_at_400_hz_is_no_plain_difference() {
    let rest = Loop::rigid(&Rotor { inertia: 6e-6, damping: 1e-4 }, 1.0 / 48e3, 0.0).unwrap();
    let filtered = estimated(&rest, (Choice::Filtered(400.0), COUNT));
    let b = 0.9 * filtered.damping_edge().gain;
    println!("{} {}", filtered.edge(b).gain, rest.edge(b).gain);
    assert!(rest.edge(b).gain > 5.0 * filtered.edge(b).gain);
}
