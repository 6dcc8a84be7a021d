//! Playing through PulseAudio to a second program, `parec`, and what happens when its sink goes away, or somebody leads the stream elsewhere: the
//! server then moves it to another one, and says nothing.
//!
//! It needs the feature `pulseaudio`, and pulseaudio and pulseaudio-utils (on Debian packages of these names). The server runs in a folder of
//! the test's own, with sinks that have no hardware. Where it is missing, a test says that it was skipped, and why.
#![cfg(target_os = "linux")]

#[path = "common/bench.rs"]
mod bench;

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use bench::{HUM, Playing, clock_went_on, floats, heard_to_the_bit, hums, kills, scene, signal, wait};

const CHANNELS: u32 = 24;

/// One server at a time leaves the others the processor.
static ALONE: Mutex<()> = Mutex::new(());

/// A server with two sinks, `glove` and `belt`, and a folder of a test's own.
struct Rig {
    folder: PathBuf,
    server: Child,
    _alone: MutexGuard<'static, ()>,
}

/// The channels of a sink by the names that have no loudspeaker.
fn map() -> String {
    (0..CHANNELS).map(|n| format!("aux{n}")).collect::<Vec<_>>().join(",")
}

fn sink(name: &str) -> String {
    format!(
        "module-null-sink sink_name={name} channels={CHANNELS} channel_map={} rate=48000 format=float32le sink_properties=device.description={name}",
        map()
    )
}

impl Rig {
    fn new(name: &str) -> Option<Self> {
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        for program in ["pulseaudio", "pactl", "parec"] {
            if let Err(error) = Command::new(program).arg("--version").stdout(Stdio::null()).status() {
                bench::skipped(format!("{program}: {error}"));
                return None;
            }
        }
        let folder = std::env::temp_dir().join(format!("pacinian-pulse-{}-{name}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let server = served(&folder);
        let rig = Self { folder, server, _alone: alone };
        wait("the server", || rig.pactl(&["info"]).is_some());
        Some(rig)
    }

    /// The server dies, and another one comes in its place.
    fn dies_and_comes_back(&mut self) {
        self.server.kill().unwrap();
        self.server.wait().unwrap();
        std::thread::sleep(Duration::from_millis(700));
        self.server = served(&self.folder);
        wait("the server", || self.pactl(&["info"]).is_some());
    }

    /// What `pactl` says; `None` where it fails.
    fn pactl(&self, words: &[&str]) -> Option<String> {
        let output = in_folder(&self.folder, "pactl").args(words).output().unwrap();
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).into_owned())
    }

    fn unload(&self, name: &str) {
        let modules = self.pactl(&["list", "short", "modules"]).unwrap();
        let line = modules.lines().find(|line| line.contains(&format!("sink_name={name} "))).unwrap();
        self.pactl(&["unload-module", line.split_whitespace().next().unwrap()]).unwrap();
    }

    /// Leads what `kind` (`sink-input`, `source-output`) the program has to another device, as a mixer's window does.
    fn lead(&self, kind: &str, to: &str) {
        let all = self.pactl(&["list", &format!("{kind}s")]).unwrap();
        let own =
            all.split("\n\n").find(|one| one.contains("cpal-pulseaudio")).unwrap_or_else(|| panic!("{all}"));
        let number = own.split('#').nth(1).unwrap().split_whitespace().next().unwrap();
        self.pactl(&[&format!("move-{kind}"), number, to]).unwrap();
    }

    fn load(&self, name: &str) {
        let module = sink(name);
        let words: Vec<&str> = ["load-module"].into_iter().chain(module.split(' ')).collect();
        self.pactl(&words).unwrap();
    }

    fn program(&self, arguments: &[&str]) -> Command {
        let mut command = in_folder(&self.folder, env!("CARGO_BIN_EXE_pacinian"));
        command.args(arguments);
        command
    }

    /// The program, playing a hum on the glove.
    fn hum(&self) -> Playing {
        scene(&self.folder, CHANNELS);
        fs::write(self.folder.join("hum.toml"), HUM).unwrap();
        let mut play =
            self.program(&["play", "hum.toml", "--rig", "rig.toml", "--device", "pulseaudio:glove"]);
        play.args(["--block", "1024", "--events", "s.jsonl"]);
        let playing = Playing::start(play, self.folder.join("told"));
        wait("the beginning", || playing.says("plays on") == 1);
        playing
    }

