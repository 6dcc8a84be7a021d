//! Torques of effects that remember nothing.

use super::super::events::{Events, What};
use super::super::program::{Any, Program};
use super::super::{
    Effect, Modulation, Reading, constant, detent, hertz, magnet, spin, spring, table, texture, transient,
    wall,
};
use super::{T, at};
use crate::dsp::random::uniform;

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
