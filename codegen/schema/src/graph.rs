//! Graphs that may have cycles, such as types that refer to each other. `steps` lists the successors of each
//! node.

use petgraph::algo::kosaraju_scc;
use petgraph::graph::{DiGraph, NodeIndex};
use petgraph::visit::DfsPostOrder;

fn graph(steps: &[Vec<usize>]) -> DiGraph<(), (), usize> {
    let edges = steps.iter().enumerate().flat_map(|(at, next)| next.iter().map(move |next| (at, *next)));
    let mut graph = DiGraph::from_edges(edges);
    while graph.node_count() < steps.len() {
        graph.add_node(());
    }
    graph
}

/// The strongly connected components of the graph. Each component follows the components that its nodes lead to.
///
/// ```
/// // 0 → 1 ⇄ 2 → 3
/// let mut groups = uavspec_schema::graph::groups(&[vec![1], vec![2], vec![1, 3], vec![]]);
/// groups[1].sort();
/// assert_eq!(groups, [vec![3], vec![1, 2], vec![0]]);
/// ```
pub fn groups(steps: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let groups = kosaraju_scc(&graph(steps)).into_iter();
    groups.map(|group| group.into_iter().map(NodeIndex::index).collect()).collect()
}

/// All nodes, each after its successors. A successor may follow a node only if it leads back to
/// this node.
///
/// ```
/// // 0 → 1 ⇄ 2 → 3
/// let order = uavspec_schema::graph::successors_first(&[vec![1], vec![2], vec![1, 3], vec![]]);
/// assert_eq!(order, [3, 2, 1, 0]);
/// ```
pub fn successors_first(steps: &[Vec<usize>]) -> Vec<usize> {
    let graph = graph(steps);
    let mut search = DfsPostOrder::empty(&graph);
    let mut order = Vec::with_capacity(steps.len());
    for start in graph.node_indices() {
        search.move_to(start);
        while let Some(node) = search.next(&graph) {
            order.push(node.index());
        }
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_paths_do_not_overflow_the_stack() {
        let ring: Vec<Vec<usize>> = (0..200_000).map(|node| vec![(node + 1) % 200_000]).collect();
        assert_eq!(groups(&ring).len(), 1);
        assert_eq!(successors_first(&ring).first(), Some(&199_999));
    }
}
