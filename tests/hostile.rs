//! Whole patches with hostile numbers: what comes out is finite and within full scale, time goes on, a bad voice changes nothing
//! but itself, and silence becomes exact zero.

mod common;

use common::{channel, compiled, patch, play, run, schedule};
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::graph::plan::{Plan, Precision};
use pacinian::graph::scene::{Options, scene};
use pacinian::node::REGISTRY;
use pacinian::node::asset::NoAssets;
use pacinian::node::spec::{Kind, NodeSpec};
use pacinian::patch::Patch;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;
use proptest::prelude::{Just, ProptestConfig, Strategy, any, prop, prop_assert, prop_oneof, proptest};
use proptest::test_runner::TestCaseError;
use std::fmt::Write;

/// Engine samples of a run, at six frames each.
const SAMPLES: usize = 640;

/// Fields of an event that nodes read.
const FIELDS: [&str; 6] = ["frequency", "a", "b", "c", "d", "e"];

/// Wirings of an input: fields of the event, what other nodes make, and numbers past what a number can hold.
const WIRES: [&str; 10] = [
    "event.frequency",
    "event.a",
    "event.b",
    "event.c",
    "tone",
    "wild",
    "endless",
    "log(tone) * event.d",
    "tone / (event.e - event.e)",
    "sqrt(wild) * 1e30",
];

/// Numbers that an event may carry.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![
        Just(0.0),
        Just(-0.0),
        Just(1.0),
        Just(-1.0),
        Just(0.5),
        Just(250.0),
        Just(3999.9),
        Just(4000.0),
        Just(1e9),
        Just(-1e9),
        Just(1e-9),
        Just(1e-310),
        Just(1e38),
        Just(1e300),
        Just(f64::NAN),
        Just(f64::INFINITY),
        Just(f64::NEG_INFINITY),
        -2.0..2.0_f64,
        -5000.0..5000.0_f64,
    ]
}

/// A node of any type but those that need a file, its inputs wired by `wires`, its words by `word`.
fn node(spec: &NodeSpec, wires: &[usize], word: usize) -> String {
    let mut text = format!("x = {{ type = \"{}\"", spec.name);
    for (param, wire) in spec.params.iter().zip(wires.iter().cycle()) {
        let value = match param.kind {
            Kind::Signal(_) | Kind::Frequency(_) => format!("\"{}\"", WIRES[wire % WIRES.len()]),
            // Only what is known at the onset.
            Kind::Start(_) => format!("\"{}\"", WIRES[wire % 4]),
            Kind::Constant(numeric) => {
                [numeric.least, numeric.most.min(2.0), numeric.least.max(0.01)][wire % 3].to_string()
            }
            Kind::Signals => {
                format!("[\"{}\", \"tone\", \"{}\"]", WIRES[wire % WIRES.len()], WIRES[word % WIRES.len()])
            }
            Kind::Choice(words, _) => format!("\"{}\"", words[word % words.len()]),
            Kind::Points => {
                "[{ at = 0, value = 1e6 }, { at = 0.01, value = -1e6 }, { at = 1e6, value = 1 }]".into()
            }
            Kind::Flag(_) => (word.is_multiple_of(2)).to_string(),
            Kind::File => return String::new(),
        };
        let _ = write!(text, ", {} = {value}", param.name);
    }
    text + " }"
}

fn whole(node: &str, voices: usize) -> String {
    let mut text = format!("[voice.bad]\nvoices = {voices}\noutput = \"o\"\n[voice.bad.defaults]\n");
    for field in FIELDS {
        let _ = writeln!(text, "{field} = 1");
    }
    text + "[voice.bad.nodes]\n\
        tone = { type = \"sine\", frequency = \"event.frequency\" }\n\
        wild = { type = \"multiply\", inputs = [\"tone * 1e30\", \"tone * 1e30\", \"tone\"] }\n\
        endless = { type = \"add\", inputs = [\"wild * wild\", \"0 - wild * wild\"] }\n"
        + node
        + "\ne = { type = \"envelope\", attack = 0.001, release = 0.001 }\n\
        o = { type = \"multiply\", inputs = [\"x\", \"e\"] }\n\
        [voice.good]\nvoices = 4\noutput = \"o\"\n[voice.good.nodes]\n\
        tone = { type = \"triangle\", frequency = \"event.frequency\" }\n\
        e = { type = \"envelope\" }\n\
        o = { type = \"multiply\", inputs = [\"tone\", \"e\", 0.5] }\n"
}

