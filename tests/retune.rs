//! A patch that is changed while it sounds: what sounds goes on from where it is, and as the new patch has it.

mod common;

use common::{compiled, play, schedule};
use pacinian::engine::exchange::exchange;

const RATE: f64 = 48_000.0;
const BLOCK: usize = 48;

/// Seconds of each half of a run.
const HALF: f64 = 1.5;

/// What a patch plays on `channels` channels for [`HALF`], and another that takes over for as long again. A voice of the first instrument is held all the
/// time if `held`.
fn run(first: &str, second: &str, channels: usize, held: bool) -> Vec<f32> {
    let plan = |text: &str| compiled(text, channels as u32, RATE).plan;
    let (mut director, mut stagehand) = exchange(&plan(first)).unwrap();
    if held {
        schedule(stagehand.engine(), &[(0.0, play(0, 0, 60.0, 2.0 * HALF, 1))]);
    }
    let half = (HALF * RATE) as usize;
    let mut output = vec![0.0; 2 * half * channels];
    for (n, part) in output.chunks_mut(BLOCK * channels).enumerate() {
        if n == half / BLOCK {
            assert!(director.send(&plan(second)).unwrap());
        }
        stagehand.process(&[], part);
    }
    output
}

/// The last second of a channel.
fn end(output: &[f32], channels: usize, channel: usize) -> Vec<f64> {
    let samples: Vec<f64> = output.iter().skip(channel).step_by(channels).map(|x| f64::from(*x)).collect();
    samples[samples.len() - RATE as usize..].to_vec()
}

/// Root mean squares of a signal and of its steps, in decibels: what it holds, and how fast it moves.
fn figures(signal: &[f64]) -> [f64; 2] {
    let db = |sum: f64| 10.0 * (sum / signal.len() as f64 + 1e-12).log10();
    let steps = signal.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum();
    [db(signal.iter().map(|x| x * x).sum()), db(steps) + 40.0]
}

fn distance(one: [f64; 2], other: [f64; 2]) -> f64 {
    (one[0] - other[0]).hypot(one[1] - other[1])
}

/// A patch of one voice that is always on.
fn hum(nodes: &str) -> String {
    format!("[voice.hum]\nstart = \"always\"\noutput = \"out\"\n[voice.hum.nodes]\n{nodes}\n")
}

fn becomes_the_other(what: &str, before: &str, after: &str, held: bool) {
    let (changed, as_new, as_old) =
        (run(before, after, 1, held), run(after, after, 1, held), run(before, before, 1, held));
    let [is, new, old] = [&changed, &as_new, &as_old].map(|run| figures(&end(run, 1, 0)));
    let apart = distance(old, new);
    assert!(apart > 3.0, "{what}: no such change would be seen, {old:?} {new:?}");
    assert!(distance(is, new) < 0.15 * apart, "{what}: {is:?}, which were {old:?} and are to be {new:?}");
}

