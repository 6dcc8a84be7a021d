//! Playing on a sound card that ALSA drives: one in user space that keeps real time and writes down what it is given.
//!
//! The card is built from `tests/devices/card.c`. Where there is no C compiler or no ALSA, a test says that it was skipped, and why.
#![cfg(target_os = "linux")]

#[path = "common/bench.rs"]
mod bench;

use std::fs;
use std::time::Duration;

use bench::{Bench, HUM, Playing, floats, scene, signal, wait};

#[test]
fn the_card_is_listed_with_what_it_offers() {
    let Some(bench) = Bench::new("list") else { return };
    let output = bench.run(&["devices", "--json"]);
    assert!(output.status.success());
    let said: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let all: Vec<_> =
        said["hosts"].as_array().unwrap().iter().flat_map(|h| h["devices"].as_array().unwrap()).collect();
    let card = all.iter().find(|d| d["name"] == "Card of 24 channels").unwrap_or_else(|| panic!("{said:#}"));
    assert_eq!(card["output"]["channels"], serde_json::json!([24]));
    let rates = [44_100, 48_000, 88_200, 96_000, 192_000].map(|rate| [rate, rate]);
    assert_eq!(card["output"]["rates"], serde_json::json!(rates));
    // What a program wants to know before it plays.
    assert_eq!(said["pacinian"], env!("CARGO_PKG_VERSION"));
    let advice = said["advice"].as_array().unwrap();
    let none = advice.iter().any(|a| a["what"].as_str().unwrap().contains("no real-time priority"));
    assert_eq!(said["real_time_priority"], !none, "{said:#}");
}

#[test]
fn the_virtual_card_is_marked_where_nothing_else_is_played_on_by_default() {
    let Some(bench) = Bench::new("fallback") else { return };
    bench.write("hum.toml", HUM);
    for there in [false, true] {
        if there {
            bench.card("!default", "channels 8 played \"@/played.raw\"");
        }
        let listed = bench.run(&["devices", "--json"]);
        let said: serde_json::Value = serde_json::from_slice(&listed.stdout).unwrap();
        let text = String::from_utf8(bench.run(&["devices"]).stdout).unwrap();
        let played = bench.run(&["play", "hum.toml", "--duration", "0.1"]);
        let falls_back = String::from_utf8_lossy(&played.stderr).contains("virtual card");
        assert_eq!(said["virtual"]["default"], serde_json::json!(falls_back), "{there}: {said:#}");
        assert_eq!(text.contains("  * keeps real time"), falls_back, "{there}: {text}");
        let usual = if there { "alsa:default" } else { "virtual" };
        assert_eq!(said["default_output"], usual, "{said:#}");
        assert_eq!(text.contains("played by default: alsa:default\n"), there, "{text}");
        assert!(!(there && falls_back), "{}", String::from_utf8_lossy(&played.stderr));
        // Of no server is it said twice that it does not run.
        let text = text.to_lowercase();
        for server in ["pipewire", "pulseaudio", "jack"] {
            assert!(text.matches(&format!("{server}: does not run")).count() <= 1, "{text}");
        }
    }
}

