//! What the files say and nothing acts on: outputs that nothing feeds, and what this version reads and checks but does not run yet.

use std::collections::{BTreeSet, HashSet};

use super::plan::{LeftOut, Why};
use crate::actuator::protect::bounds::Bounds;
use crate::patch::{Action, Events, Patch, Place};
use crate::rig::{self, Finder, Rig};

/// What a patch and a rig name and nothing acts on yet.
pub fn not_yet(rig: &Rig) -> Vec<LeftOut> {
    let mut list = Vec::new();
    let mut say = |is: bool, what: String| {
        if is {
            list.push(LeftOut { what, why: Why::NotYet });
        }
    };
    // Volts are known, or nothing that is said in volts is of use.
    for amplifier in rig.amplifiers.iter().filter(|_| rig.device.full_scale_volts.is_none()) {
        say(true, format!("amplifier `{}`", amplifier.name));
    }
    for actuator in &rig.actuators {
        let hangs = |output: &&rig::Output| output.actuator.as_deref() == Some(actuator.name.as_str());
        let hanging: Vec<&rig::Output> = rig.outputs.iter().filter(hangs).collect();
        let any = |is: &dyn Fn(&rig::Output) -> bool| hanging.iter().any(|output| is(output));
        let kept = |is: &dyn Fn(&Bounds) -> bool| any(&|output| rig.bounds(output).as_ref().is_some_and(is));
        let turns = any(&|output| matches!(rig.wiring(output), Some(Ok(_))));
        let evened = any(&|output| matches!(rig.evened(output), Some(Ok(_))));
        let acts = turns || kept(&|_| true);
        let coil = acts && actuator.coil().is_ok();
        let moves = evened || coil;
        let heats = kept(&|bounds| bounds.heat.is_some())
            || any(&|output| rig.bears(output).is_some_and(|bears| bears.heat.is_some()));
        // Where nothing is known that would be kept to, the first three say so.
        let charges = actuator.model == rig::Model::Piezo && kept(&|bounds| bounds.slew.is_some());
        for (known, key) in [
            (moves, "resonance"),
            (moves, "q"),
            (acts, "rated_volts"),
            (!acts || coil || turns || charges, "max_amperes"),
            (!acts || coil, "max_rms_amperes"),
            (!acts || kept(&|bounds| bounds.slew.is_some()), "max_slew"),
            (!acts || heats, "max_heating"),
            (!acts || kept(&|bounds| bounds.stroke.is_some()), "stroke"),
        ] {
            let without = if key == "max_heating" { without(actuator) } else { String::new() };
            let what = format!("`{key}` of actuator `{}`{without}", actuator.name);
            say(actuator.value(key).is_some() && !known, what);
        }
    }
    for output in rig.outputs.iter().filter(|o| o.kind == rig::OutputKind::Raw) {
        let actuator = output.actuator.as_deref().and_then(|name| rig.actuator(name));
        for (is, key) in [
            (actuator.is_some_and(|a| !a.equaliser.is_empty()), "equaliser"),
            (actuator.is_some_and(|a| a.even_out.is_some()), "even_out"),
        ] {
            say(is, format!("`{key}` of raw output `{}`", output.name));
        }
    }
    list
}

/// The figures that its heat is not known without.
fn without(actuator: &rig::Actuator) -> String {
    let needed = ["resistance", "winding_to_housing", "housing_to_air", "winding_time", "housing_time"];
    let lacking: Vec<String> =
        needed.iter().filter(|key| actuator.value(key).is_none()).map(|key| format!("`{key}`")).collect();
    if lacking.is_empty() { String::new() } else { format!(" without {}", lacking.join(", ")) }
}

/// Outputs told one by one, at most.
const SHOWN: usize = 16;

/// Outputs that no event of the voices and patterns at hand can reach, where all of them are known: the events stand in the patch.
pub fn never_fed(patch: &Patch, rig: &Rig, voices: &BTreeSet<usize>) -> Vec<LeftOut> {
    let mut fed = BTreeSet::new();
    let finder = Finder::with(rig, patch);
    let mut reach = |place: Option<&Place>| {
        let found = rig.resolve_by(&finder, place, &(0..0));
        fed.extend(found.ok().into_iter().flat_map(|spot| finder.outputs(spot)));
    };
    let sounding: HashSet<&str> = voices.iter().map(|v| patch.voices[*v].name.as_str()).collect();
    let sounds = |name: &str| sounding.contains(name);
    for &v in voices {
        reach(patch.voices[v].place.as_ref());
    }
    for trigger in patch.triggers.iter().filter(|t| t.on.is_known() && t.place.is_some()) {
        reach(trigger.place.as_ref());
    }
    for pattern in &patch.patterns {
        let Events::Inline(events) = &pattern.events else { return Vec::new() };
        for event in events {
            let mut visit = |action: &Action| {
                if let Action::Voice(play) = action
                    && sounds(&play.voice)
                {
                    play.places().for_each(|(place, _)| reach(Some(place)));
                }
            };
            visit(&event.action);
            if let Action::Choose(list) = &event.action {
                list.iter().for_each(|a| visit(&a.action));
            }
        }
    }
    let feeds = |o: &rig::Output| {
        matches!(o.kind, rig::OutputKind::Vibration | rig::OutputKind::Raw | rig::OutputKind::Drive(_))
    };
    let idle = rig.outputs.iter().enumerate().filter(|(i, o)| feeds(o) && !fed.contains(i));
    let names: Vec<&str> = idle.map(|(_, o)| o.name.as_str()).collect();
    let (shown, more) = names.split_at(names.len().min(SHOWN));
    let left = |what: String| LeftOut { what, why: Why::NeverFed };
    let mut list: Vec<_> = shown.iter().map(|name| left(format!("output `{name}`"))).collect();
    list.extend((!more.is_empty()).then(|| left(format!("{} outputs more", more.len()))));
    list
}

