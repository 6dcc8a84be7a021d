//! What may leave: nothing is ever beyond an output's `max_level`, to the bit, whatever a patch, an input or a hand-over does.

mod common;

use common::{patch, run, schedule};
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::engine::exchange::exchange;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::graph::start::FIELDS;
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;
use pacinian::space::spot::Spot;
use proptest::prelude::{Just, ProptestConfig, Strategy, any, prop, prop_assert, prop_oneof, proptest};

/// Loud, wild, broken, stepping, and what comes in.
const PATCH: &str = r#"
[control.strength]
default = 1.0
range = [0.0, 1e9]
smoothing = 0.001
[voice.bad]
voices = 16
output = "o"
[voice.bad.defaults]
size = 1
frequency = 100
[voice.bad.nodes]
tone = { type = "sine", frequency = "event.frequency" }
edge = { type = "pulse", frequency = "event.frequency" }
noise = { type = "white" }
o = { type = "multiply", inputs = ["tone + edge + noise", "event.size", "strength"] }
[voice.heard]
start = "always"
output = "o"
place = "raw"
[voice.heard.nodes]
o = { type = "input", channel = 1 }
"#;

/// Ten channels, so that the last group is not full: eight tactors, a raw output and a trigger.
fn rig(device: f64, levels: &[f64], coupling: &str) -> Rig {
    let mut text = format!(
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 10\nmax_level = {device}\n{coupling}\n\
         [actuator.coil]\nequaliser = [{{ frequency = 100, gain_db = 30, q = 10 }}]\n"
    );
    for n in 0..10 {
        let level = levels[n % levels.len()];
        text += &match n {
            8 => "[[output]]\nkind = \"raw\"\nname = \"raw\"\n".into(),
            9 => "[[output]]\nkind = \"trigger\"\nname = \"eeg\"\n".into(),
            _ => format!("[[tactor]]\nname = \"t{n}\"\nactuator = \"coil\"\ngain = {}\n", 1 + 100 * (n % 2)),
        };
        text += &format!("channel = {}\nmax_level = {level}\n", n + 1);
    }
    Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}\n{text}")).value
}

