use super::super::limits::Limits;
use super::super::lra::tests::sheet;
use super::super::model::Model;
use super::super::parameters::tests::{inertial, tactor};
use super::super::parameters::{Coil, Inertial, Spring, VoiceCoil};
use super::super::plant::Plant;
use super::super::resonance::Resonance;
use super::{Equaliser, Limited, Motion, Wish};
use crate::actuator::drive::Drive;
use crate::dsp::complex::Complex;

fn wish(motion: Motion, hertz: f64, q: f64) -> Wish {
    Wish {
        motion,
        target: Resonance { hertz, q },
        band: [20.0, 1000.0],
        level: 1.0,
        most_change: 12.0,
        limits: Limits::default(),
    }
}

fn motor() -> Plant {
    Plant::inertial(&Inertial { coil: Coil { inductance: 0.0, ..inertial().coil }, ..inertial() }).unwrap()
}

fn skin() -> Plant {
    Plant::voice_coil(&VoiceCoil { coil: Coil { inductance: 0.0, ..tactor().coil }, ..tactor() }).unwrap()
}

fn second_order(r: Resonance, hertz: f64) -> Complex {
    let s = Complex::oscillation(hertz);
    s * s + s * (r.omega() / r.q) + r.omega() * r.omega()
}

/// Where nothing limits it, what remains is the target and nothing else.
#[test]
fn the_rest_is_the_target() {
    let plant = motor();
    let wanted = wish(Motion::Acceleration, 40.0, 0.7);
    let e = Equaliser::design(&plant, Drive::Voltage, &wanted).unwrap();
    assert_eq!((e.poles, e.gain, e.limited), (wanted.target, 1.0, None));
    let bl = 1.5 / 6.0 / 0.1;
    for hertz in [20.0, 41.0, 58.0, 300.0, 1000.0] {
        let s = Complex::oscillation(hertz);
        let rest = plant.per_volt(hertz).casing * e.response(hertz);
        let target = -(s * s * bl / second_order(wanted.target, hertz));
        assert!((rest - target).abs() < 1e-10 * target.abs(), "{hertz}: {rest:?} {target:?}");
    }
    let plant = skin();
    let wanted = wish(Motion::Displacement, 400.0, 0.7);
    let e = Equaliser::design(&plant, Drive::Voltage, &wanted).unwrap();
    assert_eq!(e.limited, None);
    let still = 1.2 / 7.0 / 4332.7;
    for hertz in [20.0, 250.0, 1000.0] {
        let rest = plant.per_volt(hertz).displacement * e.response(hertz);
        let omega = wanted.target.omega();
        let target = Complex::new(still * omega * omega, 0.0) / second_order(wanted.target, hertz);
        assert!((rest - target).abs() < 1e-10 * target.abs(), "{hertz}");
    }
}

/// Each limit alone stops the poles where it is just met, and is named.
#[test]
fn limits_are_met_and_named() {
    let plant = motor();
    let free = wish(Motion::Acceleration, 20.0, 0.7);
    let unlimited = Equaliser::design(&plant, Drive::Voltage, &Wish { most_change: 60.0, ..free }).unwrap();
    assert_eq!(unlimited.limited, None);
    let peak = |e: &Equaliser, of: &dyn Fn(f64) -> f64| {
        (0..4000)
            .map(|n| 20.0 * 50f64.powf(f64::from(n) / 3999.0))
            .map(|f| of(f) * e.response(f).abs())
            .fold(0.0, f64::max)
    };
    let current = |f: f64| plant.per_volt(f).current.abs();
    let stroke = |f: f64| plant.per_volt(f).displacement.abs();
    let one = |_: f64| 1.0;
    let base = Wish { most_change: 60.0, ..free };
    let none = Limits::default();
    for (wish, limited, of, limit) in [
        (
            Wish { most_change: 9.0, ..free },
            Limited::Boost,
            &one as &dyn Fn(f64) -> f64,
            10f64.powf(9.0 / 20.0),
        ),
        (Wish { limits: Limits { volts: Some(3.0), ..none }, ..base }, Limited::Volts, &one, 3.0),
        (Wish { limits: Limits { amperes: Some(0.4), ..none }, ..base }, Limited::Amperes, &current, 0.4),
        (
            Wish { limits: Limits { amperes_rms: Some(0.3), ..none }, ..base },
            Limited::Heat,
            &current,
            0.3 * std::f64::consts::SQRT_2,
        ),
        (Wish { limits: Limits { stroke: Some(5e-4), ..none }, ..base }, Limited::Stroke, &stroke, 5e-4),
    ] {
        assert!(peak(&unlimited, of) > limit, "{limited:?}: {}", peak(&unlimited, of));
        let e = Equaliser::design(&plant, Drive::Voltage, &wish).unwrap();
        assert_eq!(e.limited, Some(limited));
        let met = peak(&e, of) / limit;
        assert!((met - 1.0).abs() < 1e-3, "{limited:?}: {met}");
        assert!(e.poles.hertz > 20.0 && e.poles.hertz < e.zeros.hertz && e.gain == 1.0, "{e:?}");
    }
}

