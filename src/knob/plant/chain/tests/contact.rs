//! What a knob meets: stops, a hand, its own shaft.

use super::super::{Build, Chain, Hand};
use super::{FREE, full, shaft};
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::parts::Grasp;
use crate::knob::plant::rotor::Rotor;
use crate::knob::plant::stops::Stops;

#[test]
fn a_wall_that_was_let_go_is_met_again_behind_its_place() {
    let stops = Stops::of_ratio(f64::NEG_INFINITY, 0.0, 40.0, 2.0, 6e-6);
    let parameters = Parameters { stops: Some(stops), ..Parameters::default() };
    let mut chain = Chain::new(&Build { parameters, ..Build::default() }, 4e3).unwrap();
    let mut rotor = Rotor::<true>::new(&parameters, 4e3).unwrap();
    let speed = -1.2 * 40.0 * 0.01 / stops.damping;
    chain.place(0.01, speed).unwrap();
    rotor.place(0.01, speed).unwrap();
    for _ in 0..8 {
        chain.step(0.9, &FREE);
        rotor.step(0.9);
        assert!(
            (chain.angle() - rotor.angle()).abs() < 1e-14 && (chain.speed() - rotor.speed()).abs() < 1e-11
        );
    }
    assert_eq!(chain.counts(), rotor.counts());
}

/// Wherever the stop is: what is behind it is counted from it.
#[test]
fn a_wall_gives_back_what_it_got() {
    let mut worst = [0.0f64; 2];
    for stiffness in [0.4, 40.0, 400.0] {
        for (speed, ratio) in [(1e-3, 0.0), (0.4, 0.0), (20.0, 0.0), (20.0, 0.3), (1e3, 2.0)] {
            for rate in [1e3, 8e3, 48e3] {
                for (n, at) in [0.0, 0.7].into_iter().enumerate() {
                    let stops = Stops::of_ratio(f64::NEG_INFINITY, at, stiffness, ratio, 6e-6);
                    let parameters = Parameters { viscous: 0.0, stops: Some(stops), ..Parameters::default() };
                    let mut chain = Chain::new(&Build { parameters, ..Build::default() }, rate).unwrap();
                    let mut rotor = Rotor::<true>::new(&parameters, rate).unwrap();
                    chain.place(at - 0.4 * speed / rate, speed).unwrap();
                    rotor.place(at - 0.4 * speed / rate, speed).unwrap();
                    for _ in 0..(0.05 * rate) as usize {
                        chain.step(0.0, &FREE);
                        rotor.step(0.0);
                    }
                    worst[n] = worst[n].max((chain.speed() - rotor.speed()).abs() / speed);
                }
            }
        }
    }
    println!("chain's wall: {worst:?}");
    assert!(worst[0] < 1e-12 && worst[1] < 1e-12, "{worst:?}");
}

#[test]
fn a_crowded_step_ends_at_rest_and_is_counted() {
    let stops = Stops { low: -1e-4, high: 1e-4, stiffness: 1e6, damping: 0.0 };
    let parameters = Parameters { viscous: 0.0, stops: Some(stops), ..Parameters::default() };
    let mut chain = Chain::new(&Build { parameters, ..Build::default() }, 1e3).unwrap();
    chain.place(0.0, 1e3).unwrap();
    let before = chain.energy();
    chain.step(0.0, &FREE);
    assert_eq!((chain.counts().crowded, chain.speed()), (1, 0.0));
    assert!(chain.energy() <= before);
}

#[test]
fn a_hand_whose_target_is_lost_stays_where_it_was() {
    let build = Build { grasp: Some(Grasp { stiffness: 0.4, damping: 1e-3 }), ..Build::default() };
    let mut chain = Chain::new(&build, 1e3).unwrap();
    (0..100)
        .for_each(|n| chain.step(0.0, &Hand { target: 3e-3 * f64::from(n), target_speed: 3.0, torque: 0.0 }));
    (0..1000).for_each(|_| chain.step(0.0, &Hand { target: f64::NAN, ..FREE }));
    assert!((chain.angle() - 0.3).abs() < 1e-12, "{}", chain.angle());
}

/// A hand's spring and damper to a point that stands, then moves: the closed form, and that nothing lags when it goes on long enough.
#[test]
fn a_grasp_pulls_as_a_spring_and_damper() {
    let grasp = Grasp { stiffness: 0.4, damping: 1e-3 };
    let build = Build { grasp: Some(grasp), ..Build::default() };
    let p = build.parameters;
    for rate in [100.0, 1e3, 48e3] {
        let mut chain = Chain::new(&build, rate).unwrap();
        let (a, square) = (0.5 * (grasp.damping + p.viscous) / p.inertia, grasp.stiffness / p.inertia);
        let q = (square - a * a).sqrt();
        for n in 1..(0.05 * rate) as usize {
            chain.step(0.0, &Hand { target: 0.2, ..FREE });
            let t = n as f64 / rate;
            let expected = 0.2 * (1.0 - (-a * t).exp() * ((q * t).cos() + a / q * (q * t).sin()));
            assert!((chain.angle() - expected).abs() < 1e-13, "{rate} {n}");
        }
        let mut chain = Chain::new(&build, rate).unwrap();
        for n in 0..rate as usize {
            chain.step(0.0, &Hand { target: 3.0 * n as f64 / rate, target_speed: 3.0, torque: 0.0 });
        }
        let lag = p.viscous * 3.0 / grasp.stiffness;
        let (angle, speed) = (chain.angle() - (3.0 - lag), chain.speed() - 3.0);
        assert!(angle.abs() < 1e-12 && speed.abs() < 1e-10, "{rate}: {angle:e} {speed:e}");
    }
}

#[test]
fn a_motor_that_sticks_lets_the_knob_swing_on_its_shaft() {
    let mut build = Build { parameters: full().parameters, shaft: Some(shaft()), ..Build::default() };
    build.parameters.stops = None;
    let mut chain = Chain::new(&build, 8e3).unwrap();
    // Weaker than friction holds, even at the swing's far end.
    let s = shaft();
    for n in 1..80 {
        chain.step(0.0, &Hand { torque: 0.4e-3, ..FREE });
        let (a, square) = (0.5 * (s.damping + s.viscous) / s.inertia, s.stiffness / s.inertia);
        let (t, q) = (f64::from(n) / 8e3, (square - a * a).sqrt());
        let expected =
            0.4e-3 / s.stiffness * (1.0 - (-a * t).exp() * ((q * t).cos() + a / q * (q * t).sin()));
        assert!((chain.knob_angle() - expected).abs() < 1e-17, "{n}");
        assert_eq!((chain.angle(), chain.speed()), (0.0, 0.0));
    }
    (0..400).for_each(|_| chain.step(0.0, &Hand { torque: 1.4e-3, ..FREE }));
    assert!(chain.angle() > 1e-3);
}
