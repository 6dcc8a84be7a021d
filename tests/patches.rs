//! Every shipped patch and rig: it reads without a word of complaint, plays to its end within its limits, and is what it should
//! have been.
#![cfg(all(feature = "io", feature = "midi", feature = "report", feature = "fundsp-nodes"))]

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use pacinian::graph::plan::Why;
use pacinian::graph::scene::Options;
use pacinian::io::assets::Folder;
use pacinian::io::input::Input;
use pacinian::io::wav::WavReader;
use pacinian::midi::Message;
use pacinian::midi::file::Song;
use pacinian::node::NodeKind;
use pacinian::patch::{EventsFile, Patch};
use pacinian::player::{OpenEvents, Player};
use pacinian::report::{Measured, Take};
use pacinian::rig::{OutputKind, Rig};

/// Power of the difference from the scene reference within 1 kHz, dB.
const MOST_ERROR: f64 = -80.0;
/// Power above 1 kHz, of all power, dB.
const MOST_ABOVE: f64 = -60.0;
/// Seconds that a patch may last, so that the reference can be had for all of it.
const LONGEST: f64 = 25.0;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn files(folder: &str, ending: &str) -> Vec<PathBuf> {
    let entries = fs::read_dir(root().join(folder)).unwrap();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|e| e == ending));
    files.sort();
    assert!(!files.is_empty(), "nothing in {folder}");
    files
}

fn name(path: &Path) -> &str {
    path.file_name().and_then(|n| n.to_str()).unwrap()
}

fn patch(path: &Path) -> Patch {
    let checked = Patch::parse(name(path), &fs::read(path).unwrap()).unwrap_or_else(|p| panic!("{p}"));
    assert!(checked.warnings.list.is_empty(), "{}", checked.warnings);
    checked.value
}

fn rig(path: &Path) -> Rig {
    let checked = Rig::parse(name(path), &fs::read(path).unwrap()).unwrap_or_else(|p| panic!("{p}"));
    assert!(checked.warnings.list.is_empty(), "{}", checked.warnings);
    checked.value
}

/// The rig that a patch asks for in a line `# rig: PATH`; without one, eight tactors in a line.
fn rig_of(path: &Path) -> Rig {
    let text = fs::read_to_string(path).unwrap();
    let asked = text.lines().find_map(|line| line.strip_prefix("# rig: "));
    asked.map_or_else(|| Rig::default_for(8), |asked| rig(&root().join(asked.trim())))
}

/// What a patch hears, as it asks in a line `# input: PATH`.
fn input_of(path: &Path, player: &Player) -> Option<Input> {
    let text = fs::read_to_string(path).unwrap();
    let asked = text.lines().find_map(|line| line.strip_prefix("# input: "))?;
    let plan = player.plan();
    Some(Input::open(&root().join(asked.trim()), plan.device_rate, &plan.inputs()).unwrap())
}

/// What plays a patch, as it asks in a line `# midi: PATH`: its notes, and how they are bent and pressed. The reference knows nothing of
/// controls that move.
fn song_of(path: &Path) -> Option<Song> {
    let text = fs::read_to_string(path).unwrap();
    let asked = text.lines().find_map(|line| line.strip_prefix("# midi: "))?;
    let checked =
        Song::read(asked, &fs::read(root().join(asked.trim())).unwrap()).unwrap_or_else(|p| panic!("{p}"));
    assert!(checked.warnings.list.is_empty(), "{}", checked.warnings);
    let mut song = checked.value;
    // Of the controllers, those that choose a parameter and set it, and the timbre.
    let moves = |number: u8| ![6, 38, 74, 100, 101].contains(&number);
    song.messages
        .retain(|(_, message)| !matches!(message, Message::Controller { number, .. } if moves(*number)));
    Some(song)
}

fn player(path: &Path) -> Player {
    let song = song_of(path);
    let options = Options { rate: Some(48_000.0), live: song.is_some(), ..Options::default() };
    let folder = path.parent().unwrap().to_path_buf();
    let recordings = Folder::new(&folder).at_rate(16_000.0);
    let events: OpenEvents = Box::new(move |path| {
        let file =
            File::open(folder.join(path)).map_err(|e| pacinian::text::Problem::of_file(e.to_string()))?;
        Ok(Box::new(EventsFile::new(path, BufReader::new(file), None)?))
    });
    let (patch, rig) = (patch(path), rig_of(path));
    let problems = rig.check_places(&patch);
    assert!(problems.is_empty(), "{}: {problems:?}", name(path));
    let mut player = Player::with_files(&patch, &rig, &options, &recordings, events)
        .unwrap_or_else(|problems| panic!("{problems}"));
    if let Some(song) = song {
        player.play_song(song.messages, song.seconds);
    }
    player
}

