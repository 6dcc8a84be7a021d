//! Playing through PipeWire to a second program, `pw-record`, and what happens when its sink or the server goes away.
//!
//! It needs the feature `pipewire`, and pipewire, wireplumber and dbus-daemon (on Debian packages of these names, and pipewire-bin). They run
//! in a folder of the test's own, with a sink that has no hardware. Where one is missing, a test says that it was skipped, and why.
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
const DEVICE: &str = "pipewire:glove";

/// One server at a time leaves the others the processor.
static ALONE: Mutex<()> = Mutex::new(());

/// A server with its session manager, and a folder of a test's own.
struct Rig {
    folder: PathBuf,
    /// In the order in which they were started.
    running: Vec<Child>,
    _alone: MutexGuard<'static, ()>,
}

fn sink(name: &str, channels: u32) -> String {
    let position: String = (0..channels).map(|n| format!("AUX{n} ")).collect();
    format!(
        "{{ factory.name = support.null-audio-sink node.name = {name} node.description = {name} media.class = Audio/Sink audio.rate = 48000 \
         audio.channels = {channels} audio.position = [ {position}] object.linger = true monitor.channel-volumes = false }}"
    )
}

impl Rig {
    fn new(name: &str) -> Option<Self> {
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        for program in ["pipewire", "wireplumber", "dbus-daemon", "pw-record", "pw-cli", "pw-metadata"] {
            if let Err(error) = Command::new(program).arg("--version").stdout(Stdio::null()).status() {
                bench::skipped(format!("{program}: {error}"));
                return None;
            }
        }
        let folder = std::env::temp_dir().join(format!("pacinian-pw-{}-{name}", std::process::id()));
        fs::create_dir_all(folder.join("config/pipewire/pipewire.conf.d")).unwrap();
        // A quantum that a busy machine keeps up with.
        let config = format!(
            "context.properties = {{ default.clock.rate = 48000 default.clock.allowed-rates = [ 48000 ] default.clock.quantum = 1024 \
             default.clock.min-quantum = 1024 default.clock.max-quantum = 2048 }}\n\
             context.objects = [ {{ factory = adapter args = {} }} ]\n",
            sink("glove", CHANNELS)
        );
        fs::write(folder.join("config/pipewire/pipewire.conf.d/sink.conf"), config).unwrap();
        let mut rig = Self { folder, running: Vec::new(), _alone: alone };
        rig.start();
        Some(rig)
    }

    fn start(&mut self) {
        self.run("pipewire", &[]);
        wait("the server", || self.has("glove"));
        let address = format!("--address={}", self.bus());
        self.run("dbus-daemon", &["--session", "--nofork", "--nopidfile", &address]);
        wait("the bus", || self.folder.join("bus").exists());
        self.run("wireplumber", &[]);
        // It says which is the default, a little later.
        wait("the session manager", || {
            let told = self.command("pw-metadata").args(["0", "default.audio.sink"]).output().unwrap();
            String::from_utf8_lossy(&told.stdout).contains("\"name\"")
        });
    }

    fn run(&mut self, program: &str, arguments: &[&str]) {
        let says = fs::File::create(self.folder.join(program)).unwrap();
        let mut command = self.command(program);
        let child = command.args(arguments).stdout(Stdio::null()).stderr(says).spawn();
        self.running.push(child.unwrap_or_else(|error| panic!("{program}: {error}")));
    }

    fn bus(&self) -> String {
        format!("unix:path={}", self.folder.join("bus").display())
    }

    /// Whether the server has a node of that name.
    fn has(&self, name: &str) -> bool {
        self.node(name).is_some()
    }

    fn make(&self, sink_name: &str, channels: u32) {
        let made =
            self.command("pw-cli").args(["create-node", "adapter", &sink(sink_name, channels)]).status();
        assert!(made.unwrap().success());
        wait("a sink", || self.has(sink_name));
    }

    fn destroy(&self, name: &str) {
        let node = self.node(name).unwrap();
        assert!(self.command("pw-cli").args(["destroy", &node]).status().unwrap().success());
    }

    fn node(&self, name: &str) -> Option<String> {
        let listed = self.command("pw-cli").args(["ls", "Node"]).output().unwrap();
        let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
        let mut id = None;
        for line in listed.lines() {
            if let Some(rest) = line.trim().strip_prefix("id ") {
                id = rest.split(',').next().map(str::to_string);
            } else if line.trim() == format!("node.name = \"{name}\"") {
                return id;
            }
        }
        None
    }

