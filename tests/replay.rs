//! What is kept of a session, through the program.

use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

use pacinian::io::journal::of_bytes;
use pacinian::io::wav::{Encoding, WavReader, WavSpec, WavWriter};

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
    fails(&gone, 66, "--folder DIR");
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

/// A patch that sounds without an end and hears.
const HEARS: &str = r#"format = "pacinian-patch/1"
title = "Ear"
[voice.hum]
start = "always"
output = "o"
[voice.hum.nodes]
s = { type = "sine", frequency = 100, amplitude = 0.1 }
i = { type = "input" }
o = { type = "add", inputs = ["s", "i"] }
"#;

/// A session of a second that hears a recording.
fn listening(name: &str) -> Room {
    let room = Room::new(name);
    std::fs::write(room.0.join("h.toml"), HEARS).unwrap();
    let play = ["play", "h.toml", "--device", "virtual", "--duration", "1.2", "--input", "sounds/felt.wav"];
    let kept = room.run(&[&play[..], &["--record", "s.wav", "--events", "s.jsonl"]].concat());
    assert!(kept.status.success(), "{}", text(&kept.stderr));
    room
}

/// What a node hears sets off the same voices again, from what was recorded; the journal tells of them, and they are not played twice.
#[test]
fn what_a_node_has_set_off_it_sets_off_again() {
    let room = Room::new("node");
    let patch = format!(
        "{HEARS}[shared.nodes]\near = {{ type = \"input\" }}\nrub = {{ type = \"follow\", input = \"ear\", attack = 0.002, release = 0.005 }}\n\
         [voice.tick]\noutput = \"o\"\nplace = \"t2\"\n[voice.tick.nodes]\ns = {{ type = \"white\", amplitude = 0.3 }}\n\
         e = {{ type = \"burst\", attack = 0.002, decay = 0.01 }}\no = {{ type = \"multiply\", inputs = [\"s\", \"e\"] }}\n\
         [[trigger]]\non = \"node.rub rises 0.1\"\nplay = \"tick\"\nset = {{ duration = 0.01 }}\n"
    );
    std::fs::write(room.0.join("n.toml"), patch).unwrap();
    let play = ["play", "n.toml", "--device", "virtual", "--duration", "1", "--input", "sounds/felt.wav"];
    let kept = room.run(&[&play[..], &["--record", "s.wav", "--events", "s.csv"]].concat());
    assert!(kept.status.success(), "{}", text(&kept.stderr));
    let journal = std::fs::read_to_string(room.0.join("s.csv")).unwrap();
    let told = journal.lines().filter(|line| line.starts_with("voice,") && line.contains(",node,")).count();
    assert!(told > 2 && journal.contains(",node.rub rises 0.1,1,"), "{told}: {journal}");
    let again = room.run(&["replay", "s.csv", "--against", "s.wav", "--json"]);
    assert!(again.status.success(), "{}{}", text(&again.stdout), text(&again.stderr));
    let summary: serde_json::Value = serde_json::from_slice(&again.stdout).unwrap();
    assert_eq!(summary["comparison"]["identical"], true);
    // The gate's orders alone were given to anybody.
    assert_eq!(summary["events"], 0);
    let end = journal.lines().find(|line| line.starts_with("end,")).unwrap();
    let voices: u64 =
        end.split(";voices=").nth(1).unwrap().split([';', ',']).next().unwrap().parse().unwrap();
    assert!(voices >= told as u64 && summary["voices"] == voices, "{summary} {voices} {told}");
    // It is what rendering makes of it, too.
    let log = [
        "render",
        "n.toml",
        "--input",
        "sounds/felt.wav",
        "--duration",
        "0.9",
        "-o",
        "r.wav",
        "--log",
        "r.csv",
    ];
    assert!(room.run(&log).status.success());
    let rendered = std::fs::read_to_string(room.0.join("r.csv")).unwrap();
    let rendered = rendered.lines().filter(|line| line.contains(",voice,node.rub rises 0.1,")).count();
    assert!(rendered > 2, "{rendered} rendered, {told} played");
}

