//! Where on the body: points that tactors share, groups, lists of names.

mod common;

use common::{channel, patch, rendered, run, schedule};
use pacinian::dsp::isa::Isa;
use pacinian::engine::Engine;
use pacinian::engine::event::Play;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
use pacinian::report::{measure, reference};
use pacinian::rig::Rig;
use pacinian::space::spot::Spot;

const RATE: f64 = 48_000.0;

/// Two by two and one apart, 40 mm from one another; a marker's pulse on the last channel.
const RIG: &str = r#"format = "pacinian-rig/1"
title = "Four and one"
[device]
channels = 7
[[tactor]]
name = "a"
channel = 1
position = [0.0, 0.0]
[[tactor]]
name = "b"
channel = 3
position = [0.04, 0.0]
gain = 0.5
[[tactor]]
name = "c"
channel = 2
position = [0.0, 0.04]
polarity = -1
[[tactor]]
name = "d"
channel = 4
position = [0.04, 0.04]
[[tactor]]
name = "wrist"
channel = 5
[[output]]
kind = "trigger"
name = "sync"
channel = 7
[group.low]
tactors = ["a", "b"]
[group.all]
tactors = ["d", "c", "b", "a", "wrist"]
"#;

fn rig(text: &str) -> Rig {
    Rig::parse("rig.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value
}

fn plan(text: &str) -> Plan {
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    scene(&patch(text), &rig(RIG), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

/// A voice at a place, with further keys.
fn voice(keys: &str) -> String {
    format!(
        "[voice.v]\noutput = \"s\"\n{keys}\n[voice.v.nodes]\ns = {{ type = \"sine\", frequency = 150, amplitude = 0.3 }}\n"
    )
}

/// By channel, the largest sample of a voice that sounds where it says.
fn peaks(text: &str) -> Vec<f64> {
    let plan = plan(text);
    let play = Play { id: 1, duration: 0.1, ..plan.play("v", &[]).unwrap() };
    let (_, frames) = rendered(&plan, &[(0.0, play)], 0.1);
    let peak =
        |c: usize| channel(&frames, plan.channels, c).iter().fold(0.0_f64, |peak, x| peak.max(x.abs()));
    (0..plan.channels).map(peak).collect()
}

fn near(found: &[f64], due: &[f64]) {
    assert_eq!(found.len(), due.len());
    assert!(found.iter().zip(due).all(|(a, b)| (a - b).abs() < 2e-6), "{found:?}, but should be {due:?}");
}

/// By its law: of four tactors in a rectangle each has the product of its shares of the way across and up.
#[test]
fn a_point_is_shared_by_the_tactors_about_it() {
    let whole = peaks(&voice("place = \"a\""))[0];
    let (x, y) = (0.25, 0.6);
    let weights = [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y];
    let due = |gain: fn(f64) -> f64| {
        let [a, b, c, d] = weights.map(gain).map(|gain| whole * gain);
        [a, c, 0.5 * b, d, 0.0, 0.0, 0.0]
    };
    let at = "place = [0.01, 0.024]";
    near(&peaks(&voice(at)), &due(f64::sqrt));
    near(&peaks(&voice(&format!("{at}\nlaw = \"energy\""))), &due(f64::sqrt));
    near(&peaks(&voice(&format!("{at}\nlaw = \"linear\""))), &due(|w| w));
    near(&peaks(&voice(&format!("{at}\nlaw = \"logarithmic\""))), &due(|w| (1.0 + w).log2()));
    near(&peaks(&voice(&format!("{at}\nlaw = \"nearest\""))), &[0.0, whole, 0.0, 0.0, 0.0, 0.0, 0.0]);
    // On a tactor, beyond the rim, and beside the plane.
    near(&peaks(&voice("place = [0.0, 0.0]")), &[whole, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    near(&peaks(&voice("place = [-3.0, 7.0]")), &[0.0, whole, 0.0, 0.0, 0.0, 0.0, 0.0]);
    near(&peaks(&voice("place = [0.01, 0.024, 0.02]")), &due(f64::sqrt));
    // From half of the spacing on, a width is that of a Gaussian.
    let width = 0.03;
    let wide = peaks(&voice(&format!("{at}\nwidth = {width}")));
    let bell = |tactor: [f64; 2]| {
        let r2 = (tactor[0] - 0.01_f64).powi(2) + (tactor[1] - 0.024_f64).powi(2);
        (-0.5 * r2 / (width * width)).exp()
    };
    let bells = [[0.0, 0.0], [0.04, 0.0], [0.0, 0.04], [0.04, 0.04]].map(bell);
    let sum: f64 = bells.iter().sum();
    let [a, b, c, d] = bells.map(|w| whole * (w / sum).sqrt());
    near(&wide, &[a, c, 0.5 * b, d, 0.0, 0.0, 0.0]);
}

/// Every tactor of a group or a list has the whole level, none of them twice.
#[test]
fn groups_and_lists_sound_together() {
    let whole = peaks(&voice("place = \"a\""))[0];
    let of = |a: f64, b: f64, c: f64, d: f64, wrist: f64| {
        [a, c, 0.5 * b, d, wrist, 0.0, 0.0].map(|share| share * whole)
    };
    near(&peaks(&voice("place = \"low\"")), &of(1.0, 1.0, 0.0, 0.0, 0.0));
    near(&peaks(&voice("place = \"all\"")), &of(1.0, 1.0, 1.0, 1.0, 1.0));
    near(&peaks(&voice("place = [\"wrist\", \"d\"]")), &of(0.0, 0.0, 0.0, 1.0, 1.0));
    near(&peaks(&voice("place = [\"low\", \"b\", \"wrist\"]")), &of(1.0, 1.0, 0.0, 0.0, 1.0));
}

/// What a voice sounds as is what the reference has it sound as, wherever it is.
#[test]
fn the_reference_knows_places() {
    let text = "[voice.v]\noutput = \"s\"\nwidth = 0.01\n[voice.v.nodes]\ns = { type = \"sine\", frequency = 150, amplitude = 0.3 }\n\
                [pattern.p]\nevents = [\n{ at = 0.0, voice = \"v\", place = [0.013, 0.031] },\n\
                { at = 0.05, voice = \"v\", place = \"low\" },\n{ at = 0.1, voice = \"v\", place = [\"c\", \"wrist\"] },\n]\n\
                [[trigger]]\non = \"start\"\nplay = \"p\"\n";
    let plan = plan(text);
    let at = |place: Spot, id: u64| Play { place, id, duration: 0.1, ..plan.play("v", &[]).unwrap() };
    let list = plan.place("c + wrist").unwrap();
    let events = [
        (0.0, at(Spot::Point([0.013, 0.031, 0.0]), 1)),
        (0.05, at(plan.place("low").unwrap(), 2)),
        (0.1, at(list, 3)),
    ];
    let (engine, frames) = rendered(&plan, &events, 0.1);
    assert_eq!(engine.stage().counts().limited, 0);
    let seconds = frames.len() as f64 / plan.channels as f64 / plan.device_rate;
    let due = reference(&plan, &events, seconds, 8);
    let rms = |x: &[f64]| (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt();
    let pairs: Vec<[f64; 2]> =
        (0..6).map(|c| [rms(&channel(&frames, plan.channels, c)), rms(&due.channels[c])]).collect();
    let share = pairs[0][0] / pairs[0][1];
    for (c, [found, due]) in pairs.iter().enumerate() {
        assert!((found - share * due).abs() <= 1e-3 * due, "{c}: {found} {due}");
        assert_eq!(*due > 0.0, c < 5, "{c}");
    }
}

/// A line, a grid and two layers, 50 mm from one to the next.
fn arrays() -> [(&'static str, Rig); 3] {
    let place = |shape: &str, n: usize| match shape {
        "line" => [0.05 * n as f64, 0.0, 0.0],
        "grid" => [0.05 * (n % 5) as f64, 0.05 * (n / 5) as f64, 0.0],
        _ => [0.05 * (n % 4) as f64, 0.05 * (n / 4 % 3) as f64, 0.05 * (n / 12) as f64],
    };
    [("line", 8), ("grid", 20), ("layers", 24)].map(|(shape, count)| {
        let mut rig = Rig::default_for(count);
        for (n, output) in rig.outputs.iter_mut().enumerate() {
            output.position = Some(place(shape, n));
        }
        (shape, rig)
    })
}

/// A voice with an envelope, and what it is beside that.
fn moving(keys: &str, nodes: &str) -> String {
    format!(
        "[voice.v]\noutput = \"s\"\n{keys}\n[voice.v.nodes]\n\
         tone = {{ type = \"sine\", frequency = 170, amplitude = 0.5 }}\n\
         edge = {{ type = \"envelope\", attack = 0.02, release = 0.02 }}\n\
         s = {{ type = \"multiply\", inputs = [\"tone\", \"edge\"] }}\n{nodes}\n"
    )
}

fn on(rig: &Rig, text: &str) -> Plan {
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    scene(&patch(text), rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

/// There and back over 0.2 m, at a speed.
fn path(speed: f64) -> String {
    let there = 0.2 / speed;
    let times: Vec<String> =
        (0..=(0.35 / there).ceil() as usize).map(|n| (n as f64 * there).to_string()).collect();
    let points: Vec<&str> =
        (0..times.len()).map(|n| ["[0.0, 0.0, 0.0]", "[0.14, 0.13, 0.06]"][n % 2]).collect();
    format!("place = {{ path = [{}], times = [{}] }}", points.join(", "), times.join(", "))
}

/// Below -80 dB of the reference, whose gains are as good as continuous, at any speed up to 50 m/s.
#[test]
fn a_voice_on_its_way_is_what_it_should_be() {
    for (shape, rig) in arrays() {
        for speed in [0.1, 1.0, 5.0, 50.0] {
            let plan = on(&rig, &moving(&path(speed), ""));
            let play = Play { id: 1, duration: 0.3, ..plan.play("v", &[]).unwrap() };
            let error = measure(&plan, &[(0.01234, play)], 0.4).unwrap().comparison.error_db;
            assert!(error < -80.0, "{shape} at {speed} m/s: {error} dB");
        }
    }
}

/// The same of one that its nodes move: swinging, growing wider, and on its way along a path as well.
#[test]
fn a_voice_that_nodes_move_is_what_it_should_be() {
    let nodes = "sway = { type = \"sine\", frequency = 3 }\n\
                 here = { type = \"place\", x = \"0.1 + 0.09 * sway\", y = \"0.05 + 0.02 * edge\", width = \"0.03 * edge\" }";
    let narrow = nodes.replace("0.03 * edge", "0");
    for (shape, rig) in arrays() {
        for (keys, nodes) in [
            ("", nodes),
            ("", &narrow),
            ("place = { path = [[-0.05, 0], [0.1, 0.05]], over = 0.3 }", &narrow),
        ] {
            let plan = on(&rig, &moving(keys, nodes));
            let play = Play { id: 1, duration: 0.3, ..plan.play("v", &[]).unwrap() };
            let error = measure(&plan, &[(0.01234, play)], 0.4).unwrap().comparison.error_db;
            assert!(error < -80.0, "{shape} {keys}: {error} dB");
        }
    }
}

/// However a run is cut into calls, and by whichever instructions, the bits are the same: along edges, where a path ends, and where a point is gone on with.
#[test]
fn ways_do_not_depend_on_blocks() {
    let nodes = "sway = { type = \"lfo\", rate = 9 }\nhere = { type = \"place\", x = \"0.1 * sway\" }";
    let wide = moving("width = 0.01", nodes);
    let row = "place = { path = [[0.013, 0], [0.11, 0], [0.11, 0.05]], over = 0.15 }";
    let both = moving("place = { path = [[0, 0.03], [0.2, 0.03]] }", nodes);
    for (shape, rig) in arrays() {
        for text in [&moving(&path(3.0), ""), &moving(&path(0.4), ""), &moving(row, ""), &wide, &both] {
            let plan = on(&rig, text);
            let play = |id| Play { id, duration: 0.2, ..plan.play("v", &[]).unwrap() };
            let take = |isa: Isa, calls: &[usize]| {
                let mut engine = Engine::with_isa(&plan, isa).unwrap();
                schedule(&mut engine, &[(80.3, play(1)), (300.0, play(2)), (301.7, play(3))]);
                run(&mut engine, 14_400, calls)
            };
            let whole = take(Isa::detect(), &[480]);
            assert!(whole.iter().any(|x| x.abs() > 0.1), "{shape}");
            for calls in [&[1][..], &[7, 64, 1, 333], &[4096]] {
                assert!(take(Isa::detect(), calls) == whole, "{shape} {calls:?}");
            }
            assert!(take(Isa::Baseline, &[480]) == whole, "{shape}");
        }
    }
}

#[test]
fn what_moves_and_cannot_is_told() {
    let of = |text: &str| {
        let text = format!("format = \"pacinian-patch/1\"\ntitle = \"A test\"\n{text}");
        Patch::parse("test.toml", text.as_bytes()).map(|_| ()).unwrap_err().to_string()
    };
    let here = "here = { type = \"place\", x = 0.1 }";
    let told = of(&moving("place = \"a\"", here));
    assert!(
        told.contains("test.toml:5:") && told.contains("says itself where it is, by its node `here`"),
        "{told}"
    );
    let played = "[pattern.p]\nevents = [{ at = 0, voice = \"v\", place = 3 }]\n";
    let told = of(&format!("{}{played}", moving("", here)));
    assert!(told.contains("says itself where it is") && told.contains("position or a path"), "{told}");
    let told = of(&moving("", &format!("{here}\nthere = {{ type = \"place\" }}")));
    assert!(told.contains("two nodes `place`: `here` and `there`"), "{told}");
    let told = of(&format!("{}[shared.nodes]\n{here}\n", moving("", "")));
    assert!(told.contains("shared node `here` is a `place`"), "{told}");
    // A rig without positions has no points, and none to go along.
    let bare = rig(
        "format = \"pacinian-rig/1\"\ntitle = \"t\"\n[device]\nchannels = 1\n[[tactor]]\nname = \"a\"\nchannel = 1\n",
    );
    let options = Options { rate: Some(RATE), ..Options::default() };
    for text in [
        moving("place = { path = [[0, 0], [1, 0]] }\nstart = \"always\"", ""),
        moving("start = \"always\"", here),
    ] {
        let told = scene(&patch(&text), &bare, &options, &NoAssets).map(|_| ()).unwrap_err().to_string();
        assert!(told.contains("no tactor of the rig has a position"), "{told}");
    }
}

#[test]
fn what_a_group_cannot_be_is_told_where_it_stands() {
    let of = |from: &str, to: &str| {
        let text = RIG.replace(from, to);
        assert_ne!(text, RIG);
        Rig::parse("rig.toml", text.as_bytes()).map(|_| ()).unwrap_err().to_string()
    };
    let told = of("[\"a\", \"b\"]", "[\"a\", \"bb\"]");
    assert!(told.contains("group `low` has `bb`") && told.contains("did you mean `b`?"), "{told}");
    let told = of("[\"a\", \"b\"]", "[]");
    assert!(told.contains("group `low`") && told.contains("has no tactor"), "{told}");
    let told = of("[\"a\", \"b\"]", "[\"a\", 3]");
    assert!(told.contains("a list of names of tactors"), "{told}");
    let told = of("[\"a\", \"b\"]", "[\"a\", \"a\"]");
    assert!(told.contains("group `low` has `a` twice"), "{told}");
    let told = of("[\"a\", \"b\"]", "[\"a\", \"sync\"]");
    assert!(told.contains("`sync`, which is a trigger"), "{told}");
    let told = of("[group.low]", "[group.wrist]");
    assert!(told.contains("group `wrist` has the name of the output `wrist`"), "{told}");
    let told = of("tactors = [\"a\", \"b\"]", "");
    assert!(told.contains("lacks `tactors`"), "{told}");
}

#[test]
fn places_that_the_rig_lacks_are_told() {
    let of = |keys: &str| {
        let patch = patch(&voice(keys));
        let options = Options { rate: Some(RATE), live: true, ..Options::default() };
        scene(&patch, &rig(RIG), &options, &NoAssets).map(|_| ()).unwrap_err().to_string()
    };
    let told = of("place = [\"a\", \"alll\"]");
    assert!(told.contains("no tactor `alll`") && told.contains("did you mean `all`?"), "{told}");
    assert!(of("place = \"lw\"").contains("did you mean `low`?"));
    assert!(of("place = [\"a\", \"sync\"]").contains("`sync` is a trigger"));
}

/// The program's answer: its exit code, what it printed, what it complained of.
fn program(words: &[&str]) -> (Option<i32>, String, String) {
    let done = std::process::Command::new(env!("CARGO_BIN_EXE_pacinian")).args(words).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    (done.status.code(), text(&done.stdout), text(&done.stderr))
}

/// What it makes is a rig without a complaint, with what the layout has; and a patch plays on it at names, groups and points.
#[test]
fn rigs_of_common_arrays_are_made() {
    for (words, tactors, group, point) in [
        (&["line", "8"][..], 8, "left", "[0.01, 0.0]"),
        (&["grid", "4x5", "--spacing", "0.03"], 20, "left", "[0.02, 0.01]"),
        (&["ring", "12"], 12, "left-half", "[0.0, 0.0, 0.02]"),
        (&["belt", "8"], 8, "left-half", "[0.1, 0.0, 0.05]"),
        (&["vest", "40"], 40, "front", "[0.0, 0.1, 0.1]"),
        (&["sleeve"], 24, "top", "[0.0, 0.04, 0.0]"),
        (&["hand"], 13, "tips", "[0.0, 0.0, 0.1]"),
        (&["hand", "left"], 13, "palm", "[0.0, 0.0, 0.1]"),
    ] {
        let (code, text, told) = program(&[&["rig", "new"], words].concat());
        assert_eq!((code, told.as_str()), (Some(0), ""), "{words:?}");
        let checked = Rig::parse("made.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{words:?} {p}"));
        assert!(checked.warnings.list.is_empty(), "{words:?} {}", checked.warnings);
        let rig = checked.value;
        assert_eq!((rig.outputs.len(), rig.device.channels as usize), (tactors, tactors));
        assert!(text.lines().all(|line| line.chars().count() < 130), "{words:?}");
        let every = (1..=tactors).all(|n| {
            text.lines().any(|line| {
                line.starts_with('#') && line.split_whitespace().any(|word| word == n.to_string())
            })
        });
        assert!(every, "the picture lacks a channel: {text}");
        for place in [format!("\"{group}\""), point.to_string()] {
            let options = Options { rate: Some(RATE), live: true, ..Options::default() };
            let plan = scene(&patch(&voice(&format!("place = {place}"))), &rig, &options, &NoAssets);
            let plan = plan.unwrap_or_else(|p| panic!("{words:?} {p}")).plan;
            let play = Play { id: 1, duration: 0.05, ..plan.play("v", &[]).unwrap() };
            let (_, frames) = rendered(&plan, &[(0.0, play)], 0.1);
            assert!(frames.iter().any(|x| x.abs() > 0.05), "{words:?} {place}");
        }
    }
    let sizes = program(&["rig", "new", "grid", "2x2", "--spacing", "0.03"]).1;
    let rig = Rig::parse("made.toml", sizes.as_bytes()).unwrap().value;
    let at = |n: usize| rig.outputs[n].position.unwrap();
    assert!((at(1)[0] - at(0)[0] - 0.03).abs() < 1e-9 && (at(0)[1] - at(2)[1]).abs() - 0.03 < 1e-9);
}

#[test]
fn what_no_layout_is_is_told() {
    for (words, told) in [
        (&["rig", "new", "cube"][..], "there is no layout `cube`"),
        (&["rig", "new", "grid", "4"], "rows and columns"),
        (&["rig", "new", "grid", "0x4"], "`rows` is 0"),
        (&["rig", "new", "grid", "4x5000"], "`columns` is 5000"),
        (&["rig", "new", "line", "many"], "how many tactors a line has"),
        (&["rig", "new", "line", "8", "--spacing", "nan"], "spacing"),
        (&["rig", "new", "line", "8", "--radius", "1"], "--radius is for ring"),
        (&["rig", "new", "ring", "8", "--radius=-1"], "radius"),
        (&["rig", "new", "vest", "12"], "a vest of 12 is not known"),
        (&["rig", "new", "hand", "third"], "there is no hand `third`"),
    ] {
        let (code, printed, complaint) = program(words);
        assert_eq!((code, printed.as_str()), (Some(2), ""), "{words:?}");
        assert!(complaint.contains(told), "{words:?}: {complaint}");
    }
    let folder = std::env::temp_dir().join(format!("pacinian-rig-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join("new.toml");
    let words = ["rig", "new", "line", "4", "-o", file.to_str().unwrap()];
    assert_eq!(program(&words).0, Some(0));
    let made = std::fs::read(&file).unwrap();
    let (code, _, told) = program(&words);
    assert!(code == Some(73) && told.contains("is there already"), "{told}");
    assert_eq!(std::fs::read(&file).unwrap(), made);
    std::fs::remove_dir_all(&folder).unwrap();
}
