//! A patch on a rig, compiled: what is played decides what is built.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::sync::Arc;

use super::answer::{self, Answer};
use super::budget::Need;
use super::build::{self, Want, Wanted};
use super::knob::{Made, answering_as, knob};
use super::not_yet::{never_fed, not_yet};
use super::outputs::{output, places_of, spread};
use super::plan::{Control, Instrument, LeftOut, Output, Plan, Precision, Shared, Why, compile};
use super::program::Program;
use super::watch::{self, Watch};
use super::{felt, motions, motors, swells};
use crate::node::NodeKind;
use crate::node::asset::Assets;
use crate::patch::{Action, Events, Patch, Place, Scope, Source, Start, Trigger, Voice};
use crate::rig::{self, Finder, RATES, Rig, usual_ratio};
use crate::space::spot::{Spot, Spread};
use crate::text::{Problem, Problems};

/// What may be chosen about a rendering.
#[derive(Debug, Clone, PartialEq)]
pub struct Options {
    /// Frames a second; `None`: what the rig says, else 48,000.
    pub rate: Option<f64>,
    /// Device frames for each engine sample; `None`: so many that the engine runs at about 8 kHz.
    pub ratio: Option<usize>,
    /// Number type of the lanes.
    pub precision: Precision,
    /// Taps a phase of the up-sampling filter: 4 to 12.
    pub taps: usize,
    /// Seed of everything random; `None`: what the patch says, else 0.
    pub seed: Option<u64>,
    /// The pattern to play; `None`: those with a trigger `start`, and where nothing has one, the first.
    pub pattern: Option<String>,
    /// Whether a program or a trigger may play any voice at any time, so that all must be there.
    pub live: bool,
    /// Whether a knob that the rig reads by a sound card's inputs is there; else it is simulated.
    pub attached: bool,
    /// Frames of a device's block, as far as that is known; `None`: [`BLOCK`]. A knob that a card reads waits for blocks, and so do patterns
    /// that a knob or a node sets off.
    pub block: Option<u32>,
    /// Whether it is played on a card, be it a virtual one. Where the rig does not say what the card's outputs let through, steady voltages are taken to
    /// leave it, and are kept off; else they are taken not to.
    pub on_card: bool,
    /// The first input channel (from 0) at the least by which a knob on a serial line is heard: that of a scene that is to be followed, so that
    /// its line goes on where the new one listens to fewer inputs.
    pub knob_channel: usize,
}

/// Frames of a block where nobody says how many.
pub const BLOCK: u32 = 256;

impl Default for Options {
    fn default() -> Self {
        Self {
            rate: None,
            ratio: None,
            precision: Precision::Single,
            taps: 6,
            seed: None,
            pattern: None,
            live: false,
            attached: false,
            block: None,
            on_card: false,
            knob_channel: 0,
        }
    }
}

impl Options {
    /// For what is played live on a sound card, at `rate` frames a second: no steady voltage leaves where none is declared.
    pub fn for_card(rate: f64) -> Self {
        Self { rate: Some(rate), live: true, on_card: true, ..Self::default() }
    }
}

/// Rates that the engine may have, Hz.
const ENGINE_RATES: std::ops::RangeInclusive<f64> = 6_000.0..=12_000.0;

/// A compiled scene: a plan, and which patterns play from the beginning.
#[derive(Debug, Clone)]
pub struct Scene {
    /// For the engine.
    pub plan: Plan,
    /// Patterns that play from the beginning, by their place in the patch.
    pub patterns: Vec<usize>,
    /// For each voice of the patch, its instrument in the plan, if it has one.
    pub instruments: Vec<Option<u32>>,
}

