//! The engine against the scene reference.
#![cfg(feature = "report")]

mod common;

use common::{compiled, play};
use pacinian::engine::event::Play;
use pacinian::report::measure::{OVER, designed};
use pacinian::report::{Measured, compare, measure, reference};

fn measured(nodes: &str, output: &str, rate: f64, events: &[(f64, Play)]) -> Measured {
    let text = format!("[voice.v]\nvoices = 64\noutput = \"{output}\"\n[voice.v.nodes]\n{nodes}");
    let plan = compiled(&text, 4, rate).plan;
    let end = events.iter().map(|(at, play)| at + play.duration).fold(0.0, f64::max);
    measure(&plan, events, end + 0.2).unwrap()
}

/// A dozen voices at instants that fall between samples.
fn some(duration: f64) -> Vec<(f64, Play)> {
    (0..12_u32)
        .map(|i| {
            let at = 0.01 + 0.0731 * f64::from(i);
            (at, play(0, i % 4, 37.0 + 61.3 * f64::from(i), duration, u64::from(i)))
        })
        .map(|(at, p)| (at, Play { level: 0.2, ..p }))
        .collect()
}

#[test]
fn report() {
    for (name, nodes) in [
        (
            "sine x 10 ms",
            r#"t = { type = "sine", frequency = "event.frequency" }
            e = { type = "envelope", attack = 0.01, decay = 0.02, sustain = 0.5, release = 0.01 }
            o = "#,
        ),
        (
            "sine x 1 ms",
            r#"t = { type = "sine", frequency = "event.frequency" }
            e = { type = "envelope", attack = 0.001, decay = 0.001, sustain = 0.5, release = 0.001 }
            o = "#,
        ),
        (
            "sine x gate",
            r#"t = { type = "sine", frequency = "event.frequency" }
            e = { type = "gate" }
            o = "#,
        ),
        (
            "saw x 5 ms",
            r#"t = { type = "sawtooth", frequency = "event.frequency" }
            e = { type = "envelope" }
            o = "#,
        ),
        (
            "pulse x gate",
            r#"t = { type = "pulse", frequency = "event.frequency" }
            e = { type = "gate" }
            o = "#,
        ),
        (
            "noise x 5 ms",
            r#"t = { type = "white" }
            e = { type = "envelope" }
            o = "#,
        ),
        (
            "fm",
            r#"m = { type = "sine", frequency = 50, amplitude = 500 }
            t = { type = "sine", frequency = "event.frequency + m" }
            e = { type = "envelope" }
            o = "#,
        ),
        (
            "lowpass",
            r#"s = { type = "sawtooth", frequency = "event.frequency" }
            t = { type = "lowpass", input = "s", cutoff = 300 }
            e = { type = "envelope" }
            o = "#,
        ),
        (
            "plain2",
            r#"t = { type = "sine", frequency = "event.frequency" }
            e = { type = "add", inputs = [1.0] }
            o = "#,
        ),
    ] {
        for rate in [48_000.0, 44_100.0] {
            let nodes = format!("{nodes}{{ type = \"multiply\", inputs = [\"t\", \"e\"] }}");
            let m = measured(&nodes, "o", rate, &some(0.13));
            println!(
                "{name:14} {rate} error {:7.1} dB  above 1 kHz {:7.1} dB",
                m.comparison.error_db, m.comparison.above_db
            );
        }
    }
}