    /// They do not come to their senses before they die.
    fn kill(&mut self) {
        for mut child in self.running.drain(..).rev() {
            let _ = child.kill();
            child.wait().unwrap();
        }
        let _ = fs::remove_file(self.folder.join("bus"));
    }

    fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(program);
        command
            .env("XDG_RUNTIME_DIR", &self.folder)
            .env("PIPEWIRE_RUNTIME_DIR", &self.folder)
            .env("XDG_CONFIG_HOME", self.folder.join("config"))
            .env("XDG_STATE_HOME", self.folder.join("state"))
            .env("DBUS_SESSION_BUS_ADDRESS", self.bus())
            .env_remove("PULSE_SERVER")
            .current_dir(&self.folder)
            .stdin(Stdio::null());
        command
    }

    fn program(&self, arguments: &[&str]) -> Command {
        let mut command = self.command(env!("CARGO_BIN_EXE_pacinian"));
        command.args(arguments);
        command
    }

    /// The scene as it is without a device.
    fn render(&self) -> Vec<f32> {
        let render = ["render", "patch.toml", "--rig", "rig.toml", "-o", "offline.wav", "--duration", "1.2"];
        assert!(self.program(&render).output().unwrap().status.success());
        floats(&self.folder.join("offline.wav"))
    }

    /// The scene is played on a device, or the default, and a sink hears `own` of it to the bit.
    fn arrives(&self, own: &[f32], (sink, channels): (&str, u32), device: &[&str]) {
        heard_to_the_bit(own, channels, || {
            let recorder = self.record(sink, channels, "heard.wav");
            let play = ["play", "patch.toml", "--rig", "rig.toml", "--block", "1024", "--duration", "2"];
            let played = self.program(&play).args(device).output().unwrap();
            let said = String::from_utf8_lossy(&played.stdout).into_owned()
                + &String::from_utf8_lossy(&played.stderr);
            std::thread::sleep(Duration::from_millis(300));
            let heard = self.heard(recorder, "heard.wav");
            assert!(played.status.success(), "{said}");
            (heard, said)
        });
    }

    /// A sink's inputs, recorded by a second program until it is told to stop; it listens when this returns.
    fn record(&self, sink: &str, channels: u32, file: &str) -> Child {
        let map: Vec<String> = (0..channels).map(|n| format!("AUX{n}")).collect();
        let mut command = self.command("pw-record");
        command.args(["--target", sink, "-P", "{ stream.capture.sink=true stream.dont-remix=true }"]);
        command.args(["--rate", "48000", "--format", "f32", "--channels", &channels.to_string()]);
        let child = command.args(["--channel-map", &map.join(","), file]).spawn().unwrap();
        let length = || fs::metadata(self.folder.join(file)).map_or(0, |about| about.len());
        wait("the recorder", || length() > 20_000);
        child
    }

    /// What it has heard, interleaved.
    fn heard(&self, mut child: Child, file: &str) -> Vec<f32> {
        signal(&child, "INT");
        child.wait().unwrap();
        floats(&self.folder.join(file))
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        self.kill();
        let _ = fs::remove_dir_all(&self.folder);
    }
}

#[test]
fn a_second_program_hears_every_channel_to_the_bit() {
    let Some(rig) = Rig::new("bits") else { return };
    scene(&rig.folder, CHANNELS);
    let offline = rig.render();
    rig.arrives(&offline, ("glove", CHANNELS), &["--device", DEVICE]);
}

/// Nobody has named a sink: as many channels are taken as the one has that the server plays on by default, and those arrive as on any other.
#[test]
fn the_default_sink_has_the_channels_that_it_has() {
    let Some(rig) = Rig::new("default") else { return };
    scene(&rig.folder, 2);
    let play = ["play", "patch.toml", "--rig", "rig.toml", "--block", "1024", "--arm"];
    for device in [&[][..], &["--device", DEVICE]] {
        let refused = rig.program(&play).args(device).args(["--duration", "0.1"]).output().unwrap();
        let said = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(69) && said.contains("it offers 24"), "{device:?}: {said}");
    }
    scene(&rig.folder, CHANNELS);
    let offline = rig.render();
    rig.arrives(&offline, ("glove", CHANNELS), &["--arm"]);
    // Its own name for whatever it plays by default is no device that anybody has named.
    for (device, lowered) in [("pipewire:output_default", true), (DEVICE, false)] {
        let play = ["play", "patch.toml", "--rig", "rig.toml", "--duration", "0.1", "--device", device];
        let played = rig.program(&play).output().unwrap();
        let said = String::from_utf8_lossy(&played.stderr);
        assert!(played.status.success(), "{device}: {said}");
        assert_eq!(said.contains("at -20 dB: --arm"), lowered, "{device}: {said}");
    }
}

