//! What is no number, what cannot be, and energy whatever it is made of.

use super::super::{Parameters, Rotor, Stops};
use super::{J, wall};
use proptest::prelude::{ProptestConfig, any, prop_assert, proptest};

#[test]
fn what_is_no_torque_is_none_and_counted() {
    let parameters = Parameters { coulomb: 1e-3, stiction: 1e-3, ..wall(40.0, 0.1, 1.0) };
    let mut rotor = Rotor::<true>::new(&parameters, 1e3).unwrap();
    let mut other = rotor.clone();
    for torque in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        rotor.place(0.5, 2.0).unwrap();
        other.place(0.5, 2.0).unwrap();
        rotor.step(torque);
        other.step(0.0);
        assert_eq!((rotor.angle(), rotor.speed()), (other.angle(), other.speed()));
    }
    assert_eq!(rotor.counts().masked, 4);
    assert!(rotor.place(f64::NAN, 0.0).is_err() && rotor.place(0.0, f64::INFINITY).is_err());
}

#[test]
fn what_cannot_be_is_named() {
    let good = Parameters { coulomb: 1e-3, stiction: 2e-3, ..wall(40.0, 0.1, 1.0) };
    let stops = good.stops.unwrap();
    let with = |stops: Stops| Parameters { stops: Some(stops), ..good };
    for (parameters, field) in [
        (Parameters { inertia: 0.0, ..good }, "inertia"),
        (Parameters { viscous: -1.0, ..good }, "viscous"),
        (Parameters { coulomb: f64::NAN, ..good }, "coulomb"),
        (Parameters { stiction: 0.5e-3, ..good }, "stiction"),
        (with(Stops { high: f64::NAN, ..stops }), "stop high"),
        (with(Stops { low: 1.0, ..stops }), "stop high"),
        (with(Stops { low: f64::INFINITY, ..stops }), "stop low"),
        (with(Stops { stiffness: 0.0, ..stops }), "stop stiffness"),
        (with(Stops { damping: -1.0, ..stops }), "stop damping"),
    ] {
        assert_eq!(Rotor::<true>::new(&parameters, 1e3).unwrap_err().field, field);
    }
    assert_eq!(Rotor::<true>::new(&good, 0.0).unwrap_err().field, "rate");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn energy_never_grows_by_itself(
        log_k in -1.0f64..3.0, ratio in 0.0f64..3.0, viscous in 0.0f64..1e-4, coulomb in 0.0f64..5e-3,
        angle in -1.2f64..1.2, speed in -100.0f64..100.0, log_rate in 2.0f64..5.3,
    ) {
        let k = 10f64.powf(log_k);
        let stops = Stops::of_ratio(-1.0, 1.0, k, ratio, J);
        let parameters = Parameters { inertia: J, viscous, coulomb, stiction: 1.2 * coulomb, stops: Some(stops) };
        let mut rotor = Rotor::<true>::new(&parameters, 10f64.powf(log_rate)).unwrap();
        rotor.place(angle, speed).unwrap();
        // Placed behind a stop but faster away than it: its spring holds nothing of the knob's then.
        let mut last = rotor.energy();
        for _ in 0..300 {
            let was_free = rotor.pushes() == 0.0;
            rotor.step(0.0);
            let now = rotor.energy();
            prop_assert!(now.is_finite());
            if !was_free || rotor.angle().abs() < 1.0 {
                prop_assert!(now <= last * (1.0 + 1e-12) + 1e-25, "{last} {now}");
            }
            last = now;
        }
    }

    #[test]
    fn a_step_is_two_of_half_of_it(
        log_k in -1.0f64..2.6, ratio in 0.0f64..3.0, viscous in 0.0f64..1e-3, coulomb in 0.0f64..5e-3,
        angle in -0.02f64..0.02, speed in -20.0f64..20.0, torque in -0.02f64..0.02,
    ) {
        let stops = Stops::of_ratio(-0.01, 0.01, 10f64.powf(log_k), ratio, J);
        let parameters = Parameters { inertia: J, viscous, coulomb, stiction: 1.2 * coulomb, stops: Some(stops) };
        let mut whole = Rotor::<true>::new(&parameters, 2e3).unwrap();
        let mut halves = Rotor::<true>::new(&parameters, 4e3).unwrap();
        whole.place(angle, speed).unwrap();
        halves.place(angle, speed).unwrap();
        for n in 0..40 {
            let torque = torque * f64::from(n % 7 - 3);
            whole.step(torque);
            halves.step(torque);
            halves.step(torque);
            if whole.counts().crowded + halves.counts().crowded > 0 {
                break;
            }
            // The motion itself may be sensitive: a contact met at a graze. So each step starts from the same place.
            let scale = 20.0f64.max(whole.speed().abs());
            prop_assert!((whole.speed() - halves.speed()).abs() < 1e-12 * scale, "{n}: {} {}", whole.speed(), halves.speed());
            prop_assert!((whole.angle() - halves.angle()).abs() < 1e-12, "{n}");
            halves.place(whole.angle(), whole.speed()).unwrap();
            whole.place(halves.angle(), halves.speed()).unwrap();
        }
    }

    #[test]
    fn it_is_the_same_mirrored(
        k in 0.1f64..500.0, ratio in 0.0f64..3.0, coulomb in 0.0f64..5e-3,
        angle in -0.02f64..0.02, speed in -20.0f64..20.0, torque in -0.02f64..0.02,
    ) {
        let stops = Stops::of_ratio(-0.01, 0.01, k, ratio, J);
        let parameters = Parameters { coulomb, stiction: coulomb, stops: Some(stops), ..Parameters::default() };
        let [mut one, mut other] = [1.0, -1.0].map(|sign| {
            let mut rotor = Rotor::<true>::new(&parameters, 2e3).unwrap();
            rotor.place(sign * angle, sign * speed).unwrap();
            rotor
        });
        for n in 0..100 {
            let torque = torque * f64::from(n % 5 - 2);
            one.step(torque);
            other.step(-torque);
            prop_assert!(one.angle() == -other.angle() && one.speed() == -other.speed());
        }
    }

    #[test]
    fn a_hand_weaker_than_stiction_moves_nothing(torque in -1e-3f64..1e-3, rate in 1.0f64..2e5, coulomb in 0.0f64..1e-3) {
        let parameters = Parameters { coulomb, stiction: 1e-3, ..Parameters::default() };
        let mut rotor = Rotor::<false>::new(&parameters, rate).unwrap();
        rotor.place(0.4, 0.0).unwrap();
        (0..50).for_each(|_| rotor.step(torque));
        prop_assert!(rotor.angle() == 0.4 && rotor.speed() == 0.0);
    }

    #[test]
    fn nothing_finite_makes_it_panic_or_lose_its_number(
        exponents in proptest::array::uniform7(-1.0f64..1.0), torques in proptest::collection::vec(any::<f64>(), 1..20),
    ) {
        let power = |n: usize, low: f64, high: f64| 10f64.powf(low + (high - low) * 0.5 * (exponents[n] + 1.0));
        let coulomb = power(2, -9.0, 3.0);
        let stops = Stops { low: -0.1, high: 0.1, stiffness: power(3, -6.0, 9.0), damping: power(4, -9.0, 6.0) };
        let parameters = Parameters {
            inertia: power(0, -12.0, 3.0), viscous: power(1, -9.0, 3.0), coulomb, stiction: coulomb, stops: Some(stops),
        };
        let mut rotor = Rotor::<true>::new(&parameters, power(5, 0.0, 8.0)).unwrap();
        rotor.place(0.2 * exponents[6], 1e3 * exponents[6]).unwrap();
        for torque in torques {
            rotor.step(torque);
            prop_assert!(rotor.angle().is_finite() && rotor.speed().is_finite());
            rotor.step(torque % 1.0);
            prop_assert!(rotor.angle().is_finite() && rotor.speed().is_finite() && rotor.pushes().is_finite());
        }
    }
}
