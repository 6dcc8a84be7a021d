//! Everything falls silent when it is told to, and a listener hears of it.

mod common;

use std::sync::{Arc, Mutex};

use pacinian::graph::scene::Options;
use pacinian::node::asset::NoAssets;
use pacinian::player::{Happening, Note, Player};
use pacinian::rig::Rig;

const PATCH: &str = r#"
[control.strength]
default = 1.0
range = [0.0, 1.0]
[voice.held]
output = "out"
[voice.held.nodes]
tone = { type = "sine", frequency = 100, amplitude = "strength" }
hold = { type = "envelope", attack = 0.01, release = 0.2 }
out = { type = "multiply", inputs = ["tone", "hold"] }
[voice.bare]
output = "tone"
nodes.tone = { type = "sine", frequency = 150 }
[[trigger]]
on = "start"
play = "held"
"#;

fn player() -> Player {
    let options = Options { live: true, ..Options::default() };
    let patch = common::patch(PATCH);
    Player::new(&patch, &Rig::default_for(2), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"))
}

fn seconds(player: &mut Player, seconds: f64) -> f32 {
    let mut frames = vec![0.0; (seconds * 48_000.0) as usize * 2];
    player.process(&mut frames);
    frames[frames.len() / 2..].iter().fold(0.0, |peak, x| x.abs().max(peak))
}

#[test]
fn all_voices_fall_silent_by_their_releases() {
    let mut player = player();
    let held = Note { duration: Some(f64::INFINITY), level: Some(0.3), ..Note::default() };
    for voice in ["held", "held", "bare"] {
        player.play(voice, &held).unwrap();
    }
    assert!(seconds(&mut player, 0.5) > 0.3);
    assert!(player.engine().sounding() >= 3);
    player.release_all();
    // Half of a release of 0.2 s is not over; the other half is.
    assert!(seconds(&mut player, 0.1) > 0.01);
    seconds(&mut player, 0.3);
    assert_eq!(player.engine().sounding(), 0);
    assert_eq!(seconds(&mut player, 0.2), 0.0);
    player.play("held", &held).unwrap();
    assert!(seconds(&mut player, 0.2) > 0.1, "what comes later sounds");
}

#[test]
fn a_listener_hears_of_all_that_the_program_does() {
    let mut player = player();
    let heard = Arc::new(Mutex::new(Vec::new()));
    let list = Arc::clone(&heard);
    player.listen(Box::new(move |event| {
        let what = match event.what {
            Happening::Voice { name, place, .. } => format!("{name} on {place}"),
            Happening::Marker(name) => name.into(),
            Happening::Control(name, value) => format!("{name} to {value}"),
            Happening::Release => "release".into(),
            Happening::ReleaseAll => "all".into(),
            Happening::Touch(motion, value) => format!("{motion:?} {value}"),
        };
        list.lock().unwrap().push((event.instant.sample, what, event.id));
    }));
    seconds(&mut player, 0.1);
    let id = player.play("bare", &Note::default()).unwrap();
    player.set("strength", 0.5).unwrap();
    player.release(id);
    player.release_all();
    let heard = heard.lock().unwrap();
    let of = |i: usize| (heard[i].0, heard[i].1.as_str());
    // The trigger `start` came before the listener.
    assert_eq!((of(0), heard.len()), ((0, "held on t1"), 5));
    let now = heard[1].0;
    assert!(now >= 800);
    let rest: Vec<_> = (1..5).map(of).collect();
    assert_eq!(rest, [(now, "bare on t1"), (now, "strength to 0.5"), (now, "release"), (now, "all")]);
    assert_eq!((heard[1].2, heard[3].2), (Some(id), Some(id)));
}
