//! What shared signals set off: triggers of a patch, as the engine watches for them.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::answer::{Answer, Started, Voiced};
use super::build::{self, Want, Wanted};
use super::plan::compile;
use super::program::Feed;
use super::start::FIELDS;
use crate::node::asset::Assets;
use crate::patch::{Patch, Scope, Source, Target, Trigger, Voice};
use crate::space::spot::Spot;

/// Engine samples from the instant at which a signal passes a threshold to the onset of what that sets off: always as many, so that
/// what is seen only when some samples have been computed still begins at its instant.
pub const LATENCY: u64 = 8;

/// Voices and patterns that signals may set off in a stretch of 64 engine samples on the engine's grid; what would be more is dropped, and counted.
pub const MOST_STARTS: u64 = 1024;

/// A voice or a pattern that a shared signal sets off as it passes a threshold.
///
/// It is set off where a value lies on the far side of the threshold or on it and the one a sample before on the near side, at the instant
/// at which a straight line between the two passes it; [`LATENCY`] later the voice begins, and a pattern
/// [`super::plan::Plan::answer`] later. Values that are no numbers are passed over, and
/// nothing is set off between them and the next.
#[derive(Debug, Clone, PartialEq)]
pub struct Watch {
    /// What sets it off, as the patch has it: `node.breath rises 0.3`.
    pub name: Arc<str>,
    /// The signal, by its place in [`super::plan::Plan::shared`]; one that is not there sets nothing off.
    pub signal: u32,
    /// What it passes.
    pub threshold: f64,
    /// Upwards; else downwards.
    pub rises: bool,
    /// What it must come back to, short of this, before it can set that off again.
    pub rearm: f64,
    /// Seconds after it has set something off during which it does not do so again.
    pub hold: f64,
    /// What it sets off.
    pub answer: Answer,
}

/// Bits of an id that count what one watch has set off.
const OF_WATCH: u32 = 40;

/// Set in the ids of voices that signals have set off, where the next is not: neither patterns nor the program nor what always sounds have
/// such.
const SET_OFF: u64 = 1 << 63;

/// The id of the voice of that number, from 0, that a watch has set off, by its place in the plan: it names the voice's random numbers.
pub fn id(watch: usize, number: u64) -> u64 {
    let watch = watch as u64 & ((1 << (62 - OF_WATCH)) - 1);
    SET_OFF | watch << OF_WATCH | number & ((1 << OF_WATCH) - 1)
}

/// What sets off a trigger, in the words of a patch.
pub(super) fn words(trigger: &Trigger) -> Option<String> {
    trigger.on.by_itself()
}

/// The triggers of a patch that nodes set off, by their places in it: those that may be, and those whose nodes never move. `rate` is the
/// engine's, Hz.
pub(super) fn split(patch: &Patch, assets: &dyn Assets, rate: f64) -> (Vec<usize>, Vec<usize>) {
    let scope = Scope::new(patch, None);
    let node = |trigger: &Trigger| match &trigger.on {
        Source::Node { node, .. } => scope.find(node),
        _ => None,
    };
    let all = patch.triggers.iter().enumerate().filter_map(|(i, trigger)| Some((i, node(trigger)?)));
    let all: Vec<(usize, Target)> = all.collect();
    let shared = |target: &Target| if let Target::Shared(node) = target { Some(*node) } else { None };
    let nodes: BTreeSet<usize> = all.iter().filter_map(|(_, target)| shared(target)).collect();
    let nodes: Vec<usize> = nodes.into_iter().collect();
    let still = still(patch, &nodes, assets, rate);
    let (stay, move_): (Vec<_>, Vec<_>) =
        all.into_iter().partition(|(_, target)| shared(target).is_some_and(|node| still.contains(&node)));
    let places = |list: Vec<(usize, Target)>| list.into_iter().map(|(place, _)| place).collect();
    (places(move_), places(stay))
}

