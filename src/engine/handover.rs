//! From one plan to the next while it sounds.
//!
//! The control thread compares the two plans, allocates everything the new one needs and says which part of the old goes
//! where. The audio thread swaps pointers: voices that still exist keep sounding with their states, controls keep their
//! values, waiting events keep their times. A voice that the new plan computes in another way, or sends elsewhere, sounds from both engines
//! meanwhile, in the old one from a copy of its states: its part there falls from 1 to 0 while that in the new one rises from 0 to 1
//! in 50 ms. Between two vibrations there is then no step larger than those of the larger one. Voices that have no counterpart
//! fall silent in the same time in the old engine, which then goes back to the control thread to be freed.
//!
//! What takes long to copy, the past of delays, is copied ahead, a little with every call, while the old plan goes on; the new one takes over when it
//! has all but the last of it.

use std::collections::{HashMap, VecDeque};
use std::fmt;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use super::Engine;
use super::succession::Succession;
use super::vibration::single;
use crate::graph::Node;
use crate::graph::answer::Answer;
use crate::graph::budget;
use crate::graph::plan::{Instrument, Output, Plan, Precision};
use crate::graph::program::Program;
use crate::graph::watch::Watch;
use crate::node::{NodeKind, States};
use crate::space::path::Route;
use crate::space::spot::Spot;

/// What a new plan takes over from an old one.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Inheritance {
    /// For each instrument of the new plan: the old one, and for each op the old op.
    pub instruments: Vec<Option<(usize, Vec<Option<usize>>)>>,
    /// For each op of the shared program: the old op.
    pub shared: Vec<Option<usize>>,
    /// For each row of places of the old plan: that of the new one.
    pub places: Vec<Option<u32>>,
    /// For each path of the old plan: the same in the new one.
    pub paths: Vec<Option<u32>>,
    /// For each control: the old control.
    pub controls: Vec<Option<usize>>,
    /// For each watch of the old plan: the new one that waits for the same.
    pub watches: Vec<Option<usize>>,
    /// Whether engine-wide signals are computed as they were.
    pub same_signals: bool,
    /// Whether motors get other envelopes.
    pub swells: bool,
    /// The most that leaves each channel, where that differs.
    pub levels: Option<Vec<f32>>,
    /// By channel: whether what is played there may jump, as it goes there in another way.
    pub jumps: Vec<bool>,
    /// For each instrument of the new plan: whether its voices may jump, as they are computed in another way.
    pub changed: Vec<bool>,
}

impl Inheritance {
    /// Whether the voices of an instrument of the new plan are computed in another way.
    pub fn is_changed(&self, instrument: usize) -> bool {
        self.changed.get(instrument).copied().unwrap_or(true)
    }

    /// Whether voices of an instrument of the new plan may cross over, so that both engines must have their states.
    pub fn may_cross(&self, instrument: usize) -> bool {
        self.is_changed(instrument) || self.jumps.contains(&true)
    }

    /// Where a place of the old plan is in the new one; `None` where it is nowhere.
    pub fn spot(&self, old: Spot) -> Option<Spot> {
        match old {
            Spot::Row(row) => self.places.get(row as usize).copied().flatten().map(Spot::Row),
            Spot::Point(_) => Some(old),
            Spot::Path(path) => self.paths.get(path as usize).copied().flatten().map(Spot::Path),
        }
    }
}

/// A new engine with what it takes over, ready for the audio thread.
pub(crate) struct Handover {
    /// The engine of the new plan.
    pub(super) engine: Engine,
    /// What it takes over.
    pub(super) inheritance: Inheritance,
    /// How far it has come, as the control thread sees it.
    pub(super) passage: Arc<Passage>,
}

/// What both sides know of a plan that is to take over.
#[derive(Debug)]
pub(crate) struct Passage {
    /// Whether what it takes over can be taken over within one call.
    pub ready: AtomicBool,
    /// Whether it may.
    pub admitted: AtomicBool,
}

/// Why a plan cannot follow another without a new beginning.
#[derive(Debug, Clone, PartialEq)]
pub enum Mismatch {
    /// Frames a second: those that play, and those of the new plan.
    Rate(f64, f64),
    /// Channels: those that play, and those of the new plan.
    Channels(usize, usize),
    /// The filter that brings up the rate is another.
    Filter,
    /// The new plan listens to more channels than the old one.
    Inputs,
    /// What reads the knob differs, or at which rate.
    Sensor,
    /// The number type of the lanes differs.
    Precision,
    /// The new plan cannot be built at all.
    Refused(String),
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Rate(old, new) => {
                write!(f, "the new rig has {new} frames a second, and {old} play: stop, and play again")
            }
            Self::Channels(old, new) => {
                write!(f, "the new rig has {new} channels, and {old} play: stop, and play again")
            }
            Self::Filter => f.write_str("the new plan is brought up to the device's rate by another filter"),
            Self::Inputs => f.write_str("the new patch listens to further input channels"),
            Self::Sensor => f.write_str("a knob is read that was not, or otherwise than before"),
            Self::Precision => f.write_str("the new plan computes with other numbers"),
            Self::Refused(why) => f.write_str(why),
        }
    }
}

