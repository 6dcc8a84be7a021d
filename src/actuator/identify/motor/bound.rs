//! How much a recording holds, and how much of it is told: the least deviation that any unbiased estimate has (Cramér and Rao), from the motor's own model
//! and the noise, beside the intervals.

use super::super::least::inverse;
use super::super::noise::Noise;
use super::tests::{PAD, Run, STAIRS, absolutes, near, simulate};
use super::{Recording, identify};
use crate::actuator::motor::Parameters;

const RATE: f64 = 8000.0;
const ANGLE: f64 = 0.3;
/// 40 dB.
const SHARE: f64 = 0.01;

/// The parameters that are not known, each with its name.
type Free = (&'static str, fn(&mut Parameters) -> &mut f64);
const FREE: [Free; 7] = [
    ("resistance", |p| &mut p.resistance),
    ("inductance", |p| &mut p.inductance),
    ("torque_constant", |p| &mut p.gain),
    ("inertia", |p| &mut p.inertia),
    ("viscous_friction", |p| &mut p.viscous),
    ("coulomb_friction", |p| &mut p.coulomb),
    ("eccentric_moment", |p| &mut p.eccentric),
];

fn deviation(x: &[f64]) -> f64 {
    let mean = x.iter().sum::<f64>() / x.len() as f64;
    SHARE * (x.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt()
}

/// Half of an interval of 95 % that no unbiased estimate can do without. Instants count as known, and where the mass hung: who has to find
/// them as well knows less.
fn bounds(run: &Run) -> Vec<f64> {
    let noise = [deviation(&run.acceleration), deviation(&run.current)];
    let slopes: Vec<Vec<f64>> = FREE
        .iter()
        .map(|(_, of)| {
            let step = 1e-6 * *of(&mut PAD.clone());
            let [above, below] = [step, -step].map(|step| {
                let mut p = PAD;
                *of(&mut p) += step;
                simulate(&p, RATE, ANGLE, &STAIRS)
            });
            let slope = |a: &[f64], b: &[f64], noise: f64| -> Vec<f64> {
                a.iter().zip(b).map(|(a, b)| (a - b) / (2.0 * step * noise)).collect()
            };
            let turned = slope(&above.acceleration, &below.acceleration, noise[0]);
            [turned, slope(&above.current, &below.current, noise[1])].concat()
        })
        .collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let information = slopes.iter().map(|a| slopes.iter().map(|b| dot(a, b)).collect()).collect();
    let least = inverse(&information).unwrap();
    (0..FREE.len()).map(|n| 1.96 * least[n][n].sqrt()).collect()
}

/// A game pad's motor, whose coil takes three samples: whatever the noise, all that its current tells is within 3 %, in an interval that is no wider
/// than that, and no narrower than what the recording holds.
#[test]
fn a_slow_coil_at_8_khz_tells_all_within_three_percent() {
    let run = simulate(&PAD, RATE, ANGLE, &STAIRS);
    let bounds = bounds(&run);
    let (mut inside, mut all) = (0, 0);
    for seed in 0..6 {
        let noisy = Noise::new(seed).add(&run.acceleration, 40.0);
        let current = Noise::new(seed + 1000).add(&run.current, 40.0);
        // As recorded, and with nothing known of by how much the current is late.
        let current_delay = (seed % 2 == 0).then_some(0.0);
        let current = Some(run.channel(&current));
        let recording =
            Recording { current, current_delay, mass: PAD.casing.mass(), ..run.recording(&noisy) };
        let found = identify(&recording).unwrap();
        for (name, truth) in absolutes(&PAD) {
            inside += u32::from(near(&found, name, truth));
            all += 1;
            let told = found.get(name).unwrap();
            let half = 0.5 * (told.interval[1] - told.interval[0]);
            assert!(half < 0.03 * truth, "{told}");
            let least = bounds[FREE.iter().position(|(other, _)| *other == name).unwrap()];
            assert!(half > least, "{told}: {half:e}, and no less than {least:e} can be told");
        }
    }
    assert!(10 * inside >= 9 * all, "{inside} of {all} inside");
}

/// A recording that is a tenth of a second before its drive, or as much behind it: what begins or ends outside of the drive is not simulated, and nothing is told
/// that is not so.
#[test]
fn what_is_far_from_its_drive_is_no_harm() {
    let run = simulate(&PAD, RATE, ANGLE, &STAIRS);
    let noisy = Noise::new(1).add(&run.acceleration, 40.0);
    let current = Noise::new(2).add(&run.current, 40.0);
    for (before, behind) in [(0, 800), (800, 0), (0, 10_000), (10_000, 0)] {
        // The recording is what moves, its rest longer or shorter.
        let moved = |x: &[f64]| -> Vec<f64> {
            let all = [vec![0.0; before], x[behind..].to_vec(), vec![0.0; behind]].concat();
            all[..x.len()].to_vec()
        };
        let (x, i) = (moved(&noisy), moved(&current));
        let late = (before as f64 - behind as f64) / RATE;
        let delay = Some(late.clamp(-1.0, 10.0));
        let recording = Recording {
            current: Some(run.channel(&i)),
            current_delay: delay,
            mass: PAD.casing.mass(),
            ..run.recording(&x)
        };
        let Ok(found) = identify(&recording) else { continue };
        for (name, truth) in absolutes(&PAD) {
            let Some(told) = found.get(name) else { continue };
            assert!((told.value / truth - 1.0).abs() < 0.05, "{before} {behind}: {told}, but it is {truth}");
        }
    }
}
