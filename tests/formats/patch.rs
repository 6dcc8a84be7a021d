//! Patches.

use pacinian::node::NodeKind;
use pacinian::patch::{
    Action, Argument, Control, Curve, Events, Expr, Node, Operator, Patch, Permissions, Place, Repeat,
    Source, Start, TimeBase, Value, Voice,
};

use super::assert_told;

/// Line 1 to 3 of every patch below.
const HEAD: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n\n";
/// A voice of five lines: 4 to 8.
const VOICE: &str =
    "[voice.beat]\noutput = \"tone\"\n[voice.beat.nodes]\ntone = { type = \"sine\", frequency = 250 }\n\n";

/// The shape of a patch with everything in it.
pub const FULL: &str = r#"#:schema ../schema/patch.json
format = "pacinian-patch/1"
title = "All of it"
description = "Every key once."

[control.strength]
default = 0.5
range = [0.1, 1.0]
unit = "of full"
curve = "exponential"
smoothing = 0.02

[voice.beat]
voices = 16
output = "thud"
start = "event"
tail = 0.2
place = "t1"
[voice.beat.defaults]
frequency = 60
level = 0.8
duration = 0.25
depth = 3.5
[voice.beat.nodes]
tone = { type = "sine", frequency = "event.frequency + 2 * breath", amplitude = "min(1, event.depth)" }
thud = { type = "multiply", inputs = ["tone", "strength", 0.5] }

[voice.hum]
output = "hum"
start = "always"
place = [0.0, 0.1]
nodes.hum = { type = "sine", frequency = 80 }

[shared.nodes]
breath = { type = "sine", frequency = 0.2 }

[pattern.walk]
time = "beats"
tempo = 90
gain = 0.5
rate = 2
shuffle = true
jitter = { at = 0.01, level = 0.1, frequency = 0.05 }
repeat = { every = 4, times = 3 }
events = [
  { at = 0, voice = "beat", level = 1, duration = 0.5, place = 2, delay = 0.25, depth = 1, repeat = { times = 2, every = 0.5 } },
  { at = 1, pattern = "inner", gain = 0.5, rate = 2 },
  { at = 2, marker = "half" },
  { at = 3, choose = [{ voice = "beat", weight = 3 }, { pattern = "inner" }, { marker = "x" }] },
]

[[pattern.inner.events]]
at = 0.5
voice = "beat"
place = [0.0, 0.1, 0.2]

[pattern.long]
events = "long.csv"
repeat = { every = 60 }

[[trigger]]
on = "start"
play = "walk"

[[trigger]]
on = "midi.note"
play = "beat"
set = { level = "velocity", frequency = "40 + 2 * note", depth = 1 }
place = "t2"

[[trigger]]
on = "node.breath rises 0.3"
play = "beat"

[render]
duration = 10
seed = 7
tail = 0.5
"#;

