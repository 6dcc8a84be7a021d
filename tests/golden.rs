//! Golden files: what three short scenes should be, as the scene reference made it. The engine must meet them, and so must the
//! reference of today, so that a twin that changes is noticed as well.
//!
//! A file holds `f32` numbers, little-endian, interleaved, at the engine's rate; of them, 0 to 1 kHz counts. After a change
//! of a definition that is meant, they are made again by
//!
//! ```text
//! UPDATE_GOLDEN=1 cargo test --features report --test golden
//! ```
//!
//! which takes them from the reference, never from the engine.
#![cfg(feature = "report")]

mod common;

use common::{compiled, play, reference_as_frames, rendered};
use pacinian::engine::event::Play;
use pacinian::graph::plan::Plan;
use pacinian::report::measure::{OVER, designed};
use pacinian::report::{Reference, compare, reference};
use std::path::PathBuf;

struct Scene {
    name: &'static str,
    text: &'static str,
    channels: u32,
    events: fn() -> Vec<(f64, Play)>,
    /// Error of the engine that is borne, dB: less for what is hard, as envelopes of 1 ms are.
    most: f64,
}

const SCENES: [Scene; 3] = [
    Scene {
        name: "heartbeat",
        text: r#"
            [voice.beat]
            voices = 8
            output = "thud"
            [voice.beat.nodes]
            drop = { type = "burst", attack = 0.005, decay = 0.05 }
            tone = { type = "sine", frequency = "event.frequency + 40 * drop" }
            hit = { type = "envelope", attack = 0.004, decay = 0.08, sustain = 0.0, decay_curve = -4 }
            thud = { type = "multiply", inputs = ["tone", "hit"] }
        "#,
        channels: 2,
        most: -80.0,
        events: || {
            [(0.0101, 0, 0.8, 60.0), (0.1207, 1, 0.6, 50.0)]
                .map(|(at, c, level, f)| (at, Play { level, ..play(0, c, f, 0.1, u64::from(c)) }))
                .to_vec()
        },
    },
    Scene {
        name: "engine",
        text: r#"
            [shared.nodes]
            sway = { type = "lfo", rate = 7 }
            [voice.idle]
            voices = 8
            output = "out"
            [voice.idle.nodes]
            teeth = { type = "sawtooth", frequency = "event.frequency * (1 + 0.1 * sway)", amplitude = 0.5 }
            body = { type = "lowpass", input = "teeth", cutoff = 300, q = 2 }
            swell = { type = "envelope", attack = 0.03, release = 0.04 }
            out = { type = "multiply", inputs = ["body", "swell"] }
        "#,
        channels: 2,
        most: -80.0,
        events: || {
            (0..2_u32)
                .map(|i| {
                    (0.0333 * f64::from(i) + 0.005, play(0, i, 31.0 + 9.7 * f64::from(i), 0.15, u64::from(i)))
                })
                .collect()
        },
    },
    Scene {
        name: "clicks",
        text: r#"
            [voice.tick]
            voices = 16
            output = "out"
            [voice.tick.nodes]
            carrier = { type = "triangle", frequency = "event.frequency" }
            tap = { type = "burst", attack = 0.001, hold = 0.001, decay = 0.004, decay_curve = -3 }
            dry = { type = "multiply", inputs = ["carrier", "tap"] }
            again = { type = "delay", input = "dry", time = 0.0213, longest = 0.05 }
            hold = { type = "gate", fall = 0.05 }
            out = { type = "multiply", inputs = ["dry + 0.5 * again", "hold"] }
        "#,
        channels: 3,
        most: -70.0,
        events: || {
            (0..9_u32)
                .map(|i| {
                    let one = play(0, i % 3, 90.0 + 37.0 * f64::from(i), 0.03, u64::from(i));
                    (0.004 + 0.0187 * f64::from(i), Play { level: 0.7, ..one })
                })
                .collect()
        },
    },
];

fn plan(scene: &Scene) -> Plan {
    compiled(scene.text, scene.channels, 48_000.0).plan
}

fn path(scene: &Scene) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(scene.name).with_extension("f32")
}

fn seconds(frames: &[f32], plan: &Plan) -> f64 {
    frames.len() as f64 / plan.channels as f64 / plan.device_rate
}

/// The golden file, made first where that is asked for.
fn golden(scene: &Scene, today: &Reference) -> Reference {
    let path = path(scene);
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        let bytes: Vec<u8> = reference_as_frames(today).iter().flat_map(|x| x.to_le_bytes()).collect();
        std::fs::write(&path, bytes).unwrap();
    }
    let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    assert!(bytes.len() < 60_000, "{} holds {} bytes", path.display(), bytes.len());
    let values: Vec<f64> =
        bytes.as_chunks::<4>().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect();
    let channels = scene.channels as usize;
    let split = (0..channels).map(|c| values.iter().skip(c).step_by(channels).copied().collect());
    Reference { rate: today.rate, channels: split.collect() }
}

#[test]
fn engine_and_reference_meet_them() {
    for scene in &SCENES {
        let plan = plan(scene);
        let events = (scene.events)();
        let (engine, frames) = rendered(&plan, &events, 0.1);
        assert_eq!(engine.stage().counts().limited, 0, "{}: the reference knows no limiter", scene.name);
        let today = reference(&plan, &events, seconds(&frames, &plan), OVER);
        let golden = golden(scene, &today);
        assert_eq!(golden.channels[0].len(), today.channels[0].len(), "{}: length", scene.name);
        assert!(golden.channels.iter().all(|c| c.iter().any(|x| x.abs() > 0.05)), "{}: silent", scene.name);

        let twins = compare(&reference_as_frames(&today), &golden, 1, 0.0, &|_, _| 1.0.into());
        let delay = engine.delay();
        let found = compare(
            &frames,
            &golden,
            plan.ratio,
            delay.lead + delay.up_sampling + delay.band_limit_phase,
            &|channel, hertz| designed(&engine, channel, hertz),
        );
        println!("{}: engine {:.1} dB, reference {:.1} dB", scene.name, found.error_db, twins.error_db);
        assert!(twins.error_db < -120.0, "{}: the reference has changed: {twins:?}", scene.name);
        assert!(found.error_db < scene.most, "{}: the engine is off: {found:?}", scene.name);
    }
}
