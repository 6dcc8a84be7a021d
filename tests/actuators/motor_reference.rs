//! The rumble motor against trajectories of 19 digits (80-bit Taylor series, checked by others; see the README of the reference).
//!
//! | cases | rate | speed / rated | angle, rad | current; force x, y; X, each / its maximum |
//! |---|---|---|---|---|
//! | no gravity: a, b, c, d, e, j, both levels | 8 to 192 kHz | 1e-11 asked; 7e-15 | 1e-8 asked; 9e-13 | 6e-15; 8e-13 |
//! | gravity: f, g, h, default | 48 kHz | 3e-7 asked; 6e-8 | 1e-5 asked; 2e-7 | 3e-8; 2e-7 |
//! | the same, fine | 48 kHz | 1e-9 asked; 2e-12 | 3e-8 asked; 7e-11 | 8e-13; 3e-11 |
//! | a pendulum: i (none asked), default | 48 kHz | 6e-9 | 2e-7 | 0; 2e-7 |
//! | the same, fine | 48 kHz | 3e-16 | 1e-14 | 0; 1e-14 |
//! | casing on springs: k (none asked), default | 48 kHz | 7e-8 | 1e-7 | 5e-8; 2e-7; 5e-8 |
//! | the same, fine | 48 kHz | 1e-12 | 7e-11 | 2e-12; 3e-11; 2e-10, the casing's cubic |
//!
//! With gravity errors fall with the step to the power 2 at the default level and 3 (reversals under gravity) to 4 at the fine one. What
//! is asked is what the README suggests; here it is held to about twice of what is reached.

use crate::common::{Case, cases, run};
use pacinian::actuator::motor::{Level, Plan};

/// The largest error of each column: of the speed as a share of the rated speed, of the others as one of the column's maximum; and of the
/// angle in rad.
fn errors(case: &Case, rows: &[(usize, [f64; 6])]) -> ([f64; 6], f64) {
    let mut most = [0.0_f64; 6];
    for (row, got) in rows {
        for n in 0..6 {
            most[n] = most[n].max((got[n] - case.rows[*row][n]).abs());
        }
    }
    let angle = most[2];
    for n in 0..6 {
        let largest = case.rows.iter().map(|row| row[n].abs()).fold(0.0, f64::max);
        let scale = if n == 1 { case.parameters.rated_speed() } else { largest };
        most[n] = if scale > 0.0 { most[n] / scale } else { most[n] };
    }
    (most, angle)
}

/// The largest error a case may have at a rate: of the speed, of the other columns but the angle, and of the angle in rad.
fn check(case: &Case, level: Level, rate: f64, [speed, columns, angle]: [f64; 3]) {
    let (_, rows) = run::<false>(case, &Plan::whole(level), rate);
    assert!(rows.len() * 6 >= case.rows.len(), "{}: rows left out", case.name);
    let (error, radians) = errors(case, &rows);
    assert!(error[1] <= speed, "{} {level:?} {rate}: speed: {error:?}", case.name);
    for n in [0, 3, 4, 5] {
        assert!(error[n] <= columns, "{} {level:?} {rate}: column {n}: {error:?}", case.name);
    }
    assert!(radians <= angle, "{} {level:?} {rate}: angle {radians}", case.name);
}

#[test]
fn without_gravity_it_is_exact_at_every_rate() {
    let cases = cases();
    assert_eq!(cases.len(), 42);
    let mut seen = 0;
    for case in cases.iter().filter(|case| case.parameters.gravity == 0.0) {
        for rate in [8000.0, 16_000.0, 48_000.0, 192_000.0] {
            for level in [Level::Default, Level::Fine] {
                check(case, level, rate, [2e-14, 2e-12, 2e-12]);
            }
        }
        seen += 1;
    }
    assert_eq!(seen, 24);
}

#[test]
fn with_gravity_it_keeps_the_tolerances_at_48_khz() {
    for case in cases().iter().filter(|case| case.parameters.gravity > 0.0) {
        check(case, Level::Default, 48_000.0, [1.5e-7, 4e-7, 4e-7]);
        check(case, Level::Fine, 48_000.0, [4e-12, 4e-10, 2e-10]);
    }
}

/// Where the steps of a rate do not fall on the switches and rows of the trajectory, the end is compared, reached by a part of a step.
#[test]
fn at_44100_hz_drives_switch_within_steps() {
    for case in cases().iter().filter(|case| !case.name.contains("fine48k")) {
        let rate = 44_100.0;
        let plan = Plan::whole(Level::Fine);
        let mut motor =
            pacinian::actuator::motor::Motor::<false>::new(&case.parameters, &plan, rate).unwrap();
        motor.drive(case.segments[0].1);
        motor.place(case.angle, 0.0);
        let end = (case.rows.len() - 1) as f64 * case.every * rate;
        let mut switches: Vec<_> = case
            .segments
            .iter()
            .zip(&case.segments[1..])
            .map(|((at, _), (_, next))| (at * rate, *next))
            .collect();
        let mut step = 0.0;
        while step + 1.0 <= end {
            let here: Vec<_> = switches
                .iter()
                .filter(|(at, _)| *at < step + 1.0)
                .map(|(at, drive)| (at - step, *drive))
                .collect();
            switches.retain(|(at, _)| *at >= step + 1.0);
            motor.step_with(&here);
            step += 1.0;
        }
        for (at, drive) in switches {
            motor.part(at - step);
            motor.drive(drive);
            step = at;
        }
        motor.part(end - step);
        let (r, last) = (motor.reading(), case.rows.last().unwrap());
        let angle = r.angle + std::f64::consts::TAU * r.turns;
        let speed = (r.speed - last[1]).abs() / case.parameters.rated_speed();
        let most = if case.parameters.gravity == 0.0 { 2e-12 } else { 2e-10 };
        assert!(speed < most && (angle - last[2]).abs() < most, "{}: {r:?} {last:?}", case.name);
    }
}

/// Errors of speed and angle fall with the square of the step at the default level and with its third power or more at the fine one: the
/// fourth where all is smooth, less where a current that changes its course within a step bends the torque more than a parabola can.
#[test]
fn errors_fall_with_the_step_as_the_levels_say() {
    for case in cases().iter().filter(|case| case.parameters.gravity > 0.0) {
        let error = |level, rate| {
            let (error, radians) = errors(case, &run::<false>(case, &Plan::whole(level), rate).1);
            [error[1], radians]
        };
        let order = |a: f64, b: f64, ratio: f64| (a / b).ln() / f64::ln(ratio);
        let (slow, quick) = (error(Level::Default, 8000.0), error(Level::Default, 192_000.0));
        for n in 0..2 {
            let order = order(slow[n], quick[n], 24.0);
            assert!((1.75..2.6).contains(&order), "{} default: order {order}", case.name);
        }
        // Where the coil settles within a step, a corner of about (m_e g r / J) α τ_e² h is left of each switch, below 2e-12.
        let (slow, quick) = (error(Level::Fine, 8000.0), error(Level::Fine, 192_000.0));
        for n in 0..2 {
            let order = order(slow[n], quick[n], 24.0);
            assert!(order > 2.9 || quick[n] < 2e-12, "{} fine: order {order}", case.name);
        }
    }
}