/// Voices of the bad instrument on channel 1, by numbers that come round.
fn bad(numbers: &[f64], level: f64, duration: f64, count: u32) -> Vec<(f64, Play)> {
    let mut numbers = numbers.iter().copied().cycle();
    (0..count)
        .map(|i| {
            let mut one = Play { level, ..play(0, 0, 0.0, duration, 100 + u64::from(i)) };
            one.own.fill_with(|| numbers.next().unwrap_or(0.0));
            (100.3 + 40.7 * f64::from(i), one)
        })
        .collect()
}

/// A voice of the other instrument on channel 2, and one of the bad instrument with tame numbers on channel 3.
fn good() -> [(f64, Play); 2] {
    let mut tame = play(0, 2, 80.0, 0.04, 2);
    tame.own.fill(0.3);
    [(20.7, play(1, 1, 120.0, 0.05, 1)), (11.2, tame)]
}

fn rendered(plan: &Plan, events: &[(f64, Play)]) -> (Engine, Vec<f32>) {
    let mut engine = Engine::new(plan).unwrap();
    schedule(&mut engine, events);
    let frames = run(&mut engine, SAMPLES * plan.ratio, &[480, 7, 61]);
    (engine, frames)
}

fn is_sound(frames: &[f32]) -> bool {
    frames.iter().all(|x| x.is_finite() && x.abs() <= 1.0)
}

fn bits(frames: &[f32], c: usize) -> Vec<u64> {
    channel(frames, 3, c).iter().map(|x| x.to_bits()).collect()
}

fn neighbours_are_left_alone(
    kind: usize,
    wires: &[usize],
    word: usize,
    numbers: &[f64],
    level: f64,
    duration: f64,
    double: bool,
) -> Result<(), TestCaseError> {
    let text = node(REGISTRY[kind % REGISTRY.len()], wires, word);
    if text.is_empty() {
        return Ok(());
    }
    let mut plan = compiled(&whole(&text, 8), 3, 48_000.0).plan;
    plan.precision = if double { Precision::Double } else { Precision::Single };
    let (_, alone) = rendered(&plan, &good());
    let mut events = good().to_vec();
    events.extend(bad(numbers, level, duration, 3));
    let (engine, together) = rendered(&plan, &events);
    prop_assert!(is_sound(&together), "{text}: not finite or over full scale");
    prop_assert!(engine.clock() == SAMPLES as u64, "{text}: time stands still");
    prop_assert!(engine.counters().started == 5);
    for c in 1..3 {
        prop_assert!(bits(&alone, c) == bits(&together, c), "{text}: channel {} heard the bad voice", c + 1);
    }
    prop_assert!(alone.iter().any(|x| *x != 0.0));
    Ok(())
}

