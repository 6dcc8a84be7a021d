//! Effects that remember.

use super::super::events::{Events, What};
use super::super::{Effect, Modulation, Reading, detent, friction, inertia, snap};
use super::{T, at};
use crate::dsp::random::uniform;
use crate::knob::test_plant::Plant;

#[test]
fn detents_and_snaps_tell_what_was_passed() {
    let d = detent::Detent { hysteresis: 0.1, ..detent::Detent::with_stiffness(10.0, 0.1) };
    let pitch = std::f64::consts::TAU / 10.0;
    let (mut state, mut passed) = (detent::State::default(), Vec::new());
    let path = [0.0, 0.55, 0.49, 0.55, 0.61, 0.45, 0.41, 0.39, -2.2, -2.55, -2.61];
    for u in path {
        let mut events = Events::default();
        d.torque(&mut state, &at(u * pitch), &Modulation::PLAIN, &mut events);
        passed.extend(events.list().iter().map(|e| e.what));
    }
    let detent = |index, passed| What::Detent { index, passed };
    assert_eq!(passed, [detent(1, 1), detent(0, -1), detent(-2, -2), detent(-3, -1)]);
    let s = snap::Snap { width: 0.5, stiffness: 0.2, most: 1.0, point: 0.7, centre: 0.0 };
    let mut state = snap::State::default();
    let mut pull = |angle: f64| {
        let mut events = Events::default();
        let torque = s.torque(&mut state, &at(angle), &Modulation::PLAIN, &mut events);
        (torque, events.list().len())
    };
    for (angle, place, events) in
        [(0.0, 0.0, 0), (0.34, 0.0, 0), (0.36, 0.5, 1), (0.16, 0.5, 0), (0.14, 0.0, 1)]
    {
        let (torque, happened) = pull(angle);
        assert!((torque + 0.2 * (angle - place)).abs() < 1e-15 && happened == events, "{angle}: {torque}");
    }
}

/// Friction depends on the path alone: it comes back with its angle, whatever the time and however often, and takes energy only.
#[test]
fn friction_neither_drifts_nor_gives() {
    for law in [friction::Law::Adhesion, friction::Law::Dahl] {
        let f = friction::Friction { torque: 2e-3, stretch: 0.01, law };
        let mut e = Events::default();
        let (mut one, mut other) = (friction::State::default(), friction::State::default());
        let mut path = 0.0;
        let mut work = 0.0;
        let mut last = 0.0;
        for n in 0..20_000 {
            let step = 4e-3 * uniform(4, n);
            let torque = f.torque(&mut one, &at(path), &Modulation::PLAIN, &mut e);
            // The same path at another rate and speed.
            let fast = Reading { angle: path, velocity: 1e3 * uniform(5, n), dt: T * 7.0 };
            assert_eq!(torque, f.torque(&mut other, &fast, &Modulation::PLAIN, &mut e));
            assert!(torque.abs() <= 2e-3);
            // What a knob that is moved along it gives up, trapezoid by trapezoid, is never less than what is stored.
            if n > 0 && law == friction::Law::Dahl {
                work -= torque * last;
                assert!(work >= -1e-12);
            }
            last = step;
            path += step;
        }
        // A hand that trembles by less than the stretch.
        let mut state = friction::State::default();
        f.torque(&mut state, &at(0.0), &Modulation::PLAIN, &mut e);
        let biased = f.torque(&mut state, &at(6e-3), &Modulation::PLAIN, &mut e);
        for k in 0..10_000 {
            f.torque(&mut state, &at(6e-3 + 2e-3 * f64::from(k % 3)), &Modulation::PLAIN, &mut e);
        }
        let after = f.torque(&mut state, &at(6e-3), &Modulation::PLAIN, &mut e);
        if law == friction::Law::Adhesion {
            assert!((after - biased).abs() < 1e-12 * 2e-3 * 1e4, "{after} {biased}");
        }
        // Dragged far, it slides at its torque.
        for k in 0..100 {
            f.torque(&mut state, &at(1.0 + 0.01 * f64::from(k)), &Modulation::PLAIN, &mut e);
        }
        let slides = f.torque(&mut state, &at(3.0), &Modulation::PLAIN, &mut e);
        assert!((slides + 2e-3).abs() < 1e-12 && (f.bound().stiffness - 0.2).abs() < 1e-12);
    }
}

