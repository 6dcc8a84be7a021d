//! The rumble motor over long times: what is kept, what does not add up, and what becomes nothing.

use crate::common::COIN;
use crate::motor_extremes::{LEVELS, new};
use pacinian::actuator::motor::{Casing, Drive, Level, Parameters};

#[test]
fn without_friction_an_open_rotor_keeps_its_speed_for_ever() {
    let p = Parameters { viscous: 0.0, coulomb: 0.0, stiction: 0.0, gravity: 0.0, ..COIN };
    for level in LEVELS {
        let mut motor = new(&p, level, 48e3);
        motor.drive(Drive::Open);
        motor.place(0.0, 1234.567);
        for n in 0..100_000 {
            if n % 7 == 0 {
                motor.step_with(&[(0.3, Drive::Open)]);
            } else {
                motor.step();
            }
        }
        assert_eq!((motor.speed(), motor.current()), (1234.567, 0.0));
    }
}

/// 86 400 s at 1 kHz and a quarter of a turn a step: the angle is the product, to a part of 1e9 of a turn.
#[test]
fn a_day_of_angle_loses_nothing() {
    let p = Parameters { viscous: 0.0, coulomb: 0.0, stiction: 0.0, gravity: 0.0, ..COIN };
    let mut motor = new(&p, Level::Default, 1e3);
    motor.drive(Drive::Open);
    let steps = 86_400_000_u32;
    // 0.25 + 2^-20 turns a step, whose multiples are exact.
    let turns = 0.25 + 1.0 / 1_048_576.0;
    motor.place(0.0, turns * 1e3 * std::f64::consts::TAU);
    for _ in 0..steps {
        motor.step();
    }
    let r = motor.reading();
    let exact = f64::from(steps) * turns;
    let off = (r.turns - exact) + r.angle / std::f64::consts::TAU;
    // What a rounding of the turns a step (1e-17) adds up to, and no more.
    assert!(off.abs() < 1e-8, "{off:e} turns of {exact}");
    assert!(r.angle.abs() <= std::f64::consts::PI);
}

/// 1e8 steps, over half an hour at 48 kHz: rounding does not add up.
#[test]
fn a_hundred_million_steps_stay_where_they_belong() {
    let p = Parameters { coulomb: 0.0, stiction: 0.0, gravity: 0.0, casing: Casing::Held, ..COIN };
    let mut motor = new(&p, Level::Default, 48e3);
    let volts = vec![3.0; 100_000];
    for _ in 0..1000 {
        motor.run(&volts, |_, _, _| {});
    }
    let off = (motor.speed() / p.rated_speed() - 1.0).abs();
    assert!(off < 1e-12, "{off:e}");
}

/// A pendulum of no friction at all keeps its energy, or what the level makes of it, for a minute.
#[test]
fn a_pendulum_keeps_swinging() {
    let p = Parameters { coulomb: 0.0, stiction: 0.0, viscous: 0.0, ..COIN };
    for (level, most) in [(Level::Default, 1e-4), (Level::Fine, 1e-8)] {
        let mut motor = new(&p, level, 8e3);
        motor.drive(Drive::Open);
        motor.place(2.5, 0.0);
        let before = motor.stored();
        let mut off = 0.0_f64;
        for _ in 0..480_000 {
            motor.step();
            off = off.max((motor.stored() / before - 1.0).abs());
        }
        assert!(off < most, "{level:?} {off:e}");
    }
}

/// What dies away becomes nothing before it becomes a subnormal number.
#[test]
fn nothing_dwindles_for_ever() {
    let smooth = Parameters { coulomb: 0.0, stiction: 0.0, gravity: 0.0, ..COIN };
    for p in
        [COIN, smooth, Parameters { inductance: 3e-2, ..smooth }, Parameters { inductance: 0.0, ..smooth }]
    {
        let mut motor = new(&p, Level::Default, 8e3);
        motor.drive(Drive::Voltage(3.0));
        (0..800).for_each(|_| motor.step());
        motor.drive(Drive::SHORT);
        for _ in 0..80_000 {
            motor.step();
            let (i, w) = (motor.current(), motor.speed());
            assert!((i == 0.0 || i.abs() > 1e-35) && (w == 0.0 || w.abs() > 1e-35), "{i:e} {w:e}");
        }
        assert_eq!((motor.current(), motor.speed()), (0.0, 0.0));
    }
}

#[test]
fn many_steps_at_once_are_the_same_to_the_bit_however_they_are_cut() {
    let volts: Vec<f64> =
        (0..20_000).map(|n| if n % 977 < 400 { 3.0 } else { -1.7 } * f64::from(n % 13 + 1) / 13.0).collect();
    for level in LEVELS {
        for p in
            [COIN, Parameters { gravity: 0.0, ..COIN }, Parameters { coulomb: 0.0, stiction: 0.0, ..COIN }]
        {
            let mut one = new(&p, level, 48e3);
            let steps: Vec<_> = volts
                .iter()
                .map(|v| {
                    one.drive(Drive::Voltage(*v));
                    one.step();
                    (one.current(), one.speed())
                })
                .collect();
            for cut in [1, 7, 64, 20_000] {
                let mut many = new(&p, level, 48e3);
                let mut seen = Vec::new();
                for block in volts.chunks(cut) {
                    many.run(block, |current, speed, _| seen.push((current, speed)));
                }
                assert_eq!(seen, steps, "{level:?} {cut}");
                assert_eq!(many.reading(), one.reading());
                assert_eq!(many.counts(), one.counts());
            }
        }
    }
}

/// Steps that keep where the motor is are its own, and it goes on from them: whatever was done to it before, between and after.
#[test]
fn steps_that_keep_where_it_is_are_the_same_to_the_bit() {
    let linear = Parameters { gravity: 0.0, coulomb: 0.0, stiction: 0.0, ..COIN };
    let volts: Vec<f64> = (0..3000)
        .map(|n| match n % 611 {
            7 => f64::NAN,
            90 => 1e7,
            100..300 => 0.0,
            n => 3.0 - f64::from(n % 13) / 2.0,
        })
        .collect();
    for p in [linear, COIN, Parameters { gravity: 0.0, ..COIN }, Parameters { inductance: 0.0, ..linear }] {
        for before in [Drive::SHORT, Drive::Open, Drive::Current { amperes: 0.05, limit: 2.0 }] {
            for level in LEVELS {
                let mut one = new(&p, level, 48e3);
                one.drive(before);
                (0..480).for_each(|_| one.step());
                let mut other = one.clone();
                for block in volts.chunks(500) {
                    let mut steps = other.steps();
                    for v in block {
                        one.drive(Drive::Voltage(*v));
                        one.step();
                        steps.step(*v);
                        let seen = (steps.current(), steps.speed(), std::f64::consts::TAU * steps.phase());
                        let now = one.reading();
                        assert_eq!(seen, (now.current, now.speed, now.angle), "{level:?} {before}");
                    }
                    drop(steps);
                    one.step();
                    other.step();
                    assert_eq!(one.reading(), other.reading(), "{level:?} {before}");
                    assert_eq!(one.counts(), other.counts());
                    for motor in [&mut one, &mut other] {
                        motor.drive(before);
                        motor.step();
                    }
                    assert_eq!(one.reading(), other.reading(), "{level:?} {before}");
                }
            }
        }
    }
}
