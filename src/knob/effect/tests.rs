use super::events::{Events, What};
use super::program::{Any, Program};
use super::{
    Bound, Effect, Modulation, Reading, constant, damper, detent, friction, hertz, inertia, magnet, snap,
    spin, spring, table, texture, transient, wall,
};
use crate::dsp::random::uniform;
use crate::knob::test_plant::{Delay, Plant, count, floor};
use proptest::prelude::{ProptestConfig, prop_assert, proptest};

const T: f64 = 1e-4;

fn at(angle: f64) -> Reading {
    Reading { angle, velocity: 0.0, dt: T }
}

fn still<E: Effect>(e: &E, angle: f64) -> f64 {
    e.torque(&mut E::State::default(), &at(angle), &Modulation::PLAIN, &mut Events::default())
}

/// Torque is minus the slope of the energy, and no steeper than the bound.
fn conserves<E: Effect>(e: &E) {
    e.check().unwrap();
    let most = e.bound().stiffness;
    let mut steepest = 0.0f64;
    for n in 0..4000 {
        let angle = 4.0 * uniform(3, n);
        let (h, g) = (1e-6, 1e-4);
        let slope = (e.energy(angle + g).unwrap() - e.energy(angle - g).unwrap()) / (2.0 * g);
        let torque = still(e, angle);
        assert!(
            (torque + slope).abs() < 1e-3 * (torque.abs() + most * g * 10.0 + 1e-9),
            "{angle}: {torque} {slope}"
        );
        steepest = steepest.max((still(e, angle + h) - still(e, angle - h)).abs() / (2.0 * h));
    }
    assert!(steepest <= most * 1.000_01 + 1e-9 && steepest >= 0.5 * most, "{steepest} {most}");
}

#[test]
fn torque_is_the_slope_of_energy() {
    conserves(&spring::Spring { stiffness: 0.3, centre: 0.7 });
    conserves(&constant::Constant { torque: -0.01 });
    conserves(&wall::Wall { angle: 0.5, below: false, stiffness: 2.0, damping: 0.0 });
    conserves(&wall::Stops { low: -1.0, high: 1.5, stiffness: 2.0, damping: 0.0 });
    conserves(&magnet::Magnet { centre: 0.2, stiffness: 0.4, reach: 1.1 });
    conserves(&texture::Ripple { amplitude: 0.003, wavelength: 0.4 });
    conserves(&hertz::Hertz { angle: -1.0, below: true, factor: 0.5, most: 0.6 });
    for shape in [detent::Shape::Sine, detent::Shape::Triangle] {
        conserves(&detent::Detent { count: 7.0, amplitude: 0.01, centre: 0.1, shape, hysteresis: 0.0 });
    }
    let points = [(-2.0, 0.1), (-1.0, 0.3), (0.5, -0.2), (0.7, -0.25), (3.0, 0.0)];
    conserves(&table::Table::new(&points).unwrap());
}

#[test]
fn values_are_those_of_the_definitions() {
    let sine = detent::Detent::with_stiffness(24.0, 0.192);
    assert!((sine.amplitude - 8e-3).abs() < 1e-15);
    for n in 0..1000 {
        let angle = 10.0 * uniform(1, n);
        assert!((still(&sine, angle) + 8e-3 * (24.0 * angle).sin()).abs() < 1e-14, "{angle}");
    }
    // Rests at multiples of a 24th of a turn, for every shape.
    let table = (0..64).map(|k| -(std::f64::consts::TAU * (f64::from(k) / 64.0 - 0.5)).sin()).collect();
    for shape in [detent::Shape::Sine, detent::Shape::Triangle, detent::Shape::Table(table)] {
        let d = detent::Detent { shape, ..sine.clone() };
        for k in -50..50 {
            let rest = f64::from(k) * std::f64::consts::TAU / 24.0;
            assert!(
                still(&d, rest).abs() < 1e-14 * 24.0
                    && still(&d, rest + 1e-3) < 0.0
                    && still(&d, rest - 1e-3) > 0.0
            );
        }
        let slope = (still(&d, -1e-4) - still(&d, 1e-4)) / 2e-4;
        assert!((slope / d.stiffness() - 1.0).abs() < 0.01);
    }
    // Hertz: local stiffness 3 F / 2 p.
    let h = hertz::Hertz { angle: 0.0, below: false, factor: 30.0, most: 10.0 };
    assert!((still(&h, 0.04) + 30.0 * 0.008).abs() < 1e-15);
    let local = (still(&h, 0.04 - 1e-6) - still(&h, 0.04 + 1e-6)) / 2e-6;
    assert!((local - 1.5 * 0.24 / 0.04).abs() < 1e-6);
    let deep = (10.0f64 / 30.0).powf(2.0 / 3.0);
    assert!((h.bound().stiffness - 1.5 * 10.0 / deep).abs() < 1e-9);
    let pull = still(&magnet::Magnet { centre: 0.0, stiffness: 1.0, reach: 1.0 }, 0.2f64.sqrt());
    assert!((pull + 0.2f64.sqrt() * 0.64).abs() < 1e-15);
    let spins = spin::Spin { speed: 3.0, damping: 0.01, most: 0.02 };
    assert_eq!(still(&spins, 1.0), 0.02);
}

