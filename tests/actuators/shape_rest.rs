//! Masses that are parked between clicks, and drives that switch.

use std::f64::consts::{PI, TAU};

use crate::shape::{RATE, motors, plant};
use pacinian::actuator::motor::{Drive, Motor};
use pacinian::actuator::shape::{Click, Clicked, Course, Ending, Home, Switching};

/// How far apart angles (rad) lie at most, in degrees.
fn apart(angles: &[f64]) -> f64 {
    let off = |a: f64, b: f64| ((a - b + PI).rem_euclid(TAU) - PI).abs();
    let pairs = angles.iter().flat_map(|a| angles.iter().map(move |b| off(*a, *b)));
    pairs.fold(0.0, f64::max).to_degrees()
}

/// Four quarter turns, from each of 16 angles that nobody knows, home before each and not: how far apart the angles are at which each of them begins.
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
        let play = |plant: &mut Motor, course: &Course| {
            course.play(plant, RATE, (course.duration() * RATE).ceil() as usize + 4800, |_| {});
            assert!(plant.is_stuck(), "{name}");
        };
        let blind = quarter(0.0);
        let (mut parked, mut free) = (vec![Vec::new(); 4], vec![Vec::new(); 4]);
        // What is left of the peak speed when the drive ends, of the first click of each.
        let left = |from: f64, click: &Clicked| {
            let mut plant = plant(&motor, from);
            let mut most = 0.0_f64;
            click.course.play(&mut plant, RATE, (click.course.duration() * RATE).ceil() as usize, |plant| {
                most = most.max(plant.reading().speed.abs());
            });
            plant.reading().speed.abs() / most
        };
        let (mut left_parked, mut left_free) = (0.0_f64, 0.0_f64);
        for first in (0..16).map(|n| TAU * (f64::from(n) + 0.37) / 16.0) {
            let (mut one, mut other) = (plant(&motor, first), plant(&motor, first));
            let mut at_home = plant(&motor, first);
            play(&mut at_home, &home.course);
            left_parked = left_parked.max(left(at_home.reading().angle, &click));
            left_free = left_free.max(left(first, &blind));
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
            "{name}: home in {:.0} ms within {:.1} degrees; clicks begin within {:.1} degrees when parked, {:.0} when not; of their peak speed \
             up to {:.2} % is left when parked, {:.2} % when not",
            home.course.duration() * 1e3,
            home.spread.to_degrees(),
            worst(&parked),
            worst(&free),
            100.0 * left_parked,
            100.0 * left_free
        );
        assert!(left_parked < left_free, "{name}: {left_parked} {left_free}");
        // Within 60 degrees, more than half of each kick goes the way of any other.
        assert!(worst(&parked) < 60.0 && worst(&free) > 150.0, "{name}");
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
