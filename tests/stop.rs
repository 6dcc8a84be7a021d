//! Signals that come in pairs, as when a terminal is closed: what plays fades, and what is kept is finished.
#![cfg(all(feature = "cli", unix))]

mod program;
#[cfg(target_os = "linux")]
mod seat;

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use program::Scratch;

/// At full swing all the time.
const PATCH: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.hum]\nstart = \"always\"\noutput = \"s\"\n\
    nodes.s = { type = \"sine\", frequency = 100, amplitude = 0.5 }\n";

const KEPT: [&str; 7] = ["play", "p.toml", "--device", "virtual", "--record", "a.wav", "--events"];

/// Waits until so much is recorded that the output has come in.
fn has_played(scratch: &Scratch) {
    let begin = Instant::now();
    let length = || std::fs::metadata(scratch.0.join("a.wav")).map_or(0, |about| about.len());
    // Half a second of 8 channels.
    while length() < 4 * 8 * 24_000 {
        assert!(begin.elapsed() < Duration::from_secs(20), "nothing is recorded");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// A session that is kept, begun by such words.
fn kept(scratch: &Scratch, words: &[&str]) -> std::process::Child {
    scratch.write("p.toml", PATCH);
    let plain = scratch.command(&[&KEPT[..], &["e.jsonl"]].concat());
    let mut command = Command::new(words[0]);
    command.args(&words[1..]).arg(plain.get_program()).args(plain.get_args()).current_dir(&scratch.0);
    command.stdin(Stdio::null()).stderr(Stdio::null()).stdout(Stdio::null()).spawn().unwrap()
}

/// As it is where nobody has said `nohup`; whoever runs the tests may have.
const PLAINLY: &[&str] = if cfg!(target_os = "linux") { &["env", "--default-signal=HUP"] } else { &["env"] };

/// The recording ends in silence after it swung, and the journal with its end.
#[track_caller]
fn is_finished(scratch: &Scratch, how: &str) {
    let (spec, samples) = scratch.wav("a.wav");
    let frames: Vec<&[f32]> = samples.chunks_exact(usize::from(spec.channels)).collect();
    let (before, last) = frames.split_at(frames.len() - 64);
    assert!(last.iter().all(|frame| frame.iter().all(|x| x.to_bits() == 0)), "{how}: it is cut off");
    let swings =
        before.iter().rev().take(9600).flat_map(|frame| frame.iter()).fold(0.0_f32, |a, b| a.max(b.abs()));
    assert!(swings > 0.45, "{how}: {swings}");
    let steepest = frames.windows(2).map(|pair| (pair[1][0] - pair[0][0]).abs()).fold(0.0, f32::max);
    // The ramp of 2 ms is 96 frames long.
    assert!(steepest < 0.02, "{how}: a step of {steepest}");
    let loud = frames.iter().rposition(|frame| frame[0].abs() > 0.4).unwrap();
    let sounds = frames.iter().rposition(|frame| frame[0] != 0.0).unwrap();
    // 5 ms, and half a period of 100 Hz in which it need not have been loud.
    assert!(sounds - loud <= 240 + 240, "{how}: it fades for {} frames", sounds - loud);
    let journal = std::fs::read_to_string(scratch.0.join("e.jsonl")).unwrap();
    assert!(journal.trim_end().lines().last().unwrap().contains("\"end\""), "{how}: {journal:.300}");
    scratch.run(&["replay", "e.jsonl", "--against", "a.wav"]).succeeds();
}

#[test]
fn a_second_signal_does_not_cut_the_output_off() {
    for (first, second, code) in
        [("HUP", "HUP", 129), ("HUP", "TERM", 129), ("TERM", "INT", 143), ("QUIT", "TERM", 131)]
    {
        for pause in ["0.001", "0.02"] {
            let how = format!("{first}, {pause} s, {second}");
            let scratch = Scratch::new("stop-pair");
            let mut child = kept(&scratch, PLAINLY);
            has_played(&scratch);
            let id = child.id();
            // The second finds nobody where the first was that fast.
            let kill =
                format!("kill -s {first} {id}; sleep {pause}; kill -s {second} {id} 2>/dev/null; true");
            assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
            assert_eq!(child.wait().unwrap().code(), Some(code), "{how}");
            is_finished(&scratch, &how);
        }
    }
}

/// Whoever has begun it with `nohup` may leave.
#[cfg(target_os = "linux")]
#[test]
fn under_nohup_it_outlives_the_terminal() {
    let scratch = Scratch::new("stop-nohup");
    let mut child = kept(&scratch, &["nohup"]);
    has_played(&scratch);
    let kill = |signal: &str| {
        let done = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status();
        assert!(done.unwrap().success());
    };
    kill("HUP");
    let length = || std::fs::metadata(scratch.0.join("a.wav")).unwrap().len();
    let (before, begin) = (length(), Instant::now());
    // Another half second.
    while length() < before + 4 * 8 * 24_000 {
        assert!(begin.elapsed() < Duration::from_secs(20), "it plays no more");
        std::thread::sleep(Duration::from_millis(5));
    }
    kill("TERM");
    assert_eq!(child.wait().unwrap().code(), Some(143));
    is_finished(&scratch, "nohup");
}

/// One that nobody could stop in peace: its recording is known up to half a second before.
#[test]
fn a_session_that_is_killed_leaves_what_it_had() {
    let scratch = Scratch::new("stop-killed");
    let mut child = kept(&scratch, PLAINLY);
    has_played(&scratch);
    child.kill().unwrap();
    child.wait().unwrap();
    let (spec, samples) = scratch.wav("a.wav");
    let whole = std::fs::metadata(scratch.0.join("a.wav")).unwrap().len() as usize / 4;
    let unknown = (whole - samples.len()) / usize::from(spec.channels);
    // What is written, and up to 50 ms of a busy machine's.
    assert!(!samples.is_empty() && unknown <= 24_000 + 12_000, "{unknown} frames of {whole} samples");
    scratch.run(&["replay", "e.jsonl"]).succeeds();
}

/// As where a machine sleeps: the card has played what it had, and says so.
#[test]
fn a_session_that_stood_still_counts_an_xrun_and_goes_on() {
    let scratch = Scratch::new("stop-still");
    let mut child = kept(&scratch, PLAINLY);
    has_played(&scratch);
    let id = child.id();
    let kill = format!("kill -s STOP {id}; sleep 0.5; kill -s CONT {id}; sleep 0.5; kill -s TERM {id}");
    assert!(Command::new("sh").args(["-c", &kill]).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(143));
    is_finished(&scratch, "stopped");
    let journal = std::fs::read_to_string(scratch.0.join("e.jsonl")).unwrap();
    let end: serde_json::Value = serde_json::from_str(journal.trim_end().lines().last().unwrap()).unwrap();
    assert!(end["fields"]["xruns"].as_f64().unwrap() >= 1.0, "{end}");
}

/// One that begins it in a group of its own, and its log goes to a file: no signal comes, and nothing is written that would fail.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_that_is_gone_without_a_signal_ends_it() {
    use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
    let scratch = Scratch::new("stop-quiet");
    scratch.write("p.toml", PATCH);
    let near = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&near).unwrap();
    unlockpt(&near).unwrap();
    let path = ptsname(&near, Vec::new()).unwrap().into_string().unwrap();
    let plain = scratch.command(&[&KEPT[..], &["e.jsonl"]].concat());
    // In a session of its own, so that the terminal is none of its.
    let mut command = Command::new("setsid");
    command.arg(plain.get_program()).args(plain.get_args()).current_dir(&scratch.0);
    let open = || {
        use std::os::unix::fs::OpenOptionsExt;
        let noctty = OpenptFlags::NOCTTY.bits() as i32;
        std::fs::File::options().read(true).write(true).custom_flags(noctty).open(&path).unwrap()
    };
    command.stdin(open()).stdout(open()).stderr(std::fs::File::create(scratch.0.join("log")).unwrap());
    let Ok(mut child) = command.spawn() else { return };
    drop(command);
    has_played(&scratch);
    assert!(child.try_wait().unwrap().is_none());
    drop(near);
    let begin = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        assert!(begin.elapsed() < Duration::from_secs(20), "it plays on");
        std::thread::sleep(Duration::from_millis(10));
    };
    assert_eq!(status.code(), Some(129));
    is_finished(&scratch, "gone");
}