/// Of these shared nodes, those that come to a number.
fn still(patch: &Patch, nodes: &[usize], assets: &dyn Assets, rate: f64) -> BTreeSet<usize> {
    if nodes.is_empty() {
        return BTreeSet::new();
    }
    // What is wrong with them is told where they are built for good.
    let Ok(graph) = build::shared(patch, nodes, assets, &mut Wanted::default()) else {
        return BTreeSet::new();
    };
    let Ok(compiled) = compile(graph, false, rate) else { return BTreeSet::new() };
    let outputs = nodes.iter().zip(&compiled.program.outputs);
    outputs.filter(|(_, feed)| matches!(feed, Feed::Steady(_))).map(|(node, _)| *node).collect()
}

/// The watch for a trigger, and the signal that it wants.
pub(super) fn watch(
    trigger: &Trigger,
    answer: Answer,
    scope: &Scope<'_>,
    wanted: &mut Wanted,
) -> Option<Watch> {
    let Source::Node { node, rises, threshold } = &trigger.on else { return None };
    let signal = wanted.number(match scope.find(node)? {
        Target::Shared(node) => Want::Node(node),
        Target::Control(control) => Want::Control(control),
        Target::Node(_) => return None,
    });
    Some(Watch {
        name: words(trigger)?.into(),
        signal,
        threshold: *threshold,
        rises: *rises,
        rearm: trigger.rearm.unwrap_or(*threshold),
        hold: trigger.hold,
        answer,
    })
}

/// The voice that a trigger plays which a node sets off. `place`: where it sounds.
pub(super) fn voiced(trigger: &Trigger, voice: &Voice, instrument: u32, place: Spot) -> Voiced {
    let mut own = [0.0; FIELDS];
    own.iter_mut().zip(&voice.fields).for_each(|(value, (_, default))| *value = *default);
    let (mut level, mut felt, mut duration) = (None, None, voice.duration);
    for (field, expr, _) in &trigger.set {
        // Nothing else is left in a patch that was checked.
        let Some(value) = expr.value(&|name| trigger.on.known(name)).filter(|value| value.is_finite()) else {
            continue;
        };
        match field.as_str() {
            "level" => level = Some(value),
            "felt" => felt = Some(value),
            "duration" => duration = value.max(0.0),
            name => {
                let slot = voice.fields.iter().position(|(field, _)| field == name);
                if let Some(slot) = slot.and_then(|slot| own.get_mut(slot)) {
                    *slot = value;
                }
            }
        }
    }
    let (level, felt) = voice.strength(level, felt);
    Voiced { instrument, place, level, felt, duration, own }
}

/// The pattern that a trigger plays which a node sets off.
pub(super) fn started(trigger: &Trigger, pattern: u32) -> Started {
    let known = |name: &str| trigger.on.known(name);
    let says = |wanted: &str| {
        let (_, expr, _) = trigger.set.iter().find(|(field, ..)| field == wanted)?;
        expr.value(&known).filter(|value| value.is_finite())
    };
    Started::new(pattern, says("gain").unwrap_or(1.0), says("rate").unwrap_or(1.0))
}

#[cfg(test)]
mod tests {
    use super::{Answer, Watch, id};
    use crate::graph::plan::{Plan, Shared, Why};
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;
    use crate::space::spot::Spot;

    fn plan(text: &str, live: bool) -> Plan {
        let text = format!("format = \"pacinian-patch/1\"\ntitle = \"t\"\n{text}");
        let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let options = Options { live, ..Options::default() };
        scene(&patch, &Rig::default_for(4), &options, &NoAssets).unwrap_or_else(|p| panic!("{p}")).plan
    }

    const VOICE: &str = "[voice.v]\noutput = \"o\"\nplace = 2\ndefaults = { level = 0.7, depth = 3 }\n\
        nodes.o = { type = \"sine\", frequency = \"event.frequency + event.depth\" }\n\
        [voice.w]\noutput = \"o\"\nnodes.o = { type = \"sine\", frequency = 100 }\n";