/// What a patch came to.
struct Played {
    seconds: f64,
    /// By channel.
    peaks: Vec<f32>,
    voices: u64,
    measured: Measured,
}

/// Plays a patch to its end and measures it against the reference.
fn played(path: &Path) -> Result<Played, String> {
    let mut player = player(path);
    player.record();
    let channels = player.plan().channels;
    let mut peaks = vec![0.0_f32; channels];
    let mut frames = vec![0.0; 4800 * channels];
    let input = input_of(path, &player);
    let ears = player.engine().input_channels();
    let mut heard = vec![0.0; 4800 * ears];
    // A patch that listens is over when there is no more to be heard.
    let ends = input.as_ref().map_or(f64::INFINITY, Input::seconds);
    while !player.is_over() && player.seconds() < ends {
        if let Some(input) = &input {
            input.fill((player.seconds() * 48_000.0).round() as u64, ears, &mut heard);
        }
        player.process_input(&heard, &mut frames);
        for (i, x) in frames.iter().enumerate() {
            peaks[i % channels] = peaks[i % channels].max(x.abs());
        }
        if player.seconds() > LONGEST {
            return Err(format!("is not over after {LONGEST} s"));
        }
    }
    let (seconds, counters, counts) = (player.seconds(), player.counters(), player.engine().stage().counts());
    let mut faults = Vec::new();
    let mut fault = |is: bool, what: String| {
        if is {
            faults.push(what);
        }
    };
    fault(player.trouble().is_some(), format!("the patterns stopped: {:?}", player.trouble()));
    fault(counts.clamped > 0, format!("{} samples were clamped", counts.clamped));
    fault(counts.limited > 0, format!("{} samples were limited", counts.limited));
    fault(counts.masked + counters.masked > 0, "samples were masked".into());
    fault(counters.stolen > 0, format!("{} voices were stolen", counters.stolen));
    fault(counters.dropped + counters.late > 0, "events were dropped or late".into());
    // A rig may have more than a patch plays on, and say more than is acted on yet.
    let counts = |why: Why| !matches!(why, Why::NeverFed | Why::NotYet);
    let left_out = player.plan().left_out.iter().filter(|l| counts(l.why));
    let left_out: Vec<&str> = left_out.map(|l| l.what.as_str()).collect();
    fault(!left_out.is_empty(), format!("was left out: {}", left_out.join(", ")));
    let most = peaks.iter().copied().fold(0.0, f32::max);
    fault(most > 0.97, format!("its peak is {most}"));
    fault(most < 0.2, format!("its peak is only {most}"));
    fault(seconds < 3.0, format!("it lasts only {seconds} s"));
    let channels = input.as_ref().map_or(&[][..], Input::channels);
    let take = Take { events: player.recorded(), moves: player.recorded_moves(), input: channels, seconds };
    let measured = take.measure(player.plan(), &take.reference(player.plan())).unwrap();
    fault(
        measured.comparison.error_db > MOST_ERROR,
        format!("it differs from the reference by {:.1} dB", measured.comparison.error_db),
    );
    fault(
        measured.comparison.above_db > MOST_ABOVE,
        format!("it has {:.1} dB above 1 kHz", measured.comparison.above_db),
    );
    let played = Played { seconds, peaks, voices: counters.started, measured };
    if faults.is_empty() { Ok(played) } else { Err(format!("{}; {}", faults.join("; "), line(&played))) }
}

fn line(played: &Played) -> String {
    let used = played.peaks.iter().filter(|p| **p > 1e-4).count();
    format!(
        "{:5.1} s, {:4} voices on {:2} channels, peak {:.2}, error {:6.1} dB, above 1 kHz {:6.1} dB",
        played.seconds,
        played.voices,
        used,
        played.peaks.iter().copied().fold(0.0, f32::max),
        played.measured.comparison.error_db,
        played.measured.comparison.above_db,
    )
}

