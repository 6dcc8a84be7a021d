//! Rigs that follow one another while they sound: other tactors, equalisers, amplifiers, motors and markers.

mod common;

use common::{patch, play};
use pacinian::engine::event::{Event, Source};
use pacinian::engine::exchange::exchange;
use pacinian::engine::handover::Mismatch;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use pacinian::schedule::Instant;

const RATE: f64 = 48_000.0;
const CHANNELS: usize = 10;

const PATCH: &str = r#"
[voice.tone]
voices = 12
output = "o"
[voice.tone.nodes]
t = { type = "sine", frequency = "event.frequency", amplitude = 0.6 }
e = { type = "envelope", attack = 0.01, release = 0.01 }
o = { type = "multiply", inputs = ["t", "e"] }
[voice.turn]
output = "o"
[voice.turn.nodes]
e = { type = "envelope", attack = 0.02, release = 0.02 }
o = { type = "multiply", inputs = ["e", "event.level"] }
"#;
const TURN: u32 = 1;

/// Ten channels: four tactors, a raw output, a motor and two triggers.
struct Bench {
    tactors: Vec<(&'static str, u32, &'static str)>,
    device: &'static str,
    gain: f64,
    motor: &'static str,
    triggers: &'static str,
}

impl Bench {
    fn new() -> Self {
        Self {
            tactors: vec![("a", 1, ""), ("b", 2, ""), ("c", 3, ""), ("d", 9, "")],
            device: "channels = 10",
            gain: 1.0,
            motor: "resistance = 30.0",
            triggers: "[[output]]\nkind = \"trigger\"\nname = \"go\"\nchannel = 6\nmarker = \"go\"\n",
        }
    }

    fn rig(&self) -> Rig {
        let tactor = |(name, channel, more): &(&str, u32, &str)| {
            format!("[[tactor]]\nname = \"{name}\"\nchannel = {channel}\n{more}\n")
        };
        let text = format!(
            "format = \"pacinian-rig/1\"\n[device]\n{}\nfull_scale_volts = 5.0\ncoupling = \"dc\"\n\
             [actuator.even]\nequaliser = [{{ frequency = 150, gain_db = -9, q = 1.0 }}]\n\
             [amplifier.dc]\ncoupling = \"dc\"\ngain = {}\nmax_volts = 9.0\n\
             [actuator.coin]\nmodel = \"rumble-motor\"\nrated_volts = 3.0\n{}\ninductance = 0.0\n\
             torque_constant = 0.955e-3\ninertia = 1.8e-9\nviscous_friction = 2.15e-8\ncoulomb_friction = 1.5e-5\n\
             static_friction = 2e-5\neccentric_moment = 7.3e-7\nmass = 0.1\n\
             max_heating = 30\nwinding_to_housing = 137\nhousing_to_air = 594\nwinding_time = 1.0\nhousing_time = 4.0\n\
             {}[[output]]\nkind = \"raw\"\nname = \"r\"\nchannel = 4\n\
             [[output]]\nkind = \"drive\"\nname = \"m\"\nchannel = 5\nactuator = \"coin\"\namplifier = \"dc\"\n{}",
            self.device,
            self.gain,
            self.motor,
            self.tactors.iter().map(tactor).collect::<String>(),
            self.triggers,
        );
        Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
    }

    fn plan(&self) -> Plan {
        let options = Options { rate: Some(RATE), live: true, ..Options::default() };
        scene(&patch(PATCH), &self.rig(), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
    }
}

fn place(plan: &Plan, name: &str) -> u32 {
    plan.outputs.iter().position(|output| &*output.name == name).unwrap() as u32
}

/// What sounds from the beginning on: a tone on every tactor and the raw output, and the motor turned.
fn events(plan: &Plan) -> Vec<Event> {
    let tones = ["a", "b", "c", "d", "r"].into_iter().enumerate();
    let tones = tones
        .map(|(n, name)| Event::Play(play(0, place(plan, name), 60.0 + 45.0 * n as f64, 60.0, n as u64 + 1)));
    let mut turn = play(TURN, place(plan, "m"), 0.0, 60.0, 99);
    turn.level = 0.5;
    tones.chain([Event::Play(turn)]).collect()
}

/// Frames in calls of these lengths, one after the other and again; at `at` (frames, a sum of those) the other plan is sent.
fn run(first: &Plan, other: Option<&Plan>, at: usize, frames: usize, calls: &[usize]) -> Vec<Vec<f32>> {
    let (mut director, mut stagehand) = exchange(first).unwrap();
    for event in events(first) {
        assert!(stagehand.engine().schedule(Instant::default(), Source::Program, event));
    }
    let (mut output, mut done) = (vec![0.0; frames * CHANNELS], 0);
    for call in calls.iter().cycle() {
        if done == at
            && let Some(other) = other
        {
            assert_eq!(director.send(other), Ok(true));
        }
        let until = if done < at { at } else { frames };
        let end = (done + call).min(until);
        stagehand.process(&[], &mut output[done * CHANNELS..end * CHANNELS]);
        done = end;
        if done == frames {
            break;
        }
    }
    assert_eq!(director.collect(), 0, "the old engine has come back");
    (0..CHANNELS).map(|c| output.iter().skip(c).step_by(CHANNELS).copied().collect()).collect()
}

const AT: usize = 24_000;
const LENGTH: usize = 96_000;

fn largest_step(signal: &[f32]) -> f32 {
    signal.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max)
}