/// Compiles a patch for a rig.
///
/// # Errors
/// Everything that keeps the two from playing together: recordings that cannot be read, places the rig does not have, a
/// rate out of [`RATES`], an unknown pattern, more memory than [`super::budget::MOST`].
pub fn scene(patch: &Patch, rig: &Rig, options: &Options, assets: &dyn Assets) -> Result<Scene, Problems> {
    // Files were checked when they were read; what is made or changed in code was not.
    let mut problems: Vec<Problem> = patch.check().into_iter().filter(Problem::is_error).collect();
    problems.extend(rig.check().into_iter().filter(Problem::is_error).map(|p| Problem { span: None, ..p }));
    if !problems.is_empty() {
        return Err(patch.origin.problems(problems));
    }
    let device_rate = options.rate.or(rig.device.rate).unwrap_or(48_000.0);
    let [least, most] = RATES;
    if !(least..=most).contains(&device_rate) {
        problems.push(Problem::of_file(format!(
            "a rate of {device_rate} Hz is not between {least} and {most} Hz"
        )));
    }
    let ratio = options.ratio.unwrap_or_else(|| usual_ratio(device_rate));
    let engine_rate = device_rate / ratio as f64;
    if problems.is_empty() && !ENGINE_RATES.contains(&engine_rate) {
        let (least, most) = (ENGINE_RATES.start(), ENGINE_RATES.end());
        let what = format!(
            "a ratio of {ratio} at {device_rate} Hz lets the engine run at {engine_rate} Hz; it can from {least} to {most} Hz"
        );
        let help = format!("the usual ratio here is {}", usual_ratio(device_rate));
        problems.push(Problem::of_file(what).help(help));
    }
    if !problems.is_empty() {
        return Err(patch.origin.problems(problems));
    }
    let mut left_out = Vec::new();
    let patterns = patterns(patch, options, &mut problems);
    let (watched, still) = watch::split(patch, assets, engine_rate);
    let voices = voices(patch, &patterns, &watched, options.live, &mut left_out);

    let mut wanted = Wanted::default();
    let scope = Scope::new(patch, None);
    let (mut instruments, mut of_voice) = (Vec::new(), vec![None; patch.voices.len()]);
    let finder = Finder::with(rig, patch);
    for &v in &voices {
        let voice = &patch.voices[v];
        let graph = match build::voice(&scope, voice, assets, &mut wanted) {
            Ok(graph) => graph,
            Err(more) => {
                problems.extend(more);
                continue;
            }
        };
        let place = rig.resolve_by(&finder, voice.place.as_ref(), &voice.place_span).unwrap_or_else(|p| {
            problems.push(p);
            Spot::default()
        });
        match compile(graph, true, device_rate / ratio as f64) {
            Ok(compiled) => {
                let steers = voice.steering();
                let mut pruned = compiled.pruned;
                pruned.retain(|name| steers.is_none_or(|node| node.name != **name));
                note(&voice.name, &pruned, &compiled.folded, &mut left_out);
                of_voice[v] = Some(instruments.len() as u32);
                instruments.push(Instrument {
                    name: voice.name.as_str().into(),
                    voices: voice.voices as usize,
                    fields: voice.fields.iter().map(|(n, _)| n.as_str().into()).collect(),
                    defaults: voice.fields.iter().map(|(_, x)| *x).collect(),
                    place,
                    law: voice.law,
                    width: voice.width,
                    steered: steers.is_some(),
                    tail: voice.tail.unwrap_or_else(|| tail(&compiled.program)),
                    level: voice.strength(None, None).0,
                    felt: voice.strength(None, None).1,
                    pitch: voice.pitch(),
                    always: voice.start == Start::Always,
                    program: compiled.program,
                });
            }
            Err(why) => problems.push(Problem::error(&voice.span, format!("voice `{}`: {why}", voice.name))),
        }
    }
    let made = Made {
        patch,
        rig,
        finder: &finder,
        of_voice: &of_voice,
        rates: [device_rate / ratio as f64, device_rate],
        is_live: options.live,
        attached: options.attached,
        block: options.block.unwrap_or(BLOCK),
    };
    let mut answering = Vec::new();
    let mut knob = knob(&made, &mut wanted, &mut answering, &mut problems);
    let watches =
        watches(patch, rig, &finder, &watched, &of_voice, &mut wanted, &mut answering, &mut problems);
    left_out.extend(still.iter().filter_map(|place| {
        let trigger = patch.triggers.get(*place)?;
        let what = format!("trigger `{}` of `{}`", watch::words(trigger)?, trigger.play);
        Some(LeftOut { what, why: Why::NeverCrosses })
    }));
    let (shared, shared_program) =
        shared(patch, &mut wanted, assets, device_rate / ratio as f64, &mut left_out, &mut problems);
    let (shared, controls) = controls(patch, shared, &mut left_out);
    if rig.knob.as_ref().is_some_and(|knob| knob.controller.is_some()) {
        knob.iter_mut().for_each(|knob| knob.hear_behind(&shared, options.knob_channel));
    }
    let mut markers = Vec::new();
    let steady = rig.device.passes_steady(options.on_card);
    let outputs: Vec<Output> = rig
        .outputs
        .iter()
        .map(|o| output(o, rig, steady, device_rate / ratio as f64, &mut markers, &mut problems))
        .collect();
    let is_felt = felt::is_felt(patch);
    let tables = patch.patterns.iter().any(|pattern| matches!(pattern.events, Events::File(..)));
    let gauges = if is_felt || tables || options.live {
        felt::gauges(rig, &outputs, device_rate / ratio as f64, is_felt, &mut problems)
    } else {
        Arc::default()
    };
    felt::check(patch, rig, &finder, &gauges, &mut problems);
    let mut points = options.live;
    patch.each_place(|place, _| points |= matches!(place, Place::Position(_) | Place::Path(_)));
    points |= instruments.iter().any(|instrument| instrument.steered);
    let spread = if points || tables { spread(rig, &mut problems) } else { None };
    if spread.is_none() {
        problems.extend(voices.iter().filter_map(|v| nowhere(patch.voices.get(*v)?)));
    }
    motions::check(patch, spread.as_ref().map(Spread::array), &mut problems);
    let drives = motors::drives(rig, [device_rate / ratio as f64, device_rate], &mut problems);
    let protections = motors::protections(rig, device_rate, &mut problems);
    let clicks = motors::clicks(rig, &drives, device_rate, &instruments, &mut problems);
    let swells = swells::swells(rig, &drives, &instruments, &mut problems);
    let (homes, homeless) = motors::homes(rig, &drives, &instruments, &mut problems);
    if !problems.is_empty() {
        return Err(patch.origin.problems(problems));
    }
    let silent = rig.outputs.iter().filter(|o| o.kind == rig::OutputKind::Torque && knob.is_none());
    left_out.extend(silent.map(|o| LeftOut { what: format!("output `{}`", o.name), why: Why::NoKnob }));
    if !options.live {
        left_out.extend(never_fed(patch, rig, &voices));
    }
    if drives.is_empty() {
        left_out.extend(motors::for_nobody(&instruments));
    }
    left_out.extend(motors::for_clicks_alone(rig, &drives, &instruments));
    left_out.extend(not_yet(rig));
    let plan = Plan {
        device_rate,
        ratio,
        channels: rig.device.channels as usize,
        precision: options.precision,
        taps: options.taps,
        seed: options.seed.or(patch.render.seed).unwrap_or(0),
        shared,
        shared_program,
        controls,
        watches,
        answering,
        answer: answer::latency(options.block.unwrap_or(BLOCK), device_rate, engine_rate),
        instruments,
        places: places_of(rig, &finder, knob.is_some()),
        together: finder.called().map(Arc::from).collect(),
        spread,
        paths: finder.paths().to_vec(),
        gauges,
        outputs,
        drives,
        protections,
        clicks,
        swells,
        homes,
        homeless,
        markers,
        knob,
        left_out,
    };
    let need = Need::of(&plan);
    if need.is_too_much() {
        let of = |i: &Option<u32>| need.most.instrument == i.map(|i| i as usize);
        let voice = of_voice.iter().position(of).filter(|_| need.most.instrument.is_some());
        let span = voice.and_then(|v| patch.voices.get(v)).map(|voice| {
            let node =
                need.most.node.as_ref().and_then(|(name, _)| voice.nodes.iter().find(|n| *n.name == **name));
            node.map_or(&voice.span, |node| &node.span).clone()
        });
        return Err(patch.origin.problems(vec![Problem { span, ..need.problem() }]));
    }
    Ok(Scene { plan, patterns, instruments: of_voice })
}

