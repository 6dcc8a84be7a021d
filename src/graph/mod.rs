//! A checked node graph and the passes that turn it into a [`plan::Plan`]: loops are opened (late), then prune, fold, onset,
//! order, prune again. Each pass is one function.

pub mod answer;
mod arrival;
pub mod budget;
mod build;
pub mod command;
pub mod felt;
mod fold;
pub mod knob;
mod late;
pub mod motions;
mod motors;
mod not_yet;
mod onset;
mod order;
mod outputs;
pub mod places;
pub mod plan;
pub mod program;
mod prune;
pub mod quick;
pub mod scene;
pub mod start;
pub mod swells;
pub mod watch;

use std::sync::Arc;

use crate::node::NodeKind;
use crate::node::asset::Asset;
use crate::node::kernel::{Point, Setup};
use start::StartId;

/// A node of a graph, by its place.
pub type NodeId = u32;

/// Where an input comes from: a part that is known at the onset, and perhaps a signal.
///
/// A frequency adds the two; any other input with a signal has a base of zero.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wire {
    /// Known when the voice starts, or before.
    pub base: Base,
    /// Moves while it sounds.
    pub signal: Option<Signal>,
}

/// The part of an input that does not move while a voice sounds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Base {
    /// Known when the patch is loaded.
    Constant(f64),
    /// Worked out when the voice starts.
    Start(StartId),
}

/// The part of an input that moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Signal {
    /// A node of the same graph.
    Node(NodeId),
    /// A node of the same graph, one sample ago.
    Late(NodeId),
    /// An engine-wide signal: a control, an audio input, or a shared node, by its place in the plan's list.
    Shared(u32),
}

impl Wire {
    /// A number.
    pub const fn constant(value: f64) -> Self {
        Self { base: Base::Constant(value), signal: None }
    }
    /// A node's output.
    pub const fn node(id: NodeId) -> Self {
        Self { base: Base::Constant(0.0), signal: Some(Signal::Node(id)) }
    }
    /// An engine-wide signal.
    pub const fn shared(index: u32) -> Self {
        Self { base: Base::Constant(0.0), signal: Some(Signal::Shared(index)) }
    }
    /// A value worked out at the onset.
    pub const fn start(id: StartId) -> Self {
        Self { base: Base::Start(id), signal: None }
    }
}

/// What a node is, apart from its wires.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Settings {
    /// Constant parameters, in order.
    pub constants: Vec<f64>,
    /// Choices and flags, in order.
    pub choices: Vec<usize>,
    /// Breakpoints.
    pub points: Vec<Point>,
    /// The recording.
    pub asset: Option<Arc<Asset>>,
    /// See [`Setup::begins`].
    pub begins: bool,
}

/// A node with its wires.
#[derive(Debug, Clone, PartialEq)]
pub struct Node {
    /// The name in the patch; nodes made from expressions are named after the parameter.
    pub name: Arc<str>,
    /// Its type.
    pub kind: NodeKind,
    /// What it is.
    pub settings: Arc<Settings>,
    /// One for each input, in the order of the parameters.
    pub inputs: Vec<Wire>,
}

/// The graph of one instrument, or of what is shared.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Graph {
    /// In any order.
    pub nodes: Vec<Node>,
    /// What is worked out at the onset.
    pub starts: Vec<start::StartProgram>,
    /// What leaves: one wire for a voice, any number for what is shared.
    pub outputs: Vec<Wire>,
    /// Gain of the first output, worked out at the onset: factors that folding took out of the graph.
    pub gain: Vec<Base>,
}

impl Node {
    /// Names its random numbers: the same as long as it keeps its name (FNV-1a of it).
    pub fn stream(&self) -> u64 {
        self.name
            .bytes()
            .fold(0xCBF2_9CE4_8422_2325, |hash, b| (hash ^ u64::from(b)).wrapping_mul(0x100_0000_01B3))
    }
    /// What its kernel or its twin is told, at `rate`, in an engine that runs at `engine_rate`.
    pub fn setup(&self, rate: f64, engine_rate: f64) -> Setup {
        Setup {
            rate,
            engine_rate,
            constants: self.settings.constants.clone(),
            choices: self.settings.choices.clone(),
            points: self.settings.points.clone(),
            asset: self.settings.asset.clone(),
            begins: self.settings.begins,
        }
    }
}
