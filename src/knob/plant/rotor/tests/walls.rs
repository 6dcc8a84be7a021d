//! Contacts: what a wall gives back, and when.

use super::super::{Parameters, Rotor, Stops};
use super::{J, wall};
use crate::knob::plant::rival::integrator::{Method, Rival};

const RIM: f64 = 0.02;

/// How fast an undriven knob leaves a wall, of 1: e^{−ζ w t} at the time when K p + D ṗ is 0.
fn restitution(ratio: f64) -> f64 {
    let z = ratio;
    if z < 1.0 {
        let q = (1.0 - z * z).sqrt();
        // tan(q t) = 2 z q / (2 z² − 1) in time of 1/w.
        let t = (std::f64::consts::PI - (2.0 * z * q).atan2(1.0 - 2.0 * z * z)) / q;
        (-z * t).exp()
    } else if z == 1.0 {
        (-2.0f64).exp()
    } else {
        let q = (z * z - 1.0).sqrt();
        // e^{2 q t} = (z + q)² / (z − q)² over itself once: t = ln(z + q) · 2 / 2q.
        let fast = z + q;
        let t = 2.0 * fast.ln() / q;
        (-z * t).exp()
    }
}

/// The grid that a physical wall has to stand: leaving speeds are those of the closed form wherever the wall is, however the
/// contact falls among the steps, and nothing but numbers comes out.
#[test]
fn a_wall_gives_back_what_the_closed_form_says() {
    let mut worst = (0.0, String::new());
    for rim in [1e3, 1e4, 1e5, 1e6] {
        let stiffness = rim * RIM * RIM;
        for ratio in [0.0, 0.01, 0.05, 0.3, 0.5f64.sqrt(), 0.9, 0.999, 1.0, 1.001, 1.5, 2.0, 5.0] {
            let expected = restitution(ratio);
            for speed in [1e-6, 1e-3, 0.4, 20.0, 1e3] {
                for rate in [1e3, 8e3, 44.1e3, 48e3, 192e3] {
                    for (at, ahead) in [(0.0, 0.37), (0.7, 0.999), (-3.0, 2.5)] {
                        let mut rotor = Rotor::<true>::new(&wall(stiffness, ratio, at), rate).unwrap();
                        let start = at - speed * ahead / rate;
                        // Far away a slow knob may not come nearer by what an angle can tell.
                        rotor.place(start, speed).unwrap();
                        let mut steps = 0;
                        while rotor.speed() >= 0.0 || rotor.pushes() != 0.0 {
                            rotor.step(0.0);
                            steps += 1;
                            assert!(
                                rotor.speed().is_finite() && rotor.angle().is_finite() && steps < 200_000
                            );
                        }
                        let error = (rotor.speed() / speed + expected).abs();
                        if error > worst.0 {
                            worst = (error, format!("K {rim} zeta {ratio} v {speed} rate {rate} at {at}"));
                        }
                    }
                }
            }
        }
    }
    println!("wall grid: worst {worst:?}");
    assert!(worst.0 < 1e-12, "{worst:?}");
}

#[test]
fn a_contact_may_begin_and_end_within_a_step_on_either_side() {
    // 1.3 kHz of a wall in steps of 1 ms: a contact of 0.385 ms.
    for mirror in [1.0, -1.0] {
        let stops = Stops { low: -0.01, high: 0.01, stiffness: 400.0, damping: 0.0 };
        let parameters = Parameters { viscous: 0.0, stops: Some(stops), ..Parameters::default() };
        let mut rotor = Rotor::<true>::new(&parameters, 1e3).unwrap();
        rotor.place(0.0, mirror * 40.0).unwrap();
        let half = std::f64::consts::PI * (J / 400.0f64).sqrt();
        rotor.step(0.0);
        let left = 1e-3 - 0.01 / 40.0 - half;
        assert!((rotor.angle() - mirror * (0.01 - 40.0 * left)).abs() < 1e-15);
        assert!((rotor.speed() + mirror * 40.0).abs() < 1e-12);
        assert_eq!(rotor.counts().events, 2);
    }
}

/// The instant of a contact is known to the last place of a time, not of a step: a damped wall strikes at once.
#[test]
fn a_contact_is_at_its_instant() {
    let stops = Stops { low: -0.01, high: 0.01, stiffness: 79.0, damping: 0.095 };
    let rubs = 1.9e-3;
    let parameters = Parameters {
        viscous: 6e-4,
        coulomb: rubs,
        stiction: rubs,
        stops: Some(stops),
        ..Parameters::default()
    };
    let mut whole = Rotor::<true>::new(&parameters, 2e3).unwrap();
    let mut halves = Rotor::<true>::new(&parameters, 4e3).unwrap();
    for n in 0..4000 {
        let (angle, speed) = (8.1e-3 + f64::from(n) * 1.37e-7, 2.8 + f64::from(n % 71) * 0.013);
        whole.place(angle, speed).unwrap();
        halves.place(angle, speed).unwrap();
        whole.step(0.0192);
        (0..2).for_each(|_| halves.step(0.0192));
        assert!((whole.speed() - halves.speed()).abs() < 2e-13, "{n}: {} {}", whole.speed(), halves.speed());
    }
}

#[test]
fn a_crowded_step_ends_at_rest_and_is_counted() {
    let stops = Stops { low: -1e-4, high: 1e-4, stiffness: 1e6, damping: 0.0 };
    let parameters = Parameters { viscous: 0.0, stops: Some(stops), ..Parameters::default() };
    let mut rotor = Rotor::<true>::new(&parameters, 1e3).unwrap();
    rotor.place(0.0, 1e3).unwrap();
    let before = rotor.energy();
    rotor.step(0.0);
    assert_eq!((rotor.counts().crowded, rotor.speed()), (1, 0.0));
    assert!(rotor.energy() <= before);
}

#[test]
fn a_knob_pressed_against_a_wall_rests_at_its_depth() {
    for ratio in [0.05, 1.0, 3.0] {
        for rate in [1e3, 48e3] {
            let mut rotor = Rotor::<true>::new(&wall(40.0, ratio, 0.3), rate).unwrap();
            rotor.place(0.29, 0.0).unwrap();
            (0..(2.0 * rate) as usize).for_each(|_| rotor.step(0.02));
            assert!((rotor.angle() - (0.3 + 0.02 / 40.0)).abs() < 1e-9, "{ratio} {rate} {}", rotor.angle());
        }
    }
}

/// It leaves a wall faster than that follows, and is pushed into it again before it is out.
#[test]
fn a_wall_that_was_let_go_is_met_again_behind_its_place() {
    let (k, d) = (40.0, 2.0 * 2.0 * (40.0f64 * J).sqrt());
    let parameters = wall(k, 2.0, 0.0);
    let mut rival = Rival::new(&parameters, Method::SymplecticEuler, 4e6).unwrap();
    for rate in [1e3, 16e3] {
        let mut rotor = Rotor::<true>::new(&parameters, rate).unwrap();
        let speed = -1.2 * k * 0.01 / d;
        rotor.place(0.01, speed).unwrap();
        rival.place(0.01, speed);
        assert_eq!(rotor.pushes(), 0.0);
        let steps = (2e-3 * rate) as usize;
        (0..steps).for_each(|_| rotor.step(0.9));
        (0..8000).for_each(|_| rival.step(0.9));
        assert!(rotor.pushes() > 0.0 && rotor.counts().events == 1, "{:?}", rotor.counts());
        assert!((rotor.angle() - rival.angle()).abs() < 1e-5, "{} {}", rotor.angle(), rival.angle());
    }
}
