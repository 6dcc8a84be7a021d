//! Rigs.

use pacinian::patch::Patch;
use pacinian::rig::{Coupling, Drive, Model, OutputKind, Rig};

use super::assert_told;

const HEAD: &str = "format = \"pacinian-rig/1\"\n[device]\nchannels = 8\n";

/// A rig with everything in it.
pub const FULL: &str = r#"#:schema ../schema/rig.json
format = "pacinian-rig/1"
title = "A belt"
description = "Two tactors."
[device]
name = "card"
channels = 8
rate = 48000
full_scale_volts = 1.4
coupling = { high_pass = 8.0 }
[amplifier.class-d]
gain = 6.0
max_volts = 5.0
drive = "current"
max_amperes = 1.0
[actuator.exciter]
model = "inertial-motor"
resonance = 65.0
q = 2.0
rated_volts = 3.0
equaliser = [{ frequency = 65, gain_db = -6 }]
[[tactor]]
name = "top"
channel = 3
position = [0.0, 0.2]
actuator = "exciter"
amplifier = "class-d"
gain = 0.5
polarity = -1
[[tactor]]
name = "low"
channel = 1
[[output]]
kind = "trigger"
name = "sync"
channel = 8
marker = "go"
pulse = 0.01
[[output]]
kind = "raw"
name = "audio"
channel = 7
polarity = "invert"
"#;

#[test]
fn reads_everything() {
    let checked = Rig::parse("full.toml", FULL.as_bytes()).unwrap_or_else(|p| panic!("{p}"));
    assert_eq!(checked.warnings.list, []);
    let rig = checked.value;
    assert_eq!((rig.device.channels, rig.device.rate), (8, Some(48000.0)));
    assert_eq!(
        (rig.device.full_scale_volts, rig.device.coupling),
        (Some(1.4), Some(Coupling::HighPass(8.0)))
    );
    let amplifier = rig.amplifier("class-d").unwrap();
    assert_eq!((amplifier.gain, amplifier.drive, amplifier.max_amperes), (6.0, Drive::Current, Some(1.0)));
    let exciter = rig.actuator("exciter").unwrap();
    assert_eq!(exciter.model, Model::InertialMotor);
    assert_eq!((exciter.value("resonance"), exciter.value("q")), (Some(65.0), Some(2.0)));
    assert_eq!((exciter.equaliser[0].gain_db, exciter.equaliser[0].q), (-6.0, 1.0));
    let [top, low, sync, audio] = rig.outputs.as_slice() else { panic!("four outputs") };
    assert_eq!((top.name.as_str(), top.channel, top.gain, top.inverted), ("top", 3, 0.5, true));
    assert_eq!((top.position, low.position), (Some([0.0, 0.2, 0.0]), None));
    assert_eq!(sync.kind, OutputKind::Trigger { marker: Some("go".into()), pulse: 0.01 });
    assert_eq!((&audio.kind, audio.inverted), (&OutputKind::Raw, true));
}

