//! The truth against closed forms and laws. Its tests against trajectories of 19 digits stand with those of the motor.

use super::super::problem::listed;
use super::{Equation, Motion, Regime, State, truth};

/// Nothing but inertia, and a coil that does nothing.
const BARE: Equation = Equation {
    resistance: 1.0,
    inductance: 1.0,
    gain: 0.0,
    direct: 0.0,
    inertia: 2e-3,
    damping: 0.0,
    stiffness: 0.0,
    weight: 0.0,
    coulomb: 0.0,
    stiction: 0.0,
    smooth: 1.0,
    falls: 0.0,
    cubic: 0.0,
    reach: f64::INFINITY,
    stroke: f64::INFINITY,
    stop_stiffness: 0.0,
    stop_damping: 0.0,
    inverse: [1.0, 5e2],
};

fn moving(equation: Equation, state: State, slips: f64) -> Motion {
    let regime = Regime { slips, ..Regime::default() };
    Motion { equation, state, lost: [0.0; 3], regime, drive: 0.0 }
}

/// ω' = −(b ω + T_c)/J: it stops at (J/b) ln(1 + b ω₀/T_c), having turned (J/b) (ω₀ − (T_c/b) ln(1 + b ω₀/T_c)).
#[test]
fn friction_stops_where_the_closed_form_says() {
    let (b, coulomb, from) = (3e-3, 0.02, 40.0);
    let dry = Equation { damping: b, coulomb, stiction: 0.03, ..BARE };
    let (time, log) = (2e-3 / b, f64::ln(1.0 + b * from / coulomb));
    for sense in [1.0, -1.0] {
        let mut motion = moving(dry, [0.0, sense * from, 0.0], sense);
        let mut passed = 0.0;
        while passed < 2.0 * time * log {
            let [_, speed, _] = motion.sample(0.0, 0.011);
            passed += 0.011;
            assert_eq!(speed == 0.0, passed > time * log, "{passed}");
        }
        let turned = sense * time * (from - coulomb / b * log);
        assert!((motion.state[2] / turned - 1.0).abs() < 1e-14, "{} {turned}", motion.state[2]);
    }
}

/// B i = T_s at −(L/R) ln(1 − T_s R/(B u)).
#[test]
fn it_breaks_away_in_its_instant() {
    let dry = Equation { gain: 0.5, coulomb: 0.1, stiction: 0.2, ..BARE };
    let time = -f64::ln(1.0 - 0.2 / 0.5);
    let mut motion = moving(dry, [0.0; 3], 0.0);
    motion.grip();
    assert!(motion.regime.sticks);
    motion.sample(1.0, time * (1.0 - 1e-12));
    assert!(motion.regime.sticks && motion.state[1] == 0.0);
    motion.sample(1.0, time * 2e-12);
    assert!(!motion.regime.sticks && motion.state[1] > 0.0);
    // What pulls the other way breaks away that way.
    let mut other = moving(dry, [0.0; 3], 0.0);
    other.grip();
    other.sample(-1.0, 1.01 * time);
    assert!(other.state[1] < 0.0);
}

/// A stop with damping: p = v₀/q e^(−at) sin qt until k p + c ṗ = 0, at (π − atan2(c q, k − c a))/q; a = c/2m, q² = k/m − a².
#[test]
fn an_end_stop_gives_back_what_the_closed_form_says() {
    let (k, c, from, stroke) = (5e3, 1.1, 0.8, 1e-3);
    let wall = Equation { stroke, stop_stiffness: k, stop_damping: c, ..BARE };
    let a = c / (2.0 * 2e-3);
    let q = f64::sqrt(k / 2e-3 - a * a);
    let lasts = (std::f64::consts::PI - f64::atan2(c * q, k - c * a)) / q;
    let (s, cosine) = (q * lasts).sin_cos();
    let decay = (-a * lasts).exp();
    let (depth, back) = (from / q * decay * s, from * decay * (cosine - a / q * s));
    for side in [1.0, -1.0] {
        let mut motion = moving(wall, [0.0, side * from, 0.0], 0.0);
        let reached = stroke / from;
        let end = 1.1 * (reached + lasts);
        (0..37).for_each(|_| _ = motion.sample(0.0, end / 37.0));
        let [_, v, y] = motion.state;
        let expected = stroke + depth + back * (end - reached - lasts);
        assert!((v / (side * back) - 1.0).abs() < 1e-13, "{v} {back}");
        assert!((y - side * expected).abs() < 1e-16, "{y} {expected}");
        assert_eq!(motion.regime.stop, 0.0);
    }
}