#[test]
fn reads_everything() {
    let checked = Patch::parse("full.toml", FULL.as_bytes()).unwrap_or_else(|p| panic!("{p}"));
    // The name of the node `hum` is free: voices and nodes are told apart by where they stand.
    assert_eq!(checked.warnings.list, []);
    let patch = checked.value;
    assert_eq!((patch.title.as_str(), patch.description.as_str()), ("All of it", "Every key once."));
    let control = &patch.controls[0];
    assert_eq!((control.default, control.range, control.smoothing), (0.5, [0.1, 1.0], 0.02));
    assert_eq!((control.unit.as_str(), control.curve), ("of full", Curve::Exponential));

    let beat = &patch.voices[0];
    assert_eq!(
        (beat.name.as_str(), beat.voices, beat.output.as_str(), beat.tail),
        ("beat", 16, "thud", Some(0.2))
    );
    assert_eq!(beat.place, Some(Place::Name("t1".into())));
    assert_eq!((beat.level, beat.duration), (0.8, 0.25));
    assert_eq!(beat.fields, [("frequency".into(), 60.0), ("depth".into(), 3.5)]);
    assert_eq!(beat.field("duration"), Some(0.25));
    let [tone, thud] = beat.nodes.as_slice() else { panic!("two nodes in the order of the file") };
    assert_eq!((tone.name.as_str(), tone.kind.spec().name), ("tone", "sine"));
    let Value::Expr(Expr::Binary(Operator::Add, left, right)) = &tone.arguments[0].value else {
        panic!("a sum")
    };
    assert!(matches!(&**left, Expr::Event(field, _) if field == "frequency"));
    let Expr::Binary(Operator::Multiply, _, name) = &**right else { panic!("a product") };
    let Expr::Name(name, span) = &**name else { panic!("a name") };
    assert_eq!((name.as_str(), &FULL[span.clone()]), ("breath", "breath"));
    assert_eq!(tone.arguments[1].value, Value::Expr(Expr::Number(0.0)), "the default of `phase`");
    assert!(matches!(&thud.arguments[0].value, Value::Signals(list) if list.len() == 3));
    let hum = &patch.voices[1];
    assert_eq!((hum.start, &hum.place), (Start::Always, &Some(Place::Position([0.0, 0.1, 0.0]))));
    assert_eq!(patch.shared[0].name, "breath");

    let [walk, inner, long] = patch.patterns.as_slice() else {
        panic!("three patterns in the order of the file")
    };
    assert_eq!((walk.time, walk.gain, walk.rate, walk.shuffle), (TimeBase::Beats(90.0), 0.5, 2.0, true));
    assert_eq!(walk.repeat, Some(Repeat { every: 4.0, times: Some(3) }));
    let jitter = walk.jitter.as_ref().unwrap();
    assert_eq!(jitter.at, 0.01);
    let fractions: Vec<_> = jitter.fractions.iter().map(|s| (s.name.as_str(), s.value)).collect();
    assert_eq!(fractions, [("level", 0.1), ("frequency", 0.05)]);
    let Events::Inline(events) = &walk.events else { panic!("inline events") };
    assert_eq!((events[0].at, events[0].delay), (0.0, 0.25));
    assert_eq!(events[0].repeat, Some(Repeat { every: 0.5, times: Some(2) }));
    let Action::Voice(play) = &events[0].action else { panic!("a voice") };
    assert_eq!((play.voice.as_str(), play.level, play.duration), ("beat", Some(1.0), Some(0.5)));
    assert_eq!(play.place, Some(Place::Channel(2)));
    assert_eq!((play.fields[0].name.as_str(), play.fields[0].value), ("depth", 1.0));
    assert!(
        matches!(&events[1].action, Action::Pattern { pattern, gain: 0.5, rate: 2.0, .. } if pattern == "inner")
    );
    assert_eq!(events[2].action, Action::Marker("half".into()));
    let Action::Choose(alternatives) = &events[3].action else { panic!("a choice") };
    assert_eq!(alternatives.iter().map(|a| a.weight).collect::<Vec<_>>(), [3.0, 1.0, 1.0]);
    assert!(matches!(&inner.events, Events::Inline(events) if events.len() == 1));
    assert!(matches!(&long.events, Events::File(path, _) if path == "long.csv"));
    assert_eq!(long.repeat, Some(Repeat { every: 60.0, times: None }));
    assert_eq!(patch.triggers[0].on, Source::Start);
    assert_eq!(patch.triggers[1].set.len(), 3);
    assert_eq!(patch.triggers[2].on, Source::Node { node: "breath".into(), rises: true, threshold: 0.3 });
    assert_eq!(
        (patch.render.duration, patch.render.seed, patch.render.tail),
        (Some(10.0), Some(7), Some(0.5))
    );
}

