//! What the engine computes does not depend on how time is cut into calls, on the instruction set, or on the run.

mod common;

use common::scenes::busy;
#[cfg(feature = "fundsp-nodes")]
use common::scenes::leaves;
use common::{compiled, play, run, schedule};
use pacinian::dsp::isa::Isa;
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Source};
use pacinian::graph::plan::Precision;
use pacinian::schedule::Instant;

/// Each with each precision.
fn scenes() -> impl Iterator<Item = (String, Precision)> {
    let patches = [
        busy(5, 3),
        #[cfg(feature = "fundsp-nodes")]
        leaves(5, 3),
    ];
    patches.into_iter().flat_map(|patch| [(patch.clone(), Precision::Single), (patch, Precision::Double)])
}

fn rendered(patch: &str, isa: Isa, precision: Precision, calls: &[usize]) -> Vec<u32> {
    let mut plan = compiled(patch, 11, 48_000.0).plan;
    plan.precision = precision;
    let mut engine = Engine::with_isa(&plan, isa).unwrap();
    let mut events = Vec::new();
    for i in 0..40_u32 {
        let at = f64::from(i) * 61.37;
        events.push((
            at,
            play(i % 2, i % 11, 40.0 + 13.0 * f64::from(i), 0.002 * f64::from(i % 30), u64::from(i)),
        ));
    }
    schedule(&mut engine, &events);
    let output = run(&mut engine, 24_000, calls);
    assert!(output.iter().all(|x| x.is_finite()));
    assert!(output.iter().any(|x| *x != 0.0));
    assert!(engine.counters().stolen > 0, "the scene must steal");
    output.iter().map(|x| x.to_bits()).collect()
}

#[test]
fn any_cut_gives_the_same_bits() {
    for (patch, precision) in scenes() {
        let whole = rendered(&patch, Isa::detect(), precision, &[24_000]);
        for calls in [&[1][..], &[7], &[64], &[480], &[3, 1000, 1, 17, 250, 64]] {
            assert!(
                rendered(&patch, Isa::detect(), precision, calls) == whole,
                "{precision:?} in calls of {calls:?}"
            );
        }
    }
}

#[test]
fn any_instruction_set_gives_the_same_bits() {
    for (patch, precision) in scenes() {
        let best = rendered(&patch, Isa::detect(), precision, &[480]);
        assert!(rendered(&patch, Isa::Baseline, precision, &[480]) == best, "{precision:?}");
    }
}

/// Noise of the shared nodes and noise of the same name in the first voice that is always on are two noises.
#[test]
fn shared_and_always_on_noise_differ() {
    let text = r#"
[shared.nodes]
hiss = { type = "white" }
heard = { type = "multiply", inputs = ["hiss", 0.5] }
[voice.a]
start = "always"
output = "out"
[voice.a.nodes]
hiss = { type = "white" }
out = { type = "add", inputs = ["hiss", "-2 * heard"] }
"#;
    let mut engine = Engine::new(&compiled(text, 1, 48_000.0).plan).unwrap();
    let frames = run(&mut engine, 24_000, &[512]);
    let power = frames.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>() / frames.len() as f64;
    assert!(power > 1e-3, "{power}");
}

/// A control at rest is computed once and for all; a voice that gives it out as it is must not spend it.
#[test]
fn a_voice_that_is_a_control_does_not_depend_on_cuts() {
    let text = r#"
[control.push]
default = 0.25
range = [0.0, 1.0]
[voice.press]
start = "always"
output = "out"
[voice.press.nodes]
out = { type = "multiply", inputs = ["push"] }
"#;
    let plan = compiled(text, 1, 48_000.0).plan;
    let rendered = |calls: &[usize]| -> Vec<u32> {
        let mut engine = Engine::new(&plan).unwrap();
        let mut frames = run(&mut engine, 4800, calls);
        engine.schedule(Instant::of_samples(900.0), Source::Program, Event::Control(0, 0.75));
        frames.extend(run(&mut engine, 19_200, calls));
        frames.iter().map(|x| x.to_bits()).collect()
    };
    let whole = rendered(&[24_000]);
    // It goes on at what it was sent to.
    assert!((f32::from_bits(whole[23_999]) - 0.75).abs() < 0.05, "{}", f32::from_bits(whole[23_999]));
    for calls in [&[1][..], &[7], &[64], &[3, 1000, 1, 17, 250, 64]] {
        assert!(rendered(calls) == whole, "in calls of {calls:?}");
    }
}