fn plan(rig: &Rig) -> Plan {
    let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
    scene(&patch(PATCH), rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

/// The level of each channel.
fn levels(rig: &Rig) -> Vec<f64> {
    rig.outputs.iter().map(|output| rig.max_level(output)).collect()
}

/// The first sample that is beyond the level of its channel.
fn beyond(frames: &[f32], levels: &[f64]) -> Option<(usize, f32)> {
    let all = frames.iter().enumerate();
    let within = |at: usize, x: f32| f64::from(x.abs()) <= levels[at % levels.len()];
    all.map(|(at, x)| (at, *x)).find(|(at, x)| !within(*at, *x))
}

fn level() -> impl Strategy<Value = f64> {
    prop_oneof![Just(1.0), Just(0.5), Just(0.3), Just(1.0 / 3.0), Just(1e-4), 1e-4..1.0_f64]
}

fn size() -> impl Strategy<Value = f64> {
    let wild = [f64::NAN, f64::INFINITY, 1e38, 3.4e38, -3.4e38, 1e300, 1e9, 0.0].map(Just);
    prop_oneof![prop::sample::select(wild.map(|Just(x)| x).to_vec()), -4.0..4.0_f64]
}

/// A hostile event: place, engine sample, seconds, hertz and size.
type Blow = (u32, f64, f64, f64, f64);

fn blows() -> impl Strategy<Value = Vec<Blow>> {
    let one = (0..9_u32, 0.0..600.0_f64, 0.0..0.05_f64, prop_oneof![0.0..4.0_f64, 1.0..1200.0_f64], size());
    prop::collection::vec(one, 1..24)
}

/// The voice of [`PATCH`] that does all that, on a place.
fn bad(plan: &Plan, place: u32, duration: f64, frequency: f64, size: f64) -> Play {
    let instrument = plan.instruments.iter().position(|i| &*i.name == "bad").unwrap();
    let mut own = [0.0; FIELDS];
    for (to, field) in own.iter_mut().zip(&plan.instruments[instrument].fields) {
        *to = if &**field == "size" { size } else { frequency };
    }
    // Given to the engine past everything that looks at numbers.
    Play {
        felt: None,
        instrument: instrument as u32,
        place: Spot::Row(place),
        level: 1.0,
        duration,
        own,
        id: u64::from(place),
    }
}

fn events(plan: &Plan, blows: &[Blow]) -> Vec<(f64, Play)> {
    let one =
        |&(place, at, duration, frequency, size): &Blow| (at, bad(plan, place, duration, frequency, size));
    blows.iter().map(one).collect()
}

/// What comes in: noise, steps, and what is no number.
fn input(frames: usize) -> Vec<f32> {
    let wild = [0.0, 1.0, -1.0, f32::NAN, 3.4e38, -3.4e38, f32::INFINITY, 0.3];
    (0..frames).map(|n| wild[n * n / 7 % wild.len()]).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn nothing_leaves_beyond_its_level(
        device in level(),
        own in prop::collection::vec(level(), 1..7),
        dc in any::<bool>(),
        blows in blows(),
        call in prop_oneof![Just(1_usize), Just(37), Just(480)],
    ) {
        let rig = rig(device, &own, if dc { "coupling = \"dc\"" } else { "" });
        let (plan, levels) = (plan(&rig), levels(&rig));
        let mut engine = Engine::new(&plan).unwrap();
        schedule(&mut engine, &events(&plan, &blows));
        for at in [100.0, 101.0, 350.5] {
            engine.schedule(Instant::of_samples(at), Source::Program, Event::Marker(u32::MAX, 0));
        }
        engine.schedule(Instant::of_samples(200.0), Source::Program, Event::Control(0, 1e9));
        let heard = input(6 * 900);
        let mut frames = vec![f32::NAN; 10 * heard.len()];
        for (to, from) in frames.chunks_mut(10 * call).zip(heard.chunks(call)) {
            engine.process_input(from, to);
        }
        let beyond = beyond(&frames, &levels);
        prop_assert!(beyond.is_none(), "{beyond:?} at levels {levels:?}");
        prop_assert!(frames.iter().skip(9).step_by(10).any(|x| *x != 0.0), "a pulse");
    }

    /// From one plan to the next while all sounds: the higher of both on the way, and after 100 ms and what the filter holds the new one.
    #[test]
    fn another_level_takes_over_while_it_sounds(
        old in prop::collection::vec(level(), 1..7),
        new in prop::collection::vec(level(), 1..7),
        blows in blows(),
        at in 1..40_usize,
    ) {
        let (first, second) = (rig(1.0, &old, ""), rig(1.0, &new, ""));
        let before = plan(&first);
        let (mut director, mut stagehand) = exchange(&before).unwrap();
        schedule(stagehand.engine(), &events(&before, &blows));
        let hum = |place| (0.0, bad(&before, place, f64::INFINITY, 200.0, 1.0));
        schedule(stagehand.engine(), &[0, 1, 2, 3, 8].map(hum));
        let mut frames = vec![0.0; 10 * 48 * 160];
        for (n, part) in frames.chunks_mut(10 * 48).enumerate() {
            if n == at {
                prop_assert!(director.send(&plan(&second)) == Ok(true));
            }
            stagehand.process(&[], part);
        }
        let (first, second) = (levels(&first), levels(&second));
        let (swap, end) = (10 * 48 * at, 10 * 48 * (at + 105));
        prop_assert!(beyond(&frames[..swap], &first).is_none());
        let both: Vec<f64> = first.iter().zip(&second).map(|(a, b)| a.max(*b)).collect();
        prop_assert!(beyond(&frames[swap..end], &both).is_none());
        let late = beyond(&frames[end..], &second);
        prop_assert!(late.is_none(), "{late:?}: {second:?} after {first:?}");
        // Raw outputs are cut where they should be at once.
        let raw = |frames: &[f32]| frames.iter().skip(8).step_by(10).fold(0.0_f32, |most, x| most.max(x.abs()));
        prop_assert!(f64::from(raw(&frames[swap..])) <= second[8]);
    }
}

/// The shapes of two runs at levels that are powers of two are the same bits: the limiter does at its level what it does at full scale.
#[test]
fn the_limiter_acts_at_its_level_as_at_full_scale() {
    let rendered = |level: f64, size: f64| {
        let plan = plan(&rig(level, &[1.0], ""));
        let mut engine = Engine::new(&plan).unwrap();
        let tone = |(place, hertz)| (10.3, bad(&plan, place, f64::INFINITY, hertz, size));
        schedule(&mut engine, &[(0, 250.0), (2, 60.0), (4, 777.0)].map(tone));
        let frames = run(&mut engine, 24_000, &[480]);
        assert!(engine.stage().counts().limited > 1000, "{:?}", engine.stage().counts());
        frames
    };
    let full = rendered(1.0, 1.0);
    for level in [0.5, 0.125] {
        let lower = rendered(level, level);
        let wrong = full.iter().zip(&lower).position(|(a, b)| (a * level as f32).to_bits() != b.to_bits());
        assert_eq!(wrong, None, "at {level}");
    }
}

/// The step from one frame to the next is hardly larger for a level that comes down over a sound that keeps to both.
#[test]
fn another_level_is_not_heard_where_nothing_reaches_it() {
    let soft = |level: f64| {
        let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
        scene(&patch(SOFT), &rig(level, &[1.0], ""), &options, &NoAssets)
            .unwrap_or_else(|p| panic!("{p}"))
            .plan
    };
    let hum = |change: Option<f64>| {
        let (mut director, mut stagehand) = exchange(&soft(1.0)).unwrap();
        let mut frames = vec![0.0; 10 * 48 * 500];
        for (n, part) in frames.chunks_mut(10 * 48).enumerate() {
            if let Some(level) = change.filter(|_| n == 200) {
                assert_eq!(director.send(&soft(level)), Ok(true));
            }
            stagehand.process(&[], part);
        }
        frames.into_iter().skip(480 * 10).step_by(10).collect::<Vec<f32>>()
    };
    let step = |frames: &[f32]| frames.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f32::max);
    let plain = hum(None);
    assert!(plain.iter().any(|x| *x > 0.07), "it hums");
    for level in [0.5, 0.2] {
        let changed = hum(Some(level));
        assert!(step(&changed) <= 1.05 * step(&plain), "{level}: {} for {}", step(&changed), step(&plain));
        let end = changed.len() - 4800;
        let apart = changed[end..].iter().zip(&plain[end..]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(apart < 1e-6, "{level}: {apart}");
    }
}

/// A hum that keeps well below any level used here: the actuator lifts little of it.
const SOFT: &str = r#"
[voice.soft]
start = "always"
output = "o"
[voice.soft.nodes]
o = { type = "sine", frequency = 400, amplitude = 0.08 }
"#;

/// A level that comes down over what is louder than it turns that down as it glides: the largest step is no larger than without it.
#[test]
fn a_level_that_comes_down_over_a_tone_turns_it_down_without_a_step() {
    for hertz in [40.0, 60.0, 100.0, 160.0, 250.0, 500.0, 800.0] {
        let text = format!(
            "[voice.hum]\nstart = \"always\"\noutput = \"o\"\nplace = \"t1\"\nnodes.o = {{ type = \"sine\", frequency = {hertz}, amplitude = 0.2 }}\n"
        );
        let plan = |level: f64| {
            let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
            let rig = format!(
                "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nmax_level = {level}\n[[tactor]]\nname = \"t1\"\nchannel = 1\n"
            );
            let rig = Rig::parse("rig.toml", rig.as_bytes()).unwrap().value;
            scene(&patch(&text), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
        };
        let hum = |from: f64, to: Option<f64>| {
            let (mut director, mut stagehand) = exchange(&plan(from)).unwrap();
            let mut frames = vec![0.0; 48 * 1_000];
            for (n, part) in frames.chunks_mut(48).enumerate() {
                if let Some(level) = to.filter(|_| n == 200) {
                    assert_eq!(director.send(&plan(level)), Ok(true));
                }
                stagehand.process(&[], part);
            }
            frames.into_iter().skip(4_800).collect::<Vec<f32>>()
        };
        let step = |frames: &[f32]| frames.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f32::max);
        for (from, to) in [(0.25, 0.1), (1.0, 0.15), (0.25, 0.02), (0.1, 0.3)] {
            let (old, new, changed) = (hum(from, None), hum(to, None), hum(from, Some(to)));
            let worst = step(&changed) / step(&old).max(step(&new));
            assert!(worst <= 1.005, "{hertz} Hz, from {from} to {to}: a step {worst} times as large");
            let peak = |frames: &[f32]| frames[33_600..].iter().fold(0.0, |most: f32, x| most.max(x.abs()));
            // A need that comes back to 95 % renews the one that is held.
            let (meant, end) = (peak(&new), peak(&changed));
            assert!(
                (end / meant - 1.0).abs() < 0.055,
                "{hertz} Hz, from {from} to {to}: {end} in place of {meant}"
            );
        }
    }
}

/// What a level that comes down does depends on what was played lately, and not on the lengths of calls: also of a channel that falls asleep
/// between its blows, whose pieces begin with silence as they are cut.
#[test]
fn levels_that_come_down_between_blows_give_the_same_bits_in_any_cut() {
    let hit = "[voice.hit]\noutput = \"o\"\nplace = \"t1\"\n[voice.hit.nodes]\ntone = { type = \"sine\", frequency = 170 }\n\
        edge = { type = \"envelope\", attack = 0.002, decay = 0.7, sustain = 0, release = 0.01 }\n\
        o = { type = \"multiply\", inputs = [\"tone\", \"edge\"] }\n";
    let plan = |level: f64| {
        let rig = format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nmax_level = {level}\n[[tactor]]\nname = \"t1\"\nchannel = 1\n"
        );
        let rig = Rig::parse("rig.toml", rig.as_bytes()).unwrap().value;
        let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
        scene(&patch(hit), &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
    };
    let plans = [plan(1.0), plan(0.08)];
    // Every half a second another level, and in between calls of these lengths.
    let (swap, swaps) = (24_000, 40);
    let rendered = |call: usize| {
        let (mut director, mut stagehand) = exchange(&plans[0]).unwrap();
        let blows: Vec<(f64, Play)> = (0..24_u32)
            .map(|n| (160.0 + 6_509.6 * f64::from(n), common::play(0, 0, 170.0, 0.45, n.into())))
            .collect();
        schedule(stagehand.engine(), &blows);
        let mut frames = vec![0.0; swap * swaps];
        for (n, half) in frames.chunks_mut(swap).enumerate() {
            if n > 0 {
                assert_eq!(director.send(&plans[n % 2]), Ok(true));
            }
            half.chunks_mut(call).for_each(|part| stagehand.process(&[], part));
        }
        frames
    };
    let whole = rendered(swap);
    assert!(whole.iter().any(|x| x.abs() > 0.5));
    for call in [48, 64, 666, 4_800] {
        let other = rendered(call);
        let differs = whole.iter().zip(&other).position(|(a, b)| a.to_bits() != b.to_bits());
        assert_eq!(differs, None, "calls of {call}");
    }
}
