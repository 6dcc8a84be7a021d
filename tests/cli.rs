//! The program itself, run as people run it.
#![cfg(feature = "cli")]

mod program;

use program::{GOOD, HEAD, Run, Scratch, read_wav, with};
use serde_json::Value;
use std::process::Command;

#[test]
fn a_good_patch_shows_its_plan() {
    let scratch = Scratch::new("plan");
    let run = scratch.run(&["check", "good.toml"]);
    run.succeeds();
    for word in
        ["nothing is wrong", "8,000 Hz (1/6)", "beat", "8 lanes", "voice `never`", "nothing starts it"]
    {
        assert!(run.out.contains(word), "{word}: {}", run.out);
    }
    assert!(run.err.is_empty(), "{}", run.err);
    assert!(!run.out.contains('\x1b'), "no colours off a terminal");
    assert!(scratch.run(&["--color", "always", "check", "good.toml"]).out.contains("\x1b["));

    let plan = scratch.run(&["check", "good.toml", "--json", "--rate", "44100"]).succeeds().json();
    assert_eq!(plan["ok"], true);
    assert_eq!(plan["plan"]["engine_rate"], 7350.0);
    assert_eq!(plan["plan"]["voices"][0]["name"], "beat");
    let delay = &plan["plan"]["delay_ms"];
    let sum: f64 = ["voices", "up_sampling", "band_limit"].iter().map(|k| delay[*k].as_f64().unwrap()).sum();
    assert!((sum - delay["total"].as_f64().unwrap()).abs() < 1e-9);
    let left: Vec<&Value> = plan["plan"]["left_out"].as_array().unwrap().iter().map(|l| &l["what"]).collect();
    assert!(left.contains(&&Value::from("voice `never`")), "{left:?}");
}

#[test]
fn every_problem_is_shown_at_once_and_at_its_place() {
    let scratch = Scratch::new("problems");
    scratch.write(
        "bad.toml",
        with("[pattern.p]\nevents = [{ at = 0, voice = \"baet\" }, { at = -1, voice = \"beat\" }]\n"),
    );
    scratch.write("rig.toml", "format = \"pacinian-rig/1\"\n[device]\nchanels = 4\n");
    let run = scratch.run(&["check", "bad.toml", "--rig", "rig.toml"]);
    run.fails(
        65,
        &["bad.toml:10:", "did you mean `beat`?", "`at`", "rig.toml:3:1: error:", "`channels`", "errors"],
    );
    scratch.run(&["render", "bad.toml", "-o", "x.wav"]).fails(65, &["bad.toml:10:"]);
    assert!(!scratch.0.join("x.wav").exists());

    let list = scratch.run(&["check", "bad.toml", "--json"]);
    assert_eq!(list.code, Some(65));
    assert_eq!(list.json()["problems"][0]["line"], 10);
    let picture = scratch.run(&["--color=always", "check", "bad.toml"]);
    picture.fails(65, &["bad.toml:10:", "│", "\x1b["]);
    scratch.run(&["--color=always", "--plain", "check", "bad.toml"]).fails(65, &["bad.toml:10:"]);
}

/// The exit code says what kind of thing is wrong.
#[test]
fn files_that_are_none() {
    let scratch = Scratch::new("files");
    let check = |name: &str| scratch.run(&["check", name]);
    check("none.toml").fails(66, &["`none.toml` is not there"]);
    check(".").fails(66, &["is a folder"]);
    scratch.write("latin.toml", b"format = \"pacinian-patch/1\"\ntitle = \"caf\xe9\"\n");
    check("latin.toml").fails(65, &["line 2", "not UTF-8"]);
    scratch.write("empty.toml", "");
    check("empty.toml").fails(65, &["empty"]);
    scratch.write("huge.toml", vec![b'#'; (16 << 20) + 1]);
    check("huge.toml").fails(65, &["`huge.toml`", "16777216"]);
    scratch.write("deep.toml", format!("{HEAD}x = {}", "[".repeat(10_000)));
    check("deep.toml").fails(65, &["deeper than"]);
    let drawn = scratch.run(&["--color=always", "check", "deep.toml"]);
    assert!(drawn.err.len() < 2_000, "a line of 10,000 brackets is not drawn");
    scratch.write("toml.toml", "a = = b\n");
    check("toml.toml").fails(65, &["toml.toml:1:", "not TOML"]);
    scratch.run(&["check", "good.toml", "--rig", "none.toml"]).fails(66, &["none.toml"]);
    scratch.write(
        "rig.toml",
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\n[[tactor]]\nname = \"a\"\nchannel = 3\n",
    );
    scratch.run(&["check", "good.toml", "--rig", "rig.toml"]).fails(78, &["rig.toml:6:", "the device has 2"]);
}

