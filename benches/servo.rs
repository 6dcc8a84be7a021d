//! A knob's servo: what a tick costs, by effect, estimator and all together, as CPU time of this thread.
//!
//! `cargo bench --bench servo` prints nanoseconds a tick, and how long it takes to work out what a device bears.

use std::hint::black_box;

use cpu_time::ThreadTime;
use pacinian::knob::effect::events::Events;
use pacinian::knob::effect::program::{Any, Program};
use pacinian::knob::effect::{Reading, damper, detent, friction, inertia, texture, wall};
use pacinian::knob::governor::device::{Delay, Device};
use pacinian::knob::governor::{Governor, MARGIN};
use pacinian::knob::safety::chain::{Chain, Input, Limits};
use pacinian::knob::servo::setup::Setup;
use pacinian::knob::servo::tick::Servo;
use pacinian::knob::velocity::Estimator;
use pacinian::knob::velocity::choice::Choice;
use pacinian::knob::velocity::{adaptive, difference, edges, filtered, kalman};

/// The least of many runs.
fn least<F: FnMut(usize)>(name: &str, mut tick: F) {
    const TICKS: usize = 20_000;
    let mut best = f64::INFINITY;
    for _ in 0..200 {
        let start = ThreadTime::now();
        (0..TICKS).for_each(&mut tick);
        best = best.min(start.elapsed().as_nanos() as f64 / TICKS as f64);
    }
    println!("{name:40} {best:7.2} ns");
}

fn main() {
    let t = 1e-4;
    let six: Vec<Any> = vec![
        wall::Stops { low: -1.0, high: 1.0, stiffness: 1.0, damping: 1e-3 }.into(),
        detent::Detent::with_stiffness(24.0, 0.1).into(),
        damper::Damper { damping: 1e-4 }.into(),
        friction::Friction { torque: 2e-3, stretch: 0.01, law: friction::Law::Adhesion }.into(),
        inertia::Inertia { inertia: 1e-4, stiffness: 1.0, damping: 1e-3 }.into(),
        texture::Ripple { amplitude: 0.01, wavelength: 0.1 }.into(),
    ];
    let mut program = Program::new(six.clone()).unwrap_or_else(|e| panic!("{e:?}"));
    let mut events = Events::default();
    let count = std::f64::consts::TAU / 4000.0;
    let angles: Vec<f64> = (0..20_000)
        .map(|k| 1.5 * (f64::from(k) / 10_000.0 - 1.0).abs() - 0.4)
        .map(|angle| count * (angle / count).floor())
        .collect();
    for effect in six.clone() {
        let name = format!("{effect:?}").split('(').next().unwrap_or("").to_string();
        let mut alone = Program::new(vec![effect]).unwrap_or_else(|e| panic!("{e:?}"));
        least(&name, |k| {
            let reading = Reading { angle: angles[k], velocity: 3.0, dt: t };
            black_box(alone.tick(black_box(&reading), 1.0, 1.0, &mut events));
        });
    }
    least("six effects", |k| {
        let reading = Reading { angle: angles[k], velocity: 3.0, dt: t };
        black_box(program.tick(black_box(&reading), 1.0, 1.0, &mut events));
    });
    let device = Device {
        inertia: 6e-6,
        damping: 2e-4,
        friction: None,
        count,
        period: t,
        delay: Delay::ticks(1.0),
        resonance: None,
        low_pass: None,
        velocity: Choice::Adaptive(0.01),
        peak: 0.175,
    };
    let governor = Governor::new(&device, MARGIN).unwrap();
    let slow = Device {
        period: 1.0 / 48e3,
        delay: Delay { fixed: 0.0, block: 512, frames: 1.0, blocks: 2.0, local: None },
        ..device.clone()
    };
    let start = ThreadTime::now();
    let two_blocks = Governor::new(&slow, MARGIN).unwrap();
    println!("governor for 2 blocks of 512: {:.1?}", start.elapsed());
    let start = ThreadTime::now();
    println!("{} ({:.1?})", two_blocks.explain(0.0).unwrap(), start.elapsed());
    let limits = Limits {
        period: t,
        slew: 100.0,
        low_pass: Some(2000.0),
        continuous: 0.023,
        winding: 12.0,
        peak: 0.175,
        soft_start: 0.1,
        stale: 3,
        release: 0.02,
        over_speed: 60.0,
    };
    let mut chain = Chain::new(&limits).unwrap();
    chain.arm();
    least("safety chain", |k| {
        let (torque, angle) = (0.01 * angles[k], angles[k]);
        let input = Input { torque, angle, velocity: 3.0, fresh: true, in_time: true, governed: false };
        black_box(chain.tick(black_box(&input)));
    });
    let mut speed = kalman::Kalman::new(50.0, count, t).unwrap();
    least("servo: speed, governor, six, chain", |k| {
        let angle = black_box(angles[k]);
        let velocity = speed.push(angle);
        let allowed = governor.allow(&program.demand());
        let reading = Reading { angle, velocity, dt: t };
        let torque = program.tick(&reading, allowed.stiffness, allowed.damping, &mut events);
        let governed = allowed.acted();
        let input = Input { torque, angle, velocity, fresh: true, in_time: true, governed };
        black_box(chain.tick(&input));
    });
    let scales = [[1.0, 0.0, 0.5]; 6];
    for (name, velocity) in [("Kalman", Choice::Kalman(50.0)), ("window of 10 ms", Choice::Adaptive(0.01))] {
        let setup = Setup::new(six.clone(), Device { velocity, ..device.clone() }, limits);
        let mut servo = Servo::new(&setup).unwrap_or_else(|e| panic!("{e}"));
        servo.arm();
        least(&format!("a servo's whole tick, {name}"), |k| {
            black_box(servo.tick(Some(black_box(angles[k])), true));
        });
        least("  with all that scales its effects set", |k| {
            // From memory, as what nodes send is.
            for (control, [gain, shift, fed]) in servo.controls().zip(black_box(&scales)) {
                (control.gain, control.shift, control.fed) = (*gain, *shift, *fed);
            }
            black_box(servo.tick(Some(black_box(angles[k])), true));
        });
        assert!(servo.chain().armed(), "{:?}", servo.chain().trip());
    }
    let mut all: Vec<(&str, Box<dyn Estimator>)> = vec![
        ("difference", Box::new(difference::Difference::new(t).unwrap())),
        ("filtered", Box::new(filtered::Filtered::new(100.0, t).unwrap())),
        ("kalman", Box::new(kalman::Kalman::new(50.0, count, t).unwrap())),
        ("edges", Box::new(edges::Edges::new(count, 0.1, t).unwrap())),
        ("adaptive end 16", Box::new(adaptive::Adaptive::new(adaptive::Fit::End, 16, count, t).unwrap())),
        ("adaptive best 16", Box::new(adaptive::Adaptive::new(adaptive::Fit::Best, 16, count, t).unwrap())),
        ("adaptive end 256", Box::new(adaptive::Adaptive::new(adaptive::Fit::End, 256, count, t).unwrap())),
    ];
    for (name, e) in &mut all {
        least(name, |k| {
            black_box(e.push(black_box(angles[k])));
        });
    }
}
