//! Patches that come through standard input.
#![cfg(all(feature = "cli", unix))]

mod program;

use pacinian::io::wav::{Encoding, WavSpec, WavWriter};
use program::{GOOD, HEAD, Run, Scratch, with};
use std::io::{ErrorKind, Write};
use std::process::Stdio;

/// Runs the program with `text` in a pipe.
fn piped(scratch: &Scratch, arguments: &[&str], text: &[u8]) -> Run {
    let mut command = scratch.command(arguments);
    let mut child =
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut pipe = child.stdin.take().unwrap();
    // It may have had enough.
    let written = pipe.write_all(text);
    assert!(written.is_ok() || written.is_err_and(|e| e.kind() == ErrorKind::BrokenPipe));
    drop(pipe);
    Run::of(child.wait_with_output().unwrap())
}

#[test]
fn a_patch_may_come_through_a_pipe() {
    let scratch = Scratch::new("stream");
    scratch.run(&["render", "good.toml", "-o", "file.wav"]).succeeds();
    for name in ["-", "/dev/stdin", "/dev/fd/0"] {
        piped(&scratch, &["render", name, "-o", "pipe.wav"], GOOD.as_bytes()).succeeds();
        assert_eq!(scratch.wav("pipe.wav"), scratch.wav("file.wav"), "{name}");
        let run = piped(&scratch, &["check", name], GOOD.as_bytes());
        assert!(run.succeeds().out.contains("nothing is wrong"), "{}", run.out);
    }
    let bad = with("[pattern.p]\nevents = [{ at = 0, voice = \"baet\" }]\n");
    piped(&scratch, &["check", "-"], bad.as_bytes()).fails(65, &["stdin:10:", "did you mean `beat`?"]);
    piped(&scratch, &["check", "-"], b"").fails(65, &["empty"]);
    let rig = b"format = \"pacinian-rig/1\"\n[device]\nchannels = 3\n";
    let run = piped(&scratch, &["check", "good.toml", "--rig", "-", "--json"], rig);
    assert!(run.succeeds().json()["ok"] == true, "{}", run.out);
    piped(&scratch, &["check", "-", "--rig", "-"], rig).fails(2, &["cannot both come from standard input"]);
}

#[test]
fn a_pipe_without_end_is_read_no_further_than_a_file() {
    let scratch = Scratch::new("flood");
    let mut flood = GOOD.as_bytes().to_vec();
    flood.resize(20 << 20, b'#');
    for name in ["-", "/dev/stdin"] {
        piped(&scratch, &["check", name], &flood).fails(65, &["16777216"]);
    }
}

/// Paths of a patch without a folder count from the current one, and may not leave it either.
#[test]
fn recordings_of_a_piped_patch_lie_in_the_current_folder() {
    let scratch = Scratch::new("beside");
    let mut wav =
        WavWriter::create(scratch.0.join("tone.wav"), WavSpec::new(1, 8_000, Encoding::F32)).unwrap();
    wav.write(&[0.25; 800]).unwrap();
    wav.finish().unwrap();
    let of = |file: &str| {
        format!(
            "{HEAD}[voice.v]\noutput = \"s\"\nnodes.s = {{ type = \"sample\", file = \"{file}\" }}\n\
             [pattern.p]\nevents = [{{ at = 0, voice = \"v\" }}]\n"
        )
    };
    for name in ["-", "/dev/stdin"] {
        piped(&scratch, &["render", name, "-o", "x.wav"], of("tone.wav").as_bytes()).succeeds();
        assert!(scratch.wav("x.wav").1.iter().any(|x| *x > 0.01));
        piped(&scratch, &["check", name], of("../tone.wav").as_bytes()).fails(65, &["--allow-outside"]);
    }
}