#[cfg(test)]
mod tests {
    use super::{Why, not_yet};
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;

    const RIG: &str = r#"
format = "pacinian-rig/1"
title = "All that nothing acts on"
[device]
channels = 3
coupling = { high_pass = 8.0 }
[amplifier.class-d]
gain = 6.0
[actuator.exciter]
resonance = 65.0
q = 2.0
rated_volts = 3.0
equaliser = [{ frequency = 65, gain_db = -6 }]
[[tactor]]
name = "a"
channel = 1
[[tactor]]
name = "b"
channel = 2
[[output]]
kind = "raw"
name = "c"
channel = 3
actuator = "exciter"
"#;

    const PATCH: &str = r#"
format = "pacinian-patch/1"
title = "One tap"
[control.strength]
default = 1
range = [0.5, 1.0]
curve = "exponential"
[voice.tap]
output = "out"
[voice.tap.nodes]
out = { type = "sine", frequency = 250, amplitude = "strength" }
[pattern.p]
events = [{ at = 0, voice = "tap" }, { at = 1, voice = "tap", place = "c" }]
[[trigger]]
on = "start"
play = "p"
"#;

    fn left(why: Why, live: bool) -> Vec<String> {
        let rig = Rig::parse("r.toml", RIG.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let patch = Patch::parse("p.toml", PATCH.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let options = Options { live, ..Options::default() };
        let plan = scene(&patch, &rig, &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan;
        plan.left_out.into_iter().filter(|l| l.why == why).map(|l| l.what).collect()
    }

    #[test]
    fn outputs_that_no_place_reaches_are_told() {
        assert_eq!(left(Why::NeverFed, false), ["output `b`"]);
        assert!(left(Why::NeverFed, true).is_empty());
    }

    /// Where volts are known, what is said in volts protects.
    #[test]
    fn what_protects_is_not_told() {
        let rig = RIG.replace("coupling =", "full_scale_volts = 1.4\ncoupling =");
        let rig = Rig::parse("r.toml", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let told: Vec<String> = not_yet(&rig).into_iter().map(|left| left.what).collect();
        let wanted = [
            "`resonance` of actuator `exciter`",
            "`q` of actuator `exciter`",
            "`equaliser` of raw output `c`",
        ];
        assert_eq!(told, wanted);
    }

    /// A limit that cannot be kept to for want of other figures, or by what turns the motor.
    #[test]
    fn limits_that_nothing_keeps_to_are_told() {
        let told = |amplifier: &str, actuator: &str, output: &str| -> Vec<String> {
            let rig = format!(
                "format = \"pacinian-rig/1\"\n[device]\nchannels = 2\nfull_scale_volts = 5\ncoupling = \"dc\"\n\
                 [amplifier.a]\n{amplifier}\n[actuator.x]\n{actuator}\n{output}\nname = \"o\"\nchannel = 1\nactuator = \"x\"\namplifier = \"a\"\n"
            );
            let rig = Rig::parse("r.toml", rig.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
            let told = not_yet(&rig).into_iter().map(|left| left.what);
            told.map(|what| what.replace("` of actuator `x`", "").replacen('`', "", 1)).collect()
        };
        let heating =
            "max_heating without `winding_to_housing`, `housing_to_air`, `winding_time`, `housing_time`";
        let volts = "gain = 1\ncoupling = \"dc\"";
        let (drive, tactor) = ("[[output]]\nkind = \"drive\"", "[[tactor]]");
        let bridge = "drive = \"bridge\"\nmax_volts = 5";
        let both = "max_heating = 60\nmax_slew = 1e4\nmax_amperes = 0.1\nmax_rms_amperes = 0.05";
        let coin = format!("part = \"coin-10mm\"\n{both}");
        assert_eq!(told(volts, &coin, drive), ["max_rms_amperes", heating]);
        let line = format!("{drive}\ndirection = 2");
        assert_eq!(told(bridge, &coin, &line), ["max_rms_amperes", "max_slew", heating]);
        let whole = "winding_to_housing = 100\nhousing_to_air = 50\nwinding_time = 5\nhousing_time = 100";
        assert_eq!(told(bridge, &format!("{coin}\n{whole}"), &line), ["max_rms_amperes", "max_slew"]);
        let coil = format!("part = \"eai-c-mf\"\n{}", both.replace("0.05", "0.04"));
        assert_eq!(told(volts, &coil, tactor), [heating]);
        assert_eq!(
            told(volts, &format!("model = \"voice-coil\"\nrated_volts = 1\n{both}"), tactor),
            ["max_amperes", "max_rms_amperes", &heating.replace("without ", "without `resistance`, ")]
        );
    }

    #[test]
    fn what_nothing_acts_on_is_told() {
        let wanted = [
            "amplifier `class-d`",
            "`resonance` of actuator `exciter`",
            "`q` of actuator `exciter`",
            "`rated_volts` of actuator `exciter`",
            "`equaliser` of raw output `c`",
        ];
        assert_eq!(left(Why::NotYet, false), wanted);
    }
}
