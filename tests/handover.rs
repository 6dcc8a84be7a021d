//! Plans that follow one another while they sound.

mod common;

use common::{compiled, play, schedule};
use pacinian::engine::event::{Event, Move, Play, Source};
use pacinian::engine::exchange::exchange;
use pacinian::graph::plan::Plan;
use pacinian::node::motion::Motion;
use pacinian::schedule::Instant;
use pacinian::space::spot::Spot;

const FIRST: &str = r#"
[control.strength]
default = 0.7
range = [0.0, 1.0]
[shared.nodes]
wobble = { type = "sine", frequency = 3 }
[voice.beat]
voices = 6
output = "out"
[voice.beat.nodes]
tone = { type = "sine", frequency = "event.frequency + 20 * wobble" }
hit = { type = "envelope", attack = 0.004, decay = 0.03, sustain = 0.4, release = 0.02 }
out = { type = "multiply", inputs = ["tone", "hit", "strength"] }
"#;

const OTHER: &str = r#"
[voice.other]
output = "out"
[voice.other.nodes]
tone = { type = "sine", frequency = "event.frequency" }
hit = { type = "envelope" }
out = { type = "multiply", inputs = ["tone", "hit"] }
"#;

/// Frames of a run in calls of 48 frames; before the n-th call, the plan that `change` names is sent.
fn run(first: &Plan, calls: usize, mut change: impl FnMut(usize) -> Option<Plan>) -> Vec<f32> {
    let (mut director, mut stagehand) = exchange(first).unwrap();
    let events: Vec<_> = (0..30_u32)
        .map(|i| (f64::from(i) * 97.3, play(0, i % 4, 50.0 + 11.0 * f64::from(i), 0.05, u64::from(i))))
        .collect();
    schedule(stagehand.engine(), &events);
    let mut output = vec![0.0; calls * 48 * 4];
    for (n, part) in output.chunks_mut(48 * 4).enumerate() {
        if let Some(plan) = change(n) {
            director.send(&plan).unwrap();
        }
        stagehand.process(&[], part);
    }
    output
}

