//! The plan: everything the engine needs to know, and nothing it does not. Flat, without state.

use std::borrow::Cow;
use std::fmt;
use std::sync::Arc;

use crate::dsp::biquad::Biquad;
use crate::knob::angle::decoder::Sensor;
use crate::node::NodeKind;
use crate::node::motion::Motion;

use crate::patch::Pitch;
use crate::patch::knob::Reading;
use crate::perception::gauge::Gauge;
use crate::rig::Terminals;
use crate::space::law::Law;
use crate::space::path::Route;
use crate::space::spot::{Spot, Spread};

use crate::actuator::driver::book::Book;
use crate::actuator::driver::homing::Homing;
use crate::actuator::driver::setup::Setup;
use crate::actuator::driver::track::Track;
use crate::actuator::protect::bounds::Bounds;
use crate::actuator::protect::budget::Bears;

use super::command::Command;
use super::knob::Knob;
use super::order::depth_first;
use super::program::{Program, program};
use super::watch::Watch;
use super::{Base, Graph, NodeId, Settings, Signal, Wire, fold, late, onset, prune};

/// The number type of the lanes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Precision {
    /// 32-bit floating point.
    #[default]
    Single,
    /// 64-bit floating point.
    Double,
}

/// A compiled scene.
///
/// What [`crate::graph::scene::scene`] makes holds together, and whoever makes one by hand must see to it: channels of
/// [`Plan::places`] and [`Plan::outputs`] lie below [`Plan::channels`], every [`Shared::Control`] names one of [`Plan::controls`],
/// rates, voices and ranges are those of an engine (which refuses other plans); every [`Shared::Node`] names an output of
/// [`Plan::shared_program`]; programs read only signals that [`Plan::shared`] has. A place, an instrument or a marker that an event or a
/// watch names and that is not there is passed over.
#[derive(Debug, Clone)]
pub struct Plan {
    /// Frames a second of the device or file.
    pub device_rate: f64,
    /// Device frames for each engine sample.
    pub ratio: usize,
    /// Channels of the device or file.
    pub channels: usize,
    /// Number type of the lanes.
    pub precision: Precision,
    /// Taps a phase of the up-sampling filter.
    pub taps: usize,
    /// Seed of everything random.
    pub seed: u64,
    /// Engine-wide signals, by their number.
    pub shared: Vec<Shared>,
    /// The program that computes the shared nodes.
    pub shared_program: Program,
    /// Live parameters.
    pub controls: Vec<Control>,
    /// Voices and patterns that engine-wide signals set off.
    pub watches: Vec<Watch>,
    /// Names of the patterns that they and the knob set off.
    pub answering: Vec<Arc<str>>,
    /// Engine samples from what sets such a pattern off to its beginning; see [`super::answer::latency`].
    pub answer: u64,
    /// The voices' programs.
    pub instruments: Vec<Instrument>,
    /// Gain rows: a place as channels (from 0) with gains.
    pub places: Vec<Vec<(u32, f64)>>,
    /// What the rows behind those of the outputs are called: groups, and lists of names.
    pub together: Vec<Arc<str>>,
    /// The tactors that share points; none where no point can be played.
    pub spread: Option<Spread>,
    /// The paths that voices may go along.
    pub paths: Vec<Route>,
    /// By channel, what a tactor must be sent to be felt so strongly; none where nothing can be played that says how strongly it is felt.
    pub gauges: Arc<[Option<Gauge>]>,
    /// What hangs on channels: every output of the rig, those included that stay silent.
    pub outputs: Vec<Output>,
    /// The motors, in the order of their outputs.
    pub drives: Vec<Drive>,
    /// What the actuators on channels (from 0) bear.
    pub protections: Vec<(u32, Bounds)>,
    /// Clicks of motors that voices may order, worked out.
    pub clicks: Vec<Clicks>,
    /// Envelopes of motors that voices may order, worked out.
    pub swells: Vec<Swell>,
    /// The way home of motors that voices may send there, by their places in [`Plan::drives`].
    pub homes: Vec<(usize, Homing)>,
    /// The motors that voices may send home and that cannot be brought there, by their places in [`Plan::drives`], and why.
    pub homeless: Vec<(usize, Arc<str>)>,
    /// The force-feedback knob; `None`: the patch has none, and nothing of one is built.
    pub knob: Option<Knob>,
    /// Names of the markers that some output listens to.
    pub markers: Vec<Arc<str>>,
    /// What was left out, and why.
    pub left_out: Vec<LeftOut>,
}

