use super::Motion;
use crate::actuator::coil::model::Model;
use crate::actuator::coil::parameters::tests::{held, inertial, layered, tactor};
use crate::actuator::coil::parameters::{Coil, Inertial, Skin, Spring, Tissue, VoiceCoil};
use crate::actuator::coil::plant::Plant;
use crate::actuator::coil::sampled::Sampled;
use crate::actuator::drive::Drive;

/// Fine steps within a sample.
const FINE: usize = 16;
const STROKE: f64 = 4e-4;

/// A bare tactor with a pole pair, and metres for each steady volt.
fn tuned(hertz: f64, q: f64) -> (Plant, f64) {
    let omega = std::f64::consts::TAU * hertz;
    let coil = Coil { resistance: 6.0, inductance: 0.0, force_factor: 0.3 };
    let (mass, by_coil) = (2e-3, 0.3 * 0.3 / 6.0);
    // Few mechanics have so little damping that the coil's is too much: it gets weaker then.
    let total = mass * omega / q;
    let weaker = (0.5 * total / by_coil).sqrt().min(1.0);
    let coil = Coil { force_factor: coil.force_factor * weaker, ..coil };
    let damping = total - by_coil * weaker * weaker;
    let suspension = Spring { stiffness: mass * omega * omega, damping };
    let plant = Plant::voice_coil(&VoiceCoil { coil, mass, suspension, skin: Skin::None }).unwrap();
    let is = plant.resonance(Drive::Voltage).unwrap();
    assert!((is.hertz / hertz - 1.0).abs() < 1e-9 && (is.q / q - 1.0).abs() < 1e-6);
    (plant, 0.3 * weaker / 6.0 / suspension.stiffness)
}

/// What is wanted of the model, which it may look at: at a sample, and at its frequency in turns a sample.
type Foe = fn(usize, f64, &Model, &mut u64) -> f64;

fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    ((*seed >> 11) as f64 / (1u64 << 52) as f64) - 1.0
}

const FOES: [(&str, Foe); 8] = [
    ("steady", |_, _, _, _| 1.0),
    ("square at the resonance", |n, f, _, _| if (n as f64 * f).fract() < 0.5 { 1.0 } else { -1.0 }),
    ("sine at the resonance", |n, f, _, _| (n as f64 * f * std::f64::consts::TAU).sin()),
    ("pumping", |_, _, m, _| m.state().velocity.signum()),
    ("outwards", |_, _, m, _| m.state().displacement.signum()),
    ("noise", |_, _, _, s| random(s)),
    (
        "noise of both signs, held",
        |n, f, _, s| {
            if n % (1 + (0.3 / f) as usize) == 0 { random(s) } else { 1.0 }
        },
    ),
    ("pumping, then outwards", |n, f, m, _| {
        let x = m.state();
        if (n as f64 * f) % 7.0 < 5.3 { x.velocity.signum() } else { x.displacement.signum() }
    }),
];

/// The farthest at samples and between them, of the stroke, of a model that a foe drives for so many periods.
fn farthest(
    plant: &Plant,
    motion: &mut Motion,
    foe: Foe,
    (rate, hertz, peak, slew): (f64, f64, f64, f64),
    periods: f64,
) -> [f64; 2] {
    let mut model = Model::new(plant, rate * FINE as f64, Drive::Voltage).unwrap();
    let (mut last, mut seed, mut worst) = (0.0f64, 7u64, [0.0f64; 2]);
    for n in 0..(periods * rate / hertz) as usize {
        let wanted = foe(n, hertz / rate, &model, &mut seed).clamp(-1.0, 1.0) * peak;
        let steep = last + (wanted - last).clamp(-slew, slew);
        let (_, left, _) = motion.step(last, steep, |v| (0.0, v));
        assert!(left.abs() <= peak * (1.0 + 1e-12), "the peak");
        assert!((left - last).abs() <= slew * (1.0 + 1e-12) + 1e-15 * peak, "the slew");
        let outside = left < steep.min(0.0f64.min(last)) || left > steep.max(0.0f64.max(last));
        assert!(!outside, "between the drive wanted and what is left of the last");
        last = left;
        for _ in 0..FINE {
            worst[1] = worst[1].max(model.step(left).displacement.abs() / STROKE);
        }
        worst[0] = worst[0].max(model.state().displacement.abs() / STROKE);
        // Its own model is the same.
        assert!((motion.displacement() - model.state().displacement).abs() < 1e-7 * STROKE);
    }
    worst
}

