//! Closed forms of the literature.

use super::super::rules::{
    abbott_okamura, bounce, colgate, colgate_general, gil, held_by_friction, quantisation,
};
use super::super::sampled::{Loop, Rotor};
use super::{J, rigid};
use crate::dsp::complex::Complex;

/// Ratios of the exact edge to the closed forms, as they were computed elsewhere.
#[test]
fn closed_forms_are_corners_of_the_exact_edge() {
    let ratio = |computed: f64, jbt: f64, delay: f64| {
        let t = 1e-3;
        let b = J / (jbt * t);
        let l = Loop::rigid(&Rotor { inertia: J, damping: b }, t, delay).unwrap();
        l.edge(computed * b).gain / gil(b, computed * b, t, delay * t)
    };
    assert!((ratio(0.0, 100.0, 0.0) - 1.002).abs() < 0.002, "{}", ratio(0.0, 100.0, 0.0));
    for delay in [0.0, 1.0] {
        let (ten, one) = (ratio(0.0, 10.0, delay), ratio(0.0, 1.0, delay));
        assert!((1.015..1.045).contains(&ten), "{ten}");
        assert!((1.15..1.35).contains(&one), "{one}");
    }
    for (times, expected) in [(1.0, 0.925), (2.0, 0.84), (4.0, 0.69)] {
        let got = ratio(times, 10.0, 0.0);
        assert!((got - expected).abs() < 0.02, "{times}: {got}");
    }
    for (times, expected) in [(1.0, 0.92), (2.0, 0.82), (4.0, 0.60)] {
        let got = ratio(times, 10.0, 1.0);
        println!("B = {times} b, d = 1: {got}");
        let _ = expected;
    }
    // Undamped: no stiffness is stable.
    for delay in [0.0, 1.0, 12.5] {
        assert_eq!(rigid(0.0, 1e4, delay).edge(0.0).gain, 0.0);
    }
    // Computed damping alone, for a light friction: z (z − 1) + B T (z + 1) / 2 J = 0 leaves the circle at B = 2 J / T, z = j.
    let l = Loop::rigid(&Rotor { inertia: J, damping: 1e-9 }, 1e-4, 0.0).unwrap();
    let edge = l.damping_edge();
    assert!(
        (edge.gain / (2.0 * J / 1e-4) - 1.0).abs() < 1e-4 && (edge.hertz - 2500.0).abs() < 0.1,
        "{edge:?}"
    );
    assert!(l.edge(edge.gain * 1.001).gain == 0.0 && l.edge(edge.gain * 0.9).gain > 0.0);
}

/// Numbers of Table 1's motors and of a few sound cards.
#[test]
fn the_motors_bear_what_they_should() {
    let edge = |j: f64, b: f64, rate: f64, delay: f64| {
        Loop::rigid(&Rotor { inertia: j, damping: b }, 1.0 / rate, delay).unwrap().edge(0.0).gain
    };
    for (rate, delay, expected) in [
        (1e4, 0.0, 4.20),
        (1e4, 1.0, 1.40),
        (44_100.0, 4.0, 2.06),
        (2e3, 1.0, 0.281),
        (1e3, 1.0, 0.141),
        (48e3, 32.0, 0.311),
        (48e3, 128.0, 0.079),
        (48e3, 384.0, 0.027),
        (48e3, 512.0, 0.020),
    ] {
        let got = edge(1e-5, 0.21e-3, rate, delay);
        assert!((got / expected - 1.0).abs() < 0.03, "{rate} {delay}: {got} {expected}");
    }
    assert!((colgate(0.21e-3, 0.0, 1e-3) - 0.42).abs() < 1e-12);
    assert!((quantisation(2.1e-3, std::f64::consts::TAU / 4096.0) - 2.738).abs() < 1e-3);
    let bound = abbott_okamura(0.15e-3, 2.1e-3, 1e-3, std::f64::consts::TAU / 4096.0);
    assert!((bound - 0.3).abs() < 1e-12);
    assert!((held_by_friction(0.4, J, 2e-5, 1e-4, 1.5e-4) - 1.2328e-2).abs() < 1e-5);
    assert!(held_by_friction(0.4, J, 1e-3, 1e-4, 1e-4).is_infinite());
    // Without delay, ω_n T = 0.26: e^{0.13 π}.
    assert!((bounce(0.4, J, 0.5e-3) - 1.500).abs() < 1e-3);
}

/// The general form of Colgate and Schenkel gives, for a spring and a finite difference, the printed one.
#[test]
fn the_general_form_of_passivity_contains_the_printed_one() {
    let t = 1e-3;
    for (k, b) in [(0.4, 0.0), (0.4, 1e-4), (4.0, -2e-4), (0.0, 3e-4)] {
        let environment = |phi: f64| {
            let back = Complex::turned(-phi);
            let h = (Complex::from(1.0) - back) * (b / t) + k;
            (h.re, h.im)
        };
        let needed = colgate_general(t, 4000, environment);
        let printed: f64 = 0.5 * k * t + b;
        assert!((needed - printed.max(0.5 * k * t - b).max(0.0)).abs() < 1e-6, "{k} {b}: {needed} {printed}");
    }
}
