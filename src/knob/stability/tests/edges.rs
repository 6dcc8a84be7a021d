//! Where the first eigenvalue leaves the unit circle.

use super::super::rules::gil;
use super::super::sampled::{Loop, Rotor};
use super::super::work;
use super::{J, rigid};

#[test]
fn the_edge_is_where_the_radius_passes_1() {
    for rate in [1000.0, 10_000.0, 48_000.0, 192_000.0] {
        for delay in [0.0, 0.25, 1.0, 2.0, 3.0, 7.8, 32.0, 128.0, 512.0] {
            for (b, computed) in [(2e-5, 0.0), (2e-4, 0.0), (1e-6, 0.0), (2e-4, 2e-5)] {
                let l = rigid(b, rate, delay);
                let edge = l.edge(computed);
                if edge.gain == 0.0 {
                    assert!(l.radius(1e-9, computed) > 1.0 - 1e-9, "{rate} {delay} {b} {computed}");
                    continue;
                }
                let (under, over) =
                    (l.growth(edge.gain * 0.999_99, computed), l.growth(edge.gain * 1.000_01, computed));
                assert!(under < 0.0 && over > 0.0, "{rate} {delay} {b} {computed}: {edge:?} {under} {over}");
            }
        }
    }
}

/// What it costs grows with the delay, and not with its square, as that of all eigenvalues does.
#[test]
fn an_edge_costs_a_grid_and_no_eigenvalues() {
    let cost = |delay: f64| {
        let l = rigid(2e-4, 48_000.0, delay);
        let (edge, work) = work::of(|| l.edge(0.0));
        assert!(edge.gain > 0.0 && work.eigenvalues < 8, "{work:?}");
        work.points as f64
    };
    assert!(cost(1024.0) / cost(512.0) < 2.2, "{} {}", cost(512.0), cost(1024.0));
    assert!(cost(512.0) > 48.0 * 512.0);
}

#[test]
fn a_fraction_of_a_tick_joins_its_neighbours() {
    let at = |delay: f64| rigid(2e-5, 1e4, delay).edge(0.0).gain;
    assert!((at(0.999_999) / at(1.0) - 1.0).abs() < 1e-5 && (at(1.000_001) / at(1.0) - 1.0).abs() < 1e-5);
    // Smoothly falling, close to b / (T / 2 + d T).
    let mut last = f64::INFINITY;
    for k in 0..60 {
        let delay = 0.05 * f64::from(k);
        assert!(at(delay) < last && (at(delay) / gil(2e-5, 0.0, 1e-4, delay * 1e-4) - 1.0).abs() < 0.05);
        last = at(delay);
    }
}

#[test]
fn both_gains_grow_together_up_to_the_margin() {
    for (b, k, computed, delay) in [(2e-5, 0.05, 1e-5, 1.0), (2e-5, 0.4, 4e-5, 0.5), (0.0, 0.01, 1e-4, 0.0)] {
        let l = rigid(b, 1e4, delay);
        let margin = l.margin(k, computed).gain;
        assert!(margin > 0.0, "{b} {k}");
        let at = |f: f64| l.growth(f * margin * k, f * margin * computed);
        assert!(at(0.999) < 0.0 && at(1.001) > 0.0, "{b} {k}: {margin}");
    }
    assert_eq!(rigid(0.0, 1e4, 0.0).margin(1.0, 0.0).gain, 0.0);
}

#[test]
fn what_cannot_be_is_refused() {
    let good = Rotor { inertia: J, damping: 0.0 };
    for (rotor, period, delay, field) in [
        (Rotor { inertia: 0.0, ..good }, 1e-3, 0.0, "inertia"),
        (Rotor { damping: -1.0, ..good }, 1e-3, 0.0, "damping"),
        (good, 0.0, 0.0, "period"),
        (good, 1e-3, -0.1, "delay"),
        (good, 1e-3, 9000.0, "delay"),
        (good, 1e-3, f64::NAN, "delay"),
    ] {
        assert_eq!(Loop::rigid(&rotor, period, delay).unwrap_err().field, field);
    }
}

/// Undamped, a computed damping alone swings at φ = π / (2 (d + 1)) from B = (2 J / T) tan(φ / 2) on: often an angle of the grid itself.
#[test]
fn an_undamped_knob_has_its_damping_edge_wherever_that_lies_on_the_grid() {
    let t = 1e-4;
    for delay in (0..40).chain([64, 127, 255, 511]) {
        let phi = std::f64::consts::FRAC_PI_2 / f64::from(delay + 1);
        let edge = rigid(0.0, 1.0 / t, f64::from(delay)).damping_edge();
        let expected = 2.0 * J / t * (0.5 * phi).tan();
        assert!((edge.gain / expected - 1.0).abs() < 1e-6, "{delay}: {edge:?} {expected}");
        assert!((edge.hertz * std::f64::consts::TAU * t / phi - 1.0).abs() < 1e-6, "{delay}: {edge:?}");
    }
}
