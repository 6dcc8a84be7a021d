//! Dry friction, with walls and without.

use super::super::{Parameters, Rotor};
use super::{J, wall};

#[test]
fn friction_stops_it_at_its_instant_and_holds_it() {
    let (b, c) = (2e-5, 1e-3);
    let parameters = Parameters { viscous: b, coulomb: c, stiction: 1.4e-3, ..Parameters::default() };
    for rate in [10.0, 1e3, 48e3] {
        let mut rotor = Rotor::<false>::new(&parameters, rate).unwrap();
        rotor.place(0.0, 35.0).unwrap();
        (0..(0.3 * rate) as usize).for_each(|_| rotor.step(0.0));
        // θ = (J ω0 − T_c t) / b with t = J/b ln(1 + b ω0 / T_c).
        let t = J / b * (1.0 + b * 35.0 / c).ln();
        assert!((rotor.angle() - (J * 35.0 - c * t) / b).abs() < 1e-13, "{rate}");
        assert_eq!(rotor.speed(), 0.0);
        let rests = rotor.angle();
        (0..100).for_each(|_| rotor.step(1.399e-3));
        (0..100).for_each(|_| rotor.step(-1.4e-3));
        assert_eq!((rotor.angle(), rotor.speed()), (rests, 0.0));
        rotor.step(1.401e-3);
        assert!(rotor.speed() > 0.0);
    }
}

#[test]
fn a_reversal_within_a_step_turns_friction_round() {
    let parameters = Parameters { viscous: 0.0, coulomb: 1e-3, stiction: 1e-3, ..Parameters::default() };
    let mut rotor = Rotor::<false>::new(&parameters, 100.0).unwrap();
    rotor.place(0.0, 2.0).unwrap();
    rotor.step(-5e-3);
    let (slow, fast) = (6e-3 / J, 4e-3 / J);
    let t = 2.0 / slow;
    assert!((rotor.angle() - (2.0 * t / 2.0 - 0.5 * fast * (0.01 - t).powi(2))).abs() < 1e-15);
    assert!((rotor.speed() + fast * (0.01 - t)).abs() < 1e-14);
}

#[test]
fn a_torque_that_friction_holds_does_not_turn_it_back() {
    let parameters = Parameters { coulomb: 1e-3, stiction: 1.4e-3, ..Parameters::default() };
    let mut rotor = Rotor::<false>::new(&parameters, 100.0).unwrap();
    rotor.place(0.0, 2.0).unwrap();
    rotor.step(-1.3e-3);
    assert_eq!(rotor.speed(), 0.0);
    rotor.place(0.0, 2.0).unwrap();
    rotor.step(-1.5e-3);
    assert!(rotor.speed() < 0.0);
}

/// A torque that turns a knob round just behind a stop, all within a step at whose end it is far from there.
#[test]
fn a_stop_is_met_though_a_step_begins_and_ends_before_it() {
    for ratio in [0.0, 0.3, 2.0] {
        let parameters = wall(400.0, ratio, 0.0);
        let mut long = Rotor::<true>::new(&parameters, 1e3).unwrap();
        let mut short = Rotor::<true>::new(&parameters, 1e6).unwrap();
        let mut none = Rotor::<false>::new(&parameters, 1e3).unwrap();
        for rotor in [&mut long, &mut short] {
            rotor.place(-1e-4, 1.0).unwrap();
        }
        none.place(-1e-4, 1.0).unwrap();
        long.step(-0.015);
        none.step(-0.015);
        (0..1000).for_each(|_| short.step(-0.015));
        assert!(long.counts().events >= 2 && long.angle() < -1e-4, "{ratio}");
        assert!((long.angle() - short.angle()).abs() < 1e-14 && (long.angle() - none.angle()).abs() > 1e-6);
        assert!((long.speed() - short.speed()).abs() < 1e-12 * 20.0, "{ratio}");
    }
}

#[test]
fn a_wall_pushes_back_what_friction_cannot_hold() {
    let parameters = Parameters { coulomb: 1e-3, stiction: 1.4e-3, ..wall(40.0, 0.5, 0.0) };
    let mut rotor = Rotor::<true>::new(&parameters, 8e3).unwrap();
    (0..8000).for_each(|_| rotor.step(0.02));
    assert_eq!(rotor.speed(), 0.0);
    let rests = rotor.angle();
    assert!((rests - 0.02 / 40.0).abs() <= 1.4e-3 / 40.0);
    // As much less as friction takes, then more.
    (0..80).for_each(|_| rotor.step(40.0 * rests - 1.399e-3));
    assert_eq!(rotor.angle(), rests);
    (0..8000).for_each(|_| rotor.step(0.0));
    assert!(rotor.angle() < 1.4e-3 / 40.0 && rotor.speed() == 0.0, "{}", rotor.angle());
}
