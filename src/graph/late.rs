//! Loops. A loop may pass through the `input` of a `delay`, whose output depends on earlier samples only: that wire then carries the
//! value of the sample before, and the delay is one sample shorter. So it is with every delay whose `input` is part of a loop: which
//! of several opens it does not hang on the order of the file.

use std::sync::Arc;

use super::order::depth_first;
use super::start::{Binary, StartProgram, Step};
use super::{Base, Graph, Node, NodeId, Settings, Signal, Wire};
use crate::node::NodeKind;

/// Opens every loop that passes through a delay. `rate` is the engine's, Hz. Gives the order of [`depth_first`].
///
/// # Errors
/// The nodes of a loop without a delay, in order, each reading the next.
pub fn open(graph: &mut Graph, rate: f64) -> Result<Vec<NodeId>, Vec<NodeId>> {
    let component = components(graph);
    for delay in 0..component.len() {
        let node = &graph.nodes[delay];
        let Some(Wire { signal: Some(Signal::Node(from)), .. }) = node.inputs.first().copied() else {
            continue;
        };
        if node.kind == NodeKind::DELAY && component[delay] == component[from as usize] {
            shorten(graph, delay as NodeId, rate);
            graph.nodes[delay].inputs[0].signal = Some(Signal::Late(from));
        }
    }
    depth_first(graph)
}

/// For each node the strongly connected component that it belongs to: two nodes of one read each other, by however many others
/// (R. Tarjan, "Depth-first search and linear graph algorithms", SIAM Journal on Computing, 1972, without recursion).
fn components(graph: &Graph) -> Vec<u32> {
    const NONE: u32 = u32::MAX;
    let count = graph.nodes.len();
    // When a node was first seen; the earliest node that it is known to reach of those whose component is open.
    let (mut seen, mut reaches, mut component) = (vec![NONE; count], vec![NONE; count], vec![NONE; count]);
    let (mut clock, mut open, mut way) = (0, Vec::new(), Vec::new());
    for root in 0..count {
        if seen[root] == NONE {
            way.push((root, 0));
        }
        while let Some((id, next)) = way.last_mut() {
            let id = *id;
            if *next == 0 {
                (seen[id], reaches[id]) = (clock, clock);
                clock += 1;
                open.push(id);
            }
            let wire = graph.nodes[id].inputs.get(*next);
            *next += 1;
            match wire.map(|wire| wire.signal) {
                Some(Some(Signal::Node(from))) => {
                    let from = from as usize;
                    if seen[from] == NONE {
                        way.push((from, 0));
                    } else if component[from] == NONE {
                        reaches[id] = reaches[id].min(seen[from]);
                    }
                }
                Some(_) => {}
                None => {
                    way.pop();
                    if reaches[id] == seen[id] {
                        while let Some(of) = open.pop() {
                            component[of] = id as u32;
                            if of == id {
                                break;
                            }
                        }
                    }
                    if let Some((parent, _)) = way.last() {
                        reaches[*parent] = reaches[*parent].min(reaches[id]);
                    }
                }
            }
        }
    }
    component
}

/// Takes one sample off the time of a delay.
fn shorten(graph: &mut Graph, delay: NodeId, rate: f64) {
    let Some(time) = graph.nodes[delay as usize].inputs.get(1).copied() else { return };
    let shorter = match time {
        Wire { signal: None, base: Base::Constant(seconds) } => Wire::constant(seconds - 1.0 / rate),
        Wire { signal: None, base: Base::Start(id) } => {
            let mut steps = graph.starts[id as usize].steps().to_vec();
            steps.extend([Step::Number(1.0 / rate), Step::Binary(Binary::Subtract)]);
            match StartProgram::new(steps) {
                Ok(program) => {
                    graph.starts.push(program);
                    Wire::start(graph.starts.len() as u32 - 1)
                }
                // One level deeper than a program may be: a sample more is the smaller evil.
                Err(_) => time,
            }
        }
        moving => {
            let name = Arc::clone(&graph.nodes[delay as usize].name);
            let inputs = vec![moving, Wire::constant(-1.0 / rate)];
            let settings = Arc::new(Settings::default());
            graph.nodes.push(Node { name, kind: NodeKind::ADD, settings, inputs });
            Wire::node(graph.nodes.len() as NodeId - 1)
        }
    };
    graph.nodes[delay as usize].inputs[1] = shorter;
}

#[cfg(test)]
mod tests {
    use super::super::{Base, Graph, Node, Settings, Signal, Wire};
    use super::open;
    use crate::node::NodeKind;