/// Q from 0.5 to 200, 8 to 192 kHz, against a model of another make.
#[test]
fn no_drive_moves_it_beyond_its_stroke() {
    for q in [0.5, 0.7, 3.0, 20.0, 200.0] {
        for (rate, hertz) in [(8e3, 400.0), (8e3, 100.0), (48e3, 175.0), (192e3, 200.0)] {
            let (plant, per_volt) = tuned(hertz, q);
            let sampled = Sampled::resonant(&plant.resonance(Drive::Voltage).unwrap(), per_volt, rate);
            let peak = 8.0 * STROKE / per_volt;
            for (name, foe) in FOES {
                let mut motion = Motion::new(&sampled, Some(STROKE), 0.0).unwrap();
                let periods = if rate > 1e5 { 12.0 } else { 40.0 };
                let at = farthest(&plant, &mut motion, foe, (rate, hertz, peak, f64::INFINITY), periods);
                assert!(at[0] <= 1.0 + 1e-9, "{name}, Q {q}, {hertz} Hz at {rate}: {}", at[0]);
                // From outwards to inwards within a sample: the velocity of the one end, a quarter of a sample long.
                let between = (1.0 + (0.5 * std::f64::consts::PI * hertz / rate).powi(2)).sqrt();
                assert!(at[1] <= between * (1.0 + 1e-4), "{name}, Q {q}, {hertz} Hz at {rate}: {}", at[1]);
            }
        }
    }
}

/// The same where the voltage may not leap.
#[test]
fn no_drive_moves_it_beyond_its_stroke_where_the_slew_is_bounded() {
    for q in [0.5, 2.0, 20.0, 200.0] {
        for (rate, hertz) in [(8e3, 400.0), (48e3, 175.0)] {
            let (plant, per_volt) = tuned(hertz, q);
            let sampled = Sampled::resonant(&plant.resonance(Drive::Voltage).unwrap(), per_volt, rate);
            let peak = 8.0 * STROKE / per_volt;
            // From the peak to nothing within a tenth of a period, a period, ten of them.
            for periods in [0.1, 1.0, 10.0] {
                let slew = peak * hertz / rate / periods;
                for (name, foe) in FOES {
                    let mut motion = Motion::new(&sampled, Some(STROKE), 1.0 - slew / peak).unwrap();
                    let at = farthest(&plant, &mut motion, foe, (rate, hertz, peak, slew), 60.0);
                    assert!(at[0] <= 1.0 + 1e-9, "{name}, Q {q}, {hertz} Hz at {rate}: {}", at[0]);
                }
            }
        }
    }
}

/// Plants of two to five states.
#[test]
fn no_drive_moves_a_plant_beyond_its_stroke() {
    let bare = VoiceCoil { coil: Coil { inductance: 0.0, ..tactor().coil }, ..tactor() };
    let unswift = Inertial { coil: Coil { inductance: 0.0, ..inertial().coil }, ..held() };
    let plants = [tactor(), layered(), bare].map(|v| Plant::voice_coil(&v).unwrap());
    for plant in plants.into_iter().chain([inertial(), held(), unswift].map(|m| Plant::inertial(&m).unwrap()))
    {
        let hertz = plant.resonance(Drive::Voltage).unwrap().hertz;
        let per_volt = plant.per_volt(0.01).displacement.abs();
        for rate in [8e3, 48e3] {
            let peak = 8.0 * STROKE / per_volt;
            for slew in [f64::INFINITY, 2.0 * peak * hertz / rate] {
                for (name, foe) in FOES {
                    let keep = (1.0 - slew / peak).max(0.0);
                    let mut motion = Motion::new(&plant.sampled(rate), Some(STROKE), keep).unwrap();
                    let at = farthest(&plant, &mut motion, foe, (rate, hertz, peak, slew), 40.0);
                    assert!(at[0] <= 1.0 + 1e-9, "{name}, {hertz} Hz at {rate}: {}", at[0]);
                }
            }
        }
    }
}

