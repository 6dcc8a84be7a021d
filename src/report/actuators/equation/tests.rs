//! The equations against their series, their own differences, and the parts they are of.

use super::super::problem::{Subject, listed};
use super::super::series::{Regime, Series};
use super::{Equation, LARGE, LINEAR, MOTOR, State};

/// States that look random, about so large.
fn states(size: State) -> impl Iterator<Item = State> {
    (1..40).map(move |n| {
        let part = |k: f64| (f64::from(n) * k).sin();
        [size[0] * part(1.7), size[1] * part(2.9), size[2] * part(4.3)]
    })
}

fn equation(kind: u8) -> Equation {
    let of_kind = |e: &Equation| e.kind() == kind;
    listed().iter().map(|problem| problem.equation()).find(of_kind).expect("one of each kind")
}

/// The first coefficient of a series is the derivative, whichever way it was written down.
#[test]
fn rates_are_where_the_series_go() {
    fn check<const KIND: u8>(size: State) {
        let e = equation(KIND);
        for x in states(size) {
            let depth = x[2].abs() - e.stroke;
            let side = 1f64.copysign(x[2]);
            let pushes = depth > 0.0 && e.stop_stiffness * depth + e.stop_damping * side * x[1] > 0.0;
            let regime = Regime { stop: if pushes { side } else { 0.0 }, ..Regime::default() };
            let (rates, t) = (e.rates::<KIND>(x, 2.0), 1e-12);
            let change = Series::new(&e, &regime, x, 2.0).change(t);
            for n in 0..3 {
                // What adds up may all but cancel.
                let parts = e.jacobian::<KIND>(x)[n];
                let scale = (0..3).map(|k| (parts[k] * size[k]).abs()).sum::<f64>() + rates[n].abs();
                assert!((change[n] / t - rates[n]).abs() < 1e-6 * scale, "{KIND} {x:?} {n}");
            }
        }
    }
    check::<LINEAR>([0.1, 1000.0, 3.0]);
    check::<MOTOR>([0.1, 1000.0, 3.0]);
    check::<LARGE>([0.5, 1.0, 6e-4]);
}

#[test]
fn a_jacobian_is_how_rates_change() {
    fn check<const KIND: u8>(size: State) {
        let e = equation(KIND);
        for x in states(size).filter(|x| (x[2].abs() - e.stroke).abs() > 1e-6) {
            let a = e.jacobian::<KIND>(x);
            for k in 0..3 {
                let step = 1e-6 * size[k];
                let at = |sign: f64| {
                    let mut x = x;
                    x[k] += sign * step;
                    e.rates::<KIND>(x, 1.0)
                };
                let (above, below) = (at(1.0), at(-1.0));
                for n in 0..3 {
                    let slope = (above[n] - below[n]) / (2.0 * step);
                    let scale = (0..3).map(|j| (a[n][j] * size[j]).abs()).fold(0.0, f64::max) / size[k];
                    assert!((a[n][k] - slope).abs() < 1e-6 * (scale + slope.abs()), "{KIND} {x:?} {n} {k}");
                }
            }
        }
    }
    check::<LINEAR>([0.1, 1000.0, 3.0]);
    check::<MOTOR>([0.1, 1000.0, 3.0]);
    check::<LARGE>([0.5, 1.0, 6e-4]);
}

/// T_c tanh ω/ω_s: against the platform's own.
#[test]
fn smoothed_friction_is_a_tanh() {
    let problem = &listed()[2];
    let (e, Subject::Motor(p)) = (problem.equation(), problem.subject) else { unreachable!() };
    for share in [-1.0, -0.01, -1e-4, 0.0, 3e-4, 0.002, 0.5] {
        let speed = share * p.rated_speed();
        let x = [0.05, speed, 0.3];
        let by = e.rates::<MOTOR>(x, 1.0)[1] - e.smooth_rates::<MOTOR>(x, 1.0)[1];
        let expected = 1.5e-5 * (share / 0.002).tanh() / p.effective_inertia();
        assert!((by - expected).abs() < 1e-9 * p.coulomb / p.effective_inertia(), "{share}: {by}");
    }
}

/// At rest under a steady drive: what current and spring hold each other at.
#[test]
fn at_rest_nothing_changes() {
    let volts = 2.0;
    for problem in listed().iter().filter(|p| p.equation().kind() == LINEAR && !p.spins()) {
        let e = problem.equation();
        let (gain, stiffness, resistance) = match problem.subject {
            Subject::Tactor(v) => (1.2, v.suspension.stiffness + 1200.0, 7.0),
            _ => (1.5, 741.0, 6.0),
        };
        let rest = [volts / resistance, 0.0, gain * volts / resistance / stiffness];
        let rates = e.rates::<LINEAR>(rest, volts);
        assert!(rates[0].abs() < 1e-9 && rates[1].abs() < 1e-9 && rates[2] == 0.0, "{rates:?}");
    }
}
