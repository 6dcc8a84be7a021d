use super::super::energy::Ledger;
use super::super::parameters::tests::{held, inertial, layered, tactor};
use super::super::parameters::{Coil, Inertial, Skin, Spring, Tissue, VoiceCoil};
use super::super::plant::Plant;
use super::{Model, State};
use crate::actuator::drive::Drive;
use crate::dsp::complex::Complex;

fn plants() -> [Plant; 4] {
    let tactor_of = |v| Plant::voice_coil(&v).unwrap();
    [
        tactor_of(tactor()),
        tactor_of(layered()),
        Plant::inertial(&inertial()).unwrap(),
        Plant::inertial(&held()).unwrap(),
    ]
}

/// The static answer to a held volt follows from the springs alone, and every motion from displacements.
#[test]
fn it_comes_to_rest_where_the_springs_say() {
    for (plant, stiffness) in
        plants().iter().zip([4332.7, 4332.7 + 1.0 / (1.0 / 700.0 + 1.0 / 300.0), 741.0, 741.0])
    {
        let mut model = Model::new(plant, 48_000.0, Drive::Voltage).unwrap();
        let mut outputs = model.outputs();
        for _ in 0..96_000 {
            outputs = model.step(2.0);
        }
        let coil = plant.coil();
        let rest = 2.0 / coil.resistance * coil.force_factor / stiffness;
        assert!((outputs.displacement / rest - 1.0).abs() < 1e-10, "{outputs:?} {rest}");
        assert!(
            outputs.velocity.abs() < 1e-12
                && outputs.acceleration.abs() < 1e-8
                && outputs.casing.abs() < 1e-8
        );
        assert!((outputs.current - 2.0 / coil.resistance).abs() < 1e-12 && outputs.voltage == 2.0);
    }
}

/// A mass on the casing is more casing, and feels the force that moves it.
#[test]
fn a_mass_in_the_hand_is_more_casing() {
    let hand = Tissue { mass: 0.02, ..Tissue::default() };
    let loaded = Plant::inertial(&Inertial { hand, ..inertial() }).unwrap();
    let mounted = Plant::inertial(&Inertial { casing_mass: 0.12, ..inertial() }).unwrap();
    let mut loaded = Model::new(&loaded, 8000.0, Drive::Voltage).unwrap();
    let mut mounted = Model::new(&mounted, 8000.0, Drive::Voltage).unwrap();
    for n in 0..200 {
        let u = if n < 50 { 1.0 } else { -0.5 };
        let (a, b) = (loaded.step(u), mounted.step(u));
        assert!(
            (a.casing - b.casing).abs() < 1e-12 && (a.force - 0.02 * b.casing).abs() < 1e-12,
            "{a:?} {b:?}"
        );
        assert_eq!(b.force, 0.0);
    }
}

/// Twice the rate with every value held twice is the same motion: steps are exact.
#[test]
fn it_does_not_matter_how_fine_the_steps_are() {
    for plant in plants() {
        for drive in [Drive::Voltage, Drive::Current] {
            let mut coarse = Model::new(&plant, 1_000.0, drive).unwrap();
            let mut fine = Model::new(&plant, 192_000.0, drive).unwrap();
            let mut noise = 1u64;
            let (mut apart, mut size): (f64, f64) = (0.0, 0.0);
            for _ in 0..300 {
                noise = noise.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                let u = (noise >> 40) as f64 / 8_388_608.0 - 1.0;
                let a = coarse.step(u);
                let b = (0..192).fold(a, |_, _| fine.step(u));
                for (a, b) in [(a.displacement, b.displacement), (a.casing / 1e7, b.casing / 1e7)] {
                    apart = apart.max((a - b).abs());
                    size = size.max(a.abs());
                }
            }
            assert!(apart < 1e-12 * size, "{apart:e} of {size:e}");
        }
    }
}

/// The response of the continuous system under a hold, as sampled: the sum over all images n of H(ω + n ω_s) times the hold's
/// (1 − e^(−jωT)) / (j (ω + n ω_s) T). In pairs the images fall at least as n⁻², and what is left of
/// such a series after N is its last term times N² / (N + ½).
fn hold_corrected(hertz: f64, rate: f64, response: impl Fn(f64) -> Complex) -> Complex {
    let hold = Complex::new(1.0, 0.0) - Complex::turned(-std::f64::consts::TAU * hertz / rate);
    let image = |n: i32| {
        let at = hertz + f64::from(n) * rate;
        // H(−ω) is the conjugate of H(ω).
        let h = response(at.abs());
        let h = if at < 0.0 { Complex::new(h.re, -h.im) } else { h };
        h * hold / (Complex::oscillation(at) * (1.0 / rate))
    };
    let last = 4000;
    let rest = (image(last) + image(-last)) * (f64::from(last).powi(2) / (f64::from(last) + 0.5));
    (1..=last).fold(image(0) + rest, |sum, n| sum + (image(n) + image(-n)))
}

