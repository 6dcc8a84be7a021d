//! The engine in somebody else's audio callback: events and a control reach it through a ring, and nothing in the callback
//! allocates, locks or blocks. The sound card is simulated: it asks for as many frames as it likes, a different number each
//! time, and what comes out does not depend on that.
//!
//! Run it with `cargo run --example callback`.

use std::error::Error;

use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::engine::guard::Guard;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::schedule::Instant;
use pacinian::{NoAssets, Patch, Rig};
use ringbuf::HeapRb;
use ringbuf::traits::{Consumer, Producer, Split};

const PATCH: &str = r#"
format = "pacinian-patch/1"
title  = "Keys"

[control.strength]
default   = 1.0
range     = [0.0, 1.0]
smoothing = 0.02

[voice.key]
output = "felt"
[voice.key.nodes]
tone = { type = "sine", frequency = "event.frequency" }
hit  = { type = "envelope", attack = 0.005, decay = 0.1, sustain = 0.5, release = 0.05 }
felt = { type = "multiply", inputs = ["tone", "hit", "strength"] }
"#;

const CHANNELS: usize = 2;
const SECOND: usize = 48_000;

fn main() -> Result<(), Box<dyn Error>> {
    let patch = Patch::parse("keys.toml", PATCH.as_bytes())?.value;
    // `live`: all voices are built, since nobody knows beforehand which ones the program will play.
    let options = Options { live: true, ..Options::default() };
    let rig = Rig::default_for(CHANNELS as u32);
    let plan = scene(&patch, &rig, &options, &NoAssets)?.plan;

    let few = perform(&plan, &[480])?;
    let many = perform(&plan, &[1, 64, 7, 333, 128])?;
    let same = few.iter().zip(&many).all(|(a, b)| a.to_bits() == b.to_bits());
    let (before, after) = few.split_at(few.len() / 2);
    println!("peak {:.2}, and {:.2} with the strength turned down to 0.25", peak(before), peak(after));
    println!(
        "callbacks of 480 frames and of 1 to 333 frames: {}",
        if same { "the same bits" } else { "DIFFERENT" }
    );
    assert!(same && peak(before) > 0.5 && peak(after) < 0.3);
    Ok(())
}

/// Two seconds, in callbacks of these lengths.
fn perform(plan: &Plan, lengths: &[usize]) -> Result<Vec<f32>, Box<dyn Error>> {
    let mut engine = Engine::new(plan)?;
    let rate = plan.engine_rate();

    // The thread that has the ideas. Every event says when, so it may be sent ahead of its time.
    let (mut hand, mut ear) = HeapRb::<(Instant, Event)>::new(64).split();
    let strength = plan.control("strength")?;
    for n in 0..8_u32 {
        let key = plan.play("key", &[("frequency", 80.0 + 20.0 * f64::from(n)), ("duration", 0.15)])?;
        let place = plan.place(if n % 2 == 0 { "t1" } else { "t2" })?;
        let play = Play { place, id: u64::from(n), ..key };
        let at = Instant::of_samples(0.25 * f64::from(n) * rate);
        hand.try_push((at, Event::Play(play))).map_err(|_| "the ring is full")?;
    }
    let at = Instant::of_samples(0.9 * rate);
    hand.try_push((at, Event::Control(strength, 0.25))).map_err(|_| "the ring is full")?;

    // What a sound card would call. Nothing in it panics; should it do so after all, the guard makes it silence.
    let mut guard = Guard::default();
    let fault = guard.fault();
    let mut callback = move |output: &mut [f32]| {
        guard.call(output, |output| {
            while let Some((at, event)) = ear.try_pop() {
                engine.schedule(at, Source::Program, event);
            }
            engine.process(output);
        });
    };

    let mut heard = vec![0.0; 2 * SECOND * CHANNELS];
    let mut rest = &mut heard[..];
    for length in lengths.iter().cycle() {
        let (now, later) = rest.split_at_mut((length * CHANNELS).min(rest.len()));
        callback(now);
        if later.is_empty() {
            break;
        }
        rest = later;
    }
    assert!(!fault.is_latched());
    Ok(heard)
}

fn peak(samples: &[f32]) -> f32 {
    samples.iter().fold(0.0, |peak, x| peak.max(x.abs()))
}