/// A WAV file of so many bytes of the samples.
fn shortened(whole: &[u8], bytes: usize) -> Vec<u8> {
    let at = whole.windows(4).position(|word| word == b"data").unwrap() + 8;
    let mut part = whole[..at + bytes].to_vec();
    part[at - 4..at].copy_from_slice(&(bytes as u32).to_le_bytes());
    let riff = part.len() as u32 - 8;
    part[4..8].copy_from_slice(&riff.to_le_bytes());
    part
}

fn fails(output: &Output, code: i32, says: &str) {
    let said = text(&output.stderr);
    assert!(output.status.code() == Some(code) && said.contains(says), "{:?} {said}", output.status.code());
}

#[test]
fn what_was_heard_must_be_what_it_was() {
    let room = listening("heard");
    let again = room.run(&["replay", "s.jsonl", "--against", "s.wav"]);
    assert!(again.status.success(), "{}{}", text(&again.stdout), text(&again.stderr));
    let (heard, whole) = (room.0.join("s.input.wav"), std::fs::read(room.0.join("s.input.wav")).unwrap());
    let replay = || room.run(&["replay", "s.jsonl", "--against", "s.wav"]);

    let mut other = whole.clone();
    let middle = other.len() / 2 / 4 * 4 + 2;
    other[middle] ^= 0x40;
    std::fs::write(&heard, &other).unwrap();
    fails(&replay(), 65, "the SHA-256 of its samples is");

    // Cut to its first tenth of a second.
    std::fs::write(&heard, shortened(&whole, 4 * 4800)).unwrap();
    fails(&replay(), 65, "it has 4800 frames, and ");
    // Of a journal that breaks off nobody knows how much was recorded; but it is said where that ends.
    let journal = std::fs::read_to_string(room.0.join("s.jsonl")).unwrap();
    let until = journal.find("{\"kind\":\"end\"").unwrap();
    std::fs::write(room.0.join("s.jsonl"), &journal[..until]).unwrap();
    let cut = replay();
    let said = text(&cut.stdout);
    assert!(said.contains("heard ends at frame 4,800: silence"), "{said}{}", text(&cut.stderr));

    let elsewhere = journal.replace("\"input\":\"s", "\"input\":\"sounds/../s");
    std::fs::write(room.0.join("t.jsonl"), elsewhere).unwrap();
    fails(&room.run(&["replay", "t.jsonl"]), 65, "is no name of a file there");

    let rate = whole.windows(4).position(|word| word == 48_000_u32.to_le_bytes()).unwrap();
    let mut other = whole.clone();
    other[rate..rate + 4].copy_from_slice(&44_100_u32.to_le_bytes());
    std::fs::write(&heard, &other).unwrap();
    fails(&replay(), 65, "at 44100 Hz, and the session listened to 1 at 48000 Hz");
    std::fs::remove_file(&heard).unwrap();
    fails(&replay(), 66, "s.input.wav");
}

#[test]
fn a_journal_that_breaks_off_is_the_same_as_far_as_it_goes() {
    let room = listening("broken");
    let journal = std::fs::read_to_string(room.0.join("s.jsonl")).unwrap();
    let clocks = journal.lines().enumerate().filter(|(_, line)| line.contains("\"kind\":\"clock\""));
    let (last, line) = clocks.last().unwrap();
    let frame = serde_json::from_str::<serde_json::Value>(line).unwrap()["frame"].as_u64().unwrap();
    let until: Vec<&str> = journal.lines().take(last + 1).collect();
    std::fs::write(room.0.join("s.jsonl"), until.join("\n") + "\n").unwrap();
    let run = room.run(&["replay", "s.jsonl", "--against", "s.wav"]);
    let said = text(&run.stdout);
    assert_eq!(run.status.code(), Some(1), "{said}{}", text(&run.stderr));
    assert!(said.contains("frames that both have; the recording goes on for"), "{said}");
    assert!(said.contains("the journal breaks off"), "{said}");
    let json = room.run(&["replay", "s.jsonl", "--against", "s.wav", "--json"]);
    let summary: serde_json::Value = serde_json::from_slice(&json.stdout).unwrap();
    let compared = &summary["comparison"];
    assert_eq!((compared["frames"].as_u64(), compared["different"].as_u64()), (Some(frame), Some(0)));
    assert!(frame > 40_000 && compared["only_recorded"].as_u64() > Some(0), "{compared}");
}