/// What comes out at a frequency, once everything else has died away.
fn measured(model: &mut Model, hertz: f64, rate: f64, of: fn(&super::Outputs) -> f64) -> Complex {
    let turn = std::f64::consts::TAU * hertz / rate;
    let count = (rate / 10.0) as u32;
    let mut sum = Complex::default();
    for n in 0..31 * count {
        let phase = turn * f64::from(n % count);
        let y = of(&model.outputs());
        if n >= 30 * count {
            sum = sum + Complex::turned(-phase) * y * (2.0 / f64::from(count));
        }
        model.advance(phase.cos());
    }
    sum
}

#[test]
fn its_response_is_that_of_the_plant_under_a_hold() {
    for plant in plants() {
        for (rate, frequencies) in
            [(48_000.0, [10.0, 160.0, 250.0, 1000.0]), (1_000.0, [10.0, 60.0, 250.0, 490.0])]
        {
            for hertz in frequencies {
                let mut model = Model::new(&plant, rate, Drive::Voltage).unwrap();
                let is = measured(&mut model, hertz, rate, |o| o.displacement);
                let expected = hold_corrected(hertz, rate, |f| plant.per_volt(f).displacement);
                let apart = (is - expected).abs() / expected.abs();
                assert!(apart < 1e-9, "{hertz} {rate}: {apart:e}");
                let mut model = Model::new(&plant, rate, Drive::Current).unwrap();
                let is = measured(&mut model, hertz, rate, |o| o.velocity);
                let expected = hold_corrected(hertz, rate, |f| plant.per_ampere(f).velocity);
                let apart = (is - expected).abs() / expected.abs();
                assert!(apart < 1e-6, "{hertz} {rate}: {apart:e}");
            }
        }
    }
    // Force and casing, whose images fall more slowly.
    let (skin, hand) = (&plants()[1], &plants()[3]);
    for hertz in [10.0, 160.0, 1000.0] {
        let rate = 48_000.0;
        let mut model = Model::new(skin, rate, Drive::Voltage).unwrap();
        let is = measured(&mut model, hertz, rate, |o| o.force);
        let expected = hold_corrected(hertz, rate, |f| skin.per_volt(f).force);
        assert!((is - expected).abs() < 1e-6 * expected.abs(), "{hertz}");
        let mut model = Model::new(hand, rate, Drive::Voltage).unwrap();
        let is = measured(&mut model, hertz, rate, |o| o.casing);
        let expected = hold_corrected(hertz, rate, |f| hand.per_volt(f).casing);
        assert!((is - expected).abs() < 1e-6 * expected.abs(), "{hertz}");
    }
}

/// A vanishing inductance is none, for each output that is not the leap of the current itself.
#[test]
fn without_inductance_it_is_the_algebraic_model() {
    for (inductance, within) in [(1e-7, 1e-3), (1e-10, 1e-6), (1e-14, 1e-10), (1e-300, 1e-11)] {
        let coil = Coil { inductance, ..tactor().coil };
        let with = Plant::voice_coil(&VoiceCoil { coil, ..tactor() }).unwrap();
        let none = Coil { inductance: 0.0, ..coil };
        let without = Plant::voice_coil(&VoiceCoil { coil: none, ..tactor() }).unwrap();
        let mut a = Model::new(&with, 8000.0, Drive::Voltage).unwrap();
        let mut b = Model::new(&without, 8000.0, Drive::Voltage).unwrap();
        let mut most: f64 = 0.0;
        for n in 0..4000 {
            let u = (f64::from(n) * 0.2).sin();
            let (a, b) = (a.step(u), b.step(u));
            most = most.max(b.displacement.abs());
            assert!((a.displacement - b.displacement).abs() <= within * most, "{inductance}: {a:?} {b:?}");
            assert!((a.current - b.current).abs() <= within, "{inductance}: {a:?} {b:?}");
        }
    }
}

/// Over resonance, Q, inductance and rate: finite, no energy from nothing, and no more than there was.
#[test]
fn nothing_in_the_grid_gains_energy() {
    for rate in [1e3, 8e3, 44.1e3, 48e3, 192e3] {
        for resonance in [10.0, 230.0, 700.0, 5e3, 60e3, 3e5] {
            for q in [0.5, 3.0, 200.0] {
                for inductance in [0.0, 1e-9, 1e-4, 0.5] {
                    for resistance in [1e-3, 7.0, 1e12] {
                        let omega = std::f64::consts::TAU * resonance;
                        let suspension =
                            Spring { stiffness: 1.5e-3 * omega * omega, damping: 1.5e-3 * omega / q };
                        let coil = Coil { resistance, inductance, force_factor: 1.2 };
                        let bare = VoiceCoil { coil, suspension, skin: Skin::None, ..tactor() };
                        check_energy(&Plant::voice_coil(&bare).unwrap(), rate);
                    }
                }
            }
        }
    }
    for plant in plants() {
        for rate in [1e3, 44.1e3, 192e3] {
            check_energy(&plant, rate);
        }
    }
}