/// The sink is destroyed and made again, and then the server is killed and started again: the same device is waited for, and no other played on.
#[test]
fn a_sink_and_a_server_that_go_are_waited_for() {
    let Some(mut rig) = Rig::new("gone") else { return };
    scene(&rig.folder, CHANNELS);
    fs::write(rig.folder.join("hum.toml"), HUM).unwrap();
    let play = ["play", "hum.toml", "--rig", "rig.toml", "--device", DEVICE, "--block", "1024"];
    let play = rig.program(&[&play[..], &["--events", "s.jsonl"]].concat());
    let mut playing = Playing::start(play, rig.folder.join("told"));
    wait("the beginning", || playing.says("plays on") == 1);
    std::thread::sleep(Duration::from_millis(500));

    rig.destroy("glove");
    wait("the loss of the sink", || playing.says("the device is gone") == 1);
    std::thread::sleep(Duration::from_millis(500));
    rig.make("glove", CHANNELS);
    wait("its return", || playing.says("the device is back") == 1);

    let kills = kills(1);
    for round in 2..2 + kills {
        rig.kill();
        wait("the loss of the server", || playing.says("the device is gone") == round);
        rig.start();
        wait("its return", || playing.says("the device is back") == round);
        assert!(playing.goes_on(), "it goes on");
    }

    let recorder = rig.record("glove", CHANNELS, "heard.wav");
    std::thread::sleep(Duration::from_millis(800));
    let heard = rig.heard(recorder, "heard.wav");
    playing.interrupt();
    assert!(hums(&heard, CHANNELS), "it sounds again");
    clock_went_on(&rig.folder.join("s.jsonl"), kills);
}

/// Nobody has named a sink, and the one that it plays on goes. The server is asked not to move the stream to the other one, which hears
/// nothing until it is opened, at -20 dB, since whatever hangs there was not asked for.
#[test]
fn where_the_default_sink_goes_the_next_one_hears_a_tenth() {
    let Some(rig) = Rig::new("next") else { return };
    scene(&rig.folder, CHANNELS);
    fs::write(rig.folder.join("hum.toml"), HUM).unwrap();
    let play = rig.program(&["play", "hum.toml", "--rig", "rig.toml", "--arm", "--block", "1024"]);
    let mut playing = Playing::start(play, rig.folder.join("told"));
    wait("the beginning", || playing.says("plays on") == 1);
    std::thread::sleep(Duration::from_millis(500));

    rig.make("belt", CHANNELS);
    let recorder = rig.record("belt", CHANNELS, "heard.wav");
    rig.destroy("glove");
    wait("the loss", || playing.says("the device is gone") == 1);
    std::thread::sleep(Duration::from_millis(1500));
    let heard = rig.heard(recorder, "heard.wav");
    let loudest = heard.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    assert!((0.045..=0.0506).contains(&loudest), "{loudest}: {}", playing.text());
    playing.interrupt();
}

/// Two cards of eight channels, joined as the document says: each plays its own eight of sixteen, and nothing of the others.
#[test]
fn cards_that_are_joined_play_each_its_own() {
    let Some(mut rig) = Rig::new("joined") else { return };
    rig.kill();
    let text = include_str!("../docs/cards.md");
    let joined = text.split("```\n").find(|part| part.starts_with("context.modules")).unwrap();
    let joined = joined.replace("CARD1", "one").replace("CARD2", "two");
    fs::write(rig.folder.join("config/pipewire/pipewire.conf.d/joined.conf"), joined).unwrap();
    rig.start();
    if !rig.has("joined") {
        return bench::skipped("this PipeWire has no libpipewire-module-combine-stream");
    }
    ["one", "two"].into_iter().for_each(|card| rig.make(card, 8));
    scene(&rig.folder, 16);
    let offline = rig.render();
    for (card, first) in [("one", 0), ("two", 8)] {
        let own: Vec<f32> = offline.chunks(16).flat_map(|frame| frame[first..first + 8].to_vec()).collect();
        rig.arrives(&own, (card, 8), &["--device", "pipewire:joined"]);
    }
}