#[test]
fn patches_that_mean_nothing() {
    let scratch = Scratch::new("meaning");
    let one = "events = [{ at = 0, voice = \"beat\" }]\n";
    for (name, text, words) in [
        ("version", "format = \"pacinian-patch/2\"\ntitle = \"t\"\n".into(), &["version 2"][..]),
        ("key", with("[pattern.p]\nevnts = []\n"), &["`evnts`", "did you mean `events`"]),
        (
            "type",
            with("[voice.v]\noutput = \"o\"\nnodes.o = { type = \"sien\" }\n"),
            &["\"sien\"", "did you mean `sine`"],
        ),
        (
            "cycle",
            with(
                "[voice.v]\noutput = \"a\"\nnodes.a = { type = \"add\", inputs = [\"b\"] }\nnodes.b = { type = \"add\", inputs = [\"a\"] }\n",
            ),
            &["a → b → a", "delay"],
        ),
        ("itself", with("[pattern.p]\nevents = [{ at = 0, pattern = \"p\" }]\n"), &["contains itself"]),
        ("voice", with("[pattern.p]\nevents = [{ at = 0, voice = \"bet\" }]\n"), &["no voice `bet`"]),
        ("neither", with("[pattern.p]\nevents = [{ at = 0 }]\n"), &["voice"]),
        (
            "place",
            with(&format!("[pattern.p]\n{}", one.replace("beat\"", "beat\", place = \"toe\""))),
            &["no tactor `toe`", "--rig"],
        ),
        (
            "wav",
            with(
                "[voice.v]\noutput = \"s\"\nstart = \"always\"\nnodes.s = { type = \"sample\", file = \"../x.wav\" }\n",
            ),
            &["--allow-outside"],
        ),
    ] {
        let file = format!("{name}.toml");
        scratch.write(&file, text);
        let run = scratch.run(&["check", &file]);
        run.fails(65, words);
        assert!(run.err.starts_with(&file), "{}", run.err);
    }
    scratch.write("silent.toml", with(""));
    scratch.run(&["render", "silent.toml", "-o", "x.wav"]).fails(65, &["nothing", "[pattern]"]);
    scratch.write(
        "rig.toml",
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\n[[tactor]]\nname = \"top\"\nchannel = 1\n",
    );
    scratch.write("far.toml", with("[pattern.p]\nevents = [{ at = 0, voice = \"beat\", place = 7 }]\n"));
    scratch.run(&["check", "far.toml", "--rig", "rig.toml"]).fails(65, &["there is no channel 7", "has 2"]);
    scratch.run(&["check", "far.toml"]).succeeds();
}

/// A file that its user lets grow no further is told, and does not kill the program.
#[cfg(unix)]
#[test]
fn a_file_that_may_not_grow_is_told() {
    let scratch = Scratch::new("limit");
    let tone = "[voice.a]\noutput = \"tone\"\n[voice.a.nodes]\ntone = { type = \"sine\", frequency = 100 }\n\
                [pattern.p]\nevents = [{ at = 0, voice = \"a\", duration = 9 }]\n";
    scratch.write("long.toml", format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{tone}"));
    let command = "ulimit -f 100; exec \"$0\" render long.toml -o out.wav";
    let run = Command::new("sh")
        .args(["-c", command, env!("CARGO_BIN_EXE_pacinian")])
        .current_dir(&scratch.0)
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&run.stderr);
    assert_eq!(run.status.code(), Some(74), "{said}");
    assert!(said.contains("out.wav") && said.contains("ulimit -f"), "{said}");
}

