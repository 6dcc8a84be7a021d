//! The log of a rendering says what sounded, and when.
#![cfg(feature = "cli")]

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("pacinian-log-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }
    fn run(&self, arguments: &[&str]) -> Output {
        Command::new(env!("CARGO_BIN_EXE_pacinian")).current_dir(&self.0).args(arguments).output().unwrap()
    }
    fn read(&self, name: &str) -> String {
        std::fs::read_to_string(self.0.join(name)).unwrap()
    }
    /// Renders with a log; its lines as cells, by the names of the columns.
    fn logged(&self, patch: &str, more: &[&str]) -> (String, Vec<Line>) {
        let all = [&["render", patch, "-o", "out.wav", "--log", "out.csv"], more].concat();
        let output = self.run(&all);
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let text = self.read("out.csv");
        let mut lines = text.lines();
        let head = lines.next().unwrap().to_string();
        let columns: Vec<&str> = lines.next().unwrap().split(',').collect();
        let line = |line: &str| {
            let cells: Vec<&str> = line.split(',').collect();
            assert_eq!(cells.len(), columns.len(), "{line}");
            Line(columns.iter().zip(cells).map(|(c, x)| (c.to_string(), x.to_string())).collect())
        };
        (head, lines.map(line).collect())
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

struct Line(std::collections::HashMap<String, String>);

impl Line {
    fn text(&self, column: &str) -> &str {
        &self.0[column]
    }
    fn number(&self, column: &str) -> f64 {
        self.text(column).parse().unwrap_or_else(|_| panic!("{column}: {}", self.text(column)))
    }
}

#[test]
fn the_countdown_with_its_markers() {
    let scratch = Scratch::new("countdown");
    let patch = Path::new(env!("CARGO_MANIFEST_DIR")).join("patches/19-countdown.toml");
    let patch = patch.to_str().unwrap();
    let (head, lines) = scratch.logged(patch, &["--seed", "7", "--rate", "44100"]);
    assert!(head.contains("19-countdown.toml\" seed=7 device_rate=44100 engine_rate=7350 "), "{head}");
    let markers: Vec<_> = lines.iter().filter(|l| l.text("kind") == "marker").collect();
    let found: Vec<_> = markers
        .iter()
        .map(|l| (l.text("name"), l.text("pattern"), l.text("event"), l.number("seconds")))
        .collect();
    assert_eq!(found, [("wait", "countdown", "1", 0.2), ("go", "countdown", "8", 5.2)]);
    for marker in markers {
        let samples = marker.number("sample") + marker.number("fraction");
        assert!((samples - marker.number("seconds") * 7350.0).abs() < 1e-6);
    }
    // Five bars of four ticks in the patch's own numbers: three slow ones, two at twice, four at four times the rate.
    let ticks: Vec<_> = lines.iter().filter(|l| l.text("name") == "tick").collect();
    assert_eq!((ticks.len(), lines.len()), (36, 39));
    assert_eq!((ticks[0].number("seconds"), ticks[0].number("level")), (0.2, 0.8 * 0.5));
    assert_eq!((ticks[1].number("frequency"), ticks[1].text("event")), (160.0, "2"));
    assert!((ticks[1].number("seconds") - 0.45).abs() < 1e-12 && ticks[1].text("place") == "t1");
    assert!(lines.windows(2).all(|w| w[0].number("seconds") <= w[1].number("seconds")));
    let before = scratch.read("out.csv");
    scratch.logged(patch, &["--seed", "7", "--rate", "44100"]);
    assert!(before == scratch.read("out.csv"), "the same seed gave another log");
}

const SHUFFLED: &str = r#"format = "pacinian-patch/1"
title = "Drawn"
[voice.tap]
output = "out"
defaults = { duration = 0.05 }
[voice.tap.nodes]
tone = { type = "sine", frequency = "event.frequency" }
edge = { type = "envelope", attack = 0.005, release = 0.005 }
out = { type = "multiply", inputs = ["tone", "edge"] }
[pattern.walk]
shuffle = true
events = [
  { at = 0.0, voice = "tap", place = 1 }, { at = 0.2, voice = "tap", place = 2 }, { at = 0.4, voice = "tap", place = 3 },
  { at = 0.6, voice = "tap", place = 4 }, { at = 0.8, voice = "tap", place = 5 }, { at = 1.0, voice = "tap", place = 6 },
]
[pattern.pick]
events = [{ at = 0.0, repeat = { every = 0.1, times = 40 }, choose = [
  { weight = 1, voice = "tap", place = 1 }, { weight = 1, voice = "tap", place = 2 }, { weight = 1, voice = "tap", place = 3 } ] }]
"#;

#[test]
fn what_was_shuffled_is_logged_as_it_sounded() {
    let scratch = Scratch::new("shuffle");
    std::fs::write(scratch.0.join("drawn.toml"), SHUFFLED).unwrap();
    let mut orders = Vec::new();
    for seed in ["1", "2", "3"] {
        let (_, lines) = scratch.logged("drawn.toml", &["--seed", seed, "--pattern", "walk"]);
        let logged: Vec<usize> = lines.iter().map(|l| l.number("event") as usize).collect();
        assert!(lines.iter().zip(&logged).all(|(l, event)| l.text("place") == format!("t{event}")));
        // Which channel is the loudest in each fifth of a second.
        let mut reader = hound::WavReader::open(scratch.0.join("out.wav")).unwrap();
        let channels = reader.spec().channels as usize;
        let samples: Vec<f32> = reader.samples::<f32>().map(Result::unwrap).collect();
        let sounded: Vec<usize> = (0..6)
            .map(|slot| {
                let part = &samples[slot * 9_600 * channels..][..3_000 * channels];
                let energy = |c: usize| part.iter().skip(c).step_by(channels).map(|x| x * x).sum::<f32>();
                (0..channels).max_by(|a, b| energy(*a).total_cmp(&energy(*b))).unwrap() + 1
            })
            .collect();
        assert_eq!(logged, sounded, "seed {seed}");
        orders.push(logged);
    }
    assert!(orders.iter().any(|order| *order != orders[0]), "the seed changes nothing: {orders:?}");
}

#[test]
fn what_was_chosen_is_logged() {
    let scratch = Scratch::new("choose");
    std::fs::write(scratch.0.join("drawn.toml"), SHUFFLED).unwrap();
    let (_, lines) = scratch.logged("drawn.toml", &["--pattern", "pick"]);
    assert_eq!(lines.len(), 40);
    assert!(lines.iter().all(|l| l.text("place") == format!("t{}", l.text("drawn"))));
    assert!((1..=3).all(|n| lines.iter().any(|l| l.number("drawn") == f64::from(n))));
}

#[test]
fn what_is_read_or_rendered_is_not_written_over() {
    let scratch = Scratch::new("over");
    std::fs::write(scratch.0.join("drawn.toml"), SHUFFLED).unwrap();
    std::fs::create_dir(scratch.0.join("folder")).unwrap();
    let mut cases = vec![
        ("drawn.toml", 2, "`drawn.toml` is read for this rendering"),
        ("./out.wav", 2, "cannot be both the rendering and its log"),
        ("-", 2, "--log out.csv"),
        ("folder", 73, "`folder` is a folder"),
        ("none/out.csv", 73, "`none/out.csv` cannot be written"),
    ];
    if cfg!(target_os = "linux") {
        cases.push(("/dev/full", 74, "`/dev/full`"));
    }
    for (log, code, words) in cases {
        let output = scratch.run(&["render", "drawn.toml", "-o", "out.wav", "--log", log]);
        let said = String::from_utf8_lossy(&output.stderr).replace(['\n'], " ");
        assert_eq!(output.status.code(), Some(code), "{log}: {said}");
        assert!(said.contains(words), "{log}: {said}");
    }
    assert_eq!(scratch.read("drawn.toml"), SHUFFLED);
}