impl Plan {
    /// Samples a second of the engine.
    pub fn engine_rate(&self) -> f64 {
        self.device_rate / self.ratio as f64
    }

    /// The envelopes of a motor, by their numbers.
    pub fn swells_of(&self, drive: usize) -> impl Iterator<Item = &Swell> {
        self.swells.iter().filter(move |swell| swell.drive == drive)
    }

    /// What sets something off by itself, as the patch has it and as ids count: watches, and behind them what the knob does.
    pub fn watching(&self) -> impl Iterator<Item = &Arc<str>> {
        let starts = self.knob.iter().flat_map(|knob| &knob.starts);
        self.watches.iter().map(|watch| &watch.name).chain(starts.map(|start| &start.name))
    }

    /// Whether a voice may move.
    pub fn moves(&self) -> bool {
        !self.paths.is_empty() || self.instruments.iter().any(|instrument| instrument.steered)
    }

    /// What reads a knob that is there.
    pub fn sensor(&self) -> Option<&Sensor> {
        self.knob.as_ref()?.sensor.as_ref()
    }

    /// Channels of the input that something listens to, from 0, in ascending order: what nodes hear, and a knob's sensor.
    pub fn inputs(&self) -> Vec<usize> {
        let heard = |shared: &Shared| if let Shared::Input(c) = shared { Some(*c as usize) } else { None };
        let mut inputs: Vec<usize> = self.shared.iter().filter_map(heard).collect();
        inputs.extend(self.sensor().iter().flat_map(|sensor| sensor.channels));
        inputs.sort_unstable();
        inputs.dedup();
        inputs
    }

    /// The same of what vibrates alone: motors stand still, and nothing is held back for the sake of actuators.
    #[cfg(feature = "report")]
    pub(crate) fn of_vibration(&self) -> Self {
        let mut plan = self.clone();
        // What has a position vibrates.
        let turns = |channel: u32| self.drives.iter().any(|drive| drive.channel == channel);
        plan.places.iter_mut().for_each(|place| place.retain(|(channel, _)| !turns(*channel)));
        for output in plan.outputs.iter_mut().filter(|output| output.kind == OutputKind::Drive) {
            output.kind = OutputKind::Silent;
        }
        (plan.drives, plan.clicks, plan.swells, plan.homes, plan.protections) = Default::default();
        plan.homeless.clear();
        plan.knob = None;
        plan
    }

    /// What a place is called.
    pub fn called(&self, spot: Spot) -> Cow<'_, str> {
        let mut rows =
            self.outputs.iter().map(|output| &*output.name).chain(self.together.iter().map(|name| &**name));
        spot.name(|row| rows.nth(row))
    }

    /// Of each channel, what its output says, or `otherwise` where it has none.
    pub(crate) fn by_channel<T: Clone>(&self, otherwise: T, of: impl Fn(&Output) -> T) -> Vec<T> {
        let mut all = vec![otherwise; self.channels];
        for output in &self.outputs {
            if let Some(to) = all.get_mut(output.channel as usize) {
                *to = of(output);
            }
        }
        all
    }

    /// The most that leaves each channel.
    pub(crate) fn max_levels(&self) -> Vec<f64> {
        self.by_channel(1.0, |output| output.max_level)
    }
}

