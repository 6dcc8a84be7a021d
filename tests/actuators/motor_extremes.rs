//! The rumble motor past the edges: at stiction, at the top, half a turn a step, no inertia to speak of.

use crate::common::COIN;
use pacinian::actuator::motor::{Casing, Drive, Level, Motor, Parameters, Plan, Reading};

pub const LEVELS: [Level; 3] = [Level::Economy, Level::Default, Level::Fine];

pub fn new(parameters: &Parameters, level: Level, rate: f64) -> Motor {
    Motor::new(parameters, &Plan::whole(level), rate).unwrap()
}

/// A coin motor of these electrical and mechanical constants, its casing held.
pub fn of_times(electrical: f64, mechanical: f64, gravity: f64) -> Parameters {
    let p = Parameters { casing: Casing::Held, inductance: COIN.resistance * electrical, gravity, ..COIN };
    let inertia = mechanical * p.damping();
    // As heavy for its inertia as the coin is.
    Parameters { inertia, eccentric: COIN.eccentric * inertia / COIN.inertia, ..p }
}

pub fn is_finite(r: &Reading) -> bool {
    let one = [r.current, r.voltage, r.speed, r.angle, r.turns, r.angular_acceleration, r.reaction];
    one.iter().chain(&r.force).chain(&r.acceleration).chain(&r.displacement).all(|x| x.is_finite())
}

/// All but gravity's place is symmetric, and that is where the mass hangs: a voltage of the other sign is the mirror image, to the bit.
#[test]
fn a_mirrored_drive_is_a_mirrored_motion() {
    for level in LEVELS {
        let (mut one, mut other) = (new(&COIN, level, 16e3), new(&COIN, level, 16e3));
        for n in 0..8000_u32 {
            let v = 3.0 * f64::from(n * n % 97) / 48.0 - 3.0;
            let fold = |sign: f64| match n % 1000 {
                0..200 => Drive::Current { amperes: sign * 0.08, limit: 2.5 },
                200..300 => Drive::Open,
                _ => Drive::Voltage(sign * v),
            };
            one.step_with(&[(0.1, fold(1.0))]);
            other.step_with(&[(0.1, fold(-1.0))]);
            let (a, b) = (one.reading(), other.reading());
            assert_eq!(
                (a.current, a.speed, a.angle, a.force[0]),
                (-b.current, -b.speed, -b.angle, -b.force[0])
            );
            assert_eq!((a.turns, a.force[1]), (-b.turns, b.force[1]));
        }
    }
}

#[test]
fn it_starts_beyond_stiction_and_not_at_it() {
    for p in [Parameters { gravity: 0.0, ..COIN }, Parameters { gravity: 0.0, inductance: 0.0, ..COIN }] {
        // 2^-n, so that the torque of this voltage is the stiction to the bit.
        let p = Parameters { resistance: 32.0, gain: 1.0 / 1024.0, stiction: 2f64.powi(-15), ..p };
        for level in LEVELS {
            let mut motor = new(&p, level, 48e3);
            motor.drive(Drive::Voltage(1.0));
            (0..1000).for_each(|_| motor.step());
            assert!(motor.is_stuck());
            motor.drive(Drive::Voltage(1.0 + 1e-9));
            (0..1000).for_each(|_| motor.step());
            assert!(motor.speed() > 0.0);
        }
    }
}

/// Friction no larger at rest than in motion: it starts with no torque to spare.
#[test]
fn stiction_may_be_no_more_than_friction() {
    let p = Parameters { stiction: COIN.coulomb, ..COIN };
    for level in LEVELS {
        let mut motor = new(&p, level, 48e3);
        let mut n = 0;
        while motor.is_stuck() {
            motor.drive(Drive::Voltage(1e-5 * f64::from(n)));
            motor.step();
            n += 1;
        }
        assert!((motor.reading().voltage * p.gain / p.resistance - p.coulomb).abs() < 1e-2 * p.coulomb);
        motor.drive(Drive::Voltage(3.0));
        (0..1000).for_each(|_| motor.step());
        assert!(motor.speed() > 100.0);
        assert_eq!(motor.counts().crowded, 0);
    }
}

#[test]
fn it_may_balance_at_the_top() {
    let top = std::f64::consts::PI;
    for level in LEVELS {
        let mut motor = new(&COIN, level, 48e3);
        motor.place(top, 0.0);
        (0..48_000).for_each(|_| motor.step());
        assert!(motor.is_stuck() && motor.reading().angle.abs() == top);
        // Without friction it falls, sooner or later, and no faster than its height allows.
        let p = Parameters { coulomb: 0.0, stiction: 0.0, viscous: 0.0, ..COIN };
        for angle in [top, top - 1e-6, -top + 1e-3] {
            let mut motor = new(&p, level, 48e3);
            motor.drive(Drive::Open);
            motor.place(angle, 0.0);
            let most = 2.0 * p.pendulum_rate() * (1.0 + 1e-5);
            for _ in 0..96_000 {
                motor.step();
                assert!(motor.speed().abs() <= most, "{}", motor.speed());
            }
        }
    }
}