fn a_lane_forgets(kind: usize, wires: &[usize], word: usize, numbers: &[f64]) -> Result<(), TestCaseError> {
    let text = node(REGISTRY[kind % REGISTRY.len()], wires, word);
    if text.is_empty() {
        return Ok(());
    }
    let plan = compiled(&whole(&text, 1), 3, 48_000.0).plan;
    let mut tame = play(0, 2, 80.0, 0.03, 2);
    tame.own.fill(0.3);
    let (_, alone) = rendered(&plan, &[(400.6, tame)]);
    let mut events = bad(numbers, 1.0, 0.001, 2);
    events.push((400.6, tame));
    let (_, after) = rendered(&plan, &events);
    prop_assert!(bits(&alone, 2) == bits(&after, 2), "{text}: the lane remembers who was there");
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 250, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_bad_voice_changes_nothing_but_itself(
        kind in any::<usize>(),
        wires in prop::collection::vec(any::<usize>(), 8),
        word in any::<usize>(),
        numbers in prop::collection::vec(number(), 6),
        level in number(),
        duration in number(),
        double in any::<bool>(),
    ) {
        neighbours_are_left_alone(kind, &wires, word, &numbers, level, duration, double)?;
    }

    #[test]
    fn a_lane_keeps_nothing_of_who_was_there(
        kind in any::<usize>(),
        wires in prop::collection::vec(any::<usize>(), 8),
        word in any::<usize>(),
        numbers in prop::collection::vec(number(), 6),
    ) {
        a_lane_forgets(kind, &wires, word, &numbers)?;
    }

    /// The queue orders by time: who comes first to it does not matter.
    #[test]
    fn the_order_of_scheduling_does_not_matter(
        order in Just((0..12_usize).collect::<Vec<_>>()).prop_shuffle(),
    ) {
        let plan = compiled(TONE, 3, 48_000.0).plan;
        let events: Vec<_> = (0..12_u32)
            .map(|i| (3.0 + 31.7 * f64::from(i), play(0, i % 3, 40.0 + 30.0 * f64::from(i), 0.01, u64::from(i))))
            .collect();
        let shuffled: Vec<_> = order.iter().map(|&i| events[i]).collect();
        prop_assert!(rendered(&plan, &events).1 == rendered(&plan, &shuffled).1);
    }
}

/// Every node type is met, and not by chance: each with every wiring in its first place.
#[test]
fn every_node_bears_every_wiring() {
    for kind in 0..REGISTRY.len() {
        for first in 0..WIRES.len() {
            let wires: Vec<usize> = (0..8).map(|i| first + 3 * i).collect();
            let numbers = [1e9, f64::NAN, -1.0, f64::INFINITY, 1e300, 0.0];
            neighbours_are_left_alone(kind, &wires, first, &numbers, 1.0, 0.02, false).unwrap();
            a_lane_forgets(kind, &wires, first, &numbers).unwrap();
        }
    }
}

const TONE: &str = r#"
[control.strength]
default = 1
range = [0.0, 1.0]
[voice.v]
voices = 16
output = "o"
[voice.v.nodes]
t = { type = "sine", frequency = "event.frequency" }
e = { type = "envelope" }
o = { type = "multiply", inputs = ["t", "e", "strength"] }
"#;

#[test]
fn ties_go_by_source_and_then_by_arrival() {
    let plan = compiled(TONE, 1, 48_000.0).plan;
    let at = Instant::of_samples(200.5);
    let rendered = |changes: &[(Source, f64)]| {
        let mut engine = Engine::new(&plan).unwrap();
        schedule(&mut engine, &[(10.0, play(0, 0, 100.0, 1.0, 1))]);
        for &(source, value) in changes {
            assert!(engine.schedule(at, source, Event::Control(0, value)));
        }
        run(&mut engine, 6000, &[64])
    };
    let low = rendered(&[(Source::Program, 0.2)]);
    assert_ne!(low, rendered(&[(Source::Program, 0.9)]));
    let last = rendered(&[(Source::Pattern, 0.9), (Source::Program, 0.2)]);
    assert_eq!(last, rendered(&[(Source::Program, 0.2), (Source::Pattern, 0.9)]), "sources decide");
    assert_eq!(last, low, "the program has the last word");
    assert_eq!(low, rendered(&[(Source::Program, 0.9), (Source::Program, 0.2)]), "then arrival does");
}

