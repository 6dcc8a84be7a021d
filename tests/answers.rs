//! Patterns that a knob or a node sets off: when they begin, as what, and the same however a run is cut.

use std::sync::{Arc, Mutex};

use pacinian::graph::answer::latency;
use pacinian::graph::scene::{BLOCK, Options};
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
use pacinian::player::{Happening, Player};
use pacinian::rig::Rig;
use pacinian::schedule::Instant;

const TEXT: &str = r#"
[knob.effects]
notches = { type = "detents", count = 24, torque = 0.01 }
ends = { type = "end-stops", low = -1.5, high = 1.5, stiffness = 0.2 }
[shared.nodes]
sway = { type = "lfo", rate = 7 }
[voice.click]
voices = 16
output = "o"
nodes.o = { type = "multiply", inputs = ["tone + rub", "decay"] }
nodes.tone = { type = "sine", frequency = "event.frequency" }
nodes.rub = { type = "white", amplitude = 0.1 }
nodes.decay = { type = "envelope", attack = 0.001, decay = 0.01, sustain = 0 }
[pattern.roll]
events = [
  { at = 0.0, voice = "click", level = 0.5, frequency = 200 },
  { at = 0.03, voice = "click", level = 0.25, frequency = 150, place = 2 },
]
jitter = { level = 0.2 }
[pattern.beat]
events = [{ at = 0.01, voice = "click", level = 0.2, frequency = 90, place = 2 }]
repeat = { every = 0.05 }
[[trigger]]
on = "knob.detent"
play = "click"
set = { level = "min(1, speed / 10)", duration = 0.01 }
[[trigger]]
on = "knob.detent notches"
play = "roll"
set = { gain = "min(1, speed / 10)", rate = "1.5 + 0.5 * way" }
[[trigger]]
on = "knob.wall"
play = "beat"
[[trigger]]
on = "node.sway rises 0.6"
play = "click"
place = 2
[[trigger]]
on = "node.sway rises 0.6"
play = "roll"
set = { gain = "value" }
"#;

