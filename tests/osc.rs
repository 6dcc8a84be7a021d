//! A session on the virtual card that is driven over UDP.
#![cfg(feature = "live")]

mod common;
#[cfg(feature = "cli")]
mod program;
#[path = "common/unbroken.rs"]
mod unbroken;

use std::net::UdpSocket;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use pacinian::graph::scene::Options;
use pacinian::io::device::choose::Chosen;
use pacinian::io::osc::server::Server;
use pacinian::io::session::{Beginning, Session};
use pacinian::live::callback::{Deed, Report};
use pacinian::live::conductor::Told;
use pacinian::live::reload::Reload;
use pacinian::live::signal::{Handle, Signal, Stamped};
use pacinian::midi::{Channel, Message};
use pacinian::node::asset::NoAssets;
use pacinian::rig::Rig;
use rosc::{OscBundle, OscMessage, OscPacket, OscTime, OscType, encoder};

const CHANNELS: u32 = 2;

/// A tone that is always on, on a channel of its own.
const STEADY: &str = "[voice.steady]\nstart = \"always\"\noutput = \"s\"\nplace = \"t3\"\n[voice.steady.nodes]\n\
    s = { type = \"sine\", frequency = 100, amplitude = 0.4 }\n";

/// One voice that sounds as long as it is held, a pattern that plays from the beginning and is over soon, and one that never ends.
const PATCH: &str = "[[trigger]]\non = \"midi.note\"\nplay = \"hum\"\n[[trigger]]\non = \"start\"\nplay = \"once\"\n[control.depth]\ndefault = 1\n[[bind]]\nfrom = \"osc./1/fader1\"\ncontrol = \"depth\"\npickup = false\n[voice.hum]\nvoices = 16\noutput = \"o\"\n[voice.hum.nodes]\n\
    s = { type = \"sine\", frequency = 200, amplitude = \"1 - 0.5 * touch.pressure\" }\ne = { type = \"envelope\", attack = 0.005, release = 0.02 }\n\
    o = { type = \"multiply\", inputs = [\"s\", \"e\", \"depth\"] }\n\
    [pattern.once]\nevents = [{ at = 0, voice = \"hum\", duration = 0.01 }]\n\
    [pattern.beat]\nevents = [{ at = 0, voice = \"hum\", duration = 0.05, place = 2 }]\nrepeat = { every = 0.1 }\n";

struct Stage {
    session: Session,
    server: Option<Server>,
    client: UdpSocket,
    /// What the conductor could not do, but for notes that it could not end.
    refused: Arc<AtomicU64>,
    /// Patches that took over.
    swaps: Arc<AtomicU64>,
    channels: u32,
}

fn reload(text: &str) -> Reload {
    reload_on(text, CHANNELS)
}

fn reload_on(text: &str, channels: u32) -> Reload {
    // The rate of the virtual card.
    let options = Options { rate: Some(48_000.0), ..Options::default() };
    Reload::of(common::patch(text), Rig::default_for(channels), &options, &NoAssets).unwrap()
}

impl Stage {
    fn new() -> Self {
        Self::of(reload(PATCH), CHANNELS)
    }

    fn of(reload: Reload, channels: u32) -> Self {
        let patch = Arc::clone(&reload.patch);
        let refused = Arc::new(AtomicU64::new(0));
        let swaps = Arc::new(AtomicU64::new(0));
        let (count, swapped) = (Arc::clone(&refused), Arc::clone(&swaps));
        let mut ends = false;
        let session = Session::start(Beginning {
            block: Some(64),
            record: true,
            input: pacinian::io::session::Ear::Nothing,
            audience: Box::new(move |told| match told {
                Told::Came(Stamped { signal, .. }) => {
                    ends = matches!(signal, Signal::Midi(_, Message::NoteOff { .. }));
                }
                Told::Refused(..) if !ends => _ = count.fetch_add(1, Ordering::Relaxed),
                Told::Report(Report { deed: Deed::Swap, .. }, _) => {
                    swapped.fetch_add(1, Ordering::Relaxed);
                }
                _ => {}
            }),
            ..Beginning::of(reload, Chosen::Virtual(None))
        })
        .unwrap();
        let server = Server::start("0".parse().unwrap(), session.handle().clone(), &patch, None).unwrap();
        let client = UdpSocket::bind("127.0.0.1:0").unwrap();
        client.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
        Self { session, server: Some(server), client, refused, swaps, channels }
    }

