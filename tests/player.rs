//! What a player makes of dense patterns, and of programs that ask for what cannot be.

mod common;

use std::sync::{Arc, Mutex};

use common::{channel, patch};
use pacinian::graph::scene::Options;
use pacinian::node::asset::NoAssets;
use pacinian::patch::Place;
use pacinian::player::{Note, Player};
use pacinian::rig::Rig;

fn player(text: &str, channels: u32) -> Player {
    let options = Options { live: true, ..Options::default() };
    Player::new(&patch(text), &Rig::default_for(channels), &options, &NoAssets)
        .unwrap_or_else(|p| panic!("{p}"))
}

/// A tap on the second tactor, and so much beside it.
fn tap(beside: &str) -> String {
    format!(
        "[voice.v]\nvoices = 2\noutput = \"s\"\nnodes.s = {{ type = \"sine\", frequency = 100 }}\n\
         [voice.tap]\noutput = \"s\"\nnodes.s = {{ type = \"sine\", frequency = 250, phase = 0.25 }}\n\
         [pattern.p]\nevents = [{beside} {{ at = 0.1, voice = \"tap\", place = \"t2\", duration = 0.05 }}]\n"
    )
}

fn second(player: &mut Player, call: usize) -> Vec<f64> {
    let mut frames = vec![0.0; 2 * 9600];
    frames.chunks_mut(2 * call).for_each(|part| player.process(part));
    channel(&frames, 2, 1)
}

#[test]
fn a_dense_pattern_delays_nothing_beside_it() {
    let alone = second(&mut player(&tap(""), 2), 9600);
    assert!(alone.iter().any(|x| x.abs() > 0.5));
    // One event a microsecond, for more than the queue holds in any stretch of time that is worth computing.
    let dense = "{ at = 0, voice = \"v\", duration = 0, repeat = { every = 0.000001, times = 150000 } },";
    // More than it holds within one sample.
    let at_once = "{ at = 0.09991, voice = \"v\", duration = 0, repeat = { every = 0.000001, times = 80 } },"
        .repeat(500);
    for (beside, calls) in [(dense, [9600, 479]), (&at_once, [9600, 7])] {
        for call in calls {
            let mut player = player(&tap(beside), 2);
            let found = second(&mut player, call);
            let counters = player.counters();
            assert_eq!((counters.late, counters.dropped), (0, 0));
            assert!(found == alone, "calls of {call}: the tap is elsewhere");
        }
    }
}

#[test]
fn a_program_that_fills_the_queue_keeps_no_pattern_waiting() {
    let dense = "{ at = 0, voice = \"v\", duration = 0, repeat = { every = 0.00001, times = 15000 } },";
    let mut player = player(&tap(dense), 2);
    let far = std::iter::from_fn(|| player.play_at(1000.0, "tap", &Note::default()).ok()).count();
    assert!((10_000..20_000).contains(&far), "{far}");
    let found = second(&mut player, 9600);
    assert!(found == second(&mut self::player(&tap(""), 2), 9600));
    assert_eq!((player.counters().late, player.counters().dropped), (0, 0));
}

#[test]
fn what_cannot_be_played_is_told() {
    let text = format!(
        "[control.c]\ndefault = 0.5\n{}",
        tap("").replace("frequency = 100", "frequency = \"100 + c\"")
    );
    let mut player = player(&text, 2);
    let heard = Arc::new(Mutex::new(0));
    let count = Arc::clone(&heard);
    player.listen(Box::new(move |_| *count.lock().unwrap() += 1));
    for at in [f64::NAN, -1.0, f64::INFINITY, f64::NEG_INFINITY, 1e300] {
        let shown = player.play_at(at, "tap", &Note::default()).unwrap_err().to_string();
        assert!(
            shown.contains(&format!("at {at} s")) && shown.contains("seconds from the beginning"),
            "{shown}"
        );
    }
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let shown = player.set("c", value).unwrap_err().to_string();
        assert!(shown.contains("control `c`") && shown.contains("finite"), "{shown}");
    }
    for position in [[f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0]] {
        let note = Note { place: Some(Place::Position(position)), ..Note::default() };
        let shown = player.play("tap", &note).unwrap_err().to_string();
        assert!(shown.contains("no position"), "{shown}");
    }
    assert_eq!(*heard.lock().unwrap(), 0);
    assert!(player.set("c", 0.25).is_ok() && player.play_at(0.01, "tap", &Note::default()).is_ok());
    second(&mut player, 9600);
    second(&mut player, 9600);
    let mut rest = vec![0.0; 2 * 96_000];
    player.process(&mut rest);
    assert!(player.is_over());
}
