use super::super::bounds::{Bounds, EndStop};
use super::super::model::{Model, State};
use super::super::parameters::tests::{held, inertial, layered, tactor};
use super::super::parameters::{Coil, Inertial, Skin, Spring, VoiceCoil};
use super::super::plant::{Kind, Plant};
use super::{Large, Shape};
use crate::actuator::drive::Drive;

const SHAPE: Shape = Shape { force_falls: Some(1e-3), stiffens: Some(5e-4), reach: 8e-4 };

fn plants() -> [Plant; 5] {
    let short = VoiceCoil { coil: Coil { inductance: 0.0, ..tactor().coil }, ..tactor() };
    [
        Plant::voice_coil(&tactor()).unwrap(),
        Plant::voice_coil(&short).unwrap(),
        Plant::voice_coil(&layered()).unwrap(),
        Plant::inertial(&inertial()).unwrap(),
        Plant::inertial(&held()).unwrap(),
    ]
}

fn free() -> Bounds {
    Bounds::default()
}

#[test]
fn where_nothing_is_large_it_is_the_linear_model() {
    let none = Shape { force_falls: None, stiffens: None, reach: 1.0 };
    for plant in plants() {
        for drive in [Drive::Voltage, Drive::Current] {
            let mut linear = Model::new(&plant, 8000.0, drive).unwrap();
            let mut large = Large::new(&plant, 8000.0, drive, &free(), &none).unwrap();
            for n in 0..500 {
                let u = (f64::from(n) * 0.3).sin();
                let (a, b) = (linear.step(u), large.step(u));
                assert_eq!(linear.state(), large.model().state());
                assert!(
                    (a.acceleration - b.acceleration).abs() < 1e-12 && (a.current - b.current).abs() < 1e-15
                );
            }
        }
    }
}

/// At rest under a steady drive: k y (1 + y² / y_k²) plus the load's k y is Bl(y) i.
#[test]
fn it_comes_to_rest_where_the_parabolas_say() {
    for plant in plants() {
        let mut large = Large::new(&plant, 192_000.0, Drive::Voltage, &free(), &SHAPE).unwrap();
        let coil = plant.coil();
        // As many volts as bring the linear one to 0.3 mm.
        let compliance = plant.per_ampere(1e-9).displacement.re;
        let volts = 3e-4 / compliance * coil.resistance;
        let mut o = large.outputs();
        for _ in 0..50 {
            let last = o;
            (0..4000).for_each(|_| o = large.step(volts));
            // As still as numbers can tell it, it stays so.
            if o.displacement == last.displacement && o.current == last.current {
                break;
            }
        }
        let y = o.displacement;
        assert!(y > 1e-4 && y < 3e-4);
        let load = coil.force_factor / compliance;
        let pull = load * y + plant.suspension().stiffness * y * (y / 5e-4).powi(2);
        let push = coil.force_factor * (1.0 - (y / 1e-3).powi(2)) * volts / coil.resistance;
        assert!((pull / push - 1.0).abs() < 5e-6, "{pull} {push}");
        let still = o.velocity.abs() < 1e-5 && (o.current - volts / coil.resistance).abs() < 1e-5;
        assert!(still, "{o:?}");
    }
}

