//! Voices end, also those whose envelopes do not make them; and what dies away slowly is let.

mod common;

use common::{channel, compiled, play, run, schedule};
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Source};
use pacinian::schedule::Instant;

fn voice(nodes: &str) -> Engine {
    let text = format!("[voice.v]\nvoices = 2\noutput = \"out\"\n[voice.v.nodes]\n{nodes}\n");
    Engine::new(&compiled(&text, 1, 48_000.0).plan).unwrap()
}

const HUM: &str = "e = { type = \"envelope\", release = 0.1 }\nout = { type = \"sine\", frequency = \"100 + 50 * e\", amplitude = 0.5 }";

/// Seconds until it is silent; at most so many.
fn silent_after(engine: &mut Engine, most: usize) -> Option<usize> {
    (1..=most).find(|_| {
        run(engine, 48_000, &[480]);
        engine.is_silent()
    })
}

#[test]
fn what_no_envelope_ends_fades_some_time_after_its_release() {
    let endless = [
        HUM,
        "e = { type = \"envelope\" }\ns = { type = \"sine\", frequency = 90 }\nout = { type = \"multiply\", inputs = [\"s\", \"1 + e\", 0.2] }",
        "e = { type = \"envelope\" }\nw = { type = \"white\", amplitude = 0.2 }\nout = { type = \"add\", inputs = [\"w\", \"e\"] }",
        "e = { type = \"burst\", hold = 0.05 }\ns = { type = \"sine\", frequency = 90 }\n\
         dry = { type = \"multiply\", inputs = [\"s\", \"e\", 0.2] }\n\
         back = { type = \"delay\", input = \"out\", time = 0.25, longest = 0.25 }\n\
         out = { type = \"add\", inputs = [\"dry\", \"back\"] }",
    ];
    for nodes in endless {
        let mut engine = voice(nodes);
        schedule(&mut engine, &[(0.0, play(0, 0, 100.0, 0.5, 1))]);
        let after = silent_after(&mut engine, 60);
        assert!(after.is_some_and(|seconds| seconds > 4), "{nodes}: silent after {after:?} s");
    }
}

#[test]
fn what_is_held_is_held() {
    let mut engine = voice(HUM);
    schedule(&mut engine, &[(0.0, play(0, 0, 100.0, f64::INFINITY, 1))]);
    assert_eq!(silent_after(&mut engine, 40), None);
    engine.schedule(Instant::default(), Source::Program, Event::Release(1));
    assert!(silent_after(&mut engine, 20).is_some());
    // It comes and goes gently: there is no step where it ends.
    let mut engine = voice(HUM);
    schedule(&mut engine, &[(0.0, play(0, 0, 100.0, 0.5, 1))]);
    let signal = channel(&run(&mut engine, 48_000 * 15, &[480]), 1, 0);
    let steps =
        |from: usize, to: usize| signal[from..to].windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f64::max);
    assert!(steps(96_000, 15 * 48_000) < 3.0 * steps(96_000, 144_000));
    assert_eq!(signal.last(), Some(&0.0));
}

#[test]
fn a_slow_echo_is_heard_to_its_end() {
    // Each echo is nine tenths of the one before: 120 dB take 33 s.
    let mut engine = voice(
        "e = { type = \"burst\", hold = 0.05 }\ns = { type = \"sine\", frequency = 90 }\n\
         dry = { type = \"multiply\", inputs = [\"s\", \"e\", 0.5] }\n\
         back = { type = \"delay\", input = \"out\", time = 0.25, longest = 0.5 }\n\
         out = { type = \"add\", inputs = [\"dry\", \"0.9 * back\"] }",
    );
    schedule(&mut engine, &[(0.0, play(0, 0, 100.0, 0.1, 1))]);
    let signal = channel(&run(&mut engine, 48_000 * 32, &[480]), 1, 0);
    let peak = |k: usize| signal[12_000 * k..12_000 * (k + 1)].iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    for k in [4, 40, 80, 120] {
        let expected = peak(1) * 0.9f64.powi(k as i32 - 1);
        assert!((peak(k) / expected - 1.0).abs() < 0.05, "echo {k}: {} for {expected}", peak(k));
    }
    assert!(silent_after(&mut engine, 10).is_some());
}