/// A voice that comes too late and is let go of just in time begins before it is let go of.
#[test]
fn what_comes_too_late_stays_in_its_order() {
    let plan = compiled(TONE, 1, 48_000.0).plan;
    for (begin, end) in [(0.0, 799.5), (798.9, 799.1), (799.0, 799.000_001), (798.0, 799.0), (799.5, 799.6)] {
        let mut engine = Engine::new(&plan).unwrap();
        run(&mut engine, 4800, &[480]);
        assert_eq!(engine.clock(), 800);
        let play = play(0, 0, 90.0, f64::INFINITY, 77);
        for (at, event) in [(begin, Event::Play(play)), (end, Event::Release(play.id))] {
            assert!(engine.schedule(Instant::of_samples(at), Source::Program, event));
        }
        run(&mut engine, 48_000, &[480]);
        assert_eq!((engine.counters().started, engine.sounding()), (1, 0), "{begin} {end}");
    }
}

#[test]
fn late_and_hostile_instants_are_played_and_counted() {
    let plan = compiled(TONE, 1, 48_000.0).plan;
    let mut engine = Engine::new(&plan).unwrap();
    run(&mut engine, 4800, &[480]);
    for at in [-1.0, 3.0, f64::NAN] {
        assert!(engine.schedule(
            Instant::of_samples(at),
            Source::Program,
            Event::Play(play(0, 0, 90.0, 0.01, 1))
        ));
    }
    assert_eq!(engine.counters().late, 3);
    assert!(engine.schedule(Instant::NEVER, Source::Program, Event::Play(play(0, 0, 90.0, 0.01, 1))));
    // Neither a voice, nor a place, nor a control that is not there does harm.
    let now = Instant::of_samples(801.0);
    for event in [
        Event::Play(play(7, 0, 90.0, 0.01, 1)),
        Event::Play(play(0, 99, 90.0, 0.01, 1)),
        Event::Control(9, f64::NAN),
        Event::Control(0, f64::NAN),
        Event::Control(0, f64::INFINITY),
        Event::Release(55),
        Event::Marker(3, 0),
    ] {
        assert!(engine.schedule(now, Source::Program, event));
    }
    assert!(is_sound(&run(&mut engine, 9600, &[480])));
    assert_eq!((engine.counters().started, engine.sounding()), (4, 0));
    assert!(!engine.is_silent(), "one event waits for ever");
}

#[test]
fn a_full_queue_drops_and_counts() {
    let plan = compiled(TONE, 1, 48_000.0).plan;
    let mut engine = Engine::new(&plan).unwrap();
    let (mut taken, mut refused) = (0, 0);
    for i in 0..40_000_u32 {
        let event = Event::Play(play(0, 0, 90.0, 0.01, u64::from(i)));
        let room = engine.schedule(Instant::of_samples(1e6 + f64::from(i)), Source::Program, event);
        *(if room { &mut taken } else { &mut refused }) += 1;
    }
    assert!(refused > 0 && taken > 16_000);
    assert_eq!(engine.counters().dropped, refused);
    assert!(is_sound(&run(&mut engine, 480, &[480])));
}

/// Samples of a voice that are no number are masked, one by one, and counted, once each.
#[test]
fn what_is_no_number_is_masked_and_counted() {
    // In single precision 1e20 × 1e20 is past what a number can hold, where the square is high; where it is 0, it is fine.
    let text = r#"
        [voice.v]
        voices = 4
        output = "o"
        [voice.v.nodes]
        t = { type = "lfo", wave = "square", rate = 100, ease = 0, low = 0, high = 1e6 }
        big = { type = "multiply", inputs = ["t", "t", "t", "t", "t", "t", "t"] }
        e = { type = "gate" }
        o = { type = "multiply", inputs = ["big", "e"] }
    "#;
    let plan = compiled(text, 2, 48_000.0).plan;
    let (engine, frames) = rendered_for(&plan, &[(0.0, play(0, 0, 0.0, 0.05, 1))], 2400);
    assert!(is_sound(&frames));
    // Half of 0.05 s × 8000; a few more where jumps are band-limited.
    let masked = engine.counters().masked;
    assert!((150..=300).contains(&masked), "{masked} samples masked");
    let (twice, _) =
        rendered_for(&plan, &[(0.0, play(0, 0, 0.0, 0.05, 1)), (0.0, play(0, 1, 0.0, 0.05, 2))], 2400);
    assert_eq!(twice.counters().masked, 2 * masked);
    let soft = Play { level: 0.9, ..play(0, 0, 90.0, 0.05, 1) };
    let (tame, _) = rendered_for(&compiled(TONE, 2, 48_000.0).plan, &[(0.0, soft)], 2400);
    assert_eq!(tame.counters().masked, 0);
    assert_eq!(tame.stage().counts(), Default::default(), "a tame scene meets nothing");
}

