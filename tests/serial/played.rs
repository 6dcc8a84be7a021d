//! Patches on knobs that are there, through the program. Times that a line may take are far beyond what a busy machine needs.

use std::f64::consts::{PI, TAU};
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};

use crate::bench::Bench;
use crate::odrive::{FakeODrive, Names};
use crate::smartknob::FakeSmartKnob;
use crate::terminal::{Terminal, wait};

struct Room(PathBuf);

const PATCH: &str = r#"format = "pacinian-patch/1"
title = "t"
[knob.effects]
spring = { type = "spring", stiffness = 0.002 }
notches = { type = "detents", count = 24, torque = 1e-6 }
[voice.click]
output = "out"
[voice.click.nodes]
decay = { type = "envelope", attack = 0.001, decay = 0.02, sustain = 0 }
out = { type = "sine", frequency = 200, amplitude = "decay" }
[[trigger]]
on = "knob.detent notches"
play = "click"
"#;

/// Where a busy machine leaves readings out, the knob seems to jump: that is never too fast here, and is tested where no clock runs.
const ODRIVE: &str = "inertia = 2e-5\nviscous = 2e-3\npeak_torque = 0.05\nsoft_start = 0.05\nstale = 5\nrelease = 5\ndelay = 0.3\nmargin = 1\nover_speed = 1e4\n\
    controller = { type = \"odrive\", exchanges = 500, watchdog = 1, patience = 0.25, ";
const SMARTKNOB: &str = "inertia = 2e-5\nviscous = 2e-3\npeak_torque = 0.05\nstale = 0.3\ndelay = 0.3\n\
    controller = { type = \"smartknob\", strength = 0.01, ";

impl Room {
    fn new(name: &str, knob: &str, port: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("pacinian-on-line-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        std::fs::write(folder.join("p.toml"), PATCH).unwrap();
        let rig = format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nrate = 48000\n[[tactor]]\nname = \"a\"\nchannel = 1\n\
             [knob]\n{knob}port = \"{port}\" }}\n"
        );
        std::fs::write(folder.join("r.toml"), rig).unwrap();
        Self(folder)
    }

    fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pacinian"));
        command.args(arguments).current_dir(&self.0).stdin(Stdio::null());
        command
    }

    fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    fn play(&self, arguments: &[&str]) -> Child {
        let all = [&["play", "p.toml", "--rig", "r.toml", "--device", "virtual", "--block", "64"], arguments]
            .concat();
        self.command(&all).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// What it said, once it was asked to end.
fn ended(child: Child) -> String {
    let kill = Command::new("kill").args(["-s", "INT", &child.id().to_string()]).status();
    assert!(kill.unwrap().success());
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130));
    String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr)
}

fn said(child: Child) -> String {
    let output = child.wait_with_output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let all = text(&output.stdout) + &text(&output.stderr);
    assert!(output.status.success(), "{all}");
    all
}

#[test]
fn an_odrive_feels_a_patch_and_what_was_turned_is_played_again_to_the_bit() {
    // A machine that is too busy misses the line's time, and torque stays away; then it is tried again.
    (0..3).find(|attempt| an_odrive_feels(*attempt < 2)).expect("a spring");
}