#[test]
fn twenty_four_channels_arrive_as_they_would_be_rendered() {
    let Some(bench) = Bench::new("exact") else { return };
    scene(&bench.folder, 24);
    let rendered =
        bench.run(&["render", "patch.toml", "--rig", "rig.toml", "-o", "offline.wav", "--duration", "1.2"]);
    assert!(rendered.status.success(), "{}", String::from_utf8_lossy(&rendered.stderr));
    // A gap drops a block, on this machine or that; then it is tried again.
    for attempt in 0..5 {
        let _ = fs::remove_file(bench.played());
        let arguments = [
            "play",
            "patch.toml",
            "--rig",
            "rig.toml",
            "--device",
            "card24",
            "--block",
            "512",
            "--duration",
            "2",
        ];
        let played = bench.run(&arguments);
        let said =
            String::from_utf8_lossy(&played.stdout).into_owned() + &String::from_utf8_lossy(&played.stderr);
        assert!(played.status.success(), "{said}");
        if !said.contains(" 0 xruns") && attempt < 4 {
            continue;
        }
        let wav = fs::read(bench.folder.join("offline.wav")).unwrap();
        let data = wav.windows(4).position(|w| w == b"data").unwrap() + 8;
        let offline: Vec<f32> =
            wav[data..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        let online = bench.samples();
        // What plays from the beginning waits for the ramp of 200 ms.
        let lead = 24 * 9600;
        let last = offline.len().min(24 * 57_000);
        assert!(online.len() >= lead + last, "{} samples of {last}", online.len());
        assert!(online[..lead].iter().all(|x| *x == 0.0) && offline[..last].iter().any(|x| x.abs() > 0.3));
        let differs = (0..last).find(|&n| online[lead + n].to_bits() != offline[n].to_bits());
        assert_eq!(differs, None, "{said}");
        return;
    }
}

#[test]
fn a_card_that_is_pulled_and_plugged_in_again_is_found_and_no_other() {
    let Some(bench) = Bench::new("pulled") else { return };
    bench.write("hum.toml", HUM);
    let child = bench.start(&["play", "hum.toml", "--device", "card8", "--block", "256"]);
    let length = || fs::metadata(bench.played()).map_or(0, |about| about.len());
    for _ in 0..3 {
        let before = length();
        wait("sound", || length() > before + 8 * 4 * 24_000);
        fs::write(bench.gone(), "").unwrap();
        std::thread::sleep(Duration::from_millis(500));
        let silent = length();
        std::thread::sleep(Duration::from_millis(200));
        assert_eq!(length(), silent, "nothing is played on a card that is gone");
        fs::remove_file(bench.gone()).unwrap();
        wait("the card's return", || length() > silent);
    }
    let before = length();
    wait("sound", || length() > before + 8 * 4 * 12_000);
    signal(&child, "INT");
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{said}");
    assert_eq!(
        (said.matches("the device is gone").count(), said.matches("the device is back").count()),
        (3, 3),
        "{said}"
    );
    // The output ended in exact zeros.
    let samples = bench.samples();
    assert!(samples[samples.len() - 8 * 100..].iter().all(|x| *x == 0.0));
    assert!(samples.iter().any(|x| x.abs() > 0.45));
    // It never jumped: 0.5 times the slope of 100 Hz is 0.0066 a frame, and ramps of 2 ms add 0.5 / 96 each frame.
    let channel: Vec<f32> = samples.iter().step_by(8).copied().collect();
    let within_a_stream = |w: &[f32]| (w[1] - w[0]).abs() < 0.03;
    let jumps = channel.windows(2).filter(|w| !within_a_stream(w)).count();
    // Where the card was pulled, what it had not played yet is lost; and a block with every gap.
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    let gaps = told.split(" over their time, ").nth(1).and_then(|s| s.split(' ').next()?.parse().ok());
    let gaps: usize = gaps.unwrap_or_else(|| panic!("no gaps are told\n{told}"));
    assert!(jumps <= 3 + 2 * gaps, "{jumps} jumps, {gaps} gaps");
}

/// A program that the system halts gives its card nothing to play: ALSA tells of the gap, and from then on frames belong to other moments.
#[test]
fn a_gap_of_a_card_is_counted_and_times_line_up_behind_it() {
    const HALT: f64 = 0.5;
    let Some(bench) = Bench::new("gap") else { return };
    bench.write("hum.toml", HUM);
    let play = ["play", "hum.toml", "--device", "card8", "--block", "512", "--events", "j.jsonl"];
    let child = bench.start(&[&play[..], &["--record", "sent.wav"]].concat());
    let length = || fs::metadata(bench.played()).map_or(0, |about| about.len());
    wait("sound", || length() > 8 * 4 * 96_000);
    let begin = std::time::Instant::now();
    signal(&child, "STOP");
    std::thread::sleep(Duration::from_secs_f64(HALT));
    signal(&child, "CONT");
    let halted = begin.elapsed().as_secs_f64();
    let before = length();
    wait("sound again", || length() > before + 8 * 4 * 96_000);
    signal(&child, "INT");
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(130) && !said.contains("is gone"), "{said}");
    let journal = fs::read_to_string(bench.folder.join("j.jsonl")).unwrap();
    let lines: Vec<serde_json::Value> =
        journal.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    // The first may stand before anything was asked for.
    let told = |line: &&serde_json::Value| line["kind"] == "clock" && line["frame"].is_number();
    let clocks: Vec<_> = lines.iter().filter(told).collect();
    // By how many seconds a moment is behind its frame, and gaps so far.
    let [first, last] = [clocks[0], clocks[clocks.len() - 1]].map(|line| {
        let of = |value: &serde_json::Value| value.as_f64().unwrap_or_else(|| panic!("{line}"));
        (of(&line["seconds"]) - of(&line["frame"]) / 48_000.0, of(&line["fields"]["xruns"]))
    });
    assert!(last.1 > first.1, "no gap was told: {first:?} {last:?}");
    // What the card had in its buffer it has played meanwhile; gaps that the machine makes by itself come on top.
    let behind = last.0 - first.0;
    let buffered = 2.0 * 512.0 / 48_000.0;
    assert!(behind > HALT - buffered - 0.02, "{behind} s, {first:?} {last:?}");
    assert!(behind < halted + 0.2 || last.1 - first.1 > 1.0, "{behind} s of {halted} s, {first:?} {last:?}");
    // What was sent is known all the same, without a gap.
    let again = bench.run(&["replay", "j.jsonl", "--against", "sent.wav"]);
    assert!(again.status.success(), "{}", String::from_utf8_lossy(&again.stderr));
}

