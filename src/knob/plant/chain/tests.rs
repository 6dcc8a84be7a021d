use super::{Build, Chain, Drive, Hand};
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::parts::{Grasp, Shaft, Winding};
use crate::knob::plant::rotor::Rotor;
use crate::knob::plant::stops::Stops;
use crate::knob::plant::wave::{Harmonic, Wave};
use proptest::prelude::{ProptestConfig, any, prop_assert, proptest};

const FREE: Hand = Hand { torque: 0.0, target: 0.0, target_speed: 0.0 };

/// A small motor: 19 V, 577 µs, 19.7 mN m/A.
fn winding() -> Winding {
    Winding { resistance: 2.6, inductance: 1.5e-3, gain: 19.7e-3, supply: 19.0 }
}

fn shaft() -> Shaft {
    Shaft { inertia: 5e-6, viscous: 1e-6, stiffness: Shaft::stiffness_of(1e-6, 600.0), damping: 6e-5 }
}

/// Everything at once.
fn full() -> Build {
    Build {
        parameters: Parameters {
            inertia: 1e-6,
            viscous: 2e-6,
            coulomb: 1e-3,
            stiction: 1.3e-3,
            stops: Some(Stops { low: -0.4, high: 0.3, stiffness: 40.0, damping: 1e-3 }),
        },
        shaft: Some(shaft()),
        drive: Drive::Current { winding: winding(), bandwidth: 6e3, peak: 7.0 },
        grasp: Some(Grasp { stiffness: 0.3, damping: 2e-3 }),
        cogging: Wave::new(&[
            Harmonic { periods: 12.0, sine: 4e-4, cosine: 1e-4 },
            Harmonic { periods: 36.0, sine: 0.0, cosine: 2e-4 },
        ])
        .unwrap(),
        ripple: Wave::new(&[Harmonic { periods: 6.0, sine: 0.03, cosine: 0.0 }]).unwrap(),
    }
}

fn state(chain: &Chain) -> [f64; 5] {
    [chain.angle(), chain.knob_angle(), chain.speed(), chain.knob_speed(), chain.current()]
}