/// An engine-wide signal.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shared {
    /// A live parameter, by its place.
    Control(u32),
    /// An output of the shared program.
    Node(u32),
    /// A channel of the input, from 0.
    Input(u32),
    /// What the knob does.
    Knob(Reading),
}

/// A live parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Control {
    /// Its name in the patch.
    pub name: Arc<str>,
    /// Where it starts.
    pub default: f64,
    /// The least it may be.
    pub least: f64,
    /// The most it may be.
    pub most: f64,
    /// Seconds it takes to reach a new value.
    pub smoothing: f64,
}

/// A voice of the patch.
#[derive(Debug, Clone, PartialEq)]
pub struct Instrument {
    /// Its name in the patch.
    pub name: Arc<str>,
    /// What runs.
    pub program: Program,
    /// How many may sound at once.
    pub voices: usize,
    /// Names of its own event fields, in order.
    pub fields: Vec<Arc<str>>,
    /// Their defaults.
    pub defaults: Vec<f64>,
    /// Its place where an event names none.
    pub place: Spot,
    /// By which law tactors share a point.
    pub law: Law,
    /// How far a point spreads, m.
    pub width: f64,
    /// Whether its program says where it is: its outputs from the second to the fifth are then its way from its place along x, y and z, and
    /// what its width grows by, all m.
    pub steered: bool,
    /// Seconds of silence after its envelopes have ended before it counts as over: what a delay may still bring. One that was
    /// released, whose envelopes have ended and which then does not become quieter either, by 3 % from one stretch of this and five
    /// seconds more to the next, fades.
    pub tail: f64,
    /// Its level where nothing says another.
    pub level: f64,
    /// Decibels above the threshold that a level of 1 is felt like where nothing says a level; `None`: as loud as it comes.
    pub felt: Option<f64>,
    /// The frequency at which that holds.
    pub pitch: Pitch,
    /// Sounds from the beginning, without an event.
    pub always: bool,
}

impl Instrument {
    /// What it orders of the motors at its place when it begins.
    pub fn commands(&self) -> Vec<Command> {
        self.program.ops.iter().filter_map(|op| Command::of(op.node.kind, &op.node.settings)).collect()
    }

    /// Which motions of the hand that holds a voice some node of it hears, by [`Motion::number`].
    pub fn hears(&self) -> [bool; Motion::ALL.len()] {
        let mut hears = [false; Motion::ALL.len()];
        for op in self.program.ops.iter().filter(|op| op.node.kind == NodeKind::TOUCH) {
            if let Some(slot) = op.node.settings.choices.first().and_then(|of| hears.get_mut(*of)) {
                *slot = true;
            }
        }
        hears
    }

    /// Whether its voices may go on as voices of another: the same name and event fields.
    pub(crate) fn goes_on_as(&self, new: &Self) -> bool {
        self.name == new.name && self.fields == new.fields && self.always == new.always
    }
}

/// What hangs on a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Output {
    /// Its name in the rig.
    pub name: Arc<str>,
    /// The channel, from 0.
    pub channel: u32,
    /// What is done to it.
    pub kind: OutputKind,
    /// The sections of its equaliser at the engine's rate; for vibration.
    pub equaliser: Vec<Biquad>,
    /// Whether a high-pass keeps steady voltages off it; for vibration.
    pub keeps_dc_off: bool,
    /// The most that leaves it, as a share of full scale: above 0, and 1 at most.
    pub max_level: f64,
}

/// A motor on a channel.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// The channel, from 0.
    pub channel: u32,
    /// How it is turned, at the engine's rate.
    pub setup: Setup,
    /// Volts or amperes at the motor for a sample of 1.0, negative where it is wired the other way round; behind a bridge for a pulse that never ends,
    /// before a rectifier the peak of a carrier.
    pub per_sample: f64,
    /// What becomes of what is sent.
    pub terminals: Terminals,
    /// What the motor bears for long, where what is sent is no voltage at its terminals: that is kept to by what turns it.
    pub bears: Option<Bears>,
}