/// The equations as they stand, by a Runge-Kutta method of fourth order with steps so small that it has no error to speak of; and the
/// order of convergence of the model towards it, 2.
#[test]
fn it_converges_to_the_equations_with_the_second_order() {
    for inductance in [2.5e-4, 0.0] {
        let v = VoiceCoil { coil: Coil { inductance, ..tactor().coil }, skin: Skin::None, ..tactor() };
        let plant = Plant::voice_coil(&v).unwrap();
        let volts = |n: u32| if n % 40 < 17 { 14.0 } else { -9.0 };
        let slope = |x: [f64; 3], u: f64| {
            let [y, speed, current] = x;
            let bl = 1.2 * (1.0 - (y / 1e-3).powi(2));
            let i = if inductance > 0.0 { current } else { (u - bl * speed) / 7.0 };
            let spring = 3132.7 * y * (1.0 + (y / 5e-4).powi(2));
            let rise = if inductance > 0.0 { (u - 7.0 * i - bl * speed) / inductance } else { 0.0 };
            [speed, (bl * i - 0.6 * speed - spring) / 1.5e-3, rise]
        };
        let (mut x, h) = ([0.0; 3], 1.0 / 8000.0 / 64.0);
        let mut exact = Vec::new();
        for n in 0..400 {
            for _ in 0..64 {
                let plus = |k: [f64; 3], f: f64| [0, 1, 2].map(|i| x[i] + f * k[i]);
                let u = volts(n);
                let k1 = slope(x, u);
                let k2 = slope(plus(k1, 0.5 * h), u);
                let k3 = slope(plus(k2, 0.5 * h), u);
                let k4 = slope(plus(k3, h), u);
                x = [0, 1, 2].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
            }
            exact.push(x[0]);
        }
        let most = exact.iter().fold(0.0f64, |m, y| m.max(y.abs()));
        assert!(most > 3e-4 && most < 8e-4, "large, but within reach: {most}");
        let error = |finer: u32| {
            let rate = 8000.0 * f64::from(finer);
            let mut large = Large::new(&plant, rate, Drive::Voltage, &free(), &SHAPE).unwrap();
            let mut worst = 0.0f64;
            for (n, exact) in exact.iter().enumerate() {
                for _ in 0..finer {
                    large.step(volts(n as u32));
                }
                worst = worst.max((large.model().state().displacement - exact).abs());
            }
            worst / most
        };
        let [coarse, middle, fine] = [2, 6, 24].map(error);
        assert!(middle < 1e-3 && fine < 6e-5, "{inductance}: {coarse:e} {middle:e} {fine:e}");
        let order = (middle / fine).log2() / 2.0;
        assert!((order - 2.0).abs() < 0.1, "{inductance}: {order} of {coarse:e} {middle:e} {fine:e}");
    }
}

/// Duffing's oscillator: period 4 / sqrt(ω² + ε A²) K(m), m = ε A² / 2 (ω² + ε A²), K by the arithmetic-geometric mean.
#[test]
fn a_stiffening_spring_swings_faster_when_it_swings_farther() {
    let suspension = Spring { stiffness: 3132.7, damping: 0.0 };
    let plant = Plant::voice_coil(&VoiceCoil { suspension, skin: Skin::None, ..tactor() }).unwrap();
    for amplitude in [1e-5, 2e-4, 6e-4] {
        let shape = Shape { force_falls: None, ..SHAPE };
        let rate = 192_000.0;
        let mut large = Large::new(&plant, rate, Drive::Current, &free(), &shape).unwrap();
        large.set_state(&State { displacement: amplitude, ..State::default() });
        let (linear, cubic) = (3132.7 / 1.5e-3, 3132.7 / 1.5e-3 * (amplitude / 5e-4f64).powi(2));
        let m = 0.5 * cubic / (linear + cubic);
        let (mut a, mut b) = (1.0, (1.0 - m).sqrt());
        for _ in 0..20 {
            (a, b) = (0.5 * (a + b), (a * b).sqrt());
        }
        let period = 2.0 * std::f64::consts::PI / a / (linear + cubic).sqrt();
        let begin = large.energy();
        // Time of the 50th crossing downwards.
        let (mut crossings, mut before, mut time) = (0, amplitude, 0.0);
        while crossings < 50 {
            large.step(0.0);
            let y = large.model().state().displacement;
            if before > 0.0 && y <= 0.0 {
                crossings += 1;
            }
            time += 1.0 / rate;
            if crossings == 50 {
                time -= y / (y - before) / rate;
            }
            before = y;
        }
        let is = time / 49.25;
        assert!((is / period - 1.0).abs() < 1e-5, "{amplitude}: {is} {period}");
        assert!((large.energy() / begin - 1.0).abs() < 1e-4, "{amplitude}: {}", large.energy() / begin);
    }
}

