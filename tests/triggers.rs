//! Markers put pulses on trigger outputs, aligned with the vibration.

mod common;

use pacinian::graph::scene::Options;
use pacinian::node::asset::NoAssets;
use pacinian::player::Player;
use pacinian::rig::Rig;

const PATCH: &str = r#"
[voice.tap]
output = "out"
[voice.tap.nodes]
tone = { type = "sine", frequency = 250 }
bump = { type = "burst", attack = 0.05, decay = 0.05 }
out = { type = "multiply", inputs = ["tone", "bump", 0.5] }
[pattern.p]
events = [
  { at = 0.1001, voice = "tap", duration = 0.1 },
  { at = 0.1501, marker = "middle" },
  { at = 0.3, marker = "end" },
]
"#;

const RIG: &str = r#"
format = "pacinian-rig/1"
title = "One tactor, two triggers"
[device]
channels = 3
[[tactor]]
name = "t"
channel = 1
[[output]]
kind = "trigger"
name = "all"
channel = 2
pulse = 0.005
[[output]]
kind = "trigger"
name = "only-end"
channel = 3
marker = "end"
pulse = 0.001
"#;

fn frames(call: usize) -> (Vec<f32>, f64) {
    let rig = Rig::parse("rig.toml", RIG.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let mut player = Player::new(&common::patch(PATCH), &rig, &Options::default(), &NoAssets).unwrap();
    let mut output = vec![0.0; 3 * 24_000];
    output.chunks_mut(3 * call).for_each(|part| player.process(part));
    let delay = player.engine().delay().total();
    (output, delay)
}

fn pulses(frames: &[f32], channel: usize) -> Vec<(usize, usize)> {
    let on: Vec<usize> = (0..frames.len() / 3).filter(|n| frames[3 * n + channel] == 1.0).collect();
    assert!(frames.iter().skip(channel).step_by(3).all(|x| *x == 0.0 || *x == 1.0));
    let begins = on.iter().filter(|n| !on.contains(&(**n - 1)));
    begins.map(|&n| (n, (n..).take_while(|m| on.contains(m)).count())).collect()
}

#[test]
fn pulses_come_with_the_vibration_they_mark() {
    let (output, delay) = frames(480);
    let due = |at: f64| ((at + delay) * 48_000.0).round() as usize;
    assert_eq!(pulses(&output, 1), [(due(0.1501), 240), (due(0.3), 240)]);
    assert_eq!(pulses(&output, 2), [(due(0.3), 48)]);
    // The bump is greatest where its marker is, within the reach of its own tone.
    let peak = (0..24_000).max_by(|&a, &b| output[3 * a].abs().total_cmp(&output[3 * b].abs())).unwrap();
    assert!(peak.abs_diff(due(0.1501)) < 200, "{peak} for {}", due(0.1501));
}

#[test]
fn pulses_do_not_mind_how_time_is_cut() {
    let whole = frames(24_000).0;
    for call in [1, 7, 64] {
        assert!(frames(call).0 == whole, "calls of {call}");
    }
}

fn loudest(trigger: &str) -> f32 {
    let patch = PATCH.split("[pattern.p]").next().unwrap_or_default().to_string() + trigger;
    let mut player =
        Player::new(&common::patch(&patch), &Rig::default_for(1), &Options::default(), &NoAssets).unwrap();
    let mut output = vec![0.0; 9_600];
    player.process(&mut output);
    output.iter().fold(0.0, |most, x| most.max(x.abs()))
}

#[test]
fn a_start_trigger_sets_the_event_it_makes() {
    let full = loudest("[[trigger]]\non = \"start\"\nplay = \"tap\"\n");
    let half = loudest("[[trigger]]\non = \"start\"\nplay = \"tap\"\nset = { level = \"1 / 2\" }\n");
    assert!(full > 0.1 && (half / full - 0.5).abs() < 1e-3, "{half} of {full}");
}

#[test]
fn what_a_trigger_cannot_say_is_refused_at_its_line() {
    for (entry, says, line) in [
        ("play = \"p\"\nset = { gain = 0.5 }", "has no `gain`", 18),
        ("play = \"p\"\nset = { rate = 2 }", "has no `rate`", 18),
        ("play = \"p\"\nplace = 1", "cannot say where pattern `p` plays", 15),
        ("play = \"tap\"\nset = { level = -1 }", "from 0 to 100", 18),
    ] {
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"t\"{PATCH}[[trigger]]\non = \"start\"\n{entry}\n"
        );
        let problems = pacinian::patch::Patch::parse("p.toml", text.as_bytes()).unwrap_err();
        let [problem] = problems.list.as_slice() else { panic!("{problems}") };
        assert!(problem.what.contains(says), "{problem}");
        assert_eq!(problem.span.as_ref().map(|s| problems.position(s.start).0), Some(line), "{problem}");
    }
}
