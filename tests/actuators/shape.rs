//! Drive shaping on the motors it is for: clicks that stop, and envelopes that are followed.

use std::f64::consts::{PI, TAU};

use pacinian::actuator::motor::{Casing, Drive, Level, Motor, Parameters, Plan};
use pacinian::actuator::shape::{
    Click, Clicked, Course, Ending, Home, Inverse, Park, Spin, Switching, Unreachable,
};

const RATE: f64 = 48_000.0;

/// The three motors of the reference, in the hands of nobody, upright.
fn motors() -> Vec<Parameters> {
    let cases = crate::common::cases();
    ["coin10", "cyl6", "gamepadL"]
        .iter()
        .map(|device| {
            let of = |case: &&crate::common::Case| {
                case.name.starts_with(device) && case.name.contains("reversal_gravity")
            };
            cases.iter().find(of).unwrap().parameters
        })
        .collect()
}

fn plant(parameters: &Parameters, angle: f64) -> Motor {
    let mut motor = Motor::new(parameters, &Plan::whole(Level::Fine), RATE).unwrap();
    motor.place(angle, 0.0);
    motor
}

/// The largest speed on the way, and the speed at the end of the course, of a motor that may be another than the one it is for.
fn clicked(course: &Course, parameters: &Parameters, angle: f64) -> (f64, f64) {
    let mut motor = plant(parameters, angle);
    let (mut peak, mut begin) = (0.0_f64, 0.0);
    for (end, drive) in course.pieces() {
        motor.drive(*drive);
        let pieces = ((end - begin) * RATE).ceil().max(1.0);
        for _ in 0..pieces as usize {
            motor.part((end - begin) * RATE / pieces);
            peak = peak.max(motor.speed().abs());
        }
        begin = *end;
    }
    (peak, motor.speed())
}

#[test]
fn a_click_has_stopped_when_its_drive_ends() {
    for (name, motor) in ["coin10", "cyl6", "gamepadL"].iter().zip(motors()) {
        for inductance in [0.0, motor.inductance] {
            let parameters = Parameters { inductance, ..motor };
            for (turns, ending, angle) in [
                (0.25, Ending::Stopped, 0.3),
                (1.0, Ending::Stopped, 2.0),
                (0.25, Ending::Settled, 0.3),
                (-1.0, Ending::Settled, -1.0),
            ] {
                let click = Click { turns, drive: Drive::Voltage(parameters.rated_volts), angle, ending };
                let solved: Clicked = click.solve(&parameters).unwrap();
                let (peak, left) = clicked(&solved.course, &parameters, angle);
                println!(
                    "{name} L {inductance:.1e} {turns:5} {ending:?}: {:?} ms, peak {peak:.0} rad/s, left {:.1e} of it",
                    solved.seconds.map(|s| s * 1e3),
                    left.abs() / peak
                );
                assert!(left.abs() < 1e-6 * peak, "{name} {click:?}: {left} of {peak}");
                assert!((peak / solved.peak_speed - 1.0).abs() < 1e-3);
                assert!(
                    (solved.angle - angle - TAU * turns).abs() < 1e-6 * TAU,
                    "{click:?} {}",
                    solved.angle
                );
                let [forward, backward, again] = solved.seconds;
                assert!(backward < forward, "less than as long as forward");
                assert_eq!(again > 0.0, ending == Ending::Settled && inductance > 0.0);
                // Behind a settled click nothing moves any more; behind one that has stopped, at most what the coil still does.
                let mut motor = plant(&parameters, angle);
                let (mut n, mut fastest, mut last) = (0, 0.0_f64, 0.0);
                let end = (solved.course.duration() * RATE).ceil() as usize;
                solved.course.play(&mut motor, RATE, end + 2000, |motor| {
                    n += 1;
                    if n > end {
                        (fastest, last) = (fastest.max(motor.speed().abs()), motor.current());
                    }
                });
                if ending == Ending::Settled {
                    assert!(fastest < 1e-6 * peak && last.abs() < 1e-9, "{click:?}: {fastest}");
                }
            }
        }
    }
}