/// Driven by a current, the resonance is sharper, and the volts that it takes are those of the current.
#[test]
fn a_current_drive_has_its_own_resonance() {
    let plant = Plant::inertial(&inertial()).unwrap();
    let limits = Limits { volts: Some(4.0), ..Limits::default() };
    let wanted = Wish { level: 0.2, limits, most_change: 40.0, ..wish(Motion::Acceleration, 25.0, 0.7) };
    let e = Equaliser::design(&plant, Drive::Current, &wanted).unwrap();
    assert_eq!((e.limited, e.zeros), (Some(Limited::Volts), plant.resonance(Drive::Current).unwrap()));
    assert!(e.zeros.q > 1.2 * plant.resonance(Drive::Voltage).unwrap().q);
    let volts = |hertz: f64| 0.2 * (e.response(hertz) * plant.per_ampere(hertz).impedance).abs();
    let most = (0..2000).map(|n| volts(20.0 * 50f64.powf(f64::from(n) / 1999.0))).fold(0.0, f64::max);
    assert!((most / 4.0 - 1.0).abs() < 1e-3, "{most}");
}

/// Where not even the actuator as it is keeps to a limit, gain is taken away.
#[test]
fn what_is_too_much_is_made_less() {
    let plant = motor();
    let limits = Limits { volts: Some(0.5), ..Limits::default() };
    let e =
        Equaliser::design(&plant, Drive::Voltage, &Wish { limits, ..wish(Motion::Acceleration, 30.0, 0.7) })
            .unwrap();
    assert_eq!(e.limited, Some(Limited::Volts));
    assert!(e.gain < 0.51 && e.boost <= 20.0 * 0.5f64.log10() + 1e-9, "{e:?}");
    assert_eq!(e.poles.hertz, e.zeros.hertz);
}

/// With the resonance 20 % and the quality 30 % off: neither boost nor cut goes beyond what was allowed, the boosted output
/// stays within the allowed change and what an untouched resonance does, and without a mismatch it is better than that by far.
#[test]
fn a_resonance_that_moved_stays_capped() {
    let lra = sheet().actuator().unwrap();
    let plants = [
        (motor(), Motion::Acceleration, 30.0),
        (skin(), Motion::Displacement, 500.0),
        (Plant::inertial(&lra).unwrap(), Motion::Acceleration, 100.0),
    ];
    for (plant, motion, target) in plants {
        let wanted = wish(motion, target, 0.7);
        let e = Equaliser::design(&plant, Drive::Voltage, &wanted).unwrap();
        let own = plant.resonance(Drive::Voltage).unwrap();
        for shift in [0.8, 1.0, 1.2] {
            for quality in [0.7, 1.0, 1.3] {
                let moved = Resonance { hertz: own.hertz * shift, q: own.q * quality };
                let (mut most, mut alone, mut gain) = (0.0f64, 0.0f64, [f64::MAX, 0.0f64]);
                for n in 0..2000 {
                    let hertz = 20.0 * 50f64.powf(f64::from(n) / 1999.0);
                    // The plant's own shape with its pole pair exchanged for the one that moved.
                    let even = match motion {
                        Motion::Acceleration => -(std::f64::consts::TAU * hertz).powi(2),
                        Motion::Displacement => moved.omega().powi(2),
                    };
                    let answer = (Complex::new(even, 0.0) / second_order(moved, hertz)).abs();
                    let h = e.response(hertz).abs();
                    gain = [gain[0].min(h), gain[1].max(h)];
                    most = most.max(answer * h);
                    alone = alone.max(answer);
                }
                let cap = 10f64.powf(12.0 / 20.0);
                assert!(gain[1] <= cap * 1.0001 && gain[0] >= 0.998 / cap, "{gain:?}");
                assert!(most <= cap * alone.max(1.0), "{shift} {quality}: {most} {alone}");
                if shift == 1.0 && quality == 1.0 && !e.cut_held {
                    assert!(most < 1.02, "{most}");
                }
            }
        }
    }
}

