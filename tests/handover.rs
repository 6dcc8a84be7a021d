//! Plans that follow one another while they sound.

mod common;

use common::{compiled, play, schedule};
use pacinian::engine::exchange::exchange;
use pacinian::graph::plan::Plan;

const FIRST: &str = r#"
[control.strength]
default = 0.7
range = [0.0, 1.0]
[shared.nodes]
wobble = { type = "sine", frequency = 3 }
[voice.beat]
voices = 6
output = "out"
[voice.beat.nodes]
tone = { type = "sine", frequency = "event.frequency + 20 * wobble" }
hit = { type = "envelope", attack = 0.004, decay = 0.03, sustain = 0.4, release = 0.02 }
out = { type = "multiply", inputs = ["tone", "hit", "strength"] }
"#;

const OTHER: &str = r#"
[voice.other]
output = "out"
[voice.other.nodes]
tone = { type = "sine", frequency = "event.frequency" }
hit = { type = "envelope" }
out = { type = "multiply", inputs = ["tone", "hit"] }
"#;

/// Frames of a run in calls of 48 frames; before the n-th call, the plan that `change` names is sent.
fn run(first: &Plan, calls: usize, mut change: impl FnMut(usize) -> Option<Plan>) -> Vec<f32> {
    let (mut director, mut stagehand) = exchange(first).unwrap();
    let events: Vec<_> = (0..30_u32)
        .map(|i| (f64::from(i) * 97.3, play(0, i % 4, 50.0 + 11.0 * f64::from(i), 0.05, u64::from(i))))
        .collect();
    schedule(stagehand.engine(), &events);
    let mut output = vec![0.0; calls * 48 * 4];
    for (n, part) in output.chunks_mut(48 * 4).enumerate() {
        if let Some(plan) = change(n) {
            director.send(&plan).unwrap();
        }
        stagehand.process(&[], part);
    }
    output
}

fn largest_step(frames: &[f32]) -> f32 {
    frames.iter().zip(&frames[4..]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn the_same_plan_again_changes_no_bit() {
    let plan = compiled(FIRST, 4, 48_000.0).plan;
    let once = run(&plan, 400, |_| None);
    let again = run(&plan, 400, |n| (n % 3 == 1).then(|| plan.clone()));
    assert!(once.iter().any(|x| *x != 0.0));
    assert!(once.iter().map(|x| x.to_bits()).eq(again.iter().map(|x| x.to_bits())));
}

#[test]
fn a_changed_graph_steps_no_more_than_an_unchanged_one() {
    let plan = compiled(FIRST, 4, 48_000.0).plan;
    let with_more = FIRST
        .replace("\"strength\"]", "\"strength\", \"soft\"]")
        .replace("out = {", "soft = { type = \"envelope\", attack = 0.05, release = 0.05 }\nout = {");
    let more = compiled(&with_more, 4, 48_000.0).plan;
    let without = compiled(OTHER, 4, 48_000.0).plan;
    let plain = largest_step(&run(&plan, 400, |_| None));
    for (name, other) in [("a node more", &more), ("the voice gone", &without)] {
        let changed = run(&plan, 400, |n| (n == 100).then(|| other.clone()));
        let step = largest_step(&changed);
        assert!(step <= plain * 1.05, "{name}: a step of {step} where {plain} was the largest");
    }
    // What has no counterpart falls silent.
    let gone = run(&plan, 400, |n| (n == 100).then(|| without.clone()));
    assert!(gone[48 * 4 * 250..].iter().all(|x| x.abs() < 1e-4));
    assert!(gone[..48 * 4 * 100].iter().any(|x| x.abs() > 0.05));
}

#[test]
fn no_more_than_two_are_under_way() {
    let plan = compiled(FIRST, 4, 48_000.0).plan;
    let (mut director, mut stagehand) = exchange(&plan).unwrap();
    assert!(director.send(&plan).unwrap());
    assert!(director.send(&plan).unwrap());
    assert!(!director.send(&plan).unwrap());
    let mut frames = vec![0.0; 4 * 480];
    for _ in 0..4 {
        stagehand.process(&[], &mut frames);
    }
    assert_eq!(director.collect(), 0);
    assert!(director.send(&plan).unwrap());
}

/// A voice that is always on begins in every engine that is built for it; what takes over must go on with the one that sounds.
#[test]
fn a_voice_that_is_always_on_goes_on_alone() {
    let hum = "[voice.hum]\nstart = \"always\"\noutput = \"tone\"\n[voice.hum.nodes]\n\
               tone = { type = \"sine\", frequency = 100, amplitude = 0.5 }\n";
    let plan = |text: &str| compiled(text, 1, 48_000.0).plan;
    let run = |change: &dyn Fn(usize) -> Option<Plan>| {
        let (mut director, mut stagehand) = exchange(&plan(hum)).unwrap();
        let mut output = vec![0.0; 400 * 64];
        for (n, part) in output.chunks_mut(64).enumerate() {
            if let Some(plan) = change(n) {
                director.send(&plan).unwrap();
            }
            stagehand.process(&[], part);
        }
        output
    };
    let steady = run(&|_| None);
    assert_eq!(run(&|n| (n % 20 == 7).then(|| plan(hum))), steady);
    let changed = run(&|n| (n == 200).then(|| plan(&format!("{hum}{OTHER}"))));
    let error = changed.iter().zip(&steady).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    // What the extrapolation of two samples misses of a sine: 0.5 (2π 100 / 8000)² at most.
    assert!(error < 0.0031, "{error}");
}