#[test]
fn recordings_and_events_files() {
    let scratch = Scratch::new("beside");
    let player =
        "[voice.s]\noutput = \"s\"\nstart = \"always\"\nnodes.s = { type = \"sample\", file = \"a.wav\" }\n";
    scratch.write("sample.toml", with(player));
    let check = |name: &str| scratch.run(&["check", name]);
    check("sample.toml")
        .fails(66, &["sample.toml:12:", "`a.wav` is not there", "counts from the patch's folder"]);
    scratch.write("a.wav", "RIFF");
    check("sample.toml").fails(65, &["a.wav"]);
    let whole = {
        scratch.run(&["render", "good.toml", "-o", "whole.wav"]).succeeds();
        std::fs::read(scratch.0.join("whole.wav")).unwrap()
    };
    let mut lying = whole.clone();
    lying.truncate(whole.len() / 2);
    scratch.write("a.wav", &lying);
    let run = check("sample.toml");
    assert!(matches!(run.code, Some(0 | 65)), "{}", run.err);
    scratch.write("a.wav", &whole);
    check("sample.toml").succeeds();
    scratch.run(&["render", "sample.toml", "-o", "a.wav", "--duration", "1"]).fails(2, &["`a.wav`", "-o"]);
    assert_eq!(std::fs::read(scratch.0.join("a.wav")).unwrap(), whole, "nothing was written over");

    scratch.write("file.toml", with("[pattern.p]\nevents = \"w.csv\"\n"));
    check("file.toml").fails(66, &["w.csv", "is not there"]);
    scratch.write("w.csv", "at,voice,level\n0,beat,1\n1,beat,loud\n2,bat,1\n");
    check("file.toml").fails(65, &["file.toml:10", "w.csv:3:", "w.csv:4:", "did you mean `beat`"]);
    scratch.run(&["render", "file.toml", "-o", "x.wav"]).fails(65, &["w.csv:3:"]);
    scratch.write("w.csv", "at,voice,level\n0,beat,0.5\n0.1,beat,0.5\n");
    let summary = scratch.run(&["render", "file.toml", "-o", "x.wav", "--json"]).succeeds().json();
    assert_eq!(summary["voices_started"], 2);
}

#[test]
fn rendering_writes_what_it_says() {
    let scratch = Scratch::new("render");
    let run = scratch.run(&["render", "good.toml", "-o", "x.wav", "--json"]);
    let summary = run.succeeds().json();
    assert!(run.err.is_empty(), "no bar off a terminal: {}", run.err);
    let (spec, samples) = scratch.wav("x.wav");
    assert_eq!((spec.channels, spec.sample_rate, spec.bits_per_sample), (8, 48_000, 32));
    assert_eq!(samples.len() as u64 / 8, summary["frames"].as_u64().unwrap());
    assert!(samples.len() / 8 > 48_000 * 3 / 10, "both events and what they ring on");
    for c in 0..8 {
        let peak = samples.iter().skip(c).step_by(8).fold(0.0_f32, |p, x| p.max(x.abs()));
        let told = summary["peaks"][c]["peak"].as_f64().unwrap();
        assert!((f64::from(peak) - told).abs() < 1e-6, "channel {c}: {peak} {told}");
        assert_eq!(peak > 0.0, c < 2, "channel {c}");
    }
    assert_eq!(summary["voices_started"], 2);
    assert_eq!(summary["complete"], true);
    assert_eq!(summary["left_out"][0]["what"], "voice `never`");
    let tail = &samples[samples.len() - 8 * 48..];
    assert!(tail.iter().all(|x| *x == 0.0), "it ends in silence");

    for (format, bits) in [("i24", 24), ("i16", 16)] {
        let file = format!("{format}.wav");
        scratch
            .run(&[
                "render",
                "good.toml",
                "-o",
                &file,
                "--format",
                format,
                "--rate",
                "44100",
                "--duration",
                "0.5",
            ])
            .succeeds();
        let (spec, other) = scratch.wav(&file);
        assert_eq!((spec.sample_rate, spec.bits_per_sample), (44_100, bits));
        assert_eq!(other.len(), 8 * 22_050);
    }
    let text = scratch.run(&["render", "good.toml", "-o", "x.wav"]);
    for word in ["x.wav", "2 started", "dBFS", "wall time", "6 of 8 channels silent"] {
        assert!(text.out.contains(word), "{word}: {}", text.out);
    }
}

#[test]
fn the_same_seed_gives_the_same_file_and_another_does_not() {
    let scratch = Scratch::new("seed");
    scratch.write(
        "n.toml",
        format!("{HEAD}[voice.n]\noutput = \"n\"\nstart = \"always\"\nnodes.n = {{ type = \"white\" }}\n"),
    );
    let render = |file: &str, seed: &str| {
        scratch.run(&["render", "n.toml", "-o", file, "--duration", "0.2", "--seed", seed]).succeeds();
        std::fs::read(scratch.0.join(file)).unwrap()
    };
    let first = render("a.wav", "7");
    assert_eq!(first, render("b.wav", "7"));
    assert_ne!(first, render("c.wav", "8"));
}

