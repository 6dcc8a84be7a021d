//! What is saved while it plays takes over; what is broken does not, and says where.
#![cfg(feature = "cli")]

mod program;

use std::fs;
use std::io::Read;
use std::process::{Child, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use program::Scratch;

const PATCH: &str = "format = \"pacinian-patch/1\"\ntitle = \"first\"\n[control.depth]\ndefault = 0.25\n\
    [voice.hum]\nstart = \"always\"\noutput = \"s\"\n[voice.hum.nodes]\n\
    s = { type = \"sine\", frequency = 100, amplitude = \"depth\" }\n\
    [voice.tap]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = 90 }\n\
    [pattern.walk]\nevents = [{ at = 0.0, voice = \"tap\", duration = 0.05 }]\nrepeat = { every = 0.2, times = 10000 }\n";

/// So long something may take to be seen.
const PATIENCE: Duration = Duration::from_secs(20);

/// The program as it plays, and what it has said so far.
struct Playing {
    child: Child,
    said: Arc<Mutex<String>>,
    /// Up to where it was heard.
    heard: usize,
}

impl Playing {
    fn new(scratch: &Scratch, arguments: &[&str]) -> Self {
        let all = [&["play"], arguments, &["--device", "virtual", "--watch"]].concat();
        let mut child = scratch.command(&all).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
        let mut err = child.stderr.take().unwrap();
        let said = Arc::<Mutex<String>>::default();
        let into = Arc::clone(&said);
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(count @ 1..) = err.read(&mut bytes) {
                into.lock().unwrap().push_str(&String::from_utf8_lossy(&bytes[..count]));
            }
        });
        let mut playing = Self { child, said, heard: 0 };
        playing.hears("tap on t1");
        playing
    }

    /// Waits until it says this, behind what was heard before; gives what came in between.
    #[track_caller]
    fn hears(&mut self, what: &str) -> String {
        let begin = Instant::now();
        loop {
            let said = self.said.lock().unwrap().clone();
            if let Some(at) = said[self.heard..].find(what) {
                let end = self.heard + at + what.len();
                let between = said[std::mem::replace(&mut self.heard, end)..end].to_string();
                return between;
            }
            assert!(begin.elapsed() < PATIENCE, "no `{what}` in\n{}", &said[self.heard..]);
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

impl Drop for Playing {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

#[test]
fn what_is_saved_plays_and_what_is_broken_is_shown_at_its_line() {
    let scratch = Scratch::new("watch-saved");
    let patch = scratch.write("p.toml", PATCH);
    let mut playing = Playing::new(&scratch, &["p.toml"]);
    // Another voice.
    fs::write(&patch, PATCH.replace("tap", "knock")).unwrap();
    playing.hears("p.toml: taken up");
    playing.hears("knock on t1");
    // Broken in two places.
    fs::write(&patch, PATCH.replace("tap", "touch").replace("\"sine\"", "\"sinus\"")).unwrap();
    playing.hears("the old one plays on: p.toml:9: node `s` of voice `hum`: there is no node type \"sinus\" (and 1 more)");
    playing.hears("p.toml:9:14: error: node `s` of voice `hum`: there is no node type \"sinus\"");
    playing.hears("help: did you mean `sine`?");
    playing.hears("p.toml:12:");
    let between = playing.hears("knock on t1");
    assert!(!between.contains("the old one"), "said once: {between}");
    // Mended.
    fs::write(&patch, PATCH.replace("tap", "touch")).unwrap();
    playing.hears("p.toml: taken up");
    playing.hears("touch on t1");
}

#[test]
fn a_file_that_is_gone_or_is_a_folder_is_waited_for() {
    let scratch = Scratch::new("watch-gone");
    let patch = scratch.write("p.toml", PATCH);
    let mut playing = Playing::new(&scratch, &["p.toml"]);
    fs::remove_file(&patch).unwrap();
    playing.hears("the old one plays on: `p.toml` is not there");
    for _ in 0..5 {
        let between = playing.hears("tap on t1");
        assert!(!between.contains("the old one"), "said once: {between}");
    }
    fs::create_dir(&patch).unwrap();
    playing.hears("the old one plays on: `p.toml` is a folder");
    fs::remove_dir(&patch).unwrap();
    playing.hears("the old one plays on: `p.toml` is not there");
    // By renaming, as many editors save.
    scratch.write("new", PATCH.replace("tap", "knock"));
    fs::rename(scratch.0.join("new"), &patch).unwrap();
    playing.hears("p.toml: taken up");
    playing.hears("knock on t1");
    scratch.write("new", PATCH.replace("tap", "touch"));
    fs::rename(scratch.0.join("new"), &patch).unwrap();
    playing.hears("p.toml: taken up");
    playing.hears("touch on t1");
}

#[test]
fn the_last_of_many_saves_plays() {
    let scratch = Scratch::new("watch-many");
    let patch = scratch.write("p.toml", PATCH);
    let mut playing = Playing::new(&scratch, &["p.toml"]);
    for n in 0..100 {
        // Half of it, and then all.
        let text = PATCH.replace("tap", &format!("tap{n}"));
        fs::write(&patch, &text[..text.len() / 2]).unwrap();
        std::thread::sleep(Duration::from_millis(5));
        fs::write(&patch, text).unwrap();
        std::thread::sleep(Duration::from_millis(5));
    }
    let between = playing.hears("tap99 on t1");
    assert!(!between.contains("the old one"), "half of a file was taken for one: {between}");
}

#[test]
fn what_the_patch_names_is_watched_and_what_another_session_needs_is_kept() {
    let scratch = Scratch::new("watch-named");
    let table = PATCH.replace("[{ at = 0.0, voice = \"tap\", duration = 0.05 }]", "\"steps.csv\"");
    let rig = "format = \"pacinian-rig/1\"\ntitle = \"r\"\n[device]\nname = \"virtual\"\nrate = 48000\nchannels = 2\n\
        [[output]]\nname = \"t1\"\nchannel = 1\n[[output]]\nname = \"left\"\nchannel = 2\n";
    scratch.write("p.toml", &table);
    scratch.write("steps.csv", "at,voice,place\n0,tap,t1\n");
    scratch.write("r.toml", rig);
    let mut playing = Playing::new(&scratch, &["p.toml", "--rig", "r.toml", "--set", "depth=0.125"]);
    scratch.write("steps.csv", "at,voice,place\n0,tap,left\n");
    playing.hears("steps.csv: taken up");
    playing.hears("tap on left");
    scratch.write("steps.csv", "at,voice,place\n0,tap,right\n");
    playing.hears("the old one plays on: steps.csv:2: ");
    playing.hears("`steps.csv` is named in p.toml:12");
    scratch.write("r.toml", rig.replace("left", "right"));
    playing.hears("r.toml: taken up");
    playing.hears("tap on right");
    for (from, to, why) in [
        ("channels = 2", "channels = 3", "the rig has 3 channels, and the session began with 2: end this session"),
        ("name = \"virtual\"", "name = \"Other\"", "the rig names another device, `Other`: end this session"),
        ("rate = 48000", "rate = 44100", "the rig says another rate, 44100 Hz: end this session"),
        ("channel = 2\n", "channel = 2\nkind = \"trigger\"\n", "the new rig has other outputs"),
    ] {
        scratch.write("r.toml", rig.replace("left", "right").replace(from, to));
        playing.hears(&format!("the old one plays on: {why}"));
    }
    // A file that the broken patch names before it is there.
    scratch.write("r.toml", rig);
    scratch.write("p.toml", table.replace("steps", "more"));
    playing.hears("the old one plays on: p.toml:12: ");
    scratch.write("more.csv", "at,voice,place\n0,tap,left\n");
    playing.hears("more.csv: taken up");
    playing.hears("tap on left");
}

#[test]
fn a_pipe_cannot_be_watched() {
    let scratch = Scratch::new("watch-pipe");
    let run = scratch.run(&["play", "-", "--device", "virtual", "--watch"]);
    run.fails(2, &["--watch looks at files, and the patch comes through a pipe", "save it to a file"]);
    let run = scratch.run(&["play", "good.toml", "--rig", "/dev/stdin", "--device", "virtual", "--watch"]);
    run.fails(2, &["the rig comes through a pipe"]);
}