/// The thread that a card calls back in asks to run before all others, and where the system allows that it does.
#[test]
fn the_callback_of_a_card_runs_in_real_time_where_the_system_allows_it() {
    let Some(bench) = Bench::new("fifo") else { return };
    bench.write("hum.toml", HUM);
    let listed = bench.run(&["devices", "--json"]);
    let listed: serde_json::Value = serde_json::from_slice(&listed.stdout).unwrap();
    if listed["real_time_priority"] != true {
        return bench::skipped("the system gives no real-time priority");
    }
    let child = bench.start(&["play", "hum.toml", "--device", "card8"]);
    wait("sound", || bench.samples().iter().any(|x| x.abs() > 0.2));
    // Of each thread its priority in real time and its policy, of which 1 is SCHED_FIFO: the fields 40 and 41 of what the system says.
    let tasks = fs::read_dir(format!("/proc/{}/task", child.id())).unwrap();
    let stat = |task: fs::DirEntry| fs::read_to_string(task.path().join("stat")).unwrap_or_default();
    let of = |stat: String| {
        let fields: Vec<u32> = stat
            .rsplit(')')
            .next()?
            .split_whitespace()
            .skip(1)
            .map(|field| field.parse().unwrap_or(0))
            .collect();
        Some((*fields.get(36)?, *fields.get(37)?))
    };
    let threads: Vec<_> = tasks.filter_map(|task| of(stat(task.ok()?))).collect();
    signal(&child, "INT");
    child.wait_with_output().unwrap();
    let first = threads.iter().filter(|(_, policy)| *policy == 1).map(|(priority, _)| *priority).max();
    // What feeds it is below, so the highest is its own.
    let feeding = threads.iter().filter(|(priority, policy)| *policy == 1 && Some(*priority) < first).count();
    assert!(first.is_some() && feeding > 0, "{threads:?}");
}

/// Whoever names what ALSA plays on by default has not said which card that is.
#[test]
fn a_default_that_is_named_is_at_a_tenth() {
    let Some(bench) = Bench::new("alias") else { return };
    bench.write("hum.toml", HUM);
    bench.card("!default", "channels 8 played \"@/played.raw\"");
    for (device, lowered) in
        [("default", true), ("Default", true), ("alsa:default", true), ("ALSA", true), ("alsa:card8", false)]
    {
        let played = bench.run(&["play", "hum.toml", "--device", device, "--duration", "0.1"]);
        let said = String::from_utf8_lossy(&played.stderr);
        assert!(played.status.success(), "{device}: {said}");
        assert_eq!(said.contains("at -20 dB: --arm"), lowered, "{device}: {said}");
    }
}

/// The default of ALSA is opened as it was where the stream only broke off; where the card itself was away, another may have its place.
#[test]
fn a_default_stream_that_breaks_off_comes_back_at_its_level_and_one_whose_card_was_away_does_not() {
    breaks("broken", false);
}

/// A server may be behind it, and have died: whatever is there then was not asked for.
#[test]
fn a_default_stream_that_breaks_off_where_a_server_runs_does_not_come_back_at_its_level() {
    breaks("broken-server", true);
}

