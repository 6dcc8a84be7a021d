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

#[test]
fn counts_are_those_of_the_definitions() {
    // Peak 4 V of 4, then 1 V a sample: all of it exact.
    let bounds = Bounds { full_scale: Some(4.0), peak: Some(4.0), slew: Some(RATE), ..none() };
    let nothing = [f32::NAN, f32::INFINITY];
    let input = [0.125, 1.25, 1.25, 1.25, 0.875, 0.75, 0.625, nothing[0], -0.25, nothing[1]];
    let (out, counts) = run(&bounds, RATE, &input);
    assert_eq!(out, [0.5, 1.5, 2.5, 3.5, 3.5, 3.0, 2.5, 1.5, 0.5, 0.0].map(|v| v / 4.0));
    assert_eq!((counts.samples, counts.masked, counts.changed), (10, 2, 6));
    assert_eq!(counts.peak, Touched { samples: 3, most: 1.0 });
    // On the way up 4 V wanted at 0.5, 1.5 and 2.5 V; on the way down 0 V at 2.5 and -1 V at 1.5.
    assert_eq!(counts.slew, Touched { samples: 5, most: 2.5 });
    // With a budget, what is wild is held, and counted once.
    let (_, counts) = run(&Bounds { heat: Some(cooling()), ..none() }, RATE, &[0.1, 17.0, -1e30, 15.9]);
    assert_eq!((counts.held, counts.masked), (2, 0));
    // A gain and a cap that both lower a sample are one bound.
    let (_, counts) = run(&Bounds { heat: Some(cooling()), ..none() }, RATE, &[16.0; 8000]);
    assert!(counts.heat.samples <= 8000 && counts.heat.samples >= 7900, "{counts:?}");
}

/// Temperature from what left, in finer steps than those of the kernel, and with the resistance of the moment.
fn warmest<const STEP: usize>(
    bounds: &Bounds,
    rate: f64,
    input: impl Fn(usize) -> f32,
    seconds: f64,
) -> (f64, Protection) {
    let mut p = Protection::new(bounds, rate).unwrap();
    let cooling = bounds.heat.unwrap();
    let mut thermal = Thermal::new(&cooling).unwrap();
    let (mut warmest, mut block) = (0.0f64, [0.0f32; STEP]);
    for part in 0..(seconds * rate / STEP as f64) as usize {
        for (k, x) in block.iter_mut().enumerate() {
            *x = input(part * STEP + k);
        }
        p.process(&mut block);
        let square: f64 = block.iter().map(|x| (f64::from(*x) * 5.0 / thermal.resistance()).powi(2)).sum();
        thermal.step(square / STEP as f64, STEP as f64 / rate);
        warmest = warmest.max(thermal.winding());
    }
    (warmest, p)
}

/// Two hours of full scale; then noise, bursts between pauses of many lengths, and what is no number.
#[test]
fn the_winding_never_passes_its_limit() {
    let base = Bounds { heat: Some(cooling()), ..none() };
    let square = |n: usize| if (n / 10).is_multiple_of(2) { 1.0 } else { -1.0 };
    let (most, p) = warmest::<23>(&base, 6000.0, square, 7200.0);
    assert!(most <= 60.0 * 1.0001, "{most}");
    assert!((p.temperature().unwrap() - 60.0).abs() < 0.01, "{:?}", p.temperature());
    // It rests at the voltage that it bears for ever, and does not chatter.
    let bears = cooling().continuous_amperes() * 7.0 * (1.0 + COPPER * 60.0);
    assert!((p.gain() * 5.0 / bears - 1.0).abs() < 1e-3, "{} {bears}", p.gain());
    let seeded = |n: usize| random(&mut (n as u64 * 77)) as f32 * 20.0;
    let (most, _) = warmest::<23>(&base, RATE, seeded, 600.0);
    assert!(most <= 60.0 * 1.02 && most > 59.0, "{most}");
    let mut worst = 0.0f64;
    for hot in [0.05, 0.3, 1.0, 4.0] {
        for pause in [0.05, 0.5, 2.0, 20.0] {
            let burst = |n: usize| {
                let at = n as f64 / RATE % (hot + pause);
                if at < hot { if n.is_multiple_of(997) { f32::NAN } else { 3.0 } } else { 0.0 }
            };
            let (most, _) = warmest::<23>(&base, RATE, burst, 200.0);
            worst = worst.max(most);
        }
    }
    // Beyond the tolerance only by what a winding that cools within a tick takes more.
    assert!(worst <= 60.0 * 1.0201, "{worst}");
}