#[test]
fn a_replay_writes_over_nothing_of_the_session() {
    let room = listening("own");
    let patch = std::fs::read(room.0.join("h.toml")).unwrap();
    std::fs::copy(room.0.join("h.toml"), room.0.join("named.wav")).unwrap();
    let journal = std::fs::read_to_string(room.0.join("s.jsonl")).unwrap();
    std::fs::write(room.0.join("s.jsonl"), journal.replace("h.toml", "named.wav")).unwrap();
    let before = |name: &str| std::fs::read(room.0.join(name)).unwrap();
    for name in ["s.input.wav", "s.wav", "named.wav"] {
        let was = before(name);
        fails(&room.run(&["replay", "s.jsonl", "-o", name]), 2, "belongs to the session itself");
        assert_eq!(before(name), was);
    }
    assert_eq!(before("named.wav"), patch);
    // The recordings that a patch names are the session's, too.
    let kept = room.run(&[&PLAY[..], &["--events", "t.csv"]].concat());
    assert!(kept.status.success(), "{}", text(&kept.stderr));
    let was = before("sounds/felt.wav");
    fails(&room.run(&["replay", "t.csv", "-o", "sounds/felt.wav"]), 2, "belongs to the session itself");
    assert_eq!(before("sounds/felt.wav"), was);
    let told = room.run(&["replay", "t.csv", "-o", "again.wav"]);
    assert!(text(&told.stderr).contains("again.wav: "), "{}", text(&told.stderr));
    assert!(room.run(&["replay", "t.csv", "-o", "again.wav"]).status.success());
}

#[test]
fn nothing_is_replaced_unless_it_is_asked_for() {
    let room = Room::new("replace");
    let (wav, csv) = (room.0.join("s.wav"), room.0.join("s.csv"));
    for (path, arguments) in [(&wav, ["--record", "s.wav"]), (&csv, ["--events", "s.csv"])] {
        std::fs::write(path, "the data of Tuesday").unwrap();
        let arguments = [&PLAY[..], &arguments].concat();
        fails(&room.run(&arguments), 73, "give another name, or --replace");
        assert_eq!(std::fs::read(path).unwrap(), b"the data of Tuesday");
        // One that does not begin has replaced nothing either.
        let gone: Vec<&str> =
            arguments.iter().map(|word| if *word == "virtual" { "no such card" } else { word }).collect();
        assert!(!room.run(&[&gone[..], &["--replace"]].concat()).status.success());
        assert_eq!(std::fs::read(path).unwrap(), b"the data of Tuesday");
        let replaced = room.run(&[&arguments[..], &["--replace"]].concat());
        assert!(replaced.status.success(), "{}", text(&replaced.stderr));
        assert!(std::fs::read(path).unwrap().len() > 1000);
        std::fs::remove_file(path).unwrap();
        // An empty one has nothing to lose.
        std::fs::write(path, "").unwrap();
        assert!(room.run(&arguments).status.success());
        std::fs::remove_file(path).unwrap();
    }
    // A port that somebody else has.
    let socket = std::net::UdpSocket::bind("127.0.0.1:0").unwrap();
    let port = socket.local_addr().unwrap().port().to_string();
    let taken = room.run(&[&PLAY[..], &["--record", "s.wav", "--events", "s.csv", "--osc", &port]].concat());
    assert!(!taken.status.success(), "{}", text(&taken.stderr));
    assert!(!wav.exists() && !csv.exists());
}