/// Without friction, gravity and inductance there is a closed form: t2 = τ ln(1 + ω1/ω_b) with ω1 = ω_a (1 − exp(−t1/τ)), and the angle is
/// ω_a t1 − ω_b t2.
#[test]
fn a_click_is_that_of_its_closed_form() {
    for motor in motors() {
        let parameters = Parameters { inductance: 0.0, gravity: 0.0, ..motor };
        let (volts, tau) = (parameters.rated_volts, parameters.mechanical_time());
        let (stall, damping) = (parameters.stall_torque(volts), parameters.damping());
        let (a, b) = ((stall - parameters.coulomb) / damping, (stall + parameters.coulomb) / damping);
        let click = Click { turns: 0.25, drive: Drive::Voltage(volts), angle: 0.0, ending: Ending::Stopped };
        let [t1, t2, _] = click.solve(&parameters).unwrap().seconds;
        let due = tau * (1.0 + a * -(-t1 / tau).exp_m1() / b).ln();
        assert!((t2 / due - 1.0).abs() < 1e-9, "{t2} {due}");
        assert!((a * t1 - b * t2 - 0.25 * TAU).abs() < 1e-8);
    }
}

/// By a current the torque is all there is: a click stops, whatever the inductance, and friction alone makes the way back shorter:
/// a = (k I ∓ c)/J, t2 = t1 a1/a2, and the angle ½ a1 t1 (t1 + t2).
#[test]
fn a_click_by_current_is_that_of_its_closed_form() {
    for motor in motors() {
        for inductance in [0.0, motor.inductance] {
            let parameters = Parameters { inductance, gravity: 0.0, viscous: 0.0, ..motor };
            let amperes = 0.8 * parameters.rated_volts / parameters.resistance;
            let drive = Drive::Current { amperes, limit: f64::from(1_000_000) };
            let click = Click { turns: -0.25, drive, angle: 0.0, ending: Ending::Settled }
                .solve(&parameters)
                .unwrap();
            let [t1, t2, t3] = click.seconds;
            let inertia = parameters.effective_inertia();
            let [fast, slow] =
                [1.0, -1.0].map(|by| (parameters.gain * amperes + by * parameters.coulomb) / inertia);
            assert!((t2 / (t1 * slow / fast) - 1.0).abs() < 1e-6, "{t1} {t2} {t3}");
            assert!((0.5 * slow * t1 * (t1 + t2) / (0.25 * TAU) - 1.0).abs() < 1e-6, "{t1} {t2}");
            let (peak, left) = clicked(&click.course, &parameters, 0.0);
            assert!(
                left.abs() < 1e-5 * peak && (click.peak_speed / peak - 1.0).abs() < 1e-3,
                "{left} of {peak}"
            );
            // A source of few volts is no ideal one: the coil takes its time, and the click stops all the same.
            let few = Drive::Current { amperes, limit: 1.1 * parameters.rated_volts };
            let click = Click { turns: 0.25, drive: few, angle: 0.0, ending: Ending::Settled };
            let click = click.solve(&parameters).unwrap();
            let (peak, left) = clicked(&click.course, &parameters, 0.0);
            println!("{:.1} ms, left {:.1e}", 1e3 * click.course.duration(), left / peak);
            assert!(left.abs() < 1e-5 * peak, "{left} of {peak}: {:?}", click.seconds);
        }
    }
}

/// Where nobody knows how the mass hangs, the click is worked out without gravity.
#[test]
fn without_knowing_the_angle_a_click_misses_by_what_gravity_does() {
    for (name, motor) in ["coin10", "cyl6", "gamepadL"].iter().zip(motors()) {
        let blind = Parameters { gravity: 0.0, ..motor };
        for turns in [0.25, 1.0] {
            let click = Click {
                turns,
                drive: Drive::Voltage(motor.rated_volts),
                angle: 0.0,
                ending: Ending::Stopped,
            };
            let course = click.solve(&blind).unwrap().course;
            let left: Vec<f64> = (0..16)
                .map(|n| {
                    let (peak, left) = clicked(&course, &motor, TAU * f64::from(n) / 16.0);
                    left / peak
                })
                .collect();
            let most = left.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            println!("{name} {turns} turns: {most:.4} of the peak speed is left at most");
            // Gravity's torque for the time of the click, over the inertia, and no more.
            let bound = motor.weight() * course.duration() / motor.effective_inertia();
            let (peak, _) = clicked(&course, &blind, 0.0);
            assert!(most < bound / peak, "{most} {}", bound / peak);
        }
    }
}