/// Windings that a tick of full scale would burn, ones that would run away, slow slews, a plant with currents of its own.
#[test]
fn the_winding_never_passes_its_limit_however_it_is_made() {
    let small = Cooling { winding_time: 0.05, housing_time: 2.0, to_housing: 100.0, ..cooling() };
    let eager = Cooling { resistance: 1.0, most: 20.0, ..cooling() };
    let low = Cooling { most: 0.5, ..cooling() };
    for cooling in [small, eager, low, cooling()] {
        for (peak, slew) in [(None, None), (Some(4.0), Some(2000.0)), (Some(5.0), Some(200.0))] {
            let bounds = Bounds { heat: Some(cooling), peak, slew, ..none() };
            // One way down from the peak, exponential or straight, without cooling.
            let way = peak.map_or(0.0, |v: f64| v * v / cooling.resistance * v / (2.0 * slew.unwrap()));
            let more = way * cooling.to_housing / cooling.winding_time;
            for hot in [0.011, 0.17, 1.9, 100.0] {
                let burst = |n: usize| {
                    let at = n as f64 / RATE % (3.1 * hot);
                    if at < hot { 2.0 } else { 0.0 }
                };
                let (most, p) = warmest::<1>(&bounds, RATE, burst, 30.0);
                let late = (0.0025f64).max(8.0 / RATE / cooling.winding_time);
                let limit = cooling.most * (1.0201 + late) + more;
                assert!(most <= limit, "{most} {limit} {hot} {bounds:?}");
                assert!(p.counts().warmest <= cooling.most * (1.02 + 1e-9) + more);
            }
        }
    }
    // With the plant: what its model tells, which runs for less than the resistance alone.
    for hertz in [0.0, 100.0, 245.0, 1000.0] {
        let bounds = Bounds { heat: Some(cooling()), actuator: Actuator::Coil(plant()), ..none() };
        let mut p = Protection::new(&bounds, RATE).unwrap();
        let mut model =
            crate::actuator::coil::model::Model::new(&plant(), RATE, crate::actuator::drive::Drive::Voltage)
                .unwrap();
        let mut thermal = Thermal::new(&cooling()).unwrap();
        let mut most = 0.0f64;
        for part in 0..40_000 {
            let mut block: [f32; 40] = std::array::from_fn(|k| {
                let turns = hertz * (part * 40 + k) as f64 / RATE;
                if turns.fract() < 0.5 { 1.0 } else { -1.0 }
            });
            p.process(&mut block);
            let square: f64 = block.iter().map(|x| model.step(f64::from(*x) * 5.0).current.powi(2)).sum();
            thermal.step(square / 40.0, 40.0 / RATE);
            most = most.max(thermal.winding());
        }
        assert!(most <= 60.0 * 1.021 && most > 59.5, "{hertz} Hz: {most}");
    }
}

/// The root mean square over its time never passes 1.01 times the limit, and what is at it for ever passes.
#[test]
fn the_mean_square_never_passes_its_limit() {
    for seconds in [0.01, 0.2, 3.0f64] {
        // Half a tick over the time.
        let late = (0.5 * (seconds / 400.0 * RATE).max(8.0) / RATE / seconds).min(0.05);
        for (unit, actuator, ohms) in
            [(Unit::Volts, Actuator::Unknown, 1.0), (Unit::Amperes, Actuator::Resistance(4.0), 4.0)]
        {
            let most = 2.0 / ohms;
            let bounds = Bounds { rms: Some(Rms { most, unit, seconds }), actuator, ..none() };
            let share = 1.0 - (-1.0 / (RATE * seconds)).exp();
            for input in [hostile(80_000), vec![1.0; 80_000], vec![0.399; 80_000]] {
                let (out, counts) = run(&bounds, RATE, &input);
                let (mut level, mut worst) = (0.0, 0.0f64);
                for x in &out {
                    level += share * ((f64::from(*x) * 5.0 / ohms).powi(2) - level);
                    worst = worst.max(level);
                }
                assert!(
                    worst <= most * most * (1.0201 + 1.02 * late),
                    "{seconds} {}: {}",
                    input[0],
                    worst.sqrt()
                );
                if input[0] == 1.0 && seconds < 1.0 {
                    assert!((level.sqrt() / most - 1.0).abs() < 1e-3, "{}", level.sqrt());
                }
                if input[0] == 0.399 {
                    assert!(bits(&out) == bits(&input) && counts.changed == 0);
                }
            }
        }
    }
}

