//! Winding, current loop, ripple.

use super::super::{Build, Chain, Drive};
use super::{FREE, state, winding};
use crate::knob::plant::parameters::Parameters;
use crate::knob::plant::wave::{Harmonic, Wave};

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
