//! Keeps out of a voice what was there before its onset.
//!
//! An oscillator has a value at any time, before the onset too, and the envelope that multiplies it makes that nothing. But what
//! has memory would keep it: a filter would hear its input from the first sample computed, which lies one to two samples
//! ahead of the onset and jumps there on the engine's grid. So the input of a node that has memory is 0 until the onset: one
//! that does not begin there by itself is multiplied by the node `onset`, which jumps at the exact instant. Likewise the output
//! of a voice that ends with its envelopes. Noises begin by themselves, and so do strings, which noise sets off: their first
//! number is the voice's first sample.
//!
//! An oscillator is told whether what moves its frequency begins at the onset, since then it may jump there.

use std::sync::Arc;

use super::{Base, Graph, Node, NodeId, Settings, Signal, Wire};
use crate::node::kernel::Onset;
use crate::node::spec::{Family, Kind};
use crate::node::{NodeKind, twin};

/// Works on a voice's graph whose nodes stand after what they read. New nodes come after them, and are read by them.
pub fn begin(graph: &mut Graph) {
    if !graph.nodes.iter().any(matters) {
        return;
    }
    let mut begun = Vec::with_capacity(graph.nodes.len());
    for node in &graph.nodes {
        begun.push(begins(node, &begun));
    }
    let mut work = Work { readers: readers(graph), begun, gate: None };
    let (mut enveloped, last) = (false, graph.nodes.len());
    for id in 0..last {
        let spec = graph.nodes[id].kind.spec();
        enveloped |= spec.family == Family::Envelope
            && ![NodeKind::LFO, NodeKind::ONSET].contains(&graph.nodes[id].kind);
        for (k, param) in spec.params.iter().filter(|p| p.kind.is_input()).enumerate() {
            let Some(wire) = graph.nodes[id].inputs.get(k).copied() else { continue };
            if spec.family == Family::Filter && param.name == "input" && !silent(&wire, &work.begun) {
                work.begin(graph, id, k);
            }
            if matches!(param.kind, Kind::Frequency(_)) && wire.signal.is_some() {
                let moving = Wire { base: Base::Constant(0.0), ..wire };
                let parts = silent(&moving, &work.begun) || work.parts(graph, &wire);
                if parts && !silent(&moving, &work.begun) {
                    work.begin(graph, id, k);
                }
                if parts {
                    Arc::make_mut(&mut graph.nodes[id].settings).begins = true;
                }
            }
        }
    }
    let Some(output) = graph.outputs.first().copied() else { return };
    if enveloped && !silent(&output, &work.begun) {
        if work.parts(graph, &output) {
            work.begin_parts(graph, &output);
        } else {
            graph.outputs[0] = work.gated(graph, output);
        }
    }
}

/// Whether there could be something to do on account of a node: one with memory, one that ends a voice, or a frequency that moves.
fn matters(node: &Node) -> bool {
    match node.kind.spec().family {
        Family::Filter | Family::Envelope => true,
        Family::Oscillator => node.inputs.iter().any(|wire| wire.signal.is_some()),
        _ => false,
    }
}

/// Whether what comes through a wire is 0 before the onset. What comes a sample late feeds a delay, and is looked at there.
fn silent(wire: &Wire, begun: &[bool]) -> bool {
    let moves = match wire.signal {
        None => false,
        Some(Signal::Node(id) | Signal::Late(id)) => !begun.get(id as usize).copied().unwrap_or(true),
        Some(Signal::Shared(_)) => true,
    };
    !moves && wire.base == Base::Constant(0.0)
}

/// Whether a node gives 0 before the onset.
fn begins(node: &Node, begun: &[bool]) -> bool {
    let spec = node.kind.spec();
    let quiet = |wire: &Wire| silent(wire, begun);
    match spec.family {
        Family::Noise | Family::Filter | Family::Motor | Family::Place => true,
        Family::Envelope => node.kind != NodeKind::LFO,
        Family::Arithmetic => match node.kind {
            NodeKind::MULTIPLY => node.inputs.iter().any(quiet),
            NodeKind::ADD => node.inputs.iter().all(quiet),
            _ => node.inputs.iter().any(quiet) && gives_nothing(node, begun),
        },
        Family::Oscillator | Family::Recording | Family::Input => {
            let names = spec.params.iter().filter(|p| p.kind.is_input()).map(|p| p.name);
            // A string is set off by noise.
            node.kind.is_set_off_by_noise()
                || names.zip(&node.inputs).any(|(name, wire)| name == "amplitude" && quiet(wire))
        }
    }
}