fn breaks(name: &str, served: bool) {
    let Some(bench) = Bench::new(name) else { return };
    if served {
        // Somebody answers there, and has nothing to say.
        let server = std::os::unix::net::UnixListener::bind(bench.folder.join("pipewire-0")).unwrap();
        std::thread::spawn(move || server.incoming().for_each(drop));
    }
    bench.write("hum.toml", HUM);
    bench.card("!default", "channels 8 played \"@/played.raw\" gone \"@/gone\" broken \"@/broken\"");
    let mut play = bench.command(&["play", "hum.toml", "--arm", "--block", "256"]);
    for name in ["PULSE_SERVER", "PULSE_RUNTIME_PATH", "PIPEWIRE_RUNTIME_DIR", "PIPEWIRE_REMOTE"] {
        play.env_remove(name);
    }
    play.env("XDG_RUNTIME_DIR", &bench.folder);
    let mut playing = Playing::start(play, bench.folder.join("told"));
    let length = || fs::metadata(bench.played()).map_or(0, |about| about.len());
    // The largest sample of the second half of what is played from now on.
    let peak = || {
        let before = length();
        wait("sound", || length() > before + 8 * 4 * 48_000);
        let samples = bench.samples();
        samples[samples.len() - 8 * 12_000..].iter().fold(0.0_f32, |most, x| most.max(x.abs()))
    };
    assert!(peak() > 0.45, "{}", playing.text());
    for flag in if served { &["broken"][..] } else { &["broken", "broken", "gone"] } {
        let before = playing.says("the device is gone");
        fs::write(bench.folder.join(flag), "").unwrap();
        wait("the loss", || playing.says("the device is gone") > before);
        fs::remove_file(bench.folder.join(flag)).unwrap();
        // It may have been opened in between, and have broken off once more.
        wait("its return", || playing.says("the device is back") == playing.says("the device is gone"));
        let (peak, text) = (peak(), playing.text());
        if text.contains("does not ask for anything") {
            bench::skipped("the machine stood still for so long that the card was taken for lost");
            return;
        }
        let lowered = served || *flag == "gone";
        assert_eq!(peak < 0.06, lowered, "{flag}: {peak}, {text}");
        assert!(lowered || peak > 0.45, "{flag}: {peak}, {text}");
        assert!(*flag == "gone" || text.contains("a larger --block helps"), "{text}");
    }
    playing.interrupt();
}

/// Without a rig, or with one that says nothing of it, nobody has said that the card may get a steady voltage; and a replay knows that
/// nobody had.
#[test]
fn nothing_steady_leaves_on_a_card_that_nobody_has_described() {
    let Some(bench) = Bench::new("undescribed") else { return };
    bench.write(
        "steady.toml",
        "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nstart = \"always\"\noutput = \"o\"\n[voice.v.nodes]\n\
         e = { type = \"envelope\", attack = 0.01 }\no = { type = \"multiply\", inputs = [\"e\", 0.5] }\n",
    );
    let rig = |said: &str| {
        let tactors = (1..=8).map(|n| format!("[[tactor]]\nname = \"t{n}\"\nchannel = {n}\n"));
        let tactors: String = tactors.collect();
        format!("format = \"pacinian-rig/1\"\n[device]\nchannels = 8\n{said}\n{tactors}")
    };
    bench.write("silent.toml", &rig(""));
    bench.write("coupled.toml", &rig("coupling = { high_pass = 8 }"));
    for (rig, stays, noted) in
        [(None, false, false), (Some("silent.toml"), false, true), (Some("coupled.toml"), true, false)]
    {
        let play = ["play", "steady.toml", "--device", "card8", "--duration", "2"];
        for file in ["sent.wav", "j.jsonl", "again.wav"] {
            let _ = std::fs::remove_file(bench.folder.join(file));
        }
        let keep = ["--record", "sent.wav", "--events", "j.jsonl"];
        let named = rig.map_or(Vec::new(), |rig| vec!["--rig", rig]);
        let run = bench.run(&[&play[..], &keep[..], &named[..]].concat());
        let told = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "{told}");
        assert_eq!(told.contains("steady voltages"), noted, "{rig:?}: {told}");
        let sent = floats(&bench.folder.join("sent.wav"));
        let first: Vec<f32> = sent.iter().step_by(8).copied().collect();
        assert!(first.iter().any(|x| *x > 0.05), "{rig:?}: it begins");
        let lasts = first[84_000..90_000].iter().all(|x| x.abs() > 0.04);
        let is_gone = first[84_000..90_000].iter().all(|x| x.abs() < 1e-3);
        assert_eq!((lasts, is_gone), (stays, !stays), "{rig:?}: {}", first[84_000]);
        let journal = std::fs::read_to_string(bench.folder.join("j.jsonl")).unwrap();
        let lines: Vec<serde_json::Value> =
            journal.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let (head, end) = (&lines[0], &lines[lines.len() - 1]);
        assert_eq!(
            (&head["device"], &head["device_id"]),
            (&"Card of 8 channels".into(), &"alsa:card8".into())
        );
        assert!(end["fields"]["block"].as_f64().is_some_and(|block| block > 0.0), "{end}");
        let run = bench.run(&["replay", "j.jsonl", "-o", "again.wav"]);
        assert!(run.status.success(), "{rig:?}: {}", String::from_utf8_lossy(&run.stderr));
        let again = floats(&bench.folder.join("again.wav"));
        let same = sent.iter().zip(&again).all(|(a, b)| a.to_bits() == b.to_bits());
        assert!(sent.len() == again.len() && same, "{rig:?}");
    }
}

