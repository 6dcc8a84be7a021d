//! Standard MIDI Files that play patches, through the program: also patches that nobody made for a keyboard, and such as would never end.
#![cfg(feature = "cli")]

mod program;

use program::Scratch;
use serde_json::Value;

/// A track of so many ticks, 480 a second, behind whose messages it ends.
fn song(messages: &[(u8, &[u8])]) -> Vec<u8> {
    let mut track = Vec::new();
    for (delta, message) in messages {
        track.push(*delta);
        track.extend(*message);
    }
    track.extend([0, 0xff, 0x2f, 0]);
    let length = u32::try_from(track.len()).unwrap().to_be_bytes();
    [&b"MThd\0\0\0\x06\0\0\0\x01\0\xf0MTrk"[..], &length, &track].concat()
}

/// A low and a high key for a quarter of a second each, the second one softly.
fn keys() -> Vec<u8> {
    song(&[(0, &[0x90, 45, 100]), (120, &[0x80, 45, 0]), (0, &[0x90, 57, 64]), (120, &[0x80, 57, 0])])
}

const HUM: &str = "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.hum]\noutput = \"o\"\n[voice.hum.nodes]\n\
    tone = { type = \"sine\", frequency = \"event.frequency\" }\nedge = { type = \"envelope\", attack = 0.002, release = 0.01 }\n\
    o = { type = \"multiply\", inputs = [\"tone\", \"edge\"] }\n";

/// Turns a second of what stands in a stretch of seconds, and its largest magnitude.
fn felt(samples: &[f32], from: f64, to: f64) -> (f64, f32) {
    let part = &samples[(from * 48e3) as usize..(to * 48e3) as usize];
    let rises = part.windows(2).filter(|pair| pair[0] < 0.0 && pair[1] >= 0.0).count();
    (rises as f64 / (to - from), part.iter().fold(0.0, |most: f32, x| most.max(x.abs())))
}

#[test]
fn notes_play_a_voice_of_any_patch() {
    let scratch = Scratch::new("songs-any");
    std::fs::write(scratch.0.join("song.mid"), keys()).unwrap();
    scratch.write("p.toml", HUM);
    let told = "nothing in the patch hears MIDI";
    scratch.run(&["check", "p.toml", "--midi", "song.mid"]).succeeds();
    let render = ["render", "p.toml", "--midi", "song.mid", "-o", "x.wav"];
    // Of two voices, it is not known which is meant; where there is one, it is told.
    scratch.write(
        "p.toml",
        format!("{HUM}[voice.two]\noutput = \"s\"\nnodes.s = {{ type = \"sine\", frequency = 100 }}\n"),
    );
    let run = scratch.run(&[&render[..], &["--duration", "0.1"]].concat());
    assert!(
        run.err.contains("so that the song changes nothing") && run.err.contains("--notes VOICE"),
        "{}",
        run.err
    );
    scratch.write("p.toml", HUM);
    let run = scratch.run(&["render", "p.toml", "--midi", "song.mid", "-o", "only.wav"]);
    assert!(run.succeeds().err.contains("the song's notes play its voice `hum`"), "{}", run.err);
    let run = scratch.run(&[&render[..], &["--notes", "hum"]].concat());
    assert!(!run.succeeds().err.contains(told), "{}", run.err);
    let (spec, samples) = scratch.wav("x.wav");
    assert_eq!(scratch.wav("only.wav").1, samples);
    let first: Vec<f32> = samples.chunks(usize::from(spec.channels)).map(|frame| frame[0]).collect();
    // A2 and A3 are 110 and 220 Hz; the velocity is the level.
    let (low, strong) = felt(&first, 0.05, 0.25);
    let (high, soft) = felt(&first, 0.3, 0.5);
    assert!((low - 110.0).abs() < 6.0 && (high - 220.0).abs() < 6.0, "{low} {high}");
    assert!(
        (f64::from(strong) - 100.0 / 127.0).abs() < 0.02 && (f64::from(soft) - 64.0 / 127.0).abs() < 0.02,
        "{strong} {soft}"
    );
    assert!((0.5..0.8).contains(&(first.len() as f64 / 48e3)), "{}", first.len());
    scratch.run(&[&render[..], &["--notes", "hmu"]].concat()).fails(2, &["no voice `hmu`", "`hum`"]);
    scratch.write("p.toml", HUM.replace("output = \"o\"", "output = \"o\"\nstart = \"always\""));
    scratch
        .run(&[&render[..], &["--notes", "hum"]].concat())
        .fails(2, &["--notes: voice `hum` is always on"]);
}