/// Each bad patch with what is said of it: behind [`HEAD`] (so that lines count from 4), with or without [`VOICE`] (from 9).
#[test]
fn every_mistake_is_told_at_its_line() {
    let plain: &[(&str, &[(usize, &str)])] = &[
        ("colour = 1", &[(4, "the patch has no key `colour`")]),
        ("[voices.beat]", &[(4, "did you mean `voice`?")]),
        ("control = 3", &[(4, "`control` of the patch is 3; it must be a table")]),
        ("[control.x]", &[(4, "control `x` lacks `default`")]),
        ("[control.x]\ndefault = 2", &[(5, "`default` of control `x` is 2; its range is from 0 to 1")]),
        ("[control.x]\ndefault = nan", &[(5, "is nan; it must be a number from")]),
        ("[control.x]\ndefault = 1\nrange = [1, 0]", &[(6, "the first number must be less")]),
        ("[control.x]\ndefault = 1\ncurve = \"exponental\"", &[(6, "did you mean `exponential`?")]),
        ("[control.x]\ndefault = 1\ncurve = \"exponential\"", &[(4, "must lie above 0")]),
        ("[control.min]\ndefault = 1", &[(4, "`min` has a meaning in expressions")]),
        ("[control.\"a b\"]\ndefault = 1", &[(4, "cannot be used"), (4, "cannot be used")]),
        (
            "[control.x]\ndefault = 1\nsmoothing = -1",
            &[(6, "`smoothing` of control `x` is -1; it must be a number from 0 to 10")],
        ),
        ("[voice.v]", &[(4, "voice `v` lacks `output` | add output = \"...\": name of")]),
        (
            "[pattern]\nevents = []\nshuffle = true",
            &[(5, "[pattern] lacks a name | a pattern has a name: [pattern.NAME]")],
        ),
        ("[[pattern]]\nevents = []", &[(4, "it must be a table | each has a name: [pattern.NAME]")]),
        ("[trigger]\non = \"start\"", &[(4, "write [[trigger]] before each")]),
        ("[voice.v]\noutput = \"x\"", &[(4, "voice `v` has no nodes")]),
        ("[voice.v]\noutput = 3", &[(5, "`output` of voice `v` is 3; it must be a string")]),
        ("[render]\nseed = -1", &[(5, "a whole number from 0 up")]),
        ("[render]\nseeds = 1", &[(5, "did you mean `seed`?")]),
        (
            "[shared.nodes]\nx = { type = \"sine\", frequency = \"event.level\" }",
            &[(5, "shared nodes belong to no event")],
        ),
        ("[shared.nodes]\nx = 3", &[(5, "node `x` of the shared nodes is 3; it must be a table")]),
    ];
    let nodes: &[(&str, &[(usize, &str)])] = &[
        ("n = { type = \"sinus\", frequency = 1 }", &[(8, "there is no node type \"sinus\"")]),
        ("n = { type = \"sinne\", frequency = 1 }", &[(8, "did you mean `sine`?")]),
        ("n = { frequency = 1 }", &[(8, "lacks `type`")]),
        (
            "n = { type = \"sine\", frequency = \"250 Hz\" }",
            &[(8, "write frequency = 250: numbers have no unit")],
        ),
        (
            "n = { type = \"envelope\", attack = \"4ms\", sustain = \"50%\" }",
            &[(8, "write attack = 0.004: numbers"), (8, "write sustain = 0.5: numbers")],
        ),
        ("n = { type = \"multiply\" }", &[(8, "lacks `inputs` | add inputs = [...]: ")]),
        ("n = { type = \"lfo\", frequency = 4 }", &[(8, "did you mean `rate`?")]),
        ("n = { type = \"sine\" }", &[(8, "node `n` of voice `beat` (sine) lacks `frequency`")]),
        ("n = { type = \"sine\", frequncy = 1 }", &[(8, "did you mean `frequency`?")]),
        (
            "n = { type = \"sine\", frequency = 1e9 }",
            &[(8, "is 1e9; it must be a number from -4000 to 4000 Hz")],
        ),
        ("n = { type = \"sine\", frequency = nan }", &[(8, "is nan; it must be")]),
        (
            "n = { type = \"sine\", frequency = true }",
            &[(8, "is true; it must be a number, a name or an expression")],
        ),
        (
            "n = { type = \"sine\", frequency = \"2000 * 3\" }",
            &[(8, "it must be a number from -4000 to 4000 Hz")],
        ),
        ("n = { type = \"sine\", frequency = \"1 / 0\" }", &[(8, "it must be a number from")]),
        ("n = { type = \"sine\", frequency = \"2 *\" }", &[(8, "missing at its end")]),
        ("n = { type = \"sine\", frequency = \"ton\" }", &[(8, "did you mean `tone`?")]),
        (
            "n = { type = \"sine\", frequency = \"frequency\" }",
            &[(8, "the event's field is `event.frequency`")],
        ),
        (
            "n = { type = \"sine\", frequency = \"event.freqency\" }",
            &[(8, "did you mean `event.frequency`?")],
        ),
        (
            "n = { type = \"sine\", frequency = \"event.pressure\" }",
            &[(8, "declare it with its default under [voice.beat.defaults]")],
        ),
        ("n = { type = \"multiply\", inputs = [] }", &[(8, "a list with something in it")]),
        (
            "n = { type = \"multiply\", inputs = \"tone\" }",
            &[(8, "it must be a list of numbers, names and expressions")],
        ),
        (
            "n = { type = \"multiply\", inputs = [\"tone\", inf] }",
            &[(8, "is inf; it must be a finite number")],
        ),
        ("n = { type = \"sine\", frequency = 1, phase = \"n\" }", &[(8, "in a circle: n → n")]),
        (
            "a = { type = \"sine\", frequency = \"b\" }\nb = { type = \"multiply\", inputs = [1, \"a\"] }",
            &[(8, "in a circle: a → b → a")],
        ),
        ("event = { type = \"sine\", frequency = 1 }", &[(8, "has a meaning in expressions")]),
        ("a-b = { type = \"sine\", frequency = 1 }", &[(8, "the name `a-b` cannot be used")]),
        ("tone = { type = \"sine\", frequency = 1 }", &[(8, "this is not TOML: duplicate key")]),
    ];
    let events: &[(&str, &[(usize, &str)])] = &[
        ("events = []", &[(10, "pattern `p` has no events")]),
        ("time = \"beats\"", &[(9, "pattern `p` lacks `events`")]),
        ("events = 3", &[(10, "`events` of pattern `p` is 3; it must be a list")]),
        ("events = \"../x.csv\"", &[(10, "leaves the folder of the patch")]),
        ("events = \"/x.csv\"", &[(10, "leaves the folder of the patch")]),
        ("events = \"C:\\\\x.csv\"", &[(10, "leaves the folder of the patch")]),
        ("events = \"\"", &[(10, "has no name")]),
        ("events = \"x.csv\"\nshuffle = true", &[(11, "shuffles a file of events")]),
        ("events = [{ at = 0 }]", &[(10, "event 1 of pattern `p` has no voice")]),
        ("events = [{ at = 0, voce = \"beat\" }]", &[(10, "did you mean `voice` instead of `voce`?")]),
        ("events = [{ voice = \"beat\" }]", &[(10, "event 1 of pattern `p` lacks `at`")]),
        (
            "events = [\n{ at = 0, voice = \"beat\" },\n{ at = -1, voice = \"beat\" }]",
            &[(12, "`at` of event 2 of pattern `p` is -1")],
        ),
        ("events = [{ at = 0, voice = \"baet\" }]", &[(10, "did you mean `beat`?")]),
        (
            "events = [{ at = 0, voice = \"beat\", frequency = \"120 Hz\" }]",
            &[(10, "is \"120 Hz\"; it must be a number in Hz | write frequency = 120: numbers have no unit")],
        ),
        ("events = [{ at = 0, marker = \"m\", frequency = 120 }]", &[(10, "a marker has no `frequency`")]),
        (
            "events = [{ at = 0, voice = \"beat\", depth = \"x\" }]",
            &[(10, "`depth` of event 1 of pattern `p` is \"x\"")],
        ),
        ("events = [{ at = 0, voice = \"beat\", volume = 1 }]", &[(10, "did you mean `level`?")]),
        (
            "events = [{ at = 0, voice = \"beat\", repeat = { every = 1, count = 4 } }]",
            &[(10, "only a pattern may repeat for ever"), (10, "did you mean `times`?")],
        ),
        (
            "events = [{ at = 0, voice = \"beat\", repeat = { every = 1, times = 0 } }]",
            &[(10, "is 0; it must be a whole number from 1")],
        ),
        (
            "events = [{ at = 0, voice = \"beat\", repeat = { every = 1, times = 1e18 } }]",
            &[(10, "is 1e18; it must be a whole number from 1")],
        ),
        ("events = [{ at = 0, marker = \"m\" }]\njitter = 0.05", &[(11, "write jitter = { at = 0.05 }")]),
        (
            "events = [{ at = 0, marker = \"m\" }]\nrepeat = 4",
            &[(11, "write repeat = { every = 0.5, times = 4 }")],
        ),
        ("events = [{ at = 0, voice = \"p\" }]", &[(10, "there is no voice `p`")]),
        ("events = [{ at = 0, voice = \"beat\", levl = 1 }]", &[(10, "did you mean `level`?")]),
        ("events = [{ at = 0, voice = \"beat\", plce = \"x\" }]", &[(10, "did you mean `place`?")]),
        ("events = [{ at = 0, voice = \"beat\", roughness = 1 }]", &[(10, "declare it with its default")]),
        ("events = [{ at = 0, voice = \"beat\", level = -1 }]", &[(10, "from 0 to 100")]),
        ("events = [{ at = 0, voice = \"beat\", place = 0 }]", &[(10, "a channel from 1 to 4096")]),
        (
            "events = [{ at = 0, voice = \"beat\", place = [1] }]",
            &[(10, "is [1]; a position has two or three coordinates")],
        ),
        (
            "events = [{ at = 0, voice = \"beat\", place = [0, inf] }]",
            &[(10, "every coordinate must be a number of metres")],
        ),
        (
            "events = [{ at = 0, voice = \"beat\", marker = \"m\" }]",
            &[(10, "has `voice` and `marker` at once")],
        ),
        ("events = [{ at = 0, marker = \"m\", level = 1 }]", &[(10, "a marker has no `level`")]),
        ("events = [{ at = 0, voice = \"beat\", rate = 2 }]", &[(10, "a voice has no `rate`")]),
        (
            "events = [{ at = 0, voice = \"beat\", repeat = { every = 1 } }]",
            &[(10, "only a pattern may repeat for ever")],
        ),
        (
            "events = [{ at = 0, voice = \"beat\", repeat = { every = 0, times = 2 } }]",
            &[(10, "`every` of `repeat`")],
        ),
        ("events = [{ at = 0, pattern = \"p\" }]", &[(9, "pattern `p` contains itself: p → p")]),
        ("events = [{ at = 0, pattern = \"q\" }]", &[(10, "there is no pattern `q`")]),
        ("events = [{ at = 0, choose = [{ pattern = \"p\" }] }]", &[(9, "contains itself: p → p")]),
        ("events = [{ at = 0, choose = [] }]", &[(10, "has no alternatives")]),
        (
            "events = [{ at = 0, choose = [{ voice = \"beat\", weight = 0 }] }]",
            &[(10, "`weight` of alternative 1")],
        ),
        (
            "events = [{ at = 0, choose = [{ voice = \"beat\" }], place = 1 }]",
            &[(10, "give it to the alternatives")],
        ),
        ("events = [{ at = 0, marker = \"m\" }]\ntempo = 90", &[(11, "counts in seconds")]),
        ("events = [{ at = 0, marker = \"m\" }]\njitter = { level = 2 }", &[(11, "from 0 to 1")]),
        (
            "events = [{ at = 0, marker = \"m\" }]\njitter = { rough = 0.5 }",
            &[(11, "a field that no voice has")],
        ),
        (
            "events = [{ at = 0, marker = \"m\" }]\n[[trigger]]\non = \"start\"\nplay = \"q\"",
            &[(13, "there is no voice or pattern `q`")],
        ),
        (
            "events = [{ at = 0, marker = \"m\" }]\n[[trigger]]\non = \"strat\"\nplay = \"p\"",
            &[(12, "did you mean `start`?")],
        ),
        (
            "events = [{ at = 0, marker = \"m\" }]\n[[trigger]]\non = \"key.0\"\nplay = \"p\"",
            &[(12, "they count from 1")],
        ),
        (
            "events = [{ at = 0, marker = \"m\" }]\n[[trigger]]\non = \"node.x rises 1\"\nplay = \"p\"",
            &[(12, "no shared node `x`")],
        ),
        (
            "events = [{ at = 0, marker = \"m\" }]\n[[trigger]]\non = \"midi.note\"\nplay = \"beat\"\nset = { level = \"velocty\", depth = 1 }",
            &[(14, "it gives `note`, `velocity`"), (14, "have no field `depth`")],
        ),
    ];
    let mut count = 0;
    let mut check = |source: String, expected: &[(usize, &str)]| {
        count += 1;
        match Patch::parse("bad.toml", source.as_bytes()) {
            Ok(_) => panic!("accepted:\n{source}"),
            Err(problems) => assert_told(&source, &problems, expected),
        }
    };
    for (bad, expected) in plain {
        check(format!("{HEAD}{bad}\n"), expected);
    }
    for (bad, expected) in nodes {
        check(format!("{HEAD}{}{bad}\n", VOICE.trim_end_matches('\n').to_string() + "\n"), expected);
    }
    for (bad, expected) in events {
        check(format!("{HEAD}{VOICE}[pattern.p]\n{bad}\n"), expected);
    }
    assert!(count >= 40);
}

