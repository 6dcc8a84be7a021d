//! From descriptions to graphs: expressions become nodes, names become wires.

mod expression;

use std::collections::HashMap;
use std::sync::Arc;

use super::start::{FIELDS, Fields, StartProgram, Step};
use super::{Base, Graph, Node, NodeId, Settings, Signal, Wire};
use crate::node::NodeKind;
use crate::node::asset::Assets;
use crate::node::kernel::INPUTS;
use crate::node::motion::Motion;
use crate::node::spec::Kind;
use crate::node::touch::SMOOTHING;
use crate::patch::knob::Reading;
use crate::patch::{self, Patch, Scope, Value, Voice};
use crate::text::{Problem, Span};
use expression::Term;

/// Engine-wide signals that graphs ask for, numbered as they come.
#[derive(Debug, Default)]
pub struct Wanted {
    /// What each number stands for.
    pub list: Vec<Want>,
    place: HashMap<Want, u32>,
    /// Nodes that expressions have become, of all graphs.
    made: usize,
}

/// Nodes that the expressions of a patch may become, which takes half a gigabyte to compile.
const MOST_MADE: usize = 1 << 19;

/// An engine-wide signal that a graph asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Want {
    /// A control, by its place in the patch.
    Control(usize),
    /// A shared node, by its place in the patch.
    Node(usize),
    /// An input channel, from 0.
    Input(u32),
    /// What the knob does.
    Knob(Reading),
}

impl Wanted {
    /// The number of a signal.
    pub fn number(&mut self, want: Want) -> u32 {
        *self.place.entry(want).or_insert_with(|| {
            self.list.push(want);
            self.list.len() as u32 - 1
        })
    }
}

/// The graph of a voice; `shared` is the scope of the shared nodes.
///
/// # Errors
/// Recordings that cannot be read, more event fields or inputs than the engine has, names that nothing has.
pub fn voice(
    shared: &Scope,
    voice: &Voice,
    assets: &dyn Assets,
    wanted: &mut Wanted,
) -> Result<Graph, Vec<Problem>> {
    let fields: Vec<&str> = voice.fields.iter().map(|(name, _)| name.as_str()).collect();
    if fields.len() > FIELDS {
        let what = format!(
            "voice `{}` declares {} fields; an event carries at most {FIELDS}",
            voice.name,
            fields.len()
        );
        return Err(vec![Problem::error(&voice.span, what)]);
    }
    let scope = shared.within(voice);
    let output = voice.output.clone();
    let mut builder = Builder {
        scope,
        fields,
        shared: false,
        assets,
        wanted,
        graph: Graph::default(),
        touches: [None; Motion::ALL.len()],
        problems: vec![],
    };
    builder.nodes(&voice.nodes);
    let place = voice.nodes.iter().position(|node| node.kind == NodeKind::PLACE);
    match voice.nodes.iter().position(|n| n.name == output) {
        Some(i) => {
            builder.graph.outputs = vec![Wire::node(i as NodeId)];
            let says = place.and_then(|id| builder.graph.nodes.get(id));
            let wires = says.map(|node| node.inputs.clone()).unwrap_or_default();
            builder.graph.outputs.extend(wires);
        }
        None => {
            let what = format!("voice `{}` has no node `{output}` to be its output", voice.name);
            builder.problems.push(Problem::error(&voice.output_span, what));
        }
    }
    builder.finish()
}

/// The graph of the shared nodes; its outputs are those of `outputs`, places in [`Patch::shared`].
///
/// # Errors
/// As [`voice`].
pub fn shared(
    patch: &Patch,
    outputs: &[usize],
    assets: &dyn Assets,
    wanted: &mut Wanted,
) -> Result<Graph, Vec<Problem>> {
    let scope = Scope::new(patch, None);
    let mut builder = Builder {
        scope,
        fields: vec![],
        shared: true,
        assets,
        wanted,
        graph: Graph::default(),
        touches: [None; Motion::ALL.len()],
        problems: vec![],
    };
    builder.nodes(&patch.shared);
    builder.graph.outputs = outputs.iter().map(|&i| Wire::node(i as NodeId)).collect();
    builder.finish()
}

struct Builder<'a> {
    scope: Scope<'a>,
    fields: Vec<&'a str>,
    shared: bool,
    assets: &'a dyn Assets,
    wanted: &'a mut Wanted,
    graph: Graph,
    /// The node that says what the hand does, by its motion, once it is needed.
    touches: [Option<NodeId>; Motion::ALL.len()],
    problems: Vec<Problem>,
}