#[test]
fn what_a_card_does_not_offer_is_refused_with_what_it_does() {
    let Some(bench) = Bench::new("refused") else { return };
    scene(&bench.folder, 6);
    let of = |arguments: &[&str]| {
        let mut all = vec!["play", "patch.toml", "--rig", "rig.toml", "--duration", "1"];
        all.extend(arguments);
        let output = bench.run(&all);
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let own = bench.run(&["play", "patch.toml", "--duration", "0.1"]);
    let told = String::from_utf8_lossy(&own.stderr).into_owned();
    assert!(own.status.success() && told.contains("of no sound card that it is the usual one"), "{told}");
    // A build that does not speak with it, or a server that does not run.
    let (code, said) = of(&["--device", "jack:system"]);
    let why = if cfg!(feature = "jack") { "JACK does not run" } else { "does not speak with JACK itself" };
    assert!(code == Some(69) && said.contains(why) && said.contains("help"), "{said}");
    let (code, said) = of(&["--device", "card8"]);
    assert!(
        code == Some(69) && said.contains("6 channels are not offered") && said.contains("it offers 8"),
        "{said}"
    );
    let (code, said) = of(&["--device", "card9"]);
    assert!(
        code == Some(69) && said.contains("there is no device `card9`") && said.contains("Card of 8"),
        "{said}"
    );
    let (code, said) = of(&["--device", "card"]);
    assert!(code == Some(69) && said.contains("may be"), "{said}");
    scene(&bench.folder, 8);
    let (code, said) = of(&["--device", "card8", "--block", "60000"]);
    assert!(code == Some(69) && said.contains("blocks of 60000 frames are not offered"), "{said}");
    // Below what it has, and between.
    for rate in ["22050", "50000"] {
        let (code, said) = of(&["--device", "card8", "--rate", rate]);
        assert!(code == Some(69) && said.contains(&format!("{rate} Hz are not offered")), "{said}");
        assert!(said.contains("it offers 44100, 48000, 88200, 96000, 192000 Hz: --rate"), "{said}");
    }
    fs::write(bench.gone(), "").unwrap();
    let (code, said) = of(&["--device", "card8"]);
    assert!(code == Some(69), "{said}");
}

/// A card that is there and cannot be opened is told of as what it is, with what helps; none of them is said not to be there.
#[test]
fn a_card_that_cannot_be_opened_is_told_of_with_the_reason() {
    let Some(bench) = Bench::new("shut") else { return };
    bench.write("hum.toml", HUM);
    let kinds: [(u32, i32, &[&str]); 5] = [
        // EACCES, EBUSY, EIO, ENOMEM, EINVAL.
        (13, 77, &["sudo usermod -aG audio $USER"]),
        (16, 75, &["close the program that plays on it"]),
        (5, 74, &["snd_pcm_open", "(5)", "plug it in again"]),
        (12, 74, &["snd_pcm_open", "(12)", "plug it in again"]),
        (22, 69, &["does not support output", "`pacinian devices` lists"]),
    ];
    for (number, ..) in kinds {
        bench.card(&format!("shut{number}"), &format!("channels 2 fails {number}"));
    }
    for (number, code, words) in kinds {
        let name = format!("shut{number}");
        for device in [name.clone(), format!("alsa:{name}")] {
            let played = bench.run(&["play", "hum.toml", "--device", &device, "--duration", "0.1"]);
            let said = String::from_utf8_lossy(&played.stderr).into_owned();
            assert_eq!(played.status.code(), Some(code), "{device}: {said}");
            assert!(said.contains(&name) && !said.contains("there is no device"), "{device}: {said}");
            assert!(words.iter().all(|word| said.contains(word)), "{device}: {said}");
        }
    }
    // One that takes what it is given as fast as it comes is let go of; the session goes on, as long as it was to.
    let config = bench.folder.join("asound.conf");
    let text = fs::read_to_string(&config).unwrap()
        + "pcm.rush { type file slave.pcm \"null\" file \"/dev/null\" }\n";
    fs::write(config, text).unwrap();
    let played = bench.run(&["play", "hum.toml", "--device", "alsa:rush", "--duration", "1.5"]);
    let said = String::from_utf8_lossy(&played.stderr).into_owned();
    assert!(said.contains("nothing keeps time on it") && !said.contains("is back"), "{said}");
    // Of those that are listed it is said; the others may be converters.
    let listed = bench.run(&["devices"]);
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    let row = |name: &str| listed.lines().find(|line| line.contains(name)).unwrap_or("").to_string();
    assert!(row("shut13").contains("not allowed") && row("shut16").contains("in use"), "{listed}");
    for (name, help) in [("shut13", "sudo usermod -aG audio"), ("shut16", "close the program")] {
        let line = |line: &str| line.contains(&format!("{name}: ")) && line.contains(help);
        assert!(listed.lines().any(line), "{name}: {listed}");
    }
    assert!(["shut5", "shut12", "shut22"].iter().all(|name| row(name).is_empty()), "{listed}");
    // Where no card is named, the virtual one plays, and it is said why.
    for (number, why) in [
        (13, "this user may not play on the sound card"),
        (16, "another program plays on the sound card"),
        (5, "the sound card cannot be opened"),
    ] {
        let Some(bench) = Bench::new(&format!("shut-{number}")) else { return };
        bench.write("hum.toml", HUM);
        bench.card("!default", &format!("channels 2 fails {number}"));
        let played = bench.run(&["play", "hum.toml", "--duration", "0.1"]);
        let said = String::from_utf8_lossy(&played.stderr).into_owned();
        assert!(played.status.success() && said.contains(why), "{number}: {said}");
    }
}

/// What a card still holds when the output is shut is said in milliseconds: it has two periods, of which it has played a part.
#[test]
fn what_a_card_still_holds_at_the_end_is_of_its_buffers_size() {
    let Some(bench) = Bench::new("held") else { return };
    bench.write("hum.toml", HUM);
    let held = |block: &str| -> f64 {
        let play = ["play", "hum.toml", "--device", "card8", "--block", block, "--duration", "0.5"];
        let played = bench.run(&play);
        let said = String::from_utf8_lossy(&played.stdout).into_owned();
        assert!(played.status.success(), "{said}");
        let held = said.split_once("when the output was shut, the device still held ");
        held.and_then(|(_, rest)| rest.split_once(" ms")?.0.parse().ok()).unwrap_or_else(|| panic!("{said}"))
    };
    // Periods of 85.3 ms and of 21.3 ms. When a callback comes, one is left, and what the machine was late is gone from it: where that
    // was much, it is tried again.
    for (block, period) in [("4096", 85.4), ("1024", 21.4)] {
        let mut told = Vec::new();
        let fits = (0..5).any(|_| {
            let held = held(block);
            assert!(held <= 2.0 * period, "{block}: {held} ms");
            told.push(held);
            held >= 0.6 * period
        });
        assert!(fits, "{block}: {told:?} ms");
    }
}

const WALKED: &str = "format = \"pacinian-rig/1\"\n[device]\nchannels = 8\n[[tactor]]\nname = \"a\"\nchannel = 1\n\
    [[tactor]]\nname = \"b\"\nchannel = 2\n[[output]]\nkind = \"torque\"\nname = \"knob\"\nchannel = 3\n\
    [[tactor]]\nname = \"c\"\nchannel = 7\ngain = 0.5\n";

#[test]
fn a_walk_moves_one_channel_after_the_other_and_never_a_torque() {
    let Some(bench) = Bench::new("walk") else { return };
    bench.write("r.toml", WALKED);
    let arguments =
        ["walk", "--rig", "r.toml", "--device", "card8", "--all", "--seconds", "0.2", "--level", "0.3"];
    let output = bench.run(&arguments);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let samples = bench.samples();
    let mut before = 0;
    for channel in 0..8 {
        let own: Vec<f32> = samples.iter().skip(channel).step_by(8).copied().collect();
        let sounding = |x: &f32| x.abs() > 1e-4;
        let (first, last) = (own.iter().position(sounding), own.iter().rposition(sounding));
        if channel == 2 {
            assert!(own.iter().all(|x| *x == 0.0), "the knob");
            continue;
        }
        let (first, last) = (first.unwrap(), last.unwrap());
        assert!(first > before && last < first + 16_000, "channel {}: {first} to {last}", channel + 1);
        before = last;
        let peak = own.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        let wanted = if channel == 6 { 0.15 } else { 0.3 };
        assert!((peak / wanted - 1.0).abs() < 0.1, "channel {}: {peak}", channel + 1);
    }
}

#[test]
fn a_walk_that_is_stopped_ends_in_zeros() {
    let Some(bench) = Bench::new("walk-stop") else { return };
    bench.write("r.toml", WALKED);
    let child = bench.start(&["walk", "--rig", "r.toml", "--device", "card8", "--seconds", "10"]);
    wait("sound", || bench.samples().iter().any(|x| x.abs() > 0.2));
    signal(&child, "INT");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
    let samples = bench.samples();
    assert!(samples[samples.len() - 8 * 100..].iter().all(|x| *x == 0.0));
}

#[test]
fn a_card_that_comes_and_goes_a_hundred_times_is_played_on_each_time() {
    let Some(bench) = Bench::new("hundred") else { return };
    bench.write(
        "hum.toml",
        "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nstart = \"always\"\noutput = \"s\"\n[voice.v.nodes]\n\
         s = { type = \"sine\", frequency = 100, amplitude = 0.5 }\n",
    );
    let child = bench.start(&["play", "hum.toml", "--device", "card8", "--block", "256"]);
    let length = || fs::metadata(bench.played()).map_or(0, |about| about.len());
    wait("sound", || length() > 8 * 4 * 4_800);
    for _ in 0..100 {
        fs::write(bench.gone(), "").unwrap();
        // Until nothing comes any more.
        wait("silence", || {
            let before = length();
            std::thread::sleep(Duration::from_millis(20));
            length() == before
        });
        let silent = length();
        fs::remove_file(bench.gone()).unwrap();
        wait("the card's return", || length() > silent + 8 * 4 * 4_800);
    }
    signal(&child, "INT");
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(130), "{said}");
    let times = (said.matches("the device is gone").count(), said.matches("the device is back").count());
    assert_eq!(times, (100, 100));
    let samples = bench.samples();
    assert!(samples[samples.len() - 8 * 100..].iter().all(|x| *x == 0.0), "it ends in silence");
}

