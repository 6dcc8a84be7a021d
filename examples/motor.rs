//! A rumble motor of a game pad under four drives: what each does, and how long it takes to be felt and to be over.
//!
//! `cargo run --release --example motor`

use std::error::Error;

use pacinian::actuator::motor::{Casing, Drive, Level, Motor, Parameters, Plan};
use pacinian::actuator::shape::{Click, Course, Ending, Spin};

const RATE: f64 = 48_000.0;

fn main() -> Result<(), Box<dyn Error>> {
    // In a casing of 250 g that is held by nobody and lies flat, so that gravity has no say.
    let motor = Parameters {
        resistance: 10.42,
        inductance: 4.2e-3,
        gain: 0.011,
        inertia: 1.15e-7,
        viscous: 1.0e-6,
        coulomb: 6e-4,
        stiction: 8e-4,
        eccentric: 1.38e-5,
        gravity: 0.0,
        casing: Casing::Free { mass: 0.25 },
        rated_volts: 12.5,
    };
    println!(
        "{:.0} rad/s at {} V; time constants: {:.2} ms of the rotor, {:.2} ms of the coil",
        motor.rated_speed(),
        motor.rated_volts,
        1e3 * motor.mechanical_time(),
        1e3 * motor.electrical_time()
    );
    println!("drive                        peak m/s2    at ms  still at ms");
    let click =
        Click { turns: 0.25, drive: Drive::Voltage(motor.rated_volts), angle: 0.0, ending: Ending::Settled }
            .solve(&motor)?;
    let [forward, backward, again] = click.seconds.map(|seconds| 1e3 * seconds);
    let spin = Spin { speed: 0.5 * motor.rated_speed(), seconds: 0.05, volts: motor.rated_volts, angle: 0.0 };
    for (name, course) in [
        ("on and off, as long", Course::on(motor.rated_volts, click.course.duration())),
        ("a click of a quarter turn", click.course.clone()),
        ("half the volts for 50 ms", Course::on(0.5 * motor.rated_volts, 0.05)),
        ("half the speed for 50 ms", spin.solve(&motor)?),
    ] {
        let (peak, at, still) = felt(&motor, &course)?;
        println!("{name:<28} {peak:>9.1} {:>8.1} {:>12.1}", 1e3 * at, 1e3 * still);
    }
    println!(
        "the click: {forward:.2} ms forward, {backward:.2} ms backward, {again:.2} ms forward for the coil"
    );
    Ok(())
}

/// The largest acceleration of the casing (m/s²), when it is there, and when the rotor stands (s).
fn felt(parameters: &Parameters, course: &Course) -> Result<(f64, f64, f64), Box<dyn Error>> {
    let mut motor: Motor = Motor::new(parameters, &Plan::whole(Level::Default), RATE)?;
    let (mut n, mut peak, mut still) = (0_u32, (0.0, 0.0), 0.0);
    course.play(&mut motor, RATE, 24_000, |motor| {
        n += 1;
        let (time, [x, y]) = (f64::from(n) / RATE, motor.reading().acceleration);
        if x.hypot(y) > peak.0 {
            peak = (x.hypot(y), time);
        }
        if !motor.is_stuck() {
            still = time;
        }
    });
    Ok((peak.0, peak.1, still))
}
