//! What somebody meets on the first day: slips, words of other programs, files in the wrong place.
#![cfg(feature = "cli")]

mod program;

use program::{HEAD, Run, Scratch, VOICE, with};

/// The program on a patch; how many errors it tells of.
fn told(scratch: &Scratch, patch: &str, text: &str, words: &[&str]) -> usize {
    scratch.write(patch, text);
    let run = scratch.run(&["check", patch]);
    run.fails(65, words);
    run.err.matches(" error: ").count()
}

#[test]
fn an_event_tells_all_that_is_wrong_with_it() {
    let scratch = Scratch::new("event");
    let event = |event: &str| with(&format!("[pattern.p]\nevents = [{event}]\n"));
    let words =
        ["lacks `at`", "no voice `baet`", "did you mean `beat`?", "field `time`", "did you mean `at`?"];
    assert_eq!(told(&scratch, "a.toml", &event("{ time = 1, voice = \"baet\" }"), &words), 3);
    let words = ["no voice `gong`", "field `levl`", "did you mean `level`?"];
    assert_eq!(
        told(&scratch, "a.toml", &event("{ at = 0, voice = \"gong\", levl = 1, frequency = 90 }"), &words),
        2
    );
    let words = ["has no voice", "or choose = [", "has no key `levl`"];
    assert_eq!(told(&scratch, "a.toml", &event("{ at = 0, levl = 1 }"), &words), 2);
    let choice = "{ at = 0, choose = [{ voice = 3 }, { voice = \"baet\" }, { pattern = \"q\", gain = -1 }] }";
    assert_eq!(
        told(&scratch, "a.toml", &event(choice), &["`voice` of alternative 1", "`baet`", "`gain`", "`q`"]),
        4
    );
}

#[test]
fn a_trigger_or_a_binding_tells_all_that_is_wrong_with_it() {
    let scratch = Scratch::new("trigger");
    let text = with(
        "[[trigger]]\non = \"midi.noot\"\nplay = \"baet\"\nset = { level = \"velocity\" }\n\
                     [[bind]]\nfrom = \"wheel\"\ncontrol = \"depth\"\n",
    );
    let words = ["midi.noot", "no voice or pattern `baet`", "`from` of binding 1", "no control `depth`"];
    assert_eq!(told(&scratch, "a.toml", &text, &words), 4);
}

#[test]
fn files_are_looked_for_whatever_else_is_wrong() {
    let scratch = Scratch::new("lost");
    scratch.write("noise.wav", "no recording");
    let samples = "[voice.s]\noutput = \"a\"\nstart = \"always\"\n[voice.s.nodes]\n\
        a = { type = \"sample\", file = \"none.wav\" }\nb = { type = \"sample\", file = \"noise.wav\" }\n\
        c = { type = \"sample\", file = \"../out.wav\" }\n[pattern.p]\nevents = \"none.csv\"\n";
    let words = [
        "a.toml:7:",
        "`none.wav` is not there",
        "a.toml:8:",
        "no WAV file",
        "a.toml:9:",
        "leaves the folder",
        "`none.csv` is not there",
    ];
    assert_eq!(told(&scratch, "a.toml", &format!("{HEAD}{samples}"), &words), 4);
    let slip = "d = { type = \"sinus\" }\n[pattern.p]";
    let text = format!("{HEAD}{}", samples.replace("../out", "noise").replace("[pattern.p]", slip));
    assert_eq!(told(&scratch, "a.toml", &text, &["`none.wav`", "no WAV file", "\"sinus\"", "`none.csv`"]), 5);
}

#[test]
fn a_table_is_told_of_at_its_own_lines() {
    let scratch = Scratch::new("table");
    scratch.write("sub/evp.toml", with("[pattern.p]\nevents = \"ev.csv\"\n"));
    scratch.write("sub/ev.csv", "at,voice,level,place\n0,beat,1,\n0.5,baet,loud,\n1,beat,1,toe\n");
    let run = scratch.run(&["check", "sub/evp.toml"]);
    let at =
        |column: &str| format!("sub/ev.csv:{column}: error: ").replace('/', std::path::MAIN_SEPARATOR_STR);
    run.fails(
        65,
        &[
            &at("3:5"),
            &at("3:10"),
            "`level` is \"loud\"",
            &at("4:10"),
            "no tactor `toe`",
            "is named in sub/evp.toml:10",
        ],
    );
    assert_eq!(run.err.matches(" error: ").count(), 3, "{}", run.err);
    let picture = scratch.run(&["--color=always", "check", "sub/evp.toml"]);
    picture.fails(65, &["0.5,baet,loud,", "ev.csv:3:5"]);
    let list = scratch.run(&["check", "sub/evp.toml", "--json"]).json();
    assert_eq!((&list["problems"][0]["line"], &list["problems"][0]["column"]), (&3.into(), &5.into()));

    scratch.write("sub/ev.csv", "at;voice\n0;beat\n");
    scratch.run(&["check", "sub/evp.toml"]).fails(65, &[&at("1:1"), "semicolons", "divided by commas"]);
    scratch.write("sub/ev.csv", "at,voice\n");
    let run = scratch.run(&["check", "sub/evp.toml"]);
    assert!(run.succeeds().err.contains("ev.csv:1:1: warning: the file has no events"), "{}", run.err);
}