/// Ctrl-C, once or passed on a second time at once: the card gets exact zeros at the end, and the recording is whole.
#[test]
fn a_signal_that_comes_twice_ends_in_zeros_and_finished_files() {
    let Some(bench) = Bench::new("twice") else { return };
    bench.write("hum.toml", HUM);
    for (run, gap) in [None, Some(0), Some(1), Some(4)].into_iter().enumerate() {
        let _ = fs::remove_file(bench.played());
        let record = format!("sent{run}.wav");
        let play = ["play", "hum.toml", "--device", "card8", "--block", "64", "--record", &record];
        let child = bench.start(&play);
        wait("sound", || bench.samples().iter().any(|x| x.abs() > 0.4));
        signal(&child, "INT");
        if let Some(gap) = gap {
            std::thread::sleep(Duration::from_millis(gap));
            // It may be over already.
            let _ = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
        }
        let output = child.wait_with_output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned();
        assert_eq!(output.status.code(), Some(130), "{gap:?}: {said}");
        assert!(said.contains("when the output was shut, the device still held "), "{gap:?}: {said}");
        let samples = bench.samples();
        assert!(samples[samples.len() - 8 * 16..].iter().all(|x| *x == 0.0), "{gap:?}");
        let sent = floats(&bench.folder.join(record));
        assert!(sent.len() > 8 * 4800 && sent.iter().any(|x| x.abs() > 0.4), "{gap:?}: {}", sent.len());
        let first: Vec<f32> = sent.iter().step_by(8).copied().collect();
        let loud = first.iter().rposition(|x| x.abs() > 0.4).unwrap();
        let last = first.iter().rposition(|x| *x != 0.0).unwrap();
        // 5 ms, and half a period of 100 Hz in which it need not have been loud.
        assert!(last - loud <= 240 + 240 && last + 1 < first.len(), "{gap:?}: {} frames", last - loud);
    }
}