#[test]
fn all_problems_are_told_at_once_and_in_order() {
    let source = format!(
        "{HEAD}[voice.beat]\nvoices = 9000\noutput = \"tonne\"\n[voice.beat.nodes]\n\
         tone = {{ type = \"sine\", frequency = \"60 + wobble\" }}\nlost = {{ type = \"sin\" }}\nuser = {{ type = \"multiply\", inputs = [\"lost\"] }}\n\
         [pattern.p]\nevents = [\n  {{ at = 0, voice = \"bet\" }},\n  {{ at = \"x\", voice = \"beat\" }},\n]\n[[triger]]\n"
    );
    let problems = Patch::parse("bad.toml", source.as_bytes()).unwrap_err();
    let expected = [
        (5, "`voices` of voice `beat` is 9000; it must be a whole number from 1 to 4096"),
        (6, "did you mean `tone`?"),
        (8, "names `wobble`"),
        (9, "there is no node type \"sin\""),
        (13, "there is no voice `bet`"),
        (14, "`at` of event 2 of pattern `p` is \"x\"; it must be a number"),
        (16, "did you mean `trigger`?"),
    ];
    assert_told(&source, &problems, &expected);
    assert!(problems.to_string().contains("bad.toml:8:43: error: `frequency` of node `tone`"), "{problems}");
}