#[test]
fn what_notes_played_is_played_again() {
    let scratch = Scratch::new("songs-again");
    std::fs::write(scratch.0.join("song.mid"), keys()).unwrap();
    scratch.write("p.toml", HUM);
    let play = [
        "play",
        "p.toml",
        "--midi-file",
        "song.mid",
        "--midi-in",
        "none",
        "--notes",
        "hum",
        "--device",
        "virtual",
        "--duration",
        "0.9",
        "--record",
        "x.wav",
        "--events",
        "x.jsonl",
    ];
    let run = scratch.run(&play);
    assert!(run.succeeds().err.contains("hum on"), "{}", run.err);
    let run = scratch.run(&["replay", "x.jsonl", "--against", "x.wav"]);
    assert!(run.succeeds().out.contains("the same, to the bit"), "{}", run.out);
    // What was played leads back to the messages of the song, which stand before it with the samples at which they are due.
    let journal = std::fs::read_to_string(scratch.0.join("x.jsonl")).unwrap();
    let lines: Vec<Value> = journal.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let sung = |line: &Value| line["kind"] == "in" && line["source"] == "song";
    let messages: Vec<&str> =
        lines.iter().filter(|line| sung(line)).map(|line| line["message"].as_str().unwrap()).collect();
    assert_eq!(messages, ["90 2D 64", "80 2D 00", "90 39 40", "80 39 00"]);
    let mut led_back = Vec::new();
    for (n, line) in lines.iter().enumerate() {
        // The end of the session is an answer to no note.
        let Some(cause) = line["cause"].as_u64().filter(|_| line["kind"] != "gate") else { continue };
        let of = |line: &&Value| sung(line) && line["id"].as_u64() == Some(cause);
        let message = lines[..n].iter().find(of).unwrap_or_else(|| panic!("{line}"));
        assert_eq!(lines.iter().filter(of).count(), 1);
        assert_eq!(message["due_sample"], line["due_sample"], "{line}");
        led_back.push((line["kind"].as_str().unwrap(), message["message"].as_str().unwrap()));
    }
    let expected =
        [("voice", messages[0]), ("release", messages[1]), ("voice", messages[2]), ("release", messages[3])];
    assert_eq!(led_back, expected);
}

/// What a note asks for and cannot be had is told as the answer to that note.
#[test]
fn what_a_song_asks_for_in_vain_is_told_with_the_note_that_did() {
    let scratch = Scratch::new("songs-vain");
    std::fs::write(scratch.0.join("song.mid"), keys()).unwrap();
    let vain = "[[trigger]]\non = \"midi.note\"\nplay = \"hum\"\nnotes = [57, 57]\nset = { level = \"1 / (velocity - velocity)\" }\n";
    scratch.write("p.toml", format!("{HUM}{vain}"));
    let play = ["play", "p.toml", "--midi-file", "song.mid", "--midi-in", "none", "--device", "virtual"];
    let run = scratch.run(&[&play[..], &["--duration", "0.9", "--events", "x.jsonl"]].concat());
    run.succeeds();
    let journal = std::fs::read_to_string(scratch.0.join("x.jsonl")).unwrap();
    let lines: Vec<Value> = journal.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let refused: Vec<&Value> = lines.iter().filter(|line| line["kind"] == "refused").collect();
    assert_eq!(refused.len(), 1, "{journal}");
    let of = |line: &&Value| line["id"] == refused[0]["cause"] && line["source"] == "song";
    let message = lines.iter().find(of).unwrap_or_else(|| panic!("{}", refused[0]));
    assert_eq!(message["message"], "90 39 40");
}

