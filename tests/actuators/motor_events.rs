//! What switches within a step of a rumble motor does so at its instant: however a time is cut, the motion is the same.

use pacinian::actuator::motor::{Casing, Drive, Level, Motor, Parameters, Plan};

/// Flat on the table.
const PAD: Parameters = Parameters { gravity: 0.0, ..crate::common::PAD };

fn new(parameters: &Parameters, rate: f64) -> Motor {
    Motor::new(parameters, &Plan::whole(Level::Default), rate).unwrap()
}

/// Numbers within ±1 that look random.
fn mixed(n: u64) -> f64 {
    let n = (n ^ 0x5851_f42d_4c95_7f2d).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let n = (n ^ (n >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((n ^ (n >> 32)) as i64) as f64 / 9_223_372_036_854_775_808.0
}

/// Steps of a millisecond against fifty parts of each, in drives that reverse the rotor, let it stick and bring a current to its limit.
#[test]
fn a_step_is_the_sum_of_its_parts() {
    for (kind, parameters) in [
        PAD,
        Parameters { inductance: 0.0, ..PAD },
        Parameters { inductance: 4.2e-2, ..PAD },
        Parameters { stiction: 6e-4, ..PAD },
        Parameters { stiction: 3e-3, ..PAD },
        Parameters { coulomb: 0.0, ..PAD },
        Parameters { inertia: 1e-8, casing: Casing::Held, ..PAD },
        // It swings by half a turn in a step, and by a whole one.
        Parameters { inertia: 3e-9, casing: Casing::Held, ..PAD },
        Parameters { inertia: 8e-10, coulomb: 6e-5, stiction: 7e-5, casing: Casing::Held, ..PAD },
    ]
    .into_iter()
    .enumerate()
    {
        let (mut whole, mut parts) = (new(&parameters, 1e3), new(&parameters, 1e3));
        for n in 0..3000_u64 {
            let x = mixed(n / 3 + 10_000 * kind as u64);
            let drive = match n / 3 % 7 {
                0 => Drive::Current { amperes: 1.2 * x, limit: 3.0 },
                1 => Drive::Current { amperes: 0.3 * x, limit: 12.5 },
                2 if x > 0.5 => Drive::Open,
                _ => Drive::Voltage(3.0 * x),
            };
            for motor in [&mut whole, &mut parts] {
                motor.drive(drive);
            }
            whole.step();
            (0..50).for_each(|_| parts.part(0.02));
            let (a, b) = (whole.reading(), parts.reading());
            let turned = (a.turns - b.turns) * std::f64::consts::TAU + a.angle - b.angle;
            let off = (a.current - b.current).abs() + (a.speed - b.speed).abs() / 1e3 + turned.abs() / 1e2;
            assert!(off < 1e-10, "{kind} {n} {drive:?}: {off:e}\n{a:?}\n{b:?}");
        }
        assert_eq!(whole.counts().events, parts.counts().events);
        assert!(whole.counts().events > 100, "{:?}", whole.counts());
    }
}

/// What comes to rest with less torque on it than stiction stays there, though friction in motion would not have held it.
#[test]
fn it_stays_at_rest_below_stiction() {
    let between = 6.5e-4 * PAD.resistance / PAD.gain;
    for (volts, sticks) in [(-between, true), (-7.5e-4 * PAD.resistance / PAD.gain, false)] {
        let mut motor = new(&Parameters { inductance: 0.0, ..PAD }, 48e3);
        motor.place(0.0, 50.0);
        motor.drive(Drive::Voltage(volts));
        (0..4800).for_each(|_| motor.step());
        assert_eq!(motor.is_stuck(), sticks, "{volts}");
        assert_eq!(motor.speed() < 0.0, !sticks);
    }
}

/// A source whose voltage is not enough lets go of its current and takes it back when the rotor has slowed down, without a jump.
#[test]
fn a_current_comes_back_when_its_voltage_suffices() {
    let mut motor = new(&Parameters { viscous: 1.2e-5, ..PAD }, 48e3);
    let drive = Drive::Current { amperes: 0.3, limit: 6.0 };
    motor.place(0.0, 600.0);
    motor.drive(drive);
    assert!(motor.current() < 0.3 && motor.reading().voltage == 6.0);
    let (mut before, mut held) = (motor.current(), 0);
    for _ in 0..9600 {
        motor.step();
        let r = motor.reading();
        assert!(r.current <= 0.3 && r.voltage.abs() <= 6.0 * (1.0 + 1e-12), "{r:?}");
        assert!((r.current - before).abs() < 0.03, "{r:?} {before}");
        if r.current == 0.3 {
            held += 1;
        }
        before = r.current;
    }
    assert!(held > 0 && motor.counts().events > 0, "{held} {:?}", motor.reading());
}
