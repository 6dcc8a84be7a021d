//! Controls that the command line sets.
#![cfg(feature = "cli")]

mod program;

use program::{HEAD, Scratch};

/// A patch whose level follows `depth`; `idle` is read by nothing.
fn patch(depth: f64) -> String {
    format!(
        "{HEAD}[control.depth]\ndefault = {depth}\nrange = [0, 2]\n[control.idle]\ndefault = 0\n\
         [voice.v]\noutput = \"o\"\n[voice.v.nodes]\ns = {{ type = \"sine\", frequency = 200 }}\n\
         e = {{ type = \"envelope\" }}\no = {{ type = \"multiply\", inputs = [\"s\", \"e\", \"depth / 4\"] }}\n\
         [pattern.p]\nevents = [{{ at = 0, voice = \"v\", duration = 0.2 }}]\n"
    )
}

/// What is set sounds as if the patch said so, from the first sample on, and every command says what was set.
#[test]
fn a_control_that_is_set_is_as_if_the_patch_said_so() {
    let scratch = Scratch::new("set");
    scratch.write("one.toml", patch(1.0));
    scratch.write("two.toml", patch(1.5));
    let run = scratch.run(&["render", "one.toml", "--set", "depth=1.5", "-o", "set.wav"]);
    run.succeeds();
    assert!(run.out.lines().any(|l| l.contains("set") && l.ends_with("depth = 1.5")), "{}", run.out);
    scratch.run(&["render", "two.toml", "-o", "said.wav"]).succeeds();
    scratch.run(&["render", "one.toml", "-o", "other.wav"]).succeeds();
    let bits = |name: &str| scratch.wav(name).1;
    assert_eq!(bits("set.wav"), bits("said.wav"));
    assert_ne!(bits("set.wav"), bits("other.wav"));

    let set = serde_json::json!([{ "control": "depth", "value": 0.5 }]);
    let words = ["one.toml", "--set=depth=0.5", "--json"];
    for command in [&["render", "-o", "x.wav"][..], &["error", "--only"]] {
        let run = scratch.run(&[command, &words].concat());
        assert_eq!(run.succeeds().json()["set"], set);
    }
    let run = scratch.run(&["error", "one.toml", "--only", "--set", "depth=0.5"]);
    assert!(run.succeeds().out.contains("depth = 0.5"), "{}", run.out);
    let run = scratch.run(&["plot", "one.toml", "--set", "depth=0.5", "-o", "p.svg"]);
    assert!(run.succeeds().out.contains("depth = 0.5"), "{}", run.out);
    assert!(std::fs::read_to_string(scratch.0.join("p.svg")).unwrap().contains("depth = 0.5"));
}

#[test]
fn what_cannot_be_set_is_told() {
    let scratch = Scratch::new("unset");
    scratch.write("p.toml", patch(1.0));
    let check = |words: &[&str]| scratch.run(&[&["check", "p.toml"], words].concat());
    check(&["--set", "depht=1"]).fails(2, &["no control `depht`", "did you mean `depth`?"]);
    check(&["--set", "depth=3"]).fails(2, &["`depth` cannot be set to 3", "from 0 to 2", "--set depth=2"]);
    check(&["--set", "depth=1", "--set", "depth=2"]).fails(2, &["`depth` is set twice"]);
    check(&["--set", "depth"]).fails(2, &["strength=0.5"]);
    check(&["--set", "depth=nan"]).fails(2, &["no finite number"]);
    check(&["--set", "depth=1kHz"])
        .fails(2, &["`1kHz` is no finite number", "without a unit, such as depth=1000"]);
    scratch.run(&["check", "good.toml", "--set", "a=1"]).fails(2, &["no control `a`", "[control.NAME]"]);
    let run = check(&["--set", "idle=1"]);
    run.succeeds();
    assert!(run.err.contains("control `idle` is set, and nothing that plays reads it"), "{}", run.err);
    assert!(check(&["--set", "depth=1"]).err.is_empty());
}

/// How it comes to a value that is sent to it.
#[test]
fn a_control_says_how_it_moves() {
    let scratch = Scratch::new("moves");
    scratch.write("p.toml", patch(1.0).replace("[control.depth]", "[control.depth]\nstream = 0.03"));
    let told = scratch.run(&["check", "p.toml"]);
    let line = told.succeeds().out.lines().find(|l| l.trim_start().starts_with("depth")).unwrap_or_default();
    assert!(line.ends_with("a stream, 30 ms later"), "{}", told.out);
    let all = scratch.run(&["check", "p.toml", "--json"]).succeeds().json();
    assert_eq!(all["plan"]["controls"][0]["stream"], 0.03, "{all:#}");
    scratch.write("p.toml", patch(1.0).replace("[control.depth]", "[control.depth]\nsmoothing = 0.02"));
    let told = scratch.run(&["check", "p.toml"]).succeeds().out.clone();
    assert!(told.contains("within 20 ms"), "{told}");
}

/// The output comes in before patterns begin.
#[test]
fn a_session_that_is_too_short_to_play_anything_says_why() {
    let scratch = Scratch::new("short");
    scratch.write("p.toml", patch(1.0));
    let always =
        "[voice.w]\nstart = \"always\"\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = 100 }\n";
    scratch.write("always.toml", patch(1.0) + always);
    for (file, seconds, said) in
        [("p.toml", "0.1", true), ("p.toml", "0.3", false), ("always.toml", "0.1", false)]
    {
        let run = scratch.run(&["play", file, "--device", "virtual", "--duration", seconds]);
        let told = run.succeeds().out.contains("comes in within 0.2 s");
        assert_eq!(told, said, "{file}, {seconds} s: {}", run.out);
    }
}
