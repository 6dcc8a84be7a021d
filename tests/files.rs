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
    std::os::unix::fs::symlink("./new.wav", scratch.0.join("z.csv")).unwrap();
    for (output, log) in [("x.wav", "y.csv"), ("new.wav", "z.csv")] {
        scratch.run(&["render", "rec.toml", "-o", output, "--log", log]).fails(2, &["both the rendering"]);
    }
    assert!(!scratch.0.join("new.wav").exists());
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
    let with_midi = |file: &'static str| [render("good.toml", "x.wav"), vec!["--midi", file]].concat();
    let with_input = [render("good.toml", "x.wav"), vec!["--input", "fifo"]].concat();
    for (arguments, code) in [
        (vec!["check", "fifo"], 65),
        (vec!["check", "good.toml", "--rig", "fifo"], 78),
        (vec!["check", "good.toml", "--rig", "/dev/zero"], 78),
        (vec!["check", "file.toml"], 65),
        (vec!["check", "sample.toml"], 65),
        (with_input, 65),
        (with_midi("fifo"), 65),
        (with_midi("/dev/zero"), 65),
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
    let words = ["0.000000001 s", "less than a frame at 48000 Hz"];
    scratch.run(&["render", "good.toml", "-o", "x.wav", "--duration", "1e-9"]).fails(2, &words);
    scratch.write("none.toml", with(&format!("{PLAY}[render]\nduration = 0.000002\n")));
    for command in [&["render", "none.toml", "-o", "x.wav"][..], &["error", "none.toml"]] {
        scratch.run(command).fails(65, &["none.toml", "[render]", "less than a frame"]);
    }
    assert!(!scratch.0.join("x.wav").exists());
    scratch.run(&["render", "none.toml", "-o", "x.wav", "--duration", "0.1"]).succeeds();
    // Zero is no length, whoever asks.
    scratch.write("zero.toml", with(&format!("{PLAY}[render]\nduration = 0\n")));
    scratch.run(&["check", "zero.toml"]).fails(65, &["zero.toml:12:12: error: `duration`", "from 0.000001"]);
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

/// Sends Ctrl-C when `ready` says so.
fn interrupt(child: &mut Child, mut ready: impl FnMut() -> bool) {
    while !ready() {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn the_demo_shows_what_it_has_before_it_measures_and_stops_when_asked() {
    use std::io::Read;
    let scratch = Scratch::new("demo");
    for json in [false, true] {
        let arguments = if json { &["demo", "--json"][..] } else { &["demo"] };
        let mut command = scratch.command(arguments);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        let mut out = Vec::new();
        let picture = scratch.0.join("pacinian-demo.svg");
        if json {
            interrupt(&mut child, || std::fs::read(&picture).is_ok_and(|svg| svg.ends_with(b"</svg>\n")));
        } else {
            // The summary and the picture come before the measurement.
            let mut piece = [0; 4096];
            while !String::from_utf8_lossy(&out).contains("every tactor did") {
                let length = child.stdout.as_mut().unwrap().read(&mut piece).unwrap();
                assert!(length > 0, "it ended without a picture");
                out.extend_from_slice(&piece[..length]);
            }
            interrupt(&mut child, || true);
        }
        let output = end_of(child);
        out.extend_from_slice(&output.stdout);
        let run = program::Run::of(Output { stdout: out, ..output });
        run.fails(130, &["stopped", "picture are complete", "not measured"]);
        if json {
            assert!(run.json()["error_db"].is_null() && run.json()["frames"].as_u64() > Some(0));
        }
        assert_eq!(scratch.wav("pacinian-demo.wav").0.channels, 16);
        std::fs::remove_file(picture).unwrap();
    }
}

#[test]
fn a_measurement_stops_when_asked_and_says_how_far_it_was() {
    let scratch = Scratch::new("measure");
    scratch.write(
        "long.toml",
        format!("{HEAD}[voice.n]\noutput = \"n\"\nstart = \"always\"\nnodes.n = {{ type = \"sine\", frequency = 250 }}\n"),
    );
    let mut command = scratch.command(&["error", "long.toml", "--duration", "120", "--csv"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    // It renders for a moment, and then computes references for a long time; how many are done by then depends on the machine.
    let begin = Instant::now();
    interrupt(&mut child, || begin.elapsed() > Duration::from_secs(3));
    let run = program::Run::of(end_of(child));
    run.fails(130, &["stopped; ", " of 6 settings were measured"]);
    assert!(run.out.is_empty(), "{}", run.out);
}

/// A mono file of 8 bits and 1 kHz that claims `frames` frames, which take no room on the disk.
fn sparse(scratch: &Scratch, name: &str, rate: u32, frames: u32) {
    let mut head = b"RIFF\0\0\0\0WAVEfmt \x10\0\0\0\x01\0\x01\0".to_vec();
    head.extend([rate, rate].map(u32::to_le_bytes).concat());
    head.extend(b"\x01\0\x08\0data");
    head.extend(frames.to_le_bytes());
    let length = head.len() as u32 + frames;
    head[4..8].copy_from_slice(&(length - 8).to_le_bytes());
    let path = scratch.write(name, head);
    std::fs::File::options().write(true).open(path).unwrap().set_len(length.into()).unwrap();
}

/// The address space that `ulimit` leaves is a fraction of what such a file would become.
#[cfg(target_os = "linux")]
#[test]
fn a_long_file_is_refused_and_not_taken_into_memory() {
    let scratch = Scratch::new("memory");
    let run = |arguments: &str| {
        let mut command = Command::new("sh");
        let program = env!("CARGO_BIN_EXE_pacinian");
        let line = format!("ulimit -v 1000000; exec {program} {arguments}");
        program::Run::of(command.current_dir(&scratch.0).args(["-c", &line]).output().unwrap())
    };
    let voice = |node: &str| {
        format!("{HEAD}[voice.v]\nstart = \"always\"\noutput = \"o\"\nnodes.o = {{ type = {node} }}\n")
    };
    scratch.write("ear.toml", voice("\"input\", channel = 1"));
    scratch.write("play.toml", voice("\"sample\", file = \"long.wav\""));
    sparse(&scratch, "long.wav", 1_000, 200_000_000);
    sparse(&scratch, "ten.wav", 1_000, 10_000_000);
    run("render ear.toml --input ten.wav --rate 768000 -o x.wav")
        .fails(65, &["`ten.wav`", "7680000000 samples at 768000 Hz", "--duration"]);
    run("render ear.toml --input long.wav -o x.wav").fails(65, &["`long.wav`", "--duration"]);
    run("check play.toml").fails(65, &["long.wav`", "3200000000 samples", "cut it"]);
    run("render ear.toml --input long.wav --duration 0.1 -o x.wav").succeeds();
    run("render ear.toml --input ten.wav --duration 0.1 --rate 768000 -o x.wav").succeeds();
}

#[test]
fn a_form_that_no_wav_file_has_is_refused_beforehand() {
    let scratch = Scratch::new("form");
    scratch.write(
        "rig.toml",
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 4096\n[[tactor]]\nname = \"t1\"\nchannel = 1\n\
         [[tactor]]\nname = \"t2\"\nchannel = 2\n",
    );
    let run = |command: &[&str], rate: &str| {
        scratch.run(&[command, &["good.toml", "--rig", "rig.toml", "--rate", rate]].concat())
    };
    let render = ["render", "-o", "x.wav"];
    run(&render, "384000").fails(2, &["of f32 holds 4096 channels", "--format i16"]);
    run(&render, "768000").fails(78, &["holds 4096 channels at 768,000 Hz", "fewer channels"]);
    assert!(!scratch.0.join("x.wav").exists());
    let check = run(&["check"], "384000");
    assert!(check.succeeds().err.contains("--format i16"), "{}", check.err);
    run(&["check"], "768000").fails(78, &["holds 4096 channels"]);
    assert!(run(&["check"], "192000").succeeds().err.is_empty());
    let short = [&render[..], &["--format", "i16", "--duration", "0.001"]].concat();
    run(&short, "384000").succeeds();
}

#[test]
fn thousands_of_wrong_names_on_one_line_are_told_in_few_words() {
    let scratch = Scratch::new("many");
    let long = "x".repeat(500);
    let mut events = String::new();
    for n in 0..10_000 {
        events += &format!("{{ at = 0, voice = \"beat\", place = \"toe{n}{long}\" }},");
    }
    scratch.write("places.toml", with(&format!("[pattern.p]\nevents = [{events}]\n")));
    let mut nodes = String::new();
    for n in 0..5_000 {
        nodes += &format!("s{n} = {{ type = \"sample\", file = \"no{n}.wav\" }}\n");
    }
    let all: Vec<String> = (0..5_000).map(|n| format!("\"s{n}\"")).collect();
    let voice =
        "[voice.v]\nstart = \"always\"\noutput = \"o\"\n[voice.v.nodes]\no = { type = \"add\", inputs = [";
    scratch.write("samples.toml", format!("{HEAD}{voice}{}] }}\n{nodes}", all.join(",")));
    for (file, code, words) in [
        ("places.toml", 65, ["`toe0xxx", "and 9500 more places"]),
        ("samples.toml", 66, ["`no0.wav` is not there", "and 4500 more problems"]),
    ] {
        let mut command = scratch.command(&["check", file]);
        let child =
            command.stdout(Stdio::null()).stderr(std::fs::File::create(scratch.0.join("err")).unwrap());
        let status = end_of(child.spawn().unwrap()).status;
        let err = std::fs::read_to_string(scratch.0.join("err")).unwrap();
        assert_eq!(status.code(), Some(code), "{}", &err[..err.len().min(500)]);
        assert!(words.iter().all(|word| err.contains(word)), "{}", &err[..err.len().min(500)]);
        assert!(
            !err.contains("and 1 more")
                && err.lines().count() < 1_100
                && err.lines().all(|line| line.len() < 400)
        );
    }
}

#[test]
fn a_name_cannot_forge_a_line() {
    let scratch = Scratch::new("forge");
    let forged = "x\\nforged.toml:1:1: error: all is lost\\u001b[2J";
    scratch.write("bad.toml", with(&format!("[pattern.p]\nevents = [{{ at = 0, voice = \"{forged}\" }}]\n")));
    scratch.write("title.toml", with(PLAY).replace("title = \"A test\"", &format!("title = \"{forged}\"")));
    for file in ["bad.toml", "title.toml"] {
        for plain in [&["--plain"][..], &["--color", "always"]] {
            let run = scratch.run(&[plain, &["check", file]].concat());
            let text = run.out + &run.err;
            assert!(text.contains("forged.toml") && !text.contains("\x1b[2J"), "{text}");
            assert!(text.lines().all(|line| !line.starts_with("forged.toml")), "{text}");
        }
    }
}

#[test]
fn a_comparison_that_takes_too_much_memory_is_refused() {
    let scratch = Scratch::new("room");
    scratch
        .run(&["error", "good.toml", "--duration", "10000"])
        .fails(2, &["8 channels", "2 GB", "--duration "]);
}

#[test]
fn a_picture_that_is_stopped_says_how_far_it_goes() {
    let scratch = Scratch::new("picture");
    let mut command = scratch.command(&["plot", "good.toml", "-o", "x.svg", "--duration", "1e6"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let begin = Instant::now();
    interrupt(&mut child, || begin.elapsed() > Duration::from_secs(2));
    program::Run::of(end_of(child)).fails(130, &["stopped; the picture shows the first "]);
    assert!(std::fs::read_to_string(scratch.0.join("x.svg")).unwrap().contains("</svg>"));
}