fn check_energy(plant: &Plant, rate: f64) {
    let mut model = Model::new(plant, rate, Drive::Voltage).unwrap();
    let mut ledger = Ledger::new(&model);
    let (mut lost, mut peak, mut noise) = (0.0, 0.0f64, 0.0);
    let coil = plant.coil();
    for n in 0..200 {
        let volts = if n < 100 { if n / 3 % 2 == 0 { 3.0 } else { -3.0 } } else { 0.0 };
        let outputs = ledger.step(&mut model, volts);
        peak = peak.max(ledger.stored).max(ledger.supplied.abs());
        let now = ledger.lost();
        // The charge is what is left of these three.
        let parts = volts * model.period()
            + coil.inductance * outputs.current
            + coil.force_factor * outputs.displacement;
        noise += 1e-15 * (volts * parts / coil.resistance).abs();
        let noise = noise + 1e-13 * peak;
        assert!(now >= lost - noise, "{plant:?} at {rate}: {lost:e} to {now:e} of {peak:e}");
        lost = now;
        assert!([outputs.displacement, outputs.acceleration, outputs.current].iter().all(|x| x.is_finite()));
    }
}

/// Without damping and open, an oscillation keeps its energy.
#[test]
fn what_is_not_damped_goes_on() {
    let suspension = Spring { stiffness: 3000.0, damping: 0.0 };
    let plant = Plant::voice_coil(&VoiceCoil { suspension, skin: Skin::None, ..tactor() }).unwrap();
    for rate in [100.0, 1_000.0, 48_000.0] {
        let mut model = Model::new(&plant, rate, Drive::Current).unwrap();
        model.set_state(&State { displacement: 1e-4, ..State::default() });
        let begin = model.energy();
        for _ in 0..100_000 {
            model.advance(0.0);
        }
        assert!((model.energy() / begin - 1.0).abs() < 1e-10, "{}", model.energy() / begin);
    }
}

/// The extremes of parameters: each is finite, and rests in the end if it is damped.
#[test]
fn extreme_parameters_stay_finite() {
    let coils = [1e-12, 1e-3, 1.0, 1e3, 1e15];
    for mass in [1e-12, 1e-3, 1e6] {
        for resistance in coils {
            for inductance in [0.0, 1e-30, 1e-6, 1e6] {
                for stiffness in [0.0, 1.0, 1e12] {
                    let coil = Coil { resistance, inductance, force_factor: 2.0 };
                    let suspension = Spring { stiffness, damping: 0.1 };
                    let motor = Inertial { coil, suspension, slug_mass: mass, ..held() };
                    let mut model =
                        Model::new(&Plant::inertial(&motor).unwrap(), 1000.0, Drive::Voltage).unwrap();
                    for n in 0..100 {
                        let o = model.step(if n % 2 == 0 { 1e3 } else { -1e3 });
                        let all = [o.displacement, o.velocity, o.acceleration, o.force, o.casing, o.current];
                        assert!(all.iter().all(|x| x.is_finite()), "{motor:?}: {o:?}");
                    }
                }
            }
        }
    }
}

#[test]
fn nonsense_is_masked_and_counted() {
    for plant in plants() {
        let mut model = Model::new(&plant, 48_000.0, Drive::Voltage).unwrap();
        let mut twin = model.clone();
        for (u, as_if) in [(1.0, 1.0), (f64::NAN, 0.0), (f64::INFINITY, 0.0), (-2.0, -2.0), (-1e300, 0.0)] {
            assert_eq!(model.step(u), twin.step(as_if));
        }
        assert_eq!((model.masked(), twin.masked()), (3, 0));
        model.set_state(&State { displacement: f64::NAN, ..State::default() });
        assert_eq!(model.state(), State::default());
    }
    assert_eq!(Model::new(&plants()[0], 0.0, Drive::Voltage).unwrap_err().field, "rate");
    assert_eq!(Model::new(&plants()[0], f64::NAN, Drive::Current).unwrap_err().field, "rate");
}

/// What has died away becomes exactly nothing.
#[test]
fn silence_becomes_zero() {
    for plant in plants() {
        let mut model = Model::new(&plant, 48_000.0, Drive::Voltage).unwrap();
        model.advance(1.0);
        (0..400_000).for_each(|_| model.advance(0.0));
        assert_eq!(model.state(), State::default());
    }
}
