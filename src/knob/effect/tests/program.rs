//! Effects together.

use super::super::events::Events;
use super::super::program::{Any, Program};
use super::super::{
    Bound, Reading, constant, damper, detent, friction, hertz, inertia, magnet, snap, spin, spring, table,
    texture, transient, wall,
};
use super::T;
use crate::dsp::random::uniform;
use proptest::prelude::{ProptestConfig, prop_assert, proptest};

/// One of each.
fn all() -> Vec<Any> {
    let points = [(-2.0, 0.1), (-1.0, 0.3), (0.5, -0.2), (3.0, 0.0)];
    vec![
        wall::Stops { low: -2.0, high: 2.0, stiffness: 1.0, damping: 1e-3 }.into(),
        spring::Spring { stiffness: 0.1, centre: 0.0 }.into(),
        damper::Damper { damping: 1e-3 }.into(),
        detent::Detent::with_stiffness(24.0, 0.1).into(),
        snap::Snap { width: 0.2, stiffness: 0.1, most: 0.1, point: 0.6, centre: 0.0 }.into(),
        magnet::Magnet { centre: 0.0, stiffness: 0.4, reach: 0.3 }.into(),
        friction::Friction { torque: 2e-3, stretch: 0.01, law: friction::Law::Dahl }.into(),
        inertia::Inertia { inertia: 1e-4, stiffness: 1.0, damping: 1e-3 }.into(),
        constant::Constant { torque: 1e-3 }.into(),
        spin::Spin { speed: 3.0, damping: 0.01, most: 0.02 }.into(),
        texture::Ripple { amplitude: 0.01, wavelength: 0.1 }.into(),
        texture::Fed { scale: 1.0 }.into(),
        table::Table::new(&points).unwrap().into(),
        hertz::Hertz { angle: 0.0, below: true, factor: 30.0, most: 10.0 }.into(),
        transient::Transient { strength: 1e-3, hertz: 120.0, decay: 0.01, least: 0.5, most: 0.05 }.into(),
    ]
}

#[test]
fn a_program_is_the_sum_of_its_effects() {
    let mut together = Program::new(all()).unwrap();
    let mut apart: Vec<Program> = all().into_iter().map(|any| Program::new(vec![any]).unwrap()).collect();
    together.control(3).unwrap().gain = -2.0;
    apart[3].control(0).unwrap().gain = -2.0;
    together.control(11).unwrap().fed = 0.25;
    apart[11].control(0).unwrap().fed = 0.25;
    let (mut events, mut angle) = (Events::default(), 0.0);
    for n in 0..3000 {
        angle += 0.01 * uniform(1, n);
        let reading = Reading { angle, velocity: 0.3 * uniform(2, n), dt: T };
        let sum: f64 = apart.iter_mut().map(|p| p.tick(&reading, 0.5, 0.25, &mut events)).sum();
        assert!((together.tick(&reading, 0.5, 0.25, &mut events) - sum).abs() < 1e-12);
    }
    let demand = apart.iter().map(Program::demand).fold(Bound::default(), |a, b| Bound {
        stiffness: a.stiffness + b.stiffness,
        damping: a.damping + b.damping,
    });
    assert!((together.demand().stiffness - demand.stiffness).abs() < 1e-9 && together.masked() == 0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Whatever is read or asked, the sum is a number, and it is the same as before once the readings are good again.
    #[test]
    fn hostile_readings_leave_no_trace(seed in 0u64..1000, wild in proptest::sample::select(
        vec![f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300, -1e300, 1e17, 0.0])) {
        let mut program = Program::new(all()).unwrap();
        let mut events = Events::default();
        for n in 0..200u64 {
            let mut reading = Reading { angle: 2.0 * uniform(seed, n), velocity: 20.0 * uniform(seed + 1, n), dt: T };
            match n % 17 {
                3 => reading.angle = wild,
                7 => reading.velocity = wild,
                11 => reading.dt = wild,
                13 => program.control((n % 15) as usize).unwrap().gain = wild,
                14 => program.controls().for_each(|c| c.gain = 1.0),
                _ => {}
            }
            prop_assert!(program.tick(&reading, 1.0, 1.0, &mut events).is_finite());
        }
        program.controls().for_each(|c| c.gain = 1.0);
        let before = program.masked();
        for n in 0..50_000u64 {
            let reading = Reading { angle: 0.1 * uniform(seed, n), velocity: 0.0, dt: T };
            prop_assert!(program.tick(&reading, 1.0, 1.0, &mut events).is_finite());
        }
        prop_assert!(program.masked() == before);
    }
}