#[test]
fn a_journal_is_not_believed_about_files() {
    let room = Room::new("outside");
    std::fs::create_dir_all(room.0.join("patches")).unwrap();
    let patch = PATCH.replace("sounds/felt.wav", "../sounds/felt.wav");
    std::fs::write(room.0.join("patches/p.toml"), patch).unwrap();
    let play = ["play", "patches/p.toml", "--device", "virtual", "--duration", "0.3", "--events", "s.jsonl"];
    let kept = room.run(&[&play[..], &["--allow-outside"]].concat());
    assert!(kept.status.success(), "{}", text(&kept.stderr));
    let inside = room.run(&["replay", "s.jsonl"]);
    assert!(
        !inside.status.success() && text(&inside.stderr).contains("--allow-outside"),
        "{}",
        text(&inside.stderr)
    );
    assert!(room.run(&["replay", "s.jsonl", "--allow-outside"]).status.success());
    // What it has no digest of is not read.
    let journal = std::fs::read_to_string(room.0.join("s.jsonl")).unwrap();
    let from = journal.find(",\"files\":[").unwrap();
    let to = from + journal[from..].find(']').unwrap() + 1;
    std::fs::write(room.0.join("s.jsonl"), format!("{}{}", &journal[..from], &journal[to..])).unwrap();
    let forged = room.run(&["replay", "s.jsonl", "--allow-outside"]);
    fails(&forged, 65, "s.jsonl:2: there is no SHA-256 of `../sounds/felt.wav`");
    // Nor is a patch played that is not the one that was.
    std::fs::write(room.0.join("s.jsonl"), journal.replacen("felt.wav", "melt.wav", 1)).unwrap();
    let forged = room.run(&["replay", "s.jsonl", "--allow-outside"]);
    fails(
        &forged,
        65,
        "does not have the SHA-256 beside it; no session writes that: play the journal as it was written",
    );
}

/// Files that were removed while they were written are nowhere: that is no success. What is there may be played again as it is suggested.
#[cfg(unix)]
#[test]
fn files_that_are_gone_in_the_end_are_told_of() {
    let room = Room::new("gone");
    let folder = room.0.join("kept here");
    std::fs::create_dir(&folder).unwrap();
    let keep = ["--record", "kept here/s.wav", "--events", "kept here/s.csv", "--replace"];
    let whole = room.run(&[&PLAY[..], &keep].concat());
    let said = text(&whole.stderr);
    assert!(whole.status.success(), "{said}");
    assert!(said.contains("pacinian replay 'kept here/s.csv' plays it again"), "{said}");
    // Whether it ends by itself or is asked to.
    for (signal, code) in [(None, 74), (Some("INT"), 130)] {
        std::fs::create_dir_all(&folder).unwrap();
        let mut long = Command::new(env!("CARGO_BIN_EXE_pacinian"));
        let long = long.args(PLAY.map(|word| if word == "0.6" { "2" } else { word })).args(keep);
        let long = long.current_dir(&room.0).stdout(Stdio::null()).stderr(Stdio::piped());
        let child = long.spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_secs(1));
        std::fs::remove_dir_all(&folder).unwrap();
        if let Some(signal) = signal {
            let kill = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status();
            assert!(kill.unwrap().success());
        }
        let gone = child.wait_with_output().unwrap();
        fails(&gone, code, "`kept here/s.wav` is gone");
        fails(&gone, code, "`kept here/s.csv` is gone");
        assert!(!text(&gone.stderr).contains("plays it again"), "{}", text(&gone.stderr));
    }
}

/// Whoever looks through a journal later sees whether it was ended by its time, by a signal, or by whom else.
#[cfg(unix)]
#[test]
fn a_journal_says_who_ended_the_session() {
    let room = Room::new("ended");
    let who = |name: &str| {
        let journal = std::fs::read_to_string(room.0.join(name)).unwrap();
        let lines = journal.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
        let ends: Vec<_> = lines.filter(|line| line["kind"] == "in" && line["message"] == "end").collect();
        let [end] = &ends[..] else { panic!("{ends:?}") };
        format!("{} {}", end["source"].as_str().unwrap(), end["name"].as_str().unwrap())
    };
    assert!(room.run(&[&PLAY[..], &["--events", "time.jsonl"]].concat()).status.success());
    assert_eq!(who("time.jsonl"), "system time");
    let long = PLAY.map(|word| if word == "0.6" { "60" } else { word });
    for (signal, code) in [("INT", 130), ("TERM", 143)] {
        let name = format!("{signal}.jsonl");
        let mut play = Command::new(env!("CARGO_BIN_EXE_pacinian"));
        play.args(long).args(["--events", &name]).current_dir(&room.0);
        let child = play.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        while !std::fs::read_to_string(room.0.join(&name)).is_ok_and(|text| text.contains("\"voice\"")) {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
        assert!(sent.unwrap().success());
        let ended = child.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(code), "{}", text(&ended.stderr));
        assert_eq!(who(&name), format!("system SIG{signal}"));
    }
}

