//! A servo behind another one.

use super::{PERIOD, setup};
use crate::knob::effect::{constant::Constant, spring::Spring};
use crate::knob::local_model::model::LocalModel;
use crate::knob::local_model::pending::Message;
use crate::knob::safety::budget::Budget;
use crate::knob::safety::chain::{Stage, Trip};
use crate::knob::servo::tick::Servo;

/// A winding that was heated is no cooler because other effects are asked for: not once, and not however often.
#[test]
fn a_servo_that_takes_over_is_as_warm_as_the_one_before() {
    let pushes = |torque: f64| setup(vec![Constant { torque }.into()], 0);
    let run = |changes: bool| {
        let mut servo = Servo::new(&pushes(0.2)).unwrap();
        servo.arm();
        let mut spent = 0.0;
        for n in 0..320_000 {
            if changes && n % 800 == 799 {
                let mut next = Servo::new(&pushes(0.2 - 1e-6 * f64::from(n % 7))).unwrap();
                next.continue_from(&servo);
                let [was, is] = [&servo, &next].map(|servo| servo.chain().load());
                assert!((is - was).abs() < 1e-12 && !next.chain().armed());
                servo = next;
                servo.arm();
            }
            let torque = servo.tick(Some(0.0), true);
            spent += torque * torque * PERIOD;
        }
        (servo.chain().load(), spent, servo.chain().count(Stage::Budget))
    };
    let (one, many) = (run(false), run(true));
    assert!(one.0 > 0.9 && (many.0 / one.0 - 1.0).abs() < 1e-3, "{one:?} {many:?}");
    assert!((many.1 / one.1 - 1.0).abs() < 1e-3 && many.2 > one.2 / 2, "{one:?} {many:?}");
    // Half the continuous torque is a quarter of the heat: what was a quarter is all of it, and never more than that.
    let [mut small, mut large] = [0.05, 0.1].map(|most| Budget::new(most, 12.0, 1.0, PERIOD).unwrap());
    large.spend_over(0.05, 12.0);
    small.continue_from(&large);
    assert!((small.load() / (4.0 * large.load()) - 1.0).abs() < 1e-12);
    large.spend_over(0.2, 12.0);
    small.continue_from(&large);
    assert_eq!((small.load(), small.allowed()), (1.0, 0.05));
    // Spent far beyond it, nothing is left, and that is a number.
    small.spend_over(10.0, 100.0);
    assert!(small.load() > 100.0 && small.allowed() == 0.0 && !small.allows(1e-9));
}

#[test]
fn a_fault_stays_latched_and_books_and_worlds_go_on() {
    let springy = |stiffness: f64| setup(vec![Spring { stiffness, centre: 0.0 }.into()], 0);
    let mut first = Servo::new(&springy(0.02)).unwrap();
    first.arm();
    first.follow(&Message::new(LocalModel { torque: 1e-3, ..LocalModel::FREE }, 0.0));
    (0..400).for_each(|n| _ = first.tick(Some(1e-4 * f64::from(n)), true));
    let mut next = Servo::new(&springy(0.0)).unwrap();
    next.continue_from(&first);
    let energy = first.energy().absorbed();
    assert!(energy.abs() > 1e-9 && next.energy().absorbed() == energy);
    next.arm();
    let torque = next.tick(Some(0.04), true);
    assert!((torque - 1e-3 * next.last().allowed.stiffness).abs() < 1e-12, "{torque}");
    first.tick(Some(1e9), true);
    assert_eq!(first.chain().trip(), Some(Trip::OverSpeed));
    let mut next = Servo::new(&springy(0.01)).unwrap();
    next.arm();
    next.continue_from(&first);
    assert_eq!((next.chain().trip(), next.chain().count(Stage::OverSpeed)), (Some(Trip::OverSpeed), 1));
    assert!(!next.arm() && next.tick(Some(0.0), true) == 0.0);
    next.acknowledge();
    assert!(next.arm());
}
