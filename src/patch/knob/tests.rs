use super::{Any, EFFECT, Knob, Scaled, TYPES};
use crate::patch::Patch;
use crate::patch::reference::TOPICS;

fn patch(effects: &str, more: &str) -> Result<Patch, String> {
    let text = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{more}\n[knob.effects]\n{effects}\n");
    Patch::parse("t", text.as_bytes()).map(|checked| checked.value).map_err(|problems| problems.to_string())
}

fn knob(effects: &str) -> Knob {
    patch(effects, "").unwrap_or_else(|p| panic!("{p}")).knob.unwrap()
}

fn told(effects: &str) -> String {
    patch(effects, "").map(|_| effects.to_string()).unwrap_err()
}

/// A figure that fits each key.
fn figure(key: &str) -> &'static str {
    match key {
        "low" => "-1",
        "signal" => "\"voices\"",
        "points" => "[[-1, 0.1], [1, -0.1]]",
        "frequency" => "100",
        "point" => "0.7",
        _ => "1",
    }
}

#[test]
fn every_type_is_read_with_its_keys_and_told_of_without_one_of_them() {
    for kind in &TYPES {
        let keys: Vec<String> = kind.needs.iter().map(|key| format!("{key} = {}", figure(key))).collect();
        let of = |keys: &[String]| format!("e = {{ type = \"{}\", {} }}", kind.word, keys.join(", "));
        // A ringing alone is told of, and not refused.
        assert_eq!(knob(&of(&keys)).effects.len(), 1, "{}", kind.word);
        for (n, key) in kind.needs.iter().enumerate() {
            let mut fewer = keys.clone();
            fewer.remove(n);
            let what = told(&of(&fewer));
            assert!(what.contains(&format!("lacks `{key}`")) && what.contains(kind.word), "{what}");
        }
        let mut more = keys.clone();
        let other = EFFECT.keys().find(|key| {
            !kind.needs.contains(key) && !kind.may.contains(key) && !["type", "gain", "shift"].contains(key)
        });
        let other = other.unwrap();
        more.push(format!("{other} = {}", if other == "law" { "\"dahl\"" } else { figure(other) }));
        assert!(told(&of(&more)).contains(&format!("has no `{other}`")), "{}", told(&of(&more)));
    }
}

#[test]
fn every_type_is_described() {
    let topic = TOPICS.iter().find(|topic| topic.name == "knob").unwrap();
    for kind in &TYPES {
        let line = topic.text.lines().find(|line| line.starts_with(&format!("- {}: ", kind.word)));
        let line = line.unwrap_or_else(|| panic!("{}", kind.word));
        for key in kind.needs.iter().chain(kind.may) {
            assert!(line.contains(key), "{line}: {key}");
        }
    }
}

#[test]
fn expressions_become_shared_nodes_and_numbers_stay_numbers() {
    let text = "a = { type = \"spring\", stiffness = 0.1, gain = \"2 * strength\", shift = 0.5 }\n\
        b = { type = \"texture\", torque = 0.1, signal = \"abs(knob.speed)\" }\n";
    let patch = patch(text, "[control.strength]\ndefault = 1\n").unwrap();
    let effects = patch.knob.unwrap().effects;
    assert_eq!(effects[0].gain, Scaled::Node("knob.a.gain".into()));
    assert_eq!((&effects[0].shift, &effects[0].signal), (&Scaled::Constant(0.5), &Scaled::Constant(0.0)));
    assert_eq!(effects[1].signal, Scaled::Node("knob.b.signal".into()));
    let names: Vec<&str> = patch.shared.iter().map(|node| node.name.as_str()).collect();
    assert_eq!(names, ["knob.a.gain", "knob.b.signal"]);
    let controls: Vec<&str> = patch.controls.iter().map(|control| control.name.as_str()).collect();
    assert_eq!(controls, ["strength", "hand"]);
}

#[test]
fn a_ringing_comes_after_the_wall_that_it_rings_at() {
    let text = "ring = { type = \"transient\", strength = 0.01, frequency = 100, decay = 0.02 }\n\
        wall = { type = \"wall\", angle = 1, stiffness = 0.1 }\n";
    let knob = knob(text);
    assert!(matches!(knob.effects[1].figures, Any::Transient(_)), "{knob:?}");
}