/// Which way a wall pushes, whatever the speed, and what it says.
#[test]
fn a_wall_never_pulls() {
    for below in [false, true] {
        let w = wall::Wall { angle: 0.3, below, stiffness: 1.0, damping: 0.1 };
        let side = if below { -1.0 } else { 1.0 };
        let mut state = wall::State::default();
        for n in 0..5000 {
            let reading = Reading { angle: 0.3 + uniform(1, n), velocity: 30.0 * uniform(2, n), dt: T };
            let mut events = Events::default();
            let inside = (reading.angle - 0.3) * side > 0.0;
            let before = state;
            let torque = w.torque(&mut state, &reading, &Modulation::PLAIN, &mut events);
            assert!(torque * side <= 0.0 && (inside || torque == 0.0));
            let hit = inside && before == wall::State::default();
            let speed = reading.velocity.abs();
            let expected = if hit { vec![What::Wall { speed, side: side as i8 }] } else { vec![] };
            assert_eq!(events.list().iter().map(|e| e.what).collect::<Vec<_>>(), expected);
        }
    }
}

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

#[test]
fn a_struck_wall_rings_as_it_should() {
    let ring = transient::Transient { strength: 1e-3, hertz: 120.0, decay: 0.01, least: 0.5, most: 0.05 };
    let w = wall::Wall { angle: 0.0, below: false, stiffness: 0.0, damping: 0.0 };
    let mut program = Program::new(vec![Any::from(w), Any::from(ring)]).unwrap();
    let mut events = Events::default();
    let mut tick =
        |angle: f64, velocity: f64| program.tick(&Reading { angle, velocity, dt: T }, 1.0, 1.0, &mut events);
    assert_eq!(tick(-1.0, 5.0), 0.0);
    for k in 0..2000 {
        let time = f64::from(k) * T;
        let exact = -5e-3 * (-time / 0.01).exp() * (std::f64::consts::TAU * 120.0 * time).sin();
        let got = tick(0.1, if k == 0 { 5.0 } else { 0.0 });
        assert!((got - exact).abs() < 1e-8, "{k}: {got} {exact}");
    }
    assert_eq!(tick(0.1, 0.0), 0.0);
    // Too slow to be heard.
    tick(-1.0, 0.0);
    assert_eq!((tick(0.1, 0.4), tick(0.1, 0.4)), (0.0, 0.0));
}

