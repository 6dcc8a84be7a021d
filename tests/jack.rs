//! Playing through a real sound server to a second program: JACK with its dummy driver, reached through ALSA's plug-in for it and, where the
//! program has that feature, through JACK's own library; and a recorder of our own.
//!
//! It needs jackd, a C compiler with JACK's headers, and ALSA's plug-ins (on Debian jackd2, libjack-jackd2-dev, libasound2-plugins), and
//! 45 MB of shared memory. Where one is missing, a test says that it was skipped, and why.
#![cfg(target_os = "linux")]

#[path = "common/bench.rs"]
mod bench;

use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bench::{HUM, Likeness, Playing, clock_went_on, floats, hums, kills, likeness, scene, signal, wait};

const CHANNELS: u32 = 24;

/// Names of the device, by the ways on which it is reached.
const WAYS: &[&str] = if cfg!(feature = "jack") { &["jackcard", "jack"] } else { &["jackcard"] };

/// One server at a time: of the 64 MB of shared memory that a container has, one takes 42.
static ALONE: Mutex<()> = Mutex::new(());

/// A server, and a folder of a test's own.
struct Rig {
    folder: PathBuf,
    server: String,
    jackd: Option<Child>,
    _alone: MutexGuard<'static, ()>,
}

impl Rig {
    fn new(name: &str) -> Option<Self> {
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        let folder = std::env::temp_dir().join(format!("pacinian-jack-{}-{name}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let plugin = ["/usr/lib/x86_64-linux-gnu", "/usr/lib/aarch64-linux-gnu", "/usr/lib64", "/usr/lib"]
            .iter()
            .any(|lib| Path::new(lib).join("alsa-lib/libasound_module_pcm_jack.so").exists());
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/devices/jackrec.c");
        let built = Command::new("cc")
            .arg("-O2")
            .arg(source)
            .args(["-ljack", "-o"])
            .arg(folder.join("jackrec"))
            .output();
        let there = Command::new("jackd").arg("--version").output();
        let why = match (plugin, built, there) {
            (false, ..) => Some("there is no ALSA plug-in for JACK".to_string()),
            (_, Ok(built), _) if !built.status.success() => Some("JACK's headers are not there".into()),
            (_, Err(error), _) | (.., Err(error)) => Some(error.to_string()),
            _ => None,
        };
        if let Some(why) = why {
            bench::skipped(why);
            return None;
        }
        let ports: Vec<String> = (0..CHANNELS).map(|n| format!("{n} system:playback_{}", n + 1)).collect();
        let card = format!(
            "pcm.jackcard {{ type jack playback_ports {{ {} }} capture_ports {{ }} hint {{ show on description \"Jack card\" }} }}\n",
            ports.join(" ")
        );
        fs::write(folder.join("asound.conf"), card).unwrap();
        let server = format!("pt{}{name}", std::process::id());
        let mut rig = Self { folder, server, jackd: None, _alone: alone };
        if let Err(why) = rig.try_start() {
            // Servers that were killed, by whomever: that is to be put right, and is no machine without JACK.
            let full =
                "all places of JACK's registry are taken: with no server running, rm -r /dev/shm/jack*";
            assert!(!why.contains("Too many servers"), "{full}");
            bench::skipped(format!("jackd does not run here: {why}"));
            return None;
        }
        Some(rig)
    }

    /// The memory of one that was killed is there again as soon as nobody has hold of it.
    fn start(&mut self) {
        wait("the server's memory", || self.try_start().is_ok());
    }

    /// The error is what a server says that has ended at once; one that lives and does not answer is none.
    fn try_start(&mut self) -> Result<(), String> {
        // What comes behind -d is the driver's, in front of it the server's: of 128 ports.
        let words =
            ["-r", "-p", "128", "-d", "dummy", "-r", "48000", "-p", "1024", "-C", "0", "-P", "24", "-m"];
        let says = self.folder.join("jackd");
        let file = fs::File::create(&says).unwrap();
        let mut jackd = Command::new("jackd");
        jackd.args(["-n", &self.server]).args(words).env("JACK_NO_AUDIO_RESERVATION", "1");
        jackd.stdin(Stdio::null()).stdout(Stdio::null()).stderr(file);
        self.jackd = Some(jackd.spawn().unwrap());
        let mut ended = None;
        wait("the server", || {
            ended = self.jackd.as_mut().and_then(|child| child.try_wait().unwrap());
            ended.is_some() || self.answers()
        });
        match ended {
            Some(status) => Err(format!("{status}: {}", fs::read_to_string(says).unwrap_or_default())),
            None => Ok(()),
        }
    }

    fn answers(&self) -> bool {
        let ports = self.command("jack_lsp").output();
        ports.is_ok_and(|ports| String::from_utf8_lossy(&ports.stdout).contains("system:monitor_24"))
    }

    /// It does not come to its senses before it dies.
    fn kill(&mut self) {
        if let Some(mut jackd) = self.jackd.take() {
            let _ = jackd.kill();
            jackd.wait().unwrap();
        }
    }

    fn command(&self, program: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(program);
        let config = format!("/usr/share/alsa/alsa.conf:{}", self.folder.join("asound.conf").display());
        command
            .env("JACK_DEFAULT_SERVER", &self.server)
            .env("JACK_NO_START_SERVER", "1")
            .env("ALSA_CONFIG_PATH", config)
            .current_dir(&self.folder)
            .stdin(Stdio::null());
        command
    }

    fn program(&self, arguments: &[&str]) -> Command {
        let mut command = self.command(env!("CARGO_BIN_EXE_pacinian"));
        command.args(arguments);
        command
    }

    /// A second program that records what comes out; it listens when this returns.
    fn record(&self) -> Recorder {
        let mut command = self.command(self.folder.join("jackrec"));
        let file = self.folder.join("heard.raw");
        command.args(["system:monitor_", &CHANNELS.to_string(), "60"]).arg(&file).stdout(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut words = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        words.read_line(&mut line).unwrap();
        assert_eq!(line, "listening\n");
        Recorder { child, words, file }
    }
}

impl Drop for Rig {
    fn drop(&mut self) {
        // One that is asked to end gives its place among the servers back; JACK has eight, and dead ones keep theirs.
        if let Some(mut jackd) = self.jackd.take() {
            signal(&jackd, "TERM");
            let end = Instant::now() + Duration::from_secs(5);
            while matches!(jackd.try_wait(), Ok(None)) && Instant::now() < end {
                std::thread::sleep(Duration::from_millis(20));
            }
            let _ = jackd.kill();
            let _ = jackd.wait();
        }
        let _ = fs::remove_dir_all(&self.folder);
        // What a killed server leaves.
        for entry in fs::read_dir("/dev/shm").into_iter().flatten().flatten() {
            if entry.file_name().to_string_lossy().contains(&self.server) {
                let _ = fs::remove_file(entry.path()).or_else(|_| fs::remove_dir_all(entry.path()));
            }
        }
    }
}

struct Recorder {
    child: Child,
    words: BufReader<std::process::ChildStdout>,
    file: PathBuf,
}

impl Recorder {
    /// What was heard, interleaved, and gaps of the server meanwhile.
    fn finish(mut self) -> (Vec<f32>, u32) {
        signal(&self.child, "TERM");
        let mut said = String::new();
        self.words.read_to_string(&mut said).unwrap();
        self.child.wait().unwrap();
        let bytes = fs::read(&self.file).unwrap();
        let frames = bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        (frames, said.split(' ').next().and_then(|n| n.parse().ok()).unwrap_or(0))
    }
}

/// One that a test leaves behind would hold on to the pipe that its words go to.
impl Drop for Recorder {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn a_second_program_hears_every_channel_to_the_bit() {
    let Some(rig) = Rig::new("bits") else { return };
    scene(&rig.folder, CHANNELS);
    let render = ["render", "patch.toml", "--rig", "rig.toml", "-o", "offline.wav", "--duration", "1.2"];
    assert!(rig.program(&render).output().unwrap().status.success());
    let offline = floats(&rig.folder.join("offline.wav"));
    for way in WAYS {
        // This machine may stop for a moment, and the server drops a block; then it is tried again.
        for attempt in 0..5 {
            let recorder = rig.record();
            let play = [
                "play",
                "patch.toml",
                "--rig",
                "rig.toml",
                "--device",
                way,
                "--events",
                "s.jsonl",
                "--replace",
            ];
            let played = rig.program(&play).args(["--block", "1024", "--duration", "2"]).output().unwrap();
            let said = String::from_utf8_lossy(&played.stdout).into_owned()
                + &String::from_utf8_lossy(&played.stderr);
            let (heard, gaps) = recorder.finish();
            assert!(played.status.success(), "{said}");
            if likeness(&heard, &offline, CHANNELS) == Likeness::Same {
                let off = astray(&rig.folder, &heard, &offline);
                println!("{way}: heard {:.2} ms after the device asked for it by the journal", 1e3 * off);
                // A quarter of a block. A busy machine calls back unevenly: what is wrong about the delay is so each time.
                if (off - known(way)).abs() < 0.005 {
                    break;
                }
                assert!(attempt < 4, "{way}: {off} s: {said}");
                continue;
            }
            let gap = gaps > 0 || !said.contains(" 0 xruns");
            assert!(gap && attempt < 4, "{way}: other samples without a gap: {said}");
        }
    }
}

/// Without a rig, every output of the server's card has a tactor, though a client may have fewer.
#[cfg(feature = "jack")]
#[test]
fn a_line_has_as_many_tactors_as_the_server_has_outputs() {
    let Some(rig) = Rig::new("line") else { return };
    fs::write(rig.folder.join("hum.toml"), HUM).unwrap();
    let played =
        rig.program(&["play", "hum.toml", "--device", "jack", "--duration", "0.2"]).output().unwrap();
    let said = String::from_utf8_lossy(&played.stderr);
    assert!(played.status.success() && said.contains(": 24 channels at 48000 Hz"), "{said}");
}

/// Seconds from the period in which a frame is asked for to that in which the recorder has it: what goes to the server's outputs stands at
/// its monitors a period later, and ALSA's plug-in has a buffer of two in front of that.
fn known(way: &str) -> f64 {
    let periods = if way == "jack" { 1.0 } else { 3.0 };
    periods * 1024.0 / 48_000.0
}

/// By how many seconds what was heard comes later than the device asked for it, as the journal has it.
fn astray(folder: &Path, heard: &[f32], offline: &[f32]) -> f64 {
    let channels = CHANNELS as usize;
    let first = |all: &[f32]| all.iter().position(|x| *x != 0.0).unwrap() / channels;
    // In the session, the pattern begins behind the ramp.
    let (there, here) = (first(heard), 9_600 + first(offline));
    let times = fs::read_to_string(folder.join("heard.raw.times")).unwrap();
    let periods = times.lines().map(|line| {
        let (frame, begun) = line.split_once(' ').unwrap();
        (frame.parse::<usize>().unwrap(), begun.parse::<f64>().unwrap() * 1e-6)
    });
    let (period, begun) = periods.take_while(|(frame, _)| *frame <= there).last().unwrap();
    let journal = fs::read_to_string(folder.join("s.jsonl")).unwrap();
    let lines: Vec<serde_json::Value> =
        journal.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let clock = lines.iter().rfind(|line| line["kind"] == "clock" && line["frame"].is_u64()).unwrap();
    let number = |value: &serde_json::Value| value.as_f64().unwrap();
    let since = here as f64 - (there - period) as f64 - number(&clock["frame"]);
    let asked = number(&lines[0]["monotonic"]) + number(&clock["seconds"]) + since / 48_000.0;
    begun - asked
}

/// Frames in which the output comes back: 20 ms.
const COMING_BACK: usize = 960;

/// Whether the hum was seen to come back, from silence on: within 20 ms, in a curve without corners, and never louder. `None` where it had
/// begun before anybody listened, or the server lost a block meanwhile.
fn comes_in_slowly(heard: &[f32], gaps: u32) -> Option<Result<(), String>> {
    let hum: Vec<f32> = heard.iter().step_by(CHANNELS as usize).copied().collect();
    let first = hum.iter().position(|x| *x != 0.0).filter(|first| *first > 0)?;
    let back = hum.get(first..first + 2 * COMING_BACK).filter(|_| gaps == 0)?;
    for (n, x) in back.iter().enumerate() {
        let share = ((n + 2) as f32 / COMING_BACK as f32).min(1.0);
        let most = 0.506 * share * share * (3.0 - 2.0 * share);
        if x.abs() > most {
            return Some(Err(format!("{x} in frame {n} of the return, where {most} is the most")));
        }
    }
    let loudest = back.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
    Some(if loudest > 0.45 { Ok(()) } else { Err(format!("no louder than {loudest}")) })
}

/// On each way.
#[test]
fn a_server_that_is_killed_is_waited_for() {
    let kills = kills(10);
    let Some(mut rig) = Rig::new("killed") else { return };
    scene(&rig.folder, CHANNELS);
    // With MIDI, which is a client of the same server where it goes through JACK.
    let keys = "[[trigger]]\non = \"midi.note\"\nplay = \"keyed\"\n[voice.keyed]\noutput = \"k\"\nnodes.k = { type = \"sine\", frequency = 100 }\n";
    fs::write(rig.folder.join("keys.toml"), format!("{HUM}{keys}")).unwrap();
    for way in WAYS {
        let journal = format!("{way}.jsonl");
        let play = ["play", "keys.toml", "--rig", "rig.toml", "--device", way, "--block", "1024"];
        let play = rig.program(&[&play[..], &["--events", &journal]].concat());
        let mut playing = Playing::start(play, rig.folder.join("told"));
        std::thread::sleep(Duration::from_millis(600));
        let mut seen = 0;
        for _ in 0..kills {
            std::thread::sleep(Duration::from_millis(200));
            rig.kill();
            std::thread::sleep(Duration::from_millis(300));
            rig.start();
            let recorder = rig.record();
            // It is looked for at least once a second.
            let connected = || {
                let ports = rig.command("jack_lsp").arg("-c").output().unwrap();
                let ports = String::from_utf8_lossy(&ports.stdout);
                // As ALSA's plug-in calls its ports, and as the library does.
                ports.contains("out_000") || ports.contains("_out:out_0")
            };
            let begin = Instant::now();
            while !connected() {
                assert!(begin.elapsed() < Duration::from_secs(20), "{way}: no return: {}", playing.text());
                std::thread::sleep(Duration::from_millis(10));
            }
            assert!(playing.goes_on(), "it goes on");
            std::thread::sleep(Duration::from_millis(200));
            let (heard, gaps) = recorder.finish();
            match comes_in_slowly(&heard, gaps) {
                Some(Ok(())) => seen += 1,
                Some(Err(why)) => panic!("{way}: {why}"),
                None => {}
            }
        }
        let recorder = rig.record();
        std::thread::sleep(Duration::from_millis(800));
        let (heard, _) = recorder.finish();
        playing.interrupt();
        let said = playing.text();
        assert_eq!(said.matches("the device is back").count(), kills, "{said}");
        assert!(hums(&heard, CHANNELS), "it sounds again");
        clock_went_on(&rig.folder.join(&journal), 2 * kills.min(5));
        println!("{way}: {seen} of {kills} returns were heard from their first frame on");
        assert!(seen > 0 || kills < 3, "{way}: no return was heard from its first frame on");
    }
}

/// While a server computes ahead of time (freewheel), as for a program that exports, a session is not played into that for longer than it takes to
/// notice; behind it the session is there again.
#[cfg(feature = "jack")]
#[test]
fn a_server_that_computes_ahead_of_time_is_waited_for() {
    let Some(rig) = Rig::new("freewheel") else { return };
    let freewheels = |how: &str| rig.command("jack_freewheel").arg(how).stdout(Stdio::null()).status();
    if let Err(error) = freewheels("n") {
        return bench::skipped(format!("jack_freewheel: {error}"));
    }
    scene(&rig.folder, CHANNELS);
    fs::write(rig.folder.join("hum.toml"), HUM).unwrap();
    let play = ["play", "hum.toml", "--rig", "rig.toml", "--device", "jack:output", "--block", "1024"];
    let mut playing = Playing::start(rig.program(&play), rig.folder.join("told"));
    wait("the beginning", || playing.says("plays on") == 1);
    std::thread::sleep(Duration::from_millis(500));
    assert!(freewheels("y").unwrap().success());
    wait("the loss", || playing.says("the device is gone") == 1);
    std::thread::sleep(Duration::from_millis(1500));
    assert_eq!(playing.says("the device is back"), 0, "{}", playing.text());
    // A server in a hurry may not answer at once.
    wait("an answer", || freewheels("n").unwrap().success());
    wait("its return", || playing.says("the device is back") == 1);
    let recorder = rig.record();
    std::thread::sleep(Duration::from_millis(800));
    let (heard, _) = recorder.finish();
    playing.interrupt();
    assert!(hums(&heard, CHANNELS), "it sounds again: {}", playing.text());
}
