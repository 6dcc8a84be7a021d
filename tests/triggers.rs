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
