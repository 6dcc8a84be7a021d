//! The program in a folder of its own, for tests that run it as people do.
#![allow(dead_code)] // No test needs all of it.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::atomic::{AtomicU64, Ordering};

/// A folder that is gone when the test is over.
pub struct Scratch(pub PathBuf);

impl Scratch {
    pub fn new(name: &str) -> Self {
        // Two of one name may be there at once.
        static COUNT: AtomicU64 = AtomicU64::new(0);
        let (process, count) = (std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed));
        let folder = std::env::temp_dir().join(format!("pacinian-cli-{name}-{process}-{count}"));
        std::fs::create_dir_all(&folder).unwrap();
        let scratch = Self(folder);
        scratch.write("good.toml", GOOD);
        scratch
    }
    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, content).unwrap();
        path
    }
    /// Runs the program in the folder.
    pub fn run(&self, arguments: &[&str]) -> Run {
        Run::of(self.command(arguments).output().unwrap())
    }
    pub fn command(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_pacinian"));
        command.current_dir(&self.0).args(arguments);
        for name in ["NO_COLOR", "CLICOLOR_FORCE", "FORCE_COLOR"] {
            command.env_remove(name);
        }
        command
    }
    pub fn wav(&self, name: &str) -> (hound::WavSpec, Vec<f32>) {
        read_wav(&self.0.join(name))
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

pub fn read_wav(path: &Path) -> (hound::WavSpec, Vec<f32>) {
    let mut reader = hound::WavReader::open(path).unwrap();
    let spec = reader.spec();
    let samples = match spec.sample_format {
        hound::SampleFormat::Float => reader.samples::<f32>().map(Result::unwrap).collect(),
        hound::SampleFormat::Int => {
            let full = (1_i64 << (spec.bits_per_sample - 1)) as f32;
            reader.samples::<i32>().map(|x| x.unwrap() as f32 / full).collect()
        }
    };
    (spec, samples)
}

pub struct Run {
    pub code: Option<i32>,
    pub out: String,
    pub err: String,
}

impl Run {
    pub fn of(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) }
    }
    /// Ends with `code`, says all of `words` on standard error, and nothing of a bug.
    #[track_caller]
    pub fn fails(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, Some(code), "{}{}", self.out, self.err);
        for word in words {
            assert!(self.err.contains(word), "no `{word}` in: {}", self.err);
        }
        assert!(!self.err.contains("bug"), "{}", self.err);
    }
    #[track_caller]
    pub fn succeeds(&self) -> &Self {
        assert_eq!(self.code, Some(0), "{}{}", self.out, self.err);
        self
    }
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}: {}", self.out))
    }
}

pub const HEAD: &str = "format = \"pacinian-patch/1\"\ntitle = \"A test\"\n";

pub const VOICE: &str = "[voice.beat]\noutput = \"thud\"\n[voice.beat.nodes]\n\
    tone = { type = \"sine\", frequency = \"event.frequency\" }\n\
    hit = { type = \"envelope\", attack = 0.004, decay = 0.05, sustain = 0.0, release = 0.02 }\n\
    thud = { type = \"multiply\", inputs = [\"tone\", \"hit\"] }\n";

pub const GOOD: &str = "format = \"pacinian-patch/1\"\ntitle = \"A test\"\n\
    [voice.beat]\noutput = \"thud\"\n[voice.beat.nodes]\n\
    tone = { type = \"sine\", frequency = \"event.frequency\" }\n\
    hit = { type = \"envelope\", attack = 0.004, decay = 0.05, sustain = 0.0, release = 0.02 }\n\
    thud = { type = \"multiply\", inputs = [\"tone\", \"hit\"] }\n\
    [voice.never]\noutput = \"n\"\nnodes.n = { type = \"white\" }\n\
    [pattern.walk]\nevents = [\n  { at = 0.0, voice = \"beat\", level = 0.5 },\n\
    \x20 { at = 0.2, voice = \"beat\", level = 0.25, place = \"t2\", frequency = 50 },\n]\n";

pub fn with(text: &str) -> String {
    format!("{HEAD}{VOICE}{text}")
}