    fn say(&self, addr: &str, args: &[OscType]) {
        let packet = OscPacket::Message(OscMessage { addr: addr.into(), args: args.to_vec() });
        self.send(&encoder::encode(&packet).unwrap());
    }

    fn send(&self, bytes: &[u8]) {
        self.client.send_to(bytes, self.server.as_ref().unwrap().address()).unwrap();
    }

    /// Hears meters until one is as is wanted.
    #[track_caller]
    fn wait_for(&self, what: &str, wanted: impl Fn(&[f32]) -> bool) {
        let begin = Instant::now();
        let mut bytes = [0; 65_536];
        while begin.elapsed() < Duration::from_secs(20) {
            let (length, _) = self.client.recv_from(&mut bytes).unwrap();
            let Ok((_, OscPacket::Message(message))) = rosc::decoder::decode_udp(&bytes[..length]) else {
                panic!("no OSC")
            };
            if message.addr == "/meter" {
                let peaks: Vec<f32> = message.args.into_iter().filter_map(OscType::float).collect();
                assert_eq!(peaks.len(), self.channels as usize);
                if wanted(&peaks) {
                    return;
                }
            }
        }
        panic!("the meter never showed {what}");
    }
}

fn s(text: &str) -> OscType {
    OscType::String(text.into())
}

#[test]
fn the_meter_shows_what_was_asked_for() {
    let stage = Stage::new();
    stage.say("/meter/subscribe", &[20.into()]);
    stage.say("/pattern/beat/play", &[]);
    stage.wait_for("the pattern", |peaks| peaks[1] > 0.3 && peaks[0] < 1e-4);
    stage.say("/pattern/*/stop", &[]);
    stage.say("/meter/subscribe", &[500.into()]);
    stage.wait_for("an end of it", |peaks| peaks[1] < 1e-4);
    stage.say("/meter/subscribe", &[20.into()]);
    stage.say(
        "/voice/hum/play",
        &[OscType::Float(0.5), OscType::Inf, s("place"), 1.into(), s("id"), 7.into()],
    );
    stage.wait_for("the voice", |peaks| peaks[0] > 0.4 && peaks[0] < 0.6);
    stage.say("/control/depth", &[OscType::Double(0.5)]);
    stage.wait_for("the control", |peaks| peaks[0] > 0.2 && peaks[0] < 0.3);
    stage.say("/1/fader1", &[OscType::Float(0.8)]);
    stage.wait_for("what is bound to an address", |peaks| peaks[0] > 0.35 && peaks[0] < 0.45);
    stage.say("/control/depth", &[OscType::Double(0.5)]);
    stage.say("/voice/pressure", &[7.into(), OscType::Float(1.0)]);
    stage.wait_for("the pressure", |peaks| peaks[0] > 0.1 && peaks[0] < 0.15);
    stage.say("/voice/release", &[7.into()]);
    stage.wait_for("the release", |peaks| peaks[0] < 1e-4);

    // A panic closes the gate, and nothing is heard until it is taken back.
    stage.say("/voice/hum/play", &[OscType::Float(1.0), OscType::Inf, s("place"), 1.into()]);
    stage.wait_for("the next voice", |peaks| peaks[0] > 0.4);
    assert_eq!(stage.session.board().shut.get(), 0);
    stage.say("/panic", &[]);
    stage.wait_for("silence", |peaks| peaks == [0.0, 0.0]);
    assert_eq!(stage.session.board().shut.get(), 1);
    let play = [OscType::Float(1.0), OscType::Inf, s("place"), 1.into(), s("id"), 8.into()];
    stage.say("/voice/hum/play", &play);
    for _ in 0..5 {
        stage.wait_for("silence", |peaks| {
            assert_eq!(peaks, [0.0, 0.0], "the gate is closed");
            true
        });
    }
    stage.say("/calm", &[]);
    stage.wait_for("the voice again", |peaks| peaks[0] > 0.4);

    // All that sounds is released, and patterns play on.
    stage.say("/pattern/beat/play", &[]);
    stage.wait_for("the pattern beside it", |peaks| peaks[0] > 0.4 && peaks[1] > 0.3);
    stage.say("/release", &[0.into()]);
    stage.wait_for("both", |peaks| peaks[0] > 0.4 && peaks[1] > 0.3);
    stage.say("/release", &[]);
    stage.wait_for("the pattern alone", |peaks| peaks[0] < 1e-4 && peaks[1] > 0.3);
    assert_eq!(stage.server.as_ref().unwrap().counts().trouble(), None);
    assert_eq!(stage.refused.load(Ordering::Relaxed), 0);
}