impl std::error::Error for Mismatch {}

/// How many channels of an input an engine of a plan hears.
pub(crate) fn listens(plan: &Plan) -> usize {
    plan.inputs().last().map_or(0, |channel| channel + 1)
}

/// Makes a new engine ready to follow one that runs `old` and hears so many channels, whatever `old` makes of them. For the control thread: it allocates.
///
/// # Errors
/// Plans that differ in what cannot change while it sounds.
pub(crate) fn prepare(old: &Plan, new: &Plan, hears: usize) -> Result<Handover, Mismatch> {
    if old.device_rate != new.device_rate {
        return Err(Mismatch::Rate(old.device_rate, new.device_rate));
    }
    if old.channels != new.channels {
        return Err(Mismatch::Channels(old.channels, new.channels));
    }
    if (old.ratio, old.taps) != (new.ratio, new.taps) {
        return Err(Mismatch::Filter);
    }
    if old.precision != new.precision {
        return Err(Mismatch::Precision);
    }
    if listens(new) > hears {
        return Err(Mismatch::Inputs);
    }
    let reads = |plan: &Plan| plan.sensor().copied().zip(plan.knob.as_ref().map(|knob| knob.ticks));
    if reads(new).is_some() && reads(old) != reads(new) {
        return Err(Mismatch::Sensor);
    }
    let mut engine = Engine::new(new).map_err(|why| Mismatch::Refused(why.to_string()))?;
    engine.expect_voices();
    let instruments = new
        .instruments
        .iter()
        .map(|instrument| {
            let (i, same) = old.instruments.iter().enumerate().find(|(_, o)| o.goes_on_as(instrument))?;
            Some((i, ops(&same.program, &instrument.program)))
        })
        .collect();
    let controls = new.controls.iter().map(|c| old.controls.iter().position(|o| o.name == c.name)).collect();
    let shared = ops(&old.shared_program, &new.shared_program);
    let succession = Succession::between(old, new);
    let levels = new.max_levels();
    let levels = (succession.is_some() || old.max_levels() != levels)
        .then(|| levels.into_iter().map(single).collect());
    let same_signals = old.shared_program == new.shared_program && old.shared == new.shared;
    let same_ways = (&old.spread, &old.paths) == (&new.spread, &new.paths);
    let path = |path: &Route| new.paths.iter().position(|other| other == path).map(|n| n as u32);
    let paths = old.paths.iter().map(path).collect();
    let (watches, places) = (watches(old, new), places(old, new));
    let jumps = jumps(old, new, &places);
    let is_another = |instrument: &Instrument| {
        !same_signals || !same_ways || !old.instruments.iter().any(|o| o == instrument)
    };
    let changed = new.instruments.iter().map(is_another).collect();
    if let Some(succession) = succession {
        engine.expect_succession(succession);
    }
    let swells = old.swells != new.swells;
    let inheritance = Inheritance {
        instruments,
        places,
        paths,
        shared,
        controls,
        watches,
        same_signals,
        swells,
        levels,
        jumps,
        changed,
    };
    let ready = past(new, &inheritance) <= AT_ONCE;
    let passage = Passage { ready: AtomicBool::new(ready), admitted: AtomicBool::new(false) };
    Ok(Handover { engine, inheritance, passage: Arc::new(passage) })
}

/// For each row of the old plan's places that of the new one that has its name: of an output, or of what sounds together.
fn places(old: &Plan, new: &Plan) -> Vec<Option<u32>> {
    let output = |old: &Output| new.outputs.iter().position(|output| output.name == old.name);
    let outputs = new.outputs.len();
    let together =
        |name: &Arc<str>| new.together.iter().position(|other| other == name).map(|row| outputs + row);
    let rows = old.outputs.iter().map(output).chain(old.together.iter().map(together));
    rows.take(old.places.len()).map(|row| row.map(|row| row as u32)).collect()
}

/// Bytes of the past of delays that are copied in one call: an eighth of a millisecond where none of them is in the caches.
const AT_ONCE: usize = 1 << 18;

/// Bytes of the past of all delays that may have to be copied for a new plan.
fn past(new: &Plan, inheritance: &Inheritance) -> usize {
    let rate = new.engine_rate();
    let bytes = |node: &Node| match new.precision {
        Precision::Single => States::<f32>::bytes(node.kind, &node.setup(rate, rate)),
        Precision::Double => States::<f64>::bytes(node.kind, &node.setup(rate, rate)),
    };
    let of = |program: &Program, ops: &[Option<usize>]| -> usize {
        let kept = program.ops.iter().zip(ops).filter(|(_, from)| from.is_some());
        kept.filter(|(op, _)| op.node.kind == NodeKind::DELAY).map(|(op, _)| bytes(&op.node)).sum()
    };
    let instruments = new.instruments.iter().zip(&inheritance.instruments).enumerate();
    let instruments = instruments.filter(|(number, _)| inheritance.may_cross(*number));
    let voices = instruments.filter_map(|(_, (instrument, from))| {
        Some(of(&instrument.program, &from.as_ref()?.1) * budget::groups(instrument.voices))
    });
    voices.sum::<usize>() + of(&new.shared_program, &inheritance.shared)
}

