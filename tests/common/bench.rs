//! A sound card in user space for tests, and the program on it.
#![allow(dead_code)]

#[path = "skipped.rs"]
mod skipped;

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

pub use skipped::skipped;

/// A folder of a test's own, with a card's driver and its configuration.
pub struct Bench {
    pub folder: PathBuf,
}

impl Bench {
    /// `None`, and a word about it, where the card cannot be had.
    pub fn new(name: &str) -> Option<Self> {
        let folder = std::env::temp_dir().join(format!("pacinian-devices-{}-{name}", std::process::id()));
        fs::create_dir_all(&folder).unwrap();
        let driver = folder.join("libasound_module_pcm_testcard.so");
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/devices/card.c");
        let flags = ["-O2", "-shared", "-fPIC", "-DPIC"];
        let built = Command::new("cc").args(flags).arg(source).args(["-lasound", "-o"]).arg(&driver).output();
        let why = match built {
            Ok(output) if output.status.success() => None,
            Ok(output) => {
                Some(String::from_utf8_lossy(&output.stderr).lines().next().unwrap_or("").to_string())
            }
            Err(error) => Some(error.to_string()),
        };
        let system = Path::new("/usr/share/alsa/alsa.conf");
        let why = why.or_else(|| (!system.exists()).then(|| "there is no /usr/share/alsa/alsa.conf".into()));
        if let Some(why) = why {
            skipped(format!("the card cannot be built: {why}"));
            return None;
        }
        let bench = Self { folder };
        let (driver, played, gone) = (driver.display(), bench.played(), bench.gone());
        let card = |channels: u32| {
            format!(
                "pcm.card{channels} {{ type testcard channels {channels} played \"{}\" gone \"{}\" \
                 hint {{ show on description \"Card of {channels} channels\" }} }}\n",
                played.display(),
                gone.display()
            )
        };
        let text = format!("pcm_type.testcard {{ lib \"{driver}\" }}\n{}{}", card(8), card(24));
        fs::write(bench.folder.join("asound.conf"), text).unwrap();
        Some(bench)
    }

    /// A further card: the fields of its configuration, in which @ is the bench's folder.
    pub fn card(&self, name: &str, fields: &str) {
        let path = self.folder.join("asound.conf");
        let fields = fields.replace('@', &self.folder.display().to_string());
        let text = fs::read_to_string(&path).unwrap()
            + &format!("pcm.{name} {{ type testcard {fields} hint {{ show on description \"{name}\" }} }}\n");
        fs::write(path, text).unwrap();
    }

    pub fn played(&self) -> PathBuf {
        self.folder.join("played.raw")
    }

    pub fn gone(&self) -> PathBuf {
        self.folder.join("gone")
    }

    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pacinian"));
        let config = format!("/usr/share/alsa/alsa.conf:{}", self.folder.join("asound.conf").display());
        command
            .args(arguments)
            .env("ALSA_CONFIG_PATH", config)
            .current_dir(&self.folder)
            .stdin(Stdio::null());
        command
    }

    pub fn run(&self, arguments: &[&str]) -> Output {
        self.command(arguments).output().unwrap()
    }

    pub fn start(&self, arguments: &[&str]) -> Child {
        self.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.folder.join(name), text).unwrap();
    }

    /// What the card was given, sample by sample.
    pub fn samples(&self) -> Vec<f32> {
        let bytes = fs::read(self.played()).unwrap_or_default();
        bytes.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.folder);
    }
}

/// How often a test kills a server, unless `PACINIAN_KILLS` says otherwise.
pub fn kills(usually: usize) -> usize {
    match std::env::var("PACINIAN_KILLS") {
        Ok(kills) => kills.parse().unwrap_or_else(|error| panic!("PACINIAN_KILLS={kills}: {error}")),
        Err(_) => usually,
    }
}

/// Waits until something holds, ten seconds at most.
pub fn wait(what: &str, mut holds: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !holds() {
        assert!(begin.elapsed() < Duration::from_secs(10), "{what} did not come");
        std::thread::sleep(Duration::from_millis(10));
    }
}

pub fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill").args([&format!("-{name}"), &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// A program that plays until it is interrupted, or the test is over, however that ends.
pub struct Playing {
    child: Child,
    told: PathBuf,
}

impl Playing {
    /// What it tells goes into a file: a pipe that nobody reads would make it wait.
    pub fn start(mut command: Command, told: PathBuf) -> Self {
        let file = fs::File::create(&told).unwrap();
        Self { child: command.stdout(Stdio::null()).stderr(file).spawn().unwrap(), told }
    }

    /// What it has told.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&fs::read(&self.told).unwrap_or_default()).into_owned()
    }

    /// How often it has told something.
    pub fn says(&self, what: &str) -> usize {
        self.text().matches(what).count()
    }

    pub fn goes_on(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Ctrl-C ends it, in order.
    pub fn interrupt(&mut self) {
        signal(&self.child, "INT");
        assert_eq!(self.child.wait().unwrap().code(), Some(130), "{}", self.text());
    }
}