/// No more of a steady voltage leaves, in the end, than is borne, whatever clips behind; and what varies passes.
#[test]
fn a_steady_voltage_is_taken_off() {
    let mean_of = |out: &[f32]| out.iter().map(|x| f64::from(*x) * 5.0).sum::<f64>() / out.len() as f64;
    let wave = |n: usize| (0.4 + 0.5 * (TAU * 100.0 * n as f64 / RATE).sin()) as f32;
    // Lopsided: three quarters of the time -0.3, one quarter 0.9, which the peak of 2 V halves.
    let lopsided = |n: usize| if n % 80 < 20 { 0.9f32 } else { -0.3 };
    for most in [0.0, 0.1] {
        for peak in [None, Some(2.0)] {
            for (name, f) in [("wave", &wave as &dyn Fn(usize) -> f32), ("lopsided", &lopsided)] {
                let bounds = Bounds { steady: Some(most), peak, ..none() };
                let input: Vec<f32> = (0..80_000).map(f).collect();
                let (out, counts) = run(&bounds, RATE, &input);
                let mean = mean_of(&out[72_000..]);
                assert!(mean.abs() <= most + 0.01, "{name} {most} {peak:?}: {mean}");
                assert!(counts.steady.samples > 0 || (name == "lopsided" && most > 0.0 && peak.is_none()));
            }
        }
    }
    // It goes as a resistor and a capacitor let it: of 2 V, what is too much is down to 1/e after 1 / 2πf.
    let (out, _) = run(&Bounds { steady: Some(0.5), ..none() }, RATE, &[0.4; 8000]);
    let at = |seconds: f64| f64::from(out[(seconds * RATE) as usize]) * 5.0;
    let time = 1.0 / (TAU * CORNER);
    // The mean is 2 (1 − e^(−t/τ)) and may be 0.5: from t = τ ln(4/3) on, 0.5 + 2 e^(−t/τ) leaves.
    for seconds in [0.02, 0.06, 0.2, 0.5] {
        let mean = 2.0 * (1.0 - (-seconds / time).exp());
        let expected = 2.0 - (mean - 0.5).max(0.0);
        assert!((at(seconds) - expected).abs() < 2e-3, "{seconds}: {} {expected}", at(seconds));
    }
}