/// Where the system refuses what a program that plays would like, that is said once, and it plays.
#[cfg(target_os = "linux")]
#[test]
fn that_there_is_no_real_time_priority_is_said() {
    let scratch = Scratch::new("stop-humble");
    scratch.write("p.toml", PATCH);
    let play = scratch.command(&["play", "p.toml", "--device", "virtual", "--duration", "0.5"]);
    let mut command = Command::new("prlimit");
    command.args(["--rtprio=0", "setpriv", "--bounding-set=-sys_nice", "--inh-caps=-sys_nice"]);
    command.arg(play.get_program()).args(play.get_args()).current_dir(&scratch.0);
    let said = command.stdin(Stdio::null()).output();
    let Some(said) = said.ok().filter(|said| said.status.code() != Some(127)) else {
        return seat::skipped("there are no prlimit and setpriv here, which util-linux brings");
    };
    let text = String::from_utf8_lossy(&said.stderr).into_owned();
    if text.contains("setpriv: ") {
        // Who has no rights to give away has none to play first either; but what is said then, a machine may allow.
        return seat::skipped(text);
    }
    assert!(said.status.success(), "{text}");
    assert_eq!(
        text.matches("the system gives no real-time priority, so gaps are likelier").count(),
        1,
        "{text}"
    );
}

/// A window that is closed: the system tells all who have the terminal, and the shell tells its children once more.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_that_is_closed_under_a_shell_does_not_cut_the_output_off() {
    let scratch = Scratch::new("stop-closed");
    scratch.write("p.toml", PATCH);
    let play = scratch.command(&[&KEPT[..], &["e.jsonl"]].concat());
    let words: Vec<_> =
        std::iter::once(play.get_program()).chain(play.get_args()).map(|w| w.to_str().unwrap()).collect();
    // What the shell does by itself here does not hang on when it comes to it: it looks whether the player is gone.
    let script = format!(
        "trap : HUP; exec 3<&0; {} <&3 & p=$!; echo $p > pid; \
         while kill -0 $p 2> /dev/null; do sleep 0.02; done; wait $p; echo $? > code",
        words.join(" ")
    );
    let mut shell = Command::new("sh");
    shell.args(["-c", &script]).current_dir(&scratch.0);
    let Some(mut seat) = seat::Seat::at(&shell, (80, 24), "xterm-256color", true) else { return };
    seat.shows("ARMED");
    has_played(&scratch);
    let player = std::fs::read_to_string(scratch.0.join("pid")).unwrap();
    seat.hang_up();
    // As a shell does that passes it on. The player may be gone by then.
    let kill = format!("kill -s HUP {0}; sleep 0.02; kill -s HUP {0}; true", player.trim());
    let told = Command::new("sh").args(["-c", &kill]).stderr(Stdio::null()).status();
    assert!(told.unwrap().success());
    let ended = seat.end();
    let code = std::fs::read_to_string(scratch.0.join("code"));
    let code = code.unwrap_or_else(|why| {
        panic!("the shell did not say how the player ended, and ended with {ended}: {why}")
    });
    assert_eq!(code.trim(), "129");
    is_finished(&scratch, "closed");
}
