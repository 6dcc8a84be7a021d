//! The rumble motor under drives and numbers that are none, and under any that may be.

use crate::common::COIN;
use crate::motor_extremes::{LEVELS, is_finite, new};
use pacinian::actuator::motor::{Casing, Drive, Level, Motor, Parameters, Plan, Suspension};
use proptest::prelude::{Just, Strategy, any, prop, prop_oneof, proptest};

#[test]
fn what_is_no_number_counts_as_a_short_circuit_and_is_counted() {
    let bad = [
        Drive::Voltage(f64::NAN),
        Drive::Voltage(f64::INFINITY),
        Drive::Voltage(-1e300),
        Drive::Current { amperes: f64::NAN, limit: 3.0 },
        Drive::Current { amperes: 0.1, limit: f64::NAN },
    ];
    for level in LEVELS {
        let (mut one, mut other) = (new(&COIN, level, 48e3), new(&COIN, level, 48e3));
        for n in 0..5000 {
            let good = Drive::Voltage(2.0);
            let (a, b) = if n % 3 == 0 { (bad[n % bad.len()], Drive::SHORT) } else { (good, good) };
            one.drive(a);
            other.drive(b);
            one.step();
            other.step();
            assert_eq!(one.reading(), other.reading());
        }
        assert_eq!((one.counts().masked, other.counts().masked), (1667, 0));
        let mut many = new(&COIN, level, 48e3);
        many.run(&[2.0, f64::NAN, 2.0, f64::NEG_INFINITY, 1e7], |_, _, _| {});
        assert_eq!(many.counts().masked, 3);
        assert!(is_finite(&many.reading()));
    }
    let mut motor = new(&COIN, Level::Default, 48e3);
    motor.place(f64::NAN, f64::INFINITY);
    motor.part(f64::NAN);
    motor.part(-1.0);
    motor.part(f64::INFINITY);
    motor.step_with(&[(f64::NAN, Drive::Voltage(1.0)), (-3.0, Drive::Open), (7.0, Drive::Voltage(2.0))]);
    assert!(is_finite(&motor.reading()));
    for rate in [0.0, -1.0, f64::NAN, 1e9] {
        assert_eq!(Motor::<false>::new(&COIN, &Plan::whole(Level::Fine), rate).unwrap_err().field, "rate");
    }
}

fn parameters() -> impl Strategy<Value = Parameters> {
    let size = |low: f64, high: f64| (low.log10()..high.log10()).prop_map(|e| 10f64.powf(e));
    let maybe = |low, high| prop_oneof![3 => size(low, high), 1 => Just(0.0)];
    let spring = || {
        (maybe(1e-2, 1e9), maybe(1e-3, 1e6))
            .prop_map(|(stiffness, damping)| Suspension { stiffness, damping })
    };
    let casing =
        (size(1e-3, 1e3), spring(), spring(), 0..3).prop_map(|(mass, across, upright, kind)| match kind {
            0 => Casing::Held,
            1 => Casing::Free { mass },
            _ => Casing::Suspended { mass, across, upright },
        });
    let electric = (size(1e-3, 1e6), maybe(1e-9, 1e2), size(1e-6, 1e1));
    let mechanic = (size(1e-15, 1e-2), maybe(1e-12, 1e-2), maybe(1e-9, 1.0), 1.0..3.0, maybe(1e-10, 1e-2));
    (electric, mechanic, 0.0..20.0, casing, size(1e-2, 1e2)).prop_map(
        |(e, m, gravity, casing, rated_volts)| Parameters {
            resistance: e.0,
            inductance: e.1,
            gain: e.2,
            inertia: m.0,
            viscous: m.1,
            coulomb: m.2,
            stiction: m.2 * m.3,
            eccentric: m.4,
            gravity,
            casing,
            rated_volts,
        },
    )
}

fn drive() -> impl Strategy<Value = Drive> {
    let number = prop_oneof![8 => -100.0..100.0, 1 => any::<f64>(), 1 => Just(0.0)];
    let other = prop_oneof![8 => 0.0..100.0, 1 => any::<f64>(), 1 => Just(f64::INFINITY)];
    prop_oneof![
        3 => number.clone().prop_map(Drive::Voltage),
        2 => (number, other).prop_map(|(amperes, limit)| Drive::Current { amperes, limit }),
        1 => Just(Drive::Open),
    ]
}

proptest! {
    /// No parameters that pass, no rate and no drive make anything but numbers.
    #[test]
    fn nothing_but_numbers_comes_out(
        p in parameters(),
        rate in prop_oneof![1.0..1e3, 1e3..2e5, 1e5..1e8],
        drives in prop::collection::vec((0.0..1.5_f64, drive()), 1..60),
        level in 0..3_usize,
    ) {
        if p.check().is_ok() {
            let mut motor = new(&p, LEVELS[level], rate);
            for pair in drives.chunks(2) {
                motor.step_with(pair);
                motor.step();
                assert!(is_finite(&motor.reading()), "{:?}", motor.reading());
            }
            motor.run(&[1.0, -50.0, 3.0, 3.0, 3.0], |current, speed, phase| {
                assert!(current.is_finite() && speed.is_finite() && phase.abs() <= 0.5);
            });
        }
    }
}