impl Builder<'_> {
    fn finish(self) -> Result<Graph, Vec<Problem>> {
        if self.problems.is_empty() { Ok(self.graph) } else { Err(self.problems) }
    }

    fn nodes(&mut self, nodes: &[patch::Node]) {
        // A node's number is its place in the file; nodes made from expressions come after.
        for node in nodes {
            self.graph.nodes.push(Node {
                name: node.name.as_str().into(),
                kind: node.kind,
                settings: Arc::default(),
                inputs: Vec::new(),
            });
        }
        for (id, node) in nodes.iter().enumerate() {
            self.node(id, node);
        }
    }

    fn node(&mut self, id: usize, node: &patch::Node) {
        let spec = node.kind.spec();
        let mut settings = Settings::default();
        let mut inputs = Vec::with_capacity(spec.params.len());
        let mut file = None;
        for (param, argument) in spec.params.iter().zip(&node.arguments) {
            match &argument.value {
                Value::Expr(expr) if matches!(param.kind, Kind::Frequency(_)) => {
                    let wire = self.frequency(&node.name, expr);
                    inputs.push(wire);
                }
                Value::Expr(expr) => {
                    let term = self.term(&node.name, expr);
                    inputs.push(self.wire(term));
                }
                Value::Signals(list) => {
                    for expr in list {
                        let term = self.term(&node.name, expr);
                        inputs.push(self.wire(term));
                    }
                }
                Value::Constant(x) => settings.constants.push(*x),
                Value::Choice(i) => settings.choices.push(*i),
                Value::Flag(on) => settings.choices.push(usize::from(*on)),
                Value::Points(points) => settings.points.clone_from(points),
                Value::File(path) => file = Some((path, argument.span.clone())),
            }
        }
        if let Some((path, span)) = file {
            settings.asset = self.asset(path, &settings, span);
        }
        if node.kind == NodeKind::INPUT {
            let channel = settings.constants.first().copied().unwrap_or(1.0);
            inputs.push(Wire::shared(self.wanted.number(Want::Input((channel as u32).saturating_sub(1)))));
        }
        let settings = Arc::new(settings);
        if inputs.len() > INPUTS {
            inputs = self.split(node, &settings, inputs);
        }
        let built = &mut self.graph.nodes[id];
        built.settings = settings;
        built.inputs = inputs;
    }

    /// A recording's channel is the node's first constant, where it has one.
    fn asset(
        &mut self,
        path: &str,
        settings: &Settings,
        span: Span,
    ) -> Option<Arc<crate::node::asset::Asset>> {
        let channel = settings.constants.first().map_or(1, |c| *c as usize);
        self.assets.load(path, channel).map_err(|what| self.problems.push(Problem::error(&span, what))).ok()
    }

    /// Sums and products of many become sums of sums and products of products.
    fn split(&mut self, node: &patch::Node, settings: &Arc<Settings>, mut inputs: Vec<Wire>) -> Vec<Wire> {
        let spec = node.kind.spec();
        if ![NodeKind::ADD, NodeKind::MULTIPLY].contains(&node.kind) {
            let what = format!(
                "`{}` has {} inputs; a `{}` takes at most {INPUTS}",
                node.name,
                inputs.len(),
                spec.name
            );
            self.problems.push(Problem::error(&node.span, what));
            inputs.truncate(INPUTS);
            return inputs;
        }
        while inputs.len() > INPUTS {
            inputs = inputs
                .chunks(INPUTS)
                .map(|part| {
                    if let [only] = part {
                        return *only;
                    }
                    let id = self.graph.nodes.len() as NodeId;
                    self.graph.nodes.push(Node {
                        name: node.name.as_str().into(),
                        kind: node.kind,
                        settings: Arc::clone(settings),
                        inputs: part.to_vec(),
                    });
                    Wire::node(id)
                })
                .collect();
        }
        inputs
    }

    fn wire(&mut self, term: Term) -> Wire {
        match term {
            Term::Known(steps) => Wire { base: self.base(steps), signal: None },
            Term::Moving(signal) => Wire { base: Base::Constant(0.0), signal: Some(signal) },
        }
    }

    fn base(&mut self, steps: Vec<Step>) -> Base {
        let known = !steps.iter().any(|s| matches!(s, Step::Level | Step::Duration | Step::Own(_)));
        match StartProgram::new(steps) {
            Ok(program) if known => {
                Base::Constant(program.value(&Fields { level: 0.0, duration: 0.0, own: [0.0; FIELDS] }))
            }
            Ok(program) => {
                self.graph.starts.push(program);
                Base::Start(self.graph.starts.len() as u32 - 1)
            }
            Err(what) => {
                self.problems.push(Problem::of_file(what));
                Base::Constant(0.0)
            }
        }
    }

    /// What the hand does: one node for all that read it.
    fn touch(&mut self, motion: Motion) -> Signal {
        let graph = &mut self.graph;
        let id = *self.touches[motion.number()].get_or_insert_with(|| {
            let settings = Settings {
                constants: vec![SMOOTHING],
                choices: vec![motion.number()],
                ..Settings::default()
            };
            let name = format!("touch.{}", Motion::WORDS[motion.number()]).into();
            graph.nodes.push(Node {
                name,
                kind: NodeKind::TOUCH,
                settings: settings.into(),
                inputs: Vec::new(),
            });
            graph.nodes.len() as NodeId - 1
        });
        Signal::Node(id)
    }

    /// A node made for an expression in a parameter of `owner`.
    fn made(&mut self, owner: &str, kind: &str, choice: Option<&str>, inputs: Vec<Wire>) -> Signal {
        let Some(kind) = NodeKind::find(kind) else {
            self.problems.push(Problem::of_file(format!("there is no node type `{kind}`")));
            return Signal::Node(0);
        };
        self.wanted.made += 1;
        if self.wanted.made > MOST_MADE {
            if self.wanted.made == MOST_MADE + 1 {
                let what = format!(
                    "the expressions of this patch come to more than {MOST_MADE} operations, those of `{owner}` among them"
                );
                let help = "add up many signals with a node `add` or `mix`, and compute once what several nodes read";
                self.problems.push(Problem::of_file(what).help(help.to_string()));
            }
            return Signal::Node(0);
        }
        let place = choice.map(|word| {
            let words = kind.spec().params.iter().find_map(|p| match p.kind {
                Kind::Choice(words, _) => Some(words),
                _ => None,
            });
            words.and_then(|w| w.iter().position(|x| *x == word)).unwrap_or(0)
        });
        let settings = Settings { choices: place.into_iter().collect(), ..Settings::default() };
        self.graph.nodes.push(Node { name: owner.into(), kind, settings: settings.into(), inputs });
        Signal::Node(self.graph.nodes.len() as NodeId - 1)
    }
}