#[test]
fn versions_are_told_apart() {
    let parse =
        |format: &str| Patch::parse("v.toml", format!("{format}\ntitle = \"t\"\nbogus = 1\n").as_bytes());
    for (format, fragment) in [
        ("format = \"pacinian-patch/2\"", "version 2 of \"pacinian-patch\" is unknown"),
        ("format = \"pacinian-patch/1x\"", "version 1x"),
        ("format = \"pacinian-rig/1\"", "this is a rig, and a patch is wanted here"),
        ("format = \"patch\"", "it must be \"pacinian-patch/1\""),
        ("format = 1", "it must be a string"),
    ] {
        assert_told(format, &parse(format).unwrap_err(), &[(1, fragment)]);
    }
    let newer = parse("format = \"pacinian-patch/1.3\"").unwrap_err();
    assert_told("1.3", &newer, &[(1, "the file is of version 1.3"), (3, "no key `bogus`")]);
    assert_told(
        "none",
        &parse("").unwrap_err(),
        &[(0, ""), (3, "")].map(|(l, t)| if l == 0 { (1, "lacks `format`") } else { (l, t) }),
    );
    let checked = Patch::parse("v.toml", b"format = \"pacinian-patch/1.3\"\ntitle = \"t\"").unwrap();
    assert_told("warning", &checked.warnings, &[(1, "this program knows version 1")]);
    assert!(!checked.warnings.has_errors());
}

