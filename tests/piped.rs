//! What a session says where nobody looks at a screen.
#![cfg(feature = "cli")]

mod program;

use program::Scratch;

/// A tone of an amplitude, to a power.
fn tone(amplitude: &str, power: usize) -> String {
    let inputs = vec!["\"t\""; power].join(", ");
    format!(
        "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\nstart = \"always\"\noutput = \"o\"\n[voice.v.nodes]\n\
         t = {{ type = \"sine\", frequency = 150, amplitude = {amplitude} }}\no = {{ type = \"multiply\", inputs = [{inputs}, 1] }}\n"
    )
}

#[test]
fn samples_that_could_not_leave_as_they_were_are_told() {
    let scratch = Scratch::new("piped-changed");
    let told = |amplitude: &str, power: usize| {
        scratch.write("p.toml", tone(amplitude, power));
        let run = scratch.run(&["play", "p.toml", "--device", "virtual", "--duration", "0.6"]);
        run.succeeds().out.clone()
    };
    let quiet = told("0.5", 1);
    assert!(quiet.contains(" frames, ") && !quiet.contains("of the samples"), "{quiet}");
    let loud = told("20", 1);
    assert!(loud.contains("turned down by the limiter"), "{loud}");
    // Past what a number of single precision can hold.
    let none = told("1e6", 7);
    assert!(none.contains("no numbers, played as 0"), "{none}");
}

/// Patterns that begin and end are told of, one line each, whoever starts them.
#[test]
fn patterns_that_begin_and_end_are_told() {
    let scratch = Scratch::new("piped-patterns");
    let patterns = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"o\"\n[voice.v.nodes]\n\
        o = { type = \"envelope\" }\n[pattern.short]\nevents = [{ at = 0, voice = \"v\", duration = 0.1 }]\n\
        [pattern.long]\nrepeat = { every = 0.1 }\nevents = [{ at = 0, voice = \"v\", duration = 0.05 }]\n";
    let start = |name: &str| format!("[[trigger]]\non = \"start\"\nplay = \"{name}\"\n");
    scratch.write("p.toml", [patterns, &start("short"), &start("long")].concat());
    let play = ["play", "p.toml", "--device", "virtual"];
    let run = scratch.run(&[&play[..], &["--duration", "1"]].concat());
    let told = |what: &str| run.succeeds().err.lines().filter(|line| line.ends_with(what)).count();
    for (what, times) in [
        ("pattern short begins", 1),
        ("pattern short is over", 1),
        ("pattern long begins", 1),
        ("pattern long is over", 0),
    ] {
        assert_eq!(told(what), times, "{what}: {}", run.err);
    }
    // With the ramp, as their voices do, and before those.
    let (begins, plays) = (run.err.find("pattern short begins").unwrap(), run.err.find("v on t1").unwrap());
    assert!(begins < plays && run.err.contains("0:00.200  pattern short begins"), "{}", run.err);
    // A node that sets one off says so itself.
    let taps = "[shared.nodes]\ntap = { type = \"lfo\", rate = 3 }\n[[trigger]]\non = \"node.tap rises 0.3\"\nplay = \"short\"\n";
    scratch.write("p.toml", format!("{patterns}{taps}"));
    let run = scratch.run(&["play", "p.toml", "--device", "virtual", "--duration", "1.5"]);
    let begins: Vec<&str> =
        run.succeeds().err.lines().filter(|line| line.contains("pattern short begins")).collect();
    assert!(
        begins.len() >= 2 && begins.iter().all(|line| line.ends_with("[node.tap rises 0.3]")),
        "{}",
        run.err
    );
}
