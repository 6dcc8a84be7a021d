//! Leaves out the nodes that no output needs.

use std::sync::Arc;

use super::{Graph, NodeId, Signal};

/// `graph` with only the nodes in `order`, renumbered so that they stand in it; the others, by their old place and name.
pub fn prune(mut graph: Graph, order: &[NodeId]) -> (Graph, Vec<(NodeId, Arc<str>)>) {
    const GONE: NodeId = NodeId::MAX;
    let mut place = vec![GONE; graph.nodes.len()];
    for (new, &old) in order.iter().enumerate() {
        place[old as usize] = new as NodeId;
    }
    let gone = graph.nodes.iter().enumerate().filter(|(id, _)| place[*id] == GONE);
    let left_out = gone.map(|(id, node)| (id as NodeId, node.name.clone())).collect();
    let mut old: Vec<_> = std::mem::take(&mut graph.nodes).into_iter().map(Some).collect();
    graph.nodes = order.iter().filter_map(|&id| old[id as usize].take()).collect();
    for wire in graph.nodes.iter_mut().flat_map(|n| &mut n.inputs).chain(&mut graph.outputs) {
        if let Some(Signal::Node(id) | Signal::Late(id)) = &mut wire.signal {
            *id = place[*id as usize];
        }
    }
    (graph, left_out)
}

#[cfg(test)]
mod tests {
    use super::super::order::depth_first;
    use super::super::{Graph, Node, Settings, Wire};
    use crate::node::NodeKind;

    #[test]
    fn what_nothing_needs_is_gone_and_named() {
        let node = |name: &str, inputs| Node {
            name: name.into(),
            kind: NodeKind::find("multiply").unwrap(),
            settings: Settings::default().into(),
            inputs,
        };
        let nodes = vec![
            node("unheard", vec![Wire::node(1)]),
            node("source", vec![Wire::constant(1.0)]),
            node("out", vec![Wire::node(1)]),
        ];
        let graph = Graph { nodes, outputs: vec![Wire::node(2)], ..Graph::default() };
        let order = depth_first(&graph).unwrap();
        let (pruned, left_out) = super::prune(graph, &order);
        assert_eq!(left_out.iter().map(|(_, name)| &**name).collect::<Vec<_>>(), ["unheard"]);
        assert_eq!(pruned.nodes.len(), 2);
        assert_eq!(pruned.nodes[1].inputs, [Wire::node(0)]);
        assert_eq!(pruned.outputs, [Wire::node(1)]);
    }
}