#[test]
fn every_mistake_is_told_at_its_line() {
    let tactor = "[[tactor]]\nname = \"a\"\nchannel = 1\n";
    let cases: &[(String, &[(usize, &str)])] = &[
        (
            "[[tactor]]\nname = \"a\"\nchannel = 9".into(),
            &[(6, "output `a` is on channel 9, the device has 8")],
        ),
        (
            "[[tactor]]\nname = \"a\"\nchannel = 0".into(),
            &[(6, "is 0; it must be a whole number from 1 to 4096")],
        ),
        ("[[tactor]]\nname = \"a\"\nchannel = 1.5".into(), &[(6, "is 1.5; it must be a whole number")]),
        ("[[tactor]]\nchannel = 1".into(), &[(4, "tactor 1 lacks `name`")]),
        ("[[tactor]]\nname = \"a b\"\nchannel = 1".into(), &[(5, "the name of tactor `a b` cannot be used")]),
        (
            format!("{tactor}[[tactor]]\nname = \"b\"\nchannel = 1"),
            &[(9, "outputs `a` and `b` are both on channel 1")],
        ),
        (
            format!("{tactor}[[tactor]]\nname = \"a\"\nchannel = 2"),
            &[(7, "there are two outputs called `a`")],
        ),
        (format!("{tactor}actuator = \"x\""), &[(4, "describe it under [actuator.x]")]),
        (
            format!("{tactor}amplifier = \"clas-d\"\n[amplifier.class-d]\ngain = 1"),
            &[(4, "did you mean `class-d`?")],
        ),
        (format!("{tactor}postion = [0, 0]"), &[(7, "did you mean `position`?")]),
        (format!("{tactor}position = [0, nan]"), &[(7, "every coordinate must be a number")]),
        (format!("{tactor}polarity = 2"), &[(7, "it must be 1, -1 or \"invert\"")]),
        (format!("{tactor}gain = inf"), &[(7, "is inf; it must be")]),
        ("[actuator.x]\nmodel = \"voice coil\"".into(), &[(5, "did you mean `voice-coil`?")]),
        (
            "[actuator.x]\nequaliser = [{ frequency = 60 }]".into(),
            &[(5, "filter 1 of actuator `x` lacks `gain_db`")],
        ),
        (
            "[amplifier.x]\ndrive = \"power\"".into(),
            &[(4, "lacks `gain`"), (5, "there are `bridge`, `carrier`, `current` and `voltage`")],
        ),
        (
            "[[output]]\nname = \"a\"\nchannel = 1\nkind = \"raw\"\npulse = 1".into(),
            &[(8, "only a trigger has `pulse`")],
        ),
        (
            "[[output]]\nname = \"a\"\nchannel = 1\nkind = \"raw\"\ndc = true".into(),
            &[(8, "output 1 is of kind raw; only vibration has `dc`")],
        ),
        (format!("{tactor}dc = 1"), &[(7, "`dc` of tactor 1")]),
        (format!("{tactor}max_level = 0"), &[(7, "`max_level` of tactor 1 is 0; it must be")]),
        (format!("{tactor}max_level = 1.1"), &[(7, "is 1.1; it must be")]),
        (format!("{tactor}max_level = nan"), &[(7, "`max_level` of tactor 1")]),
        ("[[output]]\nname = \"a\"\nchannel = 1".into(), &[(4, "output 1 lacks `kind`")]),
        ("tactor = 3".into(), &[(4, "the device has no key `tactor`")]),
    ];
    for (bad, expected) in cases {
        let source = format!("{HEAD}{bad}\n");
        match Rig::parse("bad.toml", source.as_bytes()) {
            Ok(_) => panic!("accepted:\n{source}"),
            Err(problems) => assert_told(&source, &problems, expected),
        }
    }
    for (device, fragment) in [
        ("channels = 0", "from 1 to 4096"),
        ("channels = 5000", "from 1 to 4096"),
        ("channels = 2\ncoupling = \"ac\"", "it must be \"dc\" or"),
        ("channels = 2\ncoupling = { high_pass = 0 }", "`high_pass` of `coupling` of the device"),
        ("channels = 2\nmax_level = 2", "`max_level` of the device"),
        ("rate = 48000", "the device lacks `channels`"),
    ] {
        let source = format!("format = \"pacinian-rig/1\"\n[device]\n{device}\n");
        let problems = Rig::parse("bad.toml", source.as_bytes()).unwrap_err();
        assert!(problems.to_string().contains(fragment), "{problems}");
        assert_eq!(problems.list.len(), 1, "{problems}");
    }
}

fn knob_told(keys: &str) -> String {
    let source = format!("{HEAD}[[output]]\nname = \"a\"\nchannel = 1\nkind = \"torque\"\n[knob]\n{keys}\n");
    match Rig::parse("k.toml", source.as_bytes()) {
        Ok(checked) => format!("fine {}", checked.warnings),
        Err(problems) => problems.to_string(),
    }
}

