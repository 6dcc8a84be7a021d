//! Works out what is known before anything sounds.
//!
//! - An arithmetic node whose inputs are all numbers becomes a number (its twin says which).
//! - Numbers among the inputs of `multiply` and `add` become one; a product with 0 is 0; with one input left the node is gone.
//! - Numbers and onset values that multiply a voice's output become its gain, which the mixer applies anyway.
//! - What multiplies an oscillator becomes its amplitude, which the oscillator applies anyway.

use super::{Base, Graph, Node, NodeId, Signal, Wire};
use crate::node::kernel::Onset;
use crate::node::spec::Family;
use crate::node::{NodeKind, twin};

/// The graph with everything folded that can be, given an order in which inputs come first. Nodes that are not needed any
/// more are still there.
pub fn fold(mut graph: Graph, order: &[NodeId]) -> Graph {
    let mut same: Vec<Option<Wire>> = vec![None; graph.nodes.len()];
    for &id in order {
        let node = &mut graph.nodes[id as usize];
        for wire in &mut node.inputs {
            substitute(wire, &same);
        }
        if let Some(wire) = value(node) {
            same[id as usize] = Some(wire);
        }
    }
    for wire in &mut graph.outputs {
        substitute(wire, &same);
    }
    graph
}

fn substitute(wire: &mut Wire, same: &[Option<Wire>]) {
    if let Some(Signal::Late(id)) = wire.signal
        && let Some(known @ Wire { base: Base::Constant(_), signal: None }) = same[id as usize]
    {
        *wire = known;
    }
    let Some(Signal::Node(id)) = wire.signal else { return };
    if let Some(other) = same[id as usize] {
        *wire = match (wire.base, other) {
            (Base::Constant(0.0), _) => other,
            (Base::Constant(a), Wire { base: Base::Constant(b), signal: None }) => Wire::constant(a + b),
            // A frequency with an onset part and a signal that turned out to be one too: leave it.
            _ => return,
        };
    }
}

/// What the node amounts to, if that is simpler than the node.
fn value(node: &mut Node) -> Option<Wire> {
    let spec = node.kind.spec();
    let constant = |wire: &Wire| match wire {
        Wire { base: Base::Constant(x), signal: None } => Some(*x),
        _ => None,
    };
    if spec.family == Family::Arithmetic && node.inputs.iter().all(|w| constant(w).is_some()) {
        let inputs: Vec<f64> = node.inputs.iter().filter_map(constant).collect();
        let onset = Onset { age: 0.0, stream: 0, start: &inputs };
        let mut exact = twin(node.kind, &node.setup(8000.0, 8000.0), &onset);
        return Some(Wire::constant(exact.step(0.0, &inputs)));
    }
    let (neutral, join): (f64, fn(f64, f64) -> f64) = match node.kind {
        NodeKind::MULTIPLY => (1.0, |a, b| a * b),
        NodeKind::ADD => (0.0, |a, b| a + b),
        _ => return None,
    };
    let known = node.inputs.iter().filter_map(constant).fold(neutral, join);
    if node.kind == NodeKind::MULTIPLY && known == 0.0 {
        return Some(Wire::constant(0.0));
    }
    node.inputs.retain(|w| constant(w).is_none());
    if known != neutral {
        node.inputs.push(Wire::constant(known));
    }
    if node.inputs.len() == 1 { node.inputs.pop() } else { None }
}

/// Moves what steadily multiplies the first output into the gain.
pub fn take_gain(graph: &mut Graph) {
    let Some(Wire { signal: Some(Signal::Node(id)), .. }) = graph.outputs.first().copied() else { return };
    let wire = Signal::Node(id);
    let read_elsewhere = graph.nodes.iter().flat_map(|n| &n.inputs).chain(&graph.outputs[1..]);
    if graph.nodes[id as usize].kind != NodeKind::MULTIPLY
        || read_elsewhere.into_iter().any(|w| w.signal == Some(wire) || w.signal == Some(Signal::Late(id)))
    {
        return;
    }
    let node = &mut graph.nodes[id as usize];
    graph.gain.extend(node.inputs.iter().filter(|w| w.signal.is_none()).map(|w| w.base));
    node.inputs.retain(|w| w.signal.is_some());
    match node.inputs[..] {
        [only] => graph.outputs[0] = only,
        [] => graph.outputs[0] = Wire::constant(1.0),
        _ => {}
    }
}

/// Lets oscillators of amplitude 1 that nothing but a product of two reads take the other factor as their amplitude, and
/// stand for the product. Says which nodes were such products: their work is not left out, but done elsewhere.
pub fn take_amplitudes(graph: &mut Graph) -> Vec<bool> {
    let mut readers = vec![0_u32; graph.nodes.len()];
    let mut late = vec![false; graph.nodes.len()];
    for wire in graph.nodes.iter().flat_map(|n| &n.inputs).chain(&graph.outputs) {
        match wire.signal {
            Some(Signal::Node(id)) => readers[id as usize] += 1,
            Some(Signal::Late(id)) => late[id as usize] = true,
            _ => {}
        }
    }
    let mut stands: Vec<Option<NodeId>> = vec![None; graph.nodes.len()];
    for id in 0..graph.nodes.len() {
        let &[a, b] = &graph.nodes[id].inputs[..] else { continue };
        if graph.nodes[id].kind != NodeKind::MULTIPLY || late[id] {
            continue;
        }
        let oscillator = |wire: Wire| {
            let Some(Signal::Node(tone)) = wire.signal else { return None };
            let node = &graph.nodes[tone as usize];
            let spec = node.kind.spec();
            let mut inputs = spec.params.iter().filter(|p| p.kind.is_input());
            let at = inputs.position(|p| spec.family == Family::Oscillator && p.name == "amplitude")?;
            let alone = readers[tone as usize] == 1 && !late[tone as usize];
            (alone && node.inputs.get(at) == Some(&Wire::constant(1.0))).then_some((tone, at))
        };
        let taken = oscillator(a).map(|tone| (tone, b)).or_else(|| oscillator(b).map(|tone| (tone, a)));
        if let Some(((tone, at), factor)) = taken {
            graph.nodes[tone as usize].inputs[at] = factor;
            stands[id] = Some(tone);
        }
    }
    for wire in graph.nodes.iter_mut().flat_map(|n| &mut n.inputs).chain(&mut graph.outputs) {
        while let Some(Signal::Node(id)) = wire.signal
            && let Some(tone) = stands[id as usize]
        {
            wire.signal = Some(Signal::Node(tone));
        }
    }
    stands.iter().map(Option::is_some).collect()
}

