//! MIDI through JACK where no server answers: it is said once, and the library says nothing on top.
#![cfg(all(feature = "cli", target_os = "linux"))]

mod program;

use program::Scratch;

#[test]
fn without_a_server_the_library_is_silent() {
    let scratch = Scratch::new("jack-missing");
    let patch = "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.hum]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = 100 }\n\
        [[trigger]]\non = \"midi.note\"\nplay = \"hum\"\n";
    scratch.write("p.toml", patch);
    // Long enough to look for ports several times.
    let mut command = scratch.command(&["play", "p.toml", "--device", "virtual", "--duration", "3.5"]);
    let nobody = format!("pacinian-nobody-{}", std::process::id());
    let output = command.env("JACK_DEFAULT_SERVER", nobody).output().unwrap();
    let run = program::Run::of(output);
    run.succeeds();
    let told = "no MIDI: no JACK server answers";
    assert_eq!(run.err.matches(told).count(), 1, "{}", run.err);
    for talk in ["server socket", "Jack", "cannot be started"] {
        assert!(!run.err.contains(talk), "{}", run.err);
    }
}
