//! The rumble motor at every rate and time constant.

use crate::common::COIN;
use crate::motor_extremes::{LEVELS, is_finite, new, of_times};
use pacinian::actuator::motor::{Drive, GRAVITY, Level, Parameters};

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
                // To the last digits, with gravity as well: what interpolating it is off by is less than what friction takes.
                let digits = 1e-12 * (before + p.weight());
                assert!(motor.stored() <= before + digits, "{place}: {before}");
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

/// With nothing that takes any of it, what a motor with open terminals has stays what it has, but for what interpolating gravity is off by: as a share of the mass's
/// weight, with the square of how far it turns in a step, at the fine level with the fourth power; and that does not add up from turn to turn.
#[test]
fn without_friction_what_is_stored_stays() {
    for level in LEVELS {
        for speed in [200.0, 1000.0, 1500.0] {
            let mut last: Option<(f64, f64)> = None;
            for rate in [1e3, 2e3, 4e3, 8e3, 16e3, 48e3] {
                let p = of_times(10e-6, 35e-3, GRAVITY);
                let p = Parameters { viscous: 0.0, coulomb: 0.0, stiction: 0.0, ..p };
                let mut motor = new(&p, level, rate);
                motor.place(0.0, speed);
                motor.drive(Drive::Open);
                let (begin, step) = (motor.stored(), speed / rate);
                let off = |_| {
                    motor.step();
                    ((motor.stored() - begin) / p.weight()).abs()
                };
                // Forty turns.
                let most = (0..(40.0 * std::f64::consts::TAU / step) as usize).map(off).fold(0.0, f64::max);
                // What the midpoint, and what Simpson's rule makes of a sine: Δ²/12 and Δ⁴/1440 of its amplitude, from one end of a turn to the middle.
                let (order, due) = match level {
                    Level::Fine => (4.0, step.powi(4) / 1440.0),
                    _ => (2.0, step.powi(2) / 12.0),
                };
                let place = format!("{level:?} {speed} rad/s {rate}: {most:e} {due:e}");
                if speed >= 1000.0 {
                    assert!(most < 2.6 * due && (rate < 48e3 || (most / due - 1.0).abs() < 0.03), "{place}");
                }
                if let Some((before, off)) = last.filter(|_| most > 1e-12) {
                    let is = f64::ln(off / most) / f64::ln(before / step);
                    assert!((order - 0.02..order + 1.0).contains(&is), "{place}: {is}");
                }
                last = Some((step, most));
            }
        }
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
