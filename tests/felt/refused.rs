//! What cannot be is refused, where it stands.

use pacinian::graph::scene::{Options, scene};
use pacinian::node::asset::NoAssets;
use pacinian::{Note, Patch, Player, Rig};

use crate::{RATE, RIG, Scratch, VOICE};

/// Programs and messages are refused what nobody can know.
#[test]
fn what_cannot_be_known_is_refused_when_it_is_played() {
    let scratch = Scratch::new("refused");
    let text = format!(
        "format = \"pacinian-patch/1\"\ntitle = \"T\"\n{VOICE}[voice.fixed]\noutput = \"s\"\nnodes.s = {{ type = \"sine\", frequency = 80 }}\n"
    );
    let patch = Patch::parse("p", text.as_bytes()).unwrap().value;
    let options = Options { live: true, ..Options::default() };
    let mut player = Player::new(&patch, &scratch.rig(), &options, &NoAssets).unwrap();
    let note = |hertz: f64| Note::default().felt(20.0).frequency(hertz).at_place("finger");
    assert!(player.play("v", &note(100.0)).is_ok());
    let mut told = |voice: &str, note: &Note| player.play(voice, note).unwrap_err().to_string();
    let high = told("v", &note(401.0));
    assert!(high.contains("`finger` at 401 Hz: its calibration goes from 40 to 400 Hz"), "{high}");
    assert!(told("v", &note(100.0).level(0.5)).contains("`level` and `felt` at once"));
    assert!(told("fixed", &note(100.0)).contains("felt_at"));
    for felt in [121.0, -61.0, 1e9, f64::NAN] {
        let beyond = told("v", &Note::default().felt(felt).frequency(100.0).at_place("finger"));
        assert!(beyond.contains("it may be from -60 to 120"), "{beyond}");
    }
    let point = told("v", &Note { place: Some(pacinian::Place::Position([0.0; 3])), ..note(30.0) });
    assert!(point.contains("nothing is extrapolated"), "{point}");
}

#[test]
fn every_mistake_is_told_at_its_line() {
    let scratch = Scratch::new("mistakes");
    let event = |keys: &str| format!("[pattern.p]\nevents = [{{ at = 0, voice = \"v\", {keys} }}]\n");
    let fixed = "[voice.f]\noutput = \"s\"\nnodes.s = { type = \"sine\", frequency = 80 }\n";
    let cases = [
        (event("felt = 20, level = 0.5"), 7, "has `level` and `felt` at once"),
        (event("felt = 500"), 7, "a number from -60 to 120"),
        (event("felt = nan"), 7, "a number from -60 to 120"),
        (event("felt = 20, frequency = 39.9, place = \"finger\""), 7, "its calibration goes from 40 to 400 Hz"),
        (event("felt = 20, frequency = 1500, place = \"nobody\""), 7, "thresholds are given from 10 to 1000 Hz"),
        (event("felt = 20, frequency = -3, place = \"nobody\""), 7, "thresholds are given"),
        (format!("{fixed}[pattern.p]\nevents = [{{ at = 0, voice = \"f\", felt = 3 }}]\n"), 10, "felt_at = 80"),
        (format!("{fixed}defaults = {{ felt = 3 }}\n"), 9, "felt_at = 80"),
        ("[voice.d]\noutput = \"s\"\ndefaults = { felt = 3, level = 1 }\nnodes.s = { type = \"sine\", frequency = \"event.frequency\" }\n".into(), 8, "at once"),
        ("[[trigger]]\non = \"osc./x\"\nplay = \"v\"\nset = { felt = \"value\", level = 1 }\n".into(), 9, "at once"),
        ("[[trigger]]\non = \"start\"\nplay = \"v\"\nset = { felt = 400 }\n".into(), 9, "from -60 to 120"),
        (format!("{fixed}[[trigger]]\non = \"osc./x\"\nplay = \"f\"\nset = {{ felt = \"value\" }}\n"), 12, "felt_at = 80"),
        (event("felt = 20").replace("voice = \"v\"", "marker = \"m\""), 7, "a marker has no `felt`"),
        ("[voice.d]\noutput = \"s\"\ndefaults = { felt = 3 }\nfelt_at = 2000\nnodes.s = { type = \"white\" }\n".into(), 9, "a number from 10 to 1000"),
    ];
    for (text, line, wanted) in cases {
        let (code, said) = scratch.check(&text);
        assert!(
            code == Some(65) && said.contains(&format!("patch.toml:{line}:")) && said.contains(wanted),
            "{text}: {said}"
        );
    }
    std::fs::write(
        scratch.0.join("e.csv"),
        "at,voice,felt,frequency,place\n0,v,20,100,finger\n1,v,20,30,finger\n2,v,,30,finger\n",
    )
    .unwrap();
    let (code, said) = scratch.check("[pattern.p]\nevents = \"e.csv\"\n");
    assert!(code == Some(65) && said.contains("e.csv:3:5") && said.contains("from 40 to 400 Hz"), "{said}");
    std::fs::write(scratch.0.join("e.csv"), "at,voice,felt,level\n0,v,20,1\n").unwrap();
    assert!(scratch.check("[pattern.p]\nevents = \"e.csv\"\n").1.contains("e.csv:2:5"));
}

