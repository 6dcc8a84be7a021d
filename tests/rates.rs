//! Every rate of a device keeps pitch, timing and band limit.

mod common;

use common::{channel, compiled, moments, patch, play, rendered, run, schedule};
use pacinian::engine::Engine;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use std::f64::consts::{PI, TAU};

const RATES: [f64; 5] = [44_100.0, 48_000.0, 88_200.0, 96_000.0, 192_000.0];

const HERTZ: [f64; 4] = [37.3, 123.456, 250.0, 640.01];

const TONES: &str = r#"
[voice.v]
voices = 8
output = "o"
[voice.v.nodes]
t = { type = "sine", frequency = "event.frequency", amplitude = 0.5 }
e = { type = "envelope", attack = 0.01 }
o = { type = "multiply", inputs = ["t", "e"] }
"#;

/// Turns by which tones that began at engine sample 0 differ in `frames`, the first of which is number `from`, from sines of
/// exactly their frequencies through the designed output stage.
fn wrong_turns(engine: &Engine, frames: &[f32], from: u64, rate: f64) -> Vec<f64> {
    let length = frames.len() / HERTZ.len();
    HERTZ
        .iter()
        .enumerate()
        .map(|(c, &hertz)| {
            let windowed: Vec<f64> = channel(frames, HERTZ.len(), c)
                .iter()
                .enumerate()
                // Hann squared: side lobes fall by 30 dB an octave.
                .map(|(n, x)| x * (PI * (n as f64 + 0.5) / length as f64).sin().powi(4))
                .collect();
            let (re, im) = moments(&windowed, hertz, rate)[0];
            let response = engine.stage().vibration().response(0, hertz);
            let begun = (hertz * (from as f64 / rate - engine.delay().lead)).fract();
            let wrong = im.atan2(re) / TAU + 0.25 - begun - response.im.atan2(response.re) / TAU;
            (wrong + 0.5).rem_euclid(1.0) - 0.5
        })
        .collect()
}

fn tones(plan: &Plan) -> Engine {
    let mut engine = Engine::new(plan).unwrap();
    let events: Vec<_> =
        HERTZ.iter().zip(0..).map(|(f, i)| (0.0, play(0, i, *f, f64::INFINITY, u64::from(i)))).collect();
    schedule(&mut engine, &events);
    engine
}

#[test]
fn pitch_after_ten_seconds() {
    for rate in RATES {
        let plan = compiled(TONES, HERTZ.len() as u32, rate).plan;
        let mut engine = tones(&plan);
        run(&mut engine, 9 * rate as usize, &[4096]);
        let frames = run(&mut engine, rate as usize, &[4096]);
        let wrong = wrong_turns(&engine, &frames, 9 * rate as u64, rate);
        println!("{rate}: {wrong:?} turns");
        assert!(wrong.iter().all(|w| w.abs() < 1e-6), "{wrong:?} turns at {rate} Hz");
    }
}

/// At the lowest cost there is: a device at the engine's own rate.
#[test]
fn pitch_after_an_hour() {
    let rate = 8000.0;
    let mut plan = compiled(TONES, HERTZ.len() as u32, rate).plan;
    assert_eq!(plan.ratio, 1);
    plan.taps = 4;
    let mut engine = tones(&plan);
    let mut second = vec![0.0; 8000 * HERTZ.len()];
    for _ in 0..3600 {
        engine.process(&mut second);
    }
    let wrong = wrong_turns(&engine, &second, 3599 * 8000, rate);
    println!("an hour: {wrong:?} turns");
    assert!(wrong.iter().all(|w| w.abs() < 1e-6), "{wrong:?} turns");
}