#[test]
fn what_sounds_takes_what_is_said_of_its_nodes() {
    let tone = "tone = { type = \"sine\", frequency = 200, amplitude = 0.5 }\n";
    let filtered = |filter: &str| format!("{tone}out = {{ input = \"tone\", {filter} }}");
    let sine = |rest: &str| format!("out = {{ type = \"sine\", amplitude = 0.5, {rest} }}");
    let noise = "hiss = { type = \"white\", amplitude = 0.2 }\n";
    let of_noise = |filter: &str| format!("{noise}out = {{ input = \"hiss\", {filter} }}");
    let own = |node: &str| format!("out = {{ {node} }}");
    let moved = |rest: &str| {
        format!("slow = {{ type = \"lfo\", rate = 3 }}\nout = {{ type = \"sine\", amplitude = 0.5, {rest} }}")
    };
    #[allow(unused_mut)] // only grows with the nodes of fundsp
    let mut cases = vec![
        (sine("frequency = 60"), sine("frequency = 210")),
        (sine("frequency = 100"), sine("frequency = 3700")),
        (sine("frequency = 3700"), sine("frequency = 100")),
        (sine("frequency = \"event.frequency\""), sine("frequency = \"event.frequency * 5\"")),
        (sine("frequency = 60"), moved("frequency = \"300 + 20 * slow\"")),
        (moved("frequency = \"300 + 20 * slow\""), sine("frequency = 60")),
        (
            own("type = \"triangle\", amplitude = 0.5, frequency = 50"),
            own("type = \"triangle\", amplitude = 0.5, frequency = 190"),
        ),
        (
            own("type = \"sawtooth\", amplitude = 0.5, frequency = 50"),
            own("type = \"sawtooth\", amplitude = 0.5, frequency = 290"),
        ),
        (
            own("type = \"pulse\", amplitude = 0.5, frequency = 50"),
            own("type = \"pulse\", amplitude = 0.5, frequency = 290"),
        ),
        (
            own("type = \"lfo\", low = -0.5, high = 0.5, rate = 30"),
            own("type = \"lfo\", low = -0.5, high = 0.5, rate = 90"),
        ),
        (
            own("type = \"lfo\", wave = \"square\", low = -0.5, high = 0.5, rate = 30, ease = 0.001"),
            own("type = \"lfo\", wave = \"square\", low = -0.5, high = 0.5, rate = 30, ease = 0.016"),
        ),
        (filtered("type = \"lowpass\", cutoff = 700"), filtered("type = \"lowpass\", cutoff = 60")),
        (filtered("type = \"highpass\", cutoff = 60"), filtered("type = \"highpass\", cutoff = 700")),
        (
            filtered("type = \"bandpass\", frequency = 200, q = 4"),
            filtered("type = \"bandpass\", frequency = 60, q = 4"),
        ),
        (
            filtered("type = \"notch\", frequency = 60, q = 2"),
            filtered("type = \"notch\", frequency = 190, q = 2"),
        ),
        (
            of_noise("type = \"resonator\", frequency = 60, decay = 0.1"),
            of_noise("type = \"resonator\", frequency = 250, decay = 0.1"),
        ),
        (
            own("type = \"band_noise\", low = 40, high = 60, amplitude = 0.2"),
            own("type = \"band_noise\", low = 200, high = 400, amplitude = 0.2"),
        ),
        (
            own("type = \"follow\", input = \"tone\", release = 0.5"),
            own("type = \"follow\", input = \"tone\", release = 0.0002"),
        ),
    ];
    #[cfg(feature = "fundsp-nodes")]
    cases.extend([
        (
            own("type = \"brown\", corner = 20, amplitude = 0.2"),
            own("type = \"brown\", corner = 500, amplitude = 0.2"),
        ),
        (
            own("type = \"chaos\", frequency = 8, amplitude = 0.4"),
            own("type = \"chaos\", frequency = 70, amplitude = 0.4"),
        ),
    ]);
    for (before, after) in cases {
        let whole = |nodes: &str| {
            let reads = nodes.contains("\"tone\"") && !nodes.contains("tone = ");
            hum(&if reads { format!("{tone}{nodes}") } else { nodes.to_owned() })
        };
        becomes_the_other(&before, &whole(&before), &whole(&after), false);
    }
}

#[test]
fn shared_nodes_do_as_well() {
    let shared = |node: &str| {
        format!(
            "[shared.nodes]\nslow = {{ {node} }}\n{}",
            hum("out = { type = \"sine\", frequency = 100, amplitude = \"0.5 * slow\" }")
        )
    };
    let lfo = |rate: u32| shared(&format!("type = \"lfo\", low = -1, high = 1, rate = {rate}"));
    let sine = |frequency: u32| shared(&format!("type = \"sine\", frequency = {frequency}"));
    becomes_the_other("lfo", &lfo(2), &lfo(200), false);
    becomes_the_other("sine", &sine(2), &sine(200), false);
}

