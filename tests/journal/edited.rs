use std::io::Cursor;

use pacinian::io::device::choose::Chosen;
use pacinian::io::journal::reader::Reader;
use pacinian::io::journal::remake::Recordings;
use pacinian::io::journal::replay::{Met, Replay};
use pacinian::io::journal::{Journal, Line};
use pacinian::io::session::{Beginning, Session};

use super::{PATCH, folder, reload, setting, until};

/// A journal of a moment, as text.
fn short(name: &str) -> String {
    let folder = folder(name);
    let path = folder.join("s.jsonl");
    // Without what a node sets off and what always sounds: those lines are told, and not played.
    let first = reload(PATCH.split("[[trigger]]\non = \"node").next().unwrap_or_default());
    let journal = Journal::create(&path, setting(), &first.scene.plan, first.provenance.as_deref()).unwrap();
    let is_told = journal.clone();
    let mut session = Session::start(Beginning {
        block: Some(64),
        audience: Box::new(move |told| is_told.told(&told)),
        ..Beginning::of(first, Chosen::Virtual(None))
    })
    .unwrap();
    until(&session, 9_600);
    journal.clock(session.clock().moment());
    until(&session, 14_400);
    session.stop();
    journal.finish().unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    text.lines()
        .filter(|line| !line.contains("\"source\":\"always\""))
        .map(|line| line.to_string() + "\n")
        .collect()
}

/// What becomes of a journal: how it ends.
fn outcome(text: &str) -> Result<Met, String> {
    let reader = Reader::new(Cursor::new(text.as_bytes()), "s.jsonl");
    let mut replay = Replay::new(reader, Recordings::default()).map_err(|error| error.to_string())?;
    while replay.block().map_err(|error| error.to_string())?.is_some() {}
    Ok(replay.met())
}

#[test]
fn what_is_no_journal_any_more_is_refused_at_its_line() {
    let text = short("edited");
    let whole = outcome(&text).unwrap();
    assert!(whole.ended && whole.frames >= 9_600 && whole.events > 2, "{whole:?}");
    let refused = |text: &str, says: &str| match outcome(text) {
        Err(error) => assert!(error.contains(says), "`{error}` does not say `{says}`"),
        Ok(met) => panic!("it was played: {met:?}"),
    };
    let edited = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    };
    refused("", "empty");
    refused("kind,frame\nend,3\n", "1: this is no journal");
    refused("{\"kind\":\"end\",\"frame\":3}\n", "1: this is no journal");
    refused(&edited("pacinian-journal/1", "pacinian-journal/2"), "reads `pacinian-journal/1`");
    refused(&edited("\"plan\":0", "\"plan\":-1"), "s.jsonl:2:");
    refused(&edited("frequency = 100", "frequency = 101"), "does not have the SHA-256 beside it");
    refused(&edited("\"channels\":3", "\"channels\":4"), "the session had 4 channels");
    refused(&edited("\"name\":\"tap\"", "\"name\":\"nap\""), "no voice called `nap`");
    refused(&edited("\"place\":\"t", "\"place\":\"q"), "there is no output `q");
    refused(&edited("\"fraction\":0.", "\"fraction\":7."), "from 0 to below 1");
    refused(&edited("\"source\":\"pattern\"", "\"source\":\"nobody\""), "not from `nobody`");
    refused(&edited("\"kind\":\"end\",", "\"kind\":\"swap\","), "no plan was written down");
    let last = text.lines().count() + 1;
    let beyond = format!("{text}{}\n", text.lines().nth(3).unwrap());
    refused(&beyond, &format!("s.jsonl:{last}: something follows the end"));
    // Each in one short sentence that says what to do, whatever stands there.
    let voice = text.lines().find(|line| line.contains("\"voice\"")).unwrap();
    for (from, to) in [
        ("\"level\":", "\"level\":1e300,\"x\":"),
        ("\"duration\":", "\"duration\":-1e300,\"x\":"),
        ("\"fields\":{", "\"fields\":{\"bogus\":1,"),
        ("\"frame\":", &format!("\"frame\":{}", "9".repeat(100_000))),
        ("\"frame\":", "\"frame\":-"),
        ("\"source\":\"", &format!("\"source\":\"{}", "x".repeat(100_000))),
        ("\"name\":\"", &format!("\"name\":\"{}", "y".repeat(100_000))),
        ("\"kind\":\"voice", "\"kind\":\"voise"),
        ("}", ""),
    ] {
        assert!(voice.contains(from), "{from}");
        let error = outcome(&text.replacen(voice, &voice.replacen(from, to, 1), 1)).unwrap_err();
        assert!(
            error.starts_with("s.jsonl:") && error.ends_with("play the journal as it was written"),
            "{error}"
        );
        assert!(error.len() < 500 && !error.contains(['\n', '\r']) && !error.contains("line 1"), "{error}");
    }
    let first = text.lines().position(|line| line.contains("\"voice\"")).unwrap();
    let mut lines: Vec<&str> = text.lines().collect();
    let line = lines.remove(first);
    lines.insert(lines.len() - 1, line);
    refused(&(lines.join("\n") + "\n"), "has passed");
    // Without its end it is played as far as it goes, be it within a line.
    let half = &text[..text.len() - 40];
    let met = outcome(half).unwrap();
    assert!(!met.ended && met.frames <= whole.frames, "{met:?}");
    // What the writer could not keep up with is known.
    let met =
        outcome(&edited("{\"kind\":\"end\"", "{\"kind\":\"lost\",\"value\":3}\n{\"kind\":\"end\"")).unwrap();
    assert_eq!(met.lost, 3);
}

