//! Loops. A loop may pass through the `input` of a `delay`, whose output depends on earlier samples only: that wire then carries the
//! value of the sample before, and the delay is one sample shorter.

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
    loop {
        let cycle = match depth_first(graph) {
            Ok(order) => return Ok(order),
            Err(cycle) => cycle,
        };
        let found = cycle.iter().enumerate().find(|&(i, &id)| {
            let next = cycle[(i + 1) % cycle.len()];
            let node = &graph.nodes[id as usize];
            let input = node.inputs.first().and_then(|wire| wire.signal);
            node.kind.spec().name == "delay" && input == Some(Signal::Node(next))
        });
        let Some((i, &delay)) = found else { return Err(cycle) };
        let next = cycle[(i + 1) % cycle.len()];
        shorten(graph, delay, rate);
        graph.nodes[delay as usize].inputs[0].signal = Some(Signal::Late(next));
    }
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
            let Some(kind) = NodeKind::find("add") else { return };
            let name = Arc::clone(&graph.nodes[delay as usize].name);
            let inputs = vec![moving, Wire::constant(-1.0 / rate)];
            graph.nodes.push(Node { name, kind, settings: Arc::new(Settings::default()), inputs });
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
    fn a_loop_without_a_delay_stays_an_error() {
        let nodes = vec![node("add", vec![Wire::node(1)]), node("add", vec![Wire::node(0)])];
        let mut graph = Graph { nodes, outputs: vec![Wire::node(0)], ..Graph::default() };
        assert_eq!(open(&mut graph, 8000.0), Err(vec![0, 1]));
    }
}