fn largest_step(frames: &[f32]) -> f32 {
    frames.iter().zip(&frames[4..]).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn the_same_plan_again_changes_no_bit() {
    let plan = compiled(FIRST, 4, 48_000.0).plan;
    let once = run(&plan, 400, |_| None);
    let again = run(&plan, 400, |n| (n % 3 == 1).then(|| plan.clone()));
    assert!(once.iter().any(|x| *x != 0.0));
    assert!(once.iter().map(|x| x.to_bits()).eq(again.iter().map(|x| x.to_bits())));
}

#[test]
fn a_changed_graph_steps_no_more_than_an_unchanged_one() {
    let plan = compiled(FIRST, 4, 48_000.0).plan;
    let with_more = FIRST
        .replace("\"strength\"]", "\"strength\", \"soft\"]")
        .replace("out = {", "soft = { type = \"envelope\", attack = 0.05, release = 0.05 }\nout = {");
    let more = compiled(&with_more, 4, 48_000.0).plan;
    let without = compiled(OTHER, 4, 48_000.0).plan;
    let plain = largest_step(&run(&plan, 400, |_| None));
    for (name, other) in [("a node more", &more), ("the voice gone", &without)] {
        let changed = run(&plan, 400, |n| (n == 100).then(|| other.clone()));
        let step = largest_step(&changed);
        assert!(step <= plain * 1.003, "{name}: a step of {step} where {plain} was the largest");
    }
    // What has no counterpart falls silent.
    let gone = run(&plan, 400, |n| (n == 100).then(|| without.clone()));
    assert!(gone[48 * 4 * 250..].iter().all(|x| x.abs() < 1e-4));
    assert!(gone[..48 * 4 * 100].iter().any(|x| x.abs() > 0.05));
}

#[test]
fn one_is_under_way_and_waits_until_it_is_admitted() {
    let plan = compiled(FIRST, 4, 48_000.0).plan;
    let (mut director, mut stagehand) = exchange(&plan).unwrap();
    assert!(!director.is_ready());
    assert!(director.offer(&plan).unwrap());
    assert!(!director.send(&plan).unwrap(), "another is under way");
    let mut frames = vec![0.0; 4 * 480];
    for _ in 0..4 {
        assert!(!stagehand.take_over());
        stagehand.process(&[], &mut frames);
        // It has nothing long to copy.
        assert!(director.is_ready() && director.collect() == 1);
    }
    director.admit();
    assert!(stagehand.take_over());
    assert!(!stagehand.take_over());
    assert!(!director.send(&plan).unwrap(), "the one before has not come back");
    for _ in 0..4 {
        stagehand.process(&[], &mut frames);
    }
    assert_eq!(director.collect(), 0);
    assert!(director.send(&plan).unwrap());
}

/// A voice that is always on begins in every engine that is built for it; what takes over must go on with the one that sounds.
#[test]
fn a_voice_that_is_always_on_goes_on_alone() {
    let hum = "[voice.hum]\nstart = \"always\"\noutput = \"tone\"\n[voice.hum.nodes]\n\
               tone = { type = \"sine\", frequency = 100, amplitude = 0.5 }\n";
    let plan = |text: &str| compiled(text, 1, 48_000.0).plan;
    let run = |change: &dyn Fn(usize) -> Option<Plan>| {
        let (mut director, mut stagehand) = exchange(&plan(hum)).unwrap();
        let mut output = vec![0.0; 400 * 64];
        for (n, part) in output.chunks_mut(64).enumerate() {
            if let Some(plan) = change(n) {
                director.send(&plan).unwrap();
            }
            stagehand.process(&[], part);
        }
        output
    };
    let steady = run(&|_| None);
    assert_eq!(run(&|n| (n % 20 == 7).then(|| plan(hum))), steady);
    let changed = run(&|n| (n == 200).then(|| plan(&format!("{hum}{OTHER}"))));
    let error = changed.iter().zip(&steady).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    // What the extrapolation of two samples misses of a sine: 0.5 (2π 100 / 8000)² at most.
    assert!(error < 0.0031, "{error}");
}

/// The loudest of each tenth of a second on one channel: a voice of id 1 at time 0, released after `held` seconds and pressed at `pressed`, of a
/// patch that another takes over after `change` seconds.
fn loudest(old: &str, new: &str, change: f64, held: f64, pressed: Option<f64>) -> Vec<f32> {
    let plan = |nodes: &str| {
        let text = format!("[voice.v]\noutput = \"out\"\n[voice.v.nodes]\n{nodes}");
        compiled(&text, 1, 48_000.0).plan
    };
    let (mut director, mut stagehand) = exchange(&plan(old)).unwrap();
    schedule(stagehand.engine(), &[(0.0, play(0, 0, 50.0, held, 1))]);
    if let Some(at) = pressed {
        let press = Move { id: 1, motion: Motion::Pressure, value: 0.5 };
        let at = Instant { sample: (at * 8_000.0) as u64, fraction: 0 };
        assert!(stagehand.engine().schedule(at, Source::Program, Event::Touch(press)));
    }
    let mut output = vec![0.0; 48 * 8_000];
    for (n, part) in output.chunks_mut(48).enumerate() {
        if n == (change * 1_000.0) as usize {
            director.send(&plan(new)).unwrap();
        }
        stagehand.process(&[], part);
    }
    output.chunks(4_800).map(|part| part.iter().fold(0.0_f32, |most, x| most.max(x.abs()))).collect()
}

/// What a plan adds to a voice that has sounded for seconds has not sounded for seconds itself.
#[test]
fn what_is_new_in_an_old_voice_begins_and_ends_as_it_should() {
    let sine = "tone = { type = \"sine\", frequency = 50, amplitude = 0.05 }\n";
    let out = |envelope: &str| {
        format!("{sine}out = {{ type = \"multiply\", inputs = [\"tone\", \"{envelope}\"] }}\n")
    };
    let envelope = |name: &str, release: f64, curve: f64| {
        let node = format!(
            "{name} = {{ type = \"envelope\", attack = 0.01, release = {release}, release_curve = {curve} }}\n"
        );
        format!("{node}{}", out(name))
    };
    let bare = sine.replace("tone", "out");
    let touched = sine.replace("0.05", "\"0.05 * (1 - 0.5 * touch.pressure)\"").replace("tone", "out");
    for (what, old, new) in [
        ("an envelope more", &bare, envelope("hit", 0.02, 0.0)),
        ("another envelope", &envelope("hit", 0.02, 0.0), envelope("thump", 0.03, -4.0)),
        ("another envelope of the same name", &envelope("hit", 0.02, 0.0), envelope("hit", 0.02, 3.0)),
        ("a gate", &bare, format!("hit = {{ type = \"gate\" }}\n{}", out("hit"))),
    ] {
        let loudest = loudest(old, &new, 4.0, 6.0, None);
        assert!(loudest[..60].iter().all(|peak| (0.045..0.055).contains(peak)), "{what}: {loudest:?}");
        assert!(loudest[61..].iter().all(|peak| *peak < 1e-6), "{what}: {loudest:?}");
    }
    // One that was let go of and whose envelope is another now has nothing left that would end it.
    let loudest_of = loudest(&envelope("hit", 5.0, 0.0), &envelope("thump", 5.0, 0.0), 3.0, 1.0, None);
    assert!(loudest_of[29] > 0.02 && loudest_of[31..].iter().all(|peak| *peak < 1e-6), "{loudest_of:?}");
    let pressed = loudest(&bare, &touched, 2.0, 7.0, Some(5.0));
    assert!(pressed[..50].iter().all(|peak| (0.045..0.055).contains(peak)), "{pressed:?}");
    assert!(pressed[51..69].iter().all(|peak| (0.035..0.0395).contains(peak)), "{pressed:?}");
    assert!(pressed[71..].iter().all(|peak| *peak < 1e-6), "{pressed:?}");
}

/// A voice on a path goes on along it, whatever number that has in the new plan, and one that its nodes move goes on as well; where no
/// voice goes along it any more, it falls silent.
#[test]
fn what_moves_goes_on() {
    let voice = |name: &str, place: &str, nodes: &str| {
        format!(
            "[voice.{name}]\noutput = \"tone\"\n{place}\n[voice.{name}.nodes]\n\
             tone = {{ type = \"sine\", frequency = 200, amplitude = 0.3 }}\n{nodes}\n"
        )
    };
    let along = "place = { path = [[0, 0], [0.12, 0]], over = 1.0 }";
    let swings =
        "slow = { type = \"lfo\", rate = 0.8 }\nhere = { type = \"place\", x = \"0.06 + 0.05 * slow\" }";
    let ahead = voice("ahead", "place = { path = [[0.12, 0], [0, 0]], over = 1.0 }", "");
    for (place, nodes) in [(along, ""), ("", swings)] {
        let old = compiled(&voice("mover", place, nodes), 4, 48_000.0).plan;
        let more = format!("{ahead}{}", voice("mover", place, nodes));
        let new = compiled(&more, 4, 48_000.0).plan;
        let take = |next: Option<&Plan>| {
            let (mut director, mut stagehand) = exchange(&old).unwrap();
            let play = Play { duration: 10.0, id: 1, ..old.play("mover", &[]).unwrap() };
            schedule(stagehand.engine(), &[(0.0, play)]);
            let mut frames = vec![0.0; 48_000 * 4];
            let (before, after) = frames.split_at_mut(9600 * 4);
            stagehand.process(&[], before);
            if let Some(next) = next {
                assert!(director.send(next).unwrap());
            }
            stagehand.process(&[], after);
            frames
        };
        let (alone, changed) = (take(None), take(Some(&new)));
        // What the change itself does is over soon.
        let apart = |from: usize| {
            alone.iter().zip(&changed).skip(from * 4).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
        };
        assert!(apart(0) < 0.01 && apart(12_000) < 1e-6, "{place}{nodes}: {} {}", apart(0), apart(12_000));
        if !place.is_empty() {
            let gone = take(Some(&compiled(&voice("mover", "", ""), 4, 48_000.0).plan));
            assert!(gone[20_000 * 4..].iter().all(|x| *x == 0.0), "no path is silence");
        }
    }
}

/// Lists of names are counted anew in each patch; a voice, and an event that waits, stay on theirs, and a point stays with the tactors about it.
#[test]
fn what_sounds_together_stays_where_it_was() {
    let voice = |name: &str, place: &str| {
        format!(
            "[voice.{name}]\noutput = \"tone\"\nplace = {place}\n[voice.{name}.nodes]\n\
             tone = {{ type = \"sine\", frequency = 200, amplitude = 0.3 }}\n"
        )
    };
    let old = compiled(&voice("pair", "[\"t3\", \"t4\"]"), 4, 48_000.0).plan;
    let more = format!("{}{}", voice("ahead", "[\"t1\", \"t2\"]"), voice("pair", "[\"t3\", \"t4\"]"));
    let new = compiled(&more, 4, 48_000.0).plan;
    let without = compiled(&voice("pair", "\"t1\""), 4, 48_000.0).plan;
    let place = old.place("t3 + t4").unwrap();
    assert_ne!(place, new.place("t3 + t4").unwrap());
    for (spot, reached) in
        [(place, [false, false, true, true]), (Spot::Point([0.06, 0.0, 0.0]), [false, true, true, false])]
    {
        for (begins, next, kept) in [(0.0, &new, true), (4000.0, &new, true), (0.0, &without, spot != place)]
        {
            let (mut director, mut stagehand) = exchange(&old).unwrap();
            schedule(stagehand.engine(), &[(begins, Play { place: spot, ..play(0, 0, 200.0, 10.0, 1) })]);
            let mut before = vec![0.0; 4800 * 4];
            stagehand.process(&[], &mut before);
            assert!(director.send(next).unwrap());
            let mut after = vec![0.0; 48_000 * 4];
            stagehand.process(&[], &mut after);
            let late = &after[24_000 * 4..];
            let sounds: Vec<bool> =
                (0..4).map(|c| late.iter().skip(c).step_by(4).any(|x| x.abs() > 0.05)).collect();
            assert_eq!(sounds, if kept { reached } else { [false; 4] }, "{spot:?} from {begins}");
        }
    }
}