/// Without resistance, friction and damping, what coil, mass, springs and height hold together stays.
#[test]
fn without_losses_no_energy_is_lost() {
    let swing = Equation { resistance: 0.0, inductance: 0.1, gain: 0.02, weight: 0.05, ..BARE };
    let large = Equation { weight: 0.0, stiffness: 9.0, cubic: 4.0, falls: 0.3, reach: 1.5, ..swing };
    let stopped = Equation { stroke: 0.5, stop_stiffness: 300.0, ..large };
    for e in [swing, large, stopped] {
        let energy = |[i, v, y]: State| {
            let depth = (y.abs() - e.stroke).max(0.0);
            0.5 * (e.inductance * i * i
                + e.inertia * v * v
                + e.stiffness * y * y
                + e.stop_stiffness * depth * depth)
                + 0.25 * e.cubic * y.powi(4)
                + e.weight * (1.0 - y.cos())
        };
        let start = [0.3, 30.0, 0.1];
        let (mut motion, mut turned) = (moving(e, start, 0.0), 0);
        for _ in 0..2000 {
            let before = motion.state[1];
            let x = motion.sample(0.0, 0.013);
            turned += u32::from(before * x[1] < 0.0);
            assert!((energy(x) / energy(start) - 1.0).abs() < 1e-13, "{x:?}");
        }
        assert!(turned > 10 || e.weight > 0.0);
    }
}

/// However a time is cut, it comes to the same.
#[test]
fn rates_do_not_matter_where_the_drive_is_the_same() {
    for problem in &listed()[..3] {
        let (slow, quick) = (truth(problem, 1000.0), truth(problem, 12_000.0));
        for (n, x) in slow.iter().enumerate() {
            let y = quick[12 * n + 11];
            assert!((x[1] - y[1]).abs() < 1e-11 && (x[2] - y[2]).abs() < 1e-12, "{} {n}", problem.name);
        }
    }
}

/// What is raced does what it is said to.
#[test]
fn the_problems_have_what_they_are_for() {
    let problems = listed();
    let of = |name: &str| problems.iter().find(|p| p.name == name).unwrap();
    let full = truth(of("full"), 8000.0);
    assert!(full.iter().any(|x| x[1] > 800.0) && full.iter().any(|x| x[1] < -300.0), "it reverses");
    assert!(full.iter().rev().take(80).all(|x| x[1] == 0.0), "it sticks at last");
    let large = of("large");
    let (e, motion) = (large.equation(), truth(large, 48_000.0));
    let most = motion.iter().map(|x| x[2].abs()).fold(0.0, f64::max);
    assert!(most > e.stroke && most < e.reach, "{most}");
    assert!(e.falls * most * most > 0.1 && e.cubic * most * most > 0.1 * e.stiffness);
}

#[test]
fn beyond_its_reach_it_is_not_a_number() {
    let mut motion = moving(Equation { reach: 1.0, cubic: 1.0, ..BARE }, [0.0, 50.0, 0.0], 0.0);
    assert!(motion.sample(0.0, 0.01).iter().all(|x| x.is_finite()));
    for _ in 0..3 {
        assert!(motion.sample(0.0, 0.2).iter().all(|x| x.is_nan()));
    }
}

/// A mass at an angle at which gravity is just below or above what friction holds.
#[test]
fn friction_holds_against_gravity_as_far_as_it_goes() {
    let dry = Equation { weight: 0.3, coulomb: 0.1, stiction: 0.2, ..BARE };
    let most = f64::asin(0.2 / 0.3);
    for side in [1.0, -1.0] {
        let at = |angle: f64| {
            let mut motion = moving(dry, [0.0, 0.0, side * angle], 0.0);
            motion.grip();
            motion.sample(0.0, 0.01)[1]
        };
        assert_eq!(at(most - 1e-9), 0.0);
        // 0.1 N m of 0.2 are left, on 2e-3 kg m², while the mass hardly moves.
        let fallen = -side * at(most + 1e-9);
        assert!((0.45..=0.5).contains(&fallen), "{fallen}");
    }
}