/// Clicks of a motor.
#[derive(Debug, Clone, PartialEq)]
pub struct Clicks {
    /// The motor, by its place in [`Plan::drives`].
    pub drive: usize,
    /// How far they turn its mass, turns.
    pub turns: f64,
    /// By level; motors that are alike share one.
    pub book: Arc<Book>,
    /// How far the strongest turns it of a flat motor, turns: less than the others where coupling keeps some of it off.
    pub arriving: f64,
}

/// An envelope of a motor.
#[derive(Debug, Clone, PartialEq)]
pub struct Swell {
    /// The motor, by its place in [`Plan::drives`].
    pub drive: usize,
    /// The first voice that orders it.
    pub voice: Arc<str>,
    /// The settings of the node that orders it, of which the points count.
    pub settings: Arc<Settings>,
    /// Motors that are alike share one.
    pub track: Arc<Track>,
}

/// What is done to a channel on its way out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum OutputKind {
    /// Equalised, limited and band-limited.
    Vibration,
    /// Pulses at markers.
    Trigger {
        /// The marker, by its place in [`Plan::markers`]; `None`: all.
        marker: Option<u32>,
        /// Length of a pulse, seconds.
        pulse: f64,
    },
    /// The mix as it is.
    Raw,
    /// A motor is turned by it: [`Plan::drives`] says how.
    Drive,
    /// Zero.
    Silent,
}

/// Something that is not built or not run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LeftOut {
    /// What it is.
    pub what: String,
    /// Why it is not needed.
    pub why: Why,
}

/// Why something is not needed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Why {
    /// No output needs it.
    Pruned,
    /// It is known before anything sounds.
    Folded,
    /// Nothing feeds it.
    NeverFed,
    /// Nothing starts it.
    NeverTriggered,
    /// Nothing reads it.
    NeverRead,
    /// It never moves, so it never passes a threshold.
    NeverCrosses,
    /// It orders something of motors, and the rig has none.
    NoMotor,
    /// It orders something of a motor that is there for clicks alone.
    ClicksAlone,
    /// The rig has a knob, and the patch says nothing of how it feels.
    NoKnob,
    /// It is read and checked, and nothing acts on it yet.
    NotYet,
}

impl fmt::Display for Why {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Pruned => "no output needs it",
            Self::Folded => "known before anything sounds",
            Self::NeverFed => "nothing feeds it",
            Self::NeverTriggered => "nothing starts it",
            Self::NeverRead => "nothing reads it",
            Self::NeverCrosses => "its node never moves, so it never crosses",
            Self::NoMotor => "the rig has no motor: no output of kind drive",
            Self::ClicksAlone => "clicks alone get through to that motor: shaping = \"clicks\"",
            Self::NoKnob => "the patch has no [knob]",
            Self::NotYet => "nothing acts on it yet",
        })
    }
}

/// A graph, compiled: folded, pruned and put in order.
#[derive(Debug, Clone)]
pub struct Compiled {
    /// What runs.
    pub program: Program,
    /// Names of nodes that no output needs.
    pub pruned: Vec<Arc<str>>,
    /// Names of nodes that are not run because they are known before anything sounds, or because the mixer does their work; those
    /// that an oscillator takes over as its amplitude are not among them.
    pub folded: Vec<Arc<str>>,
}

/// What keeps a graph from being compiled.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Unfit {
    /// These nodes form a loop, each reading the next.
    Loop(Vec<NodeId>),
    /// An input of this node names a node or an onset value that is not there.
    Input(NodeId),
    /// This output (or this factor of the gain) names a node or an onset value that is not there.
    Output(usize),
}

impl fmt::Display for Unfit {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Loop(nodes) => write!(f, "nodes {nodes:?} read each other in a circle"),
            Self::Input(node) => write!(f, "an input of node {node} names what is not there"),
            Self::Output(output) => write!(f, "output {output} names what is not there"),
        }
    }
}

