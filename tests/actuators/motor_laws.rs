//! The rumble motor without gravity and inductance follows laws in closed form: over half a second at 48 kHz within 1e-11 where nothing
//! switches by itself, and 1e-9 with dry friction.

use pacinian::actuator::motor::{Casing, Drive, GRAVITY, Level, Motor, Parameters, Plan};

const RATE: f64 = 48_000.0;
const STEPS: u32 = 24_000;

/// Held flat, with a coil that follows at once.
const COIN: Parameters =
    Parameters { inductance: 0.0, gravity: 0.0, casing: Casing::Held, ..crate::common::COIN };

fn smooth() -> Parameters {
    Parameters { coulomb: 0.0, stiction: 0.0, ..COIN }
}

/// J ω′ = torque − damping ω from a speed: speed and angle after a time.
fn relaxes(inertia: f64, damping: f64, torque: f64, from: f64, t: f64) -> (f64, f64) {
    if damping == 0.0 {
        return (from + torque / inertia * t, from * t + 0.5 * torque / inertia * t * t);
    }
    let (at_last, gone) = (torque / damping, -(-damping / inertia * t).exp_m1());
    (from + (at_last - from) * gone, at_last * t + (from - at_last) * inertia / damping * gone)
}

/// A piece of a law until a time: damping, torque.
type Piece = (f64, f64, f64);

/// Pieces one after the other: speed and angle at a time.
fn law(pieces: &[Piece], from: f64, t: f64) -> (f64, f64) {
    let (mut speed, mut angle, mut begin) = (from, 0.0, 0.0);
    for (end, damping, torque) in pieces {
        let (s, a) = relaxes(COIN.inertia, *damping, *torque, speed, t.min(*end) - begin);
        (speed, angle, begin) = (s, angle + a, *end);
        if t <= *end {
            break;
        }
    }
    (speed, angle)
}

/// The largest error of speed and angle, as a share of the largest of each.
fn worst(parameters: &Parameters, drive: Drive, from: f64, level: Level, pieces: &[Piece]) -> f64 {
    let mut motor = Motor::<false>::new(parameters, &Plan::whole(level), RATE).unwrap();
    motor.drive(drive);
    motor.place(0.0, from);
    let (mut error, mut largest) = ([0.0_f64; 2], [0.0_f64; 2]);
    for n in 1..=STEPS {
        motor.step();
        let r = motor.reading();
        let (speed, angle) = law(pieces, from, f64::from(n) / RATE);
        let got = [r.speed, r.angle + std::f64::consts::TAU * r.turns];
        for (k, exact) in [speed, angle].into_iter().enumerate() {
            error[k] = error[k].max((got[k] - exact).abs());
            largest[k] = largest[k].max(exact.abs());
        }
    }
    (error[0] / largest[0]).max(error[1] / largest[1])
}

const STILL: Piece = (1.0, 1.0, 0.0);
const FOR_EVER: f64 = f64::INFINITY;

#[test]
fn a_voltage_step() {
    let torque = COIN.stall_torque(3.0);
    let (b, dry) = (COIN.damping(), COIN.coulomb);
    for level in [Level::Economy, Level::Default, Level::Fine] {
        let linear = worst(&smooth(), Drive::Voltage(3.0), 0.0, level, &[(FOR_EVER, b, torque)]);
        assert!(linear < 1e-11, "{linear:e}");
        let dry = worst(&COIN, Drive::Voltage(3.0), 0.0, level, &[(FOR_EVER, b, torque - dry)]);
        assert!(dry < 1e-9, "{dry:e}");
    }
}

#[test]
fn a_short_and_an_open_circuit_stop_it_when_they_should() {
    for (drive, b) in [(Drive::SHORT, COIN.damping()), (Drive::Open, COIN.viscous)] {
        let linear = worst(&smooth(), drive, 1500.0, Level::Default, &[(FOR_EVER, b, 0.0)]);
        assert!(linear < 1e-11, "{drive:?} {linear:e}");
        let stops = COIN.inertia / b * (b * 1500.0 / COIN.coulomb).ln_1p();
        assert!(stops < 0.5);
        let dry = worst(&COIN, drive, 1500.0, Level::Default, &[(stops, b, -COIN.coulomb), STILL]);
        assert!(dry < 1e-9, "{drive:?} {dry:e}");
    }
}

#[test]
fn full_reverse() {
    let (b, torque, dry) = (COIN.damping(), COIN.stall_torque(3.0), COIN.coulomb);
    let linear = worst(&smooth(), Drive::Voltage(-3.0), 1500.0, Level::Default, &[(FOR_EVER, b, -torque)]);
    assert!(linear < 1e-11, "{linear:e}");
    let turns = COIN.inertia / b * (1500.0 * b / (torque + dry)).ln_1p();
    let pieces = [(turns, b, -torque - dry), (FOR_EVER, b, -torque + dry)];
    let dry = worst(&COIN, Drive::Voltage(-3.0), 1500.0, Level::Default, &pieces);
    assert!(dry < 1e-9, "{dry:e}");
}

