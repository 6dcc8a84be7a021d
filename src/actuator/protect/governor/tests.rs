//! Gains and caps, against the budgets that they are to keep.

use super::{Flow, Governor, LEAST};
use crate::actuator::protect::store::Store;

/// A tick with a steady voltage, its gain obeyed.
fn run(g: &mut Governor, volts: f64) -> f64 {
    for k in 1..=16 {
        let left = (g.gain(k) * volts).min(g.cap());
        g.note(volts, left, 0.0);
    }
    g.tick();
    g.gain(0)
}

#[test]
fn the_gain_comes_down_smoothly_to_what_it_bears_and_stays() {
    let mut g = Governor::new(Store::mean(1.0, 1.0, 0.002), Flow::Volts, 16, 8000.0);
    let gains: Vec<f64> = (0..10_000).map(|_| run(&mut g, 4.0)).collect();
    assert!(gains.windows(2).all(|w| w[1] <= w[0] + 1e-12), "it only falls");
    assert!(gains.windows(2).all(|w| w[0] - w[1] < 0.1), "and without a leap");
    assert!((gains[9999] * 4.0 - 1.0).abs() < 1e-9, "{}", gains[9999]);
    // And back.
    let gains: Vec<f64> = (0..1000).map(|_| run(&mut g, 0.5)).collect();
    assert!(gains.windows(2).all(|w| w[1] >= w[0]) && gains[999] == 1.0);
}

#[test]
fn the_gain_glides_over_each_tick_to_where_the_next_begins() {
    let mut g = Governor::new(Store::mean(1.0, 1.0, 0.002), Flow::Volts, 16, 8000.0);
    let (mut last, mut moved) = (1.0, 0);
    for _ in 0..200 {
        let step = g.gain(1) - g.gain(0);
        assert!((g.gain(0) - last).abs() < 1e-12, "no leap between ticks");
        assert!((1..=16).all(|k| (g.gain(k) - g.gain(k - 1) - step).abs() < 1e-12), "nor within one");
        moved += i32::from(step != 0.0);
        last = g.gain(16);
        run(&mut g, 4.0);
    }
    assert!(moved > 100 && last < 0.5, "{moved} {last}");
}

#[test]
fn what_it_bears_for_ever_is_never_turned_down() {
    let mut g = Governor::new(Store::mean(1.0, 1.0, 0.002), Flow::Ohms(2.0), 16, 8000.0);
    assert!((0..20_000).all(|_| run(&mut g, 2.0) == 1.0 && g.is_idle()));
    assert!((g.level() - 1.0).abs() < 1e-9);
}

/// What is wanted is followed as e^(-t / look): within 25 ms, but of a short budget within 1/32 of its time.
#[test]
fn a_short_budget_looks_no_farther_back_than_it_lasts() {
    for (time, look) in [(10.0, 0.025), (0.1, 0.1 / 32.0)] {
        let mut g = Governor::new(Store::mean(1.0, time, 2e-4), Flow::Volts, 16, 80_000.0);
        for n in 1..=100 {
            run(&mut g, 4.0);
            let expected = 16.0 * (1.0 - (-2e-4 * f64::from(n) / look).exp());
            assert!((g.need - expected).abs() < 1e-9, "{time} {n}: {} {expected}", g.need);
        }
    }
}

/// One at half its limit, in which the first samples of a tick have let out so many volts each.
fn under_way(flow: Flow, passed: u32, volts: f64) -> Governor {
    let mut g = Governor::new(Store::mean(1.0, 1.0, 0.002), flow, 16, 8000.0);
    for _ in 0..350 {
        (0..16).for_each(|_| g.note(1.0, if flow == Flow::Volts { 1.0 } else { 2.0 }, 0.0));
        g.tick();
    }
    assert!((g.level() - 0.5).abs() < 0.01, "{}", g.level());
    (0..passed).for_each(|_| g.note(volts, volts, 0.0));
    g
}

/// What is spared for the rest of a tick fills the store to its limit and the excess, whatever left before in that tick.
#[test]
fn what_is_spared_fills_it_and_no_more() {
    for (flow, ohms) in [(Flow::Volts, 1.0), (Flow::Ohms(2.0), 2.0)] {
        for passed in [0, 5, 15] {
            for volts in [0.0, 3.0, 10.0] {
                let mut g = under_way(flow, passed, volts * ohms);
                let left = 16 - passed;
                let spare = g.spare(f64::from(left) / 8000.0, passed);
                (0..left).for_each(|_| g.note(1.0, spare.sqrt(), 0.0));
                g.tick();
                assert!((g.level() / 1.02 - 1.0).abs() < 1e-12, "{passed} {volts}: {}", g.level());
            }
        }
    }
    assert_eq!(under_way(Flow::Volts, 5, 1e3).spare(0.1, 5), 0.0, "there is none");
}

/// The rest of a tick makes up for what left before, but is no more than the cap.
#[test]
fn the_rest_of_a_tick_keeps_to_the_cap_of_the_whole() {
    let cap = under_way(Flow::Volts, 0, 0.0).cap();
    for (volts, passed) in [(1.2 * cap, 5), (1.5 * cap, 5), (1.02 * cap, 15)] {
        let mut g = under_way(Flow::Volts, passed, volts);
        let rest = g.rest(passed);
        assert!(rest < cap);
        (passed..16).for_each(|_| g.note(1.0, rest, 0.0));
        g.tick();
        assert!((g.level() / 1.02 - 1.0).abs() < 1e-12, "{volts} {passed}: {}", g.level());
    }
    assert_eq!(under_way(Flow::Volts, 5, 0.5 * cap).rest(5), cap);
    assert_eq!(under_way(Flow::Volts, 5, 2.0 * cap).rest(5), 0.0);
}

/// A current that a coil gives back from what it stored is no sign that volts make so much of it.
#[test]
fn no_more_current_is_expected_than_the_ohms_let() {
    let mut g = Governor::new(Store::mean(1.0, 1.0, 0.002), Flow::Model(2.0), 16, 8000.0);
    for current in [10.0, 0.0] {
        (0..16).for_each(|_| g.note(2.0, 2.0, current));
        g.tick();
        assert!(g.is_idle() && g.target == 1.0, "{current}");
    }
}

/// However much is wanted, something is left, so that it is known what is wanted; the cap keeps the budget.
#[test]
fn nothing_is_turned_down_to_nothing() {
    let mut g = Governor::new(Store::mean(1.0, 1.0, 0.002), Flow::Volts, 16, 8000.0);
    (0..5000).for_each(|_| assert!(run(&mut g, 1e12) >= LEAST));
    assert!(g.level() <= 1.02 * (1.0 + 1e-9), "{}", g.level());
    assert_eq!(g.target, LEAST);
}
