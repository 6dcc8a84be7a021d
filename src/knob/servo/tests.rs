mod profile;
mod succession;
mod warmth;

use super::setup::Setup;
use super::simulated::{Model, both};
use crate::knob::effect::program::Any;
use crate::knob::effect::{constant::Constant, spring::Spring, wall::Stops};
use crate::knob::governor::device::{Delay, Device};
use crate::knob::local_model::model::LocalModel;
use crate::knob::local_model::pending::Message;
use crate::knob::passivity::Cap;
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::parts::{Build, Hand};
use crate::knob::plant::wave::Wave;
use crate::knob::safety::chain::{Limits, Stage, Trip};
use crate::knob::velocity::choice::Choice;

const PERIOD: f64 = 1.0 / 8000.0;

fn setup(effects: Vec<Any>, delay: usize) -> Setup {
    let device = Device {
        inertia: 6e-6,
        damping: 2e-4,
        friction: None,
        count: std::f64::consts::TAU / 1e6,
        period: PERIOD,
        delay: Delay::ticks(delay as f64),
        resonance: None,
        low_pass: None,
        velocity: Choice::Adaptive(0.01),
        peak: 0.2,
    };
    let limits = Limits {
        period: PERIOD,
        slew: 1e4,
        low_pass: None,
        continuous: 0.1,
        winding: 12.0,
        peak: 0.2,
        soft_start: 0.0,
        stale: 8,
        release: 0.01,
        over_speed: 1e3,
    };
    Setup::new(effects, device, limits)
}

fn model(build: Build, delay: usize) -> Model {
    Model { build, encoder: None, delay, local: None, volts: None, warms: None }
}

fn plain() -> Build {
    Build {
        parameters: Parameters { inertia: 6e-6, viscous: 2e-4, ..Parameters::default() },
        ..Build::default()
    }
}

#[test]
fn a_spring_holds_a_hand_where_hooke_says_and_follows_its_shift() {
    let setup = setup(vec![Spring { stiffness: 0.2, centre: 0.0 }.into()], 2);
    let (mut knob, mut servo) = both(&model(plain(), 2), &setup).unwrap();
    assert!(servo.arm());
    let hand = Hand { torque: 0.01, ..Hand::default() };
    for _ in 0..24_000 {
        knob.tick(&mut servo, &hand);
    }
    assert!((knob.plant().angle() - 0.05).abs() < 1e-9, "{}", knob.plant().angle());
    servo.control(0).unwrap().shift = 0.3;
    servo.control(0).unwrap().gain = 0.5;
    for _ in 0..48_000 {
        knob.tick(&mut servo, &hand);
    }
    assert!((knob.plant().angle() - 0.4).abs() < 1e-9, "{}", knob.plant().angle());
    // What the knob stores went in by the hand, and by the motor that moved the spring's end; friction took the rest.
    let stored = 0.5 * 0.1 * 0.1 * 0.1;
    assert!(knob.by_hand() > stored && servo.energy().absorbed() < knob.by_hand());
}

/// The observer's sum is the work of the torque that acted, whatever the delay.
#[test]
fn energy_is_booked_for_the_torque_that_acted() {
    for delay in [0, 1, 5] {
        let setup = setup(vec![Spring { stiffness: 0.1, centre: 0.2 }.into()], delay);
        let (mut knob, mut servo) = both(&model(plain(), delay), &setup).unwrap();
        servo.arm();
        let (mut work, mut seen) = (Vec::new(), knob.plant().angle());
        for _ in 0..300 {
            let torque = knob.tick(&mut servo, &Hand::default());
            work.push(torque * (knob.plant().angle() - seen));
            seen = knob.plant().angle();
        }
        // The last reading is `delay` + 1 steps old.
        let exact: f64 = work[..work.len() - delay - 1].iter().sum();
        assert!((servo.energy().absorbed() + exact).abs() < 1e-12 * exact.abs(), "{delay}");
    }
}

#[test]
fn what_is_too_stiff_is_held_to_what_the_device_bears() {
    let wanted = 50.0;
    let setup = setup(vec![Stops { low: -0.5, high: 0.1, stiffness: wanted, damping: 0.0 }.into()], 4);
    let (mut knob, mut servo) = both(&model(plain(), 4), &setup).unwrap();
    servo.arm();
    let hand = Hand { torque: 0.01, ..Hand::default() };
    for _ in 0..16_000 {
        knob.tick(&mut servo, &hand);
    }
    let most = servo.governor().most_stiffness(0.0);
    assert!(most < 1.0 && servo.last().allowed.stiffness < 0.02);
    assert!((knob.plant().angle() - 0.1 - 0.01 / most).abs() < 1e-6 && knob.plant().speed().abs() < 1e-6);
    assert!(servo.last().acted & 1 << Stage::Governor as u16 != 0);
}

