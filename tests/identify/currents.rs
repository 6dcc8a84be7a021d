//! A current beside the acceleration, and no drive that came back: by how much both are late nobody says.

use super::program::Scratch;
use super::{Noise, coin, groups, of_part, record, turn, why_not};
use pacinian::actuator::identify::stimulus::steps;
use pacinian::actuator::motor::{GRAVITY, Parameters};
use pacinian::io::wav::Encoding;
use serde_json::Value;
use std::f64::consts::PI;

/// Volts, m/s2 and A for a sample of 1.0.
const SCALES: [f64; 3] = [16.0, 500.0, 4.0];

/// How instants become samples.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Converter {
    /// What is there in the instant.
    Points,
    /// What a steep filter below half the rate leaves, as converters do: a windowed sinc over 24 samples.
    Band,
}

/// Of samples `fine` times as many, those that a recording has that begins so many fine samples before the drive.
fn sampled(x: &[f64], fine: usize, before: usize, behind: usize, by: Converter) -> Vec<f64> {
    let at = |n: isize| if n < 0 { 0.0 } else { x[(n as usize).min(x.len() - 1)] };
    let reach = 12 * fine as isize;
    let weight = |k: isize| {
        let t = k as f64 / fine as f64;
        let sinc = if k == 0 { 0.9 } else { (0.9 * PI * t).sin() / (PI * t) };
        sinc * (0.5 + 0.5 * (PI * k as f64 / reach as f64).cos())
    };
    let weights: Vec<f64> = (-reach..=reach).map(weight).collect();
    let sum: f64 = weights.iter().sum();
    (0..(before + x.len() + behind) / fine)
        .map(|n| {
            let middle = (n * fine) as isize - before as isize;
            match by {
                Converter::Points => at(middle),
                Converter::Band => {
                    weights.iter().zip(-reach..).map(|(w, k)| w * at(middle + k)).sum::<f64>() / sum
                }
            }
        })
        .collect()
}

/// A motor, the rate, and by how many fine samples of so many a sample everything is late.
struct Case {
    name: &'static str,
    p: Parameters,
    volts: f64,
    rate: f64,
    fine: usize,
    late: usize,
    by: Converter,
}

fn pad() -> Parameters {
    Parameters { gravity: GRAVITY, ..of_part("constar-vc2039").rumble_motor().unwrap() }
}