/// Who empties a file that is written leaves a hole in it, which is not told of as whole.
#[test]
fn files_that_were_cut_short_meanwhile_are_told_of() {
    let room = Room::new("cut");
    let mut long = Command::new(env!("CARGO_BIN_EXE_pacinian"));
    long.args(PLAY.map(|word| if word == "0.6" { "2" } else { word }));
    long.args(["--record", "s.wav", "--events", "s.csv"]).current_dir(&room.0);
    let child = long.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let length = |name: &str| std::fs::metadata(room.0.join(name)).map_or(0, |about| about.len());
    while length("s.wav") < 100_000 || length("s.csv") == 0 {
        std::thread::sleep(std::time::Duration::from_millis(5));
    }
    for name in ["s.wav", "s.csv"] {
        std::fs::File::options().write(true).open(room.0.join(name)).unwrap().set_len(0).unwrap();
    }
    let cut = child.wait_with_output().unwrap();
    for name in ["s.wav", "s.csv"] {
        // While it plays, and in the end.
        fails(&cut, 74, &format!("`{name}` takes no more"));
        fails(&cut, 74, &format!("`{name}` has been cut short"));
    }
    assert!(!text(&cut.stderr).contains("plays it again"), "{}", text(&cut.stderr));
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
    // Each file that may not grow is told of while it plays.
    let mut limited = std::process::Command::new("sh");
    limited.args(["-c", "ulimit -f 4; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_pacinian")]);
    limited.args(PLAY.map(|word| if word == "0.6" { "1.5" } else { word }));
    let keep = ["--record", "small.wav", "--events", "small.csv"];
    let full = limited.args(keep).current_dir(&room.0).output().unwrap();
    let said = text(&full.stderr);
    for name in ["small.wav", "small.csv"] {
        assert!(said.contains(&format!("`{name}` takes no more")), "{name}: {said}");
    }
    // One that takes not even its first bytes leaves nothing behind.
    let mut none = std::process::Command::new("sh");
    none.args(["-c", "ulimit -f 0; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_pacinian")]);
    let none = none.args(PLAY).args(["--record", "none.wav"]).current_dir(&room.0).output().unwrap();
    let said = text(&none.stderr);
    assert_eq!(none.status.code(), Some(74), "{said}");
    assert!(said.contains("`none.wav` has grown as large"), "{said}");
    assert!(!room.0.join("none.wav").exists());
}

#[test]
fn recordings_are_found_from_wherever_it_is_played_again() {
    let room = Room::new("elsewhere");
    std::fs::create_dir_all(room.0.join("mine/far")).unwrap();
    let mut wav =
        WavWriter::create(room.0.join("mine/hum.wav"), WavSpec::new(1, 8_000, Encoding::F32)).unwrap();
    wav.write(&(0..8_000).map(|n| 0.5 * (n as f32 * 0.1).sin()).collect::<Vec<_>>()).unwrap();
    wav.finish().unwrap();
    let patch = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nstart = \"always\"\noutput = \"s\"\n\
        [voice.v.nodes]\ns = { type = \"sample\", file = \"hum.wav\" }\n";
    std::fs::write(room.0.join("mine/patch.toml"), patch).unwrap();
    let play =
        ["play", "mine/patch.toml", "--device", "virtual", "--duration", "0.2", "--events", "mine/far/j.csv"];
    let kept = room.run(&play);
    assert!(kept.status.success(), "{}", text(&kept.stderr));
    let mut replay = std::process::Command::new(env!("CARGO_BIN_EXE_pacinian"));
    let again = replay
        .args(["replay", "j.csv", "-o", "again.wav"])
        .current_dir(room.0.join("mine/far"))
        .output()
        .unwrap();
    assert!(again.status.success(), "{}", text(&again.stderr));
}

