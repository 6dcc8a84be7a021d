//! What several tests share.
#![allow(dead_code)]

pub mod scenes;
pub mod storm;

use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, Scene, scene};
use pacinian::graph::start::FIELDS;
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;
use pacinian::space::spot::Spot;

/// A patch from its text, with its first line supplied.
pub fn patch(text: &str) -> Patch {
    let text = format!("format = \"pacinian-patch/1\"\ntitle = \"A test\"\n{text}");
    match Patch::parse("test.toml", text.as_bytes()) {
        Ok(checked) => checked.value,
        Err(problems) => panic!("{problems}"),
    }
}

/// A compiled scene that is open to events from the program.
pub fn compiled(text: &str, channels: u32, rate: f64) -> Scene {
    let options = Options { rate: Some(rate), live: true, ..Options::default() };
    let patch = patch(text);
    scene(&patch, &Rig::default_for(channels), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"))
}

/// A voice on a channel (from 0) with a frequency.
pub fn play(instrument: u32, place: u32, frequency: f64, duration: f64, id: u64) -> Play {
    let mut own = [0.0; FIELDS];
    own[0] = frequency;
    Play { instrument, place: Spot::Row(place), level: 1.0, felt: None, duration, own, id }
}

/// Schedules voices at engine samples.
pub fn schedule(engine: &mut Engine, events: &[(f64, Play)]) {
    for (at, play) in events {
        assert!(engine.schedule(Instant::of_samples(*at), Source::Program, Event::Play(*play)));
    }
}

/// All frames of a run, computed in calls of these lengths (frames), again and again.
pub fn run(engine: &mut Engine, frames: usize, calls: &[usize]) -> Vec<f32> {
    let mut output = vec![f32::NAN; frames * engine.channels()];
    let mut rest = &mut output[..];
    for &call in calls.iter().cycle() {
        if rest.is_empty() {
            break;
        }
        let (now, later) = rest.split_at_mut((call * engine.channels()).min(rest.len()));
        engine.process(now);
        rest = later;
    }
    output
}

/// Plays events (seconds, in any order) from the program on a fresh engine; frames until `tail` seconds after the last one ended.
pub fn rendered(plan: &Plan, events: &[(f64, Play)], tail: f64) -> (Engine, Vec<f32>) {
    let mut engine = Engine::new(plan).unwrap();
    let rate = plan.engine_rate();
    for (at, play) in events {
        assert!(engine.schedule(Instant::of_samples(at * rate), Source::Program, Event::Play(*play)));
    }
    let end = events.iter().map(|(at, play)| at + play.duration.clamp(0.0, 10.0)).fold(0.0, f64::max);
    // Filters and the output stage ring for less than this.
    let samples = ((end + tail + 0.3) * rate).ceil() as usize;
    let frames = run(&mut engine, samples * plan.ratio, &[480]);
    (engine, frames)
}

/// One channel of interleaved frames.
pub fn channel(frames: &[f32], channels: usize, c: usize) -> Vec<f64> {
    frames.iter().skip(c).step_by(channels).map(|x| f64::from(*x)).collect()
}

/// Moments of a signal at a frequency (Hz), its first sample at time 0: Σ x e^(−iωt) and Σ t x e^(−iωt), as (re, im).
pub fn moments(signal: &[f64], hertz: f64, rate: f64) -> [(f64, f64); 2] {
    let (mut zeroth, mut first) = ((0.0, 0.0), (0.0, 0.0));
    for (n, x) in signal.iter().enumerate() {
        let t = n as f64 / rate;
        // Turns reduced before they become radians: exact far from the beginning.
        let (sin, cos) = (-std::f64::consts::TAU * (hertz * t).fract()).sin_cos();
        zeroth = (zeroth.0 + x * cos, zeroth.1 + x * sin);
        first = (first.0 + t * x * cos, first.1 + t * x * sin);
    }
    [zeroth, first]
}

/// A reference as if an engine without an output stage had made it.
#[cfg(feature = "report")]
pub fn reference_as_frames(reference: &pacinian::report::Reference) -> Vec<f32> {
    let length = reference.channels.first().map_or(0, Vec::len);
    (0..length).flat_map(|n| reference.channels.iter().map(move |c| c[n] as f32)).collect()
}

/// Silence.
#[cfg(feature = "report")]
pub fn silent_reference(channels: usize, length: usize, rate: f64) -> pacinian::report::Reference {
    pacinian::report::Reference { rate, channels: vec![vec![0.0; length]; channels] }
}
