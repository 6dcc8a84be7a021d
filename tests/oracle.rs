//! The engine against the scene reference: both hear the same events, and what differs within 1 kHz after the reported delay
//! was taken out is error.
#![cfg(feature = "report")]

mod common;

use common::{compiled, play, reference_as_frames, rendered, silent_reference};
use pacinian::engine::event::Play;
use pacinian::graph::plan::{Plan, Precision};
use pacinian::report::measure::{OVER, designed};
use pacinian::report::{Comparison, compare, reference};

/// What may be heard of an ordinary scene and of a hard one, dB.
const ORDINARY: f64 = -80.0;
const HARD: f64 = -60.0;

const TONE: &str = r#"t = { type = "sine", frequency = "event.frequency" }"#;
const SAW: &str = r#"t = { type = "sawtooth", frequency = "event.frequency" }"#;
const PULSE: &str = r#"t = { type = "pulse", frequency = "event.frequency", width = 0.3 }"#;
const NOISE: &str = r#"t = { type = "white" }"#;
const FM: &str = r#"m = { type = "sine", frequency = 50, amplitude = 500 }
t = { type = "sine", frequency = "event.frequency + m" }"#;
const SOFT: &str = r#"s = { type = "sawtooth", frequency = "event.frequency" }
t = { type = "lowpass", input = "s", cutoff = 300 }"#;

/// A patch of one voice: a tone `t` times an envelope.
fn scene(tone: &str, envelope: &str, rate: f64) -> Plan {
    let text = format!(
        "[voice.v]\nvoices = 64\noutput = \"o\"\n[voice.v.nodes]\n{tone}\ne = {{ {envelope} }}\n\
         o = {{ type = \"multiply\", inputs = [\"t\", \"e\"] }}"
    );
    compiled(&text, 4, rate).plan
}

/// A dozen voices of 37 to 711 Hz at instants that fall between samples.
fn dozen(duration: f64) -> Vec<(f64, Play)> {
    (0..12_u32)
        .map(|i| {
            let one = play(0, i % 4, 37.0 + 61.3 * f64::from(i), duration, u64::from(i));
            (0.01 + 0.0731 * f64::from(i), Play { level: 0.2, ..one })
        })
        .collect()
}

/// How far the engine is from the reference, when it is believed to be `wrong` seconds later than it says.
fn compared(plan: &Plan, events: &[(f64, Play)], wrong: f64) -> Comparison {
    let (engine, frames) = rendered(plan, events, 0.2);
    let seconds = frames.len() as f64 / plan.channels as f64 / plan.device_rate;
    let ideal = reference(plan, events, seconds, OVER);
    let delay = engine.delay();
    assert_eq!(engine.counters().stolen, 0, "the reference knows no stealing");
    assert_eq!(engine.stage().counts().limited, 0, "the reference knows no limiter");
    compare(
        &frames,
        &ideal,
        plan.ratio,
        delay.lead + delay.up_sampling + delay.band_limit_phase + wrong,
        &|channel, hertz| designed(&engine, channel, hertz),
    )
}

fn holds(sets: &[(&str, &str, &str)], duration: f64, most: f64) {
    for &(name, tone, envelope) in sets {
        for rate in [48_000.0, 44_100.0] {
            let found = compared(&scene(tone, envelope, rate), &dozen(duration), 0.0);
            println!("{name:28} {rate} Hz: error {:7.1} dB, above {:7.1} dB", found.error_db, found.above_db);
            assert!(found.error_db < most, "{name} at {rate} Hz: {found:?}");
            assert!(found.above_db < -60.0, "{name} at {rate} Hz: {found:?}");
        }
    }
}