/// Whether it came to rest on its spring; with `patient`, that it did not is no failure.
fn an_odrive_feels(patient: bool) -> bool {
    let terminal = Terminal::new(FakeODrive::new(Names::Old));
    let room = Room::new("odrive", ODRIVE, terminal.name());
    let keep = ["--torque", "--duration", "120", "--record", "s.wav", "--events", "s.csv"];
    let playing = room.play(&keep);
    // As in `torque_stays_away`.
    wait("exchanges", || terminal.device().exchanges > 100);
    terminal.device().hand = 1e-3;
    // Where hand and spring balance, within the turn in which it was when it was heard first.
    let off = |angle: f64| ((angle + PI).rem_euclid(TAU) - PI).abs();
    let rests = || {
        let device = terminal.device();
        off(device.plant.angle() - 0.5) < 0.02 && device.plant.speed().abs() < 0.05 && device.torque() < -9e-4
    };
    let begin = std::time::Instant::now();
    while patient && !rests() {
        if begin.elapsed() > std::time::Duration::from_secs(20) {
            println!("no spring: {}", ended(playing));
            return false;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    wait("the spring", rests);
    let all = ended(playing);
    assert!(all.contains(terminal.name()), "{all}");
    assert!(
        all.contains("which the line's own thread works out")
            && all.contains("blocks' torques came over")
            && all.contains("J went into what is felt, by the torques that were given"),
        "{all}"
    );
    wait("the last bytes", || terminal.device().state == 1);
    let left = {
        let device = terminal.device();
        (device.torque(), device.error)
    };
    assert_eq!(left, (0.0, 0));
    let again = room.run(&["replay", "s.csv", "--against", "s.wav", "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&again.stdout)
        .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&again.stderr)));
    assert_eq!(summary["comparison"]["identical"], true, "{summary}");
    let journal = std::fs::read_to_string(room.0.join("s.csv")).unwrap();
    assert!(journal.contains("knob.detent"), "notches were passed: {journal}");
    true
}

/// A patch that listens to a card's second input as well: both are heard, and what both said is played again to the bit.
#[test]
fn a_card_is_heard_beside_the_knob() {
    let Some(bench) = Bench::new("beside") else { return };
    bench.card("microphone", "channels 2 heard \"@/heard.raw\"");
    let tone = |n: u32| (0.5 * (TAU * 200.0 * f64::from(n) / 48_000.0).sin()) as f32;
    let heard: Vec<u8> = (0..48_000 * 60).flat_map(|n| [0.0, tone(n)]).flat_map(f32::to_le_bytes).collect();
    std::fs::write(bench.folder.join("heard.raw"), heard).unwrap();
    // A machine that is too busy misses the line's time; then it is tried again.
    for attempt in 0..3 {
        let terminal = Terminal::new(FakeODrive::new(Names::Old));
        let room = Room::new("beside", ODRIVE, terminal.name());
        let listens = "[voice.v]\nstart = \"always\"\noutput = \"i\"\n[voice.v.nodes]\ni = { type = \"input\", channel = 2 }\n";
        bench.write("p.toml", &format!("{PATCH}{listens}"));
        std::fs::copy(room.0.join("r.toml"), bench.folder.join("r.toml")).unwrap();
        let with =
            |more: &[&'static str]| [&["play", "p.toml", "--rig", "r.toml", "--torque"], more].concat();
        let cards = ["--device", "card8", "--input-device", "microphone", "--duration", "120"];
        let rig = std::fs::read_to_string(bench.folder.join("r.toml")).unwrap();
        bench.write("r.toml", &rig.replace("channels = 1", "channels = 8\ncoupling = \"dc\""));
        // What an attempt before has kept is in the way.
        for name in ["s.csv", "s.wav", "s.input.wav"] {
            let _ = std::fs::remove_file(bench.folder.join(name));
        }
        let _ = std::fs::remove_file(bench.played());
        let playing = bench.start(&with(&[&cards[..], &["--events", "s.csv", "--record", "s.wav"]].concat()));
        terminal.device().hand = 1e-3;
        let off = |angle: f64| ((angle + PI).rem_euclid(TAU) - PI).abs();
        let begin = std::time::Instant::now();
        let rests = || {
            let device = terminal.device();
            off(device.plant.angle() - 0.5) < 0.02
                && device.plant.speed().abs() < 0.05
                && device.torque() < -9e-4
        };
        let sounds = || bench.samples().iter().step_by(8).rev().take(4800).any(|x| *x > 0.4);
        while begin.elapsed().as_secs() < 20 && !(rests() && sounds()) {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let both = rests() && sounds();
        let all = ended(playing);
        assert!(all.contains("it listens to microphone: channel 2 of 2 channels"), "{all}");
        assert!(all.contains(&format!("; its knob is on {}", terminal.name())), "{all}");
        assert!(!all.contains("hears silence"), "{all}");
        if !both && attempt < 2 {
            continue;
        }
        assert!(both, "{all}");
        let again = bench.run(&["replay", "s.csv", "--against", "s.wav", "--json"]);
        let summary: serde_json::Value = serde_json::from_slice(&again.stdout)
            .unwrap_or_else(|_| panic!("{}", String::from_utf8_lossy(&again.stderr)));
        assert_eq!(summary["comparison"]["identical"], true, "{summary}");
        // Where no card is named, the patch hears silence and says so; the knob is there.
        let told = said(bench.start(&with(&["--device", "card8", "--duration", "0.5"])));
        assert!(told.contains("hears silence") && told.contains(terminal.name()), "{told}");
        return;
    }
}

#[test]
fn nothing_turns_until_somebody_asks() {
    let terminal = Terminal::new(FakeODrive::new(Names::Old));
    let room = Room::new("off", ODRIVE, terminal.name());
    terminal.device().hand = 1e-3;
    let playing = room.play(&["--duration", "120"]);
    // The hand is alone with the bearing.
    wait("many exchanges", || {
        let device = terminal.device();
        device.exchanges > 200 && device.plant.angle() > 1.0
    });
    ended(playing);
    let device = terminal.device();
    assert!(device.made.iter().all(|(_, torque)| *torque == 0.0), "{:?}", device.made);
}

#[test]
fn torque_of_a_line_that_stalled_stays_away_when_it_is_back() {
    // A machine that is too busy misses the short time that a reading may be old here, and torque never rises; then it is tried again.
    (0..5).find(|attempt| torque_stays_away(*attempt < 4)).expect("torque");
}

/// Whether torque was there to be lost; with `patient`, that it never was is no failure.
fn torque_stays_away(patient: bool) -> bool {
    let terminal = Terminal::new(FakeODrive::new(Names::Old));
    let quick = ODRIVE.replace("stale = 5", "stale = 0.3").replace("release = 5", "release = 0.1");
    let room = Room::new("stall", &quick, terminal.name());
    let mut playing = room.play(&["--torque", "--duration", "60"]);
    // It is pushed once it is read: what turns meanwhile seems to jump where a busy machine has left readings out, and is then too fast.
    wait("exchanges", || terminal.device().exchanges > 100);
    terminal.device().hand = 1e-3;
    let pulls = || terminal.device().torque() < -5e-4;
    let begin = std::time::Instant::now();
    while patient && !pulls() {
        if begin.elapsed() > std::time::Duration::from_secs(30) {
            playing.kill().unwrap();
            println!("no torque: {:?}", playing.wait_with_output().unwrap());
            return false;
        }
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
    wait("torque", pulls);
    let now = terminal.now();
    terminal.device().mischief.stall = Some((now, now + 3.0));
    wait("its end", || terminal.device().torque() == 0.0);
    wait("the end of the stall", || terminal.now() > now + 3.1);
    let before = terminal.device().exchanges;
    wait("exchanges", || terminal.device().exchanges > before + 300);
    assert_eq!(terminal.device().torque(), 0.0);
    let from = terminal.device().made.iter().rposition(|(_, torque)| *torque != 0.0).unwrap();
    assert!(terminal.device().made[from].0 < now + 3.0, "it came back by itself");
    playing.kill().unwrap();
    let all = playing.wait_with_output().unwrap();
    let all = String::from_utf8_lossy(&all.stdout).into_owned() + &String::from_utf8_lossy(&all.stderr);
    assert!(all.contains("no answer"), "{all}");
    // Killed, it leaves a board whose watchdog stops the motor.
    wait("the watchdog", || terminal.device().error == 0x800);
    true
}

#[test]
fn what_is_no_knob_gets_no_torque() {
    for echo in [true, false] {
        let terminal = Terminal::new(FakeODrive::new(Names::Old));
        let room = Room::new(if echo { "echo" } else { "flood" }, ODRIVE, terminal.name());
        terminal.device().mischief.echo = echo;
        if !echo {
            terminal.device().mischief.flood = 1e5;
        }
        let all = said(room.play(&["--torque", "--duration", "10"]));
        assert!(all.contains(if echo { "says back" } else { "that nobody asked for" }), "{all}");
        assert!(terminal.device().made.iter().all(|(_, torque)| *torque == 0.0));
    }
}

#[test]
fn a_smartknob_is_told_what_to_be_once_somebody_asks() {
    for asked in [true, false] {
        let terminal = Terminal::new(FakeSmartKnob::new(false));
        let room = Room::new(if asked { "smart" } else { "limp" }, SMARTKNOB, terminal.name());
        let arguments: &[&str] =
            if asked { &["--torque", "--duration", "120"] } else { &["--duration", "120"] };
        let playing = room.play(arguments);
        wait("a configuration", || !terminal.device().taken.is_empty());
        if asked {
            wait("what it is to be", || terminal.device().taken.contains(&b"pacinian".to_vec()));
        }
        let all = ended(playing);
        let device = terminal.device();
        assert_eq!(device.taken.contains(&b"pacinian".to_vec()), asked, "{all}");
        assert_eq!(device.taken.last().unwrap(), b"pacinian: torque off");
        // A spring beside notches it cannot be.
        assert_eq!(all.contains("rendered by the knob"), asked, "{all}");
        assert!(!device.calibrated && device.commands.is_empty());
    }
}

/// What is saved while it plays is told to a knob that renders by itself, where it stands: that its torque is off, as of any knob that becomes
/// another, and once somebody asks again, what it is now.
#[test]
fn a_smartknob_becomes_what_is_saved() {
    let terminal = Terminal::new(FakeSmartKnob::new(false));
    let room = Room::new("saved", SMARTKNOB, terminal.name());
    let notches = |count: u32| {
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[knob.effects]\n\
             notches = {{ type = \"detents\", count = {count}, torque = 1e-3 }}\n"
        );
        std::fs::write(room.0.join("p.toml"), text).unwrap();
    };
    notches(24);
    let free = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = free.local_addr().unwrap().port().to_string();
    drop(free);
    let playing = room.play(&["--torque", "--watch", "--duration", "120", "--osc", &port]);
    let is = |count: f64| (terminal.device().width() * count / TAU - 1.0).abs() < 1e-3;
    wait("24 notches", || is(24.0));
    notches(16);
    let limp = || terminal.device().taken.last().is_some_and(|taken| taken == b"pacinian: torque off");
    wait("no torque", limp);
    let on = rosc::OscMessage { addr: "/torque".into(), args: vec![1.into()] };
    let on = rosc::encoder::encode(&rosc::OscPacket::Message(on)).unwrap();
    let surface = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    wait("16 notches", || {
        surface.send_to(&on, format!("127.0.0.1:{port}")).unwrap();
        is(16.0)
    });
    let all = ended(playing);
    assert!(limp(), "{all}");
}

#[test]
fn a_port_that_is_not_there_is_told() {
    let room = Room::new("none", ODRIVE, "/dev/pacinian-none");
    let output = room.run(&["play", "p.toml", "--rig", "r.toml", "--device", "virtual", "--duration", "1"]);
    let told = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(69), "{told}");
    assert!(told.contains("/dev/pacinian-none"), "{told}");
    // Simulated, nothing is opened; and check says what it bears.
    let simulated = room.run(&[
        "play",
        "p.toml",
        "--rig",
        "r.toml",
        "--device",
        "virtual",
        "--duration",
        "0.2",
        "--simulated",
    ]);
    assert!(simulated.status.success(), "{}", String::from_utf8_lossy(&simulated.stderr));
    let checked = room.run(&["check", "p.toml", "--rig", "r.toml"]);
    let checked = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert!(checked.contains("N m/rad"), "{checked}");
    // Two exchanges and 2 ms of the line, at 8 kHz.
    assert!(
        checked.contains("torque is 2400 ticks late, 48 where it depends on the angle alone"),
        "{checked}"
    );
}