#[test]
fn patterns_that_contain_themselves_through_others_are_named() {
    let source = format!(
        "{HEAD}[pattern.a]\nevents = [{{ at = 0, pattern = \"b\" }}]\n[pattern.b]\nevents = [{{ at = 0, choose = [{{ pattern = \"c\" }}] }}]\n\
         [pattern.c]\nevents = [{{ at = 0, pattern = \"a\" }}]\n"
    );
    let problems = Patch::parse("p.toml", source.as_bytes()).unwrap_err();
    assert_told(&source, &problems, &[(4, "pattern `a` contains itself: a → b → c → a")]);
    let endless = format!(
        "{HEAD}[pattern.a]\nevents = [{{ at = 0, pattern = \"b\" }}]\n[pattern.b]\nrepeat = {{ every = 1 }}\nevents = [{{ at = 0, marker = \"m\" }}]\n"
    );
    let problems = Patch::parse("p.toml", endless.as_bytes()).unwrap_err();
    assert_told(&endless, &problems, &[(5, "pattern `b` repeats for ever")]);
}

#[test]
fn hidden_names_are_a_warning() {
    let source = format!("{HEAD}{VOICE}[control.tone]\ndefault = 1\n");
    let checked = Patch::parse("w.toml", source.as_bytes()).unwrap();
    assert_told(
        &source,
        &checked.warnings,
        &[(7, "node `tone` of voice `beat` hides the control of that name")],
    );
}

