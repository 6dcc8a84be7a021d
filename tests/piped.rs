//! What a session says where nobody looks at a screen.
#![cfg(feature = "cli")]

mod program;

use program::Scratch;

/// A tone of an amplitude, times a number.
fn tone(amplitude: &str, times: &str) -> String {
    format!(
        "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[control.zero]\ndefault = 0\nrange = [-1, 1]\n[voice.v]\nstart = \"always\"\noutput = \"o\"\n\
         [voice.v.nodes]\nt = {{ type = \"sine\", frequency = 150, amplitude = \"{amplitude}\" }}\no = {{ type = \"multiply\", inputs = [\"t\", \"{times}\"] }}\n"
    )
}

#[test]
fn samples_that_could_not_leave_as_they_were_are_told() {
    let scratch = Scratch::new("piped-changed");
    let told = |amplitude: &str, times: &str| {
        scratch.write("p.toml", tone(amplitude, times));
        let run = scratch.run(&["play", "p.toml", "--device", "virtual", "--duration", "0.6"]);
        run.succeeds().out.clone()
    };
    let quiet = told("0.5", "1");
    assert!(quiet.contains(" frames, ") && !quiet.contains("of the samples"), "{quiet}");
    let loud = told("20", "1");
    assert!(loud.contains("turned down by the limiter"), "{loud}");
    let none = told("0.3 / zero", "zero");
    assert!(none.contains("no numbers, played as 0"), "{none}");
}
