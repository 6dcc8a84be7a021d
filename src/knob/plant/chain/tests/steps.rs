//! What a step is: a rotor's where there is no more, two halves, its own mirror image.

use super::super::{Build, Chain, Drive, Hand};
use super::{FREE, full, mixed, state, winding};
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::rotor::Rotor;
use crate::knob::plant::stops::Stops;
use crate::knob::plant::wave::{Harmonic, Wave};

#[test]
fn bare_it_is_a_rotor() {
    for (stops, rate) in [(None, 1e3), (None, 48e3), (Some(0.3), 1e3), (Some(0.0), 8e3), (Some(2.0), 1e3)] {
        let stops = stops.map(|ratio| Stops::of_ratio(-0.05, 0.05, 40.0, ratio, 6e-6));
        let parameters = Parameters { coulomb: 1e-3, stiction: 1.3e-3, stops, ..Parameters::default() };
        let mut chain = Chain::new(&Build { parameters, ..Build::default() }, rate).unwrap();
        let mut rotor = Rotor::<true>::new(&parameters, rate).unwrap();
        let mut worst = 0.0f64;
        for n in 0..(0.2 * rate) as u64 {
            let torque = 6e-3 * mixed(n / (rate / 400.0) as u64);
            chain.step(torque, &FREE);
            rotor.step(torque);
            worst = worst.max((chain.angle() - rotor.angle()).abs());
            worst = worst.max((chain.speed() - rotor.speed()).abs() * 1e-2);
        }
        assert!(rotor.counts().events > 5 && worst < 2e-11, "{stops:?} {rate}: {worst:e}");
    }
}

/// Half a step twice is a step once, with all there is.
#[test]
fn a_step_is_two_of_half_of_it() {
    let plain = Build { cogging: Wave::default(), ripple: Wave::default(), ..full() };
    for build in [full(), plain, Build { drive: Drive::Voltage(winding()), ..full() }] {
        let mut whole = Chain::new(&build, 2e3).unwrap();
        let mut halves = Chain::new(&build, 4e3).unwrap();
        let mut worst = 0.0f64;
        for n in 0..1500u64 {
            let command =
                0.2 * mixed(n / 13) * if matches!(build.drive, Drive::Voltage(_)) { 60.0 } else { 1.0 };
            let hand =
                Hand { torque: 5e-3 * mixed(n / 7 + 1000), target: 0.2 * mixed(n / 50), target_speed: 1.5 };
            let later = Hand { target: hand.target + hand.target_speed / 4e3, ..hand };
            whole.step(command, &hand);
            halves.step(command, &hand);
            halves.step(command, &later);
            for (one, (other, scale)) in
                state(&whole).iter().zip(state(&halves).iter().zip([1.0, 1.0, 300.0, 100.0, 5.0]))
            {
                worst = worst.max((one - other).abs() / scale);
            }
            // What follows a difference is not compared, but the difference.
            (halves.x, halves.origin) = (whole.x, whole.origin);
            (halves.grip, halves.contact, halves.limit) = (whole.grip, whole.contact, whole.limit);
        }
        assert_eq!((whole.counts().crowded, halves.counts().crowded), (0, 0));
        assert!(whole.counts().events > 100, "{:?}", whole.counts());
        assert!(worst < 1e-12, "{worst:e}");
    }
}

#[test]
fn it_is_the_same_mirrored() {
    let mut build = full();
    build.parameters.stops = Some(Stops { low: -0.3, high: 0.3, stiffness: 40.0, damping: 1e-3 });
    build.cogging = Wave::detent(8e-3, 24.0).unwrap();
    build.ripple = Wave::new(&[Harmonic { periods: 6.0, sine: 0.0, cosine: 0.03 }]).unwrap();
    let mut chains = [1.0, -1.0].map(|sign| (sign, Chain::new(&build, 5e3).unwrap()));
    for n in 0..3000u64 {
        for (sign, chain) in &mut chains {
            let hand = Hand {
                torque: *sign * 5e-3 * mixed(n / 9),
                target: *sign * 0.3 * mixed(n / 90),
                target_speed: 0.0,
            };
            chain.step(*sign * 0.15 * mixed(n / 31), &hand);
        }
        let [one, other] = [&chains[0].1, &chains[1].1].map(state);
        assert!((0..5).all(|k| one[k] == -other[k]), "{n}: {one:?} {other:?}");
    }
    assert!(chains[0].1.counts().events > 100);
}
