//! A patch is edited while it plays: the new plan takes over between two blocks, what is the same in both goes on without a
//! step, what is gone fades out, and the old engine is freed on the control thread.
//!
//! Run it with `cargo run --example hand_over`.

use std::error::Error;

use pacinian::engine::event::{Event, Source};
use pacinian::engine::exchange::exchange;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::schedule::Instant;
use pacinian::text::Problems;
use pacinian::{NoAssets, Patch, Rig};

const PATCH: &str = r#"
format = "pacinian-patch/1"
title  = "A hum that is edited"

[voice.hum]
output = "felt"
[voice.hum.nodes]
tone = { type = "sine", frequency = "event.frequency" }
rise = { type = "envelope", attack = 0.1, release = 0.1 }
felt = { type = "multiply", inputs = ["tone", "rise"] }
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let first = compiled(PATCH)?;
    // Half as strong, and a tremolo.
    let text = PATCH.replace(r#"["tone", "rise"]"#, r#"["tone", "rise", "0.5 + 0.2 * sway"]"#);
    let second = compiled(&format!("{text}sway = {{ type = \"lfo\", rate = 4 }}\n"))?;

    let (mut director, mut stagehand) = exchange(&first)?;
    // No duration: it is held.
    let play = first.play("hum", &[("frequency", 80.0)])?;
    stagehand.engine().schedule(Instant::default(), Source::Program, Event::Play(play));

    // In a program, the stagehand lives in the audio callback and the director with whoever edits; here they take turns.
    let mut frames = vec![0.0_f32; 96_000];
    for (n, block) in frames.chunks_mut(480).enumerate() {
        if n == 100 && !director.send(&second)? {
            return Err("two plans are still under way".into());
        }
        stagehand.process(&[], block);
    }

    let (before, after) = frames.split_at(48_000);
    println!(
        "peak {:.2} before, {:.2} after; {} voice goes on",
        peak(before),
        peak(after),
        stagehand.engine().sounding()
    );
    println!("largest step {:.4} before, {:.4} after", step(before), step(&frames[47_900..]));
    println!("engines still to be freed: {}", director.collect());
    assert!(
        step(&frames[47_900..]) <= step(before)
            && peak(&after[9_600..]) < 0.75
            && peak(&after[9_600..]) > 0.6
    );
    assert_eq!(director.collect(), 0);
    Ok(())
}

fn compiled(text: &str) -> Result<Plan, Problems> {
    let patch = Patch::parse("hum.toml", text.as_bytes())?.value;
    let options = Options { live: true, ..Options::default() };
    Ok(scene(&patch, &Rig::default_for(1), &options, &NoAssets)?.plan)
}

fn peak(samples: &[f32]) -> f32 {
    samples.iter().fold(0.0, |peak, x| peak.max(x.abs()))
}

/// The largest difference between neighbouring samples: a click would stand out.
fn step(samples: &[f32]) -> f32 {
    samples.windows(2).fold(0.0, |step, w| step.max((w[1] - w[0]).abs()))
}