#[test]
fn rigs_that_cannot_be_are_told_at_their_line() {
    let head = "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\n";
    let of = |keys: &str| {
        format!(
            "{head}full_scale_volts = 1\n[calibration.c]\n{keys}\n[[tactor]]\nname = \"t\"\nchannel = 1\ncalibration = \"c\"\n"
        )
    };
    let good = "date = 2026-03-14\nmethod = \"laser\"\narea = 2e-5\nunit = \"um/V\"\n";
    let table = "table = [[50, 1], [60, 2]]";
    let cases = [
        (of(&format!("{good}table = []")), 10, "without points"),
        (of(&format!("{good}table = [[50, 1]]")), 10, "1 point says nothing"),
        (of(&format!("{good}table = [[50, 1], [40, 1]]")), 10, "sort the points"),
        (of(&format!("{good}table = [[50, 1], [50, 1]]")), 10, "twice"),
        (of(&format!("{good}table = [[50, nan], [60, 1]]")), 10, "is no output"),
        (of(&format!("{good}table = [[nan, 1], [60, 1]]")), 10, "is no frequency"),
        (of(&format!("{good}table = [[50, 1e300], [60, 1]]")), 10, "is no output"),
        (of(&format!("{good}table = [[50, 0], [60, 1]]")), 10, "is no output"),
        (of(&format!("{good}table = [[50, 1, 2], [60, 1]]")), 10, "it must be a pair"),
        (of(&format!("{good}table = [[50, \"1\"], [60, 1]]")), 10, "it must be a pair"),
        (of(&format!("{good}table = 5")), 10, "a list of pairs"),
        (of(good), 5, "lacks `table`"),
        (of(&format!("{table}\n{}", good.replace("date = 2026-03-14\n", ""))), 5, "lacks `date`"),
        (
            of(&format!("{table}\n{}", good.replace("2026-03-14", "\"last week\""))),
            7,
            "it must be a day: 2026-03-14",
        ),
        (
            of(&format!("{table}\n{}", good.replace("2026-03-14", "2026-03-14T10:00:00"))),
            7,
            "it must be a day",
        ),
        (of(&format!("{table}\n{}", good.replace("laser", " "))), 8, "says nothing"),
        (of(&format!("{table}\n{}", good.replace("um/V", "um"))), 10, "`unit`"),
        (of(&format!("{table}\n{}", good.replace("2e-5", "20"))), 9, "`area`"),
        (
            of(&format!("{good}{table}")).replace("calibration = \"c\"", "calibration = \"d\""),
            11,
            "did you mean `c`?",
        ),
        (of(&format!("{good}{table}")).replace("full_scale_volts = 1\n", ""), 10, "full_scale_volts"),
        (of(&format!("{good}{table}").replace("um/V", "um/A")), 11, "does not impose"),
        (of(&format!("{good}{table}\nsite = \"nose\"")), 11, "`site`"),
    ];
    for (text, line, wanted) in cases {
        let problems = Rig::parse("r.toml", text.as_bytes()).map(|_| ()).unwrap_err().to_string();
        assert!(
            problems.contains(&format!("r.toml:{line}:")) && problems.contains(wanted),
            "{text}\n{problems}"
        );
    }
    // Over full scale nothing else need be known; and a rig whose table was not read is refused where it is needed, and only there.
    let whole = of(&format!("{good}{table}").replace("um/V", "um/FS")).replace("full_scale_volts = 1\n", "");
    assert!(Rig::parse("r.toml", whole.as_bytes()).is_ok());
    let unread = Rig::parse("r.toml", RIG.as_bytes()).unwrap().value;
    let text = format!(
        "format = \"pacinian-patch/1\"\ntitle = \"T\"\n{VOICE}[pattern.p]\nevents = [{{ at = 0, voice = \"v\" }}]\n"
    );
    let patch = |text: &str| Patch::parse("p", text.as_bytes()).unwrap().value;
    let options = Options::default();
    assert!(scene(&patch(&text), &unread, &options, &NoAssets).is_ok());
    let felt = text.replace("voice = \"v\" }", "voice = \"v\", felt = 3, place = \"palm\" }");
    let told = scene(&patch(&felt), &unread, &options, &NoAssets).map(|_| ()).unwrap_err().to_string();
    assert!(told.contains("`palm.csv` was not read"), "{told}");
}

/// A table that is not there, or cannot be, is told where the rig names it, or at its line.
#[test]
fn files_of_tables_are_checked_with_the_rig() {
    let scratch = Scratch::new("tables");
    let event = "[pattern.p]\nevents = [{ at = 0, voice = \"v\", felt = 10, place = \"palm\" }]\n";
    std::fs::write(scratch.0.join("palm.csv"), "frequency,output\n30,1\n20,1\n").unwrap();
    let (code, said) = scratch.check(event);
    assert!(code == Some(78) && said.contains("palm.csv:3:1") && said.contains("sort the points"), "{said}");
    std::fs::remove_file(scratch.0.join("palm.csv")).unwrap();
    let (code, said) = scratch.check(event);
    assert!(
        code == Some(78) && said.contains("rig.toml:26:9") && said.contains("`palm.csv` is not there"),
        "{said}"
    );
}

/// What nothing comes through to is not felt, calibrated or not.
#[test]
fn an_output_without_gain_is_refused() {
    let text = format!(
        "format = \"pacinian-patch/1\"\ntitle = \"T\"\n{VOICE}[pattern.p]\nevents = [{{ at = 0, voice = \"v\", felt = 10 }}]\n"
    );
    let patch = Patch::parse("p", text.as_bytes()).unwrap().value;
    let mut rig = Rig::default_for(2);
    rig.outputs[1].gain = 0.0;
    let options = Options { rate: Some(RATE), live: true, ..Options::default() };
    let said = scene(&patch, &rig, &options, &NoAssets)
        .err()
        .map(|problems| problems.to_string())
        .unwrap_or_default();
    assert!(said.contains("output `t2` has a `gain` of 0"), "{said}");
}
