//! What a plan that takes over does to voices that sound: none of their steps from frame to frame becomes larger than it would be without.

mod common;

use common::scenes::every;
#[cfg(feature = "fundsp-nodes")]
use common::scenes::leaves;
use common::{compiled, patch, play, schedule};
use pacinian::engine::event::{Event, Play, Source};
use pacinian::engine::exchange::exchange;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::{Asset, Assets};
use pacinian::rig::Rig;
use pacinian::schedule::Instant;
use std::sync::Arc;

/// Stands for any recording.
struct Hum;

impl Assets for Hum {
    fn load(&self, _path: &str, _channel: usize) -> Result<Arc<Asset>, String> {
        let samples = (0..9_600).map(|n| 0.5 * (n as f32 * 0.02).sin()).collect();
        Ok(Arc::new(Asset { samples, rate: 48_000.0 }))
    }
}

/// What changes, and the nodes before and after.
const FIGURES: [(&str, &str, [&str; 2]); 15] = [
    ("a frequency", r#"out = { type = "sine", frequency = #, amplitude = 0.5 }"#, ["100", "200"]),
    ("a frequency, down", r#"out = { type = "sine", frequency = #, amplitude = 0.5 }"#, ["200", "100"]),
    ("a frequency, a little", r#"out = { type = "sine", frequency = #, amplitude = 0.5 }"#, ["250", "260"]),
    ("a frequency, far", r#"out = { type = "sine", frequency = #, amplitude = 0.5 }"#, ["40", "700"]),
    ("a frequency, far down", r#"out = { type = "sine", frequency = #, amplitude = 0.5 }"#, ["700", "40"]),
    ("an amplitude", r#"out = { type = "sine", frequency = 50, amplitude = # }"#, ["0.1", "0.5"]),
    ("an amplitude, down", r#"out = { type = "sine", frequency = 250, amplitude = # }"#, ["0.5", "0.1"]),
    (
        "an amplitude of a high tone",
        r#"out = { type = "sine", frequency = 800, amplitude = # }"#,
        ["0.1", "0.5"],
    ),
    ("a phase", r#"out = { type = "sine", frequency = 250, phase = #, amplitude = 0.5 }"#, ["0", "0.5"]),
    ("a triangle", r#"out = { type = "triangle", frequency = #, amplitude = 0.5 }"#, ["60", "120"]),
    ("a sawtooth", r#"out = { type = "sawtooth", frequency = #, amplitude = 0.5 }"#, ["60", "90"]),
    ("a pulse", r#"out = { type = "pulse", frequency = 80, width = #, amplitude = 0.2 }"#, ["0.5", "0.2"]),
    (
        "a cutoff",
        "tone = { type = \"sine\", frequency = 150, amplitude = 0.5 }\n\
         out = { type = \"lowpass\", input = \"tone\", cutoff = # }",
        ["100", "300"],
    ),
    (
        "an envelope",
        "tone = { type = \"sine\", frequency = 200, amplitude = 0.5 }\n\
         hit = { type = \"envelope\", attack = 0.004, decay = 0.03, sustain = #, release = 0.02 }\n\
         out = { type = \"multiply\", inputs = [\"tone\", \"hit\"] }",
        ["0.9", "0.3"],
    ),
    (
        "a node less",
        "tone = { type = \"sine\", frequency = 200, amplitude = 0.3 }\n\
         more = { type = \"sine\", frequency = 90, amplitude = 0.3 }\nout = { type = \"add\", inputs = [#] }",
        [r#""tone", "more""#, r#""tone""#],
    ),
];

/// Frames of a call, and calls: five eighths of a second.
const CALL: usize = 41;
const CALLS: usize = 730;

fn voice(nodes: &str) -> Plan {
    compiled(&format!("[voice.v]\noutput = \"out\"\n[voice.v.nodes]\n{nodes}\n"), 1, 48_000.0).plan
}

/// Frames of a voice from its onset on, whose plan is followed by another before the n-th call.
fn run(plan: &Plan, then: Option<(usize, &Plan)>) -> Vec<f32> {
    let (mut director, mut stagehand) = exchange(plan).unwrap();
    schedule(stagehand.engine(), &[(0.0, play(0, 0, 50.0, 10.0, 1))]);
    let mut output = vec![0.0; CALL * CALLS];
    for (n, part) in output.chunks_mut(CALL).enumerate() {
        if let Some((at, plan)) = then
            && at == n
        {
            assert!(director.send(plan).unwrap());
        }
        stagehand.process(&[], part);
    }
    output
}

/// The largest step from frame to frame, the first tenth of a second left out.
fn largest_step(frames: &[f32]) -> f32 {
    frames[4_800..].windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f32::max)
}

/// The largest step with a change at one of thirty moments, as a share of the larger of those before and after.
fn worst(old: &Plan, new: &Plan) -> f32 {
    let alone = largest_step(&run(old, None)).max(largest_step(&run(new, None)));
    (200..230).map(|n| largest_step(&run(old, Some((n, new))))).fold(0.0, f32::max) / alone
}

#[test]
fn another_figure_makes_no_larger_step() {
    for (name, nodes, [before, after]) in FIGURES {
        let worst = worst(&voice(&nodes.replace('#', before)), &voice(&nodes.replace('#', after)));
        // What the band limit takes of 800 Hz it does not take of all that goes with the change: a thousandth. And two sawtooths meet.
        assert!(worst <= 1.003, "{name}: a step {worst} times as large");
    }
}

/// What crosses to a plan that computes the same sounds as if nothing had happened: a copy of every node's state is that state.
#[test]
fn a_copy_of_every_node_goes_on_as_the_original() {
    // Room for a voice more makes the instrument another one, and its sound is the same.
    // Softly, so that no limiter hears of it.
    let soft = every(0.1).replace("\"sum\", \"on\"", "\"0.1 * sum\", \"on\"");
    let mut scenes = vec![[12, 13].map(|voices| soft.replace("voices = 12", &format!("voices = {voices}")))];
    scenes.extend(bodies());
    for texts in scenes {
        let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
        let [old, new] = texts.map(|text| {
            scene(&patch(&text), &Rig::default_for(1), &options, &Hum).unwrap_or_else(|p| panic!("{p}")).plan
        });
        let alone = run(&old, None);
        let loudest = alone.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        assert!(loudest > 1e-3, "{loudest}");
        for n in [120, 213, 400] {
            let crossed = run(&old, Some((n, &new)));
            let apart = alone.iter().zip(&crossed).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(apart <= 2e-6 * loudest.max(1.0), "{apart} of {loudest} at call {n}");
        }
    }
}

/// Voices of the units of fundsp, and strings.
#[cfg(feature = "fundsp-nodes")]
fn bodies() -> Option<[String; 2]> {
    Some([12, 13].map(|voices| leaves(voices, 8)))
}

#[cfg(not(feature = "fundsp-nodes"))]
fn bodies() -> Option<[String; 2]> {
    None
}

/// Signals that all voices read go on as well, for what sounds in the old way.
#[test]
fn another_figure_of_a_shared_signal_makes_no_larger_step() {
    let plan = |frequency: u32| {
        let text = format!(
            "[shared.nodes]\nsway = {{ type = \"sine\", frequency = {frequency} }}\n[voice.v]\noutput = \"out\"\n[voice.v.nodes]\n\
             tone = {{ type = \"sine\", frequency = 120, amplitude = 0.5 }}\n\
             out = {{ type = \"multiply\", inputs = [\"tone\", \"sway\"] }}\n"
        );
        compiled(&text, 1, 48_000.0).plan
    };
    let worst = worst(&plan(150), &plan(60));
    assert!(worst <= 1.003, "a step {worst} times as large");
}

/// What is read a sample late goes on from what it was. A figure within the loop is another at once, and that comes round again and again before
/// the new way is all that is heard: two hundredths.
#[test]
fn another_figure_of_a_loop_makes_no_larger_step() {
    let nodes = "tone = { type = \"sine\", frequency = 130, amplitude = 0.2 }\n\
                 out = { type = \"delay\", input = \"tone + # * out\", time = 0.0061, longest = 0.02 }";
    let worst = worst(&voice(&nodes.replace('#', "0.5")), &voice(&nodes.replace('#', "0.7")));
    assert!(worst <= 1.025, "a step {worst} times as large");
}

/// Room for more voices, or for fewer: what sounds goes on, and ends when it should.
#[test]
fn another_number_of_voices_keeps_what_sounds() {
    let plan = |voices: u32, amplitude: f64| {
        let text = format!(
            "[voice.v]\nvoices = {voices}\noutput = \"out\"\n[voice.v.nodes]\n\
             out = {{ type = \"sine\", frequency = 130, amplitude = {amplitude} }}\n"
        );
        compiled(&text, 1, 48_000.0).plan
    };
    for (old, new) in
        [(plan(2, 0.4), plan(40, 0.4)), (plan(40, 0.4), plan(2, 0.4)), (plan(40, 0.2), plan(2, 0.4))]
    {
        assert!(worst(&old, &new) <= 1.003);
        let (mut director, mut stagehand) = exchange(&old).unwrap();
        schedule(stagehand.engine(), &[(0.0, play(0, 0, 50.0, 1.0, 1))]);
        let mut frames = vec![0.0; 2 * 48_000];
        for (n, part) in frames.chunks_mut(96).enumerate() {
            if n == 100 {
                director.send(&new).unwrap();
            }
            stagehand.process(&[], part);
        }
        assert!(
            frames[10_000..47_000].windows(480).all(|part| part.iter().any(|x| x.abs() > 0.19)),
            "it goes on"
        );
        assert!(frames[50_000..].iter().all(|x| x.abs() < 1e-6), "it ends after a second");
        assert_eq!(director.collect(), 0);
    }
}

/// What begins after a plan has taken over is that plan's alone: it is not faded in with what sounded before.
#[test]
fn what_begins_meanwhile_is_not_faded() {
    let text = |amplitude: f64| {
        format!(
            "[voice.v]\noutput = \"out\"\n[voice.v.nodes]\nout = {{ type = \"sine\", frequency = 130, amplitude = {amplitude} }}\n"
        )
    };
    let [old, new] = [0.1, 0.4].map(|amplitude| compiled(&text(amplitude), 2, 48_000.0).plan);
    let take = |first: &Plan, then: Option<&Plan>| {
        let (mut director, mut stagehand) = exchange(first).unwrap();
        // One that sounds on the first channel, and one that begins on the second 5 ms after the change.
        schedule(
            stagehand.engine(),
            &[(0.0, play(0, 0, 50.0, 10.0, 1)), (1_640.3, play(0, 1, 50.0, 10.0, 2))],
        );
        let mut frames = vec![0.0; 2 * 24_000];
        let (before, after) = frames.split_at_mut(2 * 9_600);
        stagehand.process(&[], before);
        if let Some(plan) = then {
            director.send(plan).unwrap();
        }
        stagehand.process(&[], after);
        frames.chunks(2).map(|frame| frame[1]).collect::<Vec<_>>()
    };
    let crossed = take(&old, Some(&new));
    assert!(crossed.iter().any(|x| *x > 0.39));
    assert_eq!(crossed, take(&new, None));
}

/// A voice that is silenced while it crosses is silent in the old engine too, though another sounds.
#[test]
fn what_is_silenced_meanwhile_is_silent() {
    let text = |amplitude: f64| {
        format!(
            "[voice.v]\noutput = \"out\"\n[voice.v.nodes]\nout = {{ type = \"sine\", frequency = 130, amplitude = {amplitude} }}\n"
        )
    };
    let [old, new] = [0.4, 0.3].map(|amplitude| compiled(&text(amplitude), 2, 48_000.0).plan);
    for bits in [0, 64] {
        let (mut director, mut stagehand) = exchange(&old).unwrap();
        schedule(stagehand.engine(), &[(0.0, play(0, 0, 50.0, 10.0, 1)), (0.0, play(0, 1, 50.0, 10.0, 2))]);
        let mut frames = vec![0.0; 2 * 9_600];
        stagehand.process(&[], &mut frames);
        director.send(&new).unwrap();
        stagehand.process(&[], &mut frames[..2 * 96]);
        let now = Instant { sample: stagehand.engine().clock(), fraction: 0 };
        assert!(stagehand.engine().schedule(now, Source::Program, Event::Silence(1, bits)));
        // Within 5 ms, and what the band limit still holds.
        stagehand.process(&[], &mut frames[..2 * 480]);
        stagehand.process(&[], &mut frames[..2 * 480]);
        let loudest = |channel| {
            frames[..2 * 480].iter().skip(channel).step_by(2).fold(0.0_f32, |most, x| most.max(x.abs()))
        };
        assert!(loudest(0) < 1e-3, "{bits}: {}", loudest(0));
        assert_eq!(loudest(1) > 0.2, bits == 0, "{bits}: {}", loudest(1));
    }
}

/// Plans that follow one another as fast as they may, each with another figure, while voices come and go.
#[test]
fn a_hundred_changes_make_no_larger_step() {
    let plans = [100, 130, 190, 230]
        .map(|hertz| voice(&format!("out = {{ type = \"sine\", frequency = {hertz}, amplitude = 0.5 }}")));
    let alone = plans.iter().map(|plan| largest_step(&run(plan, None))).fold(0.0, f32::max);
    let (mut director, mut stagehand) = exchange(&plans[0]).unwrap();
    schedule(stagehand.engine(), &[(0.0, Play { duration: 1e6, ..play(0, 0, 50.0, 1.0, 1) })]);
    let (mut sent, mut frames) = (0, Vec::new());
    while sent < 100 {
        sent += usize::from(director.send(&plans[(sent + 1) % 4]).unwrap());
        let begin = frames.len();
        frames.resize(begin + 97, 0.0);
        stagehand.process(&[], &mut frames[begin..]);
    }
    let step = largest_step(&frames);
    assert!(step <= 1.003 * alone, "{step} and {alone}");
    assert!(frames[4_800..].windows(960).all(|part| part.iter().any(|x| x.abs() > 0.2)), "it has no gap");
}

/// Any of the patches that come with this may follow any other at any moment: what leaves stays a number within full scale, and no engine stays
/// behind.
#[cfg(feature = "io")]
#[test]
fn any_patch_follows_any_other() {
    let options = Options { rate: Some(48_000.0), live: true, ..Options::default() };
    let mut paths: Vec<_> =
        std::fs::read_dir("patches").unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let mut plans = Vec::new();
    for path in paths.iter().filter(|path| path.extension().is_some_and(|end| end == "toml")) {
        let Ok(patch) = pacinian::io::load::patch(path) else { continue };
        // Those that need a rig of their own are left to it.
        if let Ok(scene) = scene(&patch.value, &Rig::default_for(8), &options, &Hum) {
            plans.push(scene.plan);
        }
    }
    assert!(plans.len() > 15, "{}", plans.len());
    let (mut director, mut stagehand) = exchange(&plans[0]).unwrap();
    let (mut at, mut sent, mut refused, mut frames) = (0, 0_u32, 0_u32, vec![0.0; 8 * 173]);
    for n in 0..6_000_u32 {
        if n % 17 == 3 {
            // A walk that comes by every pair sooner or later.
            let next = (at + 1 + (n as usize / 17) % 17) % plans.len();
            match director.send(&plans[next]) {
                Ok(true) => (at, sent) = (next, sent + 1),
                Ok(false) => {}
                Err(_) => {
                    refused += 1;
                    (director, stagehand) = exchange(&plans[next]).unwrap();
                    at = next;
                }
            }
        }
        let voices = plans[at].instruments.len() as u32;
        for k in 0..n % 3 {
            let now = Instant { sample: stagehand.engine().clock() + u64::from(k), fraction: 99 };
            let play = play((n + k) % voices.max(1), n % 8, f64::from(40 + n % 300), 0.05, u64::from(n));
            stagehand.engine().schedule(now, Source::Program, Event::Play(play));
        }
        stagehand.process(&[], &mut frames);
        assert!(frames.iter().all(|x| x.abs() <= 1.0), "after plan {at}, {sent} sent");
    }
    assert!(sent > 300, "{sent} sent, {refused} refused");
    for _ in 0..200 {
        stagehand.process(&[], &mut frames);
    }
    assert_eq!(director.collect(), 0, "an engine stays behind");
}

/// So many voices with delays of `longest` seconds, that all hear a shared one; and, with `more`, another shared signal, that no voice which is played hears.
fn echoes(longest: f64, voices: u32, more: bool) -> Plan {
    let [signal, voice] = match more {
        true => [
            "sway = { type = \"sine\", frequency = 3 }",
            "[voice.w]\noutput = \"out\"\n[voice.w.nodes]\nout = { type = \"sine\", frequency = \"20 + sway\" }",
        ],
        false => [""; 2],
    };
    let text = format!(
        "[shared.nodes]\nslow = {{ type = \"sine\", frequency = 37, amplitude = 0.3 }}\n{signal}\n\
         late = {{ type = \"delay\", input = \"slow\", time = 0.31, longest = {longest} }}\n\
         [voice.v]\nvoices = {voices}\noutput = \"out\"\n[voice.v.nodes]\n\
         tone = {{ type = \"sine\", frequency = \"event.frequency\", amplitude = 0.02 }}\n\
         once = {{ type = \"delay\", input = \"tone\", time = 0.173, longest = {longest} }}\n\
         again = {{ type = \"delay\", input = \"once + late * tone\", time = 0.0203, longest = {longest} }}\n\
         hit = {{ type = \"envelope\", attack = 0.004, decay = 0.3, sustain = 0.7, release = 0.3 }}\n\
         out = {{ type = \"multiply\", inputs = [\"hit\", \"tone + once + again\"] }}\n{voice}\n"
    );
    compiled(&text, 2, 48_000.0).plan
}

/// Frames, in calls of `call`, of voices of which so many begin every 0.4 s and are held for 1.1 s, whose plan is followed by another after so many
/// seconds; and how many calls that was under way before it could take over.
fn coming_and_going(plan: &Plan, voices: u32, call: usize, then: Option<(f64, &Plan)>) -> (Vec<f32>, usize) {
    let (mut director, mut stagehand) = exchange(plan).unwrap();
    let events: Vec<_> = (0..6 * voices)
        .map(|n| {
            let at = 3_200.3 * f64::from(n / voices) + 0.7 * f64::from(n % voices);
            (at, play(0, n % 2, f64::from(50 + n % 37), 1.1, u64::from(n)))
        })
        .collect();
    schedule(stagehand.engine(), &events);
    let mut frames = vec![0.0; 2 * 120_000];
    let (mut sent, mut waited) = (false, 0);
    for (n, part) in frames.chunks_mut(2 * call).enumerate() {
        if let Some((at, plan)) = then
            && !sent
            && (n * call) as f64 >= at * 48_000.0
        {
            sent = true;
            assert!(director.send(plan).unwrap());
        }
        waited += usize::from(sent && !director.is_ready());
        stagehand.process(&[], part);
    }
    assert_eq!((sent, director.collect()), (then.is_some(), 0));
    (frames, waited)
}

/// However long delays are: what they remember is copied ahead, a little in each call, and then all goes on as if nothing had happened.
#[test]
fn delays_of_any_length_go_on_as_the_original() {
    for (longest, voices) in [(0.1, 4), (2.0, 32), (60.0, 20)] {
        let [old, new] = [false, true].map(|more| echoes(longest, voices, more));
        let (alone, _) = coming_and_going(&old, voices / 2, 96, None);
        assert!(alone.iter().any(|x| x.abs() > 0.02));
        // Half of the voices make room for others every 0.4 s; the last three times while the past of some is being copied.
        let late = if longest > 1.0 { &[(0.79, 96), (1.59, 64), (1.59, 17)][..] } else { &[] };
        for &(at, call) in [(0.45_f64, 64), (0.85, 96), (1.65, 1_000), (1.25, 17)].iter().chain(late) {
            let (crossed, waited) = coming_and_going(&old, voices / 2, call, Some((at, &new)));
            let apart = alone.iter().zip(&crossed).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(apart <= 2e-6, "{apart}: delays of {longest} s, at {at} s, calls of {call}");
            assert_eq!(
                waited > 0,
                longest > 1.0,
                "{waited} calls: delays of {longest} s, at {at} s, calls of {call}"
            );
            // 4 KiB with each engine sample, of the shared delay and of two of each of some more voices than there is room for.
            let most = 8_000.0 * at.min(longest) * 4.0 * (2.5 * f64::from(voices) + 1.0);
            let most = most / (4096.0 * f64::from(call as u32) / 6.0) + 3.0;
            assert!((waited as f64) <= most, "{waited} calls of {call}, {most}");
        }
    }
}