/// What looks random, within ±1.
fn mixed(n: u64) -> f64 {
    let n = (n ^ 0x5851_f42d_4c95_7f2d).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    let n = (n ^ (n >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    ((n ^ (n >> 32)) as i64) as f64 / 9_223_372_036_854_775_808.0
}

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

/// The current of a held rotor follows as of first order; beyond the supply it rises as the winding lets it.
#[test]
fn a_current_loop_has_its_bandwidth_and_its_supply() {
    let w = winding();
    let parameters = Parameters { coulomb: 1.0, stiction: 1.0, ..Parameters::default() };
    let bandwidth = 5e3;
    let drive = Drive::Current { winding: w, bandwidth, peak: 10.0 };
    let build = Build { parameters, drive, ..Build::default() };
    for rate in [1e3, 8e3, 48e3] {
        let mut chain = Chain::new(&build, rate).unwrap();
        for n in 1..(5e-3 * rate) as usize {
            chain.step(0.02, &FREE);
            let expected = 0.02 / w.gain * -(-bandwidth * n as f64 / rate).exp_m1();
            assert!((chain.current() - expected).abs() < 1e-13, "{rate} {n}: {} {expected}", chain.current());
        }
        // 6 A need 19 V for a while: the loop asks for 45 V at first.
        let mut chain = Chain::new(&build, rate).unwrap();
        let wish = 6.0;
        let kp = w.inductance * bandwidth;
        // i = I∞ (1 − e^{−t/τ}), K_i q = V (1 − e^{−t/τ}) with I∞ = V/R: it leaves the limit where K_p (i* − i) + K_i q = V.
        let most = w.supply / w.resistance;
        // Kp i* − Kp I∞ g + V g = V with g = 1 − e^{−t/τ}: g = (V − Kp i*) / (V − Kp I∞).
        let g = (w.supply - kp * wish) / (w.supply - kp * most);
        let leaves = -(w.inductance / w.resistance) * (-g).ln_1p();
        for n in 1..(5e-3 * rate) as usize {
            chain.step(wish * w.gain, &FREE);
            let t = n as f64 / rate;
            assert!(chain.voltage().abs() <= w.supply);
            if t < leaves {
                let expected = most * -(-t * w.resistance / w.inductance).exp_m1();
                assert!((chain.current() - expected).abs() < 1e-12, "{rate} {n}");
            } else {
                let at = most * g;
                // With K_i q = R i, as the winding's own time constant leaves it, what is missing decays with ω_i alone.
                let (e0, v0) = (wish - at, w.supply * g - w.resistance * at);
                let a = bandwidth;
                assert!(v0.abs() < 1e-12);
                let expected = wish - e0 * (-a * (t - leaves)).exp();
                assert!((chain.current() - expected).abs() < 1e-11, "{rate} {n}");
            }
        }
        assert!(chain.counts().events >= 1);
    }
}

/// A voltage on a winding that turns: against small steps of Runge and Kutta.
#[test]
fn a_voltage_turns_it_as_the_equations_say() {
    let build = Build { drive: Drive::Voltage(winding()), ..Build::default() };
    let mut chain = Chain::new(&build, 1e3).unwrap();
    let (w, p) = (winding(), Parameters::default());
    let slope = |x: [f64; 3]| {
        [
            x[1],
            (w.gain * x[2] - p.viscous * x[1]) / p.inertia,
            (12.0 - w.resistance * x[2] - w.gain * x[1]) / w.inductance,
        ]
    };
    let (mut x, h) = ([0.0f64; 3], 1e-6);
    for n in 0..20_000 {
        let plus = |k: [f64; 3], f: f64| [0, 1, 2].map(|i| x[i] + f * k[i]);
        let k1 = slope(x);
        let k2 = slope(plus(k1, 0.5 * h));
        let k3 = slope(plus(k2, 0.5 * h));
        let k4 = slope(plus(k3, h));
        x = [0, 1, 2].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        if n % 1000 == 0 {
            chain.step(12.0, &FREE);
        }
    }
    assert!((chain.angle() - x[0]).abs() < 1e-11 && (chain.current() - x[2]).abs() < 1e-10, "{x:?}");
    // Beyond the supply there is no more.
    let mut one = Chain::new(&build, 1e3).unwrap();
    let mut other = one.clone();
    one.step(19.0, &FREE);
    other.step(500.0, &FREE);
    assert_eq!(state(&one), state(&other));
}

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

/// Ripple on a torque is a torque over the angle.
#[test]
fn ripple_is_a_share_of_the_torque() {
    let wave =
        |size: f64| Wave::new(&[Harmonic { periods: 6.0, sine: 0.3 * size, cosine: 0.1 * size }]).unwrap();
    let mut rippled = Chain::new(&Build { ripple: wave(1.0), ..Build::default() }, 1e3).unwrap();
    let mut cogged = Chain::new(&Build { cogging: wave(2e-3), ..Build::default() }, 1e3).unwrap();
    for _ in 0..100 {
        rippled.step(2e-3, &FREE);
        cogged.step(2e-3, &FREE);
    }
    assert!((rippled.angle() - cogged.angle()).abs() < 1e-12 && rippled.speed() > 1.0);
}

/// Of a winding, torque and the voltage of the speed both: against small steps of Runge and Kutta.
#[test]
fn ripple_acts_on_torque_and_voltage_alike() {
    let ripple = Wave::new(&[Harmonic { periods: 6.0, sine: 0.3, cosine: 0.1 }]).unwrap();
    let build = Build {
        drive: Drive::Voltage(winding()),
        ripple,
        cogging: Wave::detent(1e-3, 24.0).unwrap(),
        ..Build::default()
    };
    let mut chain = Chain::new(&build, 1e3).unwrap();
    let (w, p) = (winding(), Parameters::default());
    let slope = |x: [f64; 3]| {
        let gain = w.gain * (1.0 + 0.3 * (6.0 * x[0]).sin() + 0.1 * (6.0 * x[0]).cos());
        let torque = gain * x[2] - p.viscous * x[1] - 1e-3 * (24.0 * x[0]).sin();
        [x[1], torque / p.inertia, (3.0 - w.resistance * x[2] - gain * x[1]) / w.inductance]
    };
    let (mut x, h) = ([0.0f64; 3], 2e-6);
    for n in 0..20_000 {
        let plus = |k: [f64; 3], f: f64| [0, 1, 2].map(|i| x[i] + f * k[i]);
        let k1 = slope(x);
        let k2 = slope(plus(k1, 0.5 * h));
        let k3 = slope(plus(k2, 0.5 * h));
        let k4 = slope(plus(k3, h));
        x = [0, 1, 2].map(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        if n % 500 == 0 {
            chain.step(3.0, &FREE);
        }
    }
    assert!((chain.angle() - x[0]).abs() < 1e-10, "{} {x:?}", chain.angle());
    assert!((chain.current() - x[2]).abs() < 1e-9, "{} {x:?}", chain.current());
    assert!(x[0] > 1.0);
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
fn nothing_makes_energy_by_itself() {
    for (n, rate) in [500.0, 1e3, 8e3, 48e3].into_iter().enumerate() {
        for waved in [false, true] {
            let build = Build {
                drive: Drive::Torque,
                grasp: None,
                ripple: Wave::default(),
                cogging: if waved { full().cogging } else { Wave::default() },
                ..full()
            };
            for start in 0..6 {
                let mut chain = Chain::new(&build, rate).unwrap();
                chain.place(0.25 * mixed(start), 60.0 * mixed(start + 10 * n as u64)).unwrap();
                let mut last = chain.energy();
                for _ in 0..(0.1 * rate) as usize {
                    chain.step(0.0, &FREE);
                    let now = chain.energy();
                    // A wall that is left with a dent keeps no energy of the knob's; one that is met again has none to give.
                    if chain.contact == super::Contact::Away {
                        assert!(now <= last + 1e-12 * last.abs() + 1e-18, "{rate} {waved}: {last} {now}");
                        last = now;
                    }
                }
                assert_eq!(chain.counts().crowded, 0);
            }
        }
    }
}

#[test]
fn a_detent_without_friction_keeps_its_energy() {
    let parameters = Parameters { viscous: 0.0, ..Parameters::default() };
    let build = Build { parameters, cogging: Wave::detent(8e-3, 24.0).unwrap(), ..Build::default() };
    for rate in [200.0, 1e3, 48e3] {
        let mut chain = Chain::new(&build, rate).unwrap();
        chain.place(0.02, 9.0).unwrap();
        let before = chain.energy();
        (0..(2.0 * rate) as usize).for_each(|_| chain.step(0.0, &FREE));
        assert!((chain.energy() / before - 1.0).abs() < 1e-11, "{rate}: {}", chain.energy() / before);
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

#[test]
fn what_is_no_number_is_none_and_counted() {
    let mut chain = Chain::new(&full(), 1e3).unwrap();
    let wild = [f64::NAN, f64::INFINITY, -1e300];
    for value in wild {
        chain.step(value, &Hand { torque: value, target: value, target_speed: value });
        assert!(state(&chain).iter().all(|x| *x == 0.0), "{:?}", state(&chain));
    }
    assert_eq!(chain.counts().masked, 9);
}

#[test]
fn what_cannot_be_is_named() {
    let w = winding();
    for (build, field) in [
        (Build { shaft: Some(Shaft { inertia: 0.0, ..shaft() }), ..full() }, "shaft inertia"),
        (Build { shaft: Some(Shaft { stiffness: f64::NAN, ..shaft() }), ..full() }, "shaft stiffness"),
        (Build { drive: Drive::Voltage(Winding { inductance: 0.0, ..w }), ..full() }, "inductance"),
        (Build { drive: Drive::Voltage(Winding { resistance: -1.0, ..w }), ..full() }, "resistance"),
        (Build { drive: Drive::Current { winding: w, bandwidth: 0.0, peak: 1.0 }, ..full() }, "bandwidth"),
        (Build { drive: Drive::Current { winding: w, bandwidth: 1e3, peak: 0.0 }, ..full() }, "peak"),
        (Build { grasp: Some(Grasp { stiffness: -1.0, damping: 0.0 }), ..full() }, "grasp stiffness"),
        (Build { parameters: Parameters { inertia: -1.0, ..full().parameters }, ..full() }, "inertia"),
    ] {
        assert_eq!(Chain::new(&build, 1e3).unwrap_err().field, field);
    }
    let stiff = Build { shaft: Some(Shaft { stiffness: 1e9, ..shaft() }), ..full() };
    let fault = Chain::new(&stiff, 1.0).unwrap_err();
    assert_eq!(fault.field, "rate");
    assert!(fault.because.is_some());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    #[test]
    fn nothing_finite_makes_it_panic_or_lose_its_number(
        e in proptest::array::uniform14(0.0f64..1.0), torques in proptest::collection::vec(any::<f64>(), 1..12),
        kind in 0..3, parts in 0..8,
    ) {
        let power = |n: usize, low: f64, high: f64| 10f64.powf(low + (high - low) * e[n]);
        let coulomb = power(2, -9.0, 1.0);
        let w = Winding {
            resistance: power(6, -3.0, 3.0), inductance: power(7, -7.0, 1.0), gain: power(8, -6.0, 1.0), supply: power(9, -2.0, 3.0),
        };
        let build = Build {
            parameters: Parameters {
                inertia: power(0, -9.0, 0.0), viscous: power(1, -9.0, 0.0), coulomb, stiction: coulomb * 1.5,
                stops: Some(Stops { low: -0.1, high: 0.1, stiffness: power(3, -3.0, 4.0), damping: power(4, -9.0, 1.0) }),
            },
            shaft: (parts & 1 > 0).then(|| Shaft {
                inertia: power(10, -9.0, 0.0), viscous: 0.0, stiffness: power(11, -3.0, 4.0), damping: power(12, -9.0, 0.0),
            }),
            grasp: (parts & 2 > 0).then(|| Grasp { stiffness: power(13, -3.0, 3.0), damping: 1e-3 }),
            drive: match kind {
                0 => Drive::Torque,
                1 => Drive::Voltage(w),
                _ => Drive::Current { winding: w, bandwidth: power(5, 1.0, 5.0), peak: 10.0 },
            },
            cogging: if parts & 4 > 0 { full().cogging } else { Wave::default() },
            ripple: if parts & 4 > 0 { full().ripple } else { Wave::default() },
        };
        let Ok(mut chain) = Chain::new(&build, power(5, 2.5, 6.0)) else { return Ok(()) };
        chain.place(0.2 * (e[5] - 0.5), 1e3 * (e[6] - 0.5)).unwrap();
        for torque in torques {
            chain.step(torque, &Hand { torque, target: torque, target_speed: 0.0 });
            chain.step(torque % 1.0, &Hand { torque: torque % 0.1, target: torque % 0.2, target_speed: 0.1 });
            prop_assert!(state(&chain).iter().all(|x| x.is_finite()) && chain.voltage().is_finite(), "{:?}", state(&chain));
        }
    }
}