fn apart(one: &[f32], other: &[f32]) -> f32 {
    one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn peak(signal: &[f32]) -> f32 {
    signal.iter().fold(0.0, |most, x| most.max(x.abs()))
}

fn same(one: &[f32], other: &[f32]) -> bool {
    one.iter().map(|x| x.to_bits()).eq(other.iter().map(|x| x.to_bits()))
}

const PEAK: &str = "actuator = \"even\"";

/// Other things on one channel, and nothing else: the other channels do not notice, not by a bit, those of the same eight included.
#[test]
fn what_is_as_it_was_goes_on_to_the_bit() {
    let bench = Bench::new();
    let plan = bench.plan();
    let plain = run(&plan, None, AT, LENGTH, &[64]);
    assert!((0..5).chain([8]).all(|c| peak(&plain[c]) > 0.1));
    let mut evened = Bench::new();
    evened.tactors[1].2 = PEAK;
    let mut added = Bench::new();
    added.tactors.push(("e", 10, PEAK));
    let mut let_through = Bench::new();
    let_through.tactors[1].2 = "dc = true";
    let mut other_motor = Bench::new();
    other_motor.motor = "resistance = 25.0";
    let mut other_triggers = Bench::new();
    other_triggers.triggers = "[[output]]\nkind = \"trigger\"\nname = \"all\"\nchannel = 7\n\
         [[output]]\nkind = \"trigger\"\nname = \"go\"\nchannel = 6\nmarker = \"go\"\n";
    let mut renamed = Bench::new();
    renamed.tactors.swap(0, 3);
    for (bench, changed) in [
        (&evened, vec![1]),
        (&added, vec![]),
        (&let_through, vec![1]),
        (&other_motor, vec![4]),
        (&other_triggers, vec![]),
        (&renamed, vec![]),
    ] {
        let after = run(&plan, Some(&bench.plan()), AT, LENGTH, &[64]);
        for (c, (before, after)) in plain.iter().zip(&after).enumerate() {
            assert!(same(&before[..AT], &after[..AT]));
            let apart = before.iter().zip(after).position(|(one, other)| one.to_bits() != other.to_bits());
            assert_eq!(
                apart.is_some(),
                changed.contains(&c),
                "channel {}, {apart:?}, changed: {changed:?}",
                c + 1
            );
        }
    }
}

/// A channel that differs goes from one to the other: as loud as the old one before and as the new one after, never a step, never a gap.
#[test]
fn what_differs_crosses_without_a_step_or_a_gap() {
    let plan = Bench::new().plan();
    let plain = run(&plan, None, AT, LENGTH, &[64]);
    for change in [PEAK, "dc = true"] {
        let mut bench = Bench::new();
        bench.tactors[1].2 = change;
        let other = bench.plan();
        let alone = run(&other, None, AT, LENGTH, &[64]);
        let crossed = run(&plan, Some(&other), AT, LENGTH, &[64]);
        let steps = largest_step(&plain[1]).max(largest_step(&alone[1]));
        assert!(
            largest_step(&crossed[1]) <= steps * 1.001,
            "{change}: {} {steps}",
            largest_step(&crossed[1])
        );
        // Of 105 Hz: every period is heard, before, meanwhile and after.
        for period in crossed[1][4800..].chunks_exact(460) {
            assert!(peak(period) > 0.9 * peak(&plain[1]).min(peak(&alone[1])), "{change}");
        }
        let (end, expected) = (&crossed[1][AT + 9600..], &alone[1][AT + 9600..]);
        let apart = apart(end, expected);
        assert!(apart < 2e-4, "{change}: {apart}");
    }
}

/// A tactor that is moved to another channel takes along what sounds on it; on that where it was it is silent, once what rang has died away.
#[test]
fn a_tactor_that_moves_takes_along_what_sounds() {
    let plan = Bench::new().plan();
    let plain = run(&plan, None, AT, LENGTH, &[64]);
    let mut bench = Bench::new();
    bench.tactors[1].1 = 8;
    let moved = run(&plan, Some(&bench.plan()), AT, LENGTH, &[64]);
    let steps = largest_step(&plain[1]) * 1.003;
    assert!(largest_step(&moved[1]) <= steps, "{} {steps}", largest_step(&moved[1]));
    assert!(largest_step(&moved[7]) <= steps, "{} {steps}", largest_step(&moved[7]));
    assert!(peak(&moved[1][AT + 24_000..]) < 1e-5 && peak(&moved[7][..AT]) == 0.0);
    let (end, expected) = (&moved[7][AT + 24_000..], &plain[1][AT + 24_000..]);
    // But for what the other channel's high-pass has still to forget.
    let apart = apart(end, expected);
    assert!(apart < 1e-3, "{apart}");
}

#[test]
fn any_cut_gives_the_same_bits() {
    let plan = Bench::new().plan();
    let mut bench = Bench::new();
    bench.tactors[2].2 = PEAK;
    bench.tactors.push(("e", 10, ""));
    bench.motor = "resistance = 25.0";
    bench.gain = 0.8;
    let other = bench.plan();
    let whole = run(&plan, Some(&other), AT, LENGTH, &[64]);
    for calls in [&[512][..], &[1, 5, 6, 7, 131], &[16]] {
        let cut = run(&plan, Some(&other), AT, LENGTH, calls);
        for (c, (one, other)) in whole.iter().zip(&cut).enumerate() {
            let apart = one.iter().zip(other).position(|(one, other)| one.to_bits() != other.to_bits());
            assert_eq!(apart, None, "{calls:?}, channel {}", c + 1);
        }
    }
}

/// Another motor, or another amplifier before it: the one that turns is driven backward at once and is at rest before the other one is driven,
/// and the winding is not taken for a cold one.
#[test]
fn a_motor_is_braked_before_another_is_driven_and_stays_as_warm() {
    let plan = Bench::new().plan();
    let mut bench = Bench::new();
    bench.motor = "resistance = 25.0";
    let other = bench.plan();
    let (mut director, mut stagehand) = exchange(&plan).unwrap();
    for event in events(&plan) {
        stagehand.engine().schedule(Instant::default(), Source::Program, event);
    }
    let mut frames = vec![0.0; LENGTH * CHANNELS];
    stagehand.process(&[], &mut frames);
    let warm = |stagehand: &mut pacinian::engine::exchange::Stagehand| {
        let stage = stagehand.engine().stage();
        stage.protections().temperature(4).or_else(|| stage.drives().temperature(4)).unwrap()
    };
    let before = warm(&mut stagehand);
    assert!(before > 1.0, "{before}");
    assert_eq!(director.send(&other), Ok(true));
    let mut frames = vec![0.0; LENGTH * CHANNELS];
    stagehand.process(&[], &mut frames[..480 * CHANNELS]);
    let after = warm(&mut stagehand);
    assert!((after / before - 1.0).abs() < 0.05, "{before} K, then {after} K");
    stagehand.process(&[], &mut frames[480 * CHANNELS..]);
    let sent: Vec<f32> = frames.iter().skip(4).step_by(CHANNELS).copied().collect();
    // Played at half of what the motor is rated for.
    let driven = sent[LENGTH - 1];
    assert!(driven > 0.1);
    let rests = sent.iter().position(|x| x.abs() < 1e-6).unwrap();
    let again = rests + sent[rests..].iter().position(|x| x.abs() > 1e-3).unwrap();
    assert!(again - rests > 480, "at rest from {rests} to {again}");
    assert!(sent[..rests].iter().any(|x| *x < 0.0), "nothing brakes");
}

/// What is told to be silent is silent in both stages.
#[test]
fn silence_is_silence_meanwhile() {
    let plan = Bench::new().plan();
    let mut bench = Bench::new();
    (bench.tactors[0].2, bench.tactors[1].2) = (PEAK, "dc = true");
    let (mut director, mut stagehand) = exchange(&plan).unwrap();
    for event in events(&plan).into_iter().take(5) {
        stagehand.engine().schedule(Instant::default(), Source::Program, event);
    }
    let mut frames = vec![0.0; AT * CHANNELS];
    stagehand.process(&[], &mut frames);
    assert_eq!(director.send(&bench.plan()), Ok(true));
    let mut frames = vec![0.0; 480 * CHANNELS];
    stagehand.process(&[], &mut frames[..96 * CHANNELS]);
    let now = Instant { sample: stagehand.engine().clock(), fraction: 0 };
    stagehand.engine().schedule(now, Source::Program, Event::Silence(0, 64));
    stagehand.process(&[], &mut frames[96 * CHANNELS..]);
    let sounds = |frames: &[f32]| frames.chunks(CHANNELS).any(|frame| frame.iter().any(|x| *x != 0.0));
    assert!(sounds(&frames[..96 * CHANNELS]));
    let loud = |c: usize| frames.iter().skip(c).step_by(CHANNELS).rposition(|x| *x != 0.0);
    assert!(
        !sounds(&frames[(96 + 5 * 48) * CHANNELS..]),
        "5 ms later: {:?}",
        (0..CHANNELS).map(loud).collect::<Vec<_>>()
    );
}

fn high(frames: &[f32], channel: usize) -> usize {
    frames.iter().skip(channel).step_by(CHANNELS).filter(|x| **x == 1.0).count()
}

#[test]
fn pulses_go_on_whatever_their_markers_number_is() {
    let marked = "[[output]]\nkind = \"trigger\"\nname = \"go\"\nchannel = 6\nmarker = \"go\"\npulse = 0.1\n";
    let more = format!(
        "[[output]]\nkind = \"trigger\"\nname = \"first\"\nchannel = 7\nmarker = \"first\"\n{marked}"
    );
    let bench = Bench { triggers: marked, ..Bench::new() };
    let other = Bench { triggers: more.leak(), ..Bench::new() };
    let (plan, other) = (bench.plan(), other.plan());
    let (mut director, mut stagehand) = exchange(&plan).unwrap();
    let number = plan.markers.iter().position(|name| &**name == "go").unwrap() as u32;
    stagehand.engine().schedule(Instant::default(), Source::Program, Event::Marker(number, 0));
    let mut frames = vec![0.0; 9600 * CHANNELS];
    stagehand.process(&[], &mut frames[..1200 * CHANNELS]);
    assert_eq!(director.send(&other), Ok(true));
    stagehand.process(&[], &mut frames[1200 * CHANNELS..]);
    assert_eq!((high(&frames, 5), high(&frames, 6)), (4800, 0));
    // And those to come are of the marker that is called so.
    let number = other.markers.iter().position(|name| &**name == "go").unwrap() as u32;
    let now = Instant { sample: stagehand.engine().clock(), fraction: 0 };
    stagehand.engine().schedule(now, Source::Program, Event::Marker(number, 0));
    let mut frames = vec![0.0; 9600 * CHANNELS];
    stagehand.process(&[], &mut frames);
    assert_eq!((high(&frames, 5), high(&frames, 6)), (4800, 0));
}

#[test]
fn what_needs_another_stream_is_told_with_both_figures() {
    let plan = Bench::new().plan();
    let (mut director, _stagehand) = exchange(&plan).unwrap();
    let other = Bench { device: "channels = 12", ..Bench::new() };
    assert_eq!(director.send(&other.plan()), Err(Mismatch::Channels(10, 12)));
    let slower = Options { rate: Some(44_100.0), live: true, ..Options::default() };
    let slower = scene(&patch(PATCH), &Bench::new().rig(), &slower, &NoAssets).unwrap().plan;
    let told = director.send(&slower).unwrap_err().to_string();
    assert!(told.contains("44100") && told.contains("48000") && told.contains("play again"), "{told}");
}

/// A place that a voice holds is found by its name.
#[test]
fn a_place_that_is_gone_is_silent() {
    let plan = Bench::new().plan();
    let mut bench = Bench::new();
    bench.tactors.remove(1);
    let other = bench.plan();
    let crossed = run(&plan, Some(&other), AT, LENGTH, &[64]);
    let plain = run(&plan, None, AT, LENGTH, &[64]);
    assert!(peak(&crossed[1][AT + 24_000..]) < 1e-5);
    for c in [0, 2, 3, 4, 8] {
        assert!(same(&crossed[c], &plain[c]), "channel {}", c + 1);
    }
    assert!(largest_step(&crossed[1]) <= largest_step(&plain[1]) * 1.25);
}
