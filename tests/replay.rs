//! What is kept of a session, through the program.

use std::path::PathBuf;
use std::process::{Command, Output};

struct Room(PathBuf);

impl Room {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("pacinian-replay-{name}-{}", std::process::id()));
        std::fs::create_dir_all(folder.join("sounds")).unwrap();
        let from = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("patches/recordings/felt.wav");
        std::fs::copy(from, folder.join("sounds/felt.wav")).unwrap();
        std::fs::write(folder.join("p.toml"), PATCH).unwrap();
        Self(folder)
    }

    fn run(&self, arguments: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pacinian"));
        command.args(arguments).current_dir(&self.0).env_remove("NO_COLOR").output().unwrap()
    }
}

impl Drop for Room {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

const PATCH: &str = r#"format = "pacinian-patch/1"
title = "Felt"
[control.strength]
default = 0.9
[voice.rub]
output = "o"
[voice.rub.nodes]
s = { type = "sample", file = "sounds/felt.wav" }
e = { type = "envelope", release = 0.01 }
o = { type = "multiply", inputs = ["s", "e", "strength"] }
[pattern.p]
events = [{ at = 0.0, voice = "rub", duration = 0.1 }, { at = 0.2, voice = "rub", duration = 0.1, place = "t2" }]
repeat = { every = 0.4 }
"#;

const PLAY: [&str; 8] =
    ["play", "p.toml", "--device", "virtual", "--duration", "0.6", "--set", "strength=0.5"];

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn a_session_is_kept_and_played_again() {
    let room = Room::new("kept");
    let kept = room.run(&[&PLAY[..], &["--record", "s.wav", "--events", "s.csv"]].concat());
    assert!(kept.status.success(), "{}", text(&kept.stderr));
    assert!(text(&kept.stderr).contains("pacinian replay s.csv plays it again"), "{}", text(&kept.stderr));
    let again = room.run(&["replay", "s.csv", "--against", "s.wav", "-o", "again.wav"]);
    assert!(again.status.success(), "{}{}", text(&again.stdout), text(&again.stderr));
    assert!(text(&again.stdout).contains("the same, to the bit"), "{}", text(&again.stdout));
    let json = room.run(&["replay", "s.csv", "--against", "again.wav", "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    assert_eq!(summary["comparison"]["identical"], true);
    assert_eq!((&summary["whole"], summary["events"].as_u64() > Some(2)), (&true.into(), true));

    // A sample that is another one is found.
    let mut bytes = std::fs::read(room.0.join("again.wav")).unwrap();
    let middle = bytes.len() / 2 / 4 * 4 + 3;
    bytes[middle] ^= 0x10;
    std::fs::write(room.0.join("again.wav"), bytes).unwrap();
    let other = room.run(&["replay", "s.csv", "--against", "again.wav"]);
    assert_eq!(other.status.code(), Some(1), "{}", text(&other.stdout));
    assert!(text(&other.stdout).contains("different: first in frame"), "{}", text(&other.stdout));

    // The patch is in the journal; a recording must be what it was.
    std::fs::remove_file(room.0.join("p.toml")).unwrap();
    assert!(room.run(&["replay", "s.csv", "--against", "s.wav"]).status.success());
    std::fs::create_dir_all(room.0.join("elsewhere")).unwrap();
    std::fs::rename(room.0.join("sounds"), room.0.join("elsewhere/sounds")).unwrap();
    let gone = room.run(&["replay", "s.csv", "--against", "s.wav"]);
    assert_eq!(gone.status.code(), Some(66), "{}", text(&gone.stderr));
    let found = room.run(&["replay", "s.csv", "--against", "s.wav", "--folder", "elsewhere"]);
    assert!(found.status.success(), "{}", text(&found.stderr));
    let felt = room.0.join("elsewhere/sounds/felt.wav");
    let mut bytes = std::fs::read(&felt).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&felt, bytes).unwrap();
    let changed = room.run(&["replay", "s.csv", "--folder", "elsewhere"]);
    assert_eq!(changed.status.code(), Some(65));
    assert!(text(&changed.stderr).contains("is not what was played"), "{}", text(&changed.stderr));
}

#[test]
fn files_that_cannot_be_are_refused_before_anything_plays() {
    let room = Room::new("refused");
    for (arguments, says) in [
        (&["--events", "s.txt"][..], ".csv for a table or .jsonl"),
        (&["--events", "s"], ".csv for a table or .jsonl"),
        (&["--events", "-"], ".csv for a table or .jsonl"),
        (&["--record", "-"], "name a file: --record FILE"),
        (&["--record", "s.mp3"], "sound is WAV"),
        (&["--record", "p.toml"], "read for this rendering"),
        (&["--record", "sounds/felt.wav"], "read for this rendering"),
        (&["--record", "none/s.wav"], "folder is not there"),
        (&["--record", "s.wav", "--events", "./s.wav"], ".csv for a table"),
        (&["--record", "s.wav", "--events", "none/s.csv"], "folder is not there"),
    ] {
        let refused = room.run(&[&PLAY[..], arguments].concat());
        assert!(!refused.status.success(), "{arguments:?}");
        assert!(text(&refused.stderr).contains(says), "{arguments:?}: {}", text(&refused.stderr));
        assert!(!room.0.join("s.wav").exists(), "{arguments:?}");
    }
    let nothing = room.run(&["replay", "p.toml"]);
    assert_eq!(nothing.status.code(), Some(65));
    assert!(text(&nothing.stderr).contains("p.toml:1: this is no journal"), "{}", text(&nothing.stderr));
    assert_eq!(room.run(&["replay", "none.csv"]).status.code(), Some(66));
}

/// A full disk is told of, and playing goes on to its end.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_does_not_stop_the_session() {
    let room = Room::new("full");
    std::os::unix::fs::symlink("/dev/full", room.0.join("full.csv")).unwrap();
    let full = room.run(&[&PLAY[..], &["--events", "full.csv"]].concat());
    let said = text(&full.stderr);
    assert_eq!(full.status.code(), Some(74), "{said}");
    assert!(said.contains("no room left"), "{said}");
    assert!(text(&full.stdout).contains("frames"), "it played: {}", text(&full.stdout));
}