#[test]
fn a_knob_is_read_and_contradictions_are_told_with_their_keys() {
    assert!(knob_told("motor = \"pittman-8693\"").starts_with("fine"));
    assert!(
        knob_told("motor = \"maxon-re25\"\ndrive = \"voltage\"\nrate = 48000\nknob_inertia = 5e-6")
            .starts_with("fine")
    );
    let own = "inertia = 5e-6\npeak_torque = 0.1\n";
    assert_eq!(knob_told(own), "fine ");
    for (keys, told) in [
        ("motor = \"pitman-8693\"", "did you mean `pittman-8693`"),
        ("inertia = 1e-6", "lacks `peak_torque`"),
        ("peak_torque = 1", "lacks `inertia`"),
        (
            "motor = \"maxon-re25\"\ncontinuous_torque = 1",
            "`continuous_torque` 1 N m is more than `peak_torque`",
        ),
        ("inertia = 1e-6\npeak_torque = 0.1\nfriction = 0.2", "nothing would be felt"),
        (
            "inertia = 1e-6\npeak_torque = 0.1\nfriction = 0.02\nstiction = 0.01",
            "`stiction` 0.01 N m is less",
        ),
        ("inertia = 1e-6\npeak_torque = 0.1\ncounts = 0", "counts"),
        ("inertia = 1e-6\npeak_torque = 0.1\ncounts = 4000\nlines = 1000", "say the same"),
        ("inertia = 1e-6\npeak_torque = 0.1\ndrive = \"current\"", "needs the winding"),
        ("inertia = 1e-6\npeak_torque = 0.1\nlow = 1\nhigh = -1", "`high` is not above `low`"),
        ("inertia = 1e-6\npeak_torque = 0.1\nstop_stiffness = 3", "`stop_stiffness` goes with"),
        ("inertia = 1e-6\npeak_torque = 0.1\nvelocity_corner = 3", "goes with velocity = \"filtered\""),
        ("inertia = 1e-6\npeak_torque = 0.1\ncompensate = true", "goes with `cogging`"),
        ("inertia = -1\npeak_torque = 0.1", "inertia"),
        ("inertia = nan\npeak_torque = 0.1", "inertia"),
        ("inertia = 1e-6\npeak_torque = 0.1\nmargin = 2", "margin"),
        ("inertia = 1e-6\npeak_torque = 0.1\nrate = 10", "rate"),
        ("inertia = 1e-6\npeak_torque = 0.1\ncogging = 3", "a list of harmonics"),
        ("inertia = 1e-6\npeak_torque = 0.1\ncogging = [{ periods = 0, amplitude = 1 }]", "periods"),
        (
            "inertia = 1e-6\npeak_torque = 0.1\noutput = { name = \"b\", newton_metres = 1 }",
            "none of kind torque called so",
        ),
        ("inertia = 1e-6\npeak_torque = 0.1\noutput = \"a\"", "an output and its torque"),
        ("inertia = 1e-6\npeak_torque = 0.1\nfrictoin = 0.1", "friction"),
        ("motor = \"maxon-re25\"\npeak_torque = 0.5\ndrive = \"current\"", "0.233 N m at a standstill"),
        ("motor = \"maxon-re25\"\ndrive = \"voltage\"\nrate = 1000", "does not see that"),
    ] {
        let what = knob_told(keys);
        assert!(what.contains(told), "{keys}: {what}");
    }
    // Once, and by the keys of the file: the model of a knob has names of its own.
    let stops = knob_told("inertia = 1e-6\npeak_torque = 0.1\nlow = 1\nhigh = -1");
    assert!(stops.matches("error").count() == 1 && !stops.contains("stop high"), "{stops}");
    let capacitors = format!(
        "{}\ncoupling = {{ high_pass = 5 }}\n[[output]]\nname = \"a\"\nchannel = 1\nkind = \"torque\"\n",
        HEAD.trim_end()
    );
    let told = Rig::parse("k.toml", capacitors.as_bytes()).unwrap_err().to_string();
    assert!(told.contains("lets nothing steady through"), "{told}");
}

