//! Budgets for heat, mean squares, what is steady and what alternates, over long runs.

use super::{
    Actuator, Alternating, Bounds, COPPER, CORNER, Cooling, Protection, RATE, Rms, TAU, Thermal, Unit, bits,
    cooling, hostile, none, plant, random, run,
};

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