/// The middle of a click, seconds, where the output stage delays it by what it says of low frequencies.
#[test]
fn onsets_keep_their_instant() {
    let text = r#"
        [voice.v]
        voices = 16
        output = "e"
        [voice.v.nodes]
        e = { type = "burst", attack = 0.002, decay = 0.002 }
    "#;
    for rate in RATES {
        let plan = compiled(text, 1, rate).plan;
        for at in [0.0, 0.01, 0.012_345_678, 0.3 - 1e-5] {
            let (engine, frames) = rendered(&plan, &[(at, play(0, 0, 0.0, 0.01, 1))], 0.1);
            let [(zeroth, _), (first, _)] = moments(&channel(&frames, 1, 0), 0.0, rate);
            let response = engine.stage().vibration().response(0, 1.0);
            let stage = -response.im.atan2(response.re) / TAU;
            let wrong = first / zeroth - (at + 0.002 + engine.delay().lead + stage);
            assert!(wrong.abs() < 1e-6, "a click at {at} s is {wrong} s late at {rate} Hz");
        }
    }
}

/// A square of 333 Hz with hard edges, over full scale: its power above 1 kHz, measured tone by tone.
#[test]
fn the_band_ends_at_1_khz() {
    let text = r#"
        [voice.v]
        output = "o"
        [voice.v.nodes]
        t = { type = "pulse", frequency = 333, amplitude = 2 }
        e = { type = "gate" }
        o = { type = "multiply", inputs = ["t", "e"] }
    "#;
    for rate in RATES {
        let plan = compiled(text, 1, rate).plan;
        let (_, frames) = rendered(&plan, &[(0.0, play(0, 0, 333.0, 2.0, 1))], 0.0);
        let (from, length) = ((0.5 * rate) as usize, rate as usize);
        let middle: Vec<f64> = channel(&frames, 1, 0)[from..from + length]
            .iter()
            .enumerate()
            .map(|(n, x)| x * (PI * n as f64 / length as f64).sin().powi(4))
            .collect();
        let size = |hertz: f64| {
            let (re, im) = moments(&middle, hertz, rate)[0];
            re.hypot(im)
        };
        let tone = size(333.0);
        // Harmonics, and where harmonics beyond half the engine's rate and images of the up-sampling would come down.
        let engine_rate = plan.engine_rate();
        let mut suspects: Vec<f64> = (4..20).map(|k| 333.0 * f64::from(k)).collect();
        for k in 1..40 {
            for image in [1.0, 2.0] {
                suspects.push((image * engine_rate - 333.0 * f64::from(k)).abs());
            }
        }
        for hertz in suspects.into_iter().filter(|f| *f > 1000.0 && *f < rate / 2.0) {
            let share = 20.0 * (size(hertz) / tone).log10();
            assert!(share < -60.0, "{share} dB at {hertz} Hz, {rate} frames a second");
        }
    }
}

/// The ratio of the rates is an option: the engine then runs at another rate, and all of it knows.
#[test]
fn another_ratio_keeps_pitch() {
    for (rate, ratio) in [(48_000.0, 5), (48_000.0, 4), (96_000.0, 11)] {
        let options = Options { rate: Some(rate), ratio: Some(ratio), live: true, ..Options::default() };
        let plan =
            scene(&patch(TONES), &Rig::default_for(HERTZ.len() as u32), &options, &NoAssets).unwrap().plan;
        let mut engine = tones(&plan);
        run(&mut engine, rate as usize, &[4096]);
        assert_eq!(engine.clock(), (rate as u64).div_ceil(ratio as u64));
        let frames = run(&mut engine, rate as usize, &[4096]);
        let wrong = wrong_turns(&engine, &frames, rate as u64, rate);
        assert!(wrong.iter().all(|w| w.abs() < 1e-6), "{wrong:?} turns at {rate} Hz, ratio {ratio}");
    }
}

/// A ratio that lets the engine run too fast or too slowly is refused, not bent.
#[test]
fn a_ratio_out_of_range_is_refused() {
    for (ratio, good) in [(0, false), (3, false), (4, true), (8, true), (9, false), (1000, false)] {
        let options = Options { rate: Some(48_000.0), ratio: Some(ratio), ..Options::default() };
        let scene = scene(&patch(TONES), &Rig::default_for(1), &options, &NoAssets);
        assert_eq!(scene.is_ok(), good, "{ratio}");
        if let Err(problems) = scene {
            assert!(problems.list[0].what.contains(&format!("a ratio of {ratio} ")), "{problems}");
        }
    }
}