/// A probe that falls into a time in which the card is away is played again when that is back.
#[test]
fn a_walk_waits_for_a_card_that_is_away() {
    let Some(bench) = Bench::new("away") else { return };
    let child = bench.start(&["walk", "--device", "card8", "--seconds", "0.3", "--only", "1", "--only", "2"]);
    let loud = |channel: usize| bench.samples().iter().skip(channel).step_by(8).any(|x| x.abs() > 0.1);
    wait("the first channel", || loud(0));
    fs::write(bench.gone(), "").unwrap();
    std::thread::sleep(Duration::from_millis(1500));
    assert!(!loud(1), "nothing is played on a card that is gone");
    fs::remove_file(bench.gone()).unwrap();
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{said}");
    assert!(said.contains("again: channel 1"), "{said}");
    assert!(loud(1), "{said}");
}

#[test]
fn a_sound_system_that_does_not_answer_is_told_of_and_waited_for() {
    let Some(bench) = Bench::new("stuck") else { return };
    // Who opens the card waits for who reads the pipe.
    let pipe = bench.folder.join("pipe");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    bench.card("stuck", "channels 2 played \"@/pipe\"");
    bench.write("hum.toml", HUM);
    let start =
        |name: &str, arguments: &[&str]| Playing::start(bench.command(arguments), bench.folder.join(name));
    let mut asked = start("devices", &["devices"]);
    let mut played = start("play", &["play", "hum.toml", "--device", "card8", "--duration", "0.2"]);
    for one in [&mut asked, &mut played] {
        wait("a word", || one.says("a sound system does not answer yet; Ctrl-C gives up") == 1);
        assert!(one.goes_on(), "{}", one.text());
    }
    // It answers after all, each time that it is asked.
    let reader = fs::File::open(&pipe).unwrap();
    wait("the list", || !asked.goes_on());
    wait("the end", || !played.goes_on());
    assert!(played.says("plays on Card of 8 channels") == 1, "{}", played.text());
    drop(reader);
}

