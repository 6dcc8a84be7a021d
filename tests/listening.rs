//! What a session hears, live: from a sound card with a clock of its own, and from a file; and the latency of a loop.
//!
//! The cards are those of `tests/devices/card.c`. Where there is no C compiler or no ALSA, a test says that it was skipped, and why.
#![cfg(target_os = "linux")]

#[path = "common/bench.rs"]
mod bench;

use std::f64::consts::TAU;
use std::fs;
use std::process::Output;

use bench::{Bench, signal, wait};

/// Passes on what channel 2 of the input brings, to both outputs.
const LISTENS: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nstart = \"always\"\noutput = \"i\"\nplace = \"t1\"\n\
    [voice.v.nodes]\ni = { type = \"input\", channel = 2 }\n";

fn said(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

/// Frames of two channels: silence, and a tone at half of full scale.
fn tone(hertz: f64, rate: f64, seconds: f64) -> Vec<u8> {
    (0..(rate * seconds) as u32)
        .flat_map(|n| [0.0, (0.5 * (TAU * hertz * f64::from(n) / rate).sin()) as f32])
        .flat_map(f32::to_le_bytes)
        .collect()
}

/// What is left of a tone of about `hertz` when the best one is taken out, as a share of its energy; over every part of `length` samples,
/// in each of which the tone may have a phase of its own, the median.
fn residue(signal: &[f32], rate: f64, hertz: f64, length: usize) -> f64 {
    let mut all: Vec<f64> = signal
        .chunks_exact(length)
        .map(|part| {
            let (mut ss, mut sc, mut cc, mut sx, mut cx, mut xx) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
            for (n, x) in part.iter().enumerate() {
                let (s, c) = (TAU * hertz * n as f64 / rate).sin_cos();
                let x = f64::from(*x);
                (ss, sc, cc, sx, cx, xx) =
                    (ss + s * s, sc + s * c, cc + c * c, sx + s * x, cx + c * x, xx + x * x);
            }
            let det = ss * cc - sc * sc;
            let (a, b) = ((sx * cc - cx * sc) / det, (cx * ss - sx * sc) / det);
            1.0 - (a * sx + b * cx) / xx.max(1e-30)
        })
        .collect();
    all.sort_by(f64::total_cmp);
    all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
}

fn first_channel(bench: &Bench, channels: usize) -> Vec<f32> {
    bench.samples().iter().step_by(channels).copied().collect()
}

#[test]
fn a_card_with_another_clock_and_another_rate_is_heard() {
    for (name, rate, rig) in [("same", 48_000.0, ""), ("other", 44_100.0, "rates 44100")] {
        let Some(bench) = Bench::new(&format!("heard-{name}")) else { return };
        bench.card("microphone", &format!("channels 2 heard \"@/heard.raw\" ppm 250 {rig}"));
        fs::write(bench.folder.join("heard.raw"), tone(200.0, rate, 60.0)).unwrap();
        bench.write("listens.toml", LISTENS);
        let arguments = [
            "play",
            "listens.toml",
            "--device",
            "card8",
            "--input-device",
            "microphone",
            "--block",
            "512",
            "--duration",
            "6",
        ];
        // Whatever gaps there are, on this machine or that, are the cards' own; then it is tried again.
        for attempt in 0..5 {
            let _ = fs::remove_file(bench.played());
            let output = bench.run(&arguments);
            let told = said(&output);
            assert!(output.status.success(), "{told}");
            let listens = format!("it listens to microphone: channel 2 of 2 channels at {rate} Hz");
            assert!(told.contains(&listens) && told.contains("  input: "), "{told}");
            let heard = first_channel(&bench, 8);
            let late = &heard[heard.len() - 3 * 48_000..heard.len() - 9_600];
            assert!(late.iter().any(|x| *x > 0.45), "{name}: nothing is heard");
            if attempt < 4 && (told.contains("xrun\n") || told.contains("xruns\n") || told.contains("a gap"))
            {
                continue;
            }
            // The microphone is fast by 250 millionths. In its first seconds it is followed quickly, and so is the machine's jitter.
            let rest = residue(late, 48_000.0, 200.0 * 1.000_25, 4800);
            println!("{name}: {:.1} dB", 10.0 * rest.log10());
            assert!(rest < 0.02, "{name}: {rest}\n{told}");
            break;
        }
    }
}

#[test]
fn what_the_patch_does_not_hear_is_not_opened_and_the_rig_may_name_it() {
    let Some(bench) = Bench::new("named") else { return };
    bench.card("microphone", "channels 1 heard \"@/heard.raw\"");
    bench.write("listens.toml", LISTENS);
    let deaf = LISTENS.replace("type = \"input\", channel = 2", "type = \"sine\", frequency = 100");
    bench.write("deaf.toml", &deaf);
    bench.write(
        "rig.toml",
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 8\ninput = \"microphone\"\n[[tactor]]\nname = \"t1\"\nchannel = 1\n",
    );
    let play = |patch: &str, more: &[&str]| {
        let mut all = vec!["play", patch, "--device", "card8", "--duration", "0.5"];
        all.extend(more);
        let output = bench.run(&all);
        (output.status.code(), said(&output))
    };
    let (code, told) = play("listens.toml", &["--rig", "rig.toml"]);
    assert!(code == Some(0) && told.contains("it listens to microphone"), "{told}");
    assert!(told.contains("channel 2 is not there and stays silent"), "{told}");
    assert!(!told.contains("hears silence"), "{told}");
    let (code, told) = play("deaf.toml", &["--rig", "rig.toml"]);
    assert!(code == Some(0) && !told.contains("microphone") && !told.contains("  input: "), "{told}");
    let (code, told) = play("deaf.toml", &["--input-device", "microphone"]);
    assert!(code == Some(0) && told.contains("nothing in this patch listens"), "{told}");
    let (code, told) = play("listens.toml", &[]);
    assert!(code == Some(0) && told.contains("hears silence") && told.contains("--input-device"), "{told}");
    let (code, told) = play("listens.toml", &["--input-device", "nowhere"]);
    assert!(code == Some(69) && told.contains("there is no device `nowhere`"), "{told}");
}

#[test]
fn a_microphone_that_is_pulled_leaves_silence_and_comes_back() {
    let Some(bench) = Bench::new("mute") else { return };
    bench.card("microphone", "channels 2 heard \"@/heard.raw\" gone \"@/pulled\"");
    fs::write(bench.folder.join("heard.raw"), tone(50.0, 48_000.0, 60.0)).unwrap();
    bench.write("listens.toml", LISTENS);
    let child = bench.start(&[
        "play",
        "listens.toml",
        "--device",
        "card8",
        "--input-device",
        "microphone",
        "--block",
        "256",
        "--events",
        "heard.csv",
    ]);
    let length = || fs::metadata(bench.played()).map_or(0, |about| about.len());
    let loud = || bench.samples().iter().rev().take(8 * 4800).any(|x| x.abs() > 0.4);
    wait("the microphone", loud);
    let pulled = bench.folder.join("pulled");
    fs::write(&pulled, "").unwrap();
    wait("silence", || bench.samples().iter().rev().take(8 * 4800).all(|x| *x == 0.0));
    let before = length();
    wait("time that goes on", || length() > before + 8 * 4 * 9_600);
    fs::remove_file(&pulled).unwrap();
    wait("the microphone's return", loud);
    signal(&child, "INT");
    let output = child.wait_with_output().unwrap();
    let told = said(&output);
    assert_eq!(output.status.code(), Some(130), "{told}");
    assert!(told.contains("the input device is gone") && told.contains("the input device is back"), "{told}");
    // So the journal has it.
    let journal = fs::read_to_string(bench.folder.join("heard.csv")).unwrap();
    let of = |what: &str| journal.lines().position(|l| l.starts_with("device,") && l.contains(what));
    assert!(of("input-lost").unwrap() < of("input-back").unwrap(), "{journal}");
    let head = journal.lines().next().unwrap();
    assert!(head.contains("\"heard\":\"microphone\""), "{head}");
    let end = journal.lines().rfind(|line| line.starts_with("end,")).unwrap();
    let dry = end.split("input_dry=").nth(1).unwrap().split(';').next().unwrap();
    assert!(dry.parse::<u32>().unwrap() > 0, "{end}");
    // The tone has a slope of 0.0033 a frame, its fades add 0.0042 at most; a step would be up to 0.5. Gaps of the cards are their own.
    let heard = first_channel(&bench, 8);
    let steps = heard.windows(2).filter(|w| (w[1] - w[0]).abs() > 0.012).count();
    let gaps = |name: &str| -> usize {
        told.match_indices(name)
            .filter_map(|(at, _)| told[..at].trim_end().rsplit(' ').next()?.parse::<usize>().ok())
            .sum()
    };
    assert!(steps <= 4 * gaps(" xrun"), "{steps} steps\n{told}");
}

#[test]
fn a_file_is_heard_from_its_beginning_as_it_would_be_rendered() {
    let Some(bench) = Bench::new("file") else { return };
    let mut wav =
        b"RIFF\0\0\0\0WAVEfmt \x10\0\0\0\x03\0\x02\0\x80\xbb\0\0\x00\xdc\x05\0\x08\0\x20\0data".to_vec();
    let frames = tone(120.0, 48_000.0, 1.0);
    wav.extend((frames.len() as u32).to_le_bytes());
    wav.extend(&frames);
    let size = (wav.len() - 8) as u32;
    wav[4..8].copy_from_slice(&size.to_le_bytes());
    fs::write(bench.folder.join("sound.wav"), wav).unwrap();
    bench.write("listens.toml", LISTENS);
    bench.write(
        "rig.toml",
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 8\nrate = 48000\ncoupling = { high_pass = 8 }\n[[tactor]]\nname = \"t1\"\nchannel = 1\n",
    );
    let rendered = bench.run(&[
        "render",
        "listens.toml",
        "--rig",
        "rig.toml",
        "--input",
        "sound.wav",
        "-o",
        "out.wav",
        "--duration",
        "1",
    ]);
    assert!(rendered.status.success(), "{}", said(&rendered));
    let wav = fs::read(bench.folder.join("out.wav")).unwrap();
    let data = wav.windows(4).position(|w| w == b"data").unwrap() + 8;
    let offline: Vec<f32> =
        wav[data..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
    // A gap drops a block, on this machine or that; then it is tried again.
    for attempt in 0..5 {
        let _ = fs::remove_file(bench.played());
        let played = bench.run(&[
            "play",
            "listens.toml",
            "--rig",
            "rig.toml",
            "--input",
            "sound.wav",
            "--device",
            "card8",
            "--block",
            "512",
            "--duration",
            "1.5",
        ]);
        let told = said(&played);
        assert!(played.status.success() && told.contains("it hears sound.wav"), "{told}");
        if !told.contains(" 0 xruns") && attempt < 4 {
            continue;
        }
        let online = bench.samples();
        // Behind the ramp of the beginning.
        let (first, last) = (8 * 9_600, 8 * 47_000);
        assert!(offline[first..last].iter().any(|x| x.abs() > 0.4));
        let differs = (first..last).find(|&n| online[n].to_bits() != offline[n].to_bits());
        assert_eq!(differs, None, "{told}");
        return;
    }
}

/// Whether a measurement that is wrong says of itself that not all was well: rounds that differ by half a frame or more, or that do not count.
fn stood_still(measured: &serde_json::Value) -> bool {
    let differ = measured["deviation_s"].as_f64().unwrap() * 48_000.0 > 0.5;
    differ || ["unheard", "in_gaps", "far_off"].iter().any(|key| measured[key].as_u64().unwrap() > 0)
}

/// Measures through a cable of so many frames.
fn latency(bench: &Bench, arguments: &[&str]) -> serde_json::Value {
    let mut all = vec!["latency", "--json", "--count", "12"];
    all.extend(arguments);
    let output = bench.run(&all);
    assert!(output.status.success(), "{}", said(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn a_cable_of_known_length_is_measured_within_a_sample() {
    let Some(bench) = Bench::new("cable") else { return };
    for delay in [0, 57, 480] {
        let name = format!("loop{delay}");
        bench.card(&name, &format!("channels 4 played \"@/{name}.raw\" loop 1 delay {delay}"));
        // A machine that stands still while it measures is tried again.
        for attempt in 0..4 {
            let measured = latency(&bench, &["--device", &name, "--out", "2", "--in", "2"]);
            let frames = measured["loop_latency_frames"].as_f64().unwrap();
            println!("{delay} frames: {frames}, deviation {} s", measured["deviation_s"]);
            let right = (frames - f64::from(delay)).abs() < 1.0 && measured["heard"].as_u64().unwrap() >= 6;
            if !right && attempt < 3 && stood_still(&measured) {
                continue;
            }
            assert!(right, "{delay}: {measured:#}");
            assert!((measured["gain"].as_f64().unwrap() - 1.0).abs() < 0.02, "{measured:#}");
            break;
        }
    }
}

#[test]
fn a_cable_to_a_card_with_another_clock_is_measured_and_saved() {
    let Some(bench) = Bench::new("saved") else { return };
    bench.card("loud", "channels 4 played \"@/cable.raw\"");
    bench.card("fast", "channels 4 played \"@/cable.raw\" loop 1 delay 100 ppm 300");
    let rig = "# mine\nformat = \"pacinian-rig/1\"\n[device]\nname = \"loud\"\ninput = \"fast\"\nchannels = 4 # four\n\n\
        [[tactor]]\nname = \"spine\"\nchannel = 3\n";
    let mut frames = 0.0;
    for attempt in 0..4 {
        bench.write("rig.toml", rig);
        let measured = latency(&bench, &["--rig", "rig.toml", "--out", "spine", "--in", "3", "--save"]);
        frames = measured["loop_latency_frames"].as_f64().unwrap();
        let ppm = measured["clocks_ppm"].as_f64().unwrap();
        let right = (frames - 100.0).abs() < 1.0 && (ppm - 300.0).abs() < 30.0;
        assert!(right || attempt < 3 && stood_still(&measured), "{measured:#}");
        if right {
            break;
        }
    }
    let saved = fs::read_to_string(bench.folder.join("rig.toml")).unwrap();
    let line =
        saved.lines().find(|line| line.starts_with("loop_latency = ")).unwrap_or_else(|| panic!("{saved}"));
    assert_eq!(saved.replace(&format!("{line}\n"), ""), rig);
    assert!((line["loop_latency = ".len()..].parse::<f64>().unwrap() * 48_000.0 - frames).abs() < 0.01);
}

const BRIDGE: &str = "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nfull_scale_volts = 3.3\ncoupling = \"dc\"\n\
    [amplifier.b]\ndrive = \"bridge\"\nmax_volts = 3.3\n[actuator.coin]\npart = \"coin-10mm\"\n[[output]]\nkind = \"drive\"\n\
    name = \"coin\"\nchannel = 1\ndirection = 2\nactuator = \"coin\"\namplifier = \"b\"\n";

#[test]
fn where_nothing_comes_back_it_says_so() {
    let Some(bench) = Bench::new("nothing") else { return };
    bench.card("loop", "channels 2 played \"@/loop.raw\" loop 1");
    bench.card("hum", "channels 2 heard \"@/hum.raw\"");
    fs::write(bench.folder.join("hum.raw"), tone(50.0, 48_000.0, 20.0)).unwrap();
    let refused = |arguments: &[&str]| {
        let mut all = vec!["latency", "--count", "4"];
        all.extend(arguments);
        let output = bench.run(&all);
        assert!(!output.status.success() && output.stdout.is_empty());
        (output.status.code().unwrap_or(0), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let (code, told) = refused(&["--device", "loop", "--out", "1", "--in", "2"]);
    assert!(code == 74 && told.contains("nothing came back on input 2 of loop: it is silent"), "{told}");
    let (code, told) = refused(&["--device", "loop", "--input-device", "hum", "--out", "1", "--in", "2"]);
    assert!(
        code == 74 && told.contains("nothing came back on input 2 of hum that is like the probe"),
        "{told}"
    );
    let (code, told) = refused(&["--device", "loop", "--out", "3", "--in", "1"]);
    assert!(code == 69 && told.contains("loop has 2 outputs, so none is number 3"), "{told}");
    let (code, told) = refused(&["--device", "loop", "--out", "1", "--in", "3"]);
    assert!(code == 69 && told.contains("loop has 2 inputs, so none is number 3"), "{told}");
    let (code, told) = refused(&["--device", "loop", "--out", "spine", "--in", "1"]);
    assert!(code == 2 && told.contains("there is no output `spine`"), "{told}");
    // The line of a bridge that says which way its motor turns.
    fs::write(bench.folder.join("r.toml"), BRIDGE).unwrap();
    for out in ["1", "2", "coin"] {
        let (code, told) = refused(&["--rig", "r.toml", "--device", "loop", "--out", out, "--in", "1"]);
        assert!(code == 2 && told.contains("`coin`") && told.contains("no probe goes out there"), "{told}");
    }
}

/// A knob between two cards: sine and cosine come in by one, torque leaves by the other, once somebody asks for it.
#[test]
fn a_knob_is_read_by_one_card_and_felt_by_another() {
    let Some(bench) = Bench::new("knob") else { return };
    bench.card("hall", "channels 2 heard \"@/hall.raw\" ppm -120");
    let angle = |n: f64| 0.8 * (TAU * 0.5 * n / 48_000.0).sin();
    let frames = (0..48_000 * 60).flat_map(|n| {
        let (sine, cosine) = angle(f64::from(n)).sin_cos();
        [(0.5 * sine) as f32, (0.5 * cosine) as f32]
    });
    fs::write(bench.folder.join("hall.raw"), frames.flat_map(f32::to_le_bytes).collect::<Vec<u8>>()).unwrap();
    bench.write(
        "spring.toml",
        "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[knob.effects]\nspring = { type = \"spring\", stiffness = 0.004 }\n",
    );
    // Whatever this machine takes, it is granted: what is late falls, and is tried elsewhere.
    bench.write(
        "rig.toml",
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 8\ncoupling = \"dc\"\ninput = \"hall\"\n[[tactor]]\nname = \"t1\"\nchannel = 2\n\
         [[output]]\nkind = \"torque\"\nname = \"knob\"\nchannel = 1\n\
         [knob]\ninertia = 1e-5\nfriction = 1e-3\nviscous = 1e-2\npeak_torque = 0.1\ndelay = 0.4\nstale = 0.1\n\
         output = { name = \"knob\", newton_metres = 0.005 }\n\
         sensor = { type = \"sine-cosine\", sine_channel = 1, cosine_channel = 2 }\n",
    );
    let play = |more: &[&str]| {
        let _ = fs::remove_file(bench.played());
        let mut all = vec!["play", "spring.toml", "--rig", "rig.toml", "--device", "card8", "--block", "512"];
        all.extend(more);
        let output = bench.run(&all);
        assert!(output.status.success(), "{}", said(&output));
        (first_channel(&bench, 8), said(&output))
    };
    let (nothing, told) = play(&["--duration", "1"]);
    assert!(told.contains("it listens to hall: channels 1, 2 of 2 channels"), "{told}");
    assert!(nothing.len() > 40_000 && nothing.iter().all(|x| *x == 0.0), "nobody asked\n{told}");
    for attempt in 0..5 {
        let (torque, told) = play(&["--duration", "6", "--torque"]);
        if attempt < 4 && (told.contains("xrun\n") || told.contains("xruns\n") || told.contains("a gap")) {
            continue;
        }
        let late = &torque[torque.len() - 3 * 48_000..torque.len() - 9_600];
        // 0.8 rad of 0.004 N m/rad, at 0.005 N m for full scale.
        let most = late.iter().fold(0.0, |most: f32, x| most.max(x.abs()));
        assert!((most - 0.64).abs() < 0.02, "{most}\n{told}");
        let rest = residue(late, 48_000.0, 0.5, late.len());
        assert!(rest < 1e-3, "{rest}\n{told}");
        assert!(told.contains("the knob's torque is on") && !told.contains("has fallen"), "{told}");
        break;
    }
}
