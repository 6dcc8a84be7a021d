//! Effects that are sampled, on a knob, against a reference.

use super::super::events::Events;
use super::super::program::{Any, Program};
use super::super::{Reading, detent, wall};
use crate::knob::test_plant::{Delay, Plant, count, floor};

/// A knob that starts at an angle with a speed, under one effect, its torque late by whole ticks: where it ends.
fn ends(
    effect: Any,
    friction: f64,
    rate: f64,
    delay: usize,
    counts: f64,
    start: (f64, f64),
    time: f64,
) -> (f64, f64) {
    let delta = if counts == 0.0 { 0.0 } else { count(counts) };
    let mut program = Program::new(vec![effect]).unwrap();
    let mut events = Events::default();
    let mut plant = Plant::new(6e-6, 2e-5, friction, 1.0 / rate);
    (plant.angle, plant.speed) = start;
    let mut line = Delay::new(delay);
    let mut torque = |angle: f64| {
        let reading = Reading { angle: floor(angle, delta), velocity: 0.0, dt: 1.0 / rate };
        program.tick(&reading, 1.0, 1.0, &mut events)
    };
    for _ in 0..delay {
        line.pass(torque(start.0));
    }
    for _ in 0..(time * rate).round() as usize {
        plant.step(line.pass(torque(plant.angle)));
    }
    (plant.angle, plant.speed)
}

/// Last rows of the reference trajectories `knob_k3s_*` and `knob_k4s_*`, computed there with 50 digits.
#[test]
fn sampled_walls_and_detents_end_where_the_reference_does() {
    let wall = |stiffness| Any::from(wall::Wall { angle: 0.0, below: false, stiffness, damping: 0.0 });
    for (k, rate, delay, counts, angle, speed) in [
        (0.4, 1e3, 0, 0.0, -0.573_346_139_519_930_8, -21.789_600_254_357_265),
        (4.0, 1e4, 1, 4000.0, -0.756_339_958_838_282_3, -21.314_671_355_437_185),
        (40.0, 48e3, 1, 4000.0, -0.766_562_576_898_260_4, -19.936_692_437_868_29),
        (40.0, 1e3, 1, 0.0, -11.449_772_635_367_695, -316.264_657_184_283_7),
    ] {
        let end = ends(wall(k), 0.0, rate, delay, counts, (-0.0503, 20.0), 0.04);
        assert!(
            (end.0 / angle - 1.0).abs() < 1e-10 && (end.1 / speed - 1.0).abs() < 1e-10,
            "{k} {rate}: {end:?}"
        );
    }
    let detents = detent::Detent { amplitude: 8e-3, ..detent::Detent::with_stiffness(24.0, 1.0) };
    for (rate, angle, speed) in [
        (1e3, 3.421_582_545_292_086, 19.364_548_273_652_58),
        (1e4, -0.039_248_413_237_318_25, 2.595_467_229_134_871),
    ] {
        let end = ends(detents.clone().into(), 1e-4, rate, 1, 4000.0, (0.02, 9.0), 0.3);
        assert!((end.0 - angle).abs() < 1e-10 && (end.1 / speed - 1.0).abs() < 1e-9, "{rate}: {end:?}");
    }
}