#[test]
fn half_a_turn_a_step_and_more() {
    for (speed, exact) in [(3000.0, 1e3), (1e3 * std::f64::consts::PI, 1e3), (1e5, 1e3)] {
        for level in LEVELS {
            let mut motor = new(&COIN, level, exact);
            motor.place(1.0, speed);
            motor.drive(Drive::Voltage(speed * COIN.gain));
            for _ in 0..1000 {
                motor.step();
                let r = motor.reading();
                assert!(is_finite(&r) && r.speed.abs() <= speed * 1.001, "{r:?}");
            }
            // Without gravity it is exact all the same.
            let p = Parameters { gravity: 0.0, ..COIN };
            let (mut slow, mut quick) = (new(&p, level, 1e3), new(&p, level, 16e3));
            for motor in [&mut slow, &mut quick] {
                motor.place(0.0, speed);
            }
            (0..50).for_each(|_| slow.step());
            (0..800).for_each(|_| quick.step());
            let (a, b) = (slow.reading(), quick.reading());
            let turns = (a.turns - b.turns) * std::f64::consts::TAU + a.angle - b.angle;
            assert!((a.speed - b.speed).abs() < 1e-12 * speed && turns.abs() < 1e-12 * speed, "{a:?} {b:?}");
        }
    }
}

/// With hardly any inertia the speed follows the voltage, by swinging there within a step.
#[test]
fn next_to_no_inertia_is_no_harm() {
    for inertia in [1e-12, 1e-15, 1e-18] {
        for inductance in [0.0, 3e-6, 3e-4, 3e-2] {
            for dry in [0.0, 1.5e-5] {
                let p = Parameters {
                    inertia,
                    inductance,
                    coulomb: dry,
                    stiction: dry,
                    eccentric: 0.0,
                    casing: Casing::Held,
                    ..COIN
                };
                for level in LEVELS {
                    let mut motor = new(&p, level, 48e3);
                    let most = 2.01 * 3.0 / p.gain;
                    for n in 0..500_u32 {
                        motor.drive(Drive::Voltage(if n % 50 < 25 { 3.0 } else { -3.0 }));
                        motor.step();
                        assert!(
                            motor.speed().abs() <= 2.0 * most && is_finite(&motor.reading()),
                            "{p:?} {n}"
                        );
                    }
                    motor.drive(Drive::Voltage(3.0));
                    (0..48_000).for_each(|_| motor.step());
                    assert!(
                        (motor.speed() / p.rated_speed() - 1.0).abs() < 1e-9,
                        "{p:?} {:?}",
                        motor.counts()
                    );
                }
            }
        }
    }
}

/// The gravity of a mass whose rotor it dwarfs: the step is too long for the pendulum, and still nothing runs away.
#[test]
fn a_pendulum_too_quick_for_the_rate() {
    let p = Parameters { inertia: 1e-13, casing: Casing::Held, ..COIN };
    for level in LEVELS {
        for rate in [1e3, 8e3] {
            let mut motor = new(&p, level, rate);
            for n in 0..20_000_u32 {
                motor.drive(Drive::Voltage(if n % 500 < 250 { 3.0 } else { -0.5 }));
                motor.step();
                assert!(motor.speed().abs() < 2.5 * 3.0 / p.gain, "{level:?} {rate} {}", motor.speed());
            }
            assert!(is_finite(&motor.reading()));
        }
    }
}

#[test]
fn an_unplugged_motor_has_no_current_from_that_instant() {
    let p = Parameters { inductance: 3e-2, ..COIN };
    let mut motor = new(&p, Level::Fine, 48e3);
    motor.drive(Drive::Voltage(3.0));
    (0..5000).for_each(|_| motor.step());
    assert!(motor.current() > 0.01);
    motor.drive(Drive::Open);
    let r = motor.reading();
    assert_eq!((r.current, r.voltage), (0.0, p.gain * r.speed));
    motor.step();
    assert_eq!(motor.current(), 0.0);
}

/// A rotor at rest does not creep.
#[test]
fn nothing_moves_while_it_is_stuck() {
    let mut motor = new(&COIN, Level::Fine, 48e3);
    motor.place(0.4, 0.0);
    let angle = motor.reading().angle;
    for n in 0..50_000 {
        motor.drive(Drive::Voltage(0.3 * f64::from(n % 5 - 2)));
        motor.step();
    }
    assert_eq!(motor.reading().angle, angle);
}
