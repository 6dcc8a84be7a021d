//! `pacinian parts` and `pacinian motor`, against the library, and with everything that is no good.
#![cfg(feature = "cli")]

mod program;

use pacinian::actuator::drive::Drive as Imposes;
use pacinian::actuator::link::Chain;
use pacinian::actuator::link::amplifier::Amplifier;
use pacinian::actuator::link::coupling::Corners;
use pacinian::actuator::motor::{self, Casing, Drive, GRAVITY, Parameters, Plan};
use pacinian::actuator::shape::Course;
use pacinian::report::motion::coil::shakes;
use pacinian::report::motion::{Bench, Envelope, Row, Wish, behind, bursts, clicks, own};
use pacinian::rig::knob::motor as knob_motor;
use pacinian::rig::{Actuator, part};
use program::Scratch;
use serde_json::Value;

const RIG: &str = "format = \"pacinian-rig/1\"\ntitle = \"Motors\"\n[device]\nchannels = 4\nfull_scale_volts = 1.5\ncoupling = \"dc\"\n\
    [amplifier.bridge]\ngain = 4\nmax_volts = 5\ncoupling = \"dc\"\n[actuator.coin]\npart = \"coin-10mm\"\nmax_volts = 4\nmass = 0.05\n\
    [actuator.big]\nmodel = \"rumble-motor\"\nrated_volts = 5\nresistance = 10.42\ninductance = 4.2e-3\ntorque_constant = 0.011\n\
    inertia = 1.15e-7\nviscous_friction = 1e-6\ncoulomb_friction = 6e-4\nstatic_friction = 8e-4\neccentric_moment = 1.38e-5\n";
const WRIST: &str = "[[output]]\nkind = \"drive\"\nname = \"wrist\"\nchannel = 1\nactuator = \"coin\"\namplifier = \"bridge\"\ntilt = 1.0\n";
const PALM: &str = "[[output]]\nkind = \"drive\"\nname = \"palm\"\nchannel = 2\nactuator = \"big\"\namplifier = \"bridge\"\n";

fn coin() -> Parameters {
    Actuator::of_part(part::find("coin-10mm").unwrap()).rumble_motor().unwrap()
}

/// As the command has it where nothing is said.
fn bench(p: &Parameters, error: f64, posture: bool) -> Bench {
    let plan = Plan::choose(p, 48_000.0, &motor::Wish { error, posture, casing: true });
    Bench::new(p, plan, 48_000.0, 0.0).unwrap()
}

/// A number, to the bit; null stands for none.
#[track_caller]
fn same(said: &Value, due: Option<f64>, what: &str) {
    assert_eq!(said.as_f64(), due, "{what}: {said}");
}

#[track_caller]
fn same_way(said: &Value, row: &Row) {
    let done = row.done.as_ref().unwrap();
    let (f, name) = (done.figures, row.way.word());
    assert_eq!(said["way"], name);
    for (key, due) in [
        ("rise_50", f.rise[0]),
        ("rise_90", f.rise[1]),
        ("peak", Some(f.peak)),
        ("peak_at", Some(f.peak_at)),
        ("stop", f.stop),
        ("stands_at", done.run.stands),
        ("error", f.error),
        ("turns", Some(done.run.turns)),
        ("look_ahead", Some(done.look_ahead)),
    ] {
        same(&said[key], due, &format!("{name}: {key}"));
    }
    let energy = &done.run.energy;
    same(&said["energy"]["supplied"], Some(energy.supplied), name);
    same(&said["energy"]["coil_heat"], Some(energy.heat), name);
    same(&said["energy"]["friction"], Some(energy.viscous + energy.dry), name);
}