/// What a knob was read to be is in the recording of what came in, and what was lost of it as well.
#[test]
fn a_session_with_a_knob_that_was_turned_is_played_again_to_the_bit() {
    let room = Room::new("knob");
    let write = |name: &str, text: &str| std::fs::write(room.0.join(name), text).unwrap();
    write(
        "knob.toml",
        "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[knob.effects]\nnotches = { type = \"detents\", count = 24, torque = 0.01 }\n\
         [voice.v]\noutput = \"o\"\nplace = 1\nnodes.o = { type = \"sine\", frequency = 200, amplitude = \"e\" }\n\
         nodes.e = { type = \"envelope\", decay = 0.01, sustain = 0 }\n[[trigger]]\non = \"knob.detent\"\nplay = \"v\"\n",
    );
    write(
        "rig.toml",
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nrate = 48000\ncoupling = \"dc\"\n[[tactor]]\nname = \"a\"\nchannel = 1\n\
         [[output]]\nkind = \"torque\"\nname = \"knob\"\nchannel = 2\n\
         [knob]\ninertia = 1e-5\nfriction = 1e-3\nviscous = 1e-2\npeak_torque = 0.01\nsoft_start = 0.05\n\
         sensor = { type = \"voltage\", channel = 1, full_scale_volts = 5, radians_per_volt = 1 }\n",
    );
    // It ends after half a second: the angle is lost, though silence would say 0.
    let mut wav =
        WavWriter::create(room.0.join("turned.wav"), WavSpec::new(1, 48_000, Encoding::F32)).unwrap();
    wav.write(&(0..24_000).map(|n| 0.4 * (n as f32 / 24_000.0)).collect::<Vec<_>>()).unwrap();
    wav.finish().unwrap();
    let kept = room.run(&[
        "play",
        "knob.toml",
        "--rig",
        "rig.toml",
        "--input",
        "turned.wav",
        "--device",
        "virtual",
        "--duration",
        "1",
        "--torque",
        "--record",
        "s.wav",
        "--events",
        "s.csv",
    ]);
    assert!(kept.status.success(), "{}", text(&kept.stderr));
    let told = text(&kept.stdout) + &text(&kept.stderr);
    assert!(told.contains("the knob's torque is on") && told.contains("its angle was lost"), "{told}");
    let again = room.run(&["replay", "s.csv", "--against", "s.wav", "-o", "again.wav"]);
    assert!(
        text(&again.stdout).contains("the same, to the bit"),
        "{}{}",
        text(&again.stdout),
        text(&again.stderr)
    );
    let sound = WavReader::open(room.0.join("again.wav")).unwrap().channel(2).unwrap();
    let most = sound.iter().fold(0.0, |most: f32, x| most.max(x.abs()));
    assert!(most > 0.1, "torque left: {most}");
}

/// Two notes, one of them held by the pedal for longer than its key, and the wheels of a keyboard, in two tracks.
fn song() -> Vec<u8> {
    let tempo: &[u8] = &[0, 0xff, 0x51, 3, 7, 0xa1, 0x20, 0, 0xff, 0x2f, 0];
    // 480 ticks a second.
    let notes: &[u8] = &[
        0, 0x90, 40, 100, 0, 0xb0, 64, 127, 60, 0x80, 40, 0, 60, 0x90, 45, 80, 30, 0xb0, 1, 90, 30, 0xe0, 0,
        80, 30, 0xb0, 64, 0, 60, 0x90, 45, 0, 0, 0xff, 0x2f, 0,
    ];
    let chunk = |kind: &[u8], bytes: &[u8]| {
        [kind, &u32::try_from(bytes.len()).unwrap().to_be_bytes(), bytes].concat()
    };
    [chunk(b"MThd", &[0, 1, 0, 2, 0, 240]), chunk(b"MTrk", tempo), chunk(b"MTrk", notes)].concat()
}