#[test]
fn a_spin_is_at_its_speed_soon_and_stands_at_the_end() {
    for motor in motors() {
        let parameters = Parameters { gravity: 0.0, ..motor };
        let speed = 0.6 * parameters.rated_speed();
        let spin = Spin { speed, seconds: 0.3, volts: parameters.rated_volts, angle: 0.0 };
        let course = spin.solve(&parameters).unwrap();
        let mut motor = plant(&parameters, 0.0);
        let (mut n, mut worst, mut left) = (0, 0.0_f64, f64::NAN);
        let up = course.pieces()[0].0;
        // With overdrive: ω = ω_ss (1 − exp(−t/τ)) as far as the speed, and what the coil holds the current back by.
        let ratio = speed / parameters.rated_speed();
        let due = -parameters.mechanical_time() * (1.0 - ratio).ln();
        assert!(up > due && up < due + 3.0 * parameters.electrical_time() + 1e-9, "{up} {due}");
        let end = (course.duration() * RATE).ceil() as usize + 1;
        course.play(&mut motor, RATE, end, |motor| {
            n += 1;
            let t = f64::from(n) / RATE;
            if t > up + 10.0 * parameters.electrical_time() && t < 0.3 {
                worst = worst.max((motor.speed() / speed - 1.0).abs());
            }
            left = motor.speed().abs() / speed;
        });
        // What the coil still does for L/R when the voltage is taken back: to the one that holds the speed, and from the brake to none.
        let per_volt = parameters.gain * parameters.electrical_time()
            / (parameters.resistance * parameters.effective_inertia());
        let (full, back_emf) = (parameters.rated_volts, parameters.gain * speed);
        assert!(worst * speed < 1.05 * per_volt * full + 1e-6 * speed, "{worst}");
        assert!(left * speed < 1.05 * per_volt * (full + back_emf) + 1e-6 * speed, "{left}");
    }
}

/// A raised cosine of acceleration, as speeds at samples of a converter.
fn burst(inverse: &Inverse, peak: f64, seconds: f64) -> Vec<f64> {
    let samples = (seconds * inverse.rate).round();
    (0..=samples as usize)
        .map(|n| inverse.speed_of(0.5 * peak * (1.0 - (TAU * n as f64 / samples).cos())))
        .collect()
}

/// RMS of what the envelope of the casing's acceleration misses, as a share of its peak.
fn missed(volts: &[f64], plant_of: &Parameters, peak: f64, wished: &[f64]) -> f64 {
    let mut motor = plant(plant_of, 0.0);
    let per = plant_of.eccentric / plant_of.casing.mass().unwrap();
    let mut sum = 0.0;
    for (volts, wish) in volts.iter().zip(&wished[1..]) {
        motor.drive(Drive::Voltage(*volts));
        motor.step();
        let envelope = per * motor.speed() * motor.speed();
        sum += (envelope - per * wish * wish).powi(2);
    }
    (sum / volts.len() as f64).sqrt() / peak
}

