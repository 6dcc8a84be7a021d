//! What a servo leaves to a quicker thread.

use super::{PERIOD, setup};
use crate::knob::effect::detent::{Detent, Shape};
use crate::knob::effect::friction::{Friction, Law};
use crate::knob::effect::hertz::Hertz;
use crate::knob::effect::magnet::Magnet;
use crate::knob::effect::program::Any;
use crate::knob::effect::snap::Snap;
use crate::knob::effect::spring::Spring;
use crate::knob::effect::table::Table;
use crate::knob::effect::wall::{Stops, Wall};
use crate::knob::effect::{constant::Constant, damper::Damper};
use crate::knob::governor::device::Delay;
use crate::knob::local_model::model::LocalModel;
use crate::knob::local_model::pending::Message;
use crate::knob::local_model::profile::SIDE;
use crate::knob::servo::setup::Setup;
use crate::knob::servo::tick::Servo;

/// All torque of the angle alone.
fn effects() -> Vec<Any> {
    let (stiffness, centre) = (0.02, 0.1);
    vec![
        Spring { stiffness, centre }.into(),
        Wall { angle: 0.3, below: false, stiffness: 0.1, damping: 0.0 }.into(),
        Stops { low: -0.2, high: 0.4, stiffness: 0.1, damping: 0.0 }.into(),
        Detent { count: 24.0, amplitude: 0.004, centre, shape: Shape::Sine, hysteresis: 0.05 }.into(),
        Snap { width: 0.3, stiffness: 0.03, most: 0.004, point: 0.6, centre }.into(),
        Magnet { centre, stiffness: 0.03, reach: 0.2 }.into(),
        Friction { torque: 0.003, stretch: 0.01, law: Law::Adhesion }.into(),
        Table::new(&[(-0.3, 0.01), (0.0, -0.004), (0.35, 0.006)]).unwrap().into(),
        Hertz { angle: 0.25, below: false, factor: 0.05, most: 0.01 }.into(),
        Constant { torque: 0.003 }.into(),
    ]
}

fn local(effects: Vec<Any>) -> Setup {
    let mut of = setup(effects, 0);
    of.device.delay = Delay { local: Some(2.0), ..Delay::ticks(60.0) };
    of.device.damping = 2e-3;
    // What jumps to a point is not too fast.
    (of.limits.slew, of.limits.over_speed) = (1e9, 1e9);
    of
}

/// At each of its points a profile is what this very servo gives there with its next tick, whatever its effects remember.
#[test]
fn a_profile_is_what_the_next_tick_would_give_there() {
    for alone in effects().into_iter().map(|one| vec![one]).chain([effects()]) {
        let mut servo = Servo::new(&local(alone.clone())).unwrap();
        servo.arm();
        for n in 0..400 {
            let angle = 0.5 * (0.05 * f64::from(n)).sin();
            servo.tick(Some(angle), true);
            if n % 13 != 0 {
                continue;
            }
            let profile = servo.profile();
            assert!(!profile.is_flat() && profile.reach > 0.03, "{alone:?}");
            assert_eq!(profile.at(angle), (servo.last().torque, false), "to the bit");
            // No line between two points is steeper than what it stands for, but where a snap or a crest falls the other way.
            assert!(profile.stiffness() <= servo.demand().stiffness * (1.0 + 1e-9), "{alone:?}");
            for k in 0..=2 * SIDE {
                let there = angle + profile.away(k);
                let exact = servo.clone().tick(Some(there), true);
                assert!((profile.at(there).0 - exact).abs() < 1e-12, "{alone:?} {n} {k}");
            }
        }
    }
}

