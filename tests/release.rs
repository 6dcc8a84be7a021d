//! Everything falls silent when it is told to, and a listener hears of it.

mod common;

use std::sync::{Arc, Mutex};

use pacinian::graph::scene::Options;
use pacinian::midi::{Channel, Message};
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

/// Takes seconds to die away.
const LONG: &str = r#"
[voice.long]
output = "out"
[voice.long.nodes]
tone = { type = "sine", frequency = 100 }
hold = { type = "envelope", attack = 0.01, release = 3 }
out = { type = "multiply", inputs = ["tone", "hold"] }
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
            Happening::Start(name) | Happening::Marker(name) => name.into(),
            Happening::Control(name, value) => format!("{name} to {value}"),
            Happening::Release => "release".into(),
            Happening::ReleaseAll => "all".into(),
            Happening::Silence(bits) => format!("silence {bits}"),
            Happening::Cancel(bits) => format!("cancel {bits}"),
            Happening::Touch(motion, value) => format!("{motion:?} {value}"),
            Happening::Message(message) => format!("{message:?}"),
            Happening::Waits { control, .. } => format!("{control} waits"),
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

/// What a key has started, even where it takes seconds to die away, is silent within 5 ms of all sound off on its channel; what another
/// channel, the program and the patch have started is as if nothing had been said.
#[test]
fn all_sound_off_is_a_hundredth_after_five_milliseconds_and_then_nothing() {
    const KEYS: &str = r#"
[voice.hum]
output = "tone"
start = "always"
place = "t2"
nodes.tone = { type = "sine", frequency = 60, amplitude = 0.2 }
[pattern.beats]
repeat = { every = 0.02 }
events = [{ at = 0, voice = "long", level = 0.2, duration = 0.01 }]
[[trigger]]
on = "midi.note"
play = "long"
spread = "channels"
notes = [0, 63]
[[trigger]]
on = "midi.note"
play = "beats"
notes = [64, 127]
"#;
    let on = |channel, note| Message::NoteOn { channel: Channel::new(channel).unwrap(), note, velocity: 100 };
    let off = |note| Message::NoteOff { channel: Channel::FIRST, note, velocity: 64 };
    let silence = Message::Controller { channel: Channel::FIRST, number: 120, value: 0 };
    let play = |silenced: bool| {
        let options = Options { live: true, rate: Some(48_000.0), ..Options::default() };
        let patch = common::patch(&format!("{LONG}{KEYS}"));
        let mut player =
            Player::new(&patch, &Rig::default_for(2), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
        let mut song =
            vec![(0.1, on(0, 60)), (0.1, on(1, 60)), (0.1, on(0, 62)), (0.12, on(0, 70)), (0.3, off(60))];
        if silenced {
            song.push((0.5, silence));
        }
        player.play_song(song, 10.0);
        let mut frames = vec![0.0; 48_000 * 2];
        player.process(&mut frames);
        frames
    };
    let (heard, whole) = (play(true), play(false));
    let of = |frames: &[f32], channel: usize, from: f64| -> Vec<f32> {
        frames.chunks(2).skip((from * 48_000.0) as usize).map(|frame| frame[channel]).collect()
    };
    let peak = |frames: &[f32]| frames.iter().fold(0.0_f32, |peak, x| peak.max(x.abs()));
    assert!(peak(&of(&heard[..48_000], 0, 0.45)) > 0.1);
    assert!(peak(&of(&whole, 0, 0.505)) > 0.1);
    // What is left then rings in the band limit.
    let sounded = peak(&of(&heard[..48_000], 0, 0.45));
    for (after, left) in [(0.005, 0.01), (0.02, 3e-4), (0.05, 1e-5)] {
        assert!(peak(&of(&heard, 0, 0.5 + after)) < left * sounded, "{after} s");
    }
    assert_eq!(peak(&of(&heard, 0, 0.7)), 0.0);
    assert!(of(&heard, 1, 0.0) == of(&whole, 1, 0.0) && peak(&of(&heard, 1, 0.9)) > 0.1);
    // It goes in a curve and not at a blow: no step is larger than a fifth of what sounded.
    let steps =
        of(&heard, 0, 0.49).windows(2).fold(0.0_f32, |most, pair| most.max((pair[1] - pair[0]).abs()));
    assert!(steps < 0.2 * peak(&of(&heard[..48_000], 0, 0.45)), "{steps}");
}

/// Where nothing else sounds the output itself goes to exact zeros, and comes back for the next key, which sounds as it would have.
#[test]
fn where_nothing_else_sounds_it_is_exact_zeros_after_five_milliseconds() {
    const KEYS: &str = r#"
[[trigger]]
on = "midi.note"
play = "long"
"#;
    // Quiet enough that the limiter, which holds what it does, has nothing to do.
    let on = |note| Message::NoteOn { channel: Channel::FIRST, note, velocity: 50 };
    let play = |song: Vec<(f64, Message)>, parts: &[usize]| {
        let options = Options { live: true, rate: Some(48_000.0), ..Options::default() };
        let patch = common::patch(&format!("{LONG}{KEYS}"));
        let mut player =
            Player::new(&patch, &Rig::default_for(1), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
        player.play_song(song, 10.0);
        let mut frames = vec![0.0; 48_000];
        let (mut rest, mut parts) = (&mut frames[..], parts.iter().cycle());
        while !rest.is_empty() {
            let (now, later) = rest.split_at_mut((*parts.next().unwrap()).min(rest.len()));
            player.process(now);
            rest = later;
        }
        frames
    };
    let silence = Message::Controller { channel: Channel::FIRST, number: 120, value: 0 };
    for panic in [silence, Message::Reset] {
        let song = vec![(0.1, on(60)), (0.12, on(67)), (0.5, panic), (0.52, on(48)), (0.6, panic)];
        let heard = play(song.clone(), &[48_000]);
        let at = |seconds: f64| (seconds * 48_000.0_f64).round() as usize;
        let peak =
            |from: f64, to: f64| heard[at(from)..at(to)].iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        assert!(peak(0.4, 0.5) > 0.1);
        assert!(
            heard[at(0.505)..at(0.52)].iter().chain(&heard[at(0.605)..]).all(|x| x.to_bits() == 0),
            "{panic:?}"
        );
        assert_eq!(play(song, &[1, 77, 64, 480, 1001]), heard);
        // The next key: as if it were the first, but for what still rings of the others, 75 dB below.
        let alone = play(vec![(0.52, on(48))], &[480]);
        let off =
            |from: f64, to: f64| (at(from)..at(to)).map(|i| (heard[i] - alone[i]).abs()).fold(0.0, f32::max);
        assert!(off(0.52, 0.6) < 1e-3 * peak(0.4, 0.5), "{}", off(0.52, 0.6));
    }
}