    #[test]
    fn a_node_that_only_a_trigger_hears_is_there_and_so_is_its_voice() {
        let shared = "[control.push]\ndefault = 0\n[shared.nodes]\nunheard = { type = \"lfo\" }\n\
            slow = { type = \"lfo\", rate = 2 }\nheard = { type = \"scale\", input = \"slow\", gain = 0.9 }\n";
        let text = format!(
            "{shared}{VOICE}[[trigger]]\non = \"node.heard rises 0.25\"\nplay = \"v\"\nplace = 3\nhold = 0.5\n\
             set = {{ frequency = \"100 + 4 * value\", duration = 0.3 }}\n\
             [[trigger]]\non = \"node.push falls 0.5\"\nrearm = 0.6\nplay = \"v\"\n"
        );
        for live in [false, true] {
            let plan = plan(&text, live);
            let names: Vec<&str> = plan.shared_program.ops.iter().map(|op| &*op.node.name).collect();
            assert!(names.contains(&"slow") && !names.contains(&"unheard"), "{names:?}");
            assert_eq!(plan.instruments.len(), if live { 2 } else { 1 });
            let [heard, push] = plan.watches.as_slice() else { panic!("{:?}", plan.watches) };
            assert_eq!((&*heard.name, &*push.name), ("node.heard rises 0.25", "node.push falls 0.5"));
            assert!(matches!(plan.shared[heard.signal as usize], Shared::Node(_)));
            assert!(matches!(plan.shared[push.signal as usize], Shared::Control(0)));
            assert_eq!((heard.threshold, heard.rises, heard.rearm, heard.hold), (0.25, true, 0.25, 0.5));
            assert_eq!((push.threshold, push.rises, push.rearm, push.hold), (0.5, false, 0.6, 0.0));
            let voiced = |watch: &Watch| match watch.answer {
                Answer::Voice(voiced) => voiced,
                Answer::Pattern(started) => panic!("{started:?}"),
            };
            let (heard, push) = (voiced(heard), voiced(push));
            assert_eq!((heard.place, heard.level, heard.duration), (Spot::Row(2), 0.7, 0.3));
            assert_eq!((push.place, push.level, push.duration), (Spot::Row(1), 0.7, 0.1));
            let field = |name: &str| plan.instruments[0].fields.iter().position(|f| **f == *name).unwrap();
            assert_eq!((heard.own[field("frequency")], heard.own[field("depth")]), (101.0, 3.0));
            assert_eq!(push.own[field("frequency")], 250.0);
        }
    }

    #[test]
    fn a_node_that_never_moves_is_left_out_with_its_voice() {
        let text = format!(
            "[shared.nodes]\nfive = {{ type = \"add\", inputs = [2, 3] }}\n\
             none = {{ type = \"multiply\", inputs = [\"slow\", 0] }}\nslow = {{ type = \"lfo\" }}\n{VOICE}\
             [[trigger]]\non = \"node.five rises 4\"\nplay = \"v\"\n[[trigger]]\non = \"node.none rises -1\"\nplay = \"v\"\n\
             [[trigger]]\non = \"node.slow rises 0.5\"\nplay = \"w\"\n"
        );
        let plan = plan(&text, false);
        assert_eq!(plan.watches.iter().map(|w| &*w.name).collect::<Vec<_>>(), ["node.slow rises 0.5"]);
        assert_eq!(plan.instruments.iter().map(|i| &*i.name).collect::<Vec<_>>(), ["w"]);
        let told: Vec<&str> =
            plan.left_out.iter().filter(|l| l.why == Why::NeverCrosses).map(|l| &*l.what).collect();
        assert_eq!(told, ["trigger `node.five rises 4` of `v`", "trigger `node.none rises -1` of `v`"]);
    }

    #[test]
    fn ids_are_those_of_nobody_else() {
        let ids = [id(0, 0), id(0, 1), id(1, 0), id(3, (1 << 40) - 1), id((1 << 22) - 1, 7)];
        for (n, one) in ids.iter().enumerate() {
            assert!(one >> 62 == 0b10 && ids.iter().position(|other| other == one) == Some(n), "{one:x}");
        }
    }
}
