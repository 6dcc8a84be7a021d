//! A graph as a flat list of ops, with numbered buffers and steady rows: what the engine runs.

use std::collections::HashMap;
use std::sync::Arc;

use super::start::StartProgram;
use super::{Base, Graph, Node, NodeId, Signal, Wire};

/// Ops in order, and where their values stand.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Program {
    /// In the order in which they run.
    pub ops: Vec<Op>,
    /// Values that stay for the life of a voice, a row each. The first is the number 0.
    pub steady: Vec<Base>,
    /// What steady rows and gains are worked out from at the onset.
    pub starts: Vec<StartProgram>,
    /// Buffers needed by ops.
    pub buffers: usize,
    /// Where each output stands when all ops have run.
    pub outputs: Vec<Feed>,
    /// Factors of the first output, worked out at the onset.
    pub gain: Vec<Base>,
    /// Buffers whose last row is wanted one sample later. Where there are any, the program runs sample by sample.
    pub late: Vec<u32>,
}

/// A node, ready to run.
#[derive(Debug, Clone, PartialEq)]
pub struct Op {
    /// What it is; its wires are resolved in `inputs`.
    pub node: Arc<Node>,
    /// In the order of its parameters.
    pub inputs: Vec<OpInput>,
    /// How many of them its kernel is given while it runs; the rest are read at the onset.
    pub running: usize,
    /// The buffer it writes.
    pub output: u32,
}

/// An input of an op.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OpInput {
    /// The steady row of the part known at the onset.
    pub base: u32,
    /// Where the values stand.
    pub feed: Feed,
}

/// Where values stand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Feed {
    /// A steady row.
    Steady(u32),
    /// A buffer.
    Buffer(u32),
    /// An engine-wide signal.
    Shared(u32),
    /// The row that a late buffer held one sample ago, by its place in [`Program::late`].
    Late(u32),
}

/// The program of a graph whose nodes all stand after what they read (see [`super::prune`]).
pub(crate) fn program(graph: Graph) -> Program {
    let mut rows = Rows::default();
    rows.row(Base::Constant(0.0));
    let Graph { nodes, starts, outputs, gain } = graph;

    let mut uses = vec![0_u32; nodes.len()];
    for wire in nodes.iter().flat_map(|n| &n.inputs).chain(&outputs) {
        // What is wanted a sample later is never given back.
        if let Some(Signal::Node(id) | Signal::Late(id)) = wire.signal {
            uses[id as usize] += 1;
        }
    }
    let mut late_nodes: Vec<NodeId> = Vec::new();
    // By node: its place among those, if it is one.
    let mut late_of = vec![0_u32; nodes.len()];
    let mut is_late = vec![false; nodes.len()];
    for wire in nodes.iter().flat_map(|n| &n.inputs) {
        if let Some(Signal::Late(id)) = wire.signal
            && !std::mem::replace(&mut is_late[id as usize], true)
        {
            late_of[id as usize] = late_nodes.len() as u32;
            late_nodes.push(id);
        }
    }
    let mut buffer_of = vec![0_u32; nodes.len()];
    let mut free: Vec<u32> = Vec::new();
    let mut buffers = 0;
    let mut ops = Vec::with_capacity(nodes.len());
    for (id, node) in nodes.into_iter().enumerate() {
        let params = node.kind.spec().params;
        let mut inputs = Vec::with_capacity(node.inputs.len());
        for (i, wire) in node.inputs.iter().enumerate() {
            let frequency = params
                .iter()
                .filter(|p| p.kind.is_input())
                .nth(i)
                .is_some_and(|p| matches!(p.kind, crate::node::spec::Kind::Frequency(_)));
            let base = rows.row(wire.base);
            let feed = feed(wire, if frequency { 0 } else { base }, &buffer_of, &late_of);
            inputs.push(OpInput { base, feed });
        }
        // The output may not share a buffer with an input, so it is chosen before these are given back.
        let output = free.pop().unwrap_or_else(|| {
            buffers += 1;
            buffers - 1
        });
        buffer_of[id] = output;
        for wire in &node.inputs {
            if let Some(Signal::Node(from)) = wire.signal {
                uses[from as usize] -= 1;
                if uses[from as usize] == 0 {
                    free.push(buffer_of[from as usize]);
                }
            }
        }
        let running = node.kind.spec().running(inputs.len());
        ops.push(Op { node: Arc::new(node), inputs, running, output });
    }
    let outputs = outputs
        .iter()
        .map(|wire| {
            let base = rows.row(wire.base);
            feed(wire, base, &buffer_of, &late_of)
        })
        .collect();
    let late = late_nodes.iter().map(|id| buffer_of[*id as usize]).collect();
    Program { ops, steady: rows.list, starts, buffers: buffers as usize, outputs, gain, late }
}