/// A card that has another rate than anybody asked for: recordings are brought to what its engine reads, in the session as in a replay of it.
#[test]
fn a_recording_on_a_card_of_another_rate_is_played_again_to_the_bit() {
    for rate in ["44100", "88200"] {
        let Some(bench) = Bench::new(&format!("rate-{rate}")) else { return };
        bench.card("odd", &format!("channels 2 rates {rate} played \"@/played.raw\""));
        let felt = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("patches/recordings/felt.wav");
        fs::copy(felt, bench.folder.join("felt.wav")).unwrap();
        bench.write(
            "p.toml",
            "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.rub]\noutput = \"s\"\n\
             nodes.s = { type = \"sample\", file = \"felt.wav\" }\n\
             [pattern.p]\nevents = [{ at = 0, voice = \"rub\", duration = 0.3 }]\nrepeat = { every = 0.4 }\n",
        );
        let play = ["play", "p.toml", "--device", "alsa:odd", "--duration", "1", "--events", "s.csv"];
        let played = bench.run(&[&play[..], &["--record", "s.wav"]].concat());
        let said = String::from_utf8_lossy(&played.stderr);
        assert!(played.status.success() && said.contains(&format!("{rate} Hz")), "{said}");
        let again = bench.run(&["replay", "s.csv", "--against", "s.wav"]);
        let said = String::from_utf8_lossy(&again.stdout);
        assert!(again.status.success() && said.contains("the same, to the bit"), "{rate}: {said}");
    }
}