#[test]
fn words_of_other_programs_lead_to_nodes() {
    let scratch = Scratch::new("words");
    let node =
        |node: &str| format!("{HEAD}[voice.v]\noutput = \"n\"\nstart = \"always\"\nnodes.n = {node}\n");
    for (word, help) in [
        ("adsr", "did you mean `envelope`?"),
        ("noise", "did you mean `white`, `pink` or `band_noise`?"),
        ("qwertyuiop", "`pacinian nodes` lists all"),
    ] {
        told(&scratch, "a.toml", &node(&format!("{{ type = \"{word}\" }}")), &["a.toml:6:", help]);
        scratch.run(&["nodes", word]).fails(2, &[help]);
    }
    let words = ["no parameter `freqency`", "did you mean `frequency`?"];
    assert_eq!(told(&scratch, "a.toml", &node("{ type = \"sine\", freqency = 90 }"), &words), 1);
    let text = format!("{HEAD}{}", VOICE.replace("output =", "outptu ="));
    assert_eq!(told(&scratch, "a.toml", &text, &["did you mean `output`?"]), 1);
    let control = with("[control.pitch]\ndefault = 200\n");
    told(&scratch, "a.toml", &control, &["its range is from 0 to 1", "give it `range = ["]);
}

#[test]
fn numbers_of_the_command_line_are_explained() {
    let scratch = Scratch::new("numbers");
    for (arguments, word) in [
        (["--rate", "44.1"], "is 44100 meant?"),
        (["--rate", "48k"], "--rate 48000"),
        (["--rate", "500"], "whole hertz from"),
        (["--rate", "-1"], "whole hertz from"),
        (["--rate", "fast"], "whole hertz from"),
        (["--seed", "x"], "a whole number from 0"),
        (["--seed", "-1"], "a whole number from 0"),
        (["--duration", "-1"], "seconds above 0"),
    ] {
        let run = scratch.run(&[&["render", "good.toml", "-o", "x.wav"], &arguments[..]].concat());
        run.fails(2, &[arguments[0], word]);
        assert!(
            !run.err.contains("invalid digit") && !run.err.contains("unexpected argument"),
            "{}",
            run.err
        );
    }
    for (arguments, word) in [(["--duration", "-1"], "seconds above 0"), (["--osc-to", "0"], "1 to 65535")] {
        let run = scratch.run(&[&["play", "good.toml", "--device", "virtual"], &arguments[..]].concat());
        run.fails(2, &[arguments[0], word]);
    }
    scratch.run(&["check", "good.toml", "--rate", "44100", "--seed", "7"]).succeeds();
}

/// Where nothing would ever sound, what it waits for is said.
#[test]
fn a_patch_that_waits_says_what_for() {
    let scratch = Scratch::new("waits");
    let keys =
        "[[trigger]]\non = \"key.1\"\nplay = \"beat\"\n[[trigger]]\non = \"osc./hit\"\nplay = \"beat\"\n";
    let play = |patch: String| {
        scratch.write("p.toml", patch);
        scratch.run(&["play", "p.toml", "--device", "virtual", "--duration", "0.1"])
    };
    let pattern = "[pattern.p]\nevents = [{ at = 0, voice = \"beat\" }]\n";
    let waits = play(format!("{HEAD}{VOICE}{pattern}{keys}"));
    let told = "nothing plays by itself; it waits for key 1 (beat), OSC to /hit (beat)";
    assert!(waits.succeeds().err.contains(told), "{}", waits.err);
    // Ports are opened for a clock alone; where there is no MIDI, that is said.
    let clocked =
        "[pattern.p]\ntime = \"beats\"\nclock = \"midi\"\nevents = [{ at = 0, voice = \"beat\" }]\n";
    let waits = play(format!("{HEAD}{VOICE}{clocked}"));
    let told = "nothing plays by itself; it waits for the clock of MIDI (p)";
    assert!(waits.succeeds().err.contains(told), "{}", waits.err);
    if cfg!(target_os = "linux") && !std::path::Path::new("/dev/snd/seq").exists() {
        assert!(waits.err.contains("no MIDI: "), "{}", waits.err);
    }
    let start = "[[trigger]]\non = \"start\"\nplay = \"beat\"\n";
    let plays = play(format!("{HEAD}{VOICE}{pattern}{keys}{start}"));
    assert!(!plays.succeeds().err.contains("it waits for"), "{}", plays.err);
}