    /// What a sink plays, recorded by a second program until it is told to stop; it listens when this returns.
    fn record(&self, sink: &str, file: &str) -> Child {
        self.record_as(sink, file, CHANNELS, &map())
    }

    /// The same of a sink whose channels have other names.
    fn record_as(&self, sink: &str, file: &str, channels: u32, map: &str) -> Child {
        let mut command = in_folder(&self.folder, "parec");
        command.args([&format!("--device={sink}.monitor"), "--format=float32le", "--rate=48000", "--raw"]);
        command.args([
            &format!("--channels={channels}"),
            &format!("--channel-map={map}"),
            "--latency-msec=50",
        ]);
        let child = command.stdout(fs::File::create(self.folder.join(file)).unwrap()).spawn().unwrap();
        wait("the recorder", || fs::metadata(self.folder.join(file)).map_or(0, |about| about.len()) > 20_000);
        child
    }

    /// What it has heard, interleaved.
    fn heard(&self, mut child: Child, file: &str) -> Vec<f32> {
        signal(&child, "INT");
        child.wait().unwrap();
        let bytes = fs::read(self.folder.join(file)).unwrap();
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    }
}

/// A server.
fn served(folder: &PathBuf) -> Child {
    let socket =
        format!("module-native-protocol-unix socket={} auth-anonymous=1", folder.join("native").display());
    let mut server = in_folder(folder, "pulseaudio");
    server.args(["-n", "--daemonize=no", "--exit-idle-time=-1", "--use-pid-file=no", "--disallow-exit"]);
    for module in [&sink("glove"), &sink("belt"), &socket] {
        server.args(["-L", module]);
    }
    let says = fs::File::create(folder.join("says")).unwrap();
    server.stdout(Stdio::null()).stderr(says).spawn().unwrap()
}

fn in_folder(folder: &PathBuf, program: &str) -> Command {
    let mut command = Command::new(program);
    command
        .env("XDG_RUNTIME_DIR", folder)
        .env_remove("XDG_CONFIG_HOME")
        .env("HOME", folder)
        .env("PULSE_RUNTIME_PATH", folder)
        .env("PULSE_SERVER", format!("unix:{}", folder.join("native").display()))
        .current_dir(folder)
        .stdin(Stdio::null());
    command
}

impl Drop for Rig {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
        let _ = fs::remove_dir_all(&self.folder);
    }
}

#[test]
fn a_second_program_hears_every_channel_to_the_bit() {
    let Some(rig) = Rig::new("bits") else { return };
    scene(&rig.folder, CHANNELS);
    let render = ["render", "patch.toml", "--rig", "rig.toml", "-o", "offline.wav", "--duration", "1.2"];
    assert!(rig.program(&render).output().unwrap().status.success());
    let offline = floats(&rig.folder.join("offline.wav"));
    heard_to_the_bit(&offline, CHANNELS, || {
        let recorder = rig.record("glove", "heard.raw");
        let play = ["play", "patch.toml", "--rig", "rig.toml", "--device", "pulseaudio:glove"];
        let played = rig.program(&play).args(["--block", "1024", "--duration", "2"]).output().unwrap();
        let said =
            String::from_utf8_lossy(&played.stdout).into_owned() + &String::from_utf8_lossy(&played.stderr);
        std::thread::sleep(Duration::from_millis(500));
        let heard = rig.heard(recorder, "heard.raw");
        assert!(played.status.success(), "{said}");
        (heard, said)
    });
}

