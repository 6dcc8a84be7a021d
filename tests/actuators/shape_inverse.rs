//! Inverse dynamics on the motors they are for: envelopes that are followed.

use std::f64::consts::TAU;

use crate::shape::{RATE, motors, plant};
use pacinian::actuator::motor::{Drive, Parameters};
use pacinian::actuator::shape::Inverse;

/// A raised cosine of acceleration, as speeds at samples of a converter.
fn burst(inverse: &Inverse, peak: f64, seconds: f64) -> Vec<f64> {
    let samples = (seconds * inverse.rate).round();
    (0..=samples as usize)
        .map(|n| inverse.speed_of(0.5 * peak * (1.0 - (TAU * n as f64 / samples).cos())))
        .collect()
}

/// The envelope of the casing's acceleration under volts, at the end of each sample.
fn envelope(volts: &[f64], plant_of: &Parameters) -> Vec<f64> {
    let mut motor = plant(plant_of, 0.0);
    let per = plant_of.eccentric / plant_of.casing.mass().unwrap();
    let step = |volts: &f64| {
        motor.drive(Drive::Voltage(*volts));
        motor.step();
        per * motor.speed() * motor.speed()
    };
    volts.iter().map(step).collect()
}

/// Root mean square of what two envelopes differ by, as a share of the peak.
fn apart(one: &[f64], other: &[f64], peak: f64) -> f64 {
    let sum: f64 = one.iter().zip(other).map(|(a, b)| (a - b) * (a - b)).sum();
    (sum / one.len() as f64).sqrt() / peak
}

/// RMS of what the envelope of the casing's acceleration misses, as a share of its peak.
fn missed(volts: &[f64], plant_of: &Parameters, peak: f64, wished: &[f64]) -> f64 {
    let per = plant_of.eccentric / plant_of.casing.mass().unwrap();
    let wished: Vec<f64> = wished[1..].iter().map(|wish| per * wish * wish).collect();
    apart(&envelope(volts, plant_of), &wished, peak)
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
        // What a motor can do, as 150 ms of it, is followed; what it cannot is missed by little more than any drive must miss.
        assert_eq!(least == 0.0, seconds == 0.15, "{seconds}: {least}");
        assert!(
            by < 1e-3 + 1.4 * least && by < 0.7 * plain && plain > 0.28,
            "{seconds}: {by} {least} {plain}"
        );
    }
}

/// With a figure 10 % off the other way or the one, nothing open loop does better by much: a drive that has a motor with the one follow has a motor with the
/// other miss as much as they differ, and whatever drive it is, by the triangle inequality one of them misses half of what they differ by under it.
#[test]
fn figures_that_are_off_are_missed_by_what_no_drive_can_know() {
    let coin = motors()[0];
    let of = |parameters: Parameters| Inverse {
        parameters,
        limit: coin.rated_volts,
        rate: RATE,
        angle: Some(0.0),
    };
    let wished = burst(&of(coin), 8.0, 0.15);
    let believing = |parameters: Parameters| of(parameters).shape(&wished).unwrap().volts;
    for (what, change, reached) in [
        ("R", &(|p: &mut Parameters, by: f64| p.resistance *= by) as &dyn Fn(&mut Parameters, f64), 0.12),
        ("k", &|p, by| p.gain *= by, 0.07),
        ("J", &|p, by| p.inertia *= by, 0.05),
        ("friction", &|p, by| (p.coulomb, p.stiction) = (p.coulomb * by, p.stiction * by), 0.035),
    ] {
        let with = |by: f64| {
            let mut other = coin;
            change(&mut other, by);
            other
        };
        let ends = [with(0.9), with(1.1)];
        let miss = |volts: &[f64]| ends.map(|motor| missed(volts, &motor, 8.0, &wished));
        let [low, high] = miss(&believing(coin));
        // What is believed may be anything in between, and what has the one follow has the other miss.
        let (mut best, mut bound) = (f64::INFINITY, f64::INFINITY);
        for by in (0..=20).map(|n| 0.9 + 0.01 * f64::from(n)) {
            let volts = believing(with(by));
            let [one, other] = miss(&volts);
            let half = 0.5 * apart(&envelope(&volts, &ends[0]), &envelope(&volts, &ends[1]), 8.0);
            assert!(one.max(other) >= half - 1e-12, "{what} {by}");
            (best, bound) = (best.min(one.max(other)), bound.min(half));
        }
        println!(
            "{what} 10 % less: {low:.3}, more: {high:.3}; the best that can be believed {best:.3}, no drive of these less than {bound:.3}"
        );
        assert!(low.max(high) < reached, "{what}: {low} {high}");
        assert!(low.max(high) < 1.4 * best && best > 0.01 && bound > 0.01, "{what}: {best} {bound}");
        for (follows, other) in [(0, 1), (1, 0)] {
            let by = miss(&believing(ends[follows]));
            assert!(by[follows] < 1e-3 && by[other] > 2.0 * bound * 0.8, "{what}: {by:?} {bound}");
        }
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
