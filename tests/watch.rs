//! What is saved while it plays takes over; what is broken does not, and says where.
#![cfg(feature = "cli")]

mod program;
#[cfg(target_os = "linux")]
mod seat;

use std::fs;
use std::io::Read;
use std::process::{Child, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use program::Scratch;

const PATCH: &str = "format = \"pacinian-patch/1\"\ntitle = \"first\"\n[control.depth]\ndefault = 0.25\n\
    [voice.hum]\nstart = \"always\"\noutput = \"s\"\n[voice.hum.nodes]\n\
    s = { type = \"sine\", frequency = 100, amplitude = \"depth\" }\n\
    [voice.tap]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = 90 }\n\
    [pattern.walk]\nevents = [{ at = 0.0, voice = \"tap\", duration = 0.05 }]\nrepeat = { every = 0.2, times = 10000 }\n";

/// So long something may take to be seen.
const PATIENCE: Duration = Duration::from_secs(20);

/// The program as it plays, and what it has said so far.
struct Playing {
    child: Child,
    said: Arc<Mutex<String>>,
    /// Up to where it was heard.
    heard: usize,
}

impl Playing {
    fn new(scratch: &Scratch, arguments: &[&str]) -> Self {
        let all = [&["play"], arguments, &["--watch"]].concat();
        let mut child = scratch.command(&all).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut err = child.stderr.take().unwrap();
        let said = Arc::<Mutex<String>>::default();
        let into = Arc::clone(&said);
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = err.read(&mut bytes) {
                into.lock().unwrap().push_str(&String::from_utf8_lossy(&bytes[..count]));
            }
        });
        let mut playing = Self { child, said, heard: 0 };
        playing.hears("tap on t");
        playing
    }

    /// Waits until it says this, behind what was heard before; gives what came in between.
    #[track_caller]
    fn hears(&mut self, what: &str) -> String {
        let begin = Instant::now();
        loop {
            let said = self.said.lock().unwrap().clone();
            if let Some(at) = said[self.heard..].find(what) {
                let end = self.heard + at + what.len();
                let between = said[std::mem::replace(&mut self.heard, end)..end].to_string();
                return between;
            }
            assert!(begin.elapsed() < PATIENCE, "no `{what}` in\n{}", &said[self.heard..]);
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Ctrl-C.
    fn interrupt(&mut self) {
        let kill =
            std::process::Command::new("kill").args(["-s", "INT", &self.child.id().to_string()]).status();
        assert!(kill.unwrap().success());
        assert_eq!(self.child.wait().unwrap().code(), Some(130));
    }
}

impl Drop for Playing {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn what_is_saved_plays_and_what_is_broken_is_shown_at_its_line() {
    let scratch = Scratch::new("watch-saved");
    let patch = scratch.write("p.toml", PATCH);
    let mut playing = Playing::new(&scratch, &["p.toml", "--device", "virtual"]);
    // Another voice.
    fs::write(&patch, PATCH.replace("tap", "knock")).unwrap();
    playing.hears("p.toml: taken up");
    playing.hears("knock on t1");
    // Broken in two places.
    fs::write(&patch, PATCH.replace("tap", "touch").replace("\"sine\"", "\"sinus\"")).unwrap();
    playing.hears("the old one plays on, as what was saved is broken:\n");
    let mut all =
        playing.hears("p.toml:9:14: error: node `s` of voice `hum`: there is no node type \"sinus\"");
    all += &playing.hears("help: did you mean `sine`?");
    all += &playing.hears("p.toml:12:");
    all += &playing.hears("knock on t1");
    let count = |what: &str| all.matches(what).count();
    assert_eq!(
        (count("of voice `hum`: there is no"), count("the old one"), count("p.toml:12:")),
        (1, 0, 1),
        "{all}"
    );
    // Mended.
    fs::write(&patch, PATCH.replace("tap", "touch")).unwrap();
    playing.hears("p.toml: taken up");
    playing.hears("touch on t1");
}

/// Other programs find what the new patch has; controls keep their values, and MIDI is listened to once there is use for it.
#[test]
fn what_hears_from_outside_follows() {
    use rosc::{OscMessage, OscPacket, OscType, decoder, encoder};
    let scratch = Scratch::new("watch-osc");
    let patch = scratch.write("p.toml", PATCH);
    let mut playing = Playing::new(&scratch, &["p.toml", "--device", "virtual", "--osc", "0"]);
    let said = playing.said.lock().unwrap().clone();
    let address =
        said.split("OSC is heard on ").nth(1).and_then(|rest| rest.split(',').next()).unwrap().to_string();
    let surface = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    surface.set_read_timeout(Some(PATIENCE)).unwrap();
    let say = |addr: &str, args: Vec<OscType>| {
        let packet = OscPacket::Message(OscMessage { addr: addr.into(), args });
        surface.send_to(&encoder::encode(&packet).unwrap(), &address).unwrap();
    };
    let controls = || {
        say("/controls", vec![]);
        let (mut all, mut bytes) = (Vec::new(), [0; 4096]);
        loop {
            let length = surface.recv(&mut bytes).unwrap();
            let Ok((_, OscPacket::Message(message))) = decoder::decode_udp(&bytes[..length]) else {
                panic!("no OSC")
            };
            if message.addr == "/controls/end" {
                return all;
            }
            all.push((message.args[0].clone().string().unwrap(), message.args[1].clone().float().unwrap()));
        }
    };
    say("/control/depth", vec![OscType::Float(0.75)]);
    assert_eq!(controls(), [("depth".to_string(), 0.75)]);
    let more =
        "[control.more]\ndefault = 0.5\n[[bind]]\nfrom = \"midi.bend\"\ncontrol = \"more\"\n[control.depth]";
    let text =
        PATCH.replace("[control.depth]", more).replace("frequency = 100", "frequency = \"100 * more\"");
    fs::write(&patch, text).unwrap();
    playing.hears("p.toml: taken up");
    playing.hears("MIDI");
    let both = [("more".to_string(), 0.5), ("depth".to_string(), 0.75)];
    let begin = Instant::now();
    while controls() != both {
        assert!(begin.elapsed() < PATIENCE, "{:?}", controls());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn the_screen_shows_what_is_wrong_until_it_is_mended() {
    let scratch = Scratch::new("watch-screen");
    let patch = scratch.write("p.toml", PATCH);
    let command = scratch.command(&["play", "p.toml", "--device", "virtual", "--watch"]);
    let Some(mut seat) = seat::Seat::new(&command) else { return };
    seat.shows("1 ▶ walk");
    fs::write(&patch, PATCH.replace("\"sine\"", "\"sinus\"")).unwrap();
    let line = "THE OLD ONE PLAYS ON  p.toml:9: node `s` of voice `hum`: there is no node type \"sinus\" (and 1 more)";
    assert!(seat.shows(line).lines().nth(1).unwrap().contains(line), "{}", seat.contents());
    // All of it, with its place and its help.
    for part in ["p.toml:9:14: error: node `s` of voice `hum`", "help: did you mean `sine`?", "p.toml:12:"] {
        seat.shows(part);
    }
    let mended = PATCH.replace("first", "second").replace("walk", "run").replace("tap", "knock");
    fs::write(&patch, &mended).unwrap();
    // What plays from the beginning is the first pattern of the new patch now.
    seat.shows("knock on t1");
    let shown = seat.shows("1 ▶ run");
    assert!(!shown.contains("THE OLD ONE"), "{shown}");
    assert!(shown.lines().next().unwrap().contains("second  on virtual card"), "{shown}");
    fs::write(&patch, mended.replace("format", "fromat")).unwrap();
    seat.shows("THE OLD ONE PLAYS ON  p.toml:1: ");
    seat.press("q");
    assert_eq!(seat.end().code(), Some(0));
    // What is still wrong is told in full.
    let shown = seat.contents();
    assert!(shown.contains("what was saved last was not played:") && shown.contains("[p.toml:1:"), "{shown}");
}

/// The journal of a session whose patch was saved anew plays it again to the bit.
#[cfg(unix)]
const RIG: &str = "format = \"pacinian-rig/1\"\ntitle = \"r\"\n[device]\nname = \"virtual\"\nrate = 48000\nchannels = 3\n\
    coupling = \"dc\"\n[[tactor]]\nname = \"t1\"\nchannel = 1\n";
const MORE: &str =
    "[[tactor]]\nname = \"t2\"\nchannel = 2\n[[output]]\nname = \"eeg\"\nkind = \"trigger\"\nchannel = 3\n";

#[test]
fn a_journal_knows_what_took_over() {
    let scratch = Scratch::new("watch-journal");
    let patch = scratch.write("p.toml", PATCH);
    let rig = scratch.write("r.toml", RIG);
    let arguments = ["p.toml", "--rig", "r.toml", "--record", "o.wav", "--events", "j.jsonl"];
    let mut playing = Playing::new(&scratch, &arguments);
    for name in ["knock", "touch"] {
        fs::write(&patch, PATCH.replace("tap", name)).unwrap();
        playing.hears("p.toml: taken up");
        playing.hears(&format!("{name} on t1"));
    }
    fs::write(&patch, PATCH.replace("[voice.tap]", "[voice.tap")).unwrap();
    playing.hears("the old one plays on");
    // An output more, and another stage for one that sounds.
    fs::write(&patch, PATCH).unwrap();
    playing.hears("p.toml: taken up");
    fs::write(&rig, RIG.replace("channel = 1\n", "channel = 1\ndc = true\n") + MORE).unwrap();
    playing.hears("r.toml: taken up");
    playing.hears("tap on t1");
    playing.interrupt();
    fs::remove_file(&patch).unwrap();
    fs::remove_file(&rig).unwrap();
    replays(&scratch);
    // Also what could not: a reload came in, and was refused.
    let text = fs::read_to_string(scratch.0.join("j.jsonl")).unwrap();
    let lines: Vec<serde_json::Value> =
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let refused = lines.iter().find(|line| line["kind"] == "refused").expect("a line");
    let asked = |line: &serde_json::Value, cause: &serde_json::Value| {
        line["kind"] == "in" && line["message"] == "reload" && line["id"] == cause["cause"]
    };
    assert!(lines.iter().any(|line| asked(line, refused)), "{refused}");
    assert!(refused["message"].as_str().unwrap().starts_with("p.toml:10: this is not TOML"), "{refused}");
    // Whoever let the others take over is known.
    let swaps: Vec<_> = lines.iter().filter(|line| line["kind"] == "swap").collect();
    // A save may be seen in two parts.
    assert!(swaps.len() >= 4, "{swaps:?}");
    for swap in swaps {
        assert!(lines.iter().any(|line| asked(line, swap)), "{swap}");
    }
}

/// What was recorded comes again from the journal, to the bit.
#[track_caller]
fn replays(scratch: &Scratch) {
    let run = scratch.run(&["replay", "j.jsonl", "-o", "again.wav"]);
    run.succeeds();
    let (sent, again) = (scratch.wav("o.wav").1, scratch.wav("again.wav").1);
    assert!(sent.len() > 48_000 && sent.len() == again.len(), "{} and {}", sent.len(), again.len());
    assert!(sent.iter().zip(&again).all(|(a, b)| a.to_bits() == b.to_bits()));
}

/// A recording that is saved anew while it plays: one path, and what was played by it more than once.
#[cfg(unix)]
#[test]
fn recordings_that_were_saved_anew_are_played_again() {
    let scratch = Scratch::new("watch-recordings");
    let tap = "{ type = \"sine\", frequency = 90 }";
    assert!(PATCH.contains(tap));
    scratch.write("p.toml", PATCH.replace(tap, "{ type = \"sample\", file = \"x.wav\" }"));
    let tone = |frequency: f32| {
        let spec = hound::WavSpec {
            channels: 1,
            sample_rate: 8_000,
            bits_per_sample: 32,
            sample_format: hound::SampleFormat::Float,
        };
        let mut wav = hound::WavWriter::create(scratch.0.join("x.wav"), spec).unwrap();
        let tone = |n: u16| 0.5 * (std::f32::consts::TAU * frequency * f32::from(n) / 8_000.0).sin();
        (0..1600).for_each(|n| wav.write_sample(tone(n)).unwrap());
        wav.finalize().unwrap();
    };
    let copies = |journal: &str| {
        let entries = fs::read_dir(scratch.0.join(format!("{journal}.files")));
        entries.map_or(0, |entries| entries.count())
    };
    let all = ["p.toml", "--device", "virtual", "--record", "o.wav", "--replace", "--events"];
    for journal in ["j.csv", "j.jsonl"] {
        tone(80.0);
        let mut playing = Playing::new(&scratch, &[&all[..], &[journal]].concat());
        for frequency in [120.0, 200.0] {
            tone(frequency);
            playing.hears("x.wav: taken up");
            playing.hears("tap on t1");
            playing.hears("tap on t1");
        }
        playing.interrupt();
        playing.hears(&format!("{journal}.files: 3 recordings of the journal, as they were played"));
        playing.hears("plays it again");
        assert_eq!(copies(journal), 3);
        // Of no use any more.
        fs::remove_file(scratch.0.join("x.wav")).unwrap();
        let again = scratch.run(&["replay", journal, "--against", "o.wav"]);
        assert!(again.succeeds().out.contains("the same, to the bit"), "{}", again.out);
        // The session's own is not written over.
        let copy = fs::read_dir(scratch.0.join(format!("{journal}.files"))).unwrap().next().unwrap();
        let copy = copy.unwrap().path().display().to_string();
        scratch.run(&["replay", journal, "-o", &copy]).fails(2, &["belongs to the session itself"]);
        // Nor is one believed that is another.
        fs::write(copy, "something else").unwrap();
        scratch.run(&["replay", journal]).fails(66, &["x.wav` is not there"]);
    }
    // What belongs to a journal that is gone is replaced only where that is asked for.
    tone(80.0);
    fs::remove_file(scratch.0.join("j.csv")).unwrap();
    let short =
        ["play", "p.toml", "--device", "virtual", "--duration", "0.5", "--watch", "--events", "j.csv"];
    scratch.run(&short).fails(73, &["j.csv.files` is there already", "--replace"]);
    let run = scratch.run(&[&short[..], &["--replace"]].concat());
    assert!(!run.succeeds().err.contains("j.csv.files"), "{}", run.err);
    assert!(!scratch.0.join("j.csv.files").exists());
    // What cannot be kept is told.
    std::os::unix::fs::symlink("none/none", scratch.0.join("j.csv.files")).unwrap();
    let run = scratch.run(&[&short[..], &["--replace"]].concat());
    run.fails(74, &["`j.csv.files` takes no more", "the journal, which lacks a recording"]);
}

/// Delays of a minute take over a little at a time, while the old patch goes on; and the journal knows when.
#[test]
fn what_remembers_for_long_takes_over_and_is_played_again() {
    let scratch = Scratch::new("watch-long");
    let nodes = "late = { type = \"delay\", input = \"s\", time = 0.5, longest = 60 }\n\
        both = { type = \"add\", inputs = [\"0.5 * s\", \"0.5 * late\"] }\n";
    let hum = "output = \"s\"\n[voice.hum.nodes]\n";
    // What is tapped is felt elsewhere, so that the first channel has the hum alone.
    let long = PATCH
        .replace(hum, &format!("output = \"both\"\n[voice.hum.nodes]\n{nodes}"))
        .replace("voice = \"tap\",", "voice = \"tap\", place = \"t2\",");
    assert!(long.contains("both") && long.contains("t2"));
    let patch = scratch.write("p.toml", &long);
    let arguments = ["p.toml", "--device", "virtual", "--record", "o.wav", "--events", "j.jsonl"];
    let mut playing = Playing::new(&scratch, &arguments);
    // Some hundred kilobytes of past.
    std::thread::sleep(Duration::from_secs(4));
    for name in ["knock", "touch"] {
        fs::write(&patch, long.replace("tap", name).replace("frequency = 100", "frequency = 110")).unwrap();
        playing.hears("p.toml: taken up");
        playing.hears(&format!("{name} on t2"));
    }
    playing.interrupt();
    replays(&scratch);
    let sent = scratch.wav("o.wav").1;
    // Eight channels; nothing of it ever jumps or is silent once it has begun.
    let first: Vec<f32> = sent.chunks(8).map(|frame| frame[0]).collect();
    // However long it took to end behind the gate, which closes within 96 frames.
    let last = first.iter().rposition(|x| *x != 0.0).unwrap();
    let sounding = &first[24_000..last - 480];
    let largest = |part: &[f32]| part.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f32::max);
    let (before, all) = (largest(&sounding[..120_000]), largest(sounding));
    // 110 Hz in place of 100, and what one passes into the other by.
    assert!(all <= 1.2 * before, "a step of {all} where {before} was the largest");
    assert!(sounding.windows(960).all(|part| part.iter().any(|x| x.abs() > 0.001)), "it has no gap");
}

#[test]
fn a_file_that_is_gone_or_is_a_folder_is_waited_for() {
    let scratch = Scratch::new("watch-gone");
    let patch = scratch.write("p.toml", PATCH);
    let mut playing = Playing::new(&scratch, &["p.toml", "--device", "virtual"]);
    fs::remove_file(&patch).unwrap();
    playing.hears("the old one plays on, as what was saved is broken:\nerror: `p.toml` is not there");
    for _ in 0..5 {
        let between = playing.hears("tap on t1");
        assert!(!between.contains("the old one"), "said once: {between}");
    }
    fs::create_dir(&patch).unwrap();
    playing.hears("the old one plays on, as what was saved is broken:\nerror: `p.toml` is a folder");
    fs::remove_dir(&patch).unwrap();
    playing.hears("the old one plays on, as what was saved is broken:\nerror: `p.toml` is not there");
    // By renaming, as many editors save.
    scratch.write("new", PATCH.replace("tap", "knock"));
    fs::rename(scratch.0.join("new"), &patch).unwrap();
    playing.hears("p.toml: taken up");
    playing.hears("knock on t1");
    scratch.write("new", PATCH.replace("tap", "touch"));
    fs::rename(scratch.0.join("new"), &patch).unwrap();
    playing.hears("p.toml: taken up");
    playing.hears("touch on t1");
}

#[test]
fn the_last_of_many_saves_plays() {
    let scratch = Scratch::new("watch-many");
    let patch = scratch.write("p.toml", PATCH);
    let mut playing = Playing::new(&scratch, &["p.toml", "--device", "virtual"]);
    for n in 0..100 {
        // Half of it, and then all.
        let text = PATCH.replace("tap", &format!("tap{n}"));
        fs::write(&patch, &text[..text.len() / 2]).unwrap();
        std::thread::sleep(Duration::from_millis(5));
        fs::write(&patch, text).unwrap();
        std::thread::sleep(Duration::from_millis(5));
    }
    let between = playing.hears("tap99 on t1");
    assert!(!between.contains("the old one"), "half of a file was taken for one: {between}");
}

#[test]
fn what_the_patch_names_is_watched_and_what_another_session_needs_is_kept() {
    let scratch = Scratch::new("watch-named");
    let table = PATCH.replace("[{ at = 0.0, voice = \"tap\", duration = 0.05 }]", "\"steps.csv\"");
    let rig = "format = \"pacinian-rig/1\"\ntitle = \"r\"\n[device]\nname = \"virtual\"\nrate = 48000\nchannels = 3\n\
        [[output]]\nname = \"t1\"\nkind = \"vibration\"\nchannel = 1\n\
        [[output]]\nname = \"left\"\nkind = \"vibration\"\nchannel = 2\n";
    scratch.write("p.toml", &table);
    scratch.write("steps.csv", "at,voice,place\n0,tap,t1\n");
    scratch.write("r.toml", rig);
    let mut playing = Playing::new(&scratch, &["p.toml", "--rig", "r.toml", "--set", "depth=0.125"]);
    scratch.write("steps.csv", "at,voice,place\n0,tap,left\n");
    playing.hears("steps.csv: taken up");
    playing.hears("tap on left");
    scratch.write("steps.csv", "at,voice,place\n0,tap,right\n");
    playing.hears("the old one plays on, as what was saved is broken:\nsteps.csv:2:");
    playing.hears("`steps.csv` is named in p.toml:14");
    scratch.write("r.toml", rig.replace("left", "right"));
    // With the table that was broken until then, where its rest was still waited for.
    playing.hears("r.toml");
    playing.hears(": taken up");
    playing.hears("tap on right");
    for (from, to, why) in [
        (
            "channels = 3",
            "channels = 4",
            "the rig has 4 channels, and the session began with 3: stop, and play again",
        ),
        (
            "name = \"virtual\"",
            "name = \"Other\"",
            "the rig names another device, `Other`: stop, and play again",
        ),
        (
            "rate = 48000",
            "rate = 48000\ninput = \"Microphone\"",
            "the rig names another input: stop, and play again",
        ),
        (
            "rate = 48000",
            "rate = 44100",
            "the rig says another rate, 44100 Hz, and 48000 Hz play: stop, and play again",
        ),
    ] {
        scratch.write("r.toml", rig.replace("left", "right").replacen(from, to, 1));
        playing.hears(&format!("the old one plays on: r.toml: {why}"));
    }
    // Other outputs need no other stream.
    let more = format!("{rig}[[output]]\nname = \"right\"\nkind = \"raw\"\nchannel = 3\n");
    scratch.write("r.toml", &more);
    playing.hears("r.toml: taken up");
    playing.hears("tap on right");
    // A file that the broken patch names before it is there.
    scratch.write("r.toml", rig);
    scratch.write("p.toml", table.replace("steps", "more"));
    playing.hears("the old one plays on, as what was saved is broken:\np.toml:14:");
    scratch.write("more.csv", "at,voice,place\n0,tap,left\n");
    playing.hears("more.csv: taken up");
    playing.hears("tap on left");
}

/// From Rust: a session, files that are watched, and what comes out.
#[test]
fn nothing_jumps_while_files_are_saved() {
    use pacinian::graph::scene::Options;
    use pacinian::io::device::choose::Chosen;
    use pacinian::io::session::{Beginning, Session};
    use pacinian::io::{load, watch::Watch};
    use pacinian::live::conductor::Told;
    use pacinian::live::reload::Reload;
    use pacinian::live::signal::Signal;
    use pacinian::{NoAssets, Rig};
    use ringbuf::traits::Consumer;
    use std::sync::atomic::{AtomicUsize, Ordering};

    let scratch = Scratch::new("watch-rust");
    let original = PATCH.replace("start = \"always\"", "start = \"always\"\nplace = \"t2\"");
    let file = scratch.write("p.toml", &original);
    let read = |path: &std::path::Path| {
        let options = Options { rate: Some(48_000.0), ..Options::default() };
        Reload::of(load::patch(path)?.value, Rig::default_for(2), &options, &NoAssets)
    };
    let mut watch = Watch::of([&file]);
    let taken = Arc::<AtomicUsize>::default();
    let count = Arc::clone(&taken);
    let mut session = Session::start(Beginning {
        block: Some(64),
        record: true,
        audience: Box::new(move |told| {
            if let Told::Reloaded = told {
                count.fetch_add(1, Ordering::Relaxed);
            }
        }),
        ..Beginning::of(read(&file).unwrap(), Chosen::Virtual(None))
    })
    .unwrap();
    let (mut recording, mut all) = (session.recording().unwrap(), Vec::<f32>::new());
    let (begin, mut saved, mut broken) = (Instant::now(), 0, 0);
    while begin.elapsed() < PATIENCE {
        let seen = taken.load(Ordering::Relaxed) + broken >= saved;
        if seen && saved == 8 && session.board().frames.get() >= 96_000 {
            break;
        }
        if seen && saved < 8 {
            saved += 1;
            // Every fourth is broken; the others play something else beside the hum.
            let text = original.replace("frequency = 90", &format!("frequency = {}", 90 + saved));
            let text = if saved % 4 == 3 { text.replace("[voice.hum]", "[voice.hum") } else { text };
            fs::write(&file, text).unwrap();
        }
        for path in watch.look() {
            match read(&path) {
                Ok(reload) => session.handle().send(Signal::Reload(Box::new(reload))).unwrap(),
                Err(problems) => {
                    assert!(problems.to_string().contains("p.toml:5:"), "{problems}");
                    broken += 1;
                }
            }
        }
        all.extend(recording.pop_iter());
        std::thread::sleep(Duration::from_millis(20));
    }
    session.stop();
    all.extend(recording.pop_iter());
    assert_eq!((taken.load(Ordering::Relaxed), broken), (6, 2));
    let hum: Vec<f32> = all.iter().skip(1).step_by(2).copied().collect();
    // Without how it begins, and how it fades at its end.
    let hum = &hum[9700..hum.len() - 4800];
    // The steepest step of a sine of 100 Hz and 0.25 at 48 kHz is 0.00327.
    let steepest = hum.windows(2).map(|w| (w[1] - w[0]).abs()).fold(0.0, f32::max);
    assert!(steepest < 0.0033, "{steepest}");
    assert!(hum.chunks_exact(480).all(|c| c.iter().any(|x| x.abs() > 0.22)), "a gap");
}

/// An input is opened for the channels that the patch listened to at first.
#[test]
fn a_patch_that_would_listen_in_vain_is_kept_out() {
    let scratch = Scratch::new("watch-input");
    let patch = scratch.write("p.toml", PATCH);
    scratch.run(&["render", "good.toml", "-o", "in.wav"]).succeeds();
    let mut playing = Playing::new(&scratch, &["p.toml", "--device", "virtual", "--input", "in.wav"]);
    let listening = PATCH.replace("{ type = \"sine\", frequency = 90 }", "{ type = \"input\", channel = 2 }");
    fs::write(&patch, listening).unwrap();
    playing.hears("the old one plays on: p.toml: the patch listens to channel 2 of the input, and the session does not: stop, and play again");
    fs::write(&patch, PATCH.replace("tap", "knock")).unwrap();
    playing.hears("knock on t1");
}

#[test]
fn a_pipe_cannot_be_watched() {
    let scratch = Scratch::new("watch-pipe");
    let run = scratch.run(&["play", "-", "--device", "virtual", "--watch"]);
    run.fails(2, &["--watch looks at files, and the patch comes through a pipe", "save it to a file"]);
    let run = scratch.run(&["play", "good.toml", "--rig", "/dev/stdin", "--device", "virtual", "--watch"]);
    run.fails(2, &["the rig comes through a pipe"]);
}

/// What is over stays over, and what is saved to go on goes on; a pattern that was away for a moment plays on where it would be.
#[test]
fn a_pattern_that_was_over_or_away_comes_back_where_it_would_be() {
    let scratch = Scratch::new("watch-over");
    let voice = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.tap]\noutput = \"s\"\n[voice.tap.nodes]\n\
        s = { type = \"sine\", frequency = 200 }\n";
    let once = format!("{voice}[pattern.p]\nevents = [{{ at = 0, voice = \"tap\", duration = 0.05 }}]\n");
    let patch = scratch.write("p.toml", &once);
    let mut playing = Playing::new(&scratch, &["p.toml", "--device", "virtual"]);
    std::thread::sleep(Duration::from_millis(600));
    fs::write(&patch, once.replace("0.05", "0.06")).unwrap();
    playing.hears("p.toml: taken up; patterns that are over do not begin again");
    fs::write(&patch, format!("{once}repeat = {{ every = 0.25 }}\n")).unwrap();
    playing.hears("taken up");
    playing.hears("tap on t1");
    playing.hears("tap on t1");
    fs::write(&patch, voice).unwrap();
    playing.hears("taken up");
    fs::write(&patch, format!("{once}repeat = {{ every = 0.25 }}\n")).unwrap();
    playing.hears("taken up");
    playing.hears("tap on t1");
    playing.hears("tap on t1");
}