/// Torque that depends on the speed, what is still rising, and what is at its limits.
#[test]
fn a_profile_keeps_what_is_no_matter_of_the_angle_and_every_limit() {
    let spring = Any::from(Spring { stiffness: 0.05, centre: 0.0 });
    let mut servo = Servo::new(&local(vec![Damper { damping: 1e-3 }.into(), spring.clone()])).unwrap();
    assert!(servo.profile().is_flat());
    servo.arm();
    (0..200).for_each(|n| _ = servo.tick(Some(1e-4 * f64::from(n)), true));
    let (profile, last) = (servo.profile(), *servo.last());
    let away = profile.at(last.angle + 0.01).0 - last.torque;
    let allowed = servo.last().allowed.stiffness;
    assert!(last.velocity > 0.5 && (away + 0.05 * allowed * 0.01).abs() < 1e-12);
    // Half risen, half of it.
    let mut of = local(vec![spring.clone()]);
    of.limits.soft_start = 200.0 * PERIOD;
    let mut rising = Servo::new(&of).unwrap();
    rising.arm();
    (0..100).for_each(|_| _ = rising.tick(Some(0.1), true));
    let profile = rising.profile();
    let slope = (profile.at(0.105).0 - profile.at(0.095).0) / 0.01;
    let granted = 0.05 * rising.last().allowed.stiffness;
    assert!((slope / (-0.5 * granted) - 1.0).abs() < 1e-9, "{slope}");
    assert!((profile.energy / (0.5 * (0.5 * granted) * 0.1 * 0.1) - 1.0).abs() < 1e-9, "{}", profile.energy);
    // Nothing beyond the peak, wherever.
    let mut of = local(vec![spring]);
    (of.limits.peak, of.limits.continuous) = (1e-3, 1e-3);
    let mut weak = Servo::new(&of).unwrap();
    weak.arm();
    for n in 0..2000 {
        weak.tick(Some(0.1 * (0.01 * f64::from(n)).sin()), true);
        let profile = weak.profile();
        for k in 0..100 {
            assert!(profile.at(weak.last().angle + 0.01 * f64::from(k - 50)).0.abs() <= 1e-3 * (1.0 + 1e-12));
        }
    }
    // Nor while it is still on its way to what was asked: from 0 at one end, the other end is twice as far.
    of.limits.slew = 1e-6;
    let mut slewed = Servo::new(&of).unwrap();
    slewed.arm();
    (0..9).for_each(|_| _ = slewed.tick(Some(0.1), true));
    let profile = slewed.profile();
    assert!(profile.torque.abs() < 1e-6 && profile.reach > 0.3);
    for k in 0..60 {
        assert!(profile.at(0.1 - 0.01 * f64::from(k)).0.abs() <= 1e-3 * (1.0 + 1e-12), "{k}");
    }
    // Latched, lost, behind a low-pass, and where nobody is quicker: the same at every angle.
    servo.tick(Some(f64::NAN), true);
    assert!(servo.profile().is_flat() && servo.profile().torque == 0.0);
    let mut slow = Servo::new(&setup(effects(), 2)).unwrap();
    slow.arm();
    (0..9).for_each(|_| _ = slow.tick(Some(0.1), true));
    assert!(slow.profile().is_flat() && slow.profile().torque == slow.last().torque);
    let mut of = local(effects());
    of.limits.low_pass = Some(500.0);
    let mut smooth = Servo::new(&of).unwrap();
    smooth.arm();
    (0..9).for_each(|_| _ = smooth.tick(Some(0.1), true));
    assert!(smooth.profile().is_flat());
}

/// What a slow thread sent is among it, as the next tick would give it; and it reaches as far as the knob gets by then, at its speed and pushed by
/// all its torque.
#[test]
fn a_profile_holds_a_slow_thread_s_world_and_reaches_where_the_knob_gets() {
    let of = local(vec![Spring { stiffness: 0.02, centre: 0.0 }.into()]);
    let world = LocalModel { torque: 2e-3, stiffness: 0.03, centre: 0.05, ..LocalModel::FREE };
    let mut servo = Servo::new(&of).unwrap();
    servo.arm();
    servo.follow(&Message::new(world, 0.0));
    (0..400).for_each(|_| _ = servo.tick(Some(0.1), true));
    let profile = servo.profile();
    for k in 0..=2 * SIDE {
        let there = 0.1 + profile.away(k);
        let exact = servo.clone().tick(Some(there), true);
        assert!((profile.at(there).0 - exact).abs() < 1e-12, "{k}");
    }
    let until = of.device.delay.total() * PERIOD;
    let pushed = 0.5 * of.device.peak / of.device.inertia * until * until;
    for speed in [0.0, 10.0, -100.0] {
        let mut servo = Servo::new(&of).unwrap();
        servo.arm();
        (0..400).for_each(|n| _ = servo.tick(Some(speed * PERIOD * f64::from(n)), true));
        let reach = servo.profile().reach;
        assert!(
            reach >= until * f64::abs(speed) + pushed && reach <= std::f64::consts::PI,
            "{speed}: {reach}"
        );
    }
}