/// What is seen keeps to Newton at every instant, with the parabolas in it.
#[test]
fn what_is_seen_belongs_together() {
    for drive in [Drive::Voltage, Drive::Current] {
        for inductance in [0.0, 2.5e-4] {
            let v = VoiceCoil { coil: Coil { inductance, ..tactor().coil }, ..tactor() };
            let skin = Plant::voice_coil(&v).unwrap();
            let hand =
                Plant::inertial(&Inertial { coil: Coil { inductance, ..held().coil }, ..held() }).unwrap();
            let free_motor = Plant::inertial(&inertial()).unwrap();
            for plant in [skin, hand, free_motor] {
                let mut large = Large::new(&plant, 48_000.0, drive, &free(), &SHAPE).unwrap();
                for n in 0..2000 {
                    let u = if n / 90 % 2 == 0 { 6.0 } else { -6.0 };
                    let o = large.step(if drive == Drive::Current { u / 7.0 } else { u });
                    let state = large.model().state();
                    let y = o.displacement;
                    let push = large.force_factor(y) * o.current;
                    let (own, inertia, load) = match &plant.kind {
                        Kind::Tactor(v) => {
                            let Skin::One(t) = v.skin else { unreachable!() };
                            let load = t.mass * o.acceleration
                                + t.spring.damping * o.velocity
                                + t.spring.stiffness * y;
                            (v.suspension, v.mass * o.acceleration + o.force, load)
                        }
                        Kind::Inertial(m) => {
                            let load = m.hand.mass * o.casing
                                + m.hand.spring.damping * state.other_velocity
                                + m.hand.spring.stiffness * state.other_displacement;
                            assert!(
                                (m.slug_mass * (o.acceleration + o.casing) + m.casing_mass * o.casing + load)
                                    .abs()
                                    < 1e-10
                            );
                            (m.suspension, m.slug_mass * (o.acceleration + o.casing), load)
                        }
                    };
                    let spring = own.stiffness * y * (1.0 + (y / 5e-4).powi(2)) + own.damping * o.velocity;
                    assert!(
                        y.abs() < 8e-4 && (inertia + spring - push).abs() < 1e-10,
                        "{plant:?} {n}: {o:?}"
                    );
                    assert!((o.force - load).abs() < 1e-10, "{plant:?} {n}: {o:?} {load}");
                }
            }
        }
    }
}

/// Beyond its reach the spring goes on straight, and its energy is what it took to get there.
#[test]
fn beyond_its_reach_energy_is_the_integral_of_the_force() {
    let mut large = Large::new(&plants()[0], 48_000.0, Drive::Current, &free(), &SHAPE).unwrap();
    let mut at = |y: f64| {
        large.set_state(&State { displacement: y, ..State::default() });
        (large.energy(), large.spring(y))
    };
    for y in [1e-4, -7.9e-4, 8e-4, 1e-3, -3e-3] {
        let (h, spring) = (1e-8, at(y).1);
        let pull = (at(y + h).0 - at(y - h).0) / (2.0 * h);
        let linear = 4332.7 * y;
        assert!((pull - linear + spring).abs() < 1e-5 * pull.abs(), "{y}: {pull} {linear} {spring}");
    }
    let slope = (at(3e-3).1 - at(2e-3).1) / 1e-3;
    assert!((slope / ((at(8.1e-4).1 - at(8e-4).1) / 1e-5) - 1.0).abs() < 1e-9, "{slope}");
}

/// Over rates, drives and displacements far beyond the reach: finite, bounded by the drive, and at rest in the end.
#[test]
fn it_is_stable_wherever_it_is_admitted() {
    let stop = EndStop { stroke: 6e-4, spring: Spring { stiffness: 1e5, damping: 2.0 } };
    for plant in plants() {
        for rate in [1e3, 8e3, 48e3] {
            for drive in [Drive::Voltage, Drive::Current] {
                for bounds in [free(), Bounds { end_stop: Some(stop), preload: None }] {
                    let mut large = Large::new(&plant, rate, drive, &bounds, &SHAPE).unwrap();
                    let mut most = 0.0f64;
                    for n in 0..(0.1 * rate) as u32 {
                        large.step(if n / 7 % 2 == 0 { 100.0 } else { -100.0 });
                        most = most.max(large.energy());
                    }
                    assert!(most.is_finite() && most < 1e3, "{plant:?} {rate}: {most}");
                    // At rest it stays: what is left of it is looked at, not the time that it has.
                    for _ in 0..150 {
                        (0..(0.01 * rate) as u32).for_each(|_| _ = large.step(0.0));
                        if large.energy() < 1e-12 * most {
                            break;
                        }
                    }
                    assert!(
                        large.energy() < 1e-9 * most,
                        "{plant:?} {rate} {drive:?}: {} of {most}",
                        large.energy()
                    );
                }
            }
        }
    }
}

#[test]
fn shapes_that_cannot_be_are_refused() {
    let fault = |shape: Shape, rate| {
        Large::new(&plants()[0], rate, Drive::Voltage, &free(), &shape).unwrap_err().field
    };
    assert_eq!(fault(Shape { force_falls: Some(0.0), ..SHAPE }, 48e3), "force_falls");
    assert_eq!(fault(Shape { stiffens: Some(-1.0), ..SHAPE }, 48e3), "stiffens");
    assert_eq!(fault(Shape { reach: 2e-3, ..SHAPE }, 48e3), "reach");
    assert_eq!(fault(SHAPE, 10.0), "rate");
    let mut large = Large::new(&plants()[0], 48e3, Drive::Voltage, &free(), &SHAPE).unwrap();
    large.step(f64::NAN);
    assert_eq!((large.model().masked(), large.model().state()), (1, State::default()));
}