#[test]
fn paths_may_leave_the_folder_when_allowed() {
    let source = format!("{HEAD}[pattern.p]\nevents = \"../x.csv\"\n");
    assert!(Patch::parse("p.toml", source.as_bytes()).is_err());
    assert!(Patch::parse_with("p.toml", source.as_bytes(), Permissions { allow_outside: true }).is_ok());
}

#[test]
fn a_patch_made_in_code_is_checked_too() {
    let sine = NodeKind::find("sine").unwrap();
    let argument = |value| Argument { value, span: 0..0 };
    let number = |x| argument(Value::Expr(Expr::Number(x)));
    let mut voice = Voice::new("v", "tone");
    voice.nodes.push(Node {
        name: "tone".into(),
        kind: sine,
        arguments: vec![number(250.0), number(0.0), number(1.0)],
        span: 0..0,
    });
    let mut patch = Patch { voices: vec![voice], ..Patch::default() };
    assert_eq!(patch.check(), []);
    patch.voices[0].nodes[0].arguments[0] = number(1e9);
    patch.voices[0].nodes[0].arguments[2] = argument(Value::Flag(true));
    patch.voices[0].output = "ton".into();
    assert_eq!(patch.check().len(), 3, "{:?}", patch.check());
    patch.voices[0].nodes[0].arguments.pop();
    assert!(patch.check().iter().any(|p| p.what.contains("has 2 arguments, sine wants 3")));
    patch.controls = vec![
        Control {
            name: "c".into(),
            default: 0.0,
            range: [0.0, 1.0],
            unit: String::new(),
            curve: Curve::Linear,
            smoothing: 0.0,
            stream: 0.0,
            span: 0..0
        };
        2
    ];
    assert!(patch.check().iter().any(|p| p.what.contains("there is a control called `c` already")));
}

