//! Drive shaping on the motors it is for: clicks that stop, and spins.

use std::f64::consts::TAU;

use pacinian::actuator::motor::{Casing, Drive, Level, Motor, Parameters, Plan};
use pacinian::actuator::shape::{Click, Clicked, Course, Ending, Home, Inverse, Spin, Unreachable};

pub const RATE: f64 = 48_000.0;

/// The three motors of the reference, in the hands of nobody, upright.
pub fn motors() -> Vec<Parameters> {
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

pub fn plant(parameters: &Parameters, angle: f64) -> Motor {
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
