//! What a patch costs before it sounds grows with its size, and not much faster. Where it grew with the square, each of these would
//! take many times as long as all others together.

mod common;

use std::fmt::Write;

use common::patch;
use pacinian::graph::scene::{Options, scene};
use pacinian::graph::start::Step;
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
use pacinian::player::Player;
use pacinian::rig::Rig;

fn checked(text: &str) -> Patch {
    let patch = patch(text);
    assert!(patch.check().iter().all(|p| !p.is_error()));
    patch
}

/// Steps of all start programs of the first voice, and its ops.
fn work(frequency: &str) -> (usize, usize) {
    let text = format!(
        "[voice.v]\noutput = \"s\"\ndefaults = {{ x = 1 }}\n[voice.v.nodes]\n\
         w = {{ type = \"lfo\", rate = 3 }}\ns = {{ type = \"sine\", frequency = \"{frequency}\" }}\n"
    );
    let options = Options { live: true, ..Options::default() };
    let plan = scene(&patch(&text), &Rig::default_for(1), &options, &NoAssets)
        .unwrap_or_else(|p| panic!("{p}"))
        .plan;
    let program = &plan.instruments[0].program;
    (program.starts.iter().map(|start| start.steps().len()).sum(), program.ops.len())
}

#[test]
fn expressions_are_multiplied_out_within_bounds() {
    let ones = |count| vec!["1"; count].join("+");
    // All of it is known at the onset: as many steps as were written.
    let (steps, ops) = work(&format!("(event.x+{})*({})", ones(230), ones(245)));
    assert!(steps <= 2 * (231 + 245) && ops == 1, "{steps} steps, {ops} ops");
    // Something moves: what is known beside it is known, and the factor is not copied for each of many terms.
    let (steps, ops) = work(&format!("(event.x+{})*({}+w)", ones(230), ones(245)));
    assert!(steps <= 8 * (231 + 245) && ops <= 4, "{steps} steps, {ops} ops");
    let (steps, _) = work(&format!("(event.x+{})*(w{})", ones(230), "+1".repeat(240)));
    assert!(steps <= 8 * (231 + 245), "{steps} steps");
    // A sum of a sensible length is a base and a deviation, as ever.
    let (steps, ops) = work("(event.x + 2) * (60 + 20 * w)");
    assert!(steps > 0 && steps < 20 && ops <= 4, "{steps} steps, {ops} ops");
}

#[test]
fn a_bomb_of_parentheses_stays_small() {
    // Each level would double what is below it.
    let mut text = "w".to_string();
    while text.len() < 900 {
        text = format!("(event.x+1)*({text}+1)");
    }
    let (steps, ops) = work(&text);
    assert!(steps < 10_000 && ops < 1000, "{steps} steps, {ops} ops");
}

#[test]
fn the_known_part_of_a_moving_frequency_is_apart() {
    let known = |frequency: &str| {
        let text = format!(
            "[voice.v]\noutput = \"s\"\n[voice.v.nodes]\nw = {{ type = \"lfo\", rate = 3 }}\n\
             s = {{ type = \"sine\", frequency = \"{frequency}\" }}\n"
        );
        let options = Options { live: true, ..Options::default() };
        let plan = scene(&patch(&text), &Rig::default_for(1), &options, &NoAssets).unwrap().plan;
        let program = &plan.instruments[0].program;
        let steps: Vec<Vec<Step>> = program.starts.iter().map(|start| start.steps().to_vec()).collect();
        steps.concat().contains(&Step::Own(0))
    };
    assert!(known("event.frequency * (1 + 0.1 * w)") && known("(w + 1) * (event.frequency * 2)"));
}

#[test]
fn many_events_find_their_voices() {
    let mut text = String::new();
    for v in 0..20_000 {
        let _ = writeln!(
            text,
            "[voice.v{v}]\noutput = \"s\"\nnodes.s = {{ type = \"sine\", frequency = 80 }}\nvoices = 1"
        );
    }
    text.push_str("[pattern.p]\nevents = [\n");
    for n in 0..50_000 {
        let _ = writeln!(text, "  {{ at = 0.5, voice = \"v{}\", place = \"t1\" }},", n % 20_000);
    }
    text.push_str("]\n");
    let patch = checked(&text);
    let mut player = Player::new(&patch, &Rig::default_for(1), &Options::default(), &NoAssets)
        .unwrap_or_else(|p| panic!("{p}"));
    player.listen(Box::new(|heard| assert!(heard.id.is_some())));
    player.process(&mut [0.0; 480]);
}

#[test]
fn many_voices_share_many_controls() {
    let mut text = String::new();
    for c in 0..20_000 {
        let _ = writeln!(text, "[control.c{c}]\ndefault = 0.5");
    }
    for v in 0..10_000 {
        let _ = writeln!(
            text,
            "[voice.v{v}]\noutput = \"s\"\nnodes.s = {{ type = \"sine\", frequency = \"80 + c{}\" }}\nvoices = 1",
            2 * v
        );
    }
    let options = Options { live: true, ..Options::default() };
    let plan = scene(&checked(&text), &Rig::default_for(1), &options, &NoAssets)
        .unwrap_or_else(|p| panic!("{p}"))
        .plan;
    assert_eq!((plan.instruments.len(), plan.controls.len()), (10_000, 10_000));
}