/// That a voice says where it is, and no tactor is anywhere.
fn nowhere(voice: &Voice) -> Option<Problem> {
    let node = voice.steering()?;
    let what = format!(
        "voice `{}` says where it is, by its node `{}`, but no tactor of the rig has a position",
        voice.name, node.name
    );
    Some(Problem::error(&node.span, what).help("give the tactors a `position`".to_string()))
}

/// Where each name stands first.
fn places<'a>(
    names: impl DoubleEndedIterator<Item = &'a str> + ExactSizeIterator,
) -> HashMap<&'a str, usize> {
    names.enumerate().rev().map(|(place, name)| (name, place)).collect()
}

fn patterns(patch: &Patch, options: &Options, problems: &mut Vec<Problem>) -> Vec<usize> {
    let by_name = places(patch.patterns.iter().map(|p| p.name.as_str()));
    let find = |name: &str| by_name.get(name).copied();
    if let Some(name) = &options.pattern {
        return match find(name) {
            Some(i) => vec![i],
            None => {
                let names: Vec<_> = patch.patterns.iter().map(|p| p.name.as_str()).collect();
                let what = format!("there is no pattern `{name}`; there is {}", names.join(", "));
                problems.push(Problem::of_file(what));
                Vec::new()
            }
        };
    }
    let started: Vec<usize> =
        patch.triggers.iter().filter(|t| t.on == Source::Start).filter_map(|t| find(&t.play)).collect();
    let any_start = patch.triggers.iter().any(|t| t.on == Source::Start);
    // Where keys and messages play, patterns wait for them; and where nodes or a knob play patterns.
    let by_hand = |trigger: &Trigger| trigger.on.by_itself().is_none();
    let waits = options.live && patch.triggers.iter().any(by_hand) || patch.set_off().next().is_some();
    let mut playing = if any_start || waits || patch.patterns.is_empty() { started } else { vec![0] };
    // What a clock starts is ready for it.
    let clocked = patch.patterns.iter().enumerate().filter(|(_, pattern)| pattern.follows).map(|(i, _)| i);
    for pattern in clocked {
        if !playing.contains(&pattern) {
            playing.push(pattern);
        }
    }
    playing
}