/// A pattern, or a voice, without end beside a song is over when that is; so is one that the song begins and does not end.
#[test]
fn a_song_gives_an_endless_patch_its_length() {
    let scratch = Scratch::new("songs-endless");
    std::fs::write(scratch.0.join("song.mid"), keys()).unwrap();
    std::fs::write(scratch.0.join("program.mid"), song(&[(0, &[0xc0, 3]), (120, &[0xc0, 4])])).unwrap();
    let endless = "[pattern.e]\nrepeat = { every = 0.05 }\nevents = [{ at = 0, voice = \"hum\", frequency = 160, duration = 0.02 }]\n";
    let on = |on: &str, play: &str| format!("[[trigger]]\non = \"{on}\"\nplay = \"{play}\"\n");
    let length = |name: &str, patch: String, song: &str| {
        scratch.write("p.toml", patch);
        let run = scratch.run(&["render", "p.toml", "--midi", song, "-o", "x.wav"]);
        run.succeeds();
        let (spec, samples) = scratch.wav("x.wav");
        assert!(samples.iter().any(|x| *x != 0.0), "{name}");
        samples.len() as f64 / f64::from(spec.channels) / 48e3
    };
    let key = on("midi.note", "hum");
    let always = "[voice.a]\nstart = \"always\"\noutput = \"o\"\nnodes.o = { type = \"sine\", frequency = 100, amplitude = 0.1 }\n";
    let held = length("held", format!("{HUM}{endless}{}", on("midi.note", "e")), "song.mid");
    assert!((0.5..0.7).contains(&held), "{held}");
    // That which no key of this song plays does not matter.
    let other = on("midi.note", "e") + "notes = [1, 2]\n";
    let idle = length("idle", format!("{HUM}{endless}{other}{key}"), "song.mid");
    assert!((0.5..0.7).contains(&idle), "{idle}");
    for (name, patch, song, seconds) in [
        ("beside it", format!("{HUM}{endless}{key}{}", on("start", "e")), "song.mid", 0.5),
        ("begun by it", format!("{HUM}{endless}{}", on("midi.program 3", "e")), "program.mid", 0.25),
        ("always on", format!("{HUM}{key}{always}"), "song.mid", 0.5),
    ] {
        assert_eq!(length(name, patch, song), seconds, "{name}");
    }
    // What this song cannot set off is no reason to cut its end.
    let rings = HUM.replace("release = 0.01", "release = 0.5");
    for on in [on("key.1", "e"), on("osc./e", "e"), on("midi.program 9", "e")] {
        let whole = length("rings", format!("{rings}{endless}{on}{key}"), "song.mid");
        assert!(whole > 0.9, "{on}: {whole}");
    }
    std::fs::write(scratch.0.join("empty.mid"), song(&[])).unwrap();
    scratch.write("p.toml", format!("{HUM}{key}{always}"));
    scratch
        .run(&["render", "p.toml", "--midi", "empty.mid", "-o", "x.wav"])
        .fails(2, &["has no length of its own"]);
    // Without the song, it has none.
    scratch.write("p.toml", format!("{HUM}{endless}{}", on("start", "e")));
    scratch
        .run(&["render", "p.toml", "-o", "x.wav"])
        .fails(2, &["repeats without end, so it has no length of its own"]);
}