/// A tone on a motor's envelope is lowered to its budget while the envelope passes; a click passes untouched.
#[test]
fn what_alternates_is_lowered_and_the_mean_passes() {
    let bounds = Bounds { alternating: Some(Alternating { hertz: 5.0, most: 0.5, seconds: 0.5 }), ..none() };
    let input: Vec<f32> =
        (0..80_000).map(|n| (0.5 + 0.4 * (TAU * 250.0 * n as f64 / RATE).sin()) as f32).collect();
    let (out, counts) = run(&bounds, RATE, &input);
    let end = &out[64_000..];
    let mean = end.iter().map(|x| f64::from(*x) * 5.0).sum::<f64>() / end.len() as f64;
    let square = end.iter().map(|x| (f64::from(*x) * 5.0 - mean).powi(2)).sum::<f64>() / end.len() as f64;
    assert!((mean - 2.5).abs() < 1e-3, "{mean}");
    assert!((square.sqrt() / 0.5 - 1.0).abs() < 0.05, "{}", square.sqrt());
    assert!(counts.alternating.samples > 70_000);
    let bounds = Bounds { alternating: Some(Alternating { hertz: 5.0, most: 1.5, seconds: 1.0 }), ..none() };
    // 12 ms forward, 8 ms backward, as a click has it; twice a second.
    let click: Vec<f32> = (0..40_000)
        .map(|n| match n % 4000 {
            0..96 => 0.6,
            96..160 => -0.6,
            _ => 0.0,
        })
        .collect();
    let (out, _) = run(&bounds, RATE, &click);
    assert!(bits(&out) == bits(&click));
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

#[test]
fn what_is_derived_from_limits_and_motors_is_what_they_say() {
    let limits = Limits { volts: Some(5.0), amperes: Some(0.5), amperes_rms: Some(0.25), stroke: Some(3e-4) };
    let b = Bounds::coil(&plant(), &limits, 6.0, 2.0);
    assert_eq!((b.peak, b.stroke, b.full_scale), (Some(3.5), Some(3e-4), Some(6.0)));
    assert_eq!(b.rms, Some(Rms { most: 0.25, unit: Unit::Amperes, seconds: 2.0 }));
    assert!(Protection::new(&b, 48e3).is_ok());
    assert_eq!(Bounds::coil(&plant(), &Limits { amperes: None, ..limits }, 6.0, 2.0).peak, Some(5.0));
    let coin = Parameters {
        resistance: 30.0,
        inductance: 3e-4,
        gain: 0.955e-3,
        inertia: 1.8e-9,
        viscous: 2.15e-8,
        coulomb: 0.0,
        stiction: 0.0,
        eccentric: 7.3e-7,
        gravity: 0.0,
        casing: Casing::Held,
        rated_volts: 3.0,
    };
    let b = Bounds::motor(&coin, 5.0, 1.5);
    assert_eq!((b.peak, b.rms.unwrap().most), (Some(4.5), 3.0));
    let time = 1.8e-9 * 30.0 / (0.955e-3f64.powi(2) + 2.15e-8 * 30.0);
    assert!((b.alternating.unwrap().hertz * TAU * time - 1.0).abs() < 1e-12);
    // At its rated voltage it runs untouched for ever.
    let rated = vec![0.6; 200_000];
    assert!(bits(&run(&b, RATE, &rated).0) == bits(&rated));
}

#[test]
fn what_cannot_be_is_refused_by_name() {
    let refused = |bounds: Bounds| Protection::new(&bounds, 48e3).unwrap_err().field;
    let rms = Rms { most: 1.0, unit: Unit::Volts, seconds: 1.0 };
    let a = Alternating { hertz: 5.0, most: 1.0, seconds: 1.0 };
    for (bounds, field) in [
        (Bounds { full_scale: Some(0.0), ..none() }, "full_scale"),
        (Bounds { peak: Some(f64::NAN), ..none() }, "peak"),
        (Bounds { slew: Some(-1.0), ..none() }, "slew"),
        (Bounds { stroke: Some(0.0), ..all() }, "stroke"),
        (Bounds { steady: Some(-0.1), ..none() }, "steady"),
        (Bounds { rms: Some(Rms { most: 0.0, ..rms }), ..none() }, "rms.most"),
        (Bounds { rms: Some(Rms { seconds: f64::INFINITY, ..rms }), ..none() }, "rms.seconds"),
        (Bounds { rms: Some(Rms { unit: Unit::Amperes, ..rms }), ..none() }, "rms.most"),
        (Bounds { alternating: Some(Alternating { hertz: 0.0, ..a }), ..none() }, "alternating.hertz"),
        (Bounds { alternating: Some(Alternating { most: -1.0, ..a }), ..none() }, "alternating.most"),
        (Bounds { alternating: Some(Alternating { seconds: 0.0, ..a }), ..none() }, "alternating.seconds"),
        (Bounds { heat: Some(Cooling { most: 0.0, ..cooling() }), ..none() }, "most"),
        (Bounds { stroke: Some(1e-3), ..none() }, "stroke"),
        (Bounds { actuator: Actuator::Resistance(0.0), ..none() }, "resistance"),
        (Bounds { full_scale: None, ..all() }, "rms.most"),
        (Bounds { heat: Some(cooling()), ..Bounds::default() }, "heat.most"),
        (Bounds { steady: Some(0.1), ..Bounds::default() }, "steady"),
    ] {
        assert_eq!(refused(bounds), field);
    }
    for rate in [0.0, f64::NAN, 5999.0, 1.1e6] {
        assert_eq!(Protection::new(&none(), rate).unwrap_err().field, "rate");
    }
    let text = Bounds { stroke: Some(1e-3), ..none() }.check().unwrap_err().to_string();
    assert_eq!(
        text,
        "`stroke` is 0.001, but must be left out: it is not known how far a volt moves the actuator"
    );
}