#[test]
fn a_narrow_resonance_is_cut_only_as_far_as_allowed() {
    let plant = Plant::inertial(&sheet().actuator().unwrap()).unwrap();
    let wanted = wish(Motion::Acceleration, 175.0, 0.7);
    let e = Equaliser::design(&plant, Drive::Voltage, &wanted).unwrap();
    assert_eq!((e.limited, e.cut_held), (Some(Limited::Cut), true));
    let cut = (0..10_000)
        .map(|n| 90.0 + 0.02 * f64::from(n))
        .map(|hertz| 20.0 * e.response(hertz).abs().log10())
        .fold(0.0, f64::min);
    assert!((cut + 12.0).abs() < 0.01, "{cut}");
}

/// Behind a hold the resonance is gone without a rest: from an impulse nothing swings on but the target.
#[test]
fn its_zeros_are_the_poles_of_the_held_actuator() {
    for (plant, motion, hertz) in
        [(skin(), Motion::Displacement, 500.0), (motor(), Motion::Acceleration, 30.0)]
    {
        for rate in [1000.0, 8000.0, 48_000.0] {
            let e = Equaliser::design(&plant, Drive::Voltage, &wish(motion, hertz, 0.7)).unwrap();
            let (b, a) = e.section(rate);
            let mut model = Model::new(&plant, rate, Drive::Voltage).unwrap();
            let (mut x, mut v, mut y) = ([0.0; 3], [0.0; 3], [0.0; 3]);
            let (mut peak, mut rest) = (0.0f64, 0.0f64);
            for n in 0..400 {
                x = [if n == 0 { 1.0 } else { 0.0 }, x[0], x[1]];
                let drive = b[0] * x[0] + b[1] * x[1] + b[2] * x[2] - a[0] * v[0] - a[1] * v[1];
                v = [drive, v[0], v[1]];
                y = [model.step(drive).displacement, y[0], y[1]];
                peak = peak.max(y[0].abs());
                if n > 3 {
                    rest = rest.max((y[0] + a[0] * y[1] + a[1] * y[2]).abs());
                }
            }
            assert!(rest < 1e-12 * peak, "{motion:?} {rate}: {rest:e} of {peak:e}");
        }
    }
}

#[test]
fn the_section_is_near_the_analog_form() {
    let (skin, motor) = (skin(), motor());
    for (plant, motion, hertz) in [
        (skin, Motion::Displacement, 400.0),
        (skin, Motion::Displacement, 700.0),
        (motor, Motion::Acceleration, 40.0),
    ] {
        for (rate, decibels, degrees) in [(8000.0, 2e-3, 2.5), (48_000.0, 1e-4, 0.1)] {
            let e = Equaliser::design(&plant, Drive::Voltage, &wish(motion, hertz, 0.7)).unwrap();
            let (b, a) = e.section(rate);
            for n in 0..100 {
                let hertz = 20.0 * 50f64.powf(f64::from(n) / 99.0);
                let z = Complex::turned(-std::f64::consts::TAU * hertz / rate);
                let is = (z * (z * b[2] + b[1]) + b[0]) / (z * (z * a[1] + a[0]) + 1.0);
                let apart = is / e.response(hertz);
                assert!(
                    (20.0 * apart.abs().log10()).abs() < decibels,
                    "{motion:?} {rate} {hertz}: {}",
                    apart.abs()
                );
                assert!(
                    apart.angle().to_degrees().abs() < degrees,
                    "{motion:?} {rate} {hertz}: {}",
                    apart.angle()
                );
            }
        }
    }
}

#[test]
fn wishes_that_cannot_be_are_refused() {
    let plant = motor();
    let sound = wish(Motion::Acceleration, 30.0, 0.7);
    let fault = |w: Wish| Equaliser::design(&plant, Drive::Voltage, &w).unwrap_err().field;
    assert_eq!(fault(Wish { target: Resonance { hertz: 0.0, q: 1.0 }, ..sound }), "target.hertz");
    assert_eq!(fault(Wish { target: Resonance { hertz: 1.0, q: -1.0 }, ..sound }), "target.q");
    assert_eq!(fault(Wish { band: [100.0, 100.0], ..sound }), "band.high");
    assert_eq!(fault(Wish { level: f64::NAN, ..sound }), "level");
    assert_eq!(fault(Wish { most_change: 0.0, ..sound }), "most_change");
    assert_eq!(fault(Wish { limits: Limits { volts: Some(0.0), ..Limits::default() }, ..sound }), "volts");
    let floating = Inertial { suspension: Spring::default(), ..inertial() };
    let plant = Plant::inertial(&floating).unwrap();
    assert_eq!(Equaliser::design(&plant, Drive::Voltage, &sound).unwrap_err().field, "stiffness");
}
