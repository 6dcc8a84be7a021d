//! What a session says where nobody looks at a screen.
#![cfg(feature = "cli")]

mod program;

use program::Scratch;

/// A tone that is as loud as this, and twice in its place.
fn tone(amplitude: &str) -> String {
    format!(
        "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[control.zero]\ndefault = 0\nrange = [0, 1]\n[voice.v]\nstart = \"always\"\noutput = \"o\"\n\
         [voice.v.nodes]\no = {{ type = \"sine\", frequency = 150, amplitude = \"{amplitude}\" }}\n"
    )
}

#[test]
fn samples_that_could_not_leave_as_they_were_are_told() {
    let scratch = Scratch::new("piped-changed");
    let told = |amplitude: &str| {
        scratch.write("p.toml", tone(amplitude));
        let run = scratch.run(&["play", "p.toml", "--device", "virtual", "--duration", "0.6"]);
        run.succeeds().out.clone()
    };
    let quiet = told("0.5");
    assert!(quiet.contains(" frames, ") && !quiet.contains("of the samples"), "{quiet}");
    let loud = told("20");
    assert!(loud.contains("turned down by the limiter"), "{loud}");
    let none = told("0.5 * log(zero - 1)");
    assert!(none.contains("no numbers, played as 0"), "{none}");
}