/// The sink's jacks in ALSA's order: what a person is told of where their channels leave is where they are heard.
#[test]
fn channels_leave_by_their_names_and_that_is_told() {
    let Some(rig) = Rig::new("names") else { return };
    let alsa = "front-left,front-right,rear-left,rear-right,front-center,lfe";
    for (name, count, map) in [("jacks", 6, alsa), ("numbers", 4, "aux0,aux1,aux2,aux3")] {
        let words = [
            format!("sink_name={name}"),
            format!("channels={count}"),
            format!("channel_map={map}"),
            "rate=48000".into(),
            "format=float32le".into(),
        ];
        let module = ["load-module", "module-null-sink"].into_iter().chain(words.iter().map(String::as_str));
        rig.pactl(&module.collect::<Vec<_>>()).unwrap();
    }
    let play = |device: &str, seconds: &str| {
        let play = ["play", "patch.toml", "--rig", "rig.toml", "--block", "1024", "--device", device];
        let played = rig.program(&play).args(["--duration", seconds]).output().unwrap();
        let said = String::from_utf8_lossy(&played.stderr).into_owned();
        assert!(played.status.success(), "{said}");
        said
    };
    scene(&rig.folder, 4);
    let said = play("pulseaudio:numbers", "0.3");
    assert!(said.contains("numbers has none for channels 1, 2, 3, 4:"), "{said}");
    scene(&rig.folder, 6);
    let render = ["render", "patch.toml", "--rig", "rig.toml", "-o", "offline.wav", "--duration", "1.2"];
    assert!(rig.program(&render).output().unwrap().status.success());
    let offline = floats(&rig.folder.join("offline.wav"));
    heard_to_the_bit(&offline, 6, || {
        let recorder = rig.record_as("jacks", "heard.raw", 6, alsa);
        let said = play("pulseaudio:jacks", "2");
        assert!(said.contains("channels 3, 4, 5, 6 leave on 5, 6, 3, 4 of jacks"), "{said}");
        std::thread::sleep(Duration::from_millis(500));
        let heard = rig.heard(recorder, "heard.raw");
        let by_number =
            heard.chunks_exact(6).flat_map(|frame| [0, 1, 4, 5, 2, 3].map(|place| frame[place])).collect();
        (by_number, said)
    });
}

/// It plays on the sink that is the default by then, whatever hangs there.
#[test]
fn who_names_the_system_alone_has_named_no_device() {
    let Some(rig) = Rig::new("default") else { return };
    scene(&rig.folder, CHANNELS);
    for (device, lowered) in [("pulseaudio", true), ("pulseaudio:glove", false)] {
        let play = ["play", "patch.toml", "--rig", "rig.toml", "--duration", "0.3", "--device", device];
        let played = rig.program(&play).output().unwrap();
        let said = String::from_utf8_lossy(&played.stderr);
        assert!(played.status.success() && said.contains("at -20 dB: --arm") == lowered, "{device}: {said}");
    }
}

/// It would take any number, and mix them by their names.
#[test]
fn channels_that_a_sink_does_not_have_are_refused() {
    let Some(rig) = Rig::new("few") else { return };
    scene(&rig.folder, 8);
    let play =
        ["play", "patch.toml", "--rig", "rig.toml", "--device", "pulseaudio:glove", "--duration", "0.5"];
    let played = rig.program(&play).output().unwrap();
    let said = String::from_utf8_lossy(&played.stderr);
    assert!(!played.status.success(), "{said}");
    assert!(said.contains("8 channels are not offered") && said.contains("it offers 24"), "{said}");
}

/// The sink goes, and the server moves the stream to another: that one hears it for no longer than it takes to look, and is not played on.
#[test]
fn a_stream_that_is_moved_without_a_word_is_shut() {
    let Some(rig) = Rig::new("moved") else { return };
    let mut playing = rig.hum();
    let sounds = rig.record("glove", "first.raw");
    std::thread::sleep(Duration::from_millis(4000));
    assert!(hums(&rig.heard(sounds, "first.raw"), CHANNELS), "{}", playing.text());

    // Each look would keep a connection, of which the server has 64 for all programs.
    let clients = rig.pactl(&["list", "short", "clients"]).unwrap();
    assert!(clients.lines().count() < 8, "{clients}");

    // A server that does not answer for a while holds nothing up, and is come back to.
    signal(&rig.server, "STOP");
    let gone = || playing.says("the device is gone");
    wait("the loss", || gone() == 1);
    std::thread::sleep(Duration::from_millis(1500));
    signal(&rig.server, "CONT");
    wait("its return", || playing.says("the device is back") == 1);
    std::thread::sleep(Duration::from_millis(500));

    let recorder = rig.record("belt", "other.raw");
    rig.unload("glove");
    wait("the move", || playing.says("moved the stream") == 1);
    std::thread::sleep(Duration::from_millis(2500));
    let other = rig.heard(recorder, "other.raw");
    let sounding = other.chunks(CHANNELS as usize).filter(|frame| frame.iter().any(|x| *x != 0.0)).count();
    // A look is due ten times a second; the server holds a few blocks more.
    assert!(sounding < 24_000, "{sounding} frames");
    assert!(
        other[other.len() - 48_000 * CHANNELS as usize..].iter().all(|x| *x == 0.0),
        "it is still played on"
    );

    rig.load("glove");
    wait("its return", || playing.says("the device is back") == 2);
    let recorder = rig.record("glove", "again.raw");
    std::thread::sleep(Duration::from_millis(4000));
    let again = rig.heard(recorder, "again.raw");
    let peak = again.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    assert!(hums(&again, CHANNELS), "it sounds again: {peak} of {}, {}", again.len(), playing.text());
    playing.interrupt();
}