fn rendered_for(plan: &Plan, events: &[(f64, Play)], frames: usize) -> (Engine, Vec<f32>) {
    let mut engine = Engine::new(plan).unwrap();
    schedule(&mut engine, events);
    let frames = run(&mut engine, frames, &[480]);
    (engine, frames)
}

/// No level that an event can have makes a number that the mix cannot hold.
#[test]
fn levels_past_every_measure() {
    let plan = compiled(TONE, 3, 48_000.0).plan;
    let beside = (5.0, play(0, 1, 120.0, 0.05, 1));
    let (_, alone) = rendered(&plan, &[beside]);
    for level in [1e9, 1e30, 1e39, 1e300, f64::INFINITY, f64::NEG_INFINITY, f64::NAN, -1e300] {
        let loud = (9.5, Play { level, ..play(0, 0, 70.0, 0.05, 2) });
        let (engine, frames) = rendered(&plan, &[beside, loud]);
        assert!(is_sound(&frames), "level {level}");
        assert_eq!(bits(&frames, 1), bits(&alone, 1), "level {level}");
        if level.is_finite() {
            assert!(frames.iter().any(|x| x.abs() > 0.5), "level {level}: loud is not silent");
            assert_eq!(engine.stage().counts().masked, 0, "level {level}");
        }
    }
}

#[test]
fn any_number_of_channels() {
    for channels in [1, 7, 8, 9, 4096] {
        let plan = compiled(TONE, channels, 48_000.0).plan;
        assert_eq!(plan.channels, channels as usize);
        let last = channels - 1;
        let (_, frames) = rendered_for(&plan, &[(3.3, play(0, last, 100.0, 0.01, 1))], 960);
        assert!(is_sound(&frames));
        for c in [0, channels / 2, last] {
            let sounds = channel(&frames, channels as usize, c as usize).iter().any(|x| x.abs() > 0.3);
            assert_eq!(sounds, c == last, "channel {} of {channels}", c + 1);
        }
    }
    // None at all: nothing to compute, nothing to fail.
    let mut plan = compiled(TONE, 1, 48_000.0).plan;
    (plan.channels, plan.places) = (0, vec![Vec::new()]);
    assert!(Engine::new(&plan).is_err(), "its output hangs on a channel that is not there");
    plan.outputs.clear();
    assert!(Engine::new(&plan).is_err(), "so does its tactor, which has points about it");
    plan.spread = None;
    let mut engine = Engine::new(&plan).unwrap();
    schedule(&mut engine, &[(0.0, play(0, 0, 100.0, 0.01, 1))]);
    let mut nothing = [1.0; 12];
    engine.process(&mut nothing);
    assert_eq!(engine.channels(), 0);
}