#[test]
fn voices_that_are_held_do_as_well_and_keep_what_their_events_say() {
    let voice = |nodes: &str| format!("[voice.v]\noutput = \"out\"\n[voice.v.nodes]\n{nodes}\n");
    let sine = |frequency: &str| {
        voice(&format!("out = {{ type = \"sine\", amplitude = 0.5, frequency = {frequency} }}"))
    };
    becomes_the_other("a factor", &sine("\"event.frequency\""), &sine("\"event.frequency * 4\""), true);
    becomes_the_other("a constant", &sine("60"), &sine("220"), true);
    // Another usual frequency is that of later voices.
    let usual = |hertz: u32| {
        sine("\"event.frequency\"")
            .replace("[voice.v]", &format!("[voice.v]\ndefaults = {{ frequency = {hertz} }}"))
    };
    let [is, was] = [run(&usual(90), &usual(250), 1, true), run(&usual(90), &usual(90), 1, true)]
        .map(|run| figures(&end(&run, 1, 0)));
    assert!(distance(is, was) < 0.01, "{is:?} {was:?}");
}

/// What is always on has no event but what its patch says.
#[test]
fn what_is_always_on_is_where_and_as_its_patch_says() {
    let at = |place: &str, hertz: u32, level: f64| {
        let voice = format!(
            "place = \"{place}\"\ndefaults = {{ frequency = {hertz}, level = {level} }}\noutput = \"out\""
        );
        hum("out = { type = \"sine\", frequency = \"event.frequency\", amplitude = 0.5 }")
            .replace("output = \"out\"", &voice)
    };
    let (there, here) = (at("t1", 60, 1.0), at("t2", 220, 0.5));
    let (changed, as_new) = (run(&there, &here, 2, false), run(&here, &here, 2, false));
    for channel in 0..2 {
        let [is, new] = [&changed, &as_new].map(|run| figures(&end(run, 2, channel)));
        assert!(distance(is, new) < 0.1, "{channel}: {is:?} {new:?}");
    }
}

/// The phase goes on: 60 Hz until the new patch takes over, 210 Hz from then on, and no jump but what the extrapolation of two samples misses.
#[test]
fn a_tone_goes_on_from_its_phase() {
    for wave in ["sine", "triangle"] {
        let tone =
            |hertz: u32| hum(&format!("out = {{ type = \"{wave}\", frequency = {hertz}, amplitude = 0.5 }}"));
        let step = |run: &[f32]| run.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
        let changed = run(&tone(60), &tone(210), 1, false);
        let half = (HALF * RATE) as usize;
        let (largest, usual) = (step(&changed[half - 960..half + 960]), step(&changed[half + 4_800..]));
        assert!(largest <= 1.05 * usual, "{wave}: a step of {largest} where {usual} is the largest later");
    }
}

/// How what is held will end is what the new patch says; how it began stays.
#[test]
fn what_is_held_ends_as_the_new_patch_says() {
    for (node, ends) in [
        ("type = \"envelope\", attack = 0.01, sustain = 1", "release"),
        ("type = \"gate\", rise = 0.01", "fall"),
    ] {
        let voice = |seconds: f64| {
            format!(
                "[voice.v]\noutput = \"out\"\n[voice.v.nodes]\ntone = {{ type = \"sine\", frequency = 100, amplitude = 0.5 }}\n\
                 hit = {{ {node}, {ends} = {seconds} }}\nout = {{ type = \"multiply\", inputs = [\"tone\", \"hit\"] }}\n"
            )
        };
        let plan = |text: &str| compiled(text, 1, RATE).plan;
        let (mut director, mut stagehand) = exchange(&plan(&voice(3.0))).unwrap();
        schedule(stagehand.engine(), &[(0.0, play(0, 0, 60.0, 1.0, 1))]);
        let mut output = vec![0.0; 2 * RATE as usize];
        for (n, part) in output.chunks_mut(BLOCK).enumerate() {
            if n == 500 {
                assert!(director.send(&plan(&voice(0.02))).unwrap());
            }
            stagehand.process(&[], part);
        }
        let loudest = |from: f64, to: f64| {
            let part = &output[(from * RATE) as usize..(to * RATE) as usize];
            part.iter().fold(0.0_f32, |most, x| most.max(x.abs()))
        };
        assert!(loudest(0.4, 0.99) > 0.47, "{node}");
        assert!(loudest(1.05, 2.0) < 1e-5, "{node}: {}", loudest(1.05, 2.0));
    }
}
