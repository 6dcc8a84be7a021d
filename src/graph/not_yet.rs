//! What the files say and nothing acts on: outputs that nothing feeds, and what this version reads and checks but does not run yet.

use std::collections::{BTreeSet, HashSet};

use super::plan::{LeftOut, Why};
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
        let turns = |output: &rig::Output| matches!(rig.wiring(output), Some(Ok(_)));
        let acts = |output: &rig::Output| turns(output) || rig.bounds(output).is_some();
        let acts = rig.outputs.iter().filter(hangs).any(acts);
        let evened = rig.outputs.iter().filter(hangs).any(|output| matches!(rig.evened(output), Some(Ok(_))));
        let moves = evened || acts && actuator.coil().is_ok();
        for (known, key) in [(moves, "resonance"), (moves, "q"), (acts, "rated_volts")] {
            say(actuator.value(key).is_some() && !known, format!("`{key}` of actuator `{}`", actuator.name));
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