/// The stroke is not only kept: at rest and at the resonance all of it is used, above it what the module says.
#[test]
fn what_it_leaves_of_the_stroke_is_what_it_says() {
    for q in [0.7, 3.0, 20.0] {
        let (rate, hertz) = (48e3, 175.0);
        let (plant, per_volt) = tuned(hertz, q);
        let sampled = Sampled::resonant(&plant.resonance(Drive::Voltage).unwrap(), per_volt, rate);
        let peak = 40.0 * STROKE / per_volt;
        let reach = |times: f64| {
            let mut motion = Motion::new(&sampled, Some(STROKE), 0.0).unwrap();
            let (mut last, mut most) = (0.0, 0.0f64);
            let count = (60.0 * rate / hertz) as usize;
            for n in 0..count {
                let turns = n as f64 * times * hertz / rate;
                let wanted = peak * if times == 0.0 { 1.0 } else { (std::f64::consts::TAU * turns).sin() };
                (_, last, _) = motion.step(last, wanted, |v| (0.0, v));
                if 2 * n > count {
                    most = most.max(motion.displacement().abs() / STROKE);
                }
            }
            most
        };
        assert!(reach(0.0) > 0.999, "at rest: {}", reach(0.0));
        for times in [0.25, 0.5, 1.0] {
            assert!(reach(times) > 0.97, "Q {q}, {times}: {}", reach(times));
        }
        for times in [2.0, 4.0] {
            let most = reach(times);
            assert!((0.6..1.5).contains(&(most * times)), "Q {q}, {times}: {most}");
        }
    }
}

/// What keeps to the stroke by itself passes untouched: a sine whose energy never is that of the stroke.
#[test]
fn what_keeps_to_the_stroke_passes() {
    for (q, hertz, rate) in [(0.7, 100.0, 8e3), (15.0, 175.0, 48e3), (200.0, 60.0, 192e3)] {
        let (plant, per_volt) = tuned(hertz, q);
        let sampled = Sampled::resonant(&plant.resonance(Drive::Voltage).unwrap(), per_volt, rate);
        // At the resonance, Q times as far as at rest.
        let volts = 0.9 * STROKE / (per_volt * q.max(1.0));
        let mut motion = Motion::new(&sampled, Some(STROKE), 0.0).unwrap();
        let mut last = 0.0;
        for n in 0..(3.0 * q.max(3.0) * rate / hertz) as usize {
            let wanted = volts * (std::f64::consts::TAU * hertz * n as f64 / rate).sin();
            (_, last, _) = motion.step(last, wanted, |v| (0.0, v));
            assert_eq!(last, wanted, "Q {q}, sample {n}");
        }
    }
}

#[test]
fn what_no_spring_brings_back_has_no_stroke() {
    let floating = VoiceCoil { suspension: Spring::default(), skin: Skin::None, ..tactor() };
    let damped = Tissue { mass: 0.05, spring: Spring { stiffness: 0.0, damping: 4.0 } };
    for plant in [
        Plant::voice_coil(&floating).unwrap(),
        Plant::inertial(&Inertial { hand: damped, ..inertial() }).unwrap(),
    ] {
        let sampled = plant.sampled(48e3);
        assert_eq!(Motion::new(&sampled, Some(1e-3), 0.0).unwrap_err().field, "stroke");
        assert!(Motion::new(&sampled, None, 0.0).is_ok());
    }
}

/// With a bounded slew: what is left of the stroke where the voltage takes so many periods from the peak to nothing.
#[test]
fn what_a_bounded_slew_costs_of_the_stroke_is_what_it_says() {
    let (rate, hertz) = (48e3, 175.0);
    let mut at_resonance = Vec::new();
    for (q, periods) in [(0.7, 0.02), (3.0, 0.02), (20.0, 0.02), (3.0, 0.3), (20.0, 0.3), (0.7, 0.3)] {
        let (plant, per_volt) = tuned(hertz, q);
        let sampled = Sampled::resonant(&plant.resonance(Drive::Voltage).unwrap(), per_volt, rate);
        let peak = 8.0 * STROKE / per_volt;
        let slew = peak * hertz / rate / periods;
        let reach = |times: f64| {
            let mut motion = Motion::new(&sampled, Some(STROKE), 1.0 - slew / peak).unwrap();
            let (mut last, mut most) = (0.0f64, 0.0f64);
            let count = (40.0 * rate / hertz) as usize;
            for n in 0..count {
                let turns = n as f64 * times * hertz / rate;
                let wanted = peak * if times == 0.0 { 1.0 } else { (std::f64::consts::TAU * turns).sin() };
                let steep = last + (wanted - last).clamp(-slew, slew);
                (_, last, _) = motion.step(last, steep, |v| (0.0, v));
                if 2 * n > count {
                    most = most.max(motion.displacement().abs() / STROKE);
                }
            }
            most
        };
        assert!(reach(0.0) > 0.999 && reach(0.25) > 0.95, "Q {q}, {periods}: {} {}", reach(0.0), reach(0.25));
        at_resonance.push(reach(1.0));
    }
    for (is, least) in at_resonance.iter().zip([0.93, 0.98, 0.99, 0.78, 0.95, 0.4]) {
        assert!(*is > least, "{at_resonance:?}");
    }
}
