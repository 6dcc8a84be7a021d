//! A running rumble motor never allocates, whatever happens in a step.

use crate::common::COIN;
use pacinian::actuator::motor::{Casing, Drive, Level, Motor, Parameters, Plan, Suspension};

#[test]
fn a_running_motor_never_allocates() {
    let by = Suspension { stiffness: 1000.0, damping: 3.0 };
    let p = Parameters { casing: Casing::Suspended { mass: 0.1, across: by, upright: by }, ..COIN };
    let light = Parameters { inertia: 1e-15, eccentric: 0.0, ..p };
    for level in [Level::Economy, Level::Default, Level::Fine] {
        for p in [p, light] {
            let mut motor = Motor::<true>::new(&p, &Plan::whole(level), 48e3).unwrap();
            let mut bare = Motor::<false>::new(&p, &Plan::whole(level), 48e3).unwrap();
            let before = crate::silent::allocations();
            let mut sum = 0.0;
            for n in 0..3000_u32 {
                let drive = match n % 300 {
                    0..80 => Drive::Voltage(3.0),
                    80..160 => Drive::Voltage(-3.0),
                    160..240 => Drive::Current { amperes: 0.08, limit: 3.0 },
                    _ => Drive::Open,
                };
                motor.drive(drive);
                motor.step();
                motor.step_with(&[(0.2, Drive::SHORT), (0.7, drive)]);
                motor.part(0.48);
                sum += motor.reading().acceleration[0];
                bare.run(&[2.0, -3.0, f64::NAN, 1.0], |_, speed, _| sum += speed);
            }
            assert!(sum.is_finite() && motor.counts().events > 0);
            assert_eq!(crate::silent::allocations(), before);
        }
    }
}