/// One line a patch is printed: run it with `-- --nocapture` to read them. `PATCH=rain` plays only what has that in its name.
#[test]
fn every_patch_plays_to_its_end_and_is_what_it_should_be() {
    let wanted = std::env::var("PATCH").unwrap_or_default();
    let mut all = files("patches", "toml");
    all.retain(|path| name(path).contains(&wanted));
    assert!(!all.is_empty(), "no patch has `{wanted}` in its name");
    // The longest first: it is the last in the folder.
    all.reverse();
    let (next, faults) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from).min(8) {
            scope.spawn(|| {
                while let Some(path) = all.get(next.fetch_add(1, Ordering::Relaxed)) {
                    match played(path) {
                        Ok(played) => println!("{:24} {}", name(path), line(&played)),
                        Err(fault) => faults.lock().unwrap().push(format!("{}: {fault}", name(path))),
                    }
                }
            });
        }
    });
    let faults = faults.into_inner().unwrap();
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn every_patch_says_what_it_is() {
    let mut titles = BTreeSet::new();
    for path in files("patches", "toml") {
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().next(), Some("#:schema ../schema/patch.json"), "{}", name(&path));
        let patch = patch(&path);
        assert!(patch.description.len() > 20, "{} lacks a description", name(&path));
        assert!(titles.insert(patch.title.clone()), "two patches are called {}", patch.title);
        let comments: usize =
            text.lines().filter_map(|line| line.split_once("# ")).map(|(_, c)| c.len()).sum();
        assert!(comments >= 250, "{} teaches nothing: {comments} characters of comments", name(&path));
    }
    assert!(titles.len() >= 17, "{titles:?}");
}

#[test]
fn the_ladder_has_no_missing_rung() {
    let mut numbers = Vec::new();
    for path in files("patches", "toml") {
        if let Some((number, _)) = name(&path).split_once('-') {
            numbers.push(number.parse::<usize>().unwrap());
        }
    }
    assert_eq!(numbers, (1..=numbers.len()).collect::<Vec<_>>());
}

#[test]
fn the_patches_together_use_most_nodes() {
    let mut used = BTreeSet::new();
    for path in files("patches", "toml") {
        let patch = patch(&path);
        let nodes = patch.voices.iter().flat_map(|v| &v.nodes).chain(&patch.shared);
        used.extend(nodes.map(|node: &pacinian::patch::Node| node.kind.spec().name));
    }
    for kind in ["sine", "pulse", "band_noise", "sweep", "envelope", "burst", "decay", "breakpoints"]
        .into_iter()
        .chain([
            "input",
            "lfo",
            "sample",
            "scan",
            "add",
            "multiply",
            "lowpass",
            "resonator",
            "delay",
            "follow",
        ])
    {
        assert!(NodeKind::find(kind).is_some() && used.contains(kind), "no patch shows `{kind}`");
    }
}

#[test]
fn every_rig_reads_and_every_channel_is_there() {
    for path in files("rigs", "toml") {
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(text.lines().next(), Some("#:schema ../schema/rig.json"), "{}", name(&path));
        let rig = rig(&path);
        assert!(!rig.title.is_empty() && rig.description.len() > 20, "{}", name(&path));
        let mut tactors = rig.outputs.iter().filter(|o| o.kind == OutputKind::Vibration);
        assert!(tactors.all(|o| o.position.is_some()), "{}: a tactor is nowhere", name(&path));
        let lines = rig.outputs.iter().filter_map(|o| match o.kind {
            OutputKind::Drive(turning) => turning.direction,
            _ => None,
        });
        let channels: BTreeSet<u32> = rig.outputs.iter().map(|o| o.channel).chain(lines).collect();
        assert_eq!(channels, (1..=rig.device.channels).collect(), "{}", name(&path));
    }
}

#[test]
fn recordings_are_small_and_plain() {
    for path in files("patches/recordings", "wav") {
        assert!(fs::metadata(&path).unwrap().len() < 100_000, "{}", name(&path));
        let mut reader = WavReader::open(&path).unwrap();
        assert_eq!((reader.info().channels, reader.info().rate), (1, 8000), "{}", name(&path));
        let samples = reader.channel(1).unwrap();
        let peak = samples.iter().fold(0.0_f32, |most, x| most.max(x.abs()));
        assert!((0.3..=0.99).contains(&peak), "{} has a peak of {peak}", name(&path));
    }
}