/// Dahl's step is the exact solution: however a way is cut, it ends the same.
#[test]
fn dahls_friction_is_exact_over_a_step() {
    let f = friction::Friction { torque: 2e-3, stretch: 0.01, law: friction::Law::Dahl };
    let mut e = Events::default();
    let mut end = |cuts: u32| {
        let mut state = friction::State::default();
        let mut torque = 0.0;
        for k in 0..=cuts {
            torque =
                f.torque(&mut state, &at(0.013 * f64::from(k) / f64::from(cuts)), &Modulation::PLAIN, &mut e);
        }
        torque
    };
    let closed = -2e-3 * (1.0 - (-1.3f64).exp());
    assert!((end(1) - closed).abs() < 1e-16 && (end(1000) - closed).abs() < 1e-15);
}

/// Any inertia, coupling and rate: the flywheel's energy never exceeds what the hand put in, and a slow turn feels its inertia.
#[test]
fn a_flywheel_is_stable_and_heavy() {
    for (inertia, stiffness, damping, dt) in [
        (1e-4, 1.0, 1e-3, 1e-4),
        (1e-9, 1e6, 1e-5, 1e-2),
        (1e-7, 1e-3, 5.0, 1e-3),
        (1.0, 0.1, 1e-3, 1.0 / 48e3),
    ] {
        let wheel = inertia::Inertia { inertia, stiffness, damping };
        wheel.check().unwrap();
        let (mut state, mut e) = (inertia::State::default(), Events::default());
        let mut angle = 0.0;
        for n in 0..2000 {
            angle += 1e-3 * uniform(8, n);
            let torque =
                wheel.torque(&mut state, &Reading { angle, velocity: 0.0, dt }, &Modulation::PLAIN, &mut e);
            assert!(torque.is_finite());
        }
        // Held, it swings with no more energy than it has, whatever the rate.
        let held = Reading { angle, velocity: 0.0, dt };
        wheel.torque(&mut state, &held, &Modulation::PLAIN, &mut e);
        let mut before = state.energy(&wheel);
        for _ in 0..5000 {
            wheel.torque(&mut state, &held, &Modulation::PLAIN, &mut e);
            let now = state.energy(&wheel);
            assert!(now <= before * (1.0 + 1e-12), "{inertia}: {now} {before}");
            before = now;
        }
    }
    // Turned with an acceleration a, slow against the coupling, it resists with J a.
    let wheel = inertia::Inertia { inertia: 1e-4, stiffness: 1.0, damping: 2e-2 };
    let (mut state, mut e) = (inertia::State::default(), Events::default());
    let mut torque = 0.0;
    for k in 0..40_000 {
        let time = f64::from(k) * T;
        let reading = Reading { angle: 2.5 * time * time, velocity: 5.0 * time, dt: T };
        torque = wheel.torque(&mut state, &reading, &Modulation::PLAIN, &mut e);
    }
    assert!((torque / (-1e-4 * 5.0) - 1.0).abs() < 0.01, "{torque}");
    // And the loop with a light knob stays calm where −J θ̈ from differences would not: a flywheel of ten times its inertia.
    let wheel = inertia::Inertia { inertia: 6e-5, stiffness: 0.05, damping: 2e-5 };
    let (mut state, mut knob) = (inertia::State::default(), Plant::new(6e-6, 2e-5, 0.0, T));
    knob.speed = 10.0;
    let start = knob.energy();
    for _ in 0..100_000 {
        let reading = Reading { angle: knob.angle, velocity: knob.speed, dt: T };
        let torque = wheel.torque(&mut state, &reading, &Modulation::PLAIN, &mut e);
        knob.step(torque);
        assert!(knob.energy() + state.energy(&wheel) < 1.02 * start);
    }
    assert!(knob.energy() < 0.05 * start);
}