/// Everything that rings must come to rest: no denormal tail, no least bit that goes round.
#[test]
fn silence_becomes_exact_zero() {
    let nodes: &[(&str, &str)] = &[
        ("low-pass", r#"x = { type = "lowpass", input = "t", cutoff = 30, q = 5 }"#),
        ("high-pass at 0 Hz", r#"x = { type = "highpass", input = "t", cutoff = 0 }"#),
        ("resonator", r#"x = { type = "resonator", input = "t", frequency = 90, decay = 0.1 }"#),
        ("band-pass", r#"x = { type = "bandpass", input = "t", frequency = 200, q = 30 }"#),
        ("notch", r#"x = { type = "notch", input = "t", frequency = 200, q = 5 }"#),
        ("delay", r#"x = { type = "delay", input = "t", time = 0.03, longest = 0.5 }"#),
        ("follower", r#"x = { type = "follow", input = "t", attack = 0.01, release = 0.1 }"#),
        (
            "pink noise",
            r#"x = { type = "multiply", inputs = ["t", "p"] }
            p = { type = "pink" }"#,
        ),
    ];
    for (name, node) in nodes {
        let text = format!(
            "[voice.v]\nvoices = 8\noutput = \"x\"\n[voice.v.nodes]\ne = {{ type = \"envelope\" }}\n\
             s = {{ type = \"sawtooth\", frequency = 70 }}\nt = {{ type = \"multiply\", inputs = [\"s\", \"e\"] }}\n{node}"
        );
        for precision in [Precision::Single, Precision::Double] {
            let mut plan = compiled(&text, 2, 48_000.0).plan;
            plan.precision = precision;
            let mut engine = Engine::new(&plan).unwrap();
            schedule(&mut engine, &[(10.5, play(0, 0, 0.0, 0.1, 1)), (50.2, play(0, 1, 0.0, 0.1, 2))]);
            let begin = run(&mut engine, 48_000 / 5, &[480]);
            assert!(begin.iter().any(|x| *x != 0.0), "{name}: nothing sounds");
            run(&mut engine, 2 * 48_000, &[480]);
            let rest = run(&mut engine, 4800, &[480]);
            assert!(
                rest.iter().all(|x| *x == 0.0),
                "{name}, {precision:?}: still {:e}",
                rest.iter().fold(0.0_f32, |m, x| m.max(x.abs()))
            );
            assert!(engine.is_silent(), "{name}, {precision:?}: {} voices sound", engine.sounding());
        }
    }
}

#[test]
fn a_loop_is_an_error_that_names_it() {
    let told = |nodes: &str| {
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"a\"\n[voice.v.nodes]\n{nodes}"
        );
        let problems = Patch::parse("loop.toml", text.as_bytes()).unwrap_err();
        problems.to_string()
    };
    let own = told("a = { type = \"sine\", frequency = 90, phase = \"a\" }");
    assert!(own.contains("a → a") && own.contains("delay"), "{own}");
    let far = told(
        "a = { type = \"add\", inputs = [\"b\", 1] }\nb = { type = \"multiply\", inputs = [\"c\", 0.5] }\n\
         c = { type = \"lowpass\", input = \"a\", cutoff = 90 }",
    );
    assert!(far.contains("a → b → c → a"), "{far}");
}

/// A loop that passes through a delay either sounds, finite even where it feeds back more than it gets, or is refused.
#[test]
fn a_loop_through_a_delay_sounds_or_is_refused() {
    let text = r#"
        [voice.v]
        output = "sum"
        [voice.v.nodes]
        hit = { type = "burst", attack = 0.001, decay = 0.004 }
        sum = { type = "add", inputs = ["hit", "1.5 * echo"] }
        echo = { type = "delay", input = "sum", time = 0.01, longest = 0.05 }
    "#;
    let options = Options { live: true, ..Options::default() };
    match scene(&patch(text), &Rig::default_for(1), &options, &NoAssets) {
        Ok(scene) => {
            let (_, frames) = rendered_for(&scene.plan, &[(0.0, play(0, 0, 0.0, 0.1, 1))], 48_000);
            assert!(is_sound(&frames));
            assert!(frames[24_000..].iter().any(|x| x.abs() > 0.1), "the loop does not come round");
        }
        Err(problems) => {
            assert!(
                problems.list.iter().any(|p| p.what.contains("cycle") || p.what.contains("circle")),
                "{problems:?}"
            );
        }
    }
}