/// By channel, whether a row of places that goes on as another has another gain there, or one that does not go on has any.
fn jumps(old: &Plan, new: &Plan, rows: &[Option<u32>]) -> Vec<bool> {
    let mut jumps = vec![false; new.channels];
    for (before, row) in old.places.iter().zip(rows) {
        let after = row.and_then(|row| new.places.get(row as usize)).map_or(&[][..], Vec::as_slice);
        let only = |one: &[(u32, f64)], other: &[(u32, f64)]| -> Vec<u32> {
            one.iter().filter(|gain| !other.contains(gain)).map(|(channel, _)| *channel).collect()
        };
        for channel in only(before, after).into_iter().chain(only(after, before)) {
            jumps.iter_mut().skip(channel as usize).take(1).for_each(|jumps| *jumps = true);
        }
    }
    jumps
}

/// For each watch of an old plan the new one with the same signal, threshold, direction and voice or pattern that has not been given away.
fn watches(old: &Plan, new: &Plan) -> Vec<Option<usize>> {
    let key = |plan: &Plan, watch: &Watch| {
        let voice = |number: u32| plan.instruments.get(number as usize).map(|i| Arc::clone(&i.name));
        let pattern = |number: u32| plan.answering.get(number as usize).cloned();
        let plays = match watch.answer {
            Answer::Voice(voiced) => (voice(voiced.instrument), None),
            Answer::Pattern(started) => (None, pattern(started.pattern)),
        };
        (Arc::clone(&watch.name), plays)
    };
    let mut known: HashMap<_, VecDeque<usize>> = HashMap::new();
    for (place, watch) in new.watches.iter().enumerate() {
        known.entry(key(new, watch)).or_default().push_back(place);
    }
    old.watches.iter().map(|watch| known.get_mut(&key(old, watch))?.pop_front()).collect()
}

/// For each new op the old op of the same name, type and settings that has not been given away.
fn ops(old: &Program, new: &Program) -> Vec<Option<usize>> {
    let mut given = vec![false; old.ops.len()];
    new.ops
        .iter()
        .map(|op| {
            let node = &op.node;
            let found = old.ops.iter().enumerate().position(|(i, o)| {
                let other = &o.node;
                !given[i]
                    && (&other.name, other.kind) == (&node.name, node.kind)
                    && other.settings == node.settings
                    && other.inputs.len() == node.inputs.len()
            })?;
            given[found] = true;
            Some(found)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::{Mismatch, listens, prepare};
    use crate::graph::scene::{Options, scene};
    use crate::node::asset::NoAssets;
    use crate::patch::Patch;
    use crate::rig::Rig;

    fn plan(nodes: &str, channels: u32) -> super::Plan {
        let text = format!(
            "format = \"pacinian-patch/1\"\ntitle = \"t\"\n[voice.v]\noutput = \"out\"\n[voice.v.nodes]\n{nodes}"
        );
        let patch = Patch::parse("t", text.as_bytes()).unwrap_or_else(|p| panic!("{p}")).value;
        let options = Options { live: true, ..Options::default() };
        scene(&patch, &Rig::default_for(channels), &options, &NoAssets).unwrap().plan
    }

    #[test]
    fn what_keeps_its_name_and_type_is_taken_over() {
        let sine = r#"tone = { type = "sine", frequency = 60 }"#;
        let old = plan(&format!("{sine}\nout = {{ type = \"multiply\", inputs = [\"tone\", \"tone\"] }}"), 4);
        let new = plan(
            &format!(
                "{sine}\nhit = {{ type = \"envelope\" }}\nout = {{ type = \"multiply\", inputs = [\"tone\", \"hit\"] }}"
            ),
            4,
        );
        let handover = prepare(&old, &new, 0).unwrap_or_else(|e| panic!("{e}"));
        let (instrument, ops) = handover.inheritance.instruments[0].clone().unwrap();
        assert_eq!(instrument, 0);
        let names: Vec<_> = new.instruments[0].program.ops.iter().map(|o| o.node.name.to_string()).collect();
        for (name, from) in names.iter().zip(&ops) {
            assert_eq!(from.is_some(), name != "hit", "{name}");
        }
        assert!(matches!(
            prepare(&old, &plan(sine.replace("tone", "out").as_str(), 5), 0),
            Err(Mismatch::Channels(4, 5))
        ));
    }

    #[test]
    fn a_plan_that_listens_to_more_than_before_begins_anew() {
        let of = |channel: u32| plan(&format!("out = {{ type = \"input\", channel = {channel} }}"), 1);
        let deaf = plan("out = { type = \"sine\", frequency = 60 }", 1);
        for (old, new) in [(&deaf, &of(1)), (&of(1), &of(2))] {
            assert!(matches!(prepare(old, new, listens(old)), Err(Mismatch::Inputs)));
            assert!(prepare(new, old, listens(new)).is_ok());
            assert!(prepare(old, new, listens(new)).is_ok(), "the engine still hears as much");
        }
    }
}
