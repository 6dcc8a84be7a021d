//! What reaches the device lies below 1 kHz and within full scale, whatever the patch does.
#![cfg(feature = "report")]

mod common;

use common::{channel, compiled, moments, play, rendered, silent_reference};
use pacinian::engine::Engine;
use pacinian::engine::event::Play;
use pacinian::report::compare;

/// Voices that ask most of the band limit: name, nodes with the output `o`, seconds.
const HOSTILE: &[(&str, &str, f64)] = &[
    (
        "square of 333 Hz",
        r#"t = { type = "pulse", frequency = 333 }
        e = { type = "gate" }"#,
        0.3,
    ),
    (
        "sine in a hard gate",
        r#"t = { type = "sine", frequency = 250 }
        e = { type = "gate" }"#,
        0.0213,
    ),
    (
        "noise",
        r#"t = { type = "white" }
        e = { type = "gate" }"#,
        0.3,
    ),
    (
        "one sample of noise",
        r#"t = { type = "white" }
        e = { type = "gate" }"#,
        0.000_125,
    ),
    (
        "FM of index 10",
        r#"m = { type = "sine", frequency = 100, amplitude = 1000 }
        t = { type = "sine", frequency = "300 + m" }
        e = { type = "gate" }"#,
        0.3,
    ),
    (
        "tone near the edge, stopped dead",
        r#"t = { type = "sine", frequency = 890.7, phase = 0.659 }
        e = { type = "gate" }"#,
        0.047,
    ),
    (
        "click",
        r#"t = { type = "add", inputs = [1.0] }
        e = { type = "burst", attack = 0, hold = 0.0001, decay = 0 }"#,
        0.01,
    ),
    (
        "pulse of 1 ms",
        r#"t = { type = "add", inputs = [1.0] }
        e = { type = "gate" }"#,
        0.001,
    ),
    (
        "struck noise",
        r#"t = { type = "white" }
        e = { type = "decay", time = 0.002 }"#,
        0.01,
    ),
];

fn voice(nodes: &str) -> String {
    format!(
        "[voice.v]\nvoices = 32\noutput = \"o\"\n[voice.v.nodes]\n{nodes}\n\
         o = {{ type = \"multiply\", inputs = [\"t\", \"e\"] }}"
    )
}

fn above(engine: &Engine, frames: &[f32], rate: f64, ratio: usize) -> f64 {
    let channels = engine.channels();
    let nothing = silent_reference(channels, frames.len() / channels / ratio, rate / ratio as f64);
    compare(frames, &nothing, ratio, 0.0, &|_, _| 1.0.into()).above_db
}

#[test]
fn nothing_above_1_khz_and_nothing_above_full_scale() {
    for &(name, nodes, duration) in HOSTILE {
        for (level, rate) in
            [(1.0, 48_000.0), (4.0, 48_000.0), (1.0, 44_100.0), (4.0, 44_100.0), (4.0, 96_000.0)]
        {
            let plan = compiled(&voice(nodes), 2, rate).plan;
            let events: Vec<_> = (0..6_u32)
                .map(|i| {
                    (
                        0.01 + 0.1037 * f64::from(i),
                        Play { level, ..play(0, i % 2, 0.0, duration, u64::from(i)) },
                    )
                })
                .collect();
            let (engine, frames) = rendered(&plan, &events, 0.5);
            let peak = frames.iter().fold(0.0_f32, |peak, x| peak.max(x.abs()));
            let above = above(&engine, &frames, rate, plan.ratio);
            let counts = engine.stage().counts();
            println!("{name:36} x {level} at {rate}: above {above:6.1} dB, peak {peak:.4}, {counts:?}");
            assert!(peak > 0.05, "{name} x {level} at {rate} Hz: peak {peak}");
            assert!(above < -60.0, "{name} x {level} at {rate} Hz: {above} dB above 1 kHz");
            assert!(peak <= 1.0, "{name} x {level} at {rate} Hz: peak {peak}");
            // Where the limiter works hard it leaves the clamp a few frames; a scene within its ceiling, none.
            assert!(counts.clamped <= counts.limited / 10, "{name} x {level} at {rate} Hz: {counts:?}");
        }
    }
}

/// Gain of the whole engine, dB, for sines of these frequencies.
fn gains(hertz: &[f64], rate: f64) -> Vec<f64> {
    let text = voice(
        r#"t = { type = "sine", frequency = "event.frequency", amplitude = 0.5 }
        e = { type = "envelope", attack = 0.02 }"#,
    );
    let plan = compiled(&text, hertz.len() as u32, rate).plan;
    let events: Vec<_> =
        hertz.iter().zip(0..).map(|(f, i)| (0.0, play(0, i, *f, 2.0, u64::from(i)))).collect();
    let (_, frames) = rendered(&plan, &events, 0.0);
    let (from, length) = ((0.5 * rate) as usize, rate as usize);
    (0..hertz.len())
        .map(|c| {
            let middle = &channel(&frames, hertz.len(), c)[from..from + length];
            // Hann, which sums to half its length.
            let middle: Vec<f64> = middle
                .iter()
                .enumerate()
                .map(|(n, x)| x * (0.5 - 0.5 * (std::f64::consts::TAU * n as f64 / length as f64).cos()))
                .collect();
            let (re, im) = moments(&middle, hertz[c], rate)[0];
            20.0 * (re.hypot(im) / (0.5 * length as f64 / 4.0)).log10()
        })
        .collect()
}

#[test]
fn the_pass_band_is_flat_to_850_hz_and_the_stop_band_begins_at_1_khz() {
    let pass: Vec<f64> = (0..24).map(|i| 20.0 + f64::from(i) * (850.0 - 20.0) / 23.0).collect();
    let stop = [1000.0, 1003.0, 1100.0, 1313.0, 2000.0, 3100.0, 3600.0];
    for rate in [44_100.0, 48_000.0, 96_000.0] {
        let (pass_gains, stop_gains) = (gains(&pass, rate), gains(&stop, rate));
        for (f, gain) in pass.iter().zip(&pass_gains) {
            assert!(gain.abs() < 0.5, "{gain} dB at {f} Hz, {rate} frames a second");
        }
        for (f, gain) in stop.iter().zip(&stop_gains) {
            assert!(*gain < -60.0, "{gain} dB at {f} Hz, {rate} frames a second");
        }
        let worst = pass_gains.iter().fold(0.0_f64, |worst, g| worst.max(g.abs()));
        println!("{rate}: within {worst:.3} dB to 850 Hz, stop band {stop_gains:.1?}");
    }
}