#[test]
fn the_lower_level_holds_and_steady_voltages_leave_where_it_is_said() {
    let rig = |device: &str| {
        let text = format!(
            "{HEAD}{device}\n[[tactor]]\nname = \"a\"\nchannel = 1\nmax_level = 0.25\n[[tactor]]\nname = \"b\"\nchannel = 2\n\
             dc = true\n[[output]]\nkind = \"raw\"\nname = \"c\"\nchannel = 3\nmax_level = 0.75\n[[output]]\nkind = \"trigger\"\n\
             name = \"d\"\nchannel = 4\n"
        );
        (Rig::parse("r.toml", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")), text)
    };
    let (half, _) = rig("max_level = 0.5\ncoupling = \"dc\"");
    let level = |rig: &Rig| rig.outputs.iter().map(|o| rig.max_level(o)).collect::<Vec<_>>();
    let steady = |rig: &Rig| rig.outputs.iter().map(|o| rig.lets_dc(o)).collect::<Vec<_>>();
    assert_eq!(level(&half.value), [0.25, 0.5, 0.5, 0.5]);
    assert_eq!(steady(&half.value), [Some(false), Some(true), Some(true), Some(true)]);
    assert_eq!(half.warnings.list, []);
    let (unsaid, _) = rig("");
    assert_eq!(level(&unsaid.value), [0.25, 1.0, 0.75, 1.0]);
    assert_eq!((steady(&unsaid.value), unsaid.warnings.list), (vec![None; 4], vec![]));
    let (blocked, text) = rig("coupling = { high_pass = 8 }");
    assert_eq!(steady(&blocked.value), [None; 4]);
    assert_told(
        &text,
        &blocked.warnings,
        &[(9, "lets nothing steady through: its coupling is a high-pass at 8 Hz")],
    );
}

#[test]
fn a_rig_without_tactors_gets_a_line_of_them() {
    let rig = Rig::parse("r.toml", HEAD.as_bytes()).unwrap().value;
    assert_eq!(rig.outputs, Rig::default_for(8).outputs);
    assert_eq!(Rig::default_for(8).check(), []);
    assert_eq!(rig.outputs[7].position.unwrap()[0], 0.28);
    assert_eq!(Rig::default_for(u32::MAX).outputs.len(), 4096);
    assert!(Rig::default_for(0).check()[0].what.contains("0 channels"));
}

#[test]
fn places_of_a_patch_are_checked_against_it() {
    let source = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"o\"\nplace = \"t9\"\n\
                  nodes.o = { type = \"sine\", frequency = 1 }\n[pattern.p]\nevents = [\n{ at = 0, voice = \"v\", place = \"t2\" },\n\
                  { at = 0, voice = \"v\", place = 9 },\n{ at = 0, choose = [{ voice = \"v\", place = \"tt1\" }] }]\n";
    let patch = Patch::parse("p.toml", source.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
    let list = Rig::default_for(8).check_places(&patch);
    let problems = pacinian::text::Problems { file: "p.toml".into(), source: source.into(), list };
    let expected = [
        (5, "no tactor `t9`"),
        (10, "this rig has 8 channels; there is no channel 9"),
        (11, "did you mean `t1`?"),
    ];
    assert_told(source, &problems, &expected);
}

/// A rate that no rendering can have is refused where it stands.
#[test]
fn rates_out_of_range_are_refused_at_their_line() {
    for (rate, good) in [(5_999.0, false), (6_000.0, true), (768_000.0, true), (768_001.0, false)] {
        let text = format!("{HEAD}rate = {rate:.1}\n");
        let line = Rig::parse("rig.toml", text.as_bytes()).err().map(|problems| {
            let span = problems.list[0].span.clone().unwrap();
            problems.position(span.start).0
        });
        assert_eq!(line, (!good).then_some(4), "{rate}");
    }
}