impl std::error::Error for Unfit {}

/// That wires lead to nodes and onset values that are there.
fn check(graph: &Graph) -> Result<(), Unfit> {
    let there = |base: &Base| match base {
        Base::Constant(_) => true,
        Base::Start(id) => (*id as usize) < graph.starts.len(),
    };
    let leads = |wire: &Wire| {
        let signal = match wire.signal {
            Some(Signal::Node(id) | Signal::Late(id)) => (id as usize) < graph.nodes.len(),
            Some(Signal::Shared(_)) | None => true,
        };
        signal && there(&wire.base)
    };
    if let Some(node) = graph.nodes.iter().position(|node| !node.inputs.iter().all(leads)) {
        return Err(Unfit::Input(node as NodeId));
    }
    let lost = graph.outputs.iter().position(|wire| !leads(wire));
    match lost.or_else(|| graph.gain.iter().position(|base| !there(base))) {
        Some(output) => Err(Unfit::Output(output)),
        None => Ok(()),
    }
}

/// Runs all passes over a graph. Where it is that of a voice, whose first output a mixer takes (`mixed`), steady factors of it
/// become its gain, and what was there before the onset is kept out.
/// `rate` is the engine's, Hz.
///
/// # Errors
/// A loop without a delay; a wire that leads to nothing.
pub fn compile(mut graph: Graph, mixed: bool, rate: f64) -> Result<Compiled, Unfit> {
    check(&graph)?;
    let order = late::open(&mut graph, rate).map_err(Unfit::Loop)?;
    let (graph, pruned) = prune::prune(graph, &order);
    let needed = graph.nodes.len();
    let order: Vec<NodeId> = (0..needed as NodeId).collect();
    let mut graph = fold::fold(graph, &order);
    if mixed {
        fold::take_gain(&mut graph);
        onset::begin(&mut graph);
    }
    let done_elsewhere = fold::take_amplitudes(&mut graph);
    let order = depth_first(&graph).map_err(Unfit::Loop)?;
    let (graph, folded) = prune::prune(graph, &order);
    let pruned = pruned.into_iter().map(|(_, name)| name).collect();
    let folded =
        folded.into_iter().filter(|(id, _)| !done_elsewhere[*id as usize]).map(|(_, name)| name).collect();
    Ok(Compiled { program: program(graph), pruned, folded })
}

#[cfg(test)]
mod tests {
    use super::{Unfit, compile};
    use crate::graph::{Graph, Node, Settings, Signal, Wire};
    use crate::node::NodeKind;

    #[test]
    fn wires_to_nothing_are_refused() {
        let compiled = |inputs: Vec<Wire>, output: Wire| {
            let kind = NodeKind::find("add").unwrap();
            let node = Node { name: "sum".into(), kind, settings: Settings::default().into(), inputs };
            let graph = Graph { nodes: vec![node], outputs: vec![output], ..Graph::default() };
            compile(graph, true, 8000.0).map(|c| c.program.outputs.len())
        };
        let one = Wire::constant(1.0);
        assert_eq!(compiled(vec![one, one], Wire::node(0)), Ok(1));
        assert_eq!(compiled(vec![one, Wire::node(1)], Wire::node(0)), Err(Unfit::Input(0)));
        assert_eq!(compiled(vec![one, Wire::start(0)], Wire::node(0)), Err(Unfit::Input(0)));
        let late = Wire { signal: Some(Signal::Late(7)), ..one };
        assert_eq!(compiled(vec![late, one], Wire::node(0)), Err(Unfit::Input(0)));
        assert_eq!(compiled(vec![one, one], Wire::node(3)), Err(Unfit::Output(0)));
        assert_eq!(compiled(vec![one, one], Wire::start(0)), Err(Unfit::Output(0)));
        assert_eq!(compiled(vec![one, Wire::node(0)], Wire::node(0)), Err(Unfit::Loop(vec![0])));
    }
}