/// The voices that may sound: those of the patterns that play, of triggers, and those that always do.
/// `watched`: the triggers that nodes may set off, by their places.
fn voices(
    patch: &Patch,
    patterns: &[usize],
    watched: &[usize],
    live: bool,
    left_out: &mut Vec<LeftOut>,
) -> BTreeSet<usize> {
    let voices = places(patch.voices.iter().map(|v| v.name.as_str()));
    let patterns_by_name = places(patch.patterns.iter().map(|p| p.name.as_str()));
    let voice = |name: &str| voices.get(name).copied();
    let pattern = |name: &str| patterns_by_name.get(name).copied();
    let mut found: BTreeSet<usize> =
        patch.voices.iter().enumerate().filter(|(_, v)| v.start == Start::Always).map(|(i, _)| i).collect();
    let mut played = BTreeSet::new();
    let mut open: Vec<usize> = patterns.to_vec();
    if live {
        found.extend(0..patch.voices.len());
        open.extend(0..patch.patterns.len());
    }
    found.extend(patch.triggers.iter().filter(|t| t.on == Source::Start).filter_map(|t| voice(&t.play)));
    let by_knob = patch.triggers.iter().filter(|trigger| matches!(trigger.on, Source::Knob { .. }));
    let by_nodes = watched.iter().filter_map(|place| patch.triggers.get(*place));
    for trigger in by_knob.chain(by_nodes) {
        found.extend(voice(&trigger.play));
        open.extend(patch.pattern_of(trigger).and_then(pattern));
    }
    while let Some(p) = open.pop() {
        if !played.insert(p) {
            continue;
        }
        let Events::Inline(events) = &patch.patterns[p].events else {
            // What a file plays is known only when it is read.
            found.extend(0..patch.voices.len());
            continue;
        };
        for event in events {
            let mut visit = |action: &Action| match action {
                Action::Voice(play) => found.extend(voice(&play.voice)),
                Action::Pattern { pattern: name, .. } => open.extend(pattern(name)),
                Action::Marker(_) | Action::Choose(_) => {}
            };
            visit(&event.action);
            if let Action::Choose(list) = &event.action {
                list.iter().for_each(|a| visit(&a.action));
            }
        }
    }
    let unused =
        |kind: &str, name: &str| LeftOut { what: format!("{kind} `{name}`"), why: Why::NeverTriggered };
    left_out.extend(
        patch
            .voices
            .iter()
            .enumerate()
            .filter(|(i, _)| !found.contains(i))
            .map(|(_, v)| unused("voice", &v.name)),
    );
    left_out.extend(
        patch
            .patterns
            .iter()
            .enumerate()
            .filter(|(i, _)| !played.contains(i))
            .map(|(_, p)| unused("pattern", &p.name)),
    );
    found
}

/// What engine-wide signals set off: triggers by their places in the patch.
#[expect(clippy::too_many_arguments, reason = "what is found goes three ways")]
fn watches(
    patch: &Patch,
    rig: &Rig,
    finder: &Finder,
    watched: &[usize],
    of_voice: &[Option<u32>],
    wanted: &mut Wanted,
    answering: &mut Vec<Arc<str>>,
    problems: &mut Vec<Problem>,
) -> Vec<Watch> {
    let scope = Scope::new(patch, None);
    let voices = places(patch.voices.iter().map(|v| v.name.as_str()));
    let mut watches = Vec::with_capacity(watched.len());
    for trigger in watched.iter().filter_map(|place| patch.triggers.get(*place)) {
        if let Some(name) = patch.pattern_of(trigger) {
            let started = watch::started(trigger, answering_as(answering, name));
            watches.extend(watch::watch(trigger, Answer::Pattern(started), &scope, wanted));
            continue;
        }
        let voice = voices
            .get(trigger.play.as_str())
            .and_then(|v| Some((patch.voices.get(*v)?, (*of_voice.get(*v)?)?)));
        // That of a voice which could not be built has been told of.
        let Some((voice, instrument)) = voice else { continue };
        let (place, span) = match &trigger.place {
            Some(place) => (Some(place), &trigger.span),
            None => (voice.place.as_ref(), &voice.place_span),
        };
        match rig.resolve_by(finder, place, span) {
            Ok(place) => {
                let voiced = watch::voiced(trigger, voice, instrument, place);
                watches.extend(watch::watch(trigger, Answer::Voice(voiced), &scope, wanted));
            }
            Err(problem) => problems.push(problem),
        }
    }
    watches
}

