//! What a session has played is played again from its journal, to the bit; and a journal that was tampered with is refused where it is
//! wrong.

mod bits;
mod edited;
mod flood;
mod gaps;
mod knob;
#[path = "../common/scripted.rs"]
mod scripted;
mod shed;
mod steps;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use pacinian::graph::scene::Options;
use pacinian::io::journal::reader::{Item, Reader};
use pacinian::io::journal::remake::Recordings;
use pacinian::io::journal::replay::{Met, Replay};
use pacinian::io::journal::{COLUMNS, Kind, Line, Setting, of_bytes};
use pacinian::io::session::Session;
use pacinian::io::wav::WavReader;
use pacinian::live::provenance::{Provenance, RigText, Text};
use pacinian::live::reload::Reload;
use pacinian::node::asset::NoAssets;
use pacinian::{Patch, Rig};

/// Three tactors, one of them calibrated by a file.
const RIG: &str = r#"format = "pacinian-rig/1"
[device]
channels = 3
full_scale_volts = 1.0
[calibration.c]
date = 2026-03-14
method = "none, in a test"
area = 1e-4
unit = "um/V"
table = "c.csv"
[[tactor]]
name = "t1"
channel = 1
position = [0.0, 0.0]
[[tactor]]
name = "t2"
channel = 2
position = [0.04, 0.0]
calibration = "c"
[[tactor]]
name = "t3"
channel = 3
position = [0.08, 0.0]
"#;
const TABLE: &str = "frequency,output\n20,60\n150,21\n400,3\n";

fn rig() -> Rig {
    let mut rig = Rig::parse("r.toml", RIG.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    rig.calibrations[0].take(TABLE).unwrap();
    rig
}

const PATCH: &str = r#"format = "pacinian-patch/1"
title = "t"
[control.strength]
default = 0.8
range = [0.0, 1.0]
smoothing = 0.02
[shared.nodes]
sway = { type = "lfo", rate = 23 }
[voice.hum]
start = "always"
output = "s"
[voice.hum.nodes]
s = { type = "sine", frequency = 100, amplitude = 0.1 }
[voice.tap]
output = "o"
place = "t2"
voices = 6
[voice.tap.defaults]
frequency = 120
bite = 0.5
[voice.tap.nodes]
s = { type = "sine", frequency = "event.frequency" }
n = { type = "white", amplitude = "event.bite" }
m = { type = "add", inputs = ["s", "n"] }
e = { type = "envelope", attack = 0.001, release = 0.005 }
o = { type = "multiply", inputs = ["m", "e", "strength"] }
[pattern.walk]
jitter = { at = 0.01, level = 0.2 }
events = [
  { at = 0.0, voice = "tap", duration = 0.02, place = "t1", level = 0.5 },
  { at = 0.05, choose = [{ voice = "tap", duration = 0.03, place = "t3" }, { voice = "tap", duration = 0.01, frequency = 233 }] },
  { at = 0.07, voice = "tap", duration = 0.02, felt = 26 },
]
repeat = { every = 0.1 }
[[trigger]]
on = "midi.note"
play = "tap"
place = "t2"
[[trigger]]
on = "start"
play = "walk"
[[trigger]]
on = "node.sway falls 0.3"
play = "tap"
place = "t3"
hold = 0.05
set = { level = 0.3, duration = 0.01 }
"#;

fn reload(text: &str) -> Reload {
    let options = Options { rate: Some(48_000.0), live: true, seed: Some(7), ..Options::default() };
    let tables = vec![named("c.csv", TABLE)];
    staged(text, rig(), (RigText::Text(named("r.toml", RIG)), tables), &options)
}

fn named(name: &str, text: &str) -> Text {
    Text { name: name.into(), sha256: of_bytes(text.as_bytes()), text: text.into() }
}

/// A patch on a rig that is called so, with what a journal writes of them.
fn staged(text: &str, rig: Rig, (called, tables): (RigText, Vec<Text>), options: &Options) -> Reload {
    let patch = Patch::parse("t.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let provenance = Provenance {
        patch: named("t.toml", text),
        rig: called,
        tables,
        folder: ".".into(),
        allow_outside: false,
        files: Vec::new(),
        song: None,
        set: Vec::new(),
        notes: None,
        options: options.into(),
    };
    let reload = Reload::of(patch, rig, options, &NoAssets).unwrap_or_else(|p| panic!("{p}"));
    Reload { provenance: Some(Arc::new(provenance)), ..reload }
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("pacinian-journal-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn until(session: &Session, frame: u64) {
    let begin = Instant::now();
    while session.board().frames.get() < frame {
        assert!(begin.elapsed() < Duration::from_secs(30), "the card stands still");
        std::thread::sleep(Duration::from_millis(1));
    }
}

/// On the virtual card, at its full level.
fn setting() -> Setting {
    Setting::on("virtual", true)
}

/// All samples of a recording.
fn recorded(path: &Path) -> Vec<f32> {
    let mut all = Vec::new();
    let add = |frame: &[f32]| {
        all.extend_from_slice(frame);
        Ok(())
    };
    WavReader::open(path).unwrap().each_frame(add).unwrap();
    all
}

/// All frames of a replay.
fn replayed(path: &Path) -> (Vec<f32>, Met) {
    let mut replay = Replay::open(path, Recordings::default()).unwrap_or_else(|error| panic!("{error}"));
    let mut all = Vec::new();
    while let Some(frames) = replay.block().unwrap_or_else(|error| panic!("{error}")) {
        all.extend_from_slice(frames);
    }
    (all, replay.met())
}

fn lines(path: &Path) -> Vec<Line> {
    let mut reader = Reader::open(path).unwrap();
    let mut lines = Vec::new();
    while let Some(item) = reader.read().unwrap() {
        if let Item::Line(line) = item {
            lines.push(*line);
        }
    }
    lines
}

#[test]
fn the_document_explains_every_column_and_kind() {
    let text = include_str!("../../docs/journal.md");
    for word in COLUMNS.iter().filter(|column| **column != "kind") {
        assert!(text.contains(&format!("`{word}`")), "{word}");
    }
    for kind in Kind::ALL {
        assert!(text.contains(&format!("`{}`", kind.word())), "{kind:?}");
    }
}
