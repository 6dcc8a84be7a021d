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
