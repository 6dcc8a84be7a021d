use super::super::bounds::{Actuator, Alternating, Bounds, Rms, Unit};
use super::super::counts::{Counts, Touched};
use super::{CORNER, Protection};
use crate::actuator::coil::limits::Limits;
use crate::actuator::coil::parameters::tests::tactor;
use crate::actuator::coil::plant::Plant;
use crate::actuator::coil::resonance::Resonance;
use crate::actuator::motor::{Casing, Parameters};
use crate::actuator::thermal::{COPPER, Cooling, Thermal};
use std::f64::consts::TAU;

mod bounds;
mod budgets;
mod told;

const RATE: f64 = 8000.0;

fn plant() -> Plant {
    Plant::voice_coil(&tactor()).unwrap()
}

/// Of a tactor: 5 V makes 3.6 W, which heats it by 51 K/s.
fn cooling() -> Cooling {
    Cooling {
        resistance: 7.0,
        rise: COPPER,
        to_housing: 28.0,
        to_air: 60.0,
        winding_time: 2.0,
        housing_time: 100.0,
        most: 60.0,
    }
}

fn none() -> Bounds {
    Bounds { full_scale: Some(5.0), ..Bounds::default() }
}

fn all() -> Bounds {
    Bounds {
        peak: Some(4.0),
        slew: Some(1.5e4),
        rms: Some(Rms { most: 0.4, unit: Unit::Amperes, seconds: 0.5 }),
        heat: Some(cooling()),
        stroke: Some(1e-4),
        steady: Some(0.05),
        alternating: Some(Alternating { hertz: 5.0, most: 2.0, seconds: 0.3 }),
        actuator: Actuator::Coil(plant()),
        ..none()
    }
}

/// Samples within ±1 that look random.
fn random(seed: &mut u64) -> f64 {
    *seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    ((*seed >> 11) as f64 / (1u64 << 52) as f64) - 1.0
}

/// Noise, bursts, squares, silence, steady voltages, numbers that are none.
fn hostile(count: usize) -> Vec<f32> {
    let mut seed = 3;
    let mut kind = 0;
    (0..count)
        .map(|n| {
            if n % 1000 == 0 {
                kind = ((random(&mut seed) + 1.0) * 4.5) as u32;
            }
            let x = random(&mut seed);
            match kind {
                0 => x as f32,
                1 => 0.0,
                2 => 1.0,
                3 => (((n as f64 * 0.03).fract() < 0.5) as u8) as f32 * 2.0 - 1.0,
                4 => (x * 1e-3) as f32,
                5 => [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, 1e-40][n % 5],
                6 => (0.9 * (n as f64 * 0.17).sin()) as f32,
                7 => -3.0,
                _ => (5.0 * x) as f32,
            }
        })
        .collect()
}

fn run(bounds: &Bounds, rate: f64, input: &[f32]) -> (Vec<f32>, Counts) {
    let mut p = Protection::new(bounds, rate).unwrap();
    let mut out = input.to_vec();
    p.process(&mut out);
    (out, p.counts())
}

fn bits(x: &[f32]) -> Vec<u32> {
    x.iter().map(|x| x.to_bits()).collect()
}

/// Each bound alone, all of them, and most pairs with another slew or actuator.
fn various() -> Vec<Bounds> {
    let a = all();
    let resonant = Actuator::Resonant {
        resonance: Resonance { hertz: 230.0, q: 2.7 },
        per_volt: plant().per_volt(0.01).displacement.abs(),
    };
    vec![
        none(),
        a,
        Bounds { slew: None, ..a },
        Bounds { peak: None, ..a },
        Bounds { rms: Some(Rms { most: 2.0, unit: Unit::Volts, seconds: 0.1 }), actuator: resonant, ..a },
        Bounds { peak: a.peak, ..none() },
        Bounds { range: Some([-2.0, 3.0]), slew: a.slew, ..none() },
        Bounds { slew: a.slew, ..none() },
        Bounds { peak: a.peak, slew: a.slew, ..none() },
        Bounds { heat: a.heat, ..none() },
        Bounds { heat: a.heat, slew: a.slew, peak: a.peak, ..none() },
        Bounds { heat: a.heat, actuator: a.actuator, ..none() },
        Bounds { rms: Some(Rms { most: 2.0, unit: Unit::Volts, seconds: 0.2 }), ..none() },
        Bounds { rms: a.rms, actuator: Actuator::Resistance(6.0), ..none() },
        Bounds { stroke: a.stroke, actuator: resonant, ..none() },
        Bounds { stroke: a.stroke, slew: a.slew, actuator: a.actuator, ..none() },
        Bounds { steady: a.steady, ..none() },
        Bounds { steady: Some(0.0), peak: a.peak, ..none() },
        Bounds { alternating: a.alternating, ..none() },
        Bounds { full_scale: None, peak: Some(0.7), slew: Some(900.0), ..Bounds::default() },
    ]
}