#[test]
fn every_part_is_listed_and_shown_with_where_its_figures_are_from() {
    let scratch = Scratch::new("parts");
    let list = scratch.run(&["parts"]).succeeds().out.clone();
    let all = scratch.run(&["parts", "--json"]).succeeds().json();
    assert_eq!(all.as_array().unwrap().len(), part::all().len() + knob_motor::all().len());
    for part in part::all() {
        assert!(list.contains(part.name) && list.contains(&part.title), "{}: {list}", part.name);
        let shown = scratch.run(&["parts", part.name]).succeeds().out.clone();
        let said = scratch.run(&["parts", part.name, "--json"]).succeeds().json();
        assert_eq!(said["model"], part.model.word());
        let figures = said["figures"].as_array().unwrap();
        assert_eq!(figures.len(), part.values.len());
        let mut counted = 0;
        for figure in figures {
            let key = figure["key"].as_str().unwrap();
            let value = &part.values[key];
            same(&figure["value"], Some(value.value), key);
            assert_eq!(
                (&figure["origin"], &figure["from"]),
                (&value.origin.word().into(), &Value::from(&*value.from))
            );
            assert!(!figure["doc"].as_str().unwrap().is_empty());
            let line = shown.lines().find(|line| line.trim_start().starts_with(key)).unwrap();
            assert!(line.contains(value.origin.word()), "{line}");
            counted += 1;
        }
        let origins = said["origins"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum::<u64>();
        assert_eq!(origins, counted);
        for source in &part.sources {
            assert!(source.url.as_ref().is_none_or(|url| shown.contains(url)), "{shown}");
        }
    }
    // Motors of knobs stand behind them.
    for motor in knob_motor::all() {
        assert!(list.contains(motor.name) && list.contains(&motor.title), "{}: {list}", motor.name);
        let shown = scratch.run(&["parts", motor.name]).succeeds().out.clone();
        let said = scratch.run(&["parts", motor.name, "--json"]).succeeds().json();
        let figures = said["figures"].as_array().unwrap();
        assert_eq!((&said["model"], figures.len()), (&"knob motor".into(), motor.values.len()));
        for figure in figures {
            let key = figure["key"].as_str().unwrap();
            let value = &motor.values[key];
            same(&figure["value"], Some(value.value), key);
            let line = shown.lines().find(|line| line.trim_start().starts_with(key)).unwrap();
            assert!(line.contains(value.origin.word()), "{line}");
        }
    }
    scratch.run(&["parts", "maxon-re26"]).fails(2, &["did you mean `maxon-re25`?"]);
    scratch.run(&["parts", "coin-11mm"]).fails(2, &["no part `coin-11mm`", "did you mean `coin-10mm`?"]);
}

#[test]
fn the_comparison_is_that_of_the_library() {
    let scratch = Scratch::new("motor-ways");
    let bench = bench(&coin(), 1e-4, false);
    for (words, level, seconds, envelope, turns, volts) in [
        (&["--seconds", "0.1"][..], 1.0, 0.1, Envelope::Rectangle, 0.25, 3.0),
        (
            &["--level", "0.5", "--seconds", "0.05", "--turns", "-1"],
            0.5,
            0.05,
            Envelope::Rectangle,
            -1.0,
            3.0,
        ),
        (
            &["--envelope", "raised-cosine", "--level", "0.3", "--volts", "2.5"],
            0.3,
            0.1,
            Envelope::RaisedCosine,
            0.25,
            2.5,
        ),
    ] {
        let said = scratch.run(&[&["motor", "coin-10mm", "--json"], words].concat()).succeeds().json();
        let wish = Wish { level, seconds, envelope };
        let mut rows = bursts(&bench, &wish, volts).unwrap();
        rows.extend(clicks(&bench, turns, Drive::Voltage(volts)).unwrap());
        let ways = said["ways"].as_array().unwrap();
        assert_eq!(ways.len(), rows.len());
        ways.iter().zip(&rows).for_each(|(said, row)| same_way(said, row));
    }
    let said = scratch.run(&["motor", "coin-10mm", "--json"]).succeeds().json();
    let (p, m) = (coin(), &said["motor"]);
    same(&m["rated_speed"], Some(p.rated_speed()), "speed");
    same(&m["mechanical_time"], Some(p.mechanical_time()), "time");
    same(&m["start_volts"], Some(p.start_volts()), "start");
    same(&m["rated_vibration"], p.rated_acceleration(), "acceleration");
    same(&m["standstill_amperes"], Some(0.1), "3 V on 30 ohm");
    same(&m["gravity"], None, "nobody said");
    assert_eq!(said["figures"]["assumed"].as_array().unwrap().len(), 10);
    let text = scratch.run(&["motor", "coin-10mm"]).succeeds().out.clone();
    for word in [
        "nobody measured",
        "torque_constant",
        "overdrive",
        "inverse",
        "switching",
        "a click of 0.25 turns",
        "left out",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn a_course_of_ones_own_is_played_as_written() {
    let scratch = Scratch::new("motor-drive");
    let bench = bench(&coin(), 1e-4, false);
    let said =
        scratch.run(&["motor", "coin-10mm", "--json", "--drive", "0.02:3, 0.01:-3, open"]).succeeds().json();
    let course =
        Course::ending_in(Drive::Open).then(0.02, Drive::Voltage(3.0)).then(0.01, Drive::Voltage(-3.0));
    same_way(&said["ways"][0], &own(&bench, &course));
    // A brake that is a brake.
    let short = scratch.run(&["motor", "coin-10mm", "--json", "--drive", "0.02:3, 0.01:1"]).succeeds().json();
    assert!(said["ways"][0]["stop"].as_f64() < short["ways"][0]["stop"].as_f64(), "it was braked");
    let warned = scratch.run(&["motor", "coin-10mm", "--drive", "0.02:7"]);
    assert!(warned.succeeds().err.contains("7 V, which is more than the 3 V"), "{}", warned.err);
    // Amperes would be something else.
    scratch
        .run(&["motor", "coin-10mm", "--drive", "0.02:3A"])
        .fails(2, &["the course has 3 A, and what drives the motor is a voltage", "0.02:3V"]);
    let units = scratch
        .run(&["motor", "coin-10mm", "--json", "--drive", "20ms:3V, 10ms:-3000mV, open"])
        .succeeds()
        .json();
    same_way(&units["ways"][0], &own(&bench, &course));
    let on = scratch.run(&["motor", "coin-10mm", "--drive", "1.5"]).succeeds().out.clone();
    assert!(on.contains("goes on"), "{on}");
}

#[test]
fn the_level_goes_with_the_wish_and_says_what_was_left_out() {
    let scratch = Scratch::new("motor-level");
    let said = |words: &[&str]| {
        scratch.run(&[&["motor", "coin-10mm", "--json"], words].concat()).succeeds().json()["computed"]
            .clone()
    };
    let flat = said(&[]);
    assert!(flat["left_out"][0].as_str().unwrap().contains("nobody said how the device is held"), "{flat}");
    let upright = |error: &str| said(&["--tilt", "0", "--error", error]);
    assert_eq!((&upright("0.01")["level"], &upright("1e-9")["level"]), (&"economy".into(), &"fine".into()));
    assert!(upright("0.01")["left_out"][0].as_str().unwrap().starts_with("inductance: it changes"));
    let p = Parameters { gravity: GRAVITY, ..coin() };
    let plan = Plan::choose(&p, 48_000.0, &motor::Wish { error: 1e-9, posture: true, casing: true });
    same(&upright("1e-9")["error"], Some(plan.error(&p, 48_000.0)), "error");
}

#[test]
fn clicks_behind_coupling_are_those_of_the_library() {
    let scratch = Scratch::new("motor-coupling");
    let words = ["motor", "coin-10mm", "--turns", "1", "--coupling", "2,20,20+10"];
    let said = scratch.run(&[&words[..], &["--json"]].concat()).succeeds().json();
    let bench = bench(&coin(), 1e-4, false);
    let rows = clicks(&bench, 1.0, Drive::Voltage(3.0)).unwrap();
    let click = rows[0].done.as_ref().unwrap().click.as_ref().unwrap();
    let amplifier =
        Amplifier { gain: 3.0, inverted: false, drive: Imposes::Voltage, volts: Some(3.0), amperes: None };
    let chain = Chain { full_scale: 1.0, corners: Corners::none(), amplifier };
    let all = [Corners::one(2.0), Corners::one(20.0), Corners::two(20.0, 10.0)];
    for (said, corners) in said["coupling"].as_array().unwrap().iter().zip(all) {
        let due = behind(&bench, click, &chain, corners).unwrap();
        same(&said["compensated"]["missing"], Some(due.compensated.shortfall.share), "missing");
        same(&said["compensated"]["turns"], Some(due.compensated.turns), "turns");
        same(&said["plain"]["worst_volts"], Some(due.plain.shortfall.worst), "worst");
        same(&said["lead"], Some(due.lead), "lead");
    }
    let text = scratch.run(&words).succeeds().out.clone();
    assert!(text.contains("20 and 10 Hz in series") && text.contains("compensated"), "{text}");
}

#[test]
fn a_rig_says_what_reaches_its_motor_and_how_it_is_held() {
    let scratch = Scratch::new("motor-rig");
    scratch.write("one.toml", format!("{RIG}{WRIST}"));
    scratch.write("two.toml", format!("{RIG}{WRIST}{PALM}"));
    let said = scratch.run(&["motor", "one.toml", "--json"]).succeeds().json();
    let p = Parameters { casing: Casing::Free { mass: 0.05 }, gravity: GRAVITY * 1.0_f64.cos(), ..coin() };
    same(&said["motor"]["limit_volts"], Some(4.0), "of what the rig lets it bear");
    same(&said["motor"]["gravity"], Some(p.gravity), "gravity");
    assert_eq!(
        (&said["figures"]["from_the_rig"], &said["figures"]["origins"]["assumed"]),
        (&2.into(), &9.into())
    );
    let rows = bursts(
        &bench(&p, 1e-4, true),
        &Wish { level: 1.0, seconds: 0.1, envelope: Envelope::Rectangle },
        4.0,
    );
    same_way(&said["ways"][1], &rows.unwrap()[1]);
    let palm = scratch.run(&["motor", "two.toml", "--output", "palm", "--json"]).succeeds().json();
    assert_eq!(palm["motor"]["unit"], "N", "nothing says how much moves with it");
    scratch.run(&["motor", "two.toml"]).fails(2, &["several outputs", "wrist, palm", "--output wrist"]);
    scratch
        .run(&["motor", "two.toml", "--output", "plam"])
        .fails(2, &["no output `plam`", "did you mean `palm`?"]);
    scratch.write("ac.toml", format!("{RIG}{WRIST}").replacen("\"dc\"", "{ high_pass = 10 }", 1));
    scratch.run(&["motor", "ac.toml"]).fails(78, &["ac.toml:", "high-pass at 10 Hz"]);
    scratch.write("lacks.toml", format!("{RIG}{PALM}").replace("inertia = 1.15e-7\n", ""));
    scratch.run(&["motor", "lacks.toml"]).fails(78, &["lacks `inertia`"]);
    scratch.write("none.toml", "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\n");
    scratch.run(&["motor", "none.toml"]).fails(78, &["no output of kind drive", "actuator = "]);
    scratch.run(&["motor", "one.toml", "--csv", "one.toml"]).fails(2, &["`one.toml` is read for this"]);
    let current = format!("{RIG}{WRIST}").replace("gain = 4\n", "gain = 0.1\ndrive = \"current\"\n");
    scratch.write("amperes.toml", current);
    let run = scratch.run(&["motor", "amperes.toml", "--drive", "0.05:0.1"]);
    assert!(run.succeeds().err.is_empty(), "{}", run.err);
    scratch
        .run(&["motor", "amperes.toml", "--drive", "0.05:3V"])
        .fails(2, &["the course has 3 V, and the amplifier imposes a current", "0.1A"]);
    scratch.run(&["motor", "amperes.toml", "--coupling", "10"]).fails(2, &["impose a voltage"]);
}

/// At a current, clicks are those that it drives, within its volts; the bursts beside them are at a voltage, and that is said.
#[test]
fn a_motor_at_a_current_clicks_by_its_current() {
    let scratch = Scratch::new("motor-current");
    let amplifier = "gain = 0.2\ndrive = \"current\"\nmax_amperes = 0.25\n";
    scratch.write("amperes.toml", format!("{RIG}{PALM}").replace("gain = 4\n", amplifier));
    let run = scratch.run(&["motor", "amperes.toml", "--json"]);
    assert!(
        run.succeeds().err.contains("the bursts that are compared here are driven by voltage"),
        "{}",
        run.err
    );
    let said = run.json();
    let rig = pacinian::rig::Rig::parse(
        "amperes.toml",
        std::fs::read(scratch.0.join("amperes.toml")).unwrap().as_slice(),
    );
    let rig = rig.unwrap_or_else(|p| panic!("{p}")).value;
    let p = rig.actuators.iter().find(|a| a.name == "big").unwrap().rumble_motor().unwrap();
    let rows = clicks(&bench(&p, 1e-4, false), 0.25, Drive::Current { amperes: 0.25, limit: 5.0 }).unwrap();
    let ways = said["ways"].as_array().unwrap();
    let of = |row: &Row| ways.iter().find(|said| said["way"] == row.way.word()).unwrap().clone();
    rows.iter().for_each(|row| same_way(&of(row), row));
    // At as many volts as those it may have, it would be another.
    let volts = clicks(&bench(&p, 1e-4, false), 0.25, Drive::Voltage(5.0)).unwrap();
    assert_ne!(of(&volts[0])["peak"].as_f64(), Some(volts[0].done.as_ref().unwrap().figures.peak));
}

/// A patch on a rig: what it does to the motor is what the same drive does on the bench, which shares no code with it but the motor's model.
#[test]
fn a_patch_moves_a_motor_as_its_drive_does() {
    let scratch = Scratch::new("motor-patch");
    scratch.write("rig.toml", format!("{RIG}{WRIST}{PALM}").replace("tilt = 1.0\n", ""));
    let voice = |name: &str, node: &str| {
        format!("[voice.{name}]\noutput = \"go\"\n[voice.{name}.nodes]\ngo = {node}\n")
    };
    let swell = "{ type = \"envelope\", attack = 0.1, decay = 0.05, sustain = 0.6, release = 0.1 }";
    let patch = [
        "format = \"pacinian-patch/1\"\ntitle = \"Moves\"\n".to_string(),
        voice("plain", "{ type = \"drive-on\" }"),
        voice("buzz", "{ type = \"drive-spin\", level = 0.5 }"),
        voice("swell", swell),
        "[pattern.p]\ntime = \"seconds\"\nevents = [\n{ at = 0.1, voice = \"plain\", place = \"wrist\", duration = 0.1 },\n\
         { at = 0.7, voice = \"buzz\", place = \"wrist\", duration = 0.2 },\n\
         { at = 1.3, voice = \"swell\", place = \"wrist\", duration = 0.4 },\n]\n".to_string(),
    ]
    .concat();
    scratch.write("patch.toml", &patch);
    let base = ["motor", "rig.toml", "--output", "wrist", "--patch", "patch.toml"];
    let said = scratch
        .run(&[&base[..], &["--json", "--plot", "p.svg", "--csv", "p.csv"]].concat())
        .succeeds()
        .json();
    let stretches = said["ways"][0]["stretches"].as_array().unwrap();
    assert_eq!(stretches.len(), 3);
    assert_eq!(
        stretches.iter().map(|s| s["voices"][0].as_str().unwrap()).collect::<Vec<_>>(),
        ["plain", "buzz", "swell"]
    );
    let bench = scratch
        .run(&["motor", "rig.toml", "--output", "wrist", "--drive", "0.1:4, short", "--json"])
        .succeeds()
        .json();
    let (way, plain) = (&bench["ways"][0], &stretches[0]);
    let number = |value: &Value| value.as_f64().unwrap();
    for (is, due, within) in [
        (number(&plain["peak"]), number(&way["peak"]), 0.01),
        (number(&plain["turns"]), number(&way["turns"]), 1e-3),
        (number(&plain["energy"]), number(&way["energy"]["supplied"]), 2e-3),
        (number(&plain["stop"]), number(&way["stop"]), 0.02),
        (number(&plain["peak_at"]) - number(&plain["at"]), number(&way["peak_at"]), 0.01),
    ] {
        assert!((is / due - 1.0).abs() < within, "{is} {due}: {plain} {way}");
    }
    // A spin wishes for the root of its share of the rated speed; when the motor is that fast stands in the table.
    let csv = std::fs::read_to_string(scratch.0.join("p.csv")).unwrap();
    assert!(csv.starts_with("seconds,drive,rad_per_s,wanted_rad_per_s,m_per_s2,rad,N_m\n"), "{}", &csv[..80]);
    let rows: Vec<Vec<f64>> =
        csv.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap()).collect()).collect();
    let buzz = &stretches[1];
    let at = |n: usize| rows[n][0];
    let from = rows.iter().position(|row| row[0] > 0.69 && row[3] > 0.0).unwrap();
    let wished = bench["motor"]["rated_speed"].as_f64().unwrap() * 0.5_f64.sqrt();
    assert!((rows[from + 100][3] / wished - 1.0).abs() < 1e-6, "{} {wished}", rows[from + 100][3]);
    for (key, share) in [("rise_50", 0.5), ("rise_90", 0.9)] {
        let n = (from..rows.len()).find(|n| rows[*n][2].powi(2) >= share * wished * wished).unwrap();
        assert!((number(&buzz[key]) - (at(n) - at(from) + 1.0 / 48_000.0)).abs() < 3e-5, "{key}");
    }
    // Angle is the sum of speed; and what coil and friction do to the rotor they do to the casing the other way.
    let (p, step) = (coin(), 1.0 / 48_000.0);
    let p = Parameters { casing: motor::Casing::Free { mass: 0.05 }, ..p };
    let (mut turned, mut seen) = (0.0, 0);
    let largest = rows.iter().fold(0.0_f64, |most, row| most.max(row[6].abs()));
    for n in 1..rows.len() - 1 {
        turned += 0.5 * step * (rows[n - 1][2] + rows[n][2]);
        assert!((rows[n][5] - turned).abs() < 2e-2, "{n}: {} {turned}", rows[n][5]);
        let steady = (n.saturating_sub(20)..(n + 20).min(rows.len())).all(|m| rows[m][1] == rows[n][1]);
        if steady && rows[n][2].abs() > 100.0 {
            let alpha = (rows[n + 1][2] - rows[n - 1][2]) / (2.0 * step);
            let due = -p.effective_inertia() * alpha;
            assert!((rows[n][6] - due).abs() < 5e-3 * largest, "{n}: {} {due}", rows[n][6]);
            seen += 1;
        }
    }
    assert!(seen > 2000, "{seen}");
    let (begin, end) = (number(&plain["at"]), number(&plain["at"]) + number(&plain["seconds"]));
    let within: Vec<&Vec<f64>> =
        rows.iter().filter(|row| row[0] > begin + 0.5 * step && row[0] < end + 0.5 * step).collect();
    let most = within.iter().fold(0.0_f64, |most, row| most.max(row[6].abs()));
    assert!((number(&plain["peak_reaction"]) / most - 1.0).abs() < 1e-5, "{plain} {most}");
    let last = within.last().unwrap()[5] - number(&plain["angle"]);
    let whole = (last / std::f64::consts::TAU).round() * std::f64::consts::TAU;
    assert!((last - whole).abs() < 1e-6 && number(&plain["angle"]).abs() <= std::f64::consts::PI);
    // An envelope that the motor can follow is followed.
    assert!(number(&stretches[2]["error"]) < 0.1, "{}", stretches[2]);
    roxmltree::Document::parse(&std::fs::read_to_string(scratch.0.join("p.svg")).unwrap()).unwrap();
    // Side by side: what overdrives is sooner there than what holds the speed.
    let said =
        scratch.run(&[&base[..], &["--shaping", "plain,overdrive", "--json"]].concat()).succeeds().json();
    let rise = |n: usize| number(&said["ways"][n]["stretches"][2]["rise_50"]);
    assert_eq!(
        (&said["ways"][0]["shaping"], &said["ways"][1]["shaping"]),
        (&"plain".into(), &"overdrive".into())
    );
    assert!(rise(1) < rise(0), "{} {}", rise(0), rise(1));
    let text = scratch.run(&base).succeeds().out.clone();
    for word in ["patch.toml of", "to 90 %", "mJ in", "buzz", "at level", "gravity: nobody said how"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    for (words, code, why) in [
        (
            &["motor", "coin-10mm", "--patch", "patch.toml"][..],
            2,
            &["is a part", "--output NAME --patch PATCH"][..],
        ),
        (&[&base[..], &["--turns", "1"]].concat(), 2, &["--turns is of the comparison", "--patch"]),
        (&[&base[..], &["--shaping", "plane"]].concat(), 2, &["`plane` is no shaping", "on-off"]),
        (&[&base[..], &["--duration", "90"]].concat(), 2, &["at most 60 s"]),
        (&["motor", "coin-10mm", "--pattern", "p"], 2, &["--patch"]),
        (
            &["motor", "rig.toml", "--output", "palm", "--patch", "patch.toml"],
            65,
            &["nothing in patch.toml is played on `palm`"],
        ),
        (&["motor", "rig.toml", "--output", "wrist", "--patch", "gone.toml"], 66, &["gone.toml"]),
    ] {
        scratch.run(words).fails(code, why);
    }
}

/// However late a shaping is, what it is wanted to do stands where the patch has it, and so what it does is measured by its own wish.
#[test]
fn shapings_side_by_side_have_one_wish() {
    let scratch = Scratch::new("motor-side");
    scratch.write("rig.toml", format!("{RIG}{WRIST}"));
    scratch.write(
        "patch.toml",
        "format = \"pacinian-patch/1\"\ntitle = \"Swells\"\n[voice.swell]\noutput = \"go\"\n[voice.swell.nodes]\n\
         go = { type = \"envelope\", attack = 0.15, decay = 0.05, sustain = 0.6, release = 0.15 }\n\
         [pattern.p]\ntime = \"seconds\"\nevents = [{ at = 0.5, voice = \"swell\", place = \"wrist\", duration = 0.4 }]\n",
    );
    let words = ["motor", "rig.toml", "--output", "wrist", "--patch", "patch.toml", "--shaping"];
    let more = ["plain,inverse,switching", "--json", "--csv", "w.csv", "--plot", "w.svg"];
    let said = scratch.run(&[&words[..], &more].concat()).succeeds().json();
    let number = |way: usize, key: &str| said["ways"][way][key].as_f64().unwrap();
    // The inverse must know ahead how to brake; the others do not.
    assert!(number(1, "late") > number(0, "late") + 0.01 && number(0, "late") == number(2, "late"), "{said}");
    let stretch = |way: usize, key: &str| said["ways"][way]["stretches"][0][key].as_f64().unwrap();
    assert!(stretch(1, "error") < 0.01 && stretch(0, "error") > 0.1, "{said}");
    let csv = std::fs::read_to_string(scratch.0.join("w.csv")).unwrap();
    let heads: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> =
        csv.lines().skip(1).map(|line| line.split(',').map(|x| x.parse().unwrap_or(0.0)).collect()).collect();
    let column = |name: &str| heads.iter().position(|head| *head == name).unwrap();
    let wanted = ["plain", "inverse", "switching"].map(|way| column(&format!("{way}_wanted_rad_per_s")));
    for row in &rows {
        assert_eq!((row[wanted[0]], row[wanted[0]]), (row[wanted[1]], row[wanted[2]]), "at {} s", row[0]);
    }
    // Six frames make an engine sample, and a corner is band-limited over some of them.
    let begins = rows.iter().find(|row| row[wanted[0]] > 0.0).unwrap()[0];
    assert!((begins - 0.5).abs() <= 24.0 / 48_000.0, "{begins}");
    // Where its speed is most like what is wanted, the inverse is neither early nor late.
    let is = column("inverse_rad_per_s");
    let off = |shift: i64| {
        let of = |n: usize| rows.get((n as i64 + shift) as usize).map_or(0.0, |row| row[is]);
        (0..rows.len()).map(|n| (of(n) - rows[n][wanted[1]]).powi(2)).sum::<f64>()
    };
    let best = (-480..=480).step_by(6).min_by(|a, b| off(*a).total_cmp(&off(*b))).unwrap();
    assert!(best.abs() <= 12, "{best} frames");
    let svg = std::fs::read_to_string(scratch.0.join("w.svg")).unwrap();
    // One line in the key, and one for each of the two quantities of which something is wanted.
    let broad = svg.matches("stroke-width=\"5\"").count();
    assert_eq!(broad, 3, "{svg}");
    assert!(svg.contains("sent later by: plain") && svg.contains("inverse"), "{svg}");
    // Nothing shifts a single one either.
    let alone = scratch.run(&[&words[..], &["inverse", "--json"]].concat()).succeeds().json();
    assert_eq!(alone["ways"][0], said["ways"][1]);
}

/// A motor that is known from outside has no amperes and no joules, unless its resistance is known.
#[test]
fn what_is_not_known_is_not_told() {
    let scratch = Scratch::new("motor-outside");
    let outside = "model = \"rumble-motor\"\nrated_volts = 3\ntime_constant = 0.0347\nspeed_per_volt = 600\nrunning_volts = 0.4\n\
                   eccentric_per_mass = 7.3e-6\n";
    let rig = |more: &str| {
        RIG.replace("part = \"coin-10mm\"\nmax_volts = 4\nmass = 0.05\n", &format!("{outside}{more}")) + WRIST
    };
    scratch.write("a.toml", rig(""));
    let said = scratch.run(&["motor", "a.toml", "--json"]).succeeds().json();
    assert!(said["motor"]["running_amperes"].is_null() && said["ways"][0]["energy"].is_null());
    let text = scratch.run(&["motor", "a.toml"]).succeeds().out.clone();
    assert!(text.contains("no amperes and no joules"), "{text}");
    scratch.write("b.toml", rig("resistance = 30\n"));
    let with = scratch.run(&["motor", "b.toml", "--json"]).succeeds().json();
    // At a standstill V/R, and V² t/R comes in at most.
    same(&with["motor"]["standstill_amperes"], Some(3.0 * (1.0 / 30.0)), "amperes");
    // How much of what slows it down is back-EMF is not known, nor what its mass weighs beside its torques: neither is made up.
    assert!(with["motor"]["running_amperes"].is_null() && with["ways"][0]["energy"].is_null());
    assert!(with["ways"][0]["peak_reaction"].is_null() && with["motor"]["gravity"].is_null());
    let left = with["computed"]["left_out"].as_array().unwrap();
    assert!(
        left.iter().any(|left| left.as_str().unwrap().contains("gravity: what the mass weighs")),
        "{left:?}"
    );
    scratch.run(&["motor", "b.toml"]).succeeds();
    let level = scratch.run(&["motor", "b.toml", "--tilt", "1.5707963267948966", "--json"]).succeeds().json();
    assert_eq!(with["ways"], level["ways"], "as where nothing pulls in its plane");
    for mode in [&["--drive", "0.02:3, short", "--csv", "d.csv"][..], &[]] {
        scratch.run(&[&["motor", "b.toml"][..], mode].concat()).succeeds();
    }
    let csv = std::fs::read_to_string(scratch.0.join("d.csv")).unwrap();
    let row: Vec<&str> = csv.lines().nth(100).unwrap().split(',').collect();
    assert!(row[2].is_empty() && row[6].is_empty() && !row[5].is_empty(), "{row:?}");
}

/// A motor that is known from outside moves as its twin that is known from inside, gravity aside, and says that its `tilt` is of no use.
#[test]
fn from_outside_it_moves_alike_and_tilt_counts_for_nothing() {
    let scratch = Scratch::new("motor-twin");
    let p = coin();
    let inside = Parameters {
        inductance: 0.0,
        casing: motor::Casing::Suspended {
            mass: 0.05,
            across: motor::Suspension { stiffness: 0.0, damping: 0.0 },
            upright: motor::Suspension { stiffness: 0.0, damping: 0.0 },
        },
        ..p
    };
    let outside = format!(
        "model = \"rumble-motor\"\nrated_volts = 3\nmax_volts = 4\nmass = 0.05\nresistance = {}\ntime_constant = {}\n\
         speed_per_volt = {}\nrunning_volts = {}\nstart_volts = {}\neccentric_per_mass = {}\n",
        p.resistance,
        inside.mechanical_time(),
        p.gain / (p.resistance * p.damping()),
        p.running_volts(),
        p.stiction * p.resistance / p.gain,
        p.eccentric / 0.05,
    );
    let rig = RIG.replace("part = \"coin-10mm\"\nmax_volts = 4\nmass = 0.05\n", &outside) + WRIST;
    scratch.write("twin.toml", rig);
    let said = scratch.run(&["motor", "twin.toml", "--drive", "0.05:3, short", "--json"]).succeeds().json();
    let plan = Plan::choose(&inside, 48_000.0, &motor::Wish { error: 1e-4, posture: false, casing: true });
    let due = Bench::new(&Parameters { gravity: 0.0, ..inside }, plan, 48_000.0, 0.0).unwrap();
    let course = Course::ending_in(Drive::SHORT).then(0.05, Drive::Voltage(3.0));
    let due = own(&due, &course).done.unwrap();
    let close =
        |said: &Value, due: f64| assert!((said.as_f64().unwrap() / due - 1.0).abs() < 1e-9, "{said} {due}");
    close(&said["ways"][0]["peak"], due.figures.peak);
    close(&said["ways"][0]["stop"], due.figures.stop.unwrap());
    close(&said["ways"][0]["turns"], due.run.turns);
    let check = scratch.run(&["motor", "twin.toml"]);
    assert!(check.succeeds().err.contains("`tilt`, which counts for nothing"), "{}", check.err);
}

#[test]
fn what_is_no_good_is_named() {
    let scratch = Scratch::new("motor-bad");
    for (words, code, said) in [
        (&["motor", "coin-11mm"][..], 66, &["`coin-11mm` is no part", "did you mean `coin-10mm`?"][..]),
        (&["motor", "none.toml"], 66, &["`none.toml` is not there"]),
        (&["motor", "coin-10mm", "--output", "x"], 2, &["is a part, which has no output `x`"]),
        (&["motor", "coin-10mm", "--level", "1.5"], 2, &["`level` is 1.5", "within 0.0001 and 1", "--level"]),
        (&["motor", "coin-10mm", "--seconds", "-1"], 2, &["`seconds` is -1", "--seconds"]),
        (&["motor", "coin-10mm", "--turns", "0"], 2, &["`turns` is 0", "--turns"]),
        (&["motor", "coin-10mm", "--turns", "nan"], 2, &["`turns` is NaN"]),
        (&["motor", "coin-10mm", "--volts", "-3"], 2, &["`volts` is -3", "--volts"]),
        (&["motor", "coin-10mm", "--angle", "inf"], 2, &["`angle` is inf", "--angle"]),
        (&["motor", "coin-10mm", "--tilt", "nan"], 2, &["a tilt of NaN rad"]),
        (
            &["motor", "coin-10mm", "--tilt", "1e300"],
            2,
            &["a tilt of 1e300 rad is none", "within -4 and 4 rad"],
        ),
        (&["motor", "coin-10mm", "--error", "0"], 2, &["an error of 0", "--error"]),
        (&["motor", "coin-10mm", "--rate", "100"], 2, &["--rate"]),
        (&["motor", "coin-10mm", "--drive", "3"], 0, &[]),
        (&["motor", "coin-10mm", "--drive", "3, 0.1:2"], 2, &["`3` does not say for how long"]),
        (&["motor", "coin-10mm", "--drive", "0.1:x"], 2, &["`x` is neither volts"]),
        (&["motor", "coin-10mm", "--drive", "0.1:3", "--level", "0.5"], 2, &["--level is of the comparison"]),
        (
            &["motor", "coin-10mm", "--drive", "0.1:3", "--coupling", "10"],
            2,
            &["--coupling is for the click"],
        ),
        (&["motor", "coin-10mm", "--coupling", "10,0"], 2, &["`0` is no corner"]),
        (&["motor", "coin-10mm", "--plot", "x.png"], 2, &["pictures are SVG, not png"]),
        (&["motor", "coin-10mm", "--csv", "-"], 2, &["--csv out.csv"]),
        (&["motor", "coin-10mm", "--plot", "no/x.svg"], 73, &["no/x.svg"]),
        (&["motor", "coin-10mm", "--plot", "x", "--csv", "x"], 2, &["cannot be one file"]),
    ] {
        let run = scratch.run(words);
        assert_eq!(run.code, Some(code), "{words:?}: {}{}", run.out, run.err);
        said.iter().for_each(|word| assert!(run.err.contains(word), "{words:?}: {word}: {}", run.err));
    }
    // A figure that cannot be is told as such, and not as one that is missing.
    let rig = |figure: &str| {
        format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 1\nfull_scale_volts = 5.0\ncoupling = \"dc\"\n\
             [amplifier.a]\ngain = 2.5\nmax_volts = 12.5\ncoupling = \"dc\"\n[actuator.m]\nmodel = \"rumble-motor\"\n\
             rated_volts = 12.5\ntorque_constant = 0.011\ninertia = 1.15e-7\neccentric_moment = 1.38e-5\n{figure}\n\
             [[output]]\nkind = \"drive\"\nname = \"m\"\nchannel = 1\nactuator = \"m\"\namplifier = \"a\"\n"
        )
    };
    scratch.write("none.toml", rig(""));
    scratch.run(&["motor", "none.toml"]).fails(78, &["actuator `m` lacks `resistance`"]);
    for (figure, said) in [
        ("resistance = 0", "`resistance` of actuator `m` is 0"),
        ("resistance = nan", "`resistance` of actuator `m` is nan"),
        ("resistance = -1e300", "`resistance` of actuator `m` is -1e300"),
    ] {
        scratch.write("amiss.toml", rig(figure));
        let run = scratch.run(&["motor", "amiss.toml"]);
        run.fails(78, &[said, "from 0.001 to"]);
        assert!(!run.err.contains("lacks"), "{figure}: {}", run.err);
    }
    // What cannot be done stands in its row, and the others are there.
    let weak = scratch.run(&["motor", "coin-10mm", "--volts", "0.3", "--level", "0.5"]);
    assert!(weak.succeeds().out.contains("0.3 V do not start the motor"), "{}", weak.out);
}

#[test]
fn picture_and_table_hold_what_was_computed() {
    let scratch = Scratch::new("motor-plot");
    scratch.run(&["motor", "coin-10mm", "--level", "0.5", "--plot", "a.svg", "--csv", "a.csv"]).succeeds();
    let svg = std::fs::read_to_string(scratch.0.join("a.svg")).unwrap();
    let document = roxmltree::Document::parse(&svg).unwrap();
    let texts: Vec<&str> = document.descendants().filter_map(|n| n.text()).collect();
    for word in [
        "wanted",
        "plain",
        "overdrive",
        "inverse",
        "switching",
        "click",
        "pulse",
        "drive (V)",
        "speed (rad/s)",
        "acceleration (m/s2)",
    ] {
        assert!(texts.contains(&word), "{word}: {texts:?}");
    }
    let csv = std::fs::read_to_string(scratch.0.join("a.csv")).unwrap();
    let lines: Vec<Vec<&str>> = csv.lines().map(|line| line.split(',').collect()).collect();
    let bench = bench(&coin(), 1e-4, false);
    let rows =
        bursts(&bench, &Wish { level: 0.5, seconds: 0.1, envelope: Envelope::Rectangle }, 3.0).unwrap();
    let inverse = &rows[2].done.as_ref().unwrap().run.traces;
    let column = lines[0].iter().position(|name| *name == "inverse_rad_per_s").unwrap();
    assert!(lines.iter().all(|line| line.len() == lines[0].len()));
    for n in [0, 999, 4799, inverse.speeds.len() - 1] {
        let value: f64 = lines[n + 1][column].parse().unwrap();
        assert!((value - inverse.speeds[n]).abs() < 1e-8, "{n}: {value}");
        let time: f64 = lines[n + 1][0].parse().unwrap();
        assert!((time - (n + 1) as f64 / 48_000.0).abs() < 1e-9);
    }
    // What has ended is empty, not 0.
    assert_eq!(lines[inverse.speeds.len() + 1][column], "");
}

#[test]
fn coils_have_resonance_bursts_and_an_equaliser() {
    let scratch = Scratch::new("motor-coil");
    let rig = |actuator: &str| {
        format!(
            "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\n[actuator.a]\n{actuator}\n\
             [[tactor]]\nname = \"l\"\nchannel = 1\nactuator = \"a\"\n[[tactor]]\nname = \"r\"\nchannel = 2\nactuator = \"a\"\n"
        )
    };
    let lra = "model = \"lra\"\nresonance = 175\nq = 15\nrated_volts = 2\nmax_volts = 3\nrated_acceleration = 12\ntest_mass = 0.1\n\
               device_mass = 2.5e-3\nslug_mass = 1.5e-3\nresistance = 25";
    scratch.write("lra.toml", rig(lra));
    let said =
        scratch.run(&["motor", "lra.toml", "--json", "--plot", "a.svg", "--csv", "a.csv"]).succeeds().json();
    let read = pacinian::Rig::parse("r", rig(lra).as_bytes()).unwrap().value;
    let plant = read.actuators[0].coil().unwrap();
    let due = shakes(&plant, [2.0, 3.0], 0.1, 48_000.0).unwrap();
    for (said, due) in said["bursts"].as_array().unwrap().iter().zip(&due) {
        assert_eq!(said["way"], due.name);
        same(&said["rise_90"], due.rise, due.name);
        same(&said["stop"], Some(due.stop), due.name);
        same(&said["left"], Some(due.left), due.name);
    }
    let pole = plant.resonance(Imposes::Voltage).unwrap();
    same(&said["shorted"]["q"], Some(pole.q), "q");
    assert!((said["rated_acceleration"].as_f64().unwrap() - 12.0).abs() < 1e-6, "{said}");
    assert!(said["equaliser"]["boost_db"].is_f64());
    let csv = std::fs::read_to_string(scratch.0.join("a.csv")).unwrap();
    assert!(csv.starts_with("seconds,plain_volts,plain_m_per_s2,overdrive_volts,"), "{}", &csv[..80]);
    roxmltree::Document::parse(&std::fs::read_to_string(scratch.0.join("a.svg")).unwrap()).unwrap();
    let text = scratch.run(&["motor", "lra.toml"]).succeeds().out.clone();
    for word in ["175.0 Hz", "Q 15.00", "settled", "with the equaliser: resonance moved from 175.0 Hz"] {
        assert!(text.contains(word), "{word}: {text}");
    }
    scratch.run(&["motor", "lra.toml", "--tilt", "0"]).fails(2, &["--tilt is of rumble motors"]);
    // The picture of the response has the resonance at its mark, and both curves.
    scratch.run(&["motor", "lra.toml", "--response", "r.svg"]).succeeds();
    let drawn = std::fs::read_to_string(scratch.0.join("r.svg")).unwrap();
    roxmltree::Document::parse(&drawn).unwrap();
    for word in [
        "175.0 Hz, Q 15.00",
        "as it is",
        "with the equaliser",
        "frequency (Hz)",
        "Equaliser: resonance moved",
    ] {
        assert!(drawn.contains(word), "{word}");
    }
    scratch.run(&["motor", "coin-10mm", "--response", "c.svg"]).fails(2, &["--response is of voice coils"]);
    scratch
        .run(&["motor", "lra.toml", "--response", "r.svg", "--plot", "r.svg"])
        .fails(2, &["cannot be one file", "another for --response"]);
    scratch.write("bare.toml", rig("model = \"lra\"\nresonance = 175\nrated_volts = 2"));
    scratch.run(&["motor", "bare.toml"]).fails(
        78,
        &["`q`", "`rated_acceleration`", "`slug_mass`", "`resistance`", "[actuator.a]", "q = ..."],
    );
    scratch.write("piezo.toml", rig("model = \"piezo\""));
    scratch.run(&["motor", "piezo.toml", "--output", "l"]).fails(78, &["of model piezo", "are simulated"]);
    // A stiff skin leaves nothing to swing: said, and the rest is there.
    let dull = "model = \"voice-coil\"\nresonance = 230\nq = 0.1\nresistance = 7\nforce_factor = 1.2\nmoving_mass = 1.5e-3\nrated_volts = 1";
    scratch.write("dull.toml", rig(dull));
    let dull = scratch.run(&["motor", "dull.toml"]);
    assert!(dull.succeeds().out.contains("no bursts: `q`"), "{}", dull.out);
}

/// The table has where the mass is and what torque the casing gets; the answer has the last and the largest of them; and a wish that is beyond the finest level
/// is said not to be reached.
#[test]
fn angle_torque_and_an_unreachable_wish_are_told() {
    let scratch = Scratch::new("motor-angle");
    let p = coin();
    let words = [
        "motor",
        "coin-10mm",
        "--drive",
        "0.05:3, 0.03:-2, short",
        "--angle",
        "0.3",
        "--csv",
        "t.csv",
        "--json",
    ];
    let said = scratch.run(&words).succeeds().json();
    let csv = std::fs::read_to_string(scratch.0.join("t.csv")).unwrap();
    let heads: Vec<&str> = csv.lines().next().unwrap().split(',').collect();
    let column = |name: &str| -> Vec<f64> {
        let at = heads.iter().position(|head| *head == name).unwrap_or_else(|| panic!("{name}: {heads:?}"));
        csv.lines().skip(1).filter_map(|line| line.split(',').nth(at).and_then(|x| x.parse().ok())).collect()
    };
    let [time, speed, angle, torque] = ["seconds", "drive_rad_per_s", "drive_rad", "drive_N_m"].map(column);
    assert!(torque.len() == speed.len() && torque.len() > 4000);
    let step = time[1] - time[0];
    // The speed is the angle's slope; and what speeds the rotor up acts on the casing the other way, wherever the drive does not change and it turns.
    let (mut turned, mut largest) = (0.3, 0.0_f64);
    let mut last = 0.0;
    for n in 0..speed.len() {
        turned += 0.5 * step * (last + speed[n]);
        last = speed[n];
        assert!((angle[n] - turned).abs() < 1e-2, "{n}: {} for {turned}", angle[n]);
        largest = largest.max(torque[n].abs());
    }
    let close = |n: usize, within: f64| {
        let slope = (speed[n + 1] - speed[n - 1]) / (2.0 * step);
        let due = -p.effective_inertia() * slope;
        assert!((torque[n] - due).abs() < within * largest, "{n}: {} for {due}", torque[n]);
    };
    let at = |seconds: f64| (seconds / step) as usize;
    [at(0.01), at(0.03), at(0.045), at(0.055), at(0.065)].into_iter().for_each(|n| close(n, 2e-3));
    let way = &said["ways"][0];
    let end = angle[angle.len() - 1];
    let within = (way["angle"].as_f64().unwrap() - end) / std::f64::consts::TAU;
    assert!(
        (within - within.round()).abs() < 1e-6
            && way["angle"].as_f64().unwrap().abs() <= std::f64::consts::PI
    );
    assert!((way["peak_reaction"].as_f64().unwrap() / largest - 1.0).abs() < 1e-5, "{way}");
    assert!(said["computed"]["reached"] == true && said["computed"]["error"] == 0.0, "{}", said["computed"]);
    let fine = ["motor", "coin-10mm", "--tilt", "0", "--error", "1e-12"];
    let plain = scratch.run(&fine);
    assert!(plain.succeeds().err.contains("an error of 1e-12 is not reached"), "{}", plain.err);
    assert!(plain.out.contains("are reached"), "{}", plain.out);
    let said = scratch.run(&[&fine[..], &["--json"]].concat()).succeeds().json();
    let computed = &said["computed"];
    assert!(computed["level"] == "fine" && computed["reached"] == false, "{computed}");
    assert!(computed["error"].as_f64().unwrap() > 1e-12, "{computed}");
}