fn player(text: &str) -> Player {
    let text = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{text}");
    let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let options = Options { rate: Some(48_000.0), ..Options::default() };
    Player::new(&patch, &Rig::default_for(2), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"))
}

/// What was heard.
#[derive(Debug, Clone, PartialEq)]
struct Told {
    at: Instant,
    what: String,
    level: f64,
    origin: String,
    number: u64,
    id: Option<u64>,
}

/// Two seconds with a hand that turns to and fro, in calls of these lengths, again and again: frames, and what was told in order of time.
fn turned(text: &str, lengths: &[usize]) -> (Vec<f32>, Vec<Told>) {
    let mut player = player(text);
    let told = Arc::new(Mutex::new(Vec::new()));
    let list = Arc::clone(&told);
    player.listen(Box::new(move |heard| {
        let (what, level) = match heard.what {
            Happening::Voice { name, level, .. } => (name.to_string(), level),
            Happening::Start(name) => (format!("start {name}"), 0.0),
            Happening::Cancel(_) => ("cancel".to_string(), 0.0),
            what => panic!("{what:?}"),
        };
        let (origin, number) = heard.origin.map_or(("", 0), |origin| (origin.pattern, origin.event));
        let told = Told { at: heard.instant, what, level, origin: origin.into(), number, id: heard.id };
        list.lock().unwrap().push(told);
    }));
    let mut begin = 0.05;
    for (end, angle) in [(0.4, 1.0), (0.8, -2.5), (1.3, 2.5), (1.8, 0.0)] {
        player.glide_at(begin, "hand", angle, end - begin).unwrap();
        begin = end;
    }
    let mut out = vec![0.0; 2 * 96_000];
    let (mut rest, mut n) = (out.as_mut_slice(), 0);
    while !rest.is_empty() {
        let length = (2 * lengths[n % lengths.len()]).min(rest.len());
        let (now, later) = rest.split_at_mut(length);
        player.process(now);
        (rest, n) = (later, n + 1);
    }
    let counters = player.counters();
    assert_eq!((counters.late, counters.dropped), (0, 0));
    assert_eq!(player.trouble(), None);
    let mut told = told.lock().unwrap().clone();
    // Voices are told of a little after they began.
    told.sort_by_key(|told| (told.at, told.id));
    (out, told)
}

/// Samples of the engine, at 8 kHz, by which a pattern is later than what sets it off, where nobody says how long blocks are.
fn late() -> u64 {
    latency(BLOCK, 48_000.0, 8_000.0)
}

#[test]
fn each_pattern_begins_a_fixed_time_after_what_set_it_off() {
    let (_, told) = turned(TEXT, &[96_000]);
    let of = |what: &str, origin: &str| -> Vec<&Told> {
        told.iter().filter(|told| told.what == what && told.origin.starts_with(origin)).collect()
    };
    let (clicks, rolls) = (of("click", "knob.detent"), of("start roll", "knob.detent"));
    assert!(clicks.len() > 20 && rolls.len() == clicks.len(), "{} {}", clicks.len(), rolls.len());
    assert_eq!(late(), 123);
    for (click, roll) in clicks.iter().zip(&rolls) {
        assert_eq!((roll.at.sample - click.at.sample, roll.at.fraction), (late(), click.at.fraction));
        assert_eq!(roll.number, click.number);
    }
    // As loud as the knob was fast: the first event has half of what its trigger gave, within its jitter, and is at its beginning.
    let events: Vec<&Told> = of("click", "roll").into_iter().filter(|told| told.number == 0).collect();
    for (click, roll) in clicks.iter().zip(&rolls) {
        let first = events.iter().find(|event| event.at == roll.at).unwrap_or_else(|| panic!("{roll:?}"));
        assert!((first.level / click.level - 0.5).abs() <= 0.1 + 1e-9, "{first:?} {click:?}");
    }
    // What a node sets off is as late behind the threshold, and so 8 samples less behind its voice.
    let (taps, rolls) = (of("click", "node.sway"), of("start roll", "node.sway"));
    assert!(taps.len() >= 13 && rolls.len() + 1 >= taps.len(), "{} {}", taps.len(), rolls.len());
    for (tap, roll) in taps.iter().zip(&rolls) {
        assert_eq!((roll.at.sample - tap.at.sample, roll.at.fraction), (late() - 8, tap.at.fraction));
    }
    let mut drawn: Vec<u64> = events.iter().map(|event| event.level.to_bits()).collect();
    drawn.sort_unstable();
    drawn.dedup();
    assert!(drawn.len() > events.len() / 2, "each start draws anew");
}

/// The turn to the right is played twice as fast, that to the left as it stands.
#[test]
fn what_happened_says_how_fast_a_pattern_plays() {
    let (_, told) = turned(TEXT, &[96_000]);
    let ids: Vec<u64> = told.iter().filter(|t| t.origin == "roll").filter_map(|t| t.id).collect();
    let runs = ids.iter().map(|id| id >> 32).collect::<std::collections::BTreeSet<_>>();
    let mut apart: Vec<f64> = Vec::new();
    for run in runs {
        let at: Vec<Instant> =
            told.iter().filter(|t| t.id.is_some_and(|id| id >> 32 == run)).map(|t| t.at).collect();
        if let [first, second] = at[..] {
            apart.push(second.since(first) / 8_000.0);
        }
    }
    assert!(
        apart.iter().all(|apart| (apart - 0.03).abs() < 1e-9 || (apart - 0.015).abs() < 1e-9),
        "{apart:?}"
    );
    assert!(apart.iter().any(|apart| *apart < 0.02) && apart.iter().any(|apart| *apart > 0.02));
}

/// One without end begins anew with every hit: a second would never end.
#[test]
fn a_pattern_without_end_begins_anew_with_every_hit() {
    let (_, told) = turned(TEXT, &[96_000]);
    let starts: Vec<Instant> = told.iter().filter(|t| t.what == "start beat").map(|t| t.at).collect();
    assert!(starts.len() > 1, "{starts:?}");
    let beats: Vec<f64> = told.iter().filter(|t| t.origin == "beat").map(|t| t.at.since(starts[0])).collect();
    // What is 10 ms behind each start and then every 50 ms, up to the next start.
    let mut expected = Vec::new();
    for (n, start) in starts.iter().enumerate() {
        let end = starts.get(n + 1).map_or(16_000.0, |next| next.since(Instant::default()));
        let begin = start.since(Instant::default());
        let beats = (0..).map(|beat| begin + 80.0 + 400.0 * f64::from(beat)).take_while(|at| *at < end);
        expected.extend(beats.map(|at| at - starts[0].since(Instant::default())));
    }
    // Those that were told ahead of their time were called off.
    let last = told.last().unwrap().at.since(starts[0]);
    let expected: Vec<f64> = expected.into_iter().filter(|at| *at <= last).collect();
    let called_off = beats.len() - expected.len();
    assert!(called_off <= starts.len(), "{beats:?} {expected:?}");
    for at in expected {
        assert!(beats.iter().any(|beat| (beat - at).abs() < 1e-6), "{at} {beats:?}");
    }
}

#[test]
fn no_way_to_cut_a_run_changes_a_bit_or_what_is_told() {
    let (whole, told) = turned(TEXT, &[96_000]);
    assert!(told.iter().filter(|told| told.what.starts_with("start")).count() > 30);
    for lengths in [&[1][..], &[5], &[64], &[7, 480, 1, 33], &[512], &[4_096]] {
        let (cut, again) = turned(TEXT, lengths);
        let same = whole.iter().zip(&cut).position(|(a, b)| a.to_bits() != b.to_bits());
        assert_eq!(same, None, "{lengths:?}");
        let heard = |told: &[Told]| {
            told.iter()
                .filter(|told| told.what != "cancel" && told.at.sample < 15_800)
                .cloned()
                .collect::<Vec<_>>()
        };
        assert_eq!(heard(&again), heard(&told), "{lengths:?}");
    }
}

/// Patterns that nodes and knobs set off wait for that, also where nothing else starts one.
#[test]
fn what_is_set_off_does_not_begin_by_itself() {
    let (_, told) = turned(&TEXT.replace("knob.wall", "knob.wall ends"), &[480]);
    assert!(told.iter().all(|told| told.what != "start roll" || told.origin.contains('.')));
    let first = told.iter().find(|told| told.origin == "roll").unwrap().at;
    assert!(first.sample > late(), "{first:?}");
}

/// `check` says by what, and how much later, and nothing of patterns that play by themselves.
#[cfg(feature = "cli")]
#[test]
fn check_and_knob_say_what_sets_a_pattern_off() {
    let folder = std::env::temp_dir().join(format!("pacinian-answers-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let text = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{TEXT}");
    std::fs::write(folder.join("p.toml"), text).unwrap();
    let said = |command: &str| {
        let mut program = std::process::Command::new(env!("CARGO_BIN_EXE_pacinian"));
        let output = program.args([command, "p.toml"]).current_dir(&folder).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    let check = said("check");
    for line in [
        "roll  set off by knob.detent notches, node.sway rises 0.6",
        "beat  set off by knob.wall",
        "knob.wall plays pattern beat 15.4 ms later",
        "node.sway rises 0.6  pattern roll",
    ] {
        assert!(check.contains(line), "{line}: {check}");
    }
    assert!(said("knob").contains("knob.detent notches plays pattern roll 15.4 ms later"));
    std::fs::remove_dir_all(&folder).unwrap();
}
