//! What the program reads and writes, and what it must never write over.
#![cfg(all(feature = "cli", unix))]

mod program;

use program::{HEAD, Scratch, with};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

const PLAY: &str = "[pattern.p]\nevents = [{ at = 0, voice = \"beat\" }]\n";

/// Waits for the end, which is near.
fn end_of(mut child: Child) -> Output {
    let begin = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if begin.elapsed() > Duration::from_secs(60) {
            child.kill().unwrap();
            panic!("it hangs");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    child.wait_with_output().unwrap()
}

#[test]
fn nothing_that_the_patch_names_is_written_over() {
    let scratch = Scratch::new("named");
    scratch.run(&["render", "good.toml", "-o", "whole.wav", "--duration", "0.1"]).succeeds();
    let whole = std::fs::read(scratch.0.join("whole.wav")).unwrap();
    for name in ["felt", "shared", "deep"] {
        scratch.write(&format!("rec/{name}.wav"), &whole);
    }
    scratch.write("w.csv", "at,voice\n0,beat\n");
    // Neither the voice, nor the shared node, nor the pattern is ever played.
    scratch.write(
        "rec.toml",
        with(&format!(
            "{PLAY}[pattern.q]\nevents = \"w.csv\"\n[voice.unused]\noutput = \"x\"\n\
             nodes.x = {{ type = \"sample\", file = \"rec/felt.wav\" }}\n\
             [shared.nodes]\ns = {{ type = \"sample\", file = \"rec/shared.wav\" }}\n"
        )),
    );
    std::fs::hard_link(scratch.0.join("rec.toml"), scratch.0.join("hard.wav")).unwrap();
    std::fs::hard_link(scratch.0.join("w.csv"), scratch.0.join("hard-csv")).unwrap();
    for output in ["rec/felt.wav", "rec/shared.wav", "./rec/../rec/felt.wav", "hard.wav", "hard-csv"] {
        let before = std::fs::read(scratch.0.join(output)).unwrap();
        scratch.run(&["render", "rec.toml", "-o", output]).fails(2, &[output, "is read for this rendering"]);
        scratch
            .run(&["render", "rec.toml", "-o", "x.wav", "--log", output])
            .fails(2, &[output, "is read", "--log"]);
        assert_eq!(std::fs::read(scratch.0.join(output)).unwrap(), before, "{output}");
    }
    assert!(!scratch.0.join("x.wav").exists());
    scratch.run(&["plot", "rec.toml", "-o", "hard-csv"]).fails(2, &["hard-csv", "is read"]);
    scratch.run(&["render", "rec.toml", "-o", "x.wav"]).succeeds();
    // A log is no second name of the rendering.
    std::fs::hard_link(scratch.0.join("x.wav"), scratch.0.join("y.csv")).unwrap();
    scratch.run(&["render", "rec.toml", "-o", "x.wav", "--log", "y.csv"]).fails(2, &["both the rendering"]);
}

#[test]
fn what_is_there_stays_until_all_else_is_known_to_be_possible() {
    let scratch = Scratch::new("first");
    let run = |arguments: &[&str]| scratch.run(&[&["render", "good.toml", "-o"], arguments].concat());
    scratch.write("good.wav", "a take that took a day");
    scratch.write("old.csv", "and its log");
    run(&["good.wav", "--log", "no/where.csv"]).fails(73, &["no/where.csv"]);
    run(&["no/where.wav", "--log", "old.csv"]).fails(73, &["no/where.wav"]);
    run(&["good.wav", "--log", "."]).fails(73, &["is a folder"]);
    assert_eq!(std::fs::read_to_string(scratch.0.join("good.wav")).unwrap(), "a take that took a day");
    assert_eq!(std::fs::read_to_string(scratch.0.join("old.csv")).unwrap(), "and its log");
    run(&["new.wav", "--log", "no/where.csv"]).fails(73, &["no/where.csv"]);
    assert!(!scratch.0.join("new.wav").exists());
    // A picture's name is looked at before minutes go by.
    scratch.run(&["plot", "good.toml", "-o", "no/x.svg"]).fails(73, &["no/x.svg"]);
}

#[test]
fn nothing_goes_where_the_program_speaks() {
    let scratch = Scratch::new("streams");
    let into = |name: &str| std::fs::File::create(scratch.0.join(name)).unwrap();
    for (output, log) in
        [("/dev/stdout", "x.csv"), ("a.wav", "x.csv"), ("b.wav", "/dev/stdout"), ("b.wav", "a.wav")]
    {
        let mut command = scratch.command(&["render", "good.toml", "-o", output, "--log", log]);
        let run = command.stdout(into("a.wav")).stderr(Stdio::piped()).output().unwrap();
        program::Run::of(run).fails(2, &["what this program says"]);
        assert_eq!(std::fs::metadata(scratch.0.join("a.wav")).unwrap().len(), 0, "{output} {log}");
    }
    let mut command = scratch.command(&["render", "good.toml", "-o", "a.wav"]);
    assert_eq!(command.stderr(into("a.wav")).output().unwrap().status.code(), Some(2));
    // A device has no content to lose.
    let mut command = scratch.command(&["render", "good.toml", "-o", "/dev/null"]);
    let run = command.stdout(Stdio::null()).stderr(Stdio::piped()).output().unwrap();
    assert_eq!(run.status.code(), Some(0), "{}", String::from_utf8_lossy(&run.stderr));
}

#[test]
fn pipes_are_refused_before_they_are_waited_for() {
    let scratch = Scratch::new("pipes");
    assert!(Command::new("mkfifo").arg(scratch.0.join("fifo")).status().unwrap().success());
    scratch.write("file.toml", with("[pattern.p]\nevents = \"fifo\"\n"));
    let sample = "start = \"always\"\nnodes.s = { type = \"sample\", file = \"fifo\" }\n";
    scratch.write("sample.toml", format!("{HEAD}[voice.s]\noutput = \"s\"\n{sample}"));
    let render = |patch: &'static str, output: &'static str| vec!["render", patch, "-o", output];
    let with_log = [render("good.toml", "x.wav"), vec!["--log", "fifo"]].concat();
    let with_input = [render("good.toml", "x.wav"), vec!["--input", "fifo"]].concat();
    for (arguments, code) in [
        (vec!["check", "fifo"], 65),
        (vec!["check", "good.toml", "--rig", "fifo"], 78),
        (vec!["check", "good.toml", "--rig", "/dev/zero"], 78),
        (vec!["check", "file.toml"], 65),
        (vec!["check", "sample.toml"], 65),
        (with_input, 65),
        (render("good.toml", "fifo"), 73),
        (with_log, 73),
    ] {
        let mut command = scratch.command(&arguments);
        let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let word = if arguments.contains(&"/dev/zero") { "is a device" } else { "is a pipe" };
        program::Run::of(end_of(child)).fails(code, &[word]);
    }
}

#[test]
fn names_do_not_lie_about_what_is_in_a_file() {
    let scratch = Scratch::new("extensions");
    for name in ["x.mp3", "tap.TOML", "x.wav.flac"] {
        scratch.run(&["render", "good.toml", "-o", name]).fails(2, &["sound is WAV", ".wav`"]);
        assert!(!scratch.0.join(name).exists());
    }
    for name in ["x.PNG", "x.wav", "x.html"] {
        scratch.run(&["plot", "good.toml", "-o", name]).fails(2, &["pictures are SVG", "`x.svg`"]);
    }
    for name in ["x.WAV", "plain"] {
        scratch.run(&["render", "good.toml", "-o", name, "--duration", "0.1"]).succeeds();
    }
    scratch.run(&["plot", "good.toml", "-o", "x.SVG", "--duration", "0.1"]).succeeds();
}

#[test]
fn no_length_is_no_rendering() {
    let scratch = Scratch::new("short");
    let words = ["1e-9", "less than a frame at 48000 Hz"];
    scratch.run(&["render", "good.toml", "-o", "x.wav", "--duration", "1e-9"]).fails(2, &words);
    scratch.write("none.toml", with(&format!("{PLAY}[render]\nduration = 0\n")));
    for command in [&["render", "none.toml", "-o", "x.wav"][..], &["error", "none.toml"]] {
        scratch.run(command).fails(65, &["none.toml", "[render]", "less than a frame"]);
    }
    assert!(!scratch.0.join("x.wav").exists());
    scratch.run(&["render", "none.toml", "-o", "x.wav", "--duration", "0.1"]).succeeds();
}

#[test]
fn files_that_no_name_leads_to_are_not_there() {
    let scratch = Scratch::new("names");
    std::os::unix::fs::symlink("b.wav", scratch.0.join("a.wav")).unwrap();
    std::os::unix::fs::symlink("a.wav", scratch.0.join("b.wav")).unwrap();
    let long = format!("{}.wav", "n".repeat(300));
    for (file, word) in [("a.wav", "in a circle"), (&long, "shorter")] {
        let sample = format!("nodes.s = {{ type = \"sample\", file = \"{file}\" }}\n");
        scratch.write("s.toml", format!("{HEAD}[voice.s]\noutput = \"s\"\nstart = \"always\"\n{sample}"));
        scratch.run(&["check", "s.toml"]).fails(66, &[word]);
        scratch.run(&["check", file]).fails(66, &[word]);
    }
    // One of them is wrong in itself, so the patch is.
    let both = "nodes.s = { type = \"sample\", file = \"a.wav\" }\nnodes.t = { type = \"sample\", file = \"s.toml\" }\n\
                nodes.u = { type = \"add\", inputs = [\"s\", \"t\"] }\n";
    scratch.write("s.toml", format!("{HEAD}[voice.s]\noutput = \"u\"\nstart = \"always\"\n{both}"));
    scratch.run(&["check", "s.toml"]).fails(65, &["in a circle", "no WAV file"]);
}

#[test]
fn a_killed_rendering_leaves_its_log() {
    let scratch = Scratch::new("log");
    scratch.write(
        "e.toml",
        with("[pattern.p]\nevents = [{ at = 0, voice = \"beat\" }]\nrepeat = { every = 0.5 }\n"),
    );
    let arguments = ["render", "e.toml", "-o", "x.wav", "--log", "x.csv", "--duration", "100000"];
    let mut command = scratch.command(&arguments);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let size = |name: &str| std::fs::metadata(scratch.0.join(name)).map_or(0, |about| about.len());
    // Four refreshes, of two seconds each.
    while size("x.wav") < 8 * 4 * 48_000 * 9 {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(Duration::from_millis(2));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let log = std::fs::read_to_string(scratch.0.join("x.csv")).unwrap();
    let last = log.rfind('\n').and_then(|end| log[..end].lines().last()).unwrap_or_default();
    let seconds: f64 = last.split(',').next().and_then(|cell| cell.parse().ok()).unwrap_or(0.0);
    assert!(seconds >= 7.0, "{} bytes, up to {seconds} s", log.len());
}