/// Whether an arithmetic node gives 0 where its silent inputs are 0, whatever the others are: tried with a few numbers.
fn gives_nothing(node: &Node, begun: &[bool]) -> bool {
    [0.37, -1.9, 3.3].into_iter().all(|any| {
        let value = |wire: &Wire| match *wire {
            Wire { base: Base::Constant(x), signal: None } => x,
            _ if silent(wire, begun) => 0.0,
            _ => any,
        };
        let inputs: Vec<f64> = node.inputs.iter().map(value).collect();
        let onset = Onset { age: 0.0, stream: 0, start: &inputs };
        twin(node.kind, &node.setup(8000.0, 8000.0), &onset).step(0.0, &inputs) == 0.0
    })
}

fn readers(graph: &Graph) -> Vec<u32> {
    let mut readers = vec![0; graph.nodes.len()];
    for wire in graph.nodes.iter().flat_map(|n| &n.inputs).chain(&graph.outputs) {
        if let Some(Signal::Node(id) | Signal::Late(id)) = wire.signal {
            readers[id as usize] += 1;
        }
    }
    readers
}

struct Work {
    readers: Vec<u32>,
    begun: Vec<bool>,
    /// The node `onset`, once it is needed.
    gate: Option<NodeId>,
}

impl Work {
    /// Whether a wire carries a sum that nothing else reads, of which a part begins by itself: then the others are kept out one
    /// by one, since a jump that is kept out twice is another jump.
    fn parts(&self, graph: &Graph, wire: &Wire) -> bool {
        let Some(Signal::Node(id)) = wire.signal else { return false };
        let Some(node) = graph.nodes.get(id as usize) else { return false };
        self.readers.get(id as usize) == Some(&1)
            && [NodeKind::ADD, NodeKind::MIX].contains(&node.kind)
            && node.inputs.iter().skip(signals(node)).any(|wire| silent(wire, &self.begun))
    }

    /// Input `k` of a node is 0 until the onset.
    fn begin(&mut self, graph: &mut Graph, id: usize, k: usize) {
        let wire = graph.nodes[id].inputs[k];
        if self.parts(graph, &wire) {
            self.begin_parts(graph, &wire);
        } else {
            graph.nodes[id].inputs[k] = self.gated(graph, wire);
        }
    }

    /// The same for all parts of the sum on a wire.
    fn begin_parts(&mut self, graph: &mut Graph, wire: &Wire) {
        let mut sums = vec![*wire];
        while let Some(wire) = sums.pop() {
            let Some(Signal::Node(id)) = wire.signal else { continue };
            let id = id as usize;
            for k in signals(&graph.nodes[id])..graph.nodes[id].inputs.len() {
                let part = graph.nodes[id].inputs[k];
                if silent(&part, &self.begun) {
                    continue;
                }
                if self.parts(graph, &part) {
                    sums.push(part);
                } else {
                    graph.nodes[id].inputs[k] = self.gated(graph, part);
                }
            }
        }
    }

    /// A wire, times the onset.
    fn gated(&mut self, graph: &mut Graph, wire: Wire) -> Wire {
        let mut add = |kind: NodeKind, inputs: Vec<Wire>| {
            let settings = Arc::new(Settings::default());
            graph.nodes.push(Node { name: "onset".into(), kind, settings, inputs });
            graph.nodes.len() as NodeId - 1
        };
        let gate = *self.gate.get_or_insert_with(|| add(NodeKind::ONSET, Vec::new()));
        Wire::node(add(NodeKind::MULTIPLY, vec![wire, Wire::node(gate)]))
    }
}

/// Where the summands of a sum begin among its inputs.
fn signals(node: &Node) -> usize {
    let params = node.kind.spec().params.iter().filter(|p| p.kind.is_input());
    params.take_while(|p| !matches!(p.kind, Kind::Signals)).count()
}

#[cfg(test)]
mod tests {
    use super::super::{Graph, Node, NodeId, Settings, Signal, Wire};
    use super::begin;
    use crate::node::NodeKind;

    fn node(kind: &str, inputs: Vec<Wire>) -> Node {
        let kind = NodeKind::find(kind).unwrap();
        Node { name: kind.spec().name.into(), kind, settings: Settings::default().into(), inputs }
    }

    fn number(x: f64) -> Wire {
        Wire::constant(x)
    }

    /// The graph after the pass, and the names of what each node reads.
    fn after(nodes: Vec<Node>) -> (Graph, Vec<Vec<String>>) {
        let outputs = vec![Wire::node(nodes.len() as NodeId - 1)];
        let mut graph = Graph { nodes, outputs, ..Graph::default() };
        begin(&mut graph);
        let name = |wire: &Wire| match wire.signal {
            Some(Signal::Node(id)) => graph.nodes[id as usize].kind.spec().name.to_string(),
            _ => "-".into(),
        };
        let names = graph.nodes.iter().map(|n| n.inputs.iter().map(name).collect()).collect();
        (graph, names)
    }

