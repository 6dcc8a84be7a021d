//! What several tests share.
#![allow(dead_code)]

use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::graph::scene::{Options, Scene, scene};
use pacinian::graph::start::FIELDS;
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;

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
    scene(&patch, &Rig::default_for(channels), &options, &NoAssets).unwrap_or_else(|p| panic!("{p:?}"))
}

/// A voice on a channel (from 0) with a frequency.
pub fn play(instrument: u32, place: u32, frequency: f64, duration: f64, id: u64) -> Play {
    let mut own = [0.0; FIELDS];
    own[0] = frequency;
    Play { instrument, place, level: 1.0, duration, own, id }
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