#[test]
fn an_envelope_is_followed_where_a_static_map_misses_a_quarter() {
    let coin = motors()[0];
    let inverse = Inverse { parameters: coin, limit: coin.rated_volts, rate: RATE, angle: Some(0.0) };
    // The shorter ones flat on a table, where it is known what is possible.
    let flat = Parameters { gravity: 0.0, ..coin };
    for (seconds, coin) in [(0.15, coin), (0.08, flat), (0.04, flat)] {
        let inverse = Inverse { parameters: coin, ..inverse };
        let wished = burst(&inverse, 8.0, seconds);
        let shaped = inverse.shape(&wished).unwrap();
        let by = missed(&shaped.volts, &coin, 8.0, &wished);
        let fixed: Vec<f64> = wished[1..]
            .iter()
            .map(|w| {
                (coin.damping() * w + coin.coulomb * if *w > 0.0 { 1.0 } else { 0.0 }) * coin.resistance
                    / coin.gain
            })
            .map(|volts| volts.min(coin.rated_volts))
            .collect();
        let plain = missed(&fixed, &coin, 8.0, &wished);
        println!(
            "{seconds} s: inverse {:.4}, static map {plain:.3}; short by {:.0} rad/s, {} of {} samples at the limit",
            by,
            shaped.short,
            shaped.limited,
            shaped.volts.len()
        );
        // As fast as the motor can be from the beginning on: what lies above that no drive reaches.
        let per = coin.eccentric / coin.casing.mass().unwrap();
        let unreachable: f64 = (1..wished.len())
            .map(|n| {
                let most = coin.rated_speed() * -(-(n as f64) / RATE / coin.mechanical_time()).exp_m1();
                (per * (wished[n] * wished[n] - most * most)).max(0.0).powi(2)
            })
            .sum();
        let least = (unreachable / wished.len() as f64).sqrt() / 8.0;
        println!("  no drive can miss less than {least:.4}");
        assert!(
            by < 0.01 + 3.0 * least && by < 0.7 * plain && plain > 0.25,
            "{seconds}: {by} {least} {plain}"
        );
    }
    let wished = burst(&inverse, 8.0, 0.15);
    let shaped = inverse.shape(&wished).unwrap();
    let off = |change: &dyn Fn(&mut Parameters)| {
        let mut other = coin;
        change(&mut other);
        missed(&shaped.volts, &other, 8.0, &wished)
    };
    for (what, change) in [
        ("R", &(|p: &mut Parameters, by: f64| p.resistance *= by) as &dyn Fn(&mut Parameters, f64)),
        ("k", &|p, by| p.gain *= by),
        ("J", &|p, by| p.inertia *= by),
        ("friction", &|p, by| (p.coulomb, p.stiction) = (p.coulomb * by, p.stiction * by)),
    ] {
        let [low, high] = [0.9, 1.1].map(|by| off(&|p| change(p, by)));
        println!("{what} 10 % less: {low:.3}, more: {high:.3}");
        assert!(low.max(high) < 0.28, "{what}");
    }
}

/// How far apart angles (rad) lie at most, in degrees.
fn apart(angles: &[f64]) -> f64 {
    let off = |a: f64, b: f64| ((a - b + PI).rem_euclid(TAU) - PI).abs();
    let pairs = angles.iter().flat_map(|a| angles.iter().map(move |b| off(*a, *b)));
    pairs.fold(0.0, f64::max).to_degrees()
}

/// Four quarter turns, from each of 16 angles that nobody knows: how far apart the angles are at which each of them begins.
#[test]
fn parked_clicks_kick_the_same_way() {
    for (name, motor) in ["coin10", "cyl6", "gamepadL"].iter().zip(motors()) {
        let volts = motor.rated_volts;
        let home = Home { volts }.solve(&motor).unwrap();
        let quarter = |angle: f64| {
            Click { turns: 0.25, drive: Drive::Voltage(volts), angle, ending: Ending::Settled }
                .solve(&motor)
                .unwrap()
        };
        let click = quarter(home.angle);
        let back = Park { from: click.angle, to: home.angle, volts: 1.3 * motor.start_volts() };
        let back = back.solve(&motor).unwrap().unwrap();
        assert!((back.peak_speed / click.peak_speed).powi(2) < 0.5, "the way back is felt less");
        let ends = |course: &Course, from: f64| {
            let mut plant = plant(&motor, from);
            course.play(&mut plant, RATE, (course.duration() * RATE).ceil() as usize + 1, |_| {});
            plant.reading().angle
        };
        assert!(apart(&[ends(&back.course, click.angle), home.angle]) < 0.01, "it is back");
        let play = |plant: &mut Motor, course: &Course| {
            course.play(plant, RATE, (course.duration() * RATE).ceil() as usize + 4800, |_| {});
            assert!(plant.is_stuck(), "{name}");
        };
        let blind = quarter(0.0);
        let (mut parked, mut free) = (vec![Vec::new(); 4], vec![Vec::new(); 4]);
        for first in (0..16).map(|n| TAU * (f64::from(n) + 0.37) / 16.0) {
            let (mut one, mut other) = (plant(&motor, first), plant(&motor, first));
            for (parked, free) in parked.iter_mut().zip(&mut free) {
                play(&mut one, &home.course);
                parked.push(one.reading().angle);
                free.push(other.reading().angle);
                play(&mut one, &click.course);
                play(&mut other, &blind.course);
            }
        }
        let worst = |angles: &[Vec<f64>]| angles.iter().map(|a| apart(a)).fold(0.0, f64::max);
        println!(
            "{name}: home in {:.0} ms within {:.1} degrees; clicks begin within {:.1} degrees when parked, {:.0} when not",
            home.course.duration() * 1e3,
            home.spread.to_degrees(),
            worst(&parked),
            worst(&free)
        );
        // Within 60 degrees, more than half of each kick goes the way of any other.
        assert!(worst(&parked) < 60.0 && worst(&free) > 150.0, "{name}");
        assert!(home.angle.sin() > 0.0, "on the way up");
        assert_eq!(Park { from: 3.0, to: 3.0 - TAU, volts }.solve(&motor).unwrap(), None);
    }
}

