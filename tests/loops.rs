//! Loops through a delay, and audio input.

mod common;

use common::{compiled, play, run, schedule};
use pacinian::engine::Engine;

const ECHO: &str = r#"
[voice.echo]
output = "sum"
[voice.echo.nodes]
tone = { type = "sine", frequency = "event.frequency" }
hit = { type = "burst", attack = 0.005, hold = 0.01, decay = 0.005 }
dry = { type = "multiply", inputs = ["tone", "hit", 0.4] }
sum = { type = "add", inputs = ["dry", "0.5 * back"] }
back = { type = "delay", input = "sum", time = 0.1, longest = 0.2 }
"#;

fn echoes(calls: &[usize]) -> Vec<f32> {
    let mut engine = Engine::new(&compiled(ECHO, 1, 48_000.0).plan).unwrap();
    schedule(&mut engine, &[(10.3, play(0, 0, 100.0, 0.02, 1))]);
    run(&mut engine, 48_000, calls)
}

#[test]
fn each_echo_is_half_the_one_before_and_comes_exactly_later() {
    let frames = echoes(&[480]);
    let energy = |k: usize| frames[4800 * k..4800 * (k + 1)].iter().map(|x| f64::from(x * x)).sum::<f64>();
    for k in 1..6 {
        let ratio = energy(k) / energy(k - 1);
        assert!((ratio - 0.25).abs() < 1e-3, "echo {k}: {ratio}");
        let worst = (0..4800)
            .map(|i| (frames[4800 * k + i] - 0.5 * frames[4800 * (k - 1) + i]).abs())
            .fold(0.0, f32::max);
        assert!(worst < 2e-4, "echo {k}: {worst}");
    }
}

#[test]
fn loops_do_not_mind_how_time_is_cut() {
    let whole = echoes(&[48_000]);
    for calls in [&[1][..], &[7], &[64, 3]] {
        assert!(echoes(calls) == whole);
    }
}

#[cfg(feature = "report")]
#[test]
fn loops_agree_with_the_reference() {
    let plan = compiled(ECHO, 1, 48_000.0).plan;
    let measured = pacinian::report::measure(&plan, &[(0.0123, play(0, 0, 100.0, 0.02, 1))], 2.5).unwrap();
    assert!(measured.comparison.error_db < -80.0, "{:?}", measured.comparison);
}

const LISTENING: &str = r#"
[shared.nodes]
ear = { type = "input", channel = 2 }
[voice.through]
start = "always"
output = "out"
[voice.through.nodes]
open = { type = "gate" }
out = { type = "multiply", inputs = ["ear", "open"] }
"#;

#[test]
fn input_passes_through_with_the_reported_delay() {
    let heard = |calls: &[usize]| {
        let mut engine = Engine::new(&compiled(LISTENING, 1, 48_000.0).plan).unwrap();
        assert_eq!(engine.input_channels(), 2);
        let delay = engine.delay();
        let late = engine.input_delay() + delay.up_sampling + delay.band_limit_phase;
        let tone = |n: usize| (std::f64::consts::TAU * 250.0 * n as f64 / 48_000.0).sin() as f32 * 0.5;
        let input: Vec<f32> = (0..24_000).flat_map(|n| [f32::NAN, tone(n)]).collect();
        let mut output = vec![0.0; 24_000];
        let (mut at, mut calls) = (0, calls.iter().cycle());
        while at < output.len() {
            let end = (at + calls.next().unwrap()).min(output.len());
            engine.process_input(&input[2 * at..2 * end], &mut output[at..end]);
            at = end;
        }
        (output, late)
    };
    let (whole, late) = heard(&[24_000]);
    for calls in [&[1][..], &[5], &[64, 3, 500]] {
        assert!(heard(calls).0 == whole, "{calls:?}");
    }
    for n in 12_000..12_400 {
        let exact = 0.5 * (std::f64::consts::TAU * 250.0 * (n as f64 / 48_000.0 - late)).sin();
        assert!((f64::from(whole[n]) - exact).abs() < 0.02, "frame {n}: {} for {exact}", whole[n]);
    }
}

/// What a scene should have been does not depend on number type and taps, but for the filter of an input, which has as many.
#[cfg(feature = "report")]
#[test]
fn settings_share_their_reference() {
    use pacinian::graph::plan::{Plan, Precision};
    use pacinian::report::Take;
    let sound: Vec<f32> = (0..9_600).map(|n| (f64::from(n) * 0.05).sin() as f32 * 0.5).collect();
    let events = [(0.01, play(0, 0, 100.0, 0.02, 1))];
    let with = |plan: &Plan, precision, taps| Plan { precision, taps, ..plan.clone() };

    let plan = compiled(ECHO, 1, 48_000.0).plan;
    let take = Take { events: &events, moves: &[], input: &[], seconds: 0.2 };
    let one = take.reference(&with(&plan, Precision::Single, 4));
    assert!(one.channels[0].iter().any(|x| x.abs() > 0.1));
    assert_eq!(one, take.reference(&with(&plan, Precision::Double, 12)));

    let plan = compiled(LISTENING, 1, 48_000.0).plan;
    let input = [Vec::new(), sound];
    let take = Take { events: &[], moves: &[], input: &input, seconds: 0.2 };
    let one = take.reference(&with(&plan, Precision::Single, 4));
    assert!(one.channels[0].iter().any(|x| x.abs() > 0.1));
    assert_eq!(one, take.reference(&with(&plan, Precision::Double, 4)));
    assert_ne!(one, take.reference(&with(&plan, Precision::Single, 12)));
    for taps in [4, 12] {
        let plan = with(&plan, Precision::Double, taps);
        let found = take.measure(&plan, &take.reference(&plan)).unwrap().comparison;
        assert!(found.error_db < -60.0, "{taps} taps: {found:?}");
    }
}