/// All that the current tells.
fn absolutes(p: &Parameters) -> [(&'static str, f64); 10] {
    let [a, b, c, d] = groups(p);
    [
        a,
        b,
        c,
        d,
        ("resistance", p.resistance),
        ("torque_constant", p.gain),
        ("inertia", p.inertia),
        ("viscous_friction", p.viscous),
        ("coulomb_friction", p.coulomb),
        ("inductance", p.inductance),
    ]
}

impl Case {
    /// What was recorded without noise: back, acceleration, current; and what was played.
    fn take(&self) -> [Vec<f64>; 4] {
        let volts = steps(self.volts, self.p.mechanical_time(), self.rate).unwrap();
        let held: Vec<f64> = volts.iter().flat_map(|v| std::iter::repeat_n(*v, self.fine)).collect();
        let [x, i] = turn(&self.p, self.rate * self.fine as f64, &held);
        let of = |x: &[f64]| sampled(x, self.fine, self.late, 500 * self.fine, self.by);
        [of(&held), of(&x), of(&i), volts]
    }

    fn identify(&self, scratch: &Scratch, take: &[Vec<f64>; 4], seed: u64, channels: &str) -> Value {
        let [back, x, i, volts] = take;
        record(scratch, "d.wav", self.rate, Encoding::F32, &[(volts, SCALES[0])]);
        let (x, i) = (Noise(2 * seed + 1).on(x, 40.0), Noise(2 * seed + 2).on(i, 40.0));
        let back = Noise(seed + 777).on(back, 60.0);
        record(
            scratch,
            "take.wav",
            self.rate,
            Encoding::F32,
            &[(&x, SCALES[1]), (&i, SCALES[2]), (&back, SCALES[0])],
        );
        let mass = self.p.casing.mass().unwrap().to_string();
        let scales = SCALES.map(|scale| scale.to_string());
        let words = [
            "identify",
            "take.wav",
            "--drive",
            "d.wav",
            "--channels",
            channels,
            "--part",
            self.name,
            "--drive-scale",
            &scales[0],
            "--acceleration-scale",
            &scales[1],
            "--current-scale",
            &scales[2],
            "--mass",
            &mass,
            "--json",
        ];
        scratch.run(&words).succeeds().json()
    }
}

/// Of all figures of some cases and seeds: every one near its interval, and about as many inside as 95 % says.
fn holds(cases: &[(Case, u64, &str)], scratch: &Scratch) -> Vec<Value> {
    let (mut inside, mut outside, mut answers) = (0, Vec::new(), Vec::new());
    for (case, seeds, channels) in cases {
        let take = case.take();
        for seed in 0..*seeds {
            let said = case.identify(scratch, &take, seed, channels);
            let title =
                format!("{} at {} Hz, late {}/{}, {seed}", case.name, case.rate, case.late, case.fine);
            let late = said["delay"].as_f64().unwrap() * case.rate - case.late as f64 / case.fine as f64;
            assert!(late.abs() < 1.0, "{title}: the delay is {late} samples off");
            for figure in said["told"].as_array().unwrap() {
                let name = figure["name"].as_str().unwrap();
                let Some((_, truth)) = absolutes(&case.p).into_iter().find(|(one, _)| *one == name) else {
                    continue;
                };
                let value = figure["value"].as_f64().unwrap();
                let [least, most] = [0, 1].map(|n| figure["interval"][n].as_f64().unwrap());
                let text = format!("{title}: {name} = {value} ({least} to {most}), but it is {truth}");
                let side = if truth < value { value - least } else { most - value };
                assert!((value / truth - 1.0).abs() < 0.03, "{text}");
                assert!((value - truth).abs() < 1.6 * side, "{text}");
                if (least..=most).contains(&truth) { inside += 1 } else { outside.push(text) }
            }
            answers.push(said);
        }
    }
    assert!(outside.len() * 14 <= inside, "of {inside} and {}: {outside:#?}", outside.len());
    answers
}

const ALONE: &str = "acceleration,current,-";
const LOOPED: &str = "acceleration,current,drive";

/// A coil of less than a sample: how late the recording is and how slow the coil do not come apart, and so it is not told.
#[test]
fn a_quick_coil_is_no_delay() {
    let scratch = Scratch::new("identify-quick");
    let case = |rate, fine, late, by| Case { name: "coin-10mm", p: coin(), volts: 3.0, rate, fine, late, by };
    let all = [
        (case(8e3, 4, 3001 * 4, Converter::Points), 3, ALONE),
        (case(8e3, 4, 777 * 4 + 1, Converter::Points), 2, ALONE),
        (case(8e3, 4, 777 * 4 + 2, Converter::Band), 2, ALONE),
        (case(8e3, 4, 777 * 4 + 1, Converter::Points), 2, LOOPED),
        (case(48e3, 2, 777 * 2 + 1, Converter::Points), 1, ALONE),
    ];
    for said in holds(&all, &scratch) {
        assert!(why_not(&said, "inductance").contains("cannot be told from a delay"), "{said:#}");
        let told = said["told"].as_array().unwrap();
        for (name, _) in &absolutes(&coin())[..9] {
            assert!(told.iter().any(|figure| figure["name"] == *name), "{name}: {said:#}");
        }
    }
}

/// A coil of some samples: it is told, whatever the delay.
#[test]
fn a_slow_coil_is_told_beside_a_delay() {
    let scratch = Scratch::new("identify-slow");
    let case =
        |rate, fine, late, by| Case { name: "constar-vc2039", p: pad(), volts: 9.0, rate, fine, late, by };
    let all = [
        (case(8e3, 4, 3001 * 4, Converter::Points), 2, ALONE),
        (case(8e3, 4, 777 * 4 + 1, Converter::Points), 2, ALONE),
        (case(8e3, 4, 777 * 4 + 2, Converter::Band), 1, ALONE),
        (case(8e3, 4, 777 * 4 + 2, Converter::Band), 1, LOOPED),
        (case(24e3, 4, 777 * 4 + 1, Converter::Points), 2, LOOPED),
        (case(48e3, 2, 777 * 2 + 1, Converter::Points), 1, ALONE),
    ];
    for said in holds(&all, &scratch) {
        let told = said["told"].as_array().unwrap();
        assert!(told.iter().any(|figure| figure["name"] == "inductance"), "{said:#}");
    }
}