impl Drop for Playing {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A tone on each of so many channels, each its own, with hard onsets between samples, for a second.
pub fn scene(folder: &Path, channels: u32) {
    let mut patch = String::from(
        "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nvoices = 64\noutput = \"o\"\n[voice.v.nodes]\n\
         s = { type = \"sine\", frequency = \"event.frequency\" }\ne = { type = \"envelope\", attack = 0.003, release = 0.02 }\n\
         o = { type = \"multiply\", inputs = [\"s\", \"e\"] }\n[pattern.p]\nevents = [\n",
    );
    for channel in 1..=channels {
        let at = 0.3 + 0.013_37 * f64::from(channel);
        patch += &format!(
            "  {{ at = {at}, voice = \"v\", level = 0.6, duration = 0.4, place = {channel}, frequency = {} }},\n",
            60 + 20 * channel
        );
    }
    patch += "]\n";
    let mut rig = format!(
        "format = \"pacinian-rig/1\"\n[device]\nchannels = {channels}\nrate = 48000\ncoupling = {{ high_pass = 8 }}\n"
    );
    for channel in 1..=channels {
        rig += &format!("[[tactor]]\nname = \"c{channel}\"\nchannel = {channel}\n");
    }
    fs::write(folder.join("patch.toml"), patch).unwrap();
    fs::write(folder.join("rig.toml"), rig).unwrap();
}

/// A tone on the first channel, always.
pub const HUM: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nstart = \"always\"\noutput = \"s\"\n[voice.v.nodes]\n\
    s = { type = \"sine\", frequency = 100, amplitude = 0.5 }\n";

/// Whether that tone is in interleaved frames, and nothing louder.
pub fn hums(frames: &[f32], channels: u32) -> bool {
    let hum = frames.iter().step_by(channels as usize);
    // The high-pass of a card that nobody has described takes the sine's beginning for a steady part, a hundredth of it.
    hum.clone().any(|x| x.abs() > 0.45) && hum.clone().all(|x| x.abs() <= 0.506)
}

/// The samples of a WAV of floats.
pub fn floats(path: &Path) -> Vec<f32> {
    let wav = fs::read(path).unwrap();
    let data = wav.windows(4).position(|w| w == b"data").unwrap() + 8;
    wav[data..].chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// How frames that were heard compare with those of [`scene`] as it is rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Likeness {
    /// To the bit, with a delay of whole frames that is the same for all channels.
    Same,
    /// A part is missing, or too much, and what is before and behind is the same to the bit: the machine stood still, and the server lost
    /// a block.
    Torn,
    /// Something else.
    Other,
}

/// Compares them. The first 200 ms, in which the output comes in and nothing sounds yet, do not count.
pub fn likeness(heard: &[f32], rendered: &[f32], channels: u32) -> Likeness {
    let channels = channels as usize;
    let (begin, end) = (channels * 9_600, rendered.len().min(channels * 57_000));
    let sounds = |frames: &[f32], at: usize| frames[at..at + channels].iter().any(|x| *x != 0.0);
    let frames = |samples: &[f32]| samples.len() / channels;
    let first = |all: &[f32]| (0..frames(all)).map(|n| n * channels).find(|at| sounds(all, *at));
    let last = |all: &[f32]| (0..frames(all)).rev().map(|n| n * channels).find(|at| sounds(all, *at));
    let wanted = &rendered[begin..end];
    let (Some(wanted_first), Some(first)) = (first(wanted), first(heard)) else { return Likeness::Other };
    let same = |(a, b): &(&f32, &f32)| a.to_bits() == b.to_bits();
    let ahead = wanted[wanted_first..].iter().zip(&heard[first..]).take_while(same).count();
    if ahead == wanted.len() - wanted_first {
        return Likeness::Same;
    }
    // From the end of what sounds on backwards.
    let (Some(wanted_last), Some(last)) = (last(rendered), last(heard)) else { return Likeness::Other };
    let behind = rendered[..wanted_last + channels]
        .iter()
        .rev()
        .zip(heard[..last + channels].iter().rev())
        .take_while(same)
        .count();
    if ahead + behind >= wanted.len() / 2 { Likeness::Torn } else { Likeness::Other }
}

/// What is kept of a session says that its clock went on whatever became of the device: from each look at it to the next, as many frames have
/// passed as time has.
/// There are more than so many looks.
pub fn clock_went_on(journal: &Path, looks: usize) {
    let journal = fs::read_to_string(journal).unwrap();
    let lines = journal.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap());
    let clocks: Vec<(f64, f64)> = lines
        .filter(|line| line["kind"] == "clock")
        .filter_map(|line| Some((line["frame"].as_f64()? / 48_000.0, line["seconds"].as_f64()?)))
        .collect();
    assert!(clocks.len() > looks, "{clocks:?}");
    for pair in clocks.windows(2) {
        let (frames, time) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        assert!((frames - time).abs() < 0.5, "{frames} s of frames in {time} s: {clocks:?}");
    }
}

/// Plays up to five times, until `heard` gives what is rendered; only what the machine's standing still explains is tried again.
pub fn heard_to_the_bit(rendered: &[f32], channels: u32, mut heard: impl FnMut() -> (Vec<f32>, String)) {
    for _ in 0..5 {
        let (heard, said) = heard();
        match likeness(&heard, rendered, channels) {
            Likeness::Same => return,
            Likeness::Torn => println!("the machine stood still: {said}"),
            Likeness::Other => panic!("other samples: {said}"),
        }
    }
    panic!("it lost blocks five times");
}
