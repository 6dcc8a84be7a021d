//! Run time of rumble motors, as CPU time of this thread.
//!
//! `cargo bench --bench motor` prints a table of nanoseconds a step; every figure is the median of many windows. With `--step`, `--run` or
//! `--gravity` it only repeats one of them, to be profiled.

use std::hint::black_box;

use cpu_time::ThreadTime;
use pacinian::actuator::motor::{
    Casing, Drive, GRAVITY, Group, LANES, Level, Motor, Parameters, Plan, Suspension,
};

const RATE: f64 = 48_000.0;

/// A coin motor with ten times its inductance, which is the case to which others' figures are known: 0.1 ms.
const COIN: Parameters = Parameters {
    resistance: 30.0,
    inductance: 3e-3,
    gain: 0.955e-3,
    inertia: 1.8e-9,
    viscous: 2.15e-8,
    coulomb: 1.5e-5,
    stiction: 2e-5,
    eccentric: 7.3e-7,
    gravity: GRAVITY,
    casing: Casing::Free { mass: 0.1 },
    rated_volts: 3.0,
};

/// Median CPU nanoseconds that each of `count` things done in a call of `work` takes.
fn median(count: usize, mut work: impl FnMut()) -> f64 {
    let mut times: Vec<f64> = (0..61)
        .map(|_| {
            let begin = ThreadTime::now();
            work();
            begin.elapsed().as_nanos() as f64 / count as f64
        })
        .collect();
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn motor(parameters: &Parameters, level: Level) -> Motor {
    let mut motor = Motor::new(parameters, &Plan::whole(level), RATE).unwrap();
    motor.drive(Drive::Voltage(3.0));
    for _ in 0..4800 {
        motor.step();
    }
    motor
}

/// A motor that spins, its voltage another at every step.
fn spinning(parameters: &Parameters, level: Level) -> f64 {
    let mut motor = motor(parameters, level);
    let volts: Vec<f64> = (0..48_000).map(|n| 2.5 + 0.5 * f64::from(n % 7) / 7.0).collect();
    median(volts.len(), || {
        for v in &volts {
            motor.drive(Drive::Voltage(*v));
            motor.step();
        }
        black_box(&motor);
    })
}

/// The same by [`Motor::steps`].
fn kept(parameters: &Parameters, level: Level) -> f64 {
    let mut motor = motor(parameters, level);
    let volts: Vec<f64> = (0..48_000).map(|n| 2.5 + 0.5 * f64::from(n % 7) / 7.0).collect();
    median(volts.len(), || {
        let mut steps = motor.steps();
        for v in &volts {
            steps.step(*v);
        }
        drop(steps);
        black_box(&motor);
    })
}

/// The same by the way for many voltages.
fn running(parameters: &Parameters, level: Level) -> f64 {
    let mut motor = motor(parameters, level);
    let volts: Vec<f64> = (0..48_000).map(|n| 2.5 + 0.5 * f64::from(n % 7) / 7.0).collect();
    median(volts.len(), || {
        let mut last = 0.0;
        motor.run(&volts, |_, speed, _| last = speed);
        black_box(last);
    })
}

/// Eight motors at once, the voltage of each another at every step: each.
fn eight(parameters: &Parameters) -> f64 {
    let mut group = Group::new(&[Some(*parameters); LANES], true, RATE).unwrap();
    let volts: Vec<f64> = (0..48_000).map(|n| 2.5 + 0.5 * f64::from(n % 7) / 7.0).collect();
    median(LANES * volts.len(), || {
        for v in &volts {
            group.voltages(&[*v; LANES]);
            group.step();
        }
        black_box(&group);
    })
}

/// The one figure that the command line asks for, again and again.
fn only(name: &str) -> bool {
    let linear = Parameters { gravity: 0.0, coulomb: 0.0, stiction: 0.0, ..COIN };
    let work: &dyn Fn() -> f64 = match name {
        "--step" => &|| spinning(&linear, Level::Default),
        "--steps" => &|| kept(&linear, Level::Default),
        "--run" => &|| running(&linear, Level::Default),
        "--eight" => &|| eight(&linear),
        "--gravity-step" => &|| spinning(&COIN, Level::Default),
        "--gravity" => &|| running(&COIN, Level::Default),
        _ => return false,
    };
    for _ in 0..20 {
        println!("{:.2}", work());
    }
    true
}

fn main() {
    if std::env::args().any(|name| only(&name)) {
        return;
    }
    let linear = Parameters { gravity: 0.0, coulomb: 0.0, stiction: 0.0, ..COIN };
    let dry = Parameters { gravity: 0.0, ..COIN };
    println!("ns a step, 48 kHz, tau_e 100 us, voltage new at every step");
    println!("{:46} {:6.2}", "linear", spinning(&linear, Level::Default));
    println!("{:46} {:6.2}", "linear, steps that keep where it is", kept(&linear, Level::Default));
    println!("{:46} {:6.2}", "friction", spinning(&dry, Level::Default));
    println!("{:46} {:6.2}", "friction and gravity, default", spinning(&COIN, Level::Default));
    println!("{:46} {:6.2}", "friction and gravity, fine", spinning(&COIN, Level::Fine));
    println!("{:46} {:6.2}", "friction and gravity, economy", spinning(&COIN, Level::Economy));
    println!("{:46} {:6.2}", "run: linear", running(&linear, Level::Default));
    println!("{:46} {:6.2}", "run: friction", running(&dry, Level::Default));
    println!("{:46} {:6.2}", "run: friction and gravity, default", running(&COIN, Level::Default));
    println!("{:46} {:6.2}", "run: friction and gravity, economy", running(&COIN, Level::Economy));
    println!("{:46} {:6.2}", "run: linear, economy", running(&linear, Level::Economy));
    println!("{:46} {:6.2}", "run: friction and gravity, fine", running(&COIN, Level::Fine));
    println!("{:46} {:6.2}", "eight at once, each: linear", eight(&linear));
    println!("{:46} {:6.2}", "eight at once, each: friction", eight(&dry));
    let by = Suspension { stiffness: 1279.0, damping: 3.39 };
    let hung = Parameters { casing: Casing::Suspended { mass: 0.1, across: by, upright: by }, ..COIN };
    println!(
        "{:46} {:6.2}",
        "friction, gravity, casing on springs, default",
        spinning(&hung, Level::Default)
    );
    println!("{:46} {:6.2}", "at rest, voltage too low", {
        let mut motor = Motor::<false>::new(&COIN, &Plan::whole(Level::Default), RATE).unwrap();
        median(48_000, || {
            for n in 0..48_000 {
                motor.drive(Drive::Voltage(0.1 * f64::from(n % 7)));
                motor.step();
            }
            black_box(&motor);
        })
    });
    println!("{:46} {:6.2}", "default, and the acceleration of its casing", {
        let mut motor = motor(&COIN, Level::Default);
        median(48_000, || {
            let mut sum = 0.0;
            for _ in 0..48_000 {
                motor.step();
                let [x, y] = motor.acceleration();
                sum += x + y;
            }
            black_box(sum);
        })
    });
    reversals();
    crowded();
}

/// A step that begins with some speed and ends with the other, at two levels.
fn reversals() {
    for (name, parameters, level) in [
        ("a step with a reversal, no gravity", Parameters { gravity: 0.0, ..COIN }, Level::Default),
        ("a step with a reversal, default", COIN, Level::Default),
        ("a step with a reversal, fine", COIN, Level::Fine),
    ] {
        let mut start = Motor::<false>::new(&parameters, &Plan::whole(level), RATE).unwrap();
        start.drive(Drive::Voltage(-3.0));
        start.place(-2.0, 40.0);
        let mut next = start.clone();
        while next.speed() > 0.0 {
            start = next.clone();
            next.step();
        }
        assert!(start.speed() > 0.0 && next.speed() < 0.0);
        one_step(name, &start);
    }
}

/// What the next step of a motor takes; putting it there is taken off.
fn one_step(name: &str, start: &Motor) {
    let mut motors = vec![start.clone(); 1000];
    let ns = median(motors.len(), || {
        motors.fill(start.clone());
        for motor in &mut motors {
            motor.step();
        }
        black_box(&motors);
    });
    let copies = median(motors.len(), || {
        motors.fill(start.clone());
        black_box(&motors);
    });
    println!("{name:46} {:6.0}", ns - copies);
}

/// A rotor so light that it swings through rest again and again within a step.
fn crowded() {
    let light = Parameters {
        inertia: 1e-16,
        inductance: 3e-3,
        viscous: 0.0,
        coulomb: 1e-9,
        stiction: 1e-9,
        eccentric: 0.0,
        ..COIN
    };
    for level in [Level::Default, Level::Fine] {
        let mut start = Motor::<false>::new(&light, &Plan::whole(level), RATE).unwrap();
        start.place(0.0, 300.0);
        let mut next = start.clone();
        next.step();
        let name = format!("a step with {} events, crowded {}", next.counts().events, next.counts().crowded);
        one_step(&name, &start);
    }
}
