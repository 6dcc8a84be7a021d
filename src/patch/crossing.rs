//! What a trigger that a node sets off may say.

use super::{Source, Trigger};
use crate::text::Problem;

/// What is wrong with what a trigger says of a node that sets it off.
pub(super) fn check(trigger: &Trigger, problems: &mut Vec<Problem>) {
    let Source::Node { rises, threshold, .. } = trigger.on else {
        let said = [(trigger.hold != 0.0, "hold"), (trigger.rearm.is_some(), "rearm")];
        for (_, key) in said.into_iter().filter(|(is, _)| *is) {
            let what = format!("`{key}` goes with nodes, and this trigger is set off by something else");
            let help = "set it off by on = \"node.NAME rises 0.3\"".to_string();
            problems.push(Problem::error(&trigger.span, what).help(help));
        }
        return;
    };
    // What is made in code may be anything.
    if !(0.0..=super::trigger::MOST_HOLD).contains(&trigger.hold) {
        let what = format!("`hold` of a trigger is {}", trigger.hold);
        let help = format!("give seconds, 0 to {}", super::trigger::MOST_HOLD);
        problems.push(Problem::error(&trigger.span, what).help(help));
    }
    if let Some(rearm) = trigger.rearm {
        let (lies, way) = if rises { (rearm <= threshold, "above") } else { (rearm >= threshold, "below") };
        if !lies {
            let what =
                format!("`rearm` {rearm} lies {way} the threshold, {threshold}: it would never be set off");
            let help = format!(
                "what {} comes back {} it",
                if rises { "rises" } else { "falls" },
                if rises { "below" } else { "above" }
            );
            problems.push(Problem::error(&trigger.span, what).help(help));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::patch::Patch;

    const PATCH: &str = "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[control.push]\ndefault = 0\n[shared.nodes]\n\
        breath = { type = \"lfo\" }\n[voice.v]\noutput = \"o\"\nnodes.o = { type = \"sine\", frequency = \"event.frequency\" }\n[pattern.p]\n\
        events = [{ at = 0, voice = \"v\" }]\n[[trigger]]\n";

    /// What is wrong with a trigger, and what to do.
    fn told(trigger: &str) -> Vec<(String, String)> {
        let problems = match Patch::parse("p.toml", format!("{PATCH}{trigger}\n").as_bytes()) {
            Ok(checked) => checked.warnings,
            Err(problems) => problems,
        };
        problems.list.into_iter().map(|p| (p.what, p.help.unwrap_or_default())).collect()
    }

    #[test]
    fn nodes_and_controls_set_off_voices_and_patterns() {
        for fine in [
            "on = \"node.breath rises 0.3\"\nplay = \"p\"\nhold = 0.1\nset = { gain = \"2 * value\", rate = 0.5 }",
            "on = \"node.breath rises 0.3\"\nplay = \"v\"",
            "on = \"node.push falls -0.3\"\nplay = \"v\"\nhold = 0.05\nrearm = -0.2\nplace = 2",
            "on = \"node.breath rises 0.3\"\nplay = \"v\"\nrearm = 0.3\nset = { level = \"2 * value\", duration = 0.2 }",
        ] {
            assert_eq!(told(fine), [], "{fine}");
        }
    }

    #[test]
    fn what_cannot_be_is_told_with_what_to_do() {
        for (trigger, what, help) in [
            (
                "on = \"node.breath rises 0.3\"\nplay = \"p\"\nplace = 2",
                "a trigger cannot say where pattern `p` plays",
                "its events say so",
            ),
            (
                "on = \"node.breath rises 0.3\"\nplay = \"p\"\nset = { level = 0.5 }",
                "a trigger cannot set `level` of a pattern",
                "gain",
            ),
            ("on = \"node.breth rises 0.3\"\nplay = \"v\"", "no shared node `breth`", "`breath`"),
            (
                "on = \"node.breath rises 0.3\"\nplay = \"v\"\nrearm = 0.4",
                "`rearm` 0.4 lies above the threshold, 0.3",
                "comes back below",
            ),
            (
                "on = \"node.breath falls 0.3\"\nplay = \"v\"\nrearm = 0.2",
                "`rearm` 0.2 lies below the threshold, 0.3",
                "comes back above",
            ),
            ("on = \"node.breath rises 0.3\"\nplay = \"v\"\nhold = -1", "`hold` of trigger 1 is -1", ""),
            ("on = \"key.1\"\nplay = \"v\"\nhold = 1", "`hold` goes with nodes", "node.NAME rises"),
            ("on = \"start\"\nplay = \"v\"\nrearm = 1", "`rearm` goes with nodes", "node.NAME rises"),
            (
                "on = \"node.breath rises 0.3\"\nplay = \"v\"\nset = { level = \"push\" }",
                "`push` is nothing that this trigger gives",
                "let its nodes read `push`",
            ),
            (
                "on = \"node.breath rises 0.3\"\nplay = \"v\"\nset = { level = \"velocity\" }",
                "`velocity` is nothing that this trigger gives",
                "it gives `value`",
            ),
            (
                "on = \"node.breath falls -0.3\"\nplay = \"v\"\nset = { level = \"value\" }",
                "`level` of a trigger is -0.3; it may be from 0 to 100",
                "",
            ),
            (
                "on = \"node.breath falls 0\"\nplay = \"v\"\nset = { frequency = \"1 / value\" }",
                "`frequency` of a trigger is inf",
                "",
            ),
        ] {
            let told = told(trigger);
            let [(found, do_this)] = told.as_slice() else { panic!("{trigger}: {told:?}") };
            assert!(found.contains(what) && do_this.contains(help), "{trigger}: {told:?}");
        }
    }
}