#[test]
fn a_song_is_played_as_it_is_rendered() {
    let room = Room::new("song");
    let keys = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("patches/27-keys.toml");
    std::fs::copy(keys, room.0.join("keys.toml")).unwrap();
    std::fs::write(room.0.join("song.mid"), song()).unwrap();
    // Of this card both know that it lets nothing steady through.
    let rig = "format = \"pacinian-rig/1\"\n[device]\nchannels = 8\ncoupling = { high_pass = 15 }\n";
    std::fs::write(room.0.join("rig.toml"), rig).unwrap();
    let render = ["render", "keys.toml", "--rig", "rig.toml", "--midi", "song.mid", "-o", "rendered.wav"];
    let output = room.run(&render);
    assert!(output.status.success(), "{}", text(&output.stderr));
    let play = [
        "play",
        "keys.toml",
        "--rig",
        "rig.toml",
        "--midi-file",
        "song.mid",
        "--midi-in",
        "none",
        "--device",
        "virtual",
        "--duration",
        "1.4",
    ];
    let output = room.run(&[&play[..], &["--record", "played.wav", "--events", "played.csv"]].concat());
    let said = text(&output.stderr);
    assert!(output.status.success(), "{said}");
    assert!(said.contains("key on t2 at 0.79") && said.contains("wobble to 0.71"), "{said}");
    assert_eq!(said.matches("the song has ended").count(), 1, "{said}");
    let read = |name: &str| WavReader::open(room.0.join(name)).unwrap();
    let (rendered, played) =
        (read("rendered.wav").channels().unwrap(), read("played.wav").channels().unwrap());
    assert_eq!((rendered.len(), played.len()), (8, 8));
    for (channel, (rendered, played)) in rendered.iter().zip(&played).enumerate() {
        // The song begins behind the ramp of 200 ms.
        let (ramp, played) = played.split_at(9_600);
        assert!(ramp.iter().all(|x| *x == 0.0));
        let frames = rendered.len();
        assert!(played.len() >= frames && frames > 24_000, "{} of {frames}", played.len());
        assert_eq!(rendered.iter().any(|x| x.abs() > 0.3), [1, 3].contains(&channel), "{channel}");
        let differs = (0..frames).find(|&n| rendered[n].to_bits() != played[n].to_bits());
        assert_eq!(differs, None, "channel {channel}: {said}");
    }
    // Of an experiment it is known which song it was.
    let journal = std::fs::read_to_string(room.0.join("played.csv")).unwrap();
    assert!(journal.contains("song.mid") && journal.contains(&of_bytes(&song())), "{journal}");
    let again = room.run(&["replay", "played.csv", "--against", "played.wav", "-o", "again.wav"]);
    assert!(again.status.success(), "{}", text(&again.stderr));
}

/// What gains, rates and beats make of an event may be more than a file may say of one.
#[test]
fn events_beyond_what_a_file_may_say_are_played_again() {
    let room = Room::new("beyond");
    let patch = r#"format = "pacinian-patch/1"
title = "Beyond"
[voice.v]
output = "o"
[voice.v.nodes]
s = { type = "sine", frequency = 90 }
o = { type = "multiply", inputs = ["s", 0.001] }
[pattern.inner]
events = [{ at = 0.0, voice = "v", level = 90, duration = 1e6 }]
[pattern.p]
events = [{ at = 0.0, pattern = "inner", gain = 5, rate = 0.25 }]
"#;
    std::fs::write(room.0.join("p.toml"), patch).unwrap();
    let play = ["play", "p.toml", "--device", "virtual", "--duration", "0.3", "--pattern", "p"];
    let kept = room.run(&[&play[..], &["--record", "s.wav", "--events", "s.jsonl"]].concat());
    assert!(kept.status.success(), "{}", text(&kept.stderr));
    let journal = std::fs::read_to_string(room.0.join("s.jsonl")).unwrap();
    let voice = journal.lines().find(|line| line.contains("\"kind\":\"voice\"")).unwrap();
    let voice: serde_json::Value = serde_json::from_str(voice).unwrap();
    assert_eq!((voice["level"].as_f64(), voice["duration"].as_f64()), (Some(450.0), Some(4e6)), "{voice}");
    let again = room.run(&["replay", "s.jsonl", "--against", "s.wav"]);
    assert!(
        text(&again.stdout).contains("the same, to the bit"),
        "{}{}",
        text(&again.stdout),
        text(&again.stderr)
    );
    // What no pattern can come to is no session's.
    let other = journal.replace("\"level\":450.0", "\"level\":1e300");
    assert_ne!(other, journal);
    std::fs::write(room.0.join("t.jsonl"), other).unwrap();
    fails(&room.run(&["replay", "t.jsonl"]), 65, "level");
}
