//! A knob in the engine: on its clock, read by nodes, moved by the patch, setting off voices.

use pacinian::engine::Engine;
use pacinian::engine::event::{Event, Source};
use pacinian::engine::exchange::exchange;
use pacinian::graph::knob::CELL;
use pacinian::graph::plan::{Plan, Why};
use pacinian::graph::scene::{Options, scene};
use pacinian::graph::watch::LATENCY;
use pacinian::knob::local_model::model::{Contact, LocalModel};
use pacinian::knob::local_model::pending::Message;
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;

const RIG: &str = "format = \"pacinian-rig/1\"\n[device]\nchannels = 3\nrate = 48000\n\
    [[tactor]]\nname = \"a\"\nchannel = 1\n[[tactor]]\nname = \"b\"\nchannel = 2\n\
    [[output]]\nkind = \"torque\"\nname = \"knob\"\nchannel = 3\n";

const KNOB: &str = "[knob]\ninertia = 1e-5\npeak_torque = 0.1\n";

fn plan(text: &str) -> Plan {
    compiled(text, false)
}

fn compiled(text: &str, live: bool) -> Plan {
    let text = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{text}");
    let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let rig = Rig::parse("r", RIG.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    scene(&patch, &rig, &Options { live, ..Options::default() }, &NoAssets)
        .unwrap_or_else(|p| panic!("{p}"))
        .plan
}

const NOTCHES: &str = r#"
[control.strength]
default = 1.0
smoothing = 0
[knob.effects]
notches = { type = "detents", count = 24, torque = 0.01, gain = "strength" }
ends = { type = "end-stops", low = -1.5, high = 1.5, stiffness = 0.2 }
grain = { type = "texture", torque = 0.004, signal = "voices" }
[voice.click]
voices = 8
output = "o"
place = "a"
defaults = { sharp = 0 }
nodes.o = { type = "sine", frequency = "200 + 10 * event.sharp", amplitude = "decay" }
nodes.decay = { type = "envelope", attack = 0.001, decay = 0.01, sustain = 0 }
[voice.hum]
output = "o"
place = "b"
start = "always"
nodes.o = { type = "sine", frequency = 150, amplitude = "0.2 * min(1, abs(knob.speed) / 10) + 0.05 * knob.angle" }
[voice.rub]
output = "o"
place = "knob"
start = "always"
nodes.o = { type = "sine", frequency = 90, amplitude = 0.5 }
[[trigger]]
on = "knob.detent"
play = "click"
set = { level = "min(1, speed / 10)", sharp = "index" }
[[trigger]]
on = "knob.wall ends"
play = "click"
set = { level = "clamp(speed / 20, 0.1, 1)", duration = 0.05 }
place = "b"
"#;

/// Seconds and angles of a hand that turns to and fro.
const TURNS: [(f64, f64); 4] = [(0.4, 1.0), (0.8, -0.7), (1.3, 2.0), (1.8, 0.0)];

/// All frames of two seconds with a hand that turns, in calls of these lengths, again and again.
fn turned(plan: &Plan, lengths: &[usize]) -> (Vec<f32>, Engine) {
    told(plan, &[], lengths)
}

/// The same, while the engine is told these at these samples.
fn told(plan: &Plan, events: &[(f64, Event)], lengths: &[usize]) -> (Vec<f32>, Engine) {
    let mut engine = Engine::new(plan).unwrap();
    let hand = plan.control("hand").unwrap();
    let mut begin = 0.05;
    for (end, angle) in TURNS {
        let at = Instant { sample: (begin * plan.engine_rate()) as u64, fraction: 0 };
        assert!(engine.schedule(at, Source::Program, Event::Glide(hand, angle, end - begin)));
        begin = end;
    }
    for (sample, event) in events {
        assert!(engine.schedule(Instant::of_samples(*sample), Source::Program, *event));
    }
    let mut out = vec![0.0; 3 * 96_000];
    let (mut rest, mut n) = (out.as_mut_slice(), 0);
    while !rest.is_empty() {
        let length = (3 * lengths[n % lengths.len()]).min(rest.len());
        let (now, later) = rest.split_at_mut(length);
        engine.process(now);
        (rest, n) = (later, n + 1);
    }
    (out, engine)
}

fn channel(frames: &[f32], channel: usize) -> Vec<f32> {
    frames.chunks_exact(3).map(|frame| frame[channel]).collect()
}

fn peak(samples: &[f32]) -> f32 {
    samples.iter().fold(0.0, |peak, x| peak.max(x.abs()))
}

#[test]
fn a_knob_is_the_same_however_a_run_is_cut_into_calls() {
    let plan = plan(NOTCHES);
    let (whole, engine) = turned(&plan, &[96_000]);
    let strongest = channel(&whole, 2).iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    // Notches alone come to 0.07, of a peak of 0.15 N m; a stop pushes back harder.
    assert!(strongest > 0.2, "{strongest}");
    assert!(engine.counters().started > 20 && engine.counters().dropped == 0, "{:?}", engine.counters());
    assert!((0..3).all(|c| peak(&channel(&whole, c)) > 0.01));
    for lengths in [&[1][..], &[5], &[16], &[64], &[7, 480, 1, 33], &[512]] {
        let (cut, _) = turned(&plan, lengths);
        let same = whole.iter().zip(&cut).position(|(a, b)| a.to_bits() != b.to_bits());
        assert_eq!(same, None, "{lengths:?}");
    }
}

/// Also where it is told something in the middle of a cell, ahead of which it has run by as much as the call is long.
#[test]
fn what_a_knob_is_told_holds_from_the_same_sample_however_a_run_is_cut() {
    let plan = plan(NOTCHES);
    let begin = 1600.0;
    for first in 0..CELL {
        let at = |n: usize| begin + first as f64 + 450.3 * n as f64;
        let tells = [
            Event::Arm(false),
            Event::Push(0.02),
            Event::Arm(true),
            Event::Push(-0.01),
            Event::Deadline(false),
            Event::Silence(0, 64),
            Event::Deadline(true),
            Event::Arm(true),
        ];
        let events: Vec<_> = tells.into_iter().enumerate().map(|(n, event)| (at(n), event)).collect();
        let (whole, engine) = told(&plan, &events, &[96_000]);
        assert!(engine.knob().unwrap().servo().chain().armed() && engine.counters().dropped == 0);
        assert!(whole != turned(&plan, &[96_000]).0, "they change something");
        for lengths in [&[1][..], &[5], &[64], &[7, 480, 1, 33], &[100]] {
            let (cut, _) = told(&plan, &events, lengths);
            let same = whole.iter().zip(&cut).position(|(a, b)| a.to_bits() != b.to_bits());
            assert_eq!(same, None, "{first} {lengths:?}");
        }
    }
}

/// What is heard of notches: as many as were passed, each with the number that it has.
#[test]
fn a_click_begins_at_the_tick_that_passes_the_notch() {
    let plan = plan(NOTCHES);
    let mut engine = Engine::new(&plan).unwrap();
    let hand = plan.control("hand").unwrap();
    engine.schedule(Instant::default(), Source::Program, Event::Glide(hand, 1.2, 1.0));
    let (mut frame, mut index, mut heard) = ([0.0; 18], 0.0, 0);
    for sample in 0..12_000_u64 {
        engine.process(&mut frame);
        // The knob runs ahead of what it is asked for by no more than the sample that was computed.
        let knob = engine.knob().unwrap();
        let now = knob.servo().ticks();
        assert_eq!(now, sample + 1, "a tick a sample, and none too early");
        for crossing in engine.crossings() {
            assert_eq!(crossing.at, Instant { sample, fraction: 0 });
            let own = crossing.play().unwrap().own;
            assert_eq!(own.iter().filter(|x| **x == index + 1.0).count(), 1, "{own:?}");
            index += 1.0;
            heard += 1;
        }
        let angle = engine.knob().unwrap().last().angle;
        // Crests lie between notches, and are passed with a hysteresis of a twentieth.
        let pitch = std::f64::consts::TAU / 24.0;
        assert!(angle < (index + 0.55) * pitch + 1e-9 && angle > (index - 0.55) * pitch, "{sample} {angle}");
    }
    assert_eq!(heard, 5, "1.2 rad are 4.6 pitches");
}

#[test]
fn nodes_read_the_knob_without_delay_and_the_patch_moves_it_a_cell_later() {
    let text = r#"
[control.pull]
default = 0
range = [-1, 1]
smoothing = 0
[knob.effects]
pull = { type = "constant", torque = 0.01, gain = "pull" }
[voice.v]
output = "o"
place = "a"
start = "always"
nodes.o = { type = "multiply", inputs = ["knob.torque", 50] }
"#;
    let plan = plan(text);
    let mut engine = Engine::new(&plan).unwrap();
    let pull = plan.control("pull").unwrap();
    let at = 2000 + CELL + 1;
    engine.schedule(Instant { sample: at, fraction: 0 }, Source::Program, Event::Control(pull, 1.0));
    let mut frame = [0.0; 18];
    let torques: Vec<f64> = (0..4000)
        .map(|_| {
            engine.process(&mut frame);
            engine.knob().unwrap().last().torque
        })
        .collect();
    let first = torques.iter().position(|t| *t != 0.0).unwrap() as u64;
    // Signals lag behind events by the engine's lead.
    let lead = (engine.delay().lead * plan.engine_rate()).round() as u64;
    assert_eq!(first, at + lead + CELL + 1, "a control goes there within a sample");
    assert_eq!(torques[3999], 0.01);
}

/// `knob.detent` and `knob.wall` are there in the samples at which triggers begin, and in no others.
#[test]
fn nodes_read_what_happens_to_the_knob_when_it_happens() {
    let text = format!(
        "{NOTCHES}
[shared.nodes]
up = {{ type = \"multiply\", inputs = [\"knob.detent\", 1] }}
down = {{ type = \"multiply\", inputs = [\"knob.detent\", -1] }}
hit = {{ type = \"multiply\", inputs = [\"knob.wall\", 1] }}
{}",
        ["up rises 0.5", "down rises 0.5", "hit rises 2", "hit rises 50"]
            .map(|on| format!(
                "[[trigger]]\non = \"node.{on}\"\nplay = \"click\"\nset = {{ duration = 0.01 }}\n"
            ))
            .concat()
    );
    let never =
        text.replace("ends = ", "# ends = ").replace("on = \"knob.wall ends\"", "on = \"knob.detent\"");
    let never =
        Patch::parse("t", format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{never}").as_bytes());
    assert!(never.unwrap_err().to_string().contains("`knob.wall` never happens"));
    let plan = plan(&text);
    let mut engine = Engine::new(&plan).unwrap();
    let hand = plan.control("hand").unwrap();
    for (sample, angle, seconds) in [(0, 2.5, 0.3), (4000, -2.5, 0.8)] {
        let event = Event::Glide(hand, angle, seconds);
        engine.schedule(Instant { sample, fraction: 0 }, Source::Program, event);
    }
    let mut frame = [0.0; 18];
    let watches = plan.watches.len() + plan.knob.as_ref().unwrap().starts.len();
    let mut at: Vec<Vec<u64>> = vec![Vec::new(); watches];
    for _ in 0..16_000 {
        engine.process(&mut frame);
        for crossing in engine.crossings() {
            at[crossing.watch as usize].push(crossing.at.sample);
        }
    }
    let samples = |of: &[u64], late: u64| of.iter().map(|sample| sample + late).collect::<Vec<_>>();
    let [up, down, hit, never, detent, wall] = &at[..] else { panic!("{watches}") };
    assert!(up.len() > 4 && down.len() > 8 && wall.len() == 2 && never.is_empty(), "{at:?}");
    let mut both = [&up[..], down].concat();
    both.sort_unstable();
    // What nodes set off is as late as the engine says, and always as late.
    let late = both[0] - detent[0];
    assert!(late < LATENCY, "{late}");
    assert_eq!(both, samples(detent, late));
    assert_eq!(*hit, samples(wall, late));
}

/// A patch that takes over and says the same of the knob changes no bit of it; one that says something else goes on from where it is.
#[test]
fn a_knob_goes_on_behind_a_patch_that_takes_over() {
    let of = |more: &str, stiffness: f64| {
        plan(&format!("[knob.effects]\ns = {{ type = \"spring\", stiffness = {stiffness} }}\n{more}"))
    };
    let sound = "[voice.v]\noutput = \"o\"\nplace = \"a\"\nnodes.o = { type = \"sine\", frequency = 100 }\n";
    let first = of("", 0.08);
    let run = |next: Option<&Plan>| {
        let (mut director, mut stagehand) = exchange(&first).unwrap();
        let hand = first.control("hand").unwrap();
        stagehand.engine().schedule(Instant::default(), Source::Program, Event::Glide(hand, 0.25, 0.1));
        let mut frames = [0.0; 3 * 48];
        let turn = |n: usize| {
            if let Some(next) = next.filter(|_| n == 500) {
                assert!(director.send(next).unwrap());
            }
            stagehand.process(&[], &mut frames);
            director.collect();
            let knob = stagehand.engine().knob().unwrap();
            assert_eq!(knob.servo().chain().trip(), None, "{n}");
            knob.last().torque.to_bits()
        };
        (0..1500).map(turn).collect::<Vec<_>>()
    };
    let plain = run(None);
    let end = |torques: &[u64]| f64::from_bits(torques[torques.len() - 1]);
    // The hand holds with 0.3 N m/rad at 0.25 rad.
    let held = |stiffness: f64| -0.25 * stiffness * 0.3 / (stiffness + 0.3);
    assert!((end(&plain) - held(0.08)).abs() < 5e-4, "{}", end(&plain));
    assert_eq!(run(Some(&of(sound, 0.08))), plain);
    let softer = end(&run(Some(&of(sound, 0.04))));
    assert!((softer - held(0.04)).abs() < 5e-4, "{softer}");
}

#[test]
fn what_voices_play_on_the_knob_is_felt_as_its_texture() {
    let plan = plan(NOTCHES);
    let mut engine = Engine::new(&plan).unwrap();
    let mut frame = [0.0; 18];
    let torques: Vec<f64> = (0..16_000)
        .map(|_| {
            engine.process(&mut frame);
            engine.knob().unwrap().servo().last().asked
        })
        .collect();
    // 4 mN m times 0.5 at 90 Hz, on top of a notch at rest.
    let tail = &torques[8000..];
    let (s, c) = tail.iter().enumerate().fold((0.0, 0.0), |(s, c), (n, torque)| {
        let phase = std::f64::consts::TAU * 90.0 * n as f64 / 8000.0;
        (s + torque * phase.sin(), c + torque * phase.cos())
    });
    let amplitude = 2.0 * f64::hypot(s, c) / 8000.0;
    assert!((amplitude - 2e-3).abs() < 2e-4, "{amplitude}");
}

#[test]
fn a_wall_sets_off_as_hard_as_it_is_hit_and_where_it_is_told() {
    let plan = plan(NOTCHES);
    let starts = &plan.knob.as_ref().unwrap().starts;
    assert_eq!(starts.iter().map(|s| &*s.name).collect::<Vec<_>>(), ["knob.detent", "knob.wall ends"]);
    let mut engine = Engine::new(&plan).unwrap();
    let hand = plan.control("hand").unwrap();
    engine.schedule(Instant::default(), Source::Program, Event::Glide(hand, 3.0, 0.3));
    let mut frames = vec![0.0; 3 * 24_000];
    engine.process(&mut frames);
    let walls: Vec<_> = engine.crossings().filter(|c| c.watch as usize == 1).collect();
    let wall = walls[0].play().unwrap();
    assert_eq!(wall.duration, 0.05);
    // The hand goes with 10 rad/s, and the knob about as fast.
    assert!(wall.level > 0.3 && wall.level < 0.7, "{}", wall.level);
    assert!(engine.knob().unwrap().simulated().unwrap().plant().angle() > 1.5);
}

#[test]
fn a_hand_that_pushes_and_one_that_is_no_number() {
    let plan = plan("[knob.effects]\ns = { type = \"spring\", stiffness = 0.1 }\n");
    let mut engine = Engine::new(&plan).unwrap();
    let mut frames = vec![0.0; 3 * 48_000];
    engine.schedule(Instant::default(), Source::Program, Event::Push(0.02));
    engine.process(&mut frames);
    // The spring and the hand's grasp, 0.1 and 0.3 N m/rad, less what friction keeps.
    let angle = engine.knob().unwrap().simulated().unwrap().plant().angle();
    assert!((angle - 0.05).abs() < 0.004, "{angle}");
    for push in [f64::NAN, f64::INFINITY] {
        engine.schedule(Instant { sample: engine.clock(), fraction: 0 }, Source::Program, Event::Push(push));
        engine.process(&mut frames);
        let angle = engine.knob().unwrap().simulated().unwrap().plant().angle();
        assert!(angle.abs() < 0.004, "{angle}");
    }
}

#[test]
fn torque_waits_to_be_asked_after_silence_and_can_be_let_go() {
    let plan = plan("[knob.effects]\nc = { type = \"constant\", torque = 0.01 }\n");
    let mut engine = Engine::new(&plan).unwrap();
    let mut frames = vec![0.0; 3 * 24_000];
    let mut last = |engine: &mut Engine, event: Option<Event>| {
        let now = Instant { sample: engine.clock(), fraction: 0 };
        event.into_iter().for_each(|event| assert!(engine.schedule(now, Source::Program, event)));
        engine.process(&mut frames);
        (engine.knob().unwrap().last().torque, frames[3 * 6 * CELL as usize + 2], frames[3 * 23_999 + 2])
    };
    // A third of a second of soft start.
    let (torque, _, sample) = last(&mut engine, None);
    assert!(torque == 0.01 && sample > 0.0, "{torque} {sample}");
    assert_eq!(last(&mut engine, Some(Event::Silence(0, 64))), (0.0, 0.0, 0.0));
    assert_eq!(last(&mut engine, None), (0.0, 0.0, 0.0));
    assert_eq!(last(&mut engine, Some(Event::Arm(true))).0, 0.01);
    assert_eq!(last(&mut engine, Some(Event::Arm(false))), (0.0, 0.0, 0.0));
}

/// A slow thread that looks 30 times a second makes a wall where there is none in the patch.
#[test]
fn a_slow_thread_sends_a_wall_that_is_felt_at_every_tick() {
    let plan = plan("[knob.effects]\nf = { type = \"constant\", torque = 0 }\n");
    let mut engine = Engine::new(&plan).unwrap();
    let mut slow = engine.link_knob().unwrap();
    let hand = plan.control("hand").unwrap();
    engine.schedule(Instant { sample: 4000, fraction: 0 }, Source::Program, Event::Glide(hand, 1.0, 0.5));
    let mut frames = vec![0.0; 3 * 1602];
    let mut seen = Vec::new();
    for _ in 0..60 {
        let look = slow.look();
        seen.push(look);
        let contact = Contact { angle: 0.5, below: false, stiffness: 0.2 };
        let range = (look.angle - 1.0, look.angle + 1.0);
        let model = LocalModel { stamp: look.tick, contact: Some(contact), range, ..LocalModel::FREE };
        assert!(slow.send(Message::new(model, 0.0)), "there is always room");
        engine.process(&mut frames);
    }
    assert!(seen.windows(2).all(|w| w[0].tick + 267 == w[1].tick || w[0].tick == 0), "{seen:?}");
    let angle = engine.knob().unwrap().simulated().unwrap().plant().angle();
    // The hand holds with 0.3 N m/rad at 1 rad, the wall with 0.2 beyond 0.5: they meet at 0.8, but for friction.
    assert!((angle - 0.8).abs() < 0.003, "{angle}");
    assert!((seen.last().unwrap().torque + 0.06).abs() < 0.001, "{:?}", seen.last());
    assert!(plan_without_knob().link_knob().is_none());
}

fn plan_without_knob() -> Engine {
    let voice =
        "[voice.v]\noutput = \"o\"\nstart = \"always\"\nnodes.o = { type = \"sine\", frequency = 100 }\n";
    Engine::new(&plan(voice)).unwrap()
}

/// What hangs on the card would be driven by what a knob feels that is not there.
#[test]
fn torque_of_a_simulated_knob_leaves_no_card_and_what_is_played_on_it_vibrates_nothing() {
    let (mut live, mut file) =
        (Engine::new(&compiled(NOTCHES, true)).unwrap(), Engine::new(&plan(NOTCHES)).unwrap());
    let (mut sent, mut written) = (vec![1.0; 3 * 24_000], vec![1.0; 3 * 24_000]);
    live.process(&mut sent);
    file.process(&mut written);
    assert!(channel(&sent, 2).iter().all(|x| *x == 0.0));
    assert_eq!(live.knob().unwrap().last(), file.knob().unwrap().last());
    let asked: Vec<f32> = channel(&written, 2);
    // 90 Hz of the texture alone, at 2 mN m of 150: none of its 0.5 as vibration.
    assert!(peak(&asked) > 0.01 && peak(&asked) < 0.02, "{}", peak(&asked));
}

#[test]
fn a_scene_without_a_knob_has_nothing_of_one() {
    let voice =
        "[voice.v]\noutput = \"o\"\nstart = \"always\"\nnodes.o = { type = \"sine\", frequency = 100 }\n";
    let plan = plan(voice);
    let (before, _) = RIG.split_once("[[output]]").unwrap();
    let text = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{voice}");
    let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let of = |rig: &str| {
        let rig = Rig::parse("r", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        scene(&patch, &rig, &Options::default(), &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
    };
    let ops = |plan: &Plan| {
        let voices = plan.instruments.iter().map(|instrument| instrument.program.ops.len()).sum::<usize>();
        (voices, plan.shared_program.ops.len())
    };
    assert_eq!(ops(&of(&format!("{RIG}{KNOB}"))), ops(&of(before)), "the knob of the rig costs no operation");
    assert!(plan.knob.is_none() && plan.shared.is_empty() && plan.controls.is_empty());
    assert!(plan.left_out.iter().any(|l| l.why == Why::NoKnob && l.what == "output `knob`"));
    let mut engine = Engine::new(&plan).unwrap();
    let mut frames = vec![1.0; 3 * 960];
    engine.process(&mut frames);
    assert!(engine.knob().is_none() && channel(&frames, 2).iter().all(|x| *x == 0.0));
}

/// The threads of a program that plays a patch without a knob, by their names, on a rig with one and on one without.
#[cfg(all(target_os = "linux", feature = "cli"))]
#[test]
fn a_session_without_a_knob_has_no_thread_of_one() {
    let folder = std::env::temp_dir().join(format!("pacinian-turned-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let voice =
        "[voice.v]\noutput = \"o\"\nstart = \"always\"\nnodes.o = { type = \"sine\", frequency = 100 }\n";
    std::fs::write(folder.join("p.toml"), format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{voice}"))
        .unwrap();
    let threads = |rig: &str| {
        std::fs::write(folder.join("r.toml"), rig).unwrap();
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_pacinian"));
        command.args(["play", "p.toml", "--rig", "r.toml", "--device", "virtual", "--duration", "30"]);
        command.stdout(std::process::Stdio::null()).stderr(std::process::Stdio::null());
        let mut child = command.current_dir(&folder).spawn().unwrap();
        let names = || -> Vec<String> {
            let tasks =
                std::fs::read_dir(format!("/proc/{}/task", child.id())).into_iter().flatten().flatten();
            let mut names: Vec<String> =
                tasks.filter_map(|task| std::fs::read_to_string(task.path().join("comm")).ok()).collect();
            names.sort();
            names
        };
        let begin = std::time::Instant::now();
        while !names().iter().any(|name| name.starts_with("virtual card")) {
            assert!(begin.elapsed().as_secs() < 20, "it does not play: {:?}", names());
            std::thread::sleep(std::time::Duration::from_millis(20));
        }
        std::thread::sleep(std::time::Duration::from_millis(500));
        let found = names();
        child.kill().unwrap();
        child.wait().unwrap();
        found
    };
    let (before, _) = RIG.split_once("[[output]]").unwrap();
    let with = threads(&format!("{RIG}{KNOB}"));
    let without = threads(before);
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(with.len() > 2, "{with:?}");
    assert_eq!(with, without);
}