    fn node(kind: &str, inputs: Vec<Wire>) -> Node {
        let settings = Settings { constants: vec![1.0], ..Settings::default() };
        Node { name: "n".into(), kind: NodeKind::find(kind).unwrap(), settings: settings.into(), inputs }
    }

    #[test]
    fn a_delay_opens_a_loop_and_is_shorter_for_it() {
        let nodes = vec![
            node("add", vec![Wire::node(1), Wire::node(2)]),
            node("delay", vec![Wire::node(0), Wire::constant(0.01)]),
            node("white", vec![Wire::constant(1.0)]),
        ];
        let mut graph = Graph { nodes, outputs: vec![Wire::node(0)], ..Graph::default() };
        let order = open(&mut graph, 8000.0).unwrap();
        assert_eq!(order.len(), 3);
        assert_eq!(graph.nodes[1].inputs[0].signal, Some(Signal::Late(0)));
        assert_eq!(graph.nodes[1].inputs[1].base, Base::Constant(0.01 - 0.000_125));
    }

    #[test]
    fn twenty_thousand_loops_are_opened_at_once() {
        const LOOPS: u32 = 20_000;
        // Each sum reads the next sum and its own echo.
        let mut nodes: Vec<Node> = (0..LOOPS)
            .map(|i| {
                node(
                    "add",
                    vec![
                        if i + 1 < LOOPS { Wire::node(i + 1) } else { Wire::constant(1.0) },
                        Wire::node(LOOPS + i),
                    ],
                )
            })
            .collect();
        nodes.extend((0..LOOPS).map(|i| node("delay", vec![Wire::node(i), Wire::constant(0.01)])));
        let mut graph = Graph { nodes, outputs: vec![Wire::node(0)], ..Graph::default() };
        let order = open(&mut graph, 8000.0).unwrap();
        assert_eq!(order.len(), 2 * LOOPS as usize);
        let late = |i: u32| graph.nodes[(LOOPS + i) as usize].inputs[0].signal == Some(Signal::Late(i));
        assert!((0..LOOPS).all(late));
        let (graph, _) = crate::graph::prune::prune(graph, &order);
        let program = crate::graph::program::program(graph);
        assert_eq!((program.late.len(), program.ops.len()), (LOOPS as usize, 2 * LOOPS as usize));
    }

    #[test]
    fn one_long_way_that_many_delays_close_is_walked_once() {
        const MANY: u32 = 20_000;
        // A sum of many echoes of the end of a long chain that begins with the sum.
        let mut nodes = vec![node("add", (0..MANY).map(|i| Wire::node(1 + i)).collect())];
        nodes.extend((0..MANY).map(|_| node("delay", vec![Wire::node(2 * MANY), Wire::constant(0.01)])));
        nodes.push(node("add", vec![Wire::node(0)]));
        nodes.extend((1..MANY).map(|i| node("add", vec![Wire::node(MANY + i)])));
        let mut graph = Graph { nodes, outputs: vec![Wire::node(0)], ..Graph::default() };
        assert_eq!(open(&mut graph, 8000.0).map(|order| order.len()), Ok(1 + 2 * MANY as usize));
    }

    #[test]
    fn a_delay_beside_a_loop_keeps_its_length() {
        let nodes = vec![
            node("add", vec![Wire::node(1), Wire::node(3)]),
            node("delay", vec![Wire::node(0), Wire::constant(0.01)]),
            node("delay", vec![Wire::node(0), Wire::constant(0.02)]),
            node("delay", vec![Wire::constant(1.0), Wire::constant(0.03)]),
        ];
        let mut graph = Graph { nodes, outputs: vec![Wire::node(0), Wire::node(2)], ..Graph::default() };
        open(&mut graph, 8000.0).unwrap();
        assert_eq!(graph.nodes[2].inputs, [Wire::node(0), Wire::constant(0.02)]);
        assert_eq!(graph.nodes[3].inputs[1], Wire::constant(0.03));
        assert_eq!(graph.nodes[1].inputs[0].signal, Some(Signal::Late(0)));
    }

    #[test]
    fn a_loop_without_a_delay_stays_an_error() {
        let nodes = vec![node("add", vec![Wire::node(1)]), node("add", vec![Wire::node(0)])];
        let mut graph = Graph { nodes, outputs: vec![Wire::node(0)], ..Graph::default() };
        assert_eq!(open(&mut graph, 8000.0), Err(vec![0, 1]));
    }
}