#[test]
fn a_ripple_fades_before_it_folds() {
    let ripple = texture::Ripple { amplitude: 1.0, wavelength: 0.01 };
    let mut e = Events::default();
    let mut peak = |velocity: f64| {
        ripple.torque(&mut (), &Reading { angle: 0.0025, velocity, dt: T }, &Modulation::PLAIN, &mut e)
    };
    // A tenth of 10 kHz over 0.01 rad is 10 rad/s.
    for (speed, size) in [(0.0, 1.0), (5.0, 1.0), (7.5, 0.5), (-7.5, 0.5), (10.0, 0.0), (1e9, 0.0)] {
        assert!((peak(speed) - size).abs() < 1e-12, "{speed}");
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let fault =
        |any: Any| Program::new(vec![Any::from(constant::Constant { torque: 0.0 }), any]).unwrap_err();
    let d = detent::Detent::with_stiffness(24.0, 0.1);
    let f = friction::Friction { torque: 1e-3, stretch: 0.01, law: friction::Law::Adhesion };
    let r = transient::Transient { strength: 1e-3, hertz: 120.0, decay: 0.01, least: 0.5, most: 0.05 };
    let cases: Vec<(Any, &str)> = vec![
        (spring::Spring { stiffness: -1.0, centre: 0.0 }.into(), "stiffness"),
        (spring::Spring { stiffness: 1.0, centre: f64::NAN }.into(), "centre"),
        (damper::Damper { damping: f64::INFINITY }.into(), "damping"),
        (wall::Stops { low: 1.0, high: 0.0, stiffness: 1.0, damping: 0.0 }.into(), "high"),
        (detent::Detent { count: 0.0, ..d.clone() }.into(), "count"),
        (detent::Detent { hysteresis: 0.5, ..d.clone() }.into(), "hysteresis"),
        (detent::Detent { shape: detent::Shape::Table([0.5].into()), ..d.clone() }.into(), "table"),
        (detent::Detent { shape: detent::Shape::Table([0.5, 2.0].into()), ..d }.into(), "table"),
        (snap::Snap { width: 0.1, stiffness: 1.0, most: 1.0, point: 0.4, centre: 0.0 }.into(), "point"),
        (magnet::Magnet { centre: 0.0, stiffness: 1.0, reach: 0.0 }.into(), "reach"),
        (friction::Friction { stretch: 0.0, ..f }.into(), "stretch"),
        (inertia::Inertia { inertia: 0.0, stiffness: 1.0, damping: 0.0 }.into(), "inertia"),
        (texture::Ripple { amplitude: 1.0, wavelength: 0.0 }.into(), "wavelength"),
        (texture::Fed { scale: f64::NAN }.into(), "scale"),
        (hertz::Hertz { angle: 0.0, below: false, factor: 0.0, most: 1.0 }.into(), "factor"),
        (spin::Spin { speed: 1.0, damping: 1.0, most: 0.0 }.into(), "most"),
        (transient::Transient { hertz: 19.0, ..r }.into(), "hertz"),
    ];
    for (any, field) in cases {
        let (which, fault) = fault(any);
        assert_eq!((which, fault.field), (1, field));
    }
    for (points, field) in [
        (vec![(0.0, 1.0)], "points"),
        (vec![], "points"),
        (vec![(0.0, 1.0), (0.0, 2.0)], "angle"),
        (vec![(1.0, 1.0), (0.0, 2.0)], "angle"),
        (vec![(0.0, f64::NAN), (1.0, 2.0)], "torque"),
    ] {
        assert_eq!(table::Table::new(&points).unwrap_err().field, field);
    }
    assert!(Program::new(vec![Any::from(constant::Constant { torque: 0.0 }); 65]).is_err());
}

/// One of each.
fn all() -> Vec<Any> {
    let points = [(-2.0, 0.1), (-1.0, 0.3), (0.5, -0.2), (3.0, 0.0)];
    vec![
        wall::Stops { low: -2.0, high: 2.0, stiffness: 1.0, damping: 1e-3 }.into(),
        spring::Spring { stiffness: 0.1, centre: 0.0 }.into(),
        damper::Damper { damping: 1e-3 }.into(),
        detent::Detent::with_stiffness(24.0, 0.1).into(),
        snap::Snap { width: 0.2, stiffness: 0.1, most: 0.1, point: 0.6, centre: 0.0 }.into(),
        magnet::Magnet { centre: 0.0, stiffness: 0.4, reach: 0.3 }.into(),
        friction::Friction { torque: 2e-3, stretch: 0.01, law: friction::Law::Dahl }.into(),
        inertia::Inertia { inertia: 1e-4, stiffness: 1.0, damping: 1e-3 }.into(),
        constant::Constant { torque: 1e-3 }.into(),
        spin::Spin { speed: 3.0, damping: 0.01, most: 0.02 }.into(),
        texture::Ripple { amplitude: 0.01, wavelength: 0.1 }.into(),
        texture::Fed { scale: 1.0 }.into(),
        table::Table::new(&points).unwrap().into(),
        hertz::Hertz { angle: 0.0, below: true, factor: 30.0, most: 10.0 }.into(),
        transient::Transient { strength: 1e-3, hertz: 120.0, decay: 0.01, least: 0.5, most: 0.05 }.into(),
    ]
}

#[test]
fn a_program_is_the_sum_of_its_effects() {
    let mut together = Program::new(all()).unwrap();
    let mut apart: Vec<Program> = all().into_iter().map(|any| Program::new(vec![any]).unwrap()).collect();
    together.controls()[3].gain = -2.0;
    apart[3].controls()[0].gain = -2.0;
    together.controls()[11].fed = 0.25;
    apart[11].controls()[0].fed = 0.25;
    let (mut events, mut angle) = (Events::default(), 0.0);
    for n in 0..3000 {
        angle += 0.01 * uniform(1, n);
        let reading = Reading { angle, velocity: 0.3 * uniform(2, n), dt: T };
        let sum: f64 = apart.iter_mut().map(|p| p.tick(&reading, 0.5, 0.25, &mut events)).sum();
        assert!((together.tick(&reading, 0.5, 0.25, &mut events) - sum).abs() < 1e-12);
    }
    let demand = apart.iter().map(Program::demand).fold(Bound::default(), |a, b| Bound {
        stiffness: a.stiffness + b.stiffness,
        damping: a.damping + b.damping,
    });
    assert!((together.demand().stiffness - demand.stiffness).abs() < 1e-9 && together.masked() == 0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Whatever is read or asked, the sum is a number, and it is the same as before once the readings are good again.
    #[test]
    fn hostile_readings_leave_no_trace(seed in 0u64..1000, wild in proptest::sample::select(
        vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e17, 0.0])) {
        let mut program = Program::new(all()).unwrap();
        let mut events = Events::default();
        for n in 0..200u64 {
            let mut reading = Reading { angle: 2.0 * uniform(seed, n), velocity: 20.0 * uniform(seed + 1, n), dt: T };
            match n % 17 {
                3 => reading.angle = wild,
                7 => reading.velocity = wild,
                11 => reading.dt = wild,
                13 => program.controls()[(n % 15) as usize].gain = wild,
                14 => program.controls().iter_mut().for_each(|c| c.gain = 1.0),
                _ => {}
            }
            prop_assert!(program.tick(&reading, 1.0, 1.0, &mut events).is_finite());
        }
        program.controls().iter_mut().for_each(|c| c.gain = 1.0);
        let before = program.masked();
        for n in 0..50_000u64 {
            let reading = Reading { angle: 0.1 * uniform(seed, n), velocity: 0.0, dt: T };
            prop_assert!(program.tick(&reading, 1.0, 1.0, &mut events).is_finite());
        }
        prop_assert!(program.masked() == before);
    }
}

/// A knob that starts at an angle with a speed, under one effect, its torque late by whole ticks: where it ends.
fn ends(
    effect: Any,
    friction: f64,
    rate: f64,
    delay: usize,
    counts: f64,
    start: (f64, f64),
    time: f64,
) -> (f64, f64) {
    let delta = if counts == 0.0 { 0.0 } else { count(counts) };
    let mut program = Program::new(vec![effect]).unwrap();
    let mut events = Events::default();
    let mut plant = Plant::new(6e-6, 2e-5, friction, 1.0 / rate);
    (plant.angle, plant.speed) = start;
    let mut line = Delay::new(delay);
    let mut torque = |angle: f64| {
        let reading = Reading { angle: floor(angle, delta), velocity: 0.0, dt: 1.0 / rate };
        program.tick(&reading, 1.0, 1.0, &mut events)
    };
    for _ in 0..delay {
        line.pass(torque(start.0));
    }
    for _ in 0..(time * rate).round() as usize {
        plant.step(line.pass(torque(plant.angle)));
    }
    (plant.angle, plant.speed)
}

/// Last rows of the reference trajectories `knob_k3s_*` and `knob_k4s_*`, computed there with 50 digits.
#[test]
fn sampled_walls_and_detents_end_where_the_reference_does() {
    let wall = |stiffness| Any::from(wall::Wall { angle: 0.0, below: false, stiffness, damping: 0.0 });
    for (k, rate, delay, counts, angle, speed) in [
        (0.4, 1e3, 0, 0.0, -0.573_346_139_519_930_8, -21.789_600_254_357_265),
        (4.0, 1e4, 1, 4000.0, -0.756_339_958_838_282_3, -21.314_671_355_437_185),
        (40.0, 48e3, 1, 4000.0, -0.766_562_576_898_260_4, -19.936_692_437_868_29),
        (40.0, 1e3, 1, 0.0, -11.449_772_635_367_695, -316.264_657_184_283_7),
    ] {
        let end = ends(wall(k), 0.0, rate, delay, counts, (-0.0503, 20.0), 0.04);
        assert!(
            (end.0 / angle - 1.0).abs() < 1e-10 && (end.1 / speed - 1.0).abs() < 1e-10,
            "{k} {rate}: {end:?}"
        );
    }
    let detents = detent::Detent { amplitude: 8e-3, ..detent::Detent::with_stiffness(24.0, 1.0) };
    for (rate, angle, speed) in [
        (1e3, 3.421_582_545_292_086, 19.364_548_273_652_58),
        (1e4, -0.039_248_413_237_318_25, 2.595_467_229_134_871),
    ] {
        let end = ends(detents.clone().into(), 1e-4, rate, 1, 4000.0, (0.02, 9.0), 0.3);
        assert!((end.0 - angle).abs() < 1e-10 && (end.1 / speed - 1.0).abs() < 1e-9, "{rate}: {end:?}");
    }
}