fn feed(wire: &Wire, steady: u32, buffer_of: &[u32], late_of: &[u32]) -> Feed {
    match wire.signal {
        Some(Signal::Late(id)) => Feed::Late(late_of[id as usize]),
        Some(Signal::Node(id)) => Feed::Buffer(buffer_of[id as usize]),
        Some(Signal::Shared(index)) => Feed::Shared(index),
        None => Feed::Steady(steady),
    }
}

/// Steady rows, each value once.
#[derive(Default)]
struct Rows {
    /// The first is the number 0.
    list: Vec<Base>,
    /// Where the number 1 stands.
    one: Option<u32>,
    place: HashMap<(bool, u64), u32>,
}

impl Rows {
    fn row(&mut self, base: Base) -> u32 {
        // Most of all rows are one of these two, and are found without a look at the others.
        match base {
            Base::Constant(x) if x.to_bits() == 0 && !self.list.is_empty() => return 0,
            Base::Constant(1.0) => {
                let next = self.list.len() as u32;
                return *self.one.get_or_insert_with(|| {
                    self.list.push(base);
                    next
                });
            }
            _ => {}
        }
        let key = match base {
            Base::Constant(x) => (false, x.to_bits()),
            Base::Start(id) => (true, u64::from(id)),
        };
        *self.place.entry(key).or_insert_with(|| {
            self.list.push(base);
            self.list.len() as u32 - 1
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::order::depth_first;
    use super::super::prune::prune;
    use super::super::{Base, Graph, Node, Settings, Wire};
    use super::{Feed, Program, program};
    use crate::node::NodeKind;

    fn compiled(nodes: Vec<Node>, last: u32) -> Program {
        let graph = Graph { nodes, outputs: vec![Wire::node(last)], ..Graph::default() };
        let order = depth_first(&graph).unwrap();
        program(prune(graph, &order).0)
    }

    fn node(kind: &str, inputs: Vec<Wire>) -> Node {
        let kind = NodeKind::find(kind).unwrap();
        Node { name: "n".into(), kind, settings: Settings::default().into(), inputs }
    }

    fn sine(hertz: f64) -> Node {
        node("sine", vec![Wire::constant(hertz), Wire::constant(0.0), Wire::constant(1.0)])
    }

    #[test]
    fn a_mixer_of_512_nodes_needs_three_buffers() {
        let mut nodes = vec![sine(50.0)];
        for i in 0..255 {
            let last = nodes.len() as u32 - 1;
            nodes.push(sine(60.0 + f64::from(i)));
            nodes.push(node("multiply", vec![Wire::node(last), Wire::node(last + 1)]));
        }
        let last = nodes.len() as u32 - 1;
        let program = compiled(nodes, last);
        assert_eq!(program.ops.len(), 511);
        // Two hold the inputs of a product, a third takes it: outputs never share with inputs.
        assert_eq!(program.buffers, 3);
    }

    #[test]
    fn no_op_writes_a_buffer_that_is_still_to_be_read() {
        let nodes = vec![
            sine(50.0),
            sine(60.0),
            node("multiply", vec![Wire::node(0), Wire::node(1)]),
            node("multiply", vec![Wire::node(2), Wire::node(0)]),
            node("multiply", vec![Wire::node(3), Wire::node(2), Wire::node(1)]),
        ];
        let program = compiled(nodes, 4);
        // Replay the list with names instead of values.
        let mut holds = vec![usize::MAX; program.buffers];
        for (i, op) in program.ops.iter().enumerate() {
            for (wire, input) in op.node.inputs.iter().zip(&op.inputs) {
                if let (Some(super::Signal::Node(from)), Feed::Buffer(b)) = (wire.signal, input.feed) {
                    assert_eq!(holds[b as usize], from as usize, "op {i}");
                    assert_ne!(b, op.output, "op {i} writes what it reads");
                }
            }
            holds[op.output as usize] = i;
        }
    }

    #[test]
    fn a_frequency_keeps_its_steady_part_apart() {
        let program = compiled(vec![sine(50.0)], 0);
        let frequency = program.ops[0].inputs[0];
        assert_eq!(program.steady[frequency.base as usize], Base::Constant(50.0));
        assert_eq!(frequency.feed, Feed::Steady(0));
        let amplitude = program.ops[0].inputs[2];
        assert_eq!(amplitude.feed, Feed::Steady(amplitude.base));
    }
}
