//! Each voice ends when its own time is over, whatever became of the voices before it on its lane.

mod common;

use std::sync::{Arc, Mutex};

use common::{channel, compiled, patch, play, run, schedule};
use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Play, Source};
use pacinian::engine::exchange::exchange;
use pacinian::engine::turnover::Turned;
use pacinian::graph::scene::Options;
use pacinian::node::asset::NoAssets;
use pacinian::player::Player;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;

/// One voice at a time, without an envelope: its end is a fade of 4 ms.
const BARE: &str = r#"
[voice.v]
voices = 1
output = "s"
nodes.s = { type = "sine", frequency = "event.frequency" }
"#;

/// Engine samples a second at 48 kHz.
const RATE: f64 = 8000.0;

fn peak(signal: &[f64], from: f64, to: f64) -> f64 {
    let at = |seconds: f64| (seconds * 48_000.0) as usize;
    signal[at(from)..at(to)].iter().fold(0.0, |peak, x| x.abs().max(peak))
}

#[test]
fn ends_of_stolen_voices_take_no_room_from_later_events() {
    let text = r#"
        [voice.v]
        voices = 3
        defaults = { duration = 60 }
        output = "s"
        nodes.s = { type = "sine", frequency = 100 }
        [pattern.p]
        events = [
          { at = 0, voice = "v", repeat = { every = 0.0005, times = 20000 } },
          { at = 10.5, voice = "v", place = "t2" },
        ]
    "#;
    let options = Options::default();
    let mut player = Player::new(&patch(text), &Rig::default_for(2), &options, &NoAssets)
        .unwrap_or_else(|p| panic!("{p}"));
    let heard = Arc::new(Mutex::new(0));
    let count = Arc::clone(&heard);
    player.listen(Box::new(move |_| *count.lock().unwrap() += 1));
    let mut frames = vec![0.0; 2 * 48_000 * 11];
    player.process(&mut frames);
    assert_eq!(*heard.lock().unwrap(), 20_001);
    let counters = player.counters();
    assert_eq!((counters.started, counters.dropped, counters.late), (20_001, 0, 0));
    assert!(peak(&channel(&frames, 2, 1), 10.6, 11.0) > 0.5, "the last voice sounds on the second tactor");
}

/// However many begin at the same instant, and however few lanes are left for those that fade.
#[test]
fn who_made_room_for_whom_is_known() {
    let plan = compiled(BARE, 1, 48_000.0).plan;
    let mut engine = Engine::new(&plan).unwrap();
    let notes: Vec<_> =
        (0..40).map(|id| (16.0 + f64::from(id / 20), play(0, 0, 90.0, 1.0, id as u64))).collect();
    schedule(&mut engine, &notes);
    run(&mut engine, 960, &[96]);
    let turns: Vec<_> = engine.turnover().map(|turn| (turn.at.sample, turn.what)).collect();
    let wanted: Vec<_> = (1..40).map(|id| (16 + id / 20, Turned::Stolen(id - 1, id))).collect();
    assert_eq!(turns, wanted);
    assert_eq!((engine.counters().stolen, engine.turnover().count()), (39, 0));
}

#[test]
fn the_queue_holds_events_and_nothing_else() {
    let plan = compiled(BARE, 1, 48_000.0).plan;
    let mut engine = Engine::new(&plan).unwrap();
    let room = engine.room();
    for n in 0..30_000_u32 {
        let at = Instant { sample: engine.clock(), fraction: 0 };
        let event = Event::Play(play(0, 0, 90.0, 600.0, u64::from(n)));
        assert!(engine.schedule(at, Source::Program, event), "event {n}");
        run(&mut engine, 6, &[6]);
    }
    assert_eq!(engine.room(), room);
}