#[cfg(test)]
mod tests {
    use super::super::order::depth_first;
    use super::super::{Base, Graph, Node, Settings, Wire};
    use super::{fold, take_amplitudes, take_gain};
    use crate::node::NodeKind;

    fn node(kind: &str, inputs: Vec<Wire>) -> Node {
        let kind = NodeKind::find(kind).unwrap();
        Node { name: "n".into(), kind, settings: Settings::default().into(), inputs }
    }

    fn folded(nodes: Vec<Node>, last: u32) -> Graph {
        let graph = Graph { nodes, outputs: vec![Wire::node(last)], ..Graph::default() };
        let order = depth_first(&graph).unwrap();
        let mut graph = fold(graph, &order);
        take_gain(&mut graph);
        let order = depth_first(&graph).unwrap();
        super::super::prune::prune(graph, &order).0
    }

    #[test]
    fn numbers_fold_through_chains() {
        let nodes = vec![
            node("multiply", vec![Wire::constant(2.0), Wire::constant(3.0)]),
            node("multiply", vec![Wire::node(0), Wire::constant(0.5)]),
            node("sine", vec![Wire::constant(50.0), Wire::constant(0.0), Wire::node(1)]),
        ];
        let graph = folded(nodes, 2);
        assert_eq!(graph.nodes.len(), 1);
        assert_eq!(graph.nodes[0].inputs[2], Wire::constant(3.0));
    }

    #[test]
    fn steady_factors_become_the_gain() {
        let sine = || node("sine", vec![Wire::constant(50.0), Wire::constant(0.0), Wire::constant(1.0)]);
        let graph = folded(
            vec![sine(), node("multiply", vec![Wire::node(0), Wire::constant(0.5), Wire::start(0)])],
            1,
        );
        assert_eq!(graph.outputs, [Wire::node(0)]);
        assert_eq!(graph.gain, [Base::Start(0), Base::Constant(0.5)]);

        let nothing = folded(vec![sine(), node("multiply", vec![Wire::node(0), Wire::constant(0.0)])], 1);
        assert_eq!((nothing.nodes.len(), nothing.outputs[0]), (0, Wire::constant(0.0)));
    }

    /// Ring modulation by an envelope: the second oscillator takes the first, and stands for the product's readers.
    #[test]
    fn factors_of_an_oscillator_become_its_amplitude() {
        let sine = || node("sine", vec![Wire::constant(50.0), Wire::constant(0.0), Wire::constant(1.0)]);
        let product = |a, b| node("multiply", vec![Wire::node(a), Wire::node(b)]);
        let hit = node("gate", vec![]);
        let taken = |nodes: Vec<Node>, outputs: Vec<Wire>| {
            let mut graph = Graph { nodes, outputs, ..Graph::default() };
            take_amplitudes(&mut graph);
            let order = depth_first(&graph).unwrap();
            super::super::prune::prune(graph, &order).0
        };
        let nodes = vec![sine(), sine(), hit.clone(), product(1, 2), product(0, 3)];
        let graph = taken(nodes, vec![Wire::node(4)]);
        let kinds: Vec<_> = graph.nodes.iter().map(|n| n.kind.spec().name).collect();
        assert_eq!(kinds, ["gate", "sine", "sine"], "{graph:?}");
        let amplitudes: Vec<_> = graph.nodes[1..].iter().map(|n| n.inputs[2]).collect();
        assert_eq!(
            (amplitudes, &graph.outputs[..]),
            (vec![Wire::node(0), Wire::node(1)], &[Wire::node(2)][..])
        );

        // What is heard elsewhere, or has an amplitude already, stays what it is.
        let heard = taken(vec![sine(), hit.clone(), product(0, 1)], vec![Wire::node(2), Wire::node(0)]);
        assert_eq!(heard.nodes.len(), 3);
        let mut own = sine();
        own.inputs[2] = Wire::constant(0.5);
        assert_eq!(taken(vec![own, hit.clone(), product(0, 1)], vec![Wire::node(2)]).nodes.len(), 3);
        let squared = taken(vec![sine(), product(0, 0)], vec![Wire::node(1)]);
        assert_eq!(squared.nodes.len(), 2);
    }

    #[test]
    fn a_product_that_is_read_twice_keeps_its_factors() {
        let nodes = vec![
            node("sine", vec![Wire::constant(50.0), Wire::constant(0.0), Wire::constant(1.0)]),
            node("multiply", vec![Wire::node(0), Wire::constant(0.5)]),
        ];
        let graph = Graph { nodes, outputs: vec![Wire::node(1), Wire::node(1)], ..Graph::default() };
        let order = depth_first(&graph).unwrap();
        let mut graph = fold(graph, &order);
        take_gain(&mut graph);
        assert!(graph.gain.is_empty());
        assert_eq!(graph.outputs, [Wire::node(1), Wire::node(1)]);
    }
}