#[test]
fn where_nothing_acts_every_bit_stays() {
    // 1.5 V at most, off the resonance, slowly faded in: well within every bound.
    let quiet: Vec<f32> = (0..40_000)
        .map(|n| {
            let fade = (n as f64 / 4000.0).min(1.0);
            (0.3 * fade * (TAU * 60.0 * n as f64 / RATE).sin() * (TAU * 3.0 * n as f64 / RATE).cos()) as f32
        })
        .chain([0.0, -0.0, 1e-40, -1e-45, f32::MIN_POSITIVE])
        .collect();
    for bounds in various() {
        if bounds.steady == Some(0.0) {
            continue;
        }
        let (out, counts) = run(&bounds, RATE, &quiet);
        assert!(bits(&out) == bits(&quiet), "{bounds:?} {counts:?}");
        let idle = Counts {
            samples: 40_005,
            warmest: counts.warmest,
            farthest: counts.farthest,
            ..Counts::default()
        };
        assert_eq!(counts, idle);
        assert_eq!(counts.warmest > 0.0, bounds.heat.is_some());
        assert_eq!(counts.farthest > 0.0, bounds.stroke.is_some());
    }
}

#[test]
fn how_a_run_is_cut_into_blocks_does_not_matter() {
    let input = hostile(30_000);
    for bounds in various() {
        let (whole, counts) = run(&bounds, RATE, &input);
        for cut in [1, 7, 64, 480] {
            let mut p = Protection::new(&bounds, RATE).unwrap();
            let mut out = input.clone();
            out.chunks_mut(cut).for_each(|block| p.process(block));
            assert!(bits(&out) == bits(&whole), "{cut} {bounds:?}");
            assert_eq!(p.counts(), counts);
            // As new.
            p.reset();
            let mut again = input[..5000].to_vec();
            p.process(&mut again);
            assert!(bits(&again) == bits(&whole[..5000]));
            assert_eq!(p.counts().samples, 5000);
        }
    }
}

#[test]
fn a_wild_sample_is_soon_forgotten_and_silence_becomes_rest() {
    for bounds in various().into_iter().filter(|b| b.heat.is_some() || b.rms.is_some() || b.steady.is_some())
    {
        let mut p = Protection::new(&bounds, RATE).unwrap();
        p.process(&mut [f32::MAX]);
        p.process(&mut vec![0.0; 40_000]);
        assert_eq!(p.gain(), 1.0, "{bounds:?}");
        let tone: Vec<f32> = (0..800).map(|n| 0.02 * (n as f32 * 0.2).sin()).collect();
        let mut out = tone.clone();
        p.process(&mut out);
        // A bound of no steady voltage at all acts on everything.
        let untouched = bits(&out) == bits(&tone) || bounds.steady == Some(0.0);
        assert!(untouched, "{bounds:?} {:?}", p.counts());
        p.process(&mut vec![0.0; 160_000]);
        assert!(p.still, "{bounds:?}");
        // Nothing is left that is so small that arithmetic slows down.
        if let Some(motion) = &p.motion {
            assert!(motion.is_still());
        }
    }
}

/// The short ways, for what passes and for silence, change nothing: each sample alone, with both of them barred.
#[test]
fn the_short_ways_lead_to_the_same() {
    // Long enough that everything comes to rest, and begins again.
    let mut input = hostile(20_000);
    input.extend(vec![0.0; 160_000]);
    input.extend((0..20_000).map(|n| 0.2 * (n as f32 * 0.05).sin()));
    for bounds in various() {
        let (out, counts) = run(&bounds, RATE, &input);
        let mut p = Protection::new(&bounds, RATE).unwrap();
        for (n, (&x, y)) in input.iter().zip(&out).enumerate() {
            (p.plain, p.still) = (false, false);
            let mut one = [x];
            p.process(&mut one);
            assert_eq!(one[0].to_bits(), y.to_bits(), "{n} {bounds:?}");
        }
        assert_eq!(p.counts(), counts);
    }
}

#[test]
fn peak_and_slew_hold_to_the_last_bit_whatever_else_acts() {
    let input = hostile(200_000);
    for rate in [RATE, 48e3, 192e3] {
        for bounds in various() {
            let (out, counts) = run(&bounds, rate, &input);
            let volts = bounds.full_scale.unwrap_or(1.0);
            let mut last = 0.0;
            for (n, &x) in out.iter().enumerate() {
                assert!(x.is_finite());
                let v = f64::from(x) * volts;
                assert!(bounds.peak.is_none_or(|peak| v.abs() <= peak), "{n}: {v}");
                let slew = bounds.slew.map_or(f64::INFINITY, |slew| slew / rate);
                assert!((v - last).abs() <= slew, "{n}: {last} {v} {slew} {bounds:?}");
                last = v;
            }
            let changed = input.iter().zip(&out).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
            assert_eq!(counts.changed, changed as u64);
            let masked = input.iter().filter(|x| !x.is_finite()).count();
            assert_eq!(counts.masked, masked as u64);
        }
    }
}

/// At each rate a device may have, all bounds at once: the model that another make of it follows keeps to the stroke.
#[test]
fn all_bounds_hold_at_once_at_every_rate() {
    for rate in [6e3, 8e3, 44.1e3, 96e3, 768e3] {
        let mut model =
            crate::actuator::coil::model::Model::new(&plant(), rate, crate::actuator::drive::Drive::Voltage)
                .unwrap();
        let (out, counts) = run(&all(), rate, &hostile(60_000));
        let mut last = 0.0;
        for x in out {
            let v = f64::from(x) * 5.0;
            assert!(v.abs() <= 4.0 && (v - last).abs() <= 1.5e4 / rate);
            last = v;
            assert!(model.step(v).displacement.abs() <= 1e-4 * (1.0 + 1e-6));
        }
        assert!(counts.warmest <= 60.0 * 1.02 && counts.farthest <= 1e-4 * (1.0 + 1e-6), "{counts:?}");
        assert!(rate > 1e5 || counts.farthest > 0.5e-4, "{rate}: {counts:?}");
    }
}
