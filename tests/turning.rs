//! What the command line says of motors behind cards and rectifiers, and of what is played on them in vain.
#![cfg(feature = "cli")]

mod program;

use pacinian::actuator::driver::coast::Coast;
use pacinian::graph::plan::Plan;
use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::patch::Patch;
use pacinian::rig::{Rig, Terminals};
use program::Scratch;
use serde_json::Value;

const MOTOR: &str = "[actuator.pad]\nmodel = \"rumble-motor\"\nrated_volts = 6.0\nresistance = 10.42\ninductance = 4.2e-3\n\
    torque_constant = 0.011\ninertia = 1.15e-7\nviscous_friction = 1e-6\ncoulomb_friction = 6e-4\nstatic_friction = 8e-4\n\
    eccentric_moment = 1.38e-5\nmass = 0.25\n";

/// A motor on channel 1, called `palm`, and a tactor, called `skin`.
fn rig(coupling: &str, amplifier: &str, output: &str) -> String {
    format!(
        "format = \"pacinian-rig/1\"\ntitle = \"A motor\"\n[device]\nchannels = 3\nrate = 48000\nfull_scale_volts = 5.0\n{coupling}\n\
         [amplifier.a]\n{amplifier}\n{MOTOR}[[output]]\nkind = \"drive\"\nname = \"palm\"\nchannel = 1\nactuator = \"pad\"\n\
         amplifier = \"a\"\n{output}\n[[tactor]]\nname = \"skin\"\nchannel = 2\n"
    )
}

fn coupled(card: f64, more: &str) -> String {
    let card = format!("coupling = {{ high_pass = {card:?} }}");
    let amplifier = "gain = 3.0\nmax_volts = 12.0\ncoupling = { high_pass = 6.0 }";
    rig(&card, amplifier, &format!("shaping = \"clicks\"\n{more}"))
}

fn carried(rectifier: &str, carrier: f64) -> String {
    let amplifier = format!(
        "drive = \"carrier\"\ngain = 4.0\nmax_volts = 18.0\ncarrier = {carrier:?}\nrectifier = \"{rectifier}\"\ndiode_drop = 0.7\n\
         coupling = {{ high_pass = 20.0 }}"
    );
    rig("coupling = { high_pass = 8.0 }", &amplifier, "")
}

const CLICKS: &str = "format = \"pacinian-patch/1\"\ntitle = \"Clicks\"\n[voice.tap]\noutput = \"o\"\nplace = \"palm\"\n\
    nodes.o = { type = \"drive-click\", turns = 0.25 }\n[voice.thump]\noutput = \"o\"\nplace = \"palm\"\n\
    nodes.o = { type = \"drive-click\", turns = 1.0 }\n[pattern.p]\nevents = [{ at = 0.0, voice = \"tap\" }, { at = 0.5, voice = \"thump\" }]\n";

/// What swells, on the motor, and a buzz.
fn swelling(place: &str, level: &str) -> String {
    format!(
        "format = \"pacinian-patch/1\"\ntitle = \"A swell\"\n[voice.swell]\noutput = \"o\"\nplace = \"{place}\"\n\
         [voice.swell.nodes]\nhit = {{ type = \"envelope\", attack = 0.1, decay = 0.1, sustain = 1.0, release = 0.05 }}\n\
         o = {{ type = \"multiply\", inputs = [\"hit\", {level}] }}\n\
         [voice.tap]\noutput = \"o\"\nplace = \"palm\"\nnodes.o = {{ type = \"drive-click\" }}\n\
         [pattern.p]\nevents = [{{ at = 0.0, voice = \"swell\", duration = 0.4 }}, {{ at = 0.6, voice = \"tap\" }}]\n"
    )
}

