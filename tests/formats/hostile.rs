//! Nothing that a file holds makes the reader panic, overflow its stack or take for ever.

use std::fmt::Write;

use pacinian::patch::{EventsFile, Patch};
use pacinian::rig::Rig;
use proptest::prelude::{Just, ProptestConfig, Strategy, any, prop, prop_oneof, proptest};

const HEAD: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n";

#[test]
fn what_is_no_text_is_refused() {
    let what = |bytes: &[u8]| Patch::parse("x.toml", bytes).unwrap_err().to_string();
    assert_eq!(what(b""), "x.toml: error: the file is empty");
    assert!(what(b"title = \"\xff\"").contains("byte 9, in line 1, is not UTF-8"));
    let mut large = HEAD.as_bytes().to_vec();
    large.resize((16 << 20) + 1, b' ');
    assert!(what(&large).contains("the most is 16 MiB"));
    large.pop();
    assert!(Patch::parse("x.toml", &large).is_ok(), "16 MiB are not too much");
    assert!(Rig::parse("x.toml", b"").is_err());
}

#[test]
fn deep_nesting_is_refused() {
    for deep in ["[".repeat(10_000), "{ a = ".repeat(10_000), format!("{}b = 1", "a.".repeat(10_000))] {
        let problems = Patch::parse("x.toml", format!("{HEAD}x = {deep}").as_bytes()).unwrap_err();
        assert!(problems.to_string().contains("x.toml:3:"), "{problems}");
    }
    let header = format!("{HEAD}[{}b]\nc = 1", "a.".repeat(10_000));
    assert!(Patch::parse("x.toml", header.as_bytes()).is_err());
    let headers: String = (0..10_000).map(|_| "[[a]]\n").collect();
    assert!(Patch::parse("x.toml", format!("{HEAD}{headers}").as_bytes()).is_err());
    let descent: String = (1..80).map(|n| format!("[[{}a]]\n", "a.".repeat(n))).collect();
    assert!(Patch::parse("x.toml", format!("{HEAD}[[a]]\n{descent}").as_bytes()).is_err());
}

/// On a thread whose stack would not bear a call for each node.
#[test]
fn a_chain_of_200_000_nodes_is_checked_without_recursion() {
    fn chain(closed: bool) -> String {
        let mut source = format!("{HEAD}[voice.v]\noutput = \"n199999\"\n[voice.v.nodes]\n");
        for i in 0..200_000 {
            match i {
                0 if closed => source.push_str("n0={type=\"sine\",frequency=\"n199999\"}\n"),
                0 => source.push_str("n0={type=\"sine\",frequency=9}\n"),
                _ => writeln!(source, "n{i}={{type=\"sine\",frequency=\"n{}\"}}", i - 1).unwrap(),
            }
        }
        source
    }
    let run = || {
        let patch =
            Patch::parse("chain.toml", chain(false).as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        assert_eq!(patch.voices[0].nodes.len(), 200_000);
        let problems = Patch::parse("chain.toml", chain(true).as_bytes()).unwrap_err();
        assert!(problems.list[0].what.contains("in a circle"), "{problems}");
    };
    std::thread::Builder::new().stack_size(512 << 10).spawn(run).unwrap().join().unwrap();
}

/// Each of 200,000 lines is wrong: only so many are told, the rest counted, and no line is compared with every name.
#[test]
fn mistakes_without_number_are_counted() {
    let mut source = format!("{HEAD}[voice.v]\noutput = \"n0\"\n[voice.v.nodes]\n");
    for i in 0..100_000 {
        writeln!(source, "n{i}={{type=\"sine\",frequency=\"m{i}\"}}").unwrap();
    }
    let problems = Patch::parse("many.toml", source.as_bytes()).unwrap_err();
    assert_eq!(problems.list.len(), 501);
    assert_eq!(problems.list[500].what, "and 99500 more problems");
}

/// Characters and words of which a file may be made.
fn scraps() -> impl Strategy<Value = String> {
    let words = prop_oneof![
        Just("["),
        Just("]"),
        Just("[["),
        Just("]]"),
        Just("{"),
        Just("}"),
        Just("="),
        Just(","),
        Just("."),
        Just("\""),
        Just("'"),
        Just("\"\"\""),
        Just("\n"),
        Just("#"),
        Just("\\"),
        Just("nan"),
        Just("inf"),
        Just("-1"),
        Just("0"),
        Just("1e999"),
        Just("true"),
        Just("voice"),
        Just("pattern"),
        Just("at"),
        Just("event."),
        Just("999999999999999999999"),
        Just("µ"),
        Just("\u{0}"),
        Just("(((("),
        Just("type"),
        Just("nodes"),
        Just("1979-05-27"),
        Just("[]"),
        Just("{}"),
        Just("0x"),
        Just("place"),
        Just("choose"),
    ];
    prop_oneof![4 => words.prop_map(str::to_string), 1 => ".{0,4}"]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_bytes_never_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let _ = Patch::parse("x", &bytes).map_err(|p| p.to_string());
        let _ = Rig::parse("x", &bytes).map_err(|p| p.to_string());
        if let Ok(file) = EventsFile::new("x", bytes.as_slice(), None) {
            assert!(file.count() <= bytes.len());
        }
    }

    #[test]
    fn arbitrary_scraps_never_panic(scraps in prop::collection::vec(scraps(), 0..60)) {
        let text = format!("{HEAD}{}", scraps.concat());
        let _ = Patch::parse("x", text.as_bytes()).map_err(|p| p.to_string());
    }

    #[test]
    fn mutated_files_never_panic(cuts in prop::collection::vec((any::<prop::sample::Index>(), 0..12usize, scraps()), 1..6)) {
        for (full, is_patch) in [(super::patch::FULL, true), (super::rig::FULL, false)] {
            let mut text: Vec<char> = full.chars().collect();
            for (at, length, scrap) in &cuts {
                let at = at.index(text.len());
                let end = (at + length).min(text.len());
                text.splice(at..end, scrap.chars());
            }
            let text: String = text.into_iter().collect();
            let error = if is_patch {
                Patch::parse("x", text.as_bytes()).map(|_| ()).map_err(|p| p.to_string())
            } else {
                Rig::parse("x", text.as_bytes()).map(|_| ()).map_err(|p| p.to_string())
            };
            assert_ne!(error, Err(String::new()), "a refusal says why");
        }
    }

    #[test]
    fn events_files_never_panic(lines in prop::collection::vec("[0-9a-z\"., -]{0,30}", 0..8)) {
        let text = format!("at,voice,level,place\n0,a,1,b\n{}", lines.join("\n"));
        let file = EventsFile::new("x", text.as_bytes(), None).unwrap();
        for event in file.flatten() {
            assert!(event.at.is_finite() && event.at >= 0.0);
        }
    }
}