/// As fast as they can be sent, while other patches take over: playing goes on, and each is played or counted.
#[test]
fn a_flood_is_played_or_counted() {
    flood(&|_| 0);
}

/// Likewise, while as many messages of MIDI come in as fast as they can be sent.
#[test]
fn floods_of_midi_and_osc_at_once_are_played_or_counted() {
    flood(&|handle| {
        let channel = Channel::new(0).unwrap();
        let mut taken = 0;
        for n in 0..FLOOD {
            let note = (n / 2 % 128) as u8;
            let message = match n % 2 {
                0 => Message::NoteOn { channel, note, velocity: 1 },
                _ => Message::NoteOff { channel, note, velocity: 0 },
            };
            let room = handle.send(Signal::Midi(0, message)).is_ok();
            taken += u64::from(room && n % 2 == 0);
            if n % 128 == 0 {
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        // Notes whose end found no room; what is always on goes on.
        until("a last word", || handle.send(Signal::MidiGone(0)).is_ok());
        taken
    });
}

/// Patterns that take long do not hold up whoever comes behind them: of a datagram full of them a part is done, the rest is counted.
#[test]
fn a_datagram_of_costly_patterns_holds_nobody_up() {
    let name = |n: usize| format!("{}{n}", "long".repeat(9));
    let controls = (0..40).map(|n| format!("[control.{}]\ndefault = 0.5\n", name(n)));
    let stage = Stage::of(reload(&format!("{}{PATCH}", controls.collect::<String>())), CHANNELS);
    let counts = Arc::clone(stage.server.as_ref().unwrap().counts());
    let costly = |n: usize| {
        let addr = format!("/control/{}{n}", "*{a,}".repeat(47));
        OscPacket::Message(OscMessage { addr, args: vec![OscType::Float(0.1)] })
    };
    let timetag = rosc::OscTime { seconds: 0, fractional: 1 };
    // A brake among them by no name of its own, for which no steps are left, is pulled and is a panic all the same.
    let brake = OscPacket::Message(OscMessage { addr: "/pani?".into(), args: vec![] });
    let content = (0..230).map(costly).chain([brake]).collect();
    let bytes = encoder::encode(&OscPacket::Bundle(rosc::OscBundle { timetag, content })).unwrap();
    assert!(bytes.len() > 50_000);
    let board = stage.session.board();
    stage.say("/voice/hum/play", &[OscType::Float(0.5), OscType::Inf]);
    until("a voice", || board.voices.get() == 1);
    stage.send(&bytes);
    until("the brake is pulled", || board.is_panicked());
    until("all is read", || counts.messages.get() >= 232);
    let refused = counts.refused.get();
    assert!((50..232).contains(&refused), "{:?}", counts.trouble());
    until("what sounded is let go of", || board.voices.get() == 0);
}

const FLOOD: u64 = 100_000;

#[track_caller]
fn until(what: &str, mut done: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !done() {
        assert!(begin.elapsed() < Duration::from_secs(20), "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Beside another that plays voices and gives how many of them were taken.
fn flood(beside: &(dyn Fn(&Handle) -> u64 + Sync)) {
    let patch = format!("{PATCH}{STEADY}");
    let mut stage = Stage::of(reload_on(&patch, 3), 3);
    let play = OscMessage {
        addr: "/voice/hum/play".into(),
        args: vec![OscType::Float(0.01), OscType::Float(0.002)],
    };
    let play = encoder::encode(&OscPacket::Message(play)).unwrap();
    let board = Arc::clone(stage.session.board());
    let counts = Arc::clone(stage.server.as_ref().unwrap().counts());
    let watch = unbroken::Watch::start(stage.session.recording().unwrap(), Arc::clone(&board));
    until("the first pattern has ended", || board.started.get() == 2 && board.voices.get() == 1);
    let before = board.started.get();
    until("the ramp's end", || board.frames.get() > 12_000);
    let handle = stage.session.handle().clone();
    let beside = std::thread::scope(|scope| {
        let other = scope.spawn(|| beside(&handle));
        for number in 0..FLOOD {
            if number % 10_000 == 5_000 {
                // Another graph each time, so that voices and events go from one plan to the next.
                let other = patch.replace("frequency = 200", &format!("frequency = {}", 200 + number / 1000));
                until("room for a reload", || {
                    stage.session.handle().send(Signal::Reload(Box::new(reload_on(&other, 3)))).is_ok()
                });
            }
            stage.send(&play);
        }
        other.join().unwrap()
    });
    until("patches take over", || stage.swaps.load(Ordering::Relaxed) >= 3);

    // Afterwards all is as it was. What is said too early is dropped by the system as well.
    let mut pings = 0;
    stage.client.set_read_timeout(Some(Duration::from_secs(1))).unwrap();
    until("it answers", || {
        stage.say("/ping", &[]);
        pings += 1;
        stage.client.recv_from(&mut [0; 99]).is_ok()
    });
    stage.client.set_read_timeout(Some(Duration::from_secs(20))).unwrap();
    // What was taken are voices: started, or told as refused by the conductor.
    let heard = || board.started.get() - before + board.dropped.get() + stage.refused.load(Ordering::Relaxed);
    until("what was taken is played", || heard() >= counts.taken.get() + beside);
    let held = [OscType::Float(0.5), OscType::Inf, s("place"), 2.into()];
    stage.say("/meter/subscribe", &[20.into()]);
    stage.say("/voice/hum/play", &held);
    stage.wait_for("a voice after the flood", |peaks| peaks[1] > 0.4);

    // The last counts come as the server ends.
    drop(stage.server.take());
    // Besides the flood and the pings: a subscription, and the last voice.
    let sent = FLOOD + pings + 2;
    assert!(counts.datagrams.get() <= sent);
    if std::path::Path::new("/proc/net/udp").exists() {
        assert_eq!(counts.datagrams.get() + counts.missed.get(), sent, "{:?}", counts.trouble());
    }
    assert_eq!(counts.messages.get(), counts.datagrams.get());
    let others = counts.messages.get() - counts.taken.get() - counts.refused.get();
    assert!((2..=pings + 1).contains(&others), "{others} of {pings}: {:?}", counts.trouble());
    until("what was taken is played", || heard() >= counts.taken.get() + beside);
    std::thread::sleep(Duration::from_millis(200));
    assert_eq!(heard(), counts.taken.get() + beside);
    // Meanwhile playing never stopped.
    stage.session.stop();
    watch.finish(&board, 2, 3, 0.4, 12_000, 64);
}

/// Through the program: where it listens, what went wrong, and a port that is taken.
#[cfg(feature = "cli")]
#[test]
fn the_program_says_where_it_listens() {
    let scratch = program::Scratch::new("osc");
    scratch.write("p.toml", format!("{}{PATCH}", program::HEAD));
    let play =
        |at: &str| scratch.run(&["play", "p.toml", "--device", "virtual", "--duration", "0.3", "--osc", at]);
    let run = play("0");
    run.succeeds();
    assert!(run.err.contains("OSC is heard on 127.0.0.1:"), "{}", run.err);
    assert!(run.err.contains("from programs on this machine") && !run.err.contains("OSC, of"), "{}", run.err);
    let taken = UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    play(&port)
        .fails(75, &[&format!("127.0.0.1:{port}"), "another program listens there", "--osc 127.0.0.1:"]);
    play("nowhere").fails(2, &["--osc", "0.0.0.0:9000"]);
}

/// Markers that nobody hears are not lost in silence: it is said while it plays, and they are counted at the end.
#[cfg(feature = "cli")]
#[test]
fn markers_that_nobody_hears_are_told_of() {
    let scratch = program::Scratch::new("unheard");
    let patch = format!(
        "{}{}[[trigger]]\non = \"start\"\nplay = \"p\"\n[pattern.p]\nrepeat = {{ every = 0.05 }}\nevents = [{{ at = 0, marker = \"m\" }}, {{ at = 0.01, voice = \"beat\", frequency = 90, duration = 0.02 }}]\n",
        program::HEAD,
        program::VOICE
    );
    scratch.write("p.toml", patch);
    let listener = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let at = listener.local_addr().unwrap().to_string();
    let play =
        || scratch.run(&["play", "p.toml", "--device", "virtual", "--duration", "0.4", "--osc-to", &at]);
    let heard = play();
    assert!(!heard.succeeds().err.contains("nobody"), "{}", heard.err);
    drop(listener);
    let unheard = play();
    let told = format!("nobody listens at {at}: what is told there over OSC is lost");
    assert_eq!(unheard.succeeds().err.matches(&told).count(), 1, "{}", unheard.err);
    let lost =
        unheard.err.split(" messages of markers, voices and the gate could not be told").next().unwrap();
    let lost: u32 = lost.rsplit('\n').next().unwrap().parse().unwrap();
    // One each 0.05 s of the 0.2 s behind the ramp, what is told of ahead, and that the gate opens, closes and calls it off.
    assert!((5..=12).contains(&lost), "{}", unheard.err);
}

/// Where lines are written, and far more comes than anybody could read: what has no line is counted in one.
#[cfg(feature = "cli")]
#[test]
fn what_comes_too_fast_to_be_written_is_counted() {
    // A machine that is busy otherwise may send no faster than lines are written.
    let missed = (0..5).map(|_| missed_in_a_flood()).find(|missed| *missed > 0);
    assert!(missed.is_some(), "nothing came too fast");
}

/// The program, the file that it writes its log to, and where it hears OSC.
#[cfg(feature = "cli")]
fn playing(scratch: &program::Scratch, more: &[&str]) -> (std::process::Child, std::path::PathBuf, String) {
    playing_of(scratch, PATCH, more)
}

#[cfg(feature = "cli")]
fn playing_of(
    scratch: &program::Scratch,
    patch: &str,
    more: &[&str],
) -> (std::process::Child, std::path::PathBuf, String) {
    scratch.write("p.toml", format!("{}{patch}", program::HEAD));
    let arguments = [&["play", "p.toml", "--device", "virtual", "--osc", "0"], more].concat();
    let log = scratch.0.join("log.txt");
    let command = &mut scratch.command(&arguments);
    command.stdout(std::process::Stdio::piped()).stderr(std::fs::File::create(&log).unwrap());
    let child = command.spawn().unwrap();
    let said = || std::fs::read_to_string(&log).unwrap();
    let at = || Some(said().split_once("OSC is heard on ")?.1.split_once(", from")?.0.to_string());
    until("the port", || at().is_some());
    let to = at().unwrap();
    (child, log, to)
}

/// What is asked for over OSC and cannot be done has no line in a journal, but its number.
#[cfg(feature = "cli")]
#[test]
fn a_journal_counts_what_came_to_nothing() {
    let scratch = program::Scratch::new("to-nothing");
    let (child, _, to) = playing(&scratch, &["--duration", "1", "--events", "j.jsonl"]);
    let client = UdpSocket::bind("127.0.0.1:0").unwrap();
    let say = |addr: &str, args: &[OscType]| {
        let packet = OscPacket::Message(OscMessage { addr: addr.into(), args: args.to_vec() });
        client.send_to(&encoder::encode(&packet).unwrap(), &to).unwrap();
    };
    say("/control/dept", &[0.5_f32.into()]);
    say("/voice/ham/play", &[]);
    say("/control/depth", &["much".into()]);
    say("/control/depth", &[0.5_f32.into()]);
    client.send_to(b"no OSC at all", &to).unwrap();
    assert!(child.wait_with_output().unwrap().status.success());
    let journal = std::fs::read_to_string(scratch.0.join("j.jsonl")).unwrap();
    let end: serde_json::Value = serde_json::from_str(journal.lines().last().unwrap()).unwrap();
    let count = |name: &str| end["fields"][name].as_f64().unwrap_or_else(|| panic!("{name}: {end}"));
    let counted = ["osc", "osc_unknown", "osc_wrong", "osc_malformed", "osc_late"].map(count);
    assert_eq!(counted, [4.0, 2.0, 1.0, 1.0, 0.0], "{end}");
}

/// What was sampled 0.3 s ago is reached 0.7 s from now where the stream is a second late; and that is what is played again.
#[cfg(feature = "cli")]
#[test]
fn a_value_is_of_when_it_was_sampled_and_is_played_again_so() {
    let scratch = program::Scratch::new("sampled");
    let patch = STEADY.replace("0.4", "\"depth\"") + "[control.depth]\ndefault = 0\nstream = 1\n";
    let keep = ["--duration", "2", "--record", "o.wav", "--events", "j.jsonl"];
    let (child, _, to) = playing_of(&scratch, &patch, &keep);
    std::thread::sleep(Duration::from_millis(400));
    let sampled = std::time::SystemTime::now() - Duration::from_millis(300);
    let timetag = OscTime::try_from(sampled).unwrap();
    let message = OscMessage { addr: "/input/depth".into(), args: vec![0.5_f32.into()] };
    let bundle = OscPacket::Bundle(OscBundle { timetag, content: vec![OscPacket::Message(message)] });
    let client = UdpSocket::bind("127.0.0.1:0").unwrap();
    client.send_to(&encoder::encode(&bundle).unwrap(), &to).unwrap();
    assert!(child.wait_with_output().unwrap().status.success());
    let journal = std::fs::read_to_string(scratch.0.join("j.jsonl")).unwrap();
    let lines: Vec<serde_json::Value> =
        journal.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let of = |key: &str, word: &str| {
        lines.iter().find(|line| line[key] == word).unwrap_or_else(|| panic!("no {word}: {journal}"))
    };
    let seconds = of("kind", "control")["duration"].as_f64().unwrap();
    assert!(seconds > 0.0 && seconds <= 0.7, "{}", of("kind", "control"));
    assert_eq!(of("source", "osc")["message"], "0.5");
    assert_eq!(of("kind", "end")["fields"]["osc_late"], 0.0);
    scratch.run(&["replay", "j.jsonl", "--against", "o.wav"]).succeeds();
}

#[cfg(feature = "cli")]
fn missed_in_a_flood() -> u64 {
    let scratch = program::Scratch::new("too-fast");
    // Whether there is MIDI is told as well, and may come too fast.
    let (child, log, to) = playing(&scratch, &["--duration", "4", "--midi-in", "none"]);
    let client = UdpSocket::bind("127.0.0.1:0").unwrap();
    let packet = OscMessage { addr: "/voice/hum/play".into(), args: vec![0.5_f32.into(), 0.01_f32.into()] };
    let packet = encoder::encode(&OscPacket::Message(packet)).unwrap();
    for _ in 0..40_000 {
        client.send_to(&packet, &to).unwrap();
    }
    let output = child.wait_with_output().unwrap();
    let (out, log) = (String::from_utf8(output.stdout).unwrap(), std::fs::read_to_string(log).unwrap());
    assert!(output.status.success(), "{log}");
    let number = |text: &str| text.replace(',', "").parse::<u64>().unwrap_or_else(|_| panic!("{text}"));
    let counted =
        |words: &str| -> u64 { log.lines().filter_map(|line| Some(number(line.split_once(words)?.0))).sum() };
    let (before, after) = out.split_once(" voices (").unwrap();
    let (played, cut) = (before.rsplit(", ").next().unwrap(), after.split_once(" cut short)").unwrap().0);
    assert!(number(cut) > 1_000, "{out}");
    let missed = counted(" events came too fast to be written here");
    let lines = log.lines().filter(|line| line.contains("  hum on t")).count() as u64;
    // An xrun is an event, too, and may be one that came too fast.
    let xruns = out.split_once(" xrun").map_or(0, |(before, _)| number(before.rsplit(", ").next().unwrap()));
    let told = lines + counted(" lines were left out here") + missed;
    assert!((number(played)..=number(played) + xruns).contains(&told), "{told}: {out}");
    missed
}