/// How long a voice's delays may be silent and still bring something: their longest times, one after the other.
fn tail(program: &Program) -> f64 {
    let delays = program.ops.iter().filter(|op| op.node.kind == NodeKind::DELAY);
    delays.filter_map(|op| op.node.settings.constants.first()).sum()
}

fn note(owner: &str, pruned: &[Arc<str>], folded: &[Arc<str>], left_out: &mut Vec<LeftOut>) {
    for (names, why) in [(pruned, Why::Pruned), (folded, Why::Folded)] {
        // What expressions of a knob have become is nobody's node.
        let names: BTreeSet<&str> = names.iter().map(|n| &**n).filter(|n| !n.starts_with("knob.")).collect();
        left_out.extend(
            names.into_iter().map(|name| LeftOut { what: format!("node `{name}` of `{owner}`"), why }),
        );
    }
}

/// The program of the shared nodes that somebody reads, and what each engine-wide signal is.
fn shared(
    patch: &Patch,
    wanted: &mut Wanted,
    assets: &dyn Assets,
    rate: f64,
    left_out: &mut Vec<LeftOut>,
    problems: &mut Vec<Problem>,
) -> (Vec<Want>, Program) {
    let outputs: Vec<usize> =
        wanted.list.iter().filter_map(|w| if let Want::Node(i) = w { Some(*i) } else { None }).collect();
    if outputs.is_empty() {
        left_out.extend(
            patch
                .shared
                .iter()
                .map(|n| LeftOut { what: format!("shared node `{}`", n.name), why: Why::NeverRead }),
        );
        return (wanted.list.clone(), Program::default());
    }
    let graph = match build::shared(patch, &outputs, assets, wanted) {
        Ok(graph) => graph,
        Err(more) => {
            problems.extend(more);
            return (wanted.list.clone(), Program::default());
        }
    };
    match compile(graph, false, rate) {
        Ok(compiled) if !compiled.program.late.is_empty() => {
            problems.push(Problem::of_file("the shared nodes have a loop; loops may stand in voices only"));
            (wanted.list.clone(), Program::default())
        }
        Ok(compiled) => {
            note("shared", &compiled.pruned, &compiled.folded, left_out);
            (wanted.list.clone(), compiled.program)
        }
        Err(why) => {
            problems.push(Problem::of_file(format!("the shared nodes: {why}")));
            (wanted.list.clone(), Program::default())
        }
    }
}

/// Engine-wide signals with controls numbered as in the plan; controls that nothing reads are left out.
fn controls(patch: &Patch, wanted: Vec<Want>, left_out: &mut Vec<LeftOut>) -> (Vec<Shared>, Vec<Control>) {
    let mut controls = Vec::new();
    let mut output = 0;
    let shared = wanted
        .iter()
        .map(|want| match *want {
            Want::Control(i) => {
                let control = &patch.controls[i];
                controls.push(Control {
                    name: control.name.as_str().into(),
                    default: control.default,
                    least: control.range[0],
                    most: control.range[1],
                    smoothing: control.smoothing,
                });
                Shared::Control(controls.len() as u32 - 1)
            }
            Want::Node(_) => {
                output += 1;
                Shared::Node(output - 1)
            }
            Want::Input(channel) => Shared::Input(channel),
            Want::Knob(reading) => Shared::Knob(reading),
        })
        .collect();
    let names: HashSet<&str> = controls.iter().map(|c| &*c.name).collect();
    let read = |name: &str| names.contains(name);
    left_out.extend(
        patch
            .controls
            .iter()
            .filter(|c| !read(&c.name))
            .map(|c| LeftOut { what: format!("control `{}`", c.name), why: Why::NeverRead }),
    );
    (shared, controls)
}