#[test]
fn what_has_no_end_needs_a_duration() {
    let scratch = Scratch::new("endless");
    scratch.write(
        "e.toml",
        with("[pattern.p]\nevents = [{ at = 0, voice = \"beat\" }]\nrepeat = { every = 0.5 }\n"),
    );
    scratch.run(&["render", "e.toml", "-o", "x.wav"]).fails(2, &["pattern `p`", "--duration"]);
    assert!(!scratch.0.join("x.wav").exists());
    let summary =
        scratch.run(&["render", "e.toml", "-o", "x.wav", "--duration", "2", "--json"]).succeeds().json();
    assert_eq!((&summary["frames"], &summary["voices_started"]), (&96_000.into(), &4.into()));
    for duration in ["0", "-1", "nan", "inf", "soon"] {
        let words = format!("--duration={duration}");
        scratch.run(&["render", "e.toml", "-o", "x.wav", &words]).fails(2, &["seconds"]);
    }
}

#[test]
fn the_command_line_is_checked() {
    let scratch = Scratch::new("usage");
    scratch.run(&["chekc"]).fails(2, &["check"]);
    scratch.run(&["render", "good.toml"]).fails(2, &["--output"]);
    scratch.run(&["render", "good.toml", "-o", "x.wav", "--rate", "100"]).fails(2, &["6000"]);
    scratch.run(&["render", "good.toml", "-o", "x.wav", "--format", "mp3"]).fails(2, &["i24"]);
    scratch
        .run(&["render", "good.toml", "-o", "x.wav", "--pattern", "wlak"])
        .fails(2, &["did you mean `walk`?"]);
    scratch.run(&["render", "good.toml", "-o", "-"]).fails(2, &["name a file"]);
    scratch.run(&["render", "good.toml", "-o", "good.toml"]).fails(2, &["`good.toml`"]);
    assert_eq!(std::fs::read_to_string(scratch.0.join("good.toml")).unwrap(), GOOD);
    scratch.run(&["render", "good.toml", "-o", "."]).fails(73, &["is a folder"]);
    scratch.run(&["render", "good.toml", "-o", "no/where.wav"]).fails(73, &["folder is not there"]);
    assert!(scratch.run(&["--version"]).succeeds().out.contains(env!("CARGO_PKG_VERSION")));
    for command in ["demo", "check", "render", "plot", "error", "nodes", "schema"] {
        let help = scratch.run(&[command, "--help"]);
        assert!(help.succeeds().out.contains(&format!("Example:\n  pacinian {command}")), "{command}");
    }
}