fn planned(patch: &str, rig: &str) -> Plan {
    let patch = Patch::parse("patch.toml", patch.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let rig = Rig::parse("rig.toml", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    scene(&patch, &rig, &Options::default(), &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
}

/// Text, warnings and JSON of `check`.
fn checked(scratch: &Scratch, patch: &str, rig: &str) -> (String, String, Value) {
    scratch.write("patch.toml", patch);
    scratch.write("rig.toml", rig);
    let words = ["check", "patch.toml", "--rig", "rig.toml"];
    let run = scratch.run(&words);
    run.succeeds();
    (run.out.clone(), run.err.clone(), scratch.run(&[&words[..], &["--json"]].concat()).succeeds().json())
}

/// Three digits that count, as they are told.
fn digits(x: f64) -> f64 {
    format!("{x:.2e}").parse().unwrap()
}

/// Of clicks through coupling, corners, strongest drives and what arrives are those of the plan; what arrives whole is said to, what does not is a warning.
#[test]
fn clicks_through_coupling_are_told_as_they_were_worked_out() {
    let scratch = Scratch::new("turning-coupled");
    let mut short = 0;
    for (rig, corners) in [(coupled(10.0, ""), [10.0, 6.0]), (coupled(2.0, "max_level = 0.9"), [2.0, 6.0])] {
        let plan = planned(CLICKS, &rig);
        let (text, warned, json) = checked(&scratch, CLICKS, &rig);
        let told = &json["plan"]["outputs"][1]["motor"]["coupled"];
        assert_eq!(told["corners"], serde_json::json!(corners));
        let through =
            format!("clicks alone, through the coupling at {} Hz and {} Hz", corners[0], corners[1]);
        assert!(text.contains(&through), "{text}");
        assert_eq!(told["clicks"].as_array().unwrap().len(), 2);
        for (told, clicks) in told["clicks"].as_array().unwrap().iter().zip(&plan.clicks) {
            let amount = clicks.book.strongest().list[0].1;
            for (key, due) in [("turns", clicks.turns), ("amount", amount), ("arriving", clicks.arriving)] {
                assert_eq!(told[key].as_f64(), Some(due), "{key}");
            }
            let (turns, arriving, amount) = (clicks.turns, clicks.arriving, digits(amount));
            let has = format!("one of {turns} turns has at most {amount} V and ");
            let whole = arriving == turns;
            let arrives = match whole {
                true => "arrives whole from rest".to_string(),
                false => format!("makes {arriving:.3} of them, which is all that gets through"),
            };
            assert!(text.contains(&(has + &arrives)), "{text}");
            let warning = format!("a click of {turns} turns makes at most {arriving:.3} of them on `palm`");
            assert_eq!(warned.contains(&warning), (arriving / turns - 1.0).abs() > 0.01, "{warned}");
            short += u32::from(!whole);
        }
    }
    assert!((1..=2).contains(&short), "some do not arrive, and some do: {short}");
}

/// Of a carrier, its frequency, that nothing brakes and how long the motor then rolls; what clicks come to, where that is far off.
#[test]
fn a_carrier_is_told_with_what_it_cannot_do() {
    let scratch = Scratch::new("turning-carrier");
    // So short that a push is over before there were many half-waves.
    let short = CLICKS.replace("turns = 0.25", "turns = 0.01");
    let mut far = 0;
    for (rectifier, carrier, patch) in
        [("full-wave", 4000.0, CLICKS), ("half-wave", 4000.0, CLICKS), ("half-wave", 2000.0, &short)]
    {
        let rig = carried(rectifier, carrier);
        let (text, _, json) = checked(&scratch, patch, &rig);
        let plan = planned(patch, &rig);
        let drive = &plan.drives[0];
        assert!(matches!(drive.terminals, Terminals::Carrier(_)));
        let full = drive.setup.full_speed();
        let rolls = Coast::new(&drive.setup.parameters).seconds(full, 1e-4 * full);
        let motor = &json["plan"]["outputs"][1]["motor"];
        assert_eq!(motor["carrier"], serde_json::json!([carrier, rolls]));
        assert!(motor["coupled"].is_null() && motor["pulses"].is_null());
        let limit = drive.setup.limit;
        let thousands = carrier / 1000.0;
        let line = format!("inverse within {limit:.3} V on average by a carrier of {thousands},000 Hz");
        assert!(text.contains(&line), "{text}");
        let alone = format!(
            "; forward alone: nothing brakes it, it rolls out in {rolls:.2} s, and clicks are pushes"
        );
        assert!(text.contains(&alone), "{text}");
        let pushes = motor["pushes"].as_array().unwrap();
        assert_eq!(pushes.len(), 2);
        for push in pushes {
            let turns = push["turns"].as_f64().unwrap();
            let reaches = [0, 1].map(|n| push["reaches"][n].as_f64().unwrap());
            let is_far = reaches.iter().any(|reached| (reached / turns - 1.0).abs() > 0.05);
            let told = format!("; a click of {turns} turns reaches {} of them", digits(reaches[0]));
            assert_eq!(text.contains(&told), is_far, "{text}");
            assert!(
                !is_far || text.contains("a full-wave rectifier comes nearer") == (rectifier == "half-wave")
            );
            far += u32::from(is_far);
            assert!(!is_far || carrier == 2000.0, "{rectifier} {carrier}: {push}");
        }
    }
    assert!(far > 0, "none is far off");
}

/// What is for the way that diodes do not let, and what is no click where clicks alone are played, is counted and told by a rendering.
#[test]
fn what_was_played_in_vain_is_told() {
    let scratch = Scratch::new("turning-vain");
    let words = ["render", "patch.toml", "--rig", "rig.toml", "-o", "out.wav"];
    for (patch, rig, key, told) in [
        (
            swelling("palm", "-0.8"),
            carried("full-wave", 4000.0),
            "backward",
            "were for backward, which its rectifier does not let",
        ),
        (
            swelling("palm", "0.8"),
            coupled(10.0, ""),
            "unplayed",
            "were no clicks, and nothing else is played there",
        ),
    ] {
        scratch.write("patch.toml", &patch);
        scratch.write("rig.toml", &rig);
        let json = scratch.run(&[&words[..], &["--json"]].concat()).succeeds().json();
        let of = |name: &str| json["held_back"].as_array().unwrap().iter().find(|one| one["name"] == name);
        let palm = of("palm").unwrap();
        // 0.45 s of it at 8 kHz, less what of its beginning and end is next to nothing.
        let count = palm[key].as_u64().unwrap();
        assert!((3000..3700).contains(&count), "{palm}");
        let other = if key == "backward" { "unplayed" } else { "backward" };
        assert_eq!(palm[other], 0, "{palm}");
        let run = scratch.run(&words);
        let (text, thousands) = (run.succeeds().out.clone() + &run.err, count / 1000);
        let line = text.lines().find(|line| line.contains(told)).unwrap_or_else(|| panic!("{text}"));
        assert!(line.contains("palm") && line.contains(&format!("{thousands}")), "{line}");
        // What goes the right way is not told.
        scratch.write("patch.toml", if key == "backward" { swelling("palm", "0.8") } else { CLICKS.into() });
        let json = scratch.run(&[&words[..], &["--json"]].concat()).succeeds().json();
        assert!(json["held_back"].as_array().unwrap().iter().all(|one| one[key] == 0), "{json}");
    }
}

/// A level where clicks alone are played: a warning with the voice, the output, what is ignored and what to do.
#[test]
fn a_level_where_clicks_alone_are_played_is_warned_of() {
    let scratch = Scratch::new("turning-levels");
    let says = [
        "voice `swell` sends a level to `palm`",
        "its level is ignored there",
        "`drive-click`",
        "patch.toml:",
    ];
    let rig = coupled(10.0, "");
    let (_, warned, json) = checked(&scratch, &swelling("palm", "0.8"), &rig);
    assert!(says.iter().all(|word| warned.contains(word)), "{warned}");
    assert!(!warned.contains("`tap`"), "an order is no level: {warned}");
    assert!(
        json["problems"]
            .as_array()
            .unwrap()
            .iter()
            .any(|p| p["message"].as_str().is_some_and(|p| p.contains(says[0]))),
        "{json}"
    );
    // By a place of an event, from an events file, by a trigger, from the beginning.
    let elsewhere = swelling("skin", "0.8");
    let placed = elsewhere.replace("voice = \"swell\"", "voice = \"swell\", place = \"palm\"");
    let file = elsewhere.replace(
        "events = [{ at = 0.0, voice = \"swell\", duration = 0.4 }, { at = 0.6, voice = \"tap\" }]",
        "events = \"e.csv\"",
    );
    scratch.write("e.csv", "at,voice,place\n0.0,swell,palm\n0.5,tap,palm\n");
    let triggered = format!("{elsewhere}[[trigger]]\non = \"key.1\"\nplay = \"swell\"\nplace = \"palm\"\n");
    let always = swelling("palm", "0.8")
        .replace(
            "place = \"palm\"\n[voice.swell.nodes]",
            "place = \"palm\"\nstart = \"always\"\n[voice.swell.nodes]",
        )
        .replace("{ at = 0.0, voice = \"swell\", duration = 0.4 }, ", "");
    let always = always.replace(
        "hit = { type = \"envelope\", attack = 0.1, decay = 0.1, sustain = 1.0, release = 0.05 }",
        "hit = { type = \"sine\", frequency = 3 }",
    );
    for patch in [placed, file, triggered, always] {
        let (_, warned, _) = checked(&scratch, &patch, &rig);
        assert_eq!(warned.matches(says[0]).count(), 1, "{patch}\n{warned}");
    }
    // On the tactor, and on a motor that plays levels, there is nothing to warn of.
    let plain = self::rig("coupling = \"dc\"", "gain = 3.0\nmax_volts = 12.0\ncoupling = \"dc\"", "");
    for (patch, rig) in [(&elsewhere, &rig), (&swelling("palm", "0.8"), &plain), (&CLICKS.to_string(), &rig)]
    {
        let (_, warned, _) = checked(&scratch, patch, rig);
        assert!(!warned.contains("clicks alone are played"), "{warned}");
    }
}

/// A way home that one motor has and another has not: a warning with the voice, the output, why and what helps, wherever the voice is played there; the
/// plan says it of the output, and a rendering counts the orders that did nothing.
#[test]
fn a_motor_that_cannot_be_sent_home_is_told_of() {
    let scratch = Scratch::new("turning-home");
    let output = |name: &str, channel: u32, more: &str| {
        format!(
            "[[output]]\nkind = \"drive\"\nname = \"{name}\"\nchannel = {channel}\nactuator = \"coin\"\namplifier = \"a\"\n{more}\n"
        )
    };
    let rig = |more: &str| {
        format!(
            "format = \"pacinian-rig/1\"\ntitle = \"Coins\"\n[device]\nchannels = 3\nrate = 48000\nfull_scale_volts = 5.0\ncoupling = \"dc\"\n\
             [amplifier.a]\ngain = 3.0\nmax_volts = 12.0\ncoupling = \"dc\"\n[actuator.coin]\npart = \"coin-10mm\"\n{}{}",
            output("palm", 1, "tilt = 0.0"),
            output("side", 2, more)
        )
    };
    let sent = |place: &str| {
        format!(
            "format = \"pacinian-patch/1\"\ntitle = \"Home\"\n[voice.go]\noutput = \"o\"\nplace = \"{place}\"\n\
             nodes.o = {{ type = \"drive-home\" }}\n[pattern.p]\nevents = [{{ at = 0.0, voice = \"go\" }}, {{ at = 1.5, voice = \"go\" }}]\n"
        )
    };
    let head = "voice `go` sends the motor of `side` home";
    let render = ["render", "patch.toml", "--rig", "rig.toml", "-o", "out.wav"];
    let unsent = |json: &Value, name: &str| {
        let of = json["held_back"].as_array().unwrap().iter().find(|one| one["name"] == name);
        of.unwrap()["homeless"].as_u64().unwrap()
    };
    for (more, why) in [
        ("", "`gravity` is 0"),
        ("tilt = 1.5707963", "anywhere within"),
        ("tilt = 1.5707963\npark = 0.5", "anywhere within"),
        ("shaping = \"clicks\"", "clicks alone"),
    ] {
        let (text, warned, json) = checked(&scratch, &sent("side"), &rig(more));
        for word in [head, why, "ignored there", "tilt = 0.0", "brought home: `palm`", "patch.toml:"] {
            assert!(warned.contains(word), "{more}: {word}: {warned}");
        }
        assert!(!text.contains("nothing is wrong") && warned.matches(head).count() == 1, "{text}{warned}");
        let problems = json["problems"].as_array().unwrap();
        assert!(problems.iter().any(|p| p["message"].as_str().is_some_and(|p| p.contains(head))), "{json}");
        let motor = |n: usize| &json["plan"]["outputs"][n]["motor"];
        assert!(motor(0)["home"].is_array() && motor(0)["homeless"].is_null(), "{json}");
        assert!(motor(1)["home"].is_null() && motor(1)["homeless"].as_str().unwrap().contains(why), "{json}");
        assert!(text.contains("not to be brought home"), "{text}");
        assert_eq!(text.contains("never parked"), more.contains("park"), "{text}");
        let run = scratch.run(&render);
        assert!(run.succeeds().err.contains(head), "{}", run.err);
        let told = run.out.clone() + &run.err;
        let line = told.lines().find(|line| line.contains("2 orders to go home did nothing"));
        assert!(line.is_some_and(|line| line.contains("side")), "{told}");
        let json = scratch.run(&[&render[..], &["--json"]].concat()).succeeds().json();
        assert_eq!((unsent(&json, "side"), unsent(&json, "palm")), (2, 0), "{json}");
    }
    // By a place of an event, from an events file, by a trigger.
    let home = sent("palm");
    let event = home.replacen("voice = \"go\" }", "voice = \"go\", place = \"side\" }", 1);
    scratch.write("e.csv", "at,voice,place\n0.0,go,side\n1.5,go,palm\n");
    let file = format!("{}events = \"e.csv\"\n", home.split("events").next().unwrap());
    let triggered = format!("{home}[[trigger]]\non = \"key.1\"\nplay = \"go\"\nplace = \"side\"\n");
    for patch in [event, file, triggered] {
        let (_, warned, _) = checked(&scratch, &patch, &rig(""));
        assert_eq!(warned.matches(head).count(), 1, "{patch}\n{warned}");
    }
    // Where nobody sends there, or where both can go, there is nothing to warn of and nothing to count.
    for (patch, rig) in [(home, rig("")), (sent("side"), rig("tilt = 0.0"))] {
        let (text, warned, _) = checked(&scratch, &patch, &rig);
        assert!(text.contains("nothing is wrong") && warned.is_empty(), "{text}{warned}");
        let json = scratch.run(&[&render[..], &["--json"]].concat()).succeeds().json();
        assert_eq!((unsent(&json, "side"), unsent(&json, "palm")), (0, 0), "{json}");
    }
}

/// A bridge is switched by steady voltages: clicks alone or not, coupling keeps them off it.
#[test]
fn a_bridge_behind_coupling_is_refused_for_clicks_too() {
    let scratch = Scratch::new("turning-bridge");
    scratch.write("patch.toml", CLICKS);
    let bridge = |coupling: &str| {
        rig(coupling, "drive = \"bridge\"\nmax_volts = 6.0", "shaping = \"clicks\"\ndirection = 3")
    };
    scratch.write("rig.toml", bridge("coupling = { high_pass = 8.0 }"));
    let words = ["check", "patch.toml", "--rig", "rig.toml"];
    scratch
        .run(&words)
        .fails(78, &["`palm`", "high-pass at 8 Hz", "a bridge is switched by steady voltages"]);
    scratch.write("rig.toml", bridge("coupling = \"dc\""));
    scratch.run(&words).succeeds();
}
