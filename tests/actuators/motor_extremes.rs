//! The rumble motor past the edges: every rate and time constant, no friction, no inertia to speak of, drives that are no numbers.

use crate::common::COIN;
use pacinian::actuator::motor::{
    Casing, Drive, GRAVITY, Level, Motor, Parameters, Plan, Reading, Suspension,
};
use proptest::prelude::{Just, Strategy, any, prop, prop_oneof, proptest};

const LEVELS: [Level; 3] = [Level::Economy, Level::Default, Level::Fine];

fn new(parameters: &Parameters, level: Level, rate: f64) -> Motor {
    Motor::new(parameters, &Plan::whole(level), rate).unwrap()
}

/// A coin motor of these electrical and mechanical constants, its casing held.
fn of_times(electrical: f64, mechanical: f64, gravity: f64) -> Parameters {
    let p = Parameters { casing: Casing::Held, inductance: COIN.resistance * electrical, gravity, ..COIN };
    let inertia = mechanical * p.damping();
    // As heavy for its inertia as the coin is.
    Parameters { inertia, eccentric: COIN.eccentric * inertia / COIN.inertia, ..p }
}

fn is_finite(r: &Reading) -> bool {
    let one = [r.current, r.voltage, r.speed, r.angle, r.turns, r.angular_acceleration, r.reaction];
    one.iter().chain(&r.force).chain(&r.acceleration).chain(&r.displacement).all(|x| x.is_finite())
}

const RATES: [f64; 9] = [1e3, 2e3, 4e3, 8e3, 16e3, 44.1e3, 48e3, 96e3, 192e3];

/// Every rate, electrical and mechanical constant: forward, reverse, open, forward, short. The speed keeps within what voltage and height
/// can give, nothing is created, and friction ends it.
#[test]
fn the_grid_of_rates_and_time_constants() {
    for rate in RATES {
        for electrical in [0.0, 1e-6, 10e-6, 100e-6, 1e-3] {
            for mechanical in [5e-3, 35e-3, 0.3] {
                for gravity in [0.0, GRAVITY] {
                    for level in LEVELS {
                        grid_point(&of_times(electrical, mechanical, gravity), level, rate, mechanical);
                    }
                }
            }
        }
    }
}

fn grid_point(p: &Parameters, level: Level, rate: f64, mechanical: f64) {
    let place = format!("{p:?} {level:?} {rate}");
    let mut motor = new(p, level, rate);
    // Coil and rotor may swing beyond where they go, by less than all of it again.
    let swings = if 4.0 * p.electrical_time() > p.mechanical_time() { 2.0 } else { 1.001 };
    let (full, height) = (p.rated_speed(), 4.0 * p.weight() / p.inertia);
    let most = ((swings * full).powi(2) + height).sqrt() * 1.001;
    let span = ((0.4 * mechanical).min(0.06) * rate).ceil() as usize;
    for drive in [
        Drive::Voltage(3.0),
        Drive::Voltage(-3.0),
        Drive::Open,
        Drive::Current { amperes: 0.05, limit: 3.0 },
        Drive::SHORT,
    ] {
        motor.drive(drive);
        for _ in 0..span {
            let before = motor.stored();
            motor.step();
            let r = motor.reading();
            assert!(is_finite(&r), "{place}: {r:?}");
            assert!(r.speed.abs() <= most, "{place}: {} of {most}", r.speed);
            if drive == Drive::SHORT || drive == Drive::Open {
                // Without gravity to the last digits; with it to what a step makes of a turn.
                let turned = r.speed.abs() / rate;
                let loose = 2.0 * p.weight() * (turned + height / rate / rate).min(1.0);
                assert!(motor.stored() <= before * (1.0 + 1e-12) + loose, "{place}: {before}");
            }
        }
    }
    // Friction has the last word.
    for _ in 0..((6.0 * mechanical * rate) as usize).min(200_000) {
        motor.step();
    }
    if rate * 6.0 * mechanical <= 200_000.0 {
        assert!(motor.is_stuck(), "{place}: {:?}", motor.reading());
    }
}

/// Against the fine level at 384 kHz, which is held to trajectories of 19 digits elsewhere: errors fall with the square of the step, and at
/// the fine level with the fourth power (2.6 where the coil settles within a slow step), for every time constant.
#[test]
fn the_order_is_the_same_all_over_the_grid() {
    for electrical in [0.0, 10e-6, 1e-3] {
        for mechanical in [5e-3, 35e-3, 0.3] {
            let p = of_times(electrical, mechanical, GRAVITY);
            // The angle at every millisecond.
            let run = |level, rate: f64| -> Vec<f64> {
                let mut motor = new(&p, level, rate);
                motor.drive(Drive::Voltage(3.0));
                let angle = |_| {
                    (0..(rate / 1e3) as usize).for_each(|_| motor.step());
                    let r = motor.reading();
                    r.angle + std::f64::consts::TAU * r.turns
                };
                (0..60).map(angle).collect()
            };
            let exact = run(Level::Fine, 384e3);
            let error = |level, rate| {
                let off = run(level, rate).into_iter().zip(&exact).map(|(a, b)| (a - b).abs());
                off.fold(0.0, f64::max)
            };
            let order = |level, (slow, quick): (f64, f64)| {
                (error(level, slow) / error(level, quick)).ln() / f64::ln(quick / slow)
            };
            let default = order(Level::Default, (8e3, 48e3));
            assert!((1.7..2.7).contains(&default), "{electrical} {mechanical}: {default}");
            // What a coil leaves that settles within the first step is of a lower order, and small.
            let fine = order(Level::Fine, (4e3, 16e3));
            let left = error(Level::Fine, 16e3);
            assert!(fine > 2.5 || left < 1e-9, "{electrical} {mechanical}: {fine}, {left:e} rad");
        }
    }
}

#[test]
fn an_inductance_that_vanishes_becomes_none() {
    let mut last = f64::INFINITY;
    for electrical in [1e-4, 1e-5, 1e-6, 1e-9] {
        let run = |electrical: f64| {
            let mut motor = new(&of_times(electrical, 35e-3, GRAVITY), Level::Fine, 48e3);
            motor.drive(Drive::Voltage(3.0));
            (0..2000).for_each(|_| motor.step());
            motor.speed()
        };
        let off = (run(electrical) - run(0.0)).abs() / COIN.rated_speed();
        assert!(off < 4.0 * electrical / 35e-3 && off < last, "{electrical}: {off:e}");
        last = off;
    }
}

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

/// 3e7 steps at 192 kHz: rounding does not add up.
#[test]
fn millions_of_steps_stay_where_they_belong() {
    let p = Parameters { coulomb: 0.0, stiction: 0.0, gravity: 0.0, casing: Casing::Held, ..COIN };
    let mut motor = new(&p, Level::Default, 192e3);
    let volts = vec![3.0; 100_000];
    for _ in 0..300 {
        motor.run(&volts, |_, _, _| {});
    }
    let off = (motor.speed() / p.rated_speed() - 1.0).abs();
    assert!(off < 1e-12, "{off:e}");
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