    fn sine(frequency: Wire) -> Node {
        node("sine", vec![frequency, number(0.0), number(1.0)])
    }

    #[test]
    fn a_filter_hears_an_oscillator_from_the_onset_on() {
        let lowpass = |input| node("lowpass", vec![Wire::node(input), number(100.0), number(0.7)]);
        let (graph, reads) = after(vec![sine(number(50.0)), lowpass(0), node("decay", vec![number(0.0); 2])]);
        assert_eq!((reads[1][0].as_str(), graph.nodes.len()), ("multiply", 5));
        assert_eq!(reads[4], ["sine", "onset"]);
        // Noise and what an envelope multiplies begin by themselves.
        let product = node("multiply", vec![Wire::node(0), Wire::node(2)]);
        let decay = node("decay", vec![number(0.0); 2]);
        let noise = node("white", vec![number(1.0)]);
        let (_, reads) = after(vec![sine(number(50.0)), noise, decay, product, lowpass(3), lowpass(1)]);
        assert_eq!((reads[4][0].as_str(), reads[5][0].as_str()), ("multiply", "white"));
        assert_eq!(reads.len(), 6);
    }

    #[cfg(feature = "fundsp-nodes")]
    #[test]
    fn filters_of_fundsp_hear_from_the_onset_on_and_strings_begin_by_themselves() {
        for (kind, inputs) in [("ladder", 3), ("bell", 4)] {
            let filter = |input| {
                let mut wires = vec![number(100.0); inputs];
                wires[0] = Wire::node(input);
                node(kind, wires)
            };
            let (_, reads) = after(vec![sine(number(50.0)), filter(0)]);
            assert_eq!(
                (reads[1][0].as_str(), &reads[3][..]),
                ("multiply", &["sine".into(), "onset".into()][..])
            );
            let sources = [
                node("pluck", vec![number(100.0), number(1.0)]),
                node("chaos", vec![number(5.0), number(1.0)]),
                node("brown", vec![number(10.0), number(1.0)]),
            ];
            for source in sources {
                let name = source.kind.spec().name;
                let (_, reads) = after(vec![source, filter(0)]);
                assert_eq!((reads[1][0].as_str(), reads.len()), (name, 2));
            }
        }
    }

    #[test]
    fn of_a_sum_the_part_that_runs_is_kept_out() {
        let decay = node("decay", vec![number(0.0); 2]);
        let sum = node("add", vec![Wire::node(0), Wire::node(1)]);
        let filter = node("highpass", vec![Wire::node(2), number(100.0), number(0.7)]);
        let (_, reads) = after(vec![sine(number(50.0)), decay, sum, filter]);
        assert_eq!(
            (&reads[2][..], reads[3][0].as_str()),
            (&["multiply".to_string(), "decay".into()][..], "add")
        );
    }

    #[test]
    fn a_frequency_knows_whether_it_begins() {
        let decay = || node("decay", vec![number(0.0); 2]);
        let moved = Wire { base: number(50.0).base, ..Wire::node(0) };
        let product = |tone| node("multiply", vec![Wire::node(tone), Wire::node(0)]);
        let (graph, reads) = after(vec![decay(), sine(moved), product(1)]);
        assert!(graph.nodes[1].settings.begins && reads.len() == 3);
        let (graph, reads) = after(vec![
            sine(number(5.0)),
            decay(),
            sine(moved),
            node("multiply", vec![Wire::node(1), Wire::node(2)]),
        ]);
        assert!(!graph.nodes[2].settings.begins && reads.len() == 4);
        let sum = node("add", vec![Wire::node(0), Wire::node(1)]);
        let moved = Wire { base: number(50.0).base, ..Wire::node(2) };
        let end = node("multiply", vec![Wire::node(3), Wire::node(0)]);
        let (graph, reads) = after(vec![decay(), sine(number(5.0)), sum, sine(moved), end]);
        assert!(graph.nodes[3].settings.begins);
        assert_eq!(reads[2], ["decay", "multiply"]);
    }

    #[test]
    fn an_output_that_no_envelope_reaches_begins_only_where_voices_end_with_envelopes() {
        let decay = node("decay", vec![number(0.0); 2]);
        let half = node("scale", vec![Wire::node(0), number(0.5), number(0.0)]);
        let sum = node("add", vec![Wire::node(1), Wire::node(2)]);
        let (_, reads) = after(vec![decay, half, sine(number(50.0)), sum]);
        assert_eq!(reads[3], ["scale", "multiply"]);
        let (graph, _) = after(vec![sine(number(50.0))]);
        assert_eq!(graph.nodes.len(), 1);
    }
}
