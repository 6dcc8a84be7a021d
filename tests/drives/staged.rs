//! Output stages of a rig that switch, and a mass that is parked: what a rig says of them, and what leaves the device.

use super::{CLICK, COIN, RATE, SWELL, compiled, compiled_of, play, sent};
use crate::common::scenes::{MOTORS, MOVES};
use pacinian::actuator::driver::order::{After, By};
use pacinian::actuator::driver::setup::{Shaping, Stage};
use pacinian::engine::event::Event;
use pacinian::rig::Rig;

/// The voice that is added to those of the scene.
const HOME: u32 = 6;

/// The rig of motors, of which the coin's output says that too.
fn with(more: &str) -> String {
    MOTORS.replacen("amplifier = \"bridge\"\n", &format!("amplifier = \"bridge\"\n{more}\n"), 1)
}

#[test]
fn a_rig_says_how_levels_switch() {
    let stage = |more: &str| {
        let setup = compiled(&with(more)).drives[0].setup;
        (setup.shaping, setup.stage, setup.park)
    };
    let said =
        "shaping = \"on-off\"\nby = \"current\"\nafter = \"open\"\nshare = 0.4\non_at = 0.3\noff_at = 0.1";
    let due = Stage { by: By::Current, after: After::Open, share: 0.4, on_at: 0.3, off_at: 0.1 };
    assert_eq!(stage(said), (Shaping::OnOff, due, None));
    assert_eq!(
        stage("shaping = \"plain\"\nafter = \"short\"").1,
        Stage { after: After::Short, ..Stage::default() }
    );
    // What is off goes with what is on.
    assert_eq!(
        stage("shaping = \"on-off\"\non_at = 0.2").1,
        Stage { on_at: 0.2, off_at: 0.1, ..Stage::default() }
    );
    assert_eq!(stage("tilt = 0.0\npark = 0.5").2, Some(0.5));
    for (more, words) in [
        ("by = \"current\"", &["`by`", "\"plain\" or \"on-off\""][..]),
        ("shaping = \"plain\"\non_at = 0.4", &["`on_at`", "\"on-off\""]),
        (
            "shaping = \"on-off\"\non_at = 0.4\noff_at = 0.6",
            &["off at a level of 0.6", "on at 0.4", "no more than"],
        ),
        ("shaping = \"on-off\"\nshare = 0", &["`share`"]),
        (
            "shaping = \"overdrive\"\nlook_ahead = 0.1",
            &["`look_ahead`", "\"inverse\" alone", "as late as all else"],
        ),
        ("shaping = \"clicks\"\ntilt = 0.0\npark = 0.5", &["`park`", "alone"]),
        ("direction = 2", &["`direction`", "`bridge` is no bridge"]),
        ("park = 0.5", &["`park`", "tilt = 0.0"]),
        ("tilt = 0.0\npark = 0", &["`park`"]),
        ("shaping = \"on_off\"", &["on-off"]),
    ] {
        let said = Rig::parse("rig.toml", with(more).as_bytes()).map(|_| ()).unwrap_err().to_string();
        assert!(words.iter().all(|word| said.contains(word)), "{more}: {said}");
    }
}

/// What a shaping does not read is refused, and what it reads changes what is sent: every shaping with every key that is of some of them.
#[test]
fn a_key_that_changes_nothing_is_refused() {
    let keys = [
        "look_ahead = 0.4",
        "by = \"current\"",
        "after = \"open\"",
        "share = 0.3",
        "on_at = 0.9",
        "off_at = 0.05",
        "park = 0.05",
    ];
    let voices =
        format!("{MOVES}[voice.z]\noutput = \"go\"\n[voice.z.nodes]\ngo = {{ type = \"drive-home\" }}\n");
    let mut refused = 0;
    for shaping in Shaping::ALL {
        for key in keys {
            // Of all that there may be a current cannot be held: that is said, and so it is some of it.
            let some = if shaping == Shaping::OnOff && key.starts_with("by") { "share = 0.4" } else { "" };
            let rig =
                |key: &str| with(&format!("shaping = \"{}\"\ntilt = 0.0\n{some}\n{key}", shaping.word()));
            let read = Rig::parse("rig.toml", rig(key).as_bytes());
            let sent = |key: &str| {
                let played = [(0.01, HOME, 1.0, 0.01), (1.5, SWELL, 0.8, 0.3), (2.6, CLICK, 1.0, 0.01)];
                let played = played
                    .map(|(at, which, level, lasts)| (at, Event::Play(play(which, COIN, level, lasts))));
                sent(&compiled_of(&voices, &rig(key)), &played, 5.0, &[480])
            };
            match read {
                Ok(_) if shaping == Shaping::Clicks => panic!("{key} changes no click"),
                Ok(_) => assert!(sent(key) != sent(""), "{shaping:?}: {key} changes nothing"),
                Err(problems) => {
                    refused += 1;
                    let told = problems.to_string();
                    let name = key.split(' ').next().unwrap();
                    assert!(
                        told.contains(&format!("has `{name}`, which is of shaping")),
                        "{shaping:?}: {told}"
                    );
                }
            }
        }
    }
    let whole = with("shaping = \"on-off\"\nby = \"current\"");
    let told =
        Rig::parse("rig.toml", whole.as_bytes()).unwrap_or_else(|p| panic!("{p}")).warnings.to_string();
    assert!(told.contains("`by`") && told.contains("share = 0.5"), "{told}");
    // The look ahead of all but one of six, `by` and `after` of all but two, three keys of all but one, `park` of clicks.
    assert_eq!(refused, 5 + 2 * 4 + 3 * 5 + 1);
}

/// A click is what it is, whatever levels are shaped by; a level is full on from its threshold to its other one.
#[test]
fn levels_that_switch_leave_the_device_switched() {
    let plan = compiled(&with("shaping = \"on-off\""));
    let [volts, _] = sent(&plan, &[(0.01, Event::Play(play(CLICK, COIN, 1.0, 0.02)))], 0.2, &[480]);
    let most = plan.drives[0].setup.limit;
    assert!(volts.iter().any(|v| (v - most).abs() < 1e-6) && volts.iter().any(|v| (v + most).abs() < 1e-6));
    let [volts, _] = sent(&plan, &[(0.01, Event::Play(play(SWELL, COIN, 1.0, 0.3)))], 1.0, &[480, 7]);
    let on = volts.iter().filter(|v| **v != 0.0).count() as f64 / RATE;
    assert!(
        volts.iter().all(|v| *v == 0.0 || (v.abs() - most).abs() < 1e-5) && (0.02..0.6).contains(&on),
        "{on}"
    );
}
