//! Computes the lengths of paths in a graph that may have cycles.

/// The state of a node during the search.
#[derive(Clone, Copy, Default)]
struct Node {
    /// The position in the order of discovery, from 1; 0 if the node isn't discovered yet.
    number: usize,
    /// The lowest number that is known to be reachable within the same component.
    low: usize,
    /// True while the component of the node isn't complete.
    is_open: bool,
}

/// An upper bound of the number of nodes on any path from each node, without repetitions. `steps` are the successors of
/// each node. All nodes that lie on cycles with each other count as if they were on one path.
///
/// Uses Tarjan's algorithm with an explicit stack, because the input determines the depth.
pub(super) fn depths(steps: &[Vec<usize>]) -> Vec<usize> {
    let mut search = Search {
        steps,
        nodes: vec![Node::default(); steps.len()],
        open: Vec::new(),
        depths: vec![0; steps.len()],
    };
    let mut count = 0;
    for start in 0..steps.len() {
        // The nodes from `start` to the current one, each with the number of visited successors.
        let mut path = Vec::new();
        if search.nodes[start].number == 0 {
            path.push((start, 0));
        }
        while let Some((at, taken)) = path.last_mut() {
            let at = *at;
            if search.nodes[at].number == 0 {
                count += 1;
                search.nodes[at] = Node { number: count, low: count, is_open: true };
                search.open.push(at);
            }
            if let Some(next) = steps[at].get(*taken).copied() {
                *taken += 1;
                if search.nodes[next].number == 0 {
                    path.push((next, 0));
                } else if search.nodes[next].is_open {
                    search.nodes[at].low = search.nodes[at].low.min(search.nodes[next].number);
                }
                continue;
            }
            path.pop();
            search.leave(at);
            if let Some((parent, _)) = path.last() {
                search.nodes[*parent].low = search.nodes[*parent].low.min(search.nodes[at].low);
            }
        }
    }
    search.depths
}

struct Search<'s> {
    steps: &'s [Vec<usize>],
    nodes: Vec<Node>,
    /// The nodes whose components aren't complete.
    open: Vec<usize>,
    depths: Vec<usize>,
}

impl Search<'_> {
    /// Completes a component if `at` is its first node.
    fn leave(&mut self, at: usize) {
        if self.nodes[at].low != self.nodes[at].number {
            return;
        }
        let start = self.open.iter().rposition(|open| *open == at).unwrap_or(0);
        let component = self.open.split_off(start);
        // The depths of this component are still 0, and those of all successors are known.
        let below = component.iter().flat_map(|node| &self.steps[*node]).map(|next| self.depths[*next]).max();
        let depth = component.len().saturating_add(below.unwrap_or(0));
        for node in component {
            self.nodes[node].is_open = false;
            self.depths[node] = depth;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_the_nodes_on_the_longest_path() {
        assert_eq!(depths(&[vec![1, 2], vec![2], vec![], vec![3]]), [3, 2, 1, 1]);
        // 0 → 1 ⇄ 2 → 3, and 4 → 0.
        assert_eq!(depths(&[vec![1], vec![2], vec![1, 3], vec![], vec![0, 3]]), [4, 3, 3, 1, 5]);
        let ring: Vec<Vec<usize>> = (0..5).map(|node| vec![(node + 1) % 5]).collect();
        assert_eq!(depths(&ring), [5; 5]);
        assert_eq!(depths(&[]), [0; 0]);
    }

    #[test]
    fn long_paths_do_not_overflow_the_stack() {
        let chain: Vec<Vec<usize>> =
            (0..200_000).map(|node| if node == 0 { Vec::new() } else { vec![node - 1] }).collect();
        assert_eq!(depths(&chain).last(), Some(&200_000));
    }
}