#[test]
fn switching_reaches_its_wish_and_swings_by_what_one_sample_does() {
    for motor in motors() {
        let drive = Switching {
            parameters: motor,
            volts: motor.rated_volts,
            rate: RATE,
            pull: 0.0,
            band: 0.0,
            angle: 0.0,
        };
        let speed = 0.5 * motor.rated_speed();
        let wished: Vec<f64> = (0..24_000).map(|n| if n < 12_000 { speed } else { 0.4 * speed }).collect();
        let (volts, speeds) = drive.shape(&wished).unwrap();
        assert!(volts.iter().all(|v| v.abs() == motor.rated_volts));
        // (k V/R + T_c + B ω + m_e g r)/J a second, for the sample in which it is decided, and for as long as the coil takes to follow.
        let most = (motor.stall_torque(motor.rated_volts)
            + motor.coulomb
            + motor.damping() * speed
            + motor.weight())
            / motor.effective_inertia();
        let most = most * (1.0 / RATE + 2.0 * motor.electrical_time());
        for part in [9_000..12_000, 21_000..24_000] {
            let worst = part.clone().map(|n: usize| (speeds[n] - wished[n]).abs()).fold(0.0, f64::max);
            assert!(worst < most, "{worst} {most}");
        }
        // A wider band switches less often.
        let flips = |volts: &[f64]| volts.windows(2).filter(|v| v[0] != v[1]).count();
        let (calm, _) = Switching { band: 4.0 * most, ..drive }.shape(&wished).unwrap();
        assert!(flips(&calm) * 2 < flips(&volts));
        // With a pull the angle keeps up: after the first catch-up it does not lag any more.
        let (_, pulled) = Switching { pull: 50.0, ..drive }.shape(&wished).unwrap();
        let lag = |speeds: &[f64]| wished.iter().zip(speeds).map(|(w, s)| (w - s) / RATE).sum::<f64>().abs();
        assert!(lag(&pulled) < 0.1 * lag(&speeds), "{} {}", lag(&pulled), lag(&speeds));
    }
}

/// What each term of the inverse is for: without it, these are missed by many times as much.
#[test]
fn coil_and_gravity_are_part_of_the_inverse() {
    let [coin, _, pad] = motors()[..] else { unreachable!() };
    let by = |motor: &Parameters, angle: Option<f64>, peak: f64, seconds: f64| {
        let inverse = Inverse { parameters: *motor, limit: motor.rated_volts, rate: RATE, angle };
        let wished = burst(&inverse, peak, seconds);
        let shaped = inverse.shape(&wished).unwrap();
        assert_eq!(shaped.short, 0.0);
        missed(&shaped.volts, motor, peak, &wished)
    };
    // The coil of the large motor is late by 0.4 ms.
    assert!(by(&pad, Some(0.0), 20.0, 0.1) < 1e-3, "{}", by(&pad, Some(0.0), 20.0, 0.1));
    let (known, unknown) = (by(&coin, Some(0.0), 1.0, 0.15), by(&coin, None, 1.0, 0.15));
    println!("1 m/s2 on the coin motor: {known:.5} with gravity known, {unknown:.3} without");
    assert!(known < 1e-3 && unknown > 0.02, "{known} {unknown}");
}

