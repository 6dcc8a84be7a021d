//! What people get wrong first: that the program says so, in `check` and wherever a patch is read, and what to do.
#![cfg(feature = "cli")]

use std::path::PathBuf;
use std::process::Command;

/// A folder that is gone when the test is over.
struct Scratch(PathBuf);

impl Scratch {
    fn new(name: &str) -> Self {
        let folder = std::env::temp_dir().join(format!("pacinian-advice-{name}-{}", std::process::id()));
        let _ = std::fs::remove_dir_all(&folder);
        std::fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }
    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.0.join(name), text).unwrap();
    }
    /// Exit code, standard output and standard error.
    fn run(&self, words: &[&str]) -> (i32, String, String) {
        let output = Command::new(env!("CARGO_BIN_EXE_pacinian"))
            .current_dir(&self.0)
            .args(words)
            .env_remove("CLICOLOR_FORCE")
            .env_remove("FORCE_COLOR")
            .output()
            .unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (output.status.code().unwrap_or(-1), text(output.stdout), text(output.stderr))
    }
    /// What `check` says of a patch: its first line, and what goes to standard error.
    fn check(&self, patch: &str, rest: &[&str]) -> (i32, String, String) {
        self.write("p.toml", patch);
        let mut words = vec!["check", "p.toml"];
        words.extend(rest);
        let (code, out, err) = self.run(&words);
        (code, out.lines().next().unwrap_or("").to_string(), err)
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

/// A patch with a voice `tap` and what follows.
fn patch(rest: &str) -> String {
    format!(
        "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.tap]\noutput = \"felt\"\n[voice.tap.nodes]\n\
         tone = {{ type = \"sine\", frequency = \"event.frequency\" }}\n\
         hit = {{ type = \"envelope\", attack = 0.004, decay = 0.05, sustain = 0.0 }}\n\
         felt = {{ type = \"multiply\", inputs = [\"tone\", \"hit\"] }}\n{rest}\n"
    )
}

fn rig(tactors: &str) -> String {
    format!("format = \"pacinian-rig/1\"\n[device]\nchannels = 2\n{tactors}")
}

#[test]
fn what_works_and_was_hardly_meant_is_a_warning_in_the_first_line() {
    let scratch = Scratch::new("warnings");
    for (rest, words) in [
        (
            "[pattern.p]\nevents = [{ at = 0, voice = \"tap\" }, { at = 1, voice = \"tap\", frequency = 7900 }]",
            &["p.toml:10:", "frequency 7900 of event 2 of pattern `p`: nothing above 1000 Hz is felt"][..],
        ),
        (
            "[pattern.p]\nevents = [{ at = 0, voice = \"tap\", place = \"t22\" }]",
            &["`t22` makes the line 22 tactors long; without a rig there are 8", "--rig"],
        ),
        ("", &["nothing in this patch plays by itself", "give it a [pattern]"]),
        (
            "[knob.effects]\nring = { type = \"transient\", strength = 0.01, frequency = 90, decay = 0.02 }\n[pattern.p]\n\
             events = [{ at = 0, voice = \"tap\" }]",
            &["effect `ring` rings as a wall is hit, and the knob has none", "add an effect of type wall"],
        ),
        (
            "[voice.ear]\noutput = \"e\"\nstart = \"always\"\nnodes.e = { type = \"input\" }",
            &["the patch listens, and hears silence", "--input FILE.wav"],
        ),
        (
            "[pattern.p]\nevents = [{ at = 0, voice = \"tap\", place = [0, 20] }]",
            &["20.00 m from the nearest tactor"],
        ),
    ] {
        let (code, head, err) = scratch.check(&patch(rest), &[]);
        assert_eq!((code, head.as_str()), (0, "p.toml: 1 warning"), "{rest}: {err}");
        for word in words {
            assert!(err.contains(word), "{word}: {err}");
        }
    }
    let (_, head, err) = scratch.check(&patch("[pattern.p]\nevents = [{ at = 0, voice = \"tap\" }]"), &[]);
    assert_eq!((head.as_str(), err.as_str()), ("p.toml: nothing is wrong", ""));
    let (_, head, _) = scratch.check(&patch("[[trigger]]\non = \"start\"\nplay = \"tap\""), &[]);
    assert_eq!(head, "p.toml: nothing is wrong", "a voice that the start sets off plays by itself");
    let (_, head, _) = scratch.check(&patch("[[trigger]]\non = \"midi.note\"\nplay = \"tap\""), &[]);
    assert_eq!(head, "p.toml: nothing is wrong", "whoever plays it knows");
}

#[test]
fn what_an_events_file_has_beyond_the_band_is_told_once() {
    let scratch = Scratch::new("beyond");
    scratch.write("e.csv", "at,voice,frequency\n0,tap,200\n1,tap,3000\n2,tap,4000\n");
    let (code, head, err) = scratch.check(&patch("[pattern.p]\nevents = \"e.csv\""), &[]);
    assert_eq!((code, head.as_str()), (0, "p.toml: 1 warning"), "{err}");
    assert!(
        err.contains("e.csv:3:7: ") && err.contains("frequency 3000 of line 3: nothing above 1000 Hz"),
        "{err}"
    );
}

#[test]
fn a_rig_in_millimetres_is_told_once() {
    let scratch = Scratch::new("millimetres");
    let tactor =
        |n: u32, x: f64| format!("[[tactor]]\nname = \"a{n}\"\nchannel = {n}\nposition = [{x}, 20]\n");
    scratch.write("r.toml", &rig(&(tactor(1, -50.0) + &tactor(2, 50.0))));
    let plain = patch("[pattern.p]\nevents = [{ at = 0, voice = \"tap\" }]");
    let (code, head, err) = scratch.check(&plain, &["--rig", "r.toml"]);
    assert_eq!((code, head.as_str()), (0, "p.toml: 1 warning"), "{err}");
    for word in ["r.toml:4:", "positions are metres, so that is 50 m away", "write -0.05"] {
        assert!(err.contains(word), "{word}: {err}");
    }
}

#[test]
fn patch_and_rig_that_change_places_are_told_how_they_go() {
    let scratch = Scratch::new("places");
    scratch.write("r.toml", &rig(""));
    scratch.write("q.toml", &patch("[pattern.p]\nevents = [{ at = 0, voice = \"tap\" }]"));
    let (code, _, err) = scratch.run(&["check", "r.toml"]);
    assert!(code == 65 && err.contains("give it to --rig: pacinian check PATCH --rig r.toml"), "{err}");
    let (code, _, err) = scratch.run(&["check", "q.toml", "--rig", "q.toml"]);
    assert!(code == 78 && err.contains("pacinian check q.toml --rig RIG"), "{err}");
    let far = patch("[pattern.p]\nevents = [{ at = 0, voice = \"tap\", place = 4 }]");
    let (code, _, err) = scratch.check(&far, &["--rig", "r.toml"]);
    assert!(code == 65 && err.contains("this rig has 2 channels; there is no channel 4"), "{err}");
}

#[test]
fn the_plan_says_what_plays_how_often_and_keeps_the_rest_short() {
    let scratch = Scratch::new("plan");
    let text = patch(
        "[pattern.all]\nevents = [{ at = 0, pattern = \"one\" }, { at = 1, choose = [{ pattern = \"two\" }, { marker = \"m\" }] }]\n\
         [pattern.one]\nevents = [{ at = 0, voice = \"tap\", repeat = { every = 0.1, times = 5 } }]\n\
         [pattern.two]\nevents = [{ at = 0, choose = [{ voice = \"tap\", duration = 2 }, { marker = \"m\" }] }]\n\
         [pattern.other]\nevents = [{ at = 0, voice = \"tap\" }]",
    );
    scratch.write("p.toml", &text);
    let (_, out, err) = scratch.run(&["check", "p.toml"]);
    let lines: Vec<String> =
        out.lines().map(|l| l.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    for wanted in [
        "one played by all 0.50 s 1 event, 5 onsets",
        "two played by all length depends on chance 1 event",
        "other does not play 0.10 s 1 event",
        "outputs `t2` to `t8` nothing feeds them",
    ] {
        assert!(lines.iter().any(|l| l == wanted), "{wanted}: {out}{err}");
    }
    let (_, out, _) = scratch.run(&["check", "p.toml", "--json"]);
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    let pattern = |i: usize| &json["plan"]["patterns"][i];
    assert_eq!((&pattern(0)["plays"], &pattern(0)["reached"]), (&true.into(), &true.into()));
    assert_eq!((&pattern(1)["plays"], &pattern(1)["reached"]), (&false.into(), &true.into()));
    assert_eq!((&pattern(3)["reached"], &pattern(1)["onsets"]), (&false.into(), &5.into()));
    assert_eq!(pattern(1)["played_by"], serde_json::json!(["all"]));
}

/// A voice that is always on has no length of its own: it is released at the end, and compared as any other.
#[test]
fn the_error_of_what_never_ends_is_that_of_what_does() {
    let scratch = Scratch::new("endless");
    let error = |nodes: &str| {
        let start = "start = \"always\"\noutput = \"o\"";
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"T\"\n[voice.hum]\n{start}\n[voice.hum.nodes]\n{nodes}"
        );
        scratch.write("p.toml", &text);
        let (code, out, err) = scratch.run(&["error", "p.toml", "--only", "--duration", "1", "--json"]);
        assert_eq!(code, 0, "{err}");
        let json: serde_json::Value = serde_json::from_str(&out).unwrap();
        (json["settings"][0]["error_db"].as_f64().unwrap(), json["rings_on"].as_bool().unwrap())
    };
    let (db, rings_on) = error("o = { type = \"sine\", frequency = 150, amplitude = 0.5 }");
    assert!(db < -80.0 && !rings_on, "{db}");
    // What no envelope ends goes on for longer than anybody waits, and that is said.
    let lasting = "s = { type = \"sine\", frequency = 150 }\ne = { type = \"envelope\" }\n\
                   o = { type = \"multiply\", inputs = [\"s\", \"1 + e\", 0.3] }";
    assert!(error(lasting).1);
}

#[test]
fn the_picture_of_error_has_both_columns_and_says_what_keeps_them_from_saying_much() {
    let scratch = Scratch::new("chart");
    let loud = patch(
        "[voice.hum]\noutput = \"n\"\nnodes.n = { type = \"sine\", frequency = 250 }\n\
                      [pattern.p]\nevents = [{ at = 0, voice = \"hum\", level = 3 }]",
    );
    scratch.write("p.toml", &loud);
    let (code, _, err) = scratch.run(&["error", "p.toml", "--only", "-o", "e.svg"]);
    assert_eq!(code, 0, "{err}");
    let svg = std::fs::read_to_string(scratch.0.join("e.svg")).unwrap();
    for wanted in ["f32: error to 1 kHz", "f32: above 1 kHz", "6 taps", "The limiter acted"] {
        assert!(svg.contains(wanted), "{wanted}: {svg}");
    }
}