#[test]
fn torque_is_gone_with_the_tick_in_which_the_angle_is_no_number() {
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let setup = setup(vec![Constant { torque: 0.05 }.into()], 0);
        let (mut knob, mut servo) = both(&model(plain(), 0), &setup).unwrap();
        servo.arm();
        (0..100).for_each(|_| assert!(knob.tick(&mut servo, &Hand::default()) >= 0.0));
        assert_eq!(servo.last().torque, 0.05);
        assert_eq!(servo.tick(Some(bad), true), 0.0);
        assert_eq!((servo.chain().trip(), servo.arm()), (Some(Trip::Reading), false));
        assert_eq!(knob.tick(&mut servo, &Hand::default()), 0.0);
        servo.acknowledge();
        assert!(servo.arm());
        assert!(knob.tick(&mut servo, &Hand::default()) > 0.0);
    }
}

#[test]
fn without_readings_torque_stays_a_little_and_falls() {
    let setup = setup(vec![Constant { torque: 0.05 }.into()], 0);
    let (mut knob, mut servo) = both(&model(plain(), 0), &setup).unwrap();
    servo.arm();
    for _ in 0..100 {
        knob.tick(&mut servo, &Hand::default());
    }
    let torques: Vec<f64> = (0..100).map(|_| servo.tick(None, true)).collect();
    assert!(torques[..8].iter().all(|t| *t == 0.05) && torques[8] < 0.05, "{torques:?}");
    // 10 ms are 80 ticks.
    assert!(torques[80] > 0.0 && torques[89..].iter().all(|t| *t == 0.0), "{torques:?}");
    assert_eq!(servo.chain().trip(), Some(Trip::Lost));
}

#[test]
fn known_cogging_is_taken_back_and_known_ripple_made_up_for() {
    let cogging = Wave::detent(2e-3, 7.0).unwrap();
    let ripple = Wave::detent(0.2, 3.0).unwrap();
    let build = Build { cogging, ..plain() };
    let wander = |known: Wave| {
        let setup = Setup { cogging: known, ..setup(vec![], 0) };
        let (mut knob, mut servo) = both(&model(build, 0), &setup).unwrap();
        knob.place(0.2).unwrap();
        servo.arm();
        for _ in 0..800 {
            knob.tick(&mut servo, &Hand::default());
        }
        (knob.plant().angle() - 0.2).abs()
    };
    assert!(wander(Wave::default()) > 0.1 && wander(cogging) < 1e-6, "{}", wander(cogging));
    let setup = Setup { ripple, ..setup(vec![Constant { torque: 0.05 }.into()], 0) };
    for angle in [0.0, 0.3, 0.6, 1.1] {
        let (_, mut servo) = both(&model(plain(), 0), &setup).unwrap();
        servo.arm();
        let torque = servo.tick(Some(angle), true);
        assert!((torque * (1.0 + ripple.at(angle)) - 0.05).abs() < 1e-15);
    }
}

#[test]
fn what_a_slow_thread_sends_is_followed_without_a_jump() {
    let setup = setup(vec![], 0);
    let (_, mut servo) = both(&model(plain(), 0), &setup).unwrap();
    servo.arm();
    servo.tick(Some(0.1), true);
    let model = LocalModel { stiffness: 0.3, ..LocalModel::FREE };
    servo.follow(&Message::new(model, 0.0));
    let torques: Vec<f64> = (0..400).map(|_| servo.tick(Some(0.1), true)).collect();
    let steps = torques.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    // 20 ms are 160 ticks.
    assert!(steps < 0.03 / 150.0 && (torques[399] + 0.03).abs() < 1e-12, "{steps}");
    assert!((servo.energy().booked() - 0.5 * 0.3 * 0.01).abs() < 1e-12, "{}", servo.energy().booked());
    // A kick is given once.
    servo.follow(&Message::new(model, 1e-6));
    servo.follow(&Message::new(model, 1e-6));
    let kicked = servo.tick(Some(0.1), true);
    assert!((kicked - (2e-6 / PERIOD - 0.03)).abs() < 1e-12, "{kicked}");
    assert!((servo.tick(Some(0.1), true) + 0.03).abs() < 1e-12);
}

/// Half as much again as the edge swings; braked by the books it swings less.
#[test]
fn the_passivity_controller_takes_back_what_hold_and_delay_create() {
    let swing = |passivity: Option<Cap>| {
        let mut setup = setup(vec![Spring { stiffness: 1.0, centre: 0.0 }.into()], 0);
        // The governor would keep it still.
        setup.device.damping = 1.0;
        setup.passivity = passivity;
        let mut build = plain();
        build.parameters.viscous = 1e-5;
        let (mut knob, mut servo) = both(&model(build, 0), &setup).unwrap();
        knob.place(0.01).unwrap();
        servo.arm();
        let most = |n: usize, knob: &mut super::simulated::Simulated, servo: &mut super::tick::Servo| {
            (0..n).fold(0.0, |most, _| {
                knob.tick(servo, &Hand::default());
                f64::max(most, knob.plant().angle().abs())
            })
        };
        most(1500, &mut knob, &mut servo);
        most(100, &mut knob, &mut servo)
    };
    let (free, braked) = (swing(None), swing(Some(Cap { inertia: 6e-6, share: 0.5, least_speed: 1e-3 })));
    assert!(free > 0.02 && braked < 1e-3, "{free} {braked}");
}