#[test]
fn ordinary_scenes() {
    let usual = r#"type = "envelope", attack = 0.01, decay = 0.02, sustain = 0.5, release = 0.01"#;
    let short = r#"type = "envelope""#;
    holds(
        &[
            ("sine, 10 ms", TONE, usual),
            ("sine, 5 ms", TONE, short),
            ("sawtooth, 5 ms", SAW, short),
            ("modulated frequency, 5 ms", FM, short),
            ("filtered sawtooth, 20 ms", SOFT, r#"type = "envelope", attack = 0.02, release = 0.02"#),
        ],
        0.13,
        ORDINARY,
    );
}

#[test]
fn hard_scenes() {
    holds(
        &[
            (
                "sine, 1 ms",
                TONE,
                r#"type = "envelope", attack = 0.001, decay = 0.001, sustain = 0.5, release = 0.001"#,
            ),
            ("sine, gate", TONE, r#"type = "gate""#),
            ("sawtooth, gate", SAW, r#"type = "gate""#),
            ("pulse, gate", PULSE, r#"type = "gate""#),
            ("noise, 5 ms", NOISE, r#"type = "envelope""#),
            ("sine, struck", TONE, r#"type = "decay", time = 0.03"#),
            (
                "sine, burst of 1 ms",
                TONE,
                r#"type = "burst", attack = 0.0003, hold = 0.0004, decay = 0.0003"#,
            ),
            ("sine, burst of 1 ms, hard", TONE, r#"type = "burst", attack = 0, hold = 0.001, decay = 0"#),
            (
                "click",
                r#"t = { type = "add", inputs = [1.0] }"#,
                r#"type = "burst", attack = 0, hold = 0.0001, decay = 0"#,
            ),
        ],
        0.13,
        HARD,
    );
}

/// What has memory, as an ordinary scene has it: filters of oscillators and of noise, a frequency that an envelope moves, a follower.
#[test]
fn memory() {
    let rise = r#"d = { type = "burst", attack = 0.005, decay = 0.05 }
t = { type = "sine", frequency = "event.frequency * (1 + 0.4 * d)" }"#;
    let hiss = r#"n = { type = "white" }
t = { type = "lowpass", input = "n", cutoff = 300 }"#;
    let short = r#"type = "envelope""#;
    remembers(
        &[
            ("filtered sawtooth, 5 ms", SOFT, short),
            ("rise of frequency, 5 ms", rise, short),
            ("pink noise, 5 ms", r#"t = { type = "pink" }"#, short),
            ("noise of a band, 5 ms", r#"t = { type = "band_noise", low = 80, high = 250 }"#, short),
            ("filtered noise, 5 ms", hiss, short),
            ("followed, 5 ms", &followed("0.3 * event.frequency"), short),
        ],
        ORDINARY,
    );
}

/// Where a jump meets what has memory: a filter behind a source that begins abruptly, a frequency that jumps, noise that begins.
#[test]
fn jumps_before_what_has_memory() {
    let jump = r#"d = { type = "decay", time = 0.02 }
t = { type = "sine", frequency = "event.frequency + 40 * d" }"#;
    let share = r#"d = { type = "decay", time = 0.02 }
t = { type = "sawtooth", frequency = "event.frequency * (0.8 + 0.4 * d)" }"#;
    let both = r#"d = { type = "decay", time = 0.02 }
m = { type = "sine", frequency = 30, phase = 0.25, amplitude = 20 }
t = { type = "sine", frequency = "event.frequency + 40 * d + m" }"#;
    let edge = r#"s = { type = "sawtooth", frequency = "event.frequency", phase = 0.4 }
t = { type = "lowpass", input = "s", cutoff = 300 }"#;
    let high = r#"s = { type = "sine", frequency = "event.frequency", phase = 0.25 }
t = { type = "highpass", input = "s", cutoff = 100 }"#;
    let sum = r#"d = { type = "decay", time = 0.02 }
s = { type = "sine", frequency = "event.frequency", phase = 0.2 }
t = { type = "bandpass", input = "s + d", frequency = 150, q = 2 }"#;
    let struck = r#"d = { type = "decay", time = 0.005 }
n = { type = "band_noise", low = 100, high = 500, amplitude = "d" }
t = { type = "resonator", input = "n", frequency = "event.frequency", decay = 0.1 }"#;
    let echo = r#"s = { type = "sine", frequency = "event.frequency", phase = 0.25 }
t = { type = "delay", input = "s", time = 0.0203, longest = 0.03 }"#;
    let gate = r#"type = "gate""#;
    let short = r#"type = "envelope""#;
    remembers(
        &[
            ("filtered sawtooth, gate", SOFT, gate),
            ("filtered edge, gate", edge, gate),
            ("high-pass of a cosine, 5 ms", high, short),
            ("filtered sum, gate", sum, gate),
            ("delayed cosine, gate", echo, gate),
            ("struck resonator, 5 ms", struck, short),
            ("jump of frequency, 5 ms", jump, short),
            ("jump of frequency, gate", jump, gate),
            ("jump of a share, 5 ms", share, short),
            ("jump and vibrato, 5 ms", both, short),
            ("noise of a band, gate", r#"t = { type = "band_noise", low = 80, high = 250 }"#, gate),
            ("followed, gate", &followed("event.frequency"), gate),
        ],
        HARD,
    );
}

/// A tone as loud as another one is at the moment.
fn followed(frequency: &str) -> String {
    format!(
        r#"s = {{ type = "sine", frequency = "{frequency}" }}
f = {{ type = "follow", input = "s", attack = 0.002, release = 0.03 }}
c = {{ type = "sine", frequency = 120 }}
t = {{ type = "multiply", inputs = ["c", "f"] }}"#
    )
}

/// As [`holds`], without the power above the band, and all of them are printed before one fails.
fn remembers(sets: &[(&str, &str, &str)], most: f64) {
    let mut worst = f64::NEG_INFINITY;
    for (name, tone, envelope) in sets {
        let [found, other] = [48_000.0, 44_100.0]
            .map(|rate| compared(&scene(tone, envelope, rate), &dozen(0.13), 0.0).error_db);
        println!("{name:28}: error {found:7.1} dB, at 44.1 kHz {other:7.1} dB");
        worst = worst.max(found).max(other);
    }
    assert!(worst < most, "{worst} dB");
}

/// A gate of less than a sample, and of nothing at all.
#[test]
fn events_shorter_than_a_sample() {
    // What is left of such a tone is so little that the band limit's own 66 dB show: only its error within the band is asked.
    let brief = compared(&scene(TONE, r#"type = "gate""#, 48_000.0), &dozen(0.0001), 0.0);
    assert!(brief.error_db < HARD, "{brief:?}");
    let plan = scene(TONE, r#"type = "gate""#, 48_000.0);
    let (_, frames) = rendered(&plan, &dozen(0.0), 0.1);
    let peak = frames.iter().fold(0.0_f32, |peak, x| peak.max(x.abs()));
    assert!(peak < 1e-5, "an event of no length peaks at {peak}");
}

#[test]
fn every_option_holds() {
    for (taps, precision) in [(4, Precision::Single), (12, Precision::Single), (6, Precision::Double)] {
        for (tone, envelope, most) in
            [(SAW, r#"type = "envelope""#, ORDINARY), (TONE, r#"type = "gate""#, HARD)]
        {
            let mut plan = scene(tone, envelope, 48_000.0);
            (plan.taps, plan.precision) = (taps, precision);
            let found = compared(&plan, &dozen(0.13), 0.0);
            println!("{taps} taps, {precision:?}: error {:7.1} dB", found.error_db);
            assert!(found.error_db < most, "{taps} taps, {precision:?}: {found:?}");
        }
    }
}

/// A measure that did not see a delay that is wrong by one frame of the device would prove nothing of time.
#[test]
fn a_delay_wrong_by_a_frame_is_seen() {
    for rate in [48_000.0, 44_100.0] {
        let plan = scene(TONE, r#"type = "envelope""#, rate);
        for wrong in [-1.0, 1.0] {
            let found = compared(&plan, &dozen(0.13), wrong / rate);
            assert!(found.error_db > -50.0, "{wrong} frames at {rate} Hz: {found:?}");
        }
    }
}

/// The reference would be no reference if it depended on how finely it is computed.
#[test]
fn the_reference_converges() {
    for (name, tone, envelope, most) in [
        ("sine, 5 ms", TONE, r#"type = "envelope""#, -100.0),
        ("modulated frequency", FM, r#"type = "envelope""#, -100.0),
        ("sine, gate", TONE, r#"type = "gate""#, -90.0),
        ("sawtooth, 5 ms", SAW, r#"type = "envelope""#, -100.0),
    ] {
        let plan = scene(tone, envelope, 48_000.0);
        let events = dozen(0.05);
        let [coarse, fine] = [8, 32].map(|over| reference(&plan, &events, 1.2, over));
        let frames = reference_as_frames(&coarse);
        let found = compare(&frames, &fine, 1, 0.0, &|_, _| 1.0.into());
        println!("{name:28} 8 against 32 times: {:7.1} dB", found.error_db);
        assert!(found.error_db < most, "{name}: {found:?}");
        // And the comparison is no formality: against silence all of it is error.
        let nothing = compare(&vec![0.0; frames.len()], &fine, 1, 0.0, &|_, _| 1.0.into());
        assert!(nothing.error_db.abs() < 1e-9);
        assert_eq!(
            compare(&[], &silent_reference(4, 100, 8000.0), 1, 0.0, &|_, _| 1.0.into()).error_db,
            f64::NEG_INFINITY
        );
    }
}