/// What leaves a card that nobody has described, be it a virtual one, holds no steady voltage.
#[test]
fn a_steady_voltage_leaves_only_where_it_is_declared() {
    let scratch = Scratch::new("songs-steady");
    let patch = "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.push]\nstart = \"always\"\noutput = \"o\"\nplace = [\"t1\", \"t2\"]\n\
        nodes.o = { type = \"add\", inputs = [0.4, 0.0] }\n";
    scratch.write("p.toml", patch);
    let rig = "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\n[[tactor]]\nname = \"t1\"\nchannel = 1\n\
        [[tactor]]\nname = \"t2\"\nchannel = 2\ndc = true\n";
    scratch.write("r.toml", rig);
    let play = [
        "play",
        "p.toml",
        "--rig",
        "r.toml",
        "--device",
        "virtual",
        "--duration",
        "2.5",
        "--record",
        "x.wav",
    ];
    let run = scratch.run(&play);
    assert!(
        run.succeeds().err.contains("does not say whether the card lets steady voltages through"),
        "{}",
        run.err
    );
    let (_, samples) = scratch.wav("x.wav");
    let last = &samples[2 * 96_000..2 * 100_800];
    let mean = |channel: usize| {
        let all: Vec<f64> = last.chunks(2).map(|frame| f64::from(frame[channel])).collect();
        all.iter().sum::<f64>() / all.len() as f64
    };
    assert!(mean(0).abs() < 1e-4 && (mean(1) - 0.4).abs() < 0.02, "{} {}", mean(0), mean(1));
}

/// A song has no fader that stands somewhere: what it says of a control counts at once, also where a fader would have to pick it up.
#[test]
fn a_song_moves_controls_without_picking_them_up() {
    let scratch = Scratch::new("songs-pickup");
    let strong = "[control.strength]\ndefault = 0.9\nrange = [0, 1]\nsmoothing = 0\n[[bind]]\nfrom = \"midi.controller 7\"\ncontrol = \"strength\"\n\
        [[trigger]]\non = \"midi.note\"\nplay = \"hum\"\nset = { level = 1, frequency = 100 }\n";
    scratch
        .write("p.toml", HUM.replace("[\"tone\", \"edge\"]", "[\"tone\", \"edge\", \"strength\"]") + strong);
    std::fs::write(
        scratch.0.join("song.mid"),
        song(&[(0, &[0xb0, 7, 32]), (0, &[0x90, 45, 100]), (120, &[0x80, 45, 0])]),
    )
    .unwrap();
    scratch.run(&["render", "p.toml", "--midi", "song.mid", "-o", "x.wav"]).succeeds();
    let (spec, samples) = scratch.wav("x.wav");
    let first: Vec<f32> = samples.chunks(usize::from(spec.channels)).map(|frame| frame[0]).collect();
    let (_, peak) = felt(&first, 0.05, 0.25);
    assert!((f64::from(peak) - 32.0 / 127.0).abs() < 0.02, "{peak}");
}

/// Notes are spread over what can be felt: outputs that give pulses or torque have none.
#[test]
fn notes_are_spread_over_tactors_alone() {
    let scratch = Scratch::new("songs-spread");
    let rig = "format = \"pacinian-rig/1\"\n[device]\nchannels = 3\nrate = 48000\n[[output]]\nkind = \"trigger\"\nname = \"eeg\"\nchannel = 1\n\
        [[tactor]]\nname = \"a\"\nchannel = 2\n[[tactor]]\nname = \"b\"\nchannel = 3\n";
    scratch.write("r.toml", rig);
    let spread = "[[trigger]]\non = \"midi.note\"\nplay = \"hum\"\nset = { level = 1, frequency = 100 }\nspread = \"notes\"\n";
    scratch.write("p.toml", format!("{HUM}{spread}"));
    std::fs::write(scratch.0.join("song.mid"), keys()).unwrap();
    scratch.run(&["render", "p.toml", "--rig", "r.toml", "--midi", "song.mid", "-o", "x.wav"]).succeeds();
    let (_, samples) = scratch.wav("x.wav");
    let peak =
        |channel: usize| samples.iter().skip(channel).step_by(3).fold(0.0, |most: f32, x| most.max(x.abs()));
    // 45 and 57 are odd: the second of two.
    assert_eq!((peak(0), peak(1)), (0.0, 0.0));
    assert!(peak(2) > 0.9, "{}", peak(2));
}