/// What a patch does when nobody plays it is not all of it.
#[test]
fn check_says_what_plays_and_moves_a_patch_from_outside() {
    let scratch = Scratch::new("outside");
    let pattern = "[pattern.p]\nevents = [{ at = 0, voice = \"beat\" }]\n";
    let outside = "[control.depth]\ndefault = 4\nrange = [2, 10]\n\
        [[trigger]]\non = \"key.2\"\nplay = \"p\"\n\
        [[trigger]]\non = \"midi.note\"\nplay = \"beat\"\nnotes = [36, 59]\nchannel = 3\nspread = \"notes\"\n\
        [[trigger]]\non = \"midi.controller 80 falls 0.25\"\nplay = \"beat\"\n\
        [[bind]]\nfrom = \"midi.bend\"\ncontrol = \"depth\"\n\
        [[bind]]\nfrom = \"osc./d\"\ncontrol = \"depth\"\nrange = [5, 3]\npickup = false\n";
    scratch.write("p.toml", format!("{HEAD}{VOICE}{pattern}{outside}"));
    let run = scratch.run(&["check", "p.toml"]);
    let shown = "played live\n  \
        key 2                                     plays p      \n  \
        notes of MIDI from C2 to B3 on channel 3  plays beat   spread over the tactors by notes\n  \
        controller 80 of MIDI falls 0.25          plays beat   \n  \
        bend of MIDI                              moves depth  from 2 to 10, with pick-up\n  \
        OSC to /d                                 moves depth  from 5 to 3\n";
    let plain = |text: &str| text.lines().map(str::trim_end).collect::<Vec<_>>().join("\n");
    assert!(plain(&run.succeeds().out).contains(&plain(shown)), "{}", run.out);
    assert!(run.out.contains("p  plays; live, it waits"), "{}", run.out);
    let plan = &scratch.run(&["check", "p.toml", "--json"]).succeeds().json()["plan"];
    assert_eq!(plan["outside"][1]["notes"], serde_json::json!([36, 59]));
    assert_eq!(plan["outside"][4]["range"], serde_json::json!([5.0, 3.0]));
    assert_eq!(
        (plan["patterns"][0]["plays"].as_bool(), plan["patterns"][0]["waits"].as_bool()),
        (Some(true), Some(true))
    );
    // As it is when it is played.
    let live = |more: &[&str]| {
        let words = ["play", "p.toml", "--device", "virtual", "--duration", "0.4"];
        let run = scratch.run(&[&words[..], more].concat());
        run.succeeds().err.contains("it waits for")
    };
    assert!(live(&[]) && !live(&["--pattern", "p"]));
    let asked = scratch.run(&["check", "p.toml", "--pattern", "p"]);
    assert!(asked.succeeds().out.contains("p  plays  0.10 s"), "{}", asked.out);
    let start = "[[trigger]]\non = \"start\"\nplay = \"p\"\n";
    scratch.write("p.toml", format!("{HEAD}{VOICE}{pattern}{outside}{start}"));
    assert!(!live(&[]) && !scratch.run(&["check", "p.toml"]).succeeds().out.contains("it waits"));
}

/// Run from the project's folder.
fn at_home(arguments: &[&str]) -> Run {
    let scratch = Scratch::new("home");
    Run::of(scratch.command(arguments).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap())
}

#[test]
fn a_patch_without_its_rig_names_it_once() {
    let run = at_home(&["check", "patches/20-compass.toml"]);
    run.fails(65, &["the rig has no tactor `front`", "--rig rigs/belt.toml"]);
    assert_eq!(run.err.matches("help:").count(), 1, "{}", run.err);
    let rain = at_home(&["check", "patches/10-rain.toml"]);
    assert!(rain.succeeds().out.contains("1 event, 20 onsets"), "{}", rain.out);
}

#[test]
fn the_log_says_what_was_set() {
    let scratch = Scratch::new("set");
    let controls = "[control.k]\ndefault = 0.5\n[control.m]\ndefault = 0.5\n[pattern.p]\nevents = [{ at = 0, voice = \"beat\" }]\n";
    scratch.write("a.toml", with(controls).replace("\"event.frequency\"", "\"event.frequency * (k + m)\""));
    let first = |settings: &[&str]| {
        let all = [&["render", "a.toml", "-o", "x.wav", "--log", "x.csv"], settings].concat();
        scratch.run(&all).succeeds();
        std::fs::read_to_string(scratch.0.join("x.csv")).unwrap().lines().next().unwrap().to_string()
    };
    assert!(!first(&[]).contains("set="));
    assert!(first(&["--set", "k=0.2"]).ends_with(" set=\"k=0.2\""));
    assert!(first(&["--set", "k=0.2", "--set", "m=1"]).ends_with(" set=\"k=0.2;m=1\""));
}

/// What the README gives to begin with is what it should be, and the crate it names has what it then uses.
#[test]
fn the_first_steps_of_the_readme() {
    let readme = include_str!("../README.md");
    assert!(readme.contains("--no-default-features --features io`. `io::load`"));
    let (_, behind) = readme.split_once("<!-- file: tap.toml -->\n```toml\n").unwrap();
    let scratch = Scratch::new("tap");
    scratch.write("tap.toml", behind.split_once("```").unwrap().0);
    let run = scratch.run(&["error", "tap.toml", "--only", "--json"]);
    let answer = run.succeeds().json();
    assert_eq!(answer["limited"], 0);
    let error = answer["settings"][0]["error_db"].as_f64().unwrap();
    assert!(error < -80.0, "{error} dB");
}