/// A node that is there but cannot be read is still one that may be meant, and a list without it would be wrong.
#[test]
fn names_of_what_cannot_be_read_are_suggested() {
    let text = format!(
        "{HEAD}[voice.v]\noutput = \"tone\"\n[voice.v.nodes]\ntone = {{ type = \"multiply\", inputs = [\"swel\", \"quite_else\"] }}\n\
         swell = {{ type = \"envelpe\" }}\n"
    );
    let told = Patch::parse("p.toml", text.as_bytes()).unwrap_err().to_string();
    assert!(told.contains("did you mean `swell`?") && told.contains("did you mean `envelope`?"), "{told}");
    assert!(told.contains("names `quite_else`") && !told.contains("there is only"), "{told}");
}

/// What shows only when patch and rig come together is shown at its line, too, by way of `?`.
#[test]
fn what_a_player_refuses_is_shown_at_its_line() {
    use pacinian::{graph::scene, node::asset::NoAssets, player::Player, rig::Rig};
    let text = format!("{HEAD}{VOICE}[pattern.p]\nevents = [{{ at = 0, voice = \"beat\" }}]\n")
        .replace("output = \"tone\"", "output = \"tone\"\nplace = \"toe\"");
    let play = || -> Result<Player, Box<dyn std::error::Error>> {
        let patch = Patch::parse("p.toml", text.as_bytes())?.value;
        Ok(Player::new(&patch, &Rig::default_for(2), &scene::Options::default(), &NoAssets)?)
    };
    let told = play().err().map(|error| error.to_string()).unwrap_or_default();
    assert!(told.starts_with("p.toml:6:") && told.contains("no tactor `toe`"), "{told}");

    let patch = Patch::parse("p.toml", text.replace("\"toe\"", "\"t2\"").as_bytes()).unwrap().value;
    let mut player =
        Player::new(&patch, &Rig::default_for(2), &scene::Options::default(), &NoAssets).unwrap();
    let nobody = player.play("bat", &Default::default()).unwrap_err();
    let error: Box<dyn std::error::Error> = nobody.into();
    let told = error.to_string();
    assert!(told.contains("no voice called `bat`") && told.contains("did you mean `beat`?"), "{told}");
    let note = |field: &str, value| pacinian::player::Note {
        fields: vec![(field.to_string(), value)],
        ..Default::default()
    };
    for (voice, field, value, words) in [
        ("beat", "frequenzy", 1.0, "did you mean `frequency`?"),
        ("beat", "frequency", f64::NAN, "it may be from -1000000000 to 1000000000"),
    ] {
        let told = player.play(voice, &note(field, value)).unwrap_err().to_string();
        assert!(told.contains(words), "{told}");
    }
    let silent = pacinian::player::Note { duration: Some(-1.0), ..Default::default() };
    assert!(player.play("beat", &silent).unwrap_err().to_string().contains("it may be from 0 to 1000000"));
    assert!(player.set("strenght", 1.0).unwrap_err().to_string().contains("no control"));
}

/// An event carries eight fields, `frequency` among them; the parser says so.
#[test]
fn a_ninth_field_is_refused() {
    let fields = |count: usize| {
        let own: String = (0..count).map(|i| format!("f{i} = {i}\n")).collect();
        let text = format!(
            "{HEAD}[voice.a]\noutput = \"s\"\n[voice.a.defaults]\n{own}[voice.a.nodes]\ns = {{ type = \"sine\", frequency = 250 }}\n"
        );
        Patch::parse("p.toml", text.as_bytes()).err().map(|p| p.list[0].what.clone())
    };
    assert_eq!(fields(7), None);
    assert!(
        fields(8).is_some_and(|what| what.contains("declare 9 fields") && what.contains("8 are the most"))
    );
}