#[test]
fn a_journal_that_breaks_off_is_played_up_to_the_last_that_it_tells_of() {
    let text = short("broken");
    let clock = text.lines().position(|line| line.contains("\"clock\"")).unwrap();
    let until: Vec<&str> = text.lines().take(clock + 1).collect();
    let Line { frame, .. } = serde_json::from_str(until[clock]).unwrap();
    let met = outcome(&(until.join("\n") + "\n")).unwrap();
    assert!(!met.ended && met.frames == frame.unwrap() && met.frames > 4_800, "{met:?} {frame:?}");
    // What is noticed beside the callback says nothing of what that had done by then.
    let gap = format!("{{\"kind\":\"xrun\",\"frame\":{},\"value\":1}}\n", met.frames + 700);
    assert_eq!(outcome(&(until.join("\n") + "\n" + &gap)).unwrap().frames, met.frames);
    // A voice that is there from the beginning sounds all that time.
    let reader = Reader::new(Cursor::new(until.join("\n") + "\n"), "s.jsonl");
    let mut replay = Replay::new(reader, Recordings::default()).unwrap();
    let mut loud = 0;
    while let Some(frames) = replay.block().unwrap() {
        loud += frames.iter().filter(|x| x.abs() > 0.01).count();
    }
    assert!(loud > 1000, "{loud}");
    // Nothing comes behind the end, however often one asks.
    assert!(replay.block().unwrap().is_none() && replay.met().frames == met.frames);
}

#[test]
fn a_journal_cannot_ask_for_more_than_a_session_has() {
    let text = short("greedy");
    let refused = |text: &str, says: &str| match outcome(text) {
        Err(error) => assert!(error.contains(says), "`{error}` does not say `{says}`"),
        Ok(met) => panic!("it was played: {met:?}"),
    };
    let with = |line: &str| {
        let end = text.find("{\"kind\":\"end\"").unwrap();
        format!("{}{line}{}", &text[..end], &text[end..])
    };
    refused(&with("{\"kind\":\"end\",\"frame\":18446744073709551615}\n"), "hours after all");
    refused(&with("{\"kind\":\"clock\",\"frame\":9000000000}\n"), "52.1 hours after all");
    refused(&text.replacen("\"gain\":1.0", "\"gain\":1e30", 1), "from 0 to 1, not 1e30;");
    refused(&text.replacen("\"gain\":1.0", "\"gain\":-1.0", 1), "from 0 to 1, not -1");
    let plan = text.lines().nth(1).unwrap();
    refused(&with(&format!("{plan}\n").repeat(100)), "plans wait here");
    let lost = "{\"kind\":\"lost\",\"value\":1e300}\n";
    assert_eq!(outcome(&with(&lost.repeat(3))).unwrap().lost, u64::MAX);
}

#[test]
fn bytes_of_any_kind_are_no_reason_to_panic() {
    let text = short("hostile");
    let mut state = 1_u64;
    for _ in 0..300 {
        let mut bytes = text.clone().into_bytes();
        for _ in 0..3 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let at = (state >> 33) as usize % bytes.len();
            bytes[at] = (state >> 20) as u8;
        }
        let mut reader = Reader::new(Cursor::new(&bytes), "s");
        while let Ok(Some(_)) = reader.read() {}
        // What can still be played is played, a second of it at most.
        if let Ok(mut replay) = Replay::new(Reader::new(Cursor::new(&bytes), "s"), Recordings::default()) {
            while replay.met().frames < 48_000 && matches!(replay.block(), Ok(Some(_))) {}
        }
    }
}