#[test]
fn a_current_until_its_voltage_ends_and_the_voltage_then() {
    for (parameters, viscous) in [(smooth(), 2.15e-8), (COIN, 2.15e-8), (smooth(), 0.0), (COIN, 0.0)] {
        let parameters = Parameters { viscous, ..parameters };
        let (amperes, limit) = (0.06, 3.0);
        let (k, dry) = (COIN.gain, parameters.coulomb);
        let torque = k * amperes - dry;
        let edge = (limit - COIN.resistance * amperes) / k;
        let until = if viscous == 0.0 {
            edge * COIN.inertia / torque
        } else {
            -COIN.inertia / viscous * (-edge * viscous / torque).ln_1p()
        };
        let pieces = [
            (until, viscous, torque),
            (FOR_EVER, parameters.damping(), parameters.stall_torque(limit) - dry),
        ];
        let error = worst(&parameters, Drive::Current { amperes, limit }, 0.0, Level::Default, &pieces);
        let most = if dry == 0.0 { 1e-11 } else { 1e-9 };
        assert!(error < most, "{viscous} {dry} {error:e}");
        let mirrored = Drive::Current { amperes: -amperes, limit };
        let pieces = pieces.map(|(end, b, torque)| (end, b, -torque));
        assert!(worst(&parameters, mirrored, 0.0, Level::Default, &pieces) < most);
    }
}

/// With inductance, the mean of a square wave whose edges fall anywhere within a step: one step of a switched voltage has the charge of the
/// voltage's area, to the last digits.
#[test]
fn a_switch_within_a_step_keeps_its_volt_seconds() {
    let parameters = Parameters { inductance: 1e-3, stiction: 1.0, ..COIN };
    for share in [0.0, 1e-9, 0.25, 0.618, 1.0] {
        // Held fast, L i′ + R i = V: after a step the current is what two exponentials make of it.
        let mut motor = Motor::<false>::new(&parameters, &Plan::whole(Level::Default), RATE).unwrap();
        motor.drive(Drive::Voltage(3.0));
        motor.step_with(&[(share, Drive::Voltage(-1.0))]);
        let decays = |t: f64| (-t / parameters.electrical_time()).exp();
        let first = 0.1 * (1.0 - decays(share / RATE));
        let exact = -1.0 / 30.0 + (first + 1.0 / 30.0) * decays((1.0 - share) / RATE);
        assert!((motor.current() - exact).abs() < 1e-16, "{share}: {} {exact}", motor.current());
    }
}

/// The speed of 2.303 τ, 1.228 τ and 2.970 τ (half and nine tenths of the acceleration), and |a| = (m_e r/M_t) √(ω⁴ + α²).
#[test]
fn a_free_casing_shakes_with_the_square_of_the_speed() {
    let parameters = Parameters { casing: Casing::Free { mass: 0.1 }, ..smooth() };
    let mut motor = Motor::<false>::new(&parameters, &Plan::whole(Level::Default), RATE).unwrap();
    motor.drive(Drive::Voltage(3.0));
    let (tau, full) = (parameters.mechanical_time(), parameters.rated_acceleration().unwrap());
    let mut points = Vec::new();
    for n in 1..=STEPS {
        motor.step();
        let r = motor.reading();
        let size = r.acceleration[0].hypot(r.acceleration[1]);
        let exact = 7.3e-6 * (r.speed.powi(4) + r.angular_acceleration.powi(2)).sqrt();
        assert!((size - exact).abs() < 1e-12 * exact);
        let t = f64::from(n) / RATE / tau;
        for (at, share) in [(1.228, 0.5), (2.970, 0.9)] {
            if (t - at).abs() < 0.5 / RATE / tau {
                assert!((r.speed * r.speed * 7.3e-6 / full - share).abs() < 1e-3);
            }
        }
        points.push((r.speed, size, r.speed * r.speed * 7.3e-6));
    }
    // log-log slope of |a| over speed: 2, where the speed hardly changes any more.
    let ((w1, a1, _), (w2, a2, _)) = (points[8000], points[23_999]);
    let slope = (a2 / a1).ln() / (w2 / w1).ln();
    assert!((slope - 2.0).abs() < 1e-3, "{slope}");
}

/// Forces of a held casing, and a reaction that is what coil and friction leave.
#[test]
fn coil_and_friction_turn_the_casing_the_other_way() {
    let parameters = Parameters { gravity: GRAVITY, ..COIN };
    let mut motor = Motor::<false>::new(&parameters, &Plan::whole(Level::Fine), RATE).unwrap();
    motor.drive(Drive::Voltage(3.0));
    for _ in 0..2000 {
        motor.step();
        let r = motor.reading();
        let on_rotor = COIN.gain * r.current - COIN.viscous * r.speed - COIN.coulomb;
        assert!((r.reaction + on_rotor).abs() < 1e-18, "{r:?}");
        assert_eq!((r.acceleration, r.displacement), ([0.0; 2], [0.0; 2]));
        let size = 7.3e-7 * (r.speed.powi(4) + r.angular_acceleration.powi(2)).sqrt();
        assert!((r.force[0].hypot(r.force[1]) - size).abs() < 1e-12 * size);
    }
    motor.drive(Drive::SHORT);
    for _ in 0..20_000 {
        motor.step();
    }
    // At rest the casing feels the weight's lever, and keeps it off by friction.
    let r = motor.reading();
    assert!(motor.is_stuck());
    assert!((r.reaction + parameters.weight() * r.angle.sin()).abs() < 1e-19);
}