/// Somebody leads the stream to another sink with a mixer's window: it is shut there, and goes on where it was opened. The session's clock goes on
/// all the while, and does not stand still for the two seconds of its own that an idle sink plays first.
#[test]
fn a_stream_that_somebody_leads_elsewhere_goes_back() {
    let Some(rig) = Rig::new("led") else { return };
    let mut playing = rig.hum();
    let sounds = rig.record("glove", "first.raw");
    std::thread::sleep(Duration::from_millis(3000));
    assert!(hums(&rig.heard(sounds, "first.raw"), CHANNELS), "{}", playing.text());
    for round in 1..=3 {
        let recorder = rig.record("belt", "other.raw");
        rig.lead("sink-input", "belt");
        wait("the move", || playing.says("moved the stream") == round);
        wait("its return", || playing.says("the device is back") == round);
        std::thread::sleep(Duration::from_millis(1000));
        let other = rig.heard(recorder, "other.raw");
        let sounding = other.chunks(CHANNELS as usize).filter(|f| f.iter().any(|x| *x != 0.0)).count();
        assert!(sounding < 24_000, "{sounding} frames");
        let tail = &other[other.len() - 24_000 * CHANNELS as usize..];
        assert!(tail.iter().all(|x| *x == 0.0), "it is still played on");
    }
    let recorder = rig.record("glove", "again.raw");
    std::thread::sleep(Duration::from_millis(3000));
    assert!(hums(&rig.heard(recorder, "again.raw"), CHANNELS), "{}", playing.text());
    playing.interrupt();
    clock_went_on(&rig.folder.join("s.jsonl"), 10);
}

/// What is listened to comes from one source, and from no other to which somebody leads the stream.
#[test]
fn an_input_that_somebody_leads_elsewhere_goes_back() {
    let Some(rig) = Rig::new("ear") else { return };
    scene(&rig.folder, CHANNELS);
    let listens = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nstart = \"always\"\noutput = \"i\"\n[voice.v.nodes]\n\
                   i = { type = \"input\", channel = 1 }\n";
    fs::write(rig.folder.join("listens.toml"), listens).unwrap();
    let mut play =
        rig.program(&["play", "listens.toml", "--rig", "rig.toml", "--device", "pulseaudio:glove"]);
    play.args(["--input-device", "pulseaudio:belt.monitor", "--block", "1024"]);
    let mut playing = Playing::start(play, rig.folder.join("told"));
    wait("the beginning", || playing.says("plays on") == 1);
    std::thread::sleep(Duration::from_millis(1000));
    for round in 1..=3 {
        rig.lead("source-output", "glove.monitor");
        wait("the move", || playing.says("moved the input") == round);
        wait("its return", || playing.says("the input device is back") == round);
        std::thread::sleep(Duration::from_millis(500));
    }
    playing.interrupt();
}

/// A server that is killed takes the stream with it; another one in its place has the same sink, and that one is played on again.
#[test]
fn a_server_that_is_killed_and_comes_back_is_played_on_again() {
    let Some(mut rig) = Rig::new("killed") else { return };
    let mut playing = rig.hum();
    let kills = kills(5);
    for round in 1..=kills {
        std::thread::sleep(Duration::from_millis(500));
        rig.dies_and_comes_back();
        wait("the loss", || playing.says("the device is gone") == round);
        wait("its return", || playing.says("the device is back") == round);
        assert!(playing.goes_on(), "{}", playing.text());
    }
    let recorder = rig.record("glove", "again.raw");
    std::thread::sleep(Duration::from_millis(3000));
    let again = rig.heard(recorder, "again.raw");
    assert!(hums(&again, CHANNELS), "{}", playing.text());
    playing.interrupt();
    clock_went_on(&rig.folder.join("s.jsonl"), 2 * kills);
}