#[test]
fn nodes_and_schemas_are_explained() {
    let scratch = Scratch::new("nodes");
    let list = scratch.run(&["nodes"]);
    list.succeeds();
    for spec in pacinian::node::REGISTRY {
        assert!(list.out.contains(spec.summary), "{}", spec.name);
        let one = scratch.run(&["nodes", spec.name]);
        for param in spec.params {
            assert!(
                one.out.contains(param.name) && one.out.contains(param.doc),
                "{} {}",
                spec.name,
                param.name
            );
        }
        assert!(one.succeeds().out.contains(spec.example.lines().next().unwrap()));
    }
    let all = scratch.run(&["nodes", "--json"]).json();
    assert_eq!(all.as_array().unwrap().len(), pacinian::node::REGISTRY.len());
    scratch.run(&["nodes", "sien"]).fails(2, &["did you mean `sine`?"]);
    assert_eq!(scratch.run(&["schema", "patch"]).succeeds().json(), pacinian::patch::schema());
    assert_eq!(scratch.run(&["schema", "rig"]).succeeds().json(), pacinian::rig::schema());
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told_and_so_is_a_full_pipe() {
    use std::fs::File;
    use std::process::Stdio;
    let scratch = Scratch::new("full");
    scratch.run(&["render", "good.toml", "-o", "/dev/full"]).fails(74, &["no room left for `/dev/full`"]);
    let full = File::options().write(true).open("/dev/full").unwrap();
    let run = scratch.command(&["nodes"]).stdout(full).stderr(Stdio::piped()).output().unwrap();
    Run::of(run).fails(74, &["standard output"]);
    // A reader that goes away is no reason to complain.
    let mut child =
        scratch.command(&["schema", "patch"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    drop(child.stdout.take());
    let run = Run::of(child.wait_with_output().unwrap());
    assert_eq!((run.code, run.err.as_str()), (Some(0), ""));
}

#[cfg(unix)]
#[test]
fn what_is_stopped_or_killed_leaves_a_file_that_plays() {
    use std::os::unix::process::ExitStatusExt;
    use std::process::Stdio;
    let scratch = Scratch::new("stop");
    scratch.write(
        "e.toml",
        with("[pattern.p]\nevents = [{ at = 0, voice = \"beat\" }]\nrepeat = { every = 0.5 }\n"),
    );
    for (signal, code) in [("INT", Some(130)), ("TERM", Some(143)), ("KILL", None)] {
        let file = format!("{signal}.wav");
        let path = scratch.0.join(&file);
        let mut child = scratch
            .command(&["render", "e.toml", "-o", &file, "--duration", "1000"])
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        // Until some seconds are there.
        while std::fs::metadata(&path).map_or(0, |m| m.len()) < 8 << 20 {
            assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        let id = child.id().to_string();
        assert!(Command::new("kill").args([&format!("-{signal}"), &id]).status().unwrap().success());
        let output = child.wait_with_output().unwrap();
        if code.is_none() {
            assert_eq!(output.status.signal(), Some(9));
        }
        let run = Run::of(output);
        assert_eq!(run.code, code, "{}", run.err);
        let (_, samples) = read_wav(&path);
        let length = std::fs::metadata(&path).unwrap().len() as usize;
        assert!(samples.len() * 4 > 4 << 20, "{signal}: {}", samples.len());
        assert!(samples.iter().any(|x| x.abs() > 0.1));
        if code.is_some() {
            assert!(run.err.contains("stopped") && run.err.contains(&file), "{}", run.err);
            assert!(run.out.contains("started"), "the summary is still given");
            assert!(length - samples.len() * 4 < 4096, "all of it is in the header");
        }
        std::fs::remove_file(&path).unwrap();
    }
}

#[test]
fn the_demo_needs_nothing_and_is_exact() {
    let scratch = Scratch::new("demo");
    let run = scratch.run(&["demo", "-o", "new/folder", "--json"]);
    let answer = run.succeeds().json();
    let (spec, samples) = scratch.wav("new/folder/pacinian-demo.wav");
    assert_eq!(spec.channels, 16);
    assert_eq!(samples.len() as u64 / 16, answer["frames"].as_u64().unwrap());
    let svg = std::fs::read_to_string(scratch.0.join("new/folder/pacinian-demo.svg")).unwrap();
    assert!(svg.contains("<svg") && svg.contains(">r4c4<"));
    assert!(answer["peaks"].as_array().unwrap().iter().all(|p| p["peak"].as_f64().unwrap() > 0.1));
    assert!(answer["error_db"].as_f64().unwrap() < -80.0, "{}", answer["error_db"]);
    assert!(answer["above_db"].as_f64().unwrap() < -60.0, "{}", answer["above_db"]);
    assert_eq!((&answer["limited"], &answer["voices_stolen"]), (&0.into(), &0.into()));
    scratch.run(&["demo", "-o", "good.toml"]).fails(73, &["good.toml"]);
}

const LISTENER: &str = "[shared.nodes]\near = { type = \"input\", channel = 2 }\n\
    [voice.v]\nstart = \"always\"\noutput = \"o\"\nplace = 3\n[voice.v.nodes]\non = { type = \"gate\" }\n\
    o = { type = \"multiply\", inputs = [\"ear\", \"on\"] }\n";

impl Scratch {
    /// A second of silence on channel 1 and of 100 Hz on channel 2, or channel 1 alone.
    fn sound(&self, name: &str, rate: u32, channels: u16) {
        let spec = hound::WavSpec {
            channels,
            sample_rate: rate,
            bits_per_sample: 16,
            sample_format: hound::SampleFormat::Int,
        };
        let mut wav = hound::WavWriter::create(self.0.join(name), spec).unwrap();
        for n in 0..rate {
            let tone = (std::f64::consts::TAU * 100.0 * f64::from(n) / f64::from(rate)).sin();
            for x in [0.0, 0.5 * tone].iter().take(channels.into()) {
                wav.write_sample((x * 32_767.0) as i16).unwrap();
            }
        }
        wav.finalize().unwrap();
    }
}

#[test]
fn what_a_file_brings_in_is_felt() {
    let scratch = Scratch::new("input");
    scratch.write("l.toml", format!("{HEAD}{LISTENER}"));
    scratch.sound("in.wav", 22_050, 2);
    let render = ["render", "l.toml", "--input", "in.wav", "-o", "x.wav", "--json"];
    let summary = scratch.run(&render).succeeds().json();
    let (_, samples) = scratch.wav("x.wav");
    assert_eq!(samples.len(), 8 * 48_000, "as long as what is heard");
    let late = 1e-3 * summary["input"]["delay_ms"].as_f64().unwrap();
    let plan = scratch.run(&["check", "l.toml", "--input", "in.wav", "--json"]).succeeds().json();
    let delay = &plan["plan"]["delay_ms"];
    // The band limit delays a tone of 100 Hz by what it delays the envelope of one, within its passband.
    let stage = 1e-3 * (delay["up_sampling"].as_f64().unwrap() + delay["band_limit"].as_f64().unwrap());
    let (mut wrong, mut wanted) = (0.0, 0.0);
    for n in 12_000..36_000 {
        let exact = 0.5 * (std::f64::consts::TAU * 100.0 * (f64::from(n) / 48_000.0 - late - stage)).sin();
        wrong += (f64::from(samples[8 * n as usize + 2]) - exact).powi(2);
        wanted += exact * exact;
    }
    assert!(wrong < 0.01 * wanted, "{}", wrong / wanted);
    assert!(samples.iter().enumerate().all(|(i, x)| i % 8 == 2 || *x == 0.0));

    let plot = scratch.run(&["plot", "l.toml", "--input", "in.wav", "-o", "x.svg"]);
    assert!(plot.succeeds().out.contains("1.000 s"), "{}", plot.out);
    let longer = scratch.run(&["render", "l.toml", "--input", "in.wav", "-o", "x.wav", "--duration", "1.5"]);
    assert!(longer.succeeds().out.contains("channel 2 of in.wav"), "{}", longer.out);
    let (_, samples) = scratch.wav("x.wav");
    assert!(samples[8 * 50_000..].iter().all(|x| x.abs() < 1e-4), "silence after its end");
    // The reference hears it too: a tone that is only let through is exact to the rounding of 32 bits.
    let error = scratch.run(&[
        "error",
        "l.toml",
        "--input",
        "in.wav",
        "--duration",
        "1.2",
        "--compare-taps",
        "6,8",
        "--json",
    ]);
    for row in error.succeeds().json()["settings"].as_array().unwrap() {
        assert!(row["error_db"].as_f64().unwrap() < -90.0, "{row}");
    }
}

#[test]
fn what_cannot_be_heard_is_said() {
    let scratch = Scratch::new("unheard");
    scratch.write("l.toml", format!("{HEAD}{LISTENER}"));
    let run = scratch.run(&["check", "l.toml"]);
    assert!(run.succeeds().out.contains("channel 2: silence; --input FILE.wav"), "{}", run.out);
    scratch
        .run(&["render", "l.toml", "-o", "x.wav"])
        .fails(2, &["voice `v` is always on", "--input FILE.wav", "--duration 10,"]);

    scratch.sound("mono.wav", 8_000, 1);
    let run = scratch.run(&["check", "l.toml", "--input", "mono.wav"]);
    run.succeeds();
    for word in ["mono.wav: warning", "channel 2", "has 1 channel", "silence"] {
        assert!(run.err.contains(word), "{word}: {}", run.err);
    }
    assert!(run.out.contains("1 warning"), "{}", run.out);
    let run = scratch.run(&["render", "l.toml", "--input", "mono.wav", "-o", "x.wav"]);
    assert!(run.succeeds().out.contains("channel 2: silence"), "{}", run.out);
    assert!(scratch.wav("x.wav").1.iter().all(|x| *x == 0.0));
    let run = scratch.run(&["check", "good.toml", "--input", "mono.wav"]);
    assert!(run.succeeds().err.contains("nothing in this patch listens"), "{}", run.err);

    let with = |input: &str| scratch.run(&["render", "l.toml", "-o", "y.wav", "--input", input]);
    with("none.wav").fails(66, &["`none.wav` is not there", "check the path"]);
    with(".").fails(66, &["is a folder"]);
    with("good.toml").fails(65, &["`good.toml`", "no WAV file"]);
    scratch.sound("slow.wav", 500, 2);
    with("slow.wav").fails(65, &["`slow.wav`", "500 Hz", "convert it"]);
    assert!(!scratch.0.join("y.wav").exists());
    scratch
        .run(&["render", "l.toml", "-o", "mono.wav", "--input", "mono.wav"])
        .fails(2, &["`mono.wav` is read for this rendering"]);
    scratch.write("bad.toml", "format = \"pacinian-patch/1\"\ntitle = 3\n");
    scratch.run(&["check", "bad.toml", "--input", "none.wav"]).fails(65, &["bad.toml:2:"]);
}

#[test]
fn equalisers_are_shown() {
    let scratch = Scratch::new("equaliser");
    scratch.write(
        "rig.toml",
        "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\n[actuator.coil]\n\
         equaliser = [{ frequency = 200, gain_db = -6, q = 2 }]\n[[tactor]]\nname = \"a\"\nchannel = 1\n\
         [[tactor]]\nname = \"t2\"\nchannel = 2\nactuator = \"coil\"\n",
    );
    let run = scratch.run(&["check", "good.toml", "--rig", "rig.toml"]);
    assert!(run.succeeds().out.contains("equaliser -6 dB at 200 Hz (q 2)"), "{}", run.out);
    let plan = scratch.run(&["check", "good.toml", "--rig", "rig.toml", "--json"]).succeeds().json();
    let outputs = &plan["plan"]["outputs"];
    assert_eq!(outputs[0]["equaliser"].as_array().unwrap().len(), 0);
    assert_eq!(outputs[1]["equaliser"][0]["gain_db"], -6.0);
}

#[test]
fn pictures_and_errors() {
    let scratch = Scratch::new("plot");
    scratch.run(&["plot", "good.toml", "-o", "x.svg", "--duration", "0.5"]).succeeds();
    let svg = std::fs::read_to_string(scratch.0.join("x.svg")).unwrap();
    assert!(svg.contains("A test") && svg.contains(">t8<"));
    let out = scratch.run(&["plot", "good.toml", "-o", "-", "--duration", "0.5"]);
    assert_eq!(out.succeeds().out, svg);
    let map = ["plot", "good.toml", "--map", "-o", "map.svg", "--duration", "0.5"];
    assert!(scratch.run(&[&map[..], &["--frames", "7"]].concat()).succeeds().out.contains("8 tactors, 0.5"));
    let map_svg = || std::fs::read_to_string(scratch.0.join("map.svg")).unwrap();
    // A frame has a disc for each tactor, and one on top for each that shakes.
    assert!(map_svg().contains("7 frames") && map_svg().matches("<circle").count() > 56);
    scratch.run(&[&map[..], &["--animated"]].concat()).succeeds();
    assert!(map_svg().contains("<animate attributeName=\"fill-opacity\""));
    scratch.run(&[&map[..], &["--animated", "--frames", "7"]].concat()).fails(2, &["--frames"]);
    scratch.run(&[&map[..], &["--frames", "0"]].concat()).fails(2, &["1..=400"]);
    scratch.run(&["plot", "good.toml", "--animated", "-o", "x.svg"]).fails(2, &["--map"]);
    let bare = "format = \"pacinian-rig/1\"\ntitle = \"r\"\n[device]\nchannels = 8\n";
    let tactors: String = (1..=8).map(|n| format!("[[tactor]]\nname = \"t{n}\"\nchannel = {n}\n")).collect();
    scratch.write("bare.toml", format!("{bare}{tactors}"));
    scratch.run(&[&map[..], &["--rig", "bare.toml"]].concat()).fails(65, &["has a position", "--map"]);
    scratch.run(&["plot", "good.toml", "-o", "x.png"]).fails(2, &["SVG", "`x.svg`"]);
    scratch.run(&["plot", "good.toml", "-o", "good.toml"]).fails(2, &["`good.toml`"]);

    let csv = scratch.run(&["error", "good.toml", "--compare-taps", "4,8", "--csv"]);
    let lines: Vec<&str> = csv.succeeds().out.lines().collect();
    assert_eq!(lines.len(), 5, "{lines:?}");
    let of = |n: usize, cell: usize| lines[n].split(',').nth(cell).unwrap().parse::<f64>().unwrap();
    assert!((1..5).all(|n| of(n, 2) < -80.0), "{lines:?}");
    assert!(of(2, 3) < of(1, 3) - 10.0, "8 taps leave less above 1 kHz than 4: {lines:?}");
    // The picture has a line for each column of each number type, and a label for each setting.
    let drawn = scratch.run(&["error", "good.toml", "--compare-taps", "4,8", "-o", "trade.svg", "--csv"]);
    assert_eq!(drawn.succeeds().out.lines().count(), 5);
    let svg = std::fs::read_to_string(scratch.0.join("trade.svg")).unwrap();
    for (label, times) in [
        (">4 taps<", 2),
        (">8 taps<", 2),
        (">f32: error to 1 kHz<", 1),
        (">f64: above 1 kHz<", 1),
        ("error against run time", 2),
    ] {
        assert_eq!(svg.matches(label).count(), times, "{label}");
    }
    scratch.run(&["error", "good.toml", "-o", "good.toml"]).fails(2, &["`good.toml`"]);
    let json = scratch.run(&["error", "good.toml", "--only", "--json"]).succeeds().json();
    assert_eq!(json["settings"].as_array().unwrap().len(), 1);
}

#[test]
fn error_shows_warnings() {
    let scratch = Scratch::new("error-warns");
    // Its node hides the control of that name.
    scratch.write(
        "warns.toml",
        "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[control.tone]\ndefault = 0.5\n[voice.a]\noutput = \"tone\"\n\
         [voice.a.nodes]\ntone = { type = \"sine\", frequency = 250 }\n[pattern.p]\nevents = [{ at = 0, voice = \"a\" }]\n",
    );
    let run = scratch.run(&["error", "warns.toml", "--only", "--duration", "0.1", "--json"]);
    assert_eq!(run.code, Some(0), "{}", run.err);
    assert!(run.err.contains("hides the control"), "{}", run.err);
}

#[test]
fn what_was_held_or_cut_is_in_the_summary() {
    let scratch = Scratch::new("held");
    let summary = scratch.run(&["render", "good.toml", "-o", "x.wav", "--json"]).succeeds().json();
    assert_eq!((&summary["held"], &summary["cut"]), (&Value::from(0), &Value::from(false)));
    let loud = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.a]\noutput = \"s\"\n[voice.a.nodes]\n\
         s = { type = \"sine\", frequency = 250, amplitude = 1e6 }\n\
         [pattern.p]\nevents = [{ at = 0, voice = \"a\", level = 100 }]\n";
    scratch.write("loud.toml", loud);
    let run = scratch.run(&["render", "loud.toml", "-o", "x.wav", "--json"]);
    assert!(run.succeeds().json()["held"].as_u64().is_some_and(|held| held > 0), "{}", run.out);
    let run = scratch.run(&["render", "loud.toml", "-o", "x.wav"]);
    assert!(run.succeeds().out.contains("held there"), "{}", run.out);
}

#[test]
fn help_and_readme_name_all_exit_codes() {
    let run = Scratch::new("codes").run(&["--help"]);
    let help = &run.succeeds().out;
    let readme = include_str!("../README.md");
    let table =
        readme.split("## Exit codes").nth(1).and_then(|t| t.split("\n## ").next()).unwrap_or_default();
    for code in [
        "0", "1", "2", "65", "66", "69", "70", "71", "73", "74", "75", "77", "78", "129", "130", "131", "143",
    ] {
        let words = |text: &str| text.split(|c: char| !c.is_ascii_digit()).any(|word| word == code);
        assert!(words(help) && words(table), "{code}");
    }
}

#[test]
fn a_song_goes_by_either_name() {
    let scratch = Scratch::new("midi-file");
    for command in ["play", "render"] {
        assert!(scratch.run(&[command, "--help"]).succeeds().out.contains("[alias: --midi-file]"));
    }
    scratch.run(&["render", "good.toml", "--midi-file", "none.mid", "-o", "x.wav"]).fails(66, &["none.mid"]);
}

#[test]
fn help_begins_with_what_a_newcomer_needs() {
    let run = Scratch::new("help").run(&["--help"]);
    for command in ["pacinian devices", "pacinian play PATCH", "plays them on a sound card"] {
        assert!(run.succeeds().out.contains(command), "no `{command}` in\n{}", run.out);
    }
}