#[test]
fn what_cannot_be_is_told_with_its_key() {
    for (effects, what) in [
        ("e = { type = \"spring\", stiffness = -1 }", "stiffness"),
        ("e = { type = \"sprung\", stiffness = 1 }", "sprung"),
        ("e = { stiffness = 1 }", "lacks `type`"),
        (
            "e = { type = \"end-stops\", low = 1, high = -1, stiffness = 1 }",
            "`high` is -1, but must be at least 1",
        ),
        ("e = { type = \"table\", points = [[0, 1]] }", "`points` is 1, but must be within 2"),
        ("e = { type = \"table\", points = [[1, 0], [0, 0]] }", "`angle`"),
        ("e = { type = \"table\", points = [[1, 0, 2], [0, 0]] }", "pairs of an angle"),
        ("e = { type = \"detents\", count = 0, torque = 1 }", "count"),
        ("e = { type = \"detents\", count = 4, torque = -1 }", "`torque`"),
        ("e = { type = \"detents\", count = 4, torque = 1, table = [0, 2] }", "`table`"),
        ("e = { type = \"spring\", stiffness = 1, gain = \"strenght\" }", "strenght"),
        ("e = { type = \"spring\", stiffness = 1, gain = \"event.level\" }", "event"),
        ("e = { type = \"spring\", stiffness = 1, gain = \"touch.pressure\" }", "hand"),
        ("e = { type = \"spring\", stiffness = 1, gain = \"knob.angel\" }", "knob.angel"),
        ("e = { type = \"spring\", stiffness = 1, gain = true }", "gain"),
        ("e = { type = \"spring\", stiffness = nan }", "stiffness"),
    ] {
        let told = told(effects);
        assert!(told.contains(what), "{effects}: {told}");
    }
}

#[test]
fn a_trigger_that_waits_for_what_never_happens_is_told() {
    let more = |on: &str| {
        format!(
            "[voice.v]\noutput = \"o\"\nnodes.o = {{ type = \"sine\", frequency = 99 }}\n[[trigger]]\non = \"{on}\"\nplay = \"v\"\n"
        )
    };
    let both = "a = { type = \"detents\", count = 4, torque = 0.1 }\nb = { type = \"wall\", angle = 1, stiffness = 1 }\n";
    for on in ["knob.detent", "knob.detent a", "knob.wall", "knob.wall b"] {
        assert!(patch(both, &more(on)).is_ok(), "{on}");
    }
    for (effects, on, told) in [
        (both, "knob.wall a", "never happens to effect `a`"),
        (both, "knob.detent c", "no effect `c`"),
        ("d = { type = \"damper\", damping = 1 }", "knob.detent", "of type detents or snap"),
        (both, "knob.bump", "nothing like that sets off a trigger"),
    ] {
        let what = patch(effects, &more(on)).unwrap_err();
        assert!(what.contains(told), "{on}: {what}");
    }
}

#[test]
fn what_never_happens_cannot_be_read() {
    let reads = |word: &str| {
        format!(
            "[voice.v]\noutput = \"o\"\nnodes.o = {{ type = \"multiply\", inputs = [\"knob.{word}\", 1] }}\n"
        )
    };
    let notches = "a = { type = \"detents\", count = 4, torque = 0.1 }\n";
    for word in ["angle", "speed", "torque", "detent"] {
        assert!(patch(notches, &reads(word)).is_ok(), "{word}");
    }
    let told = patch(notches, &reads("wall")).unwrap_err();
    assert!(told.contains("`knob.wall` never happens") && told.contains("end-stops or contact"), "{told}");
}

#[test]
fn without_a_knob_nothing_can_read_it() {
    let text = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"o\"\n\
        nodes.o = { type = \"sine\", frequency = \"100 + knob.angle\" }\n[[trigger]]\non = \"knob.wall\"\nplay = \"v\"\n";
    let told = Patch::parse("t", text.as_bytes()).unwrap_err().to_string();
    assert!(told.contains("reads the knob, and the patch has none"), "{told}");
    assert_eq!(told.matches("the patch has none").count(), 2, "{told}");
}
