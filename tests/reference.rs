//! The reference for people: `docs/*.md` are what the program makes (`UPDATE_DOCS=1 cargo test --test reference` writes them),
//! and whatever it gives as an example is read without a complaint.
#![cfg(all(feature = "cli", feature = "fundsp-nodes"))]

use pacinian::node::REGISTRY;
use pacinian::node::spec::Kind;
use pacinian::patch::{self, Patch};
use pacinian::rig::{self, Rig};
use std::path::Path;
use std::process::{Command, Output};

fn pacinian(words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pacinian")).args(words).output().unwrap()
}

fn said(words: &[&str]) -> String {
    let output = pacinian(words);
    assert!(output.status.success(), "{words:?}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_pages_are_those_that_the_program_makes() {
    for name in ["patch", "rig", "nodes", "felt"] {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("docs/{name}.md"));
        let made = said(&["format", "--markdown", name]);
        if std::env::var_os("UPDATE_DOCS").is_some_and(|v| v == "1") {
            std::fs::write(&path, &made).unwrap();
        }
        let kept = std::fs::read_to_string(&path).unwrap_or_default();
        assert!(kept == made, "docs/{name}.md is out of date: UPDATE_DOCS=1 cargo test --test reference");
    }
}

const TAP: &str =
    "[voice.tap]\noutput = \"felt\"\nnodes.felt = { type = \"sine\", frequency = \"event.frequency\" }\n";

/// That a text is read without a problem or a warning.
#[track_caller]
fn reads(what: &str, text: &str, is_rig: bool) {
    let warnings = if is_rig {
        Rig::parse(what, text.as_bytes()).map(|checked| checked.warnings)
    } else {
        Patch::parse(what, text.as_bytes()).map(|checked| checked.warnings)
    };
    let warnings = warnings.unwrap_or_else(|problems| panic!("{text}\n{problems}"));
    assert!(warnings.list.is_empty(), "{text}\n{warnings}");
}

#[test]
fn every_example_of_a_topic_is_read() {
    for topic in patch::reference::TOPICS {
        let mut text = topic.example.to_string();
        if !text.contains("format =") {
            let tap = if text.contains("[voice.tap]") { "" } else { TAP };
            text = format!("format = \"pacinian-patch/1\"\ntitle = \"T\"\n{tap}{text}\n");
        }
        reads(topic.name, &text, false);
    }
    for topic in rig::reference::TOPICS {
        let mut text = topic.example.to_string();
        if !text.contains("format =") {
            text = format!(
                "format = \"pacinian-rig/1\"\n{}{text}\n",
                if text.contains("[device]") { "" } else { "[device]\nchannels = 8\n" }
            );
        }
        reads(topic.name, &text, true);
    }
}

/// Whatever an example names is made a control or a field of the event.
#[test]
fn every_example_of_a_node_is_read() {
    for spec in REGISTRY {
        let entry = spec.example.trim();
        let name = entry.split_whitespace().next().unwrap();
        let mut text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.v]\noutput = \"{name}\"\ndefaults = {{ speed = 1 }}\n\
             [voice.v.nodes]\n{entry}\n"
        );
        for other in entry.split('"').filter(|word| {
            spec.params.iter().all(|p| !matches!(p.kind, Kind::Choice(words, _) if words.contains(word)))
        }) {
            for word in other.split(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != '.') {
                let is_name = word.starts_with(|c: char| c.is_ascii_alphabetic()) && !word.contains('.');
                let quoted = entry.contains(&format!("\"{other}\""));
                if is_name && quoted && word != spec.name && !text.contains(&format!("[control.{word}]")) {
                    text += &format!("[control.{word}]\ndefault = 0.5\n");
                }
            }
        }
        reads(spec.name, &text, false);
    }
}

#[test]
fn who_asks_the_wrong_page_is_sent_to_the_right_one() {
    let cases: [(&[&str], &str); 7] = [
        (&["nodes", "event"], "pacinian format event"),
        (&["nodes", "sinus"], "did you mean `sine`?"),
        (&["format", "sine"], "pacinian nodes sine"),
        (&["format", "evnt"], "did you mean `event`?"),
        (&["format", "midi"], "pacinian format bind"),
        (&["format", "osc"], "docs/osc.md"),
        (&["play", "patches/01-hello.toml", "--device", "virtal"], "did you mean `virtual`?"),
    ];
    for (words, wanted) in cases {
        let output = pacinian(words);
        let told = String::from_utf8(output.stderr).unwrap();
        let code = if words[0] == "play" { 69 } else { 2 };
        assert_eq!(output.status.code(), Some(code), "{told}");
        assert!(told.contains(wanted), "{told}");
    }
    let list = said(&["format"]);
    for topic in patch::reference::TOPICS.iter().chain(rig::reference::TOPICS) {
        assert!(list.contains(topic.name) && list.contains(topic.doc), "{}: {list}", topic.name);
        assert!(said(&["format", topic.name]).starts_with(topic.name), "{}", topic.name);
    }
    for (key, wanted) in [("shuffle", "pattern: "), ("weight", "event: "), ("jitter", "pattern: ")] {
        assert!(said(&["format", key]).starts_with(wanted), "{key}");
    }
    let event = said(&["format", "event"]);
    for wanted in ["level", "else 1.", "else 0.1 s", "frequency", "250", "delay", "shuffle", "weight"] {
        assert!(event.contains(wanted), "{wanted}: {event}");
    }
}