#[test]
fn a_voice_is_not_ended_by_one_before_it_of_the_same_id() {
    let plan = compiled(BARE, 1, 48_000.0).plan;
    let mut engine = Engine::new(&plan).unwrap();
    let notes = [(0.0, 1.0), (0.3, 0.2), (0.6, 5.0)];
    let notes = notes.map(|(at, duration)| (at * RATE, play(0, 0, 100.0, duration, 0)));
    schedule(&mut engine, &notes);
    let signal = channel(&run(&mut engine, 6 * 48_000, &[480]), 1, 0);
    assert!(
        peak(&signal, 0.45, 0.49) > 0.5 && peak(&signal, 0.53, 0.6) < 1e-3,
        "the second note ends at 0.5 s"
    );
    assert!(peak(&signal, 1.1, 1.2) > 0.5 && peak(&signal, 5.5, 5.59) > 0.5, "the third sounds its 5 s");
    assert!(peak(&signal, 5.65, 6.0) < 1e-3);
}

#[test]
fn one_that_takes_a_lane_ends_as_if_it_had_been_alone() {
    let plan = compiled(BARE, 1, 48_000.0).plan;
    let sound = |with_another: bool| {
        let mut engine = Engine::new(&plan).unwrap();
        let mut notes = vec![(0.2 * RATE + 0.3, play(0, 0, 100.0, 0.4 + 1e-5, 7))];
        // Soft enough for the limiter to let both pass.
        notes[0].1.level = 0.3;
        if with_another {
            notes.push((0.0, Play { level: 0.3, ..play(0, 0, 60.0, 0.5, 6) }));
        }
        schedule(&mut engine, &notes);
        let frames = run(&mut engine, 48_000, &[480]);
        (engine.counters().stolen, channel(&frames, 1, 0))
    };
    let ((stolen, taken), (none, alone)) = (sound(true), sound(false));
    assert_eq!((stolen, none), (1, 0));
    // Past what the first leaves in the output stage; through its end at 0.5 s and that of the second at 0.6 s.
    let from = 14_400;
    let largest = taken[from..].iter().zip(&alone[from..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(largest < 1e-5, "{largest}");
    assert!(peak(&alone, 0.55, 0.59) > 0.2 && peak(&alone, 0.65, 1.0) < 1e-3);
}

#[test]
fn what_waits_for_a_stolen_voice_is_not_waited_for() {
    let plan = compiled(BARE, 1, 48_000.0).plan;
    let mut engine = Engine::new(&plan).unwrap();
    schedule(&mut engine, &[(0.0, play(0, 0, 60.0, 1e6, 1)), (80.0, play(0, 0, 60.0, 0.05, 2))]);
    run(&mut engine, 9600, &[480]);
    assert!(engine.is_silent());
    // One that is released has no end to wait for either.
    schedule(&mut engine, &[(1700.0, play(0, 0, 60.0, 1e6, 1))]);
    engine.schedule(Instant::of_samples(1800.0), Source::Program, Event::Release(1));
    run(&mut engine, 9600, &[480]);
    assert!(engine.is_silent());
}

#[test]
fn ends_follow_their_voices_into_the_next_plan() {
    let old = compiled(BARE, 1, 48_000.0).plan;
    let front = "[voice.a]\nvoices = 20\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = 30 }\n";
    let new = compiled(&format!("{front}{BARE}"), 1, 48_000.0).plan;
    let run = |next: Option<&pacinian::graph::plan::Plan>| {
        let (mut director, mut stagehand) = exchange(&old).unwrap();
        schedule(stagehand.engine(), &[(0.5, play(0, 0, 100.0, 0.5, 1))]);
        let mut frames = vec![0.0; 48_000];
        for (n, part) in frames.chunks_mut(480).enumerate() {
            if let Some(plan) = next.filter(|_| n == 20) {
                assert!(director.send(plan).unwrap());
            }
            stagehand.process(&[], part);
        }
        assert!(stagehand.engine().is_silent());
        channel(&frames, 1, 0)
    };
    let (kept, changed) = (run(None), run(Some(&new)));
    assert!(peak(&changed, 0.45, 0.49) > 0.5, "it sounds on");
    let apart = kept[23_000..].iter().zip(&changed[23_000..]).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(apart < 1e-4, "and ends at its time: {apart}");
    assert!(peak(&changed, 0.55, 1.0) < 1e-3);
}