/// What falls faster than the brake can bring it down is left earlier, and the rotor stands at the end.
#[test]
fn what_cannot_be_followed_is_braked_in_time() {
    for motor in motors() {
        let inverse = Inverse { parameters: motor, limit: motor.rated_volts, rate: RATE, angle: Some(0.0) };
        let speed = 0.8 * motor.rated_speed();
        // At the speed for a tenth of a second, and the wish to stop at once.
        let wished: Vec<f64> = (0..9600).map(|n| if n < 4800 { speed } else { 0.0 }).collect();
        let shaped = inverse.shape(&wished).unwrap();
        assert!(shaped.short > 0.9 * speed, "{}", shaped.short);
        assert!(shaped.speeds.iter().zip(&wished).all(|(s, w)| *s >= 0.0 && s <= w));
        assert!(shaped.volts.iter().any(|v| *v < -0.9 * motor.rated_volts), "it is braked");
        let mut plant = plant(&motor, 0.0);
        let (mut worst, mut late) = (0.0_f64, 0.0_f64);
        for (n, volts) in shaped.volts.iter().enumerate() {
            plant.drive(Drive::Voltage(*volts));
            plant.step();
            worst = worst.max((plant.speed() - shaped.speeds[n + 1]).abs());
            if n > 4850 {
                late = late.max(plant.speed().abs());
            }
        }
        println!("off the plan by {:.4}, behind the end {:.4}", worst / speed, late / speed);
        // The current takes L/R to turn from forward to backward, and the speed goes on as before meanwhile.
        let turning =
            2.0 * motor.stall_torque(motor.rated_volts) * motor.electrical_time() / motor.effective_inertia();
        assert!(
            worst < 1.5 * turning + 0.02 * speed && late < 0.01 * speed,
            "{worst} {turning} {late} {speed}"
        );
    }
}

#[test]
fn what_cannot_be_is_said() {
    let coin = motors()[0];
    let click = Click { turns: 0.25, drive: Drive::Voltage(3.0), angle: 0.0, ending: Ending::Stopped };
    let fails = |click: Click| click.solve(&coin).unwrap_err();
    assert!(matches!(fails(Click { drive: Drive::Voltage(0.5), ..click }), Unreachable::Start(..)));
    for bad in [
        Click { turns: 0.0, ..click },
        Click { turns: f64::NAN, ..click },
        Click { drive: Drive::Voltage(f64::INFINITY), ..click },
        Click { angle: f64::NAN, ..click },
    ] {
        assert!(matches!(fails(bad), Unreachable::Fault(_)), "{bad:?}");
    }
    assert!(matches!(
        fails(Click { turns: 1000.0, drive: Drive::Voltage(1.0), ..click }),
        Unreachable::Slow(..)
    ));
    let spin = Spin { speed: 2.0 * coin.rated_speed(), seconds: 1.0, volts: 3.0, angle: 0.0 };
    assert!(matches!(spin.solve(&coin), Err(Unreachable::Slow(..))));
    // With the plane of rotation level nothing catches the mass, friction or not.
    for coulomb in [0.0, coin.coulomb] {
        let flat = Parameters { gravity: 0.0, coulomb, ..coin };
        assert!(
            matches!(Home { volts: 3.0 }.solve(&flat), Err(Unreachable::Fault(fault)) if fault.field == "gravity")
        );
    }
    let inverse = Inverse { parameters: coin, limit: 3.0, rate: RATE, angle: None };
    let held = Inverse { parameters: Parameters { casing: Casing::Held, ..coin }, ..inverse };
    assert_eq!(held.speed_of(8.0), 0.0);
    assert!(Inverse { limit: 0.0, ..inverse }.shape(&[0.0]).is_err());
    assert!(inverse.shape(&[]).unwrap().volts.is_empty());
    let wild = inverse.shape(&[f64::NAN, 1e300, -1e300, 5000.0, -5000.0, f64::INFINITY]).unwrap();
    assert!(wild.volts.iter().all(|v| v.abs() <= 3.0) && wild.speeds.iter().all(|s| s.is_finite()));
}
