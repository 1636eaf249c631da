//! Finds cycles in graphs, such as types that refer to each other.

/// The groups of nodes that lead to each other, in which most nodes are alone. `steps` are the successors of each node.
///
/// Each group follows the groups that its nodes lead to. Within a group, each node follows its successors, except those
/// that close a cycle.
///
/// Uses Tarjan's algorithm with an explicit stack, because the input determines the depth.
///
/// ```
/// // 0 → 1 ⇄ 2 → 3
/// let groups = uavspec_schema::graph::groups(&[vec![1], vec![2], vec![1, 3], vec![]]);
/// assert_eq!(groups, [vec![3], vec![2, 1], vec![0]]);
/// ```
pub fn groups(steps: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut groups = Vec::new();
    // The position of each node in the order of discovery, from 1; 0 if the node isn't discovered yet.
    let mut numbers = vec![0; steps.len()];
    // The lowest number that is known to be reachable from each node within its group; the maximum if its group is complete.
    let mut lows = vec![usize::MAX; steps.len()];
    let mut count = 0;
    // The nodes whose successors are all visited, but whose groups aren't complete.
    let mut open: Vec<usize> = Vec::new();
    for start in 0..steps.len() {
        // The nodes from `start` to the current one, each with the number of visited successors.
        let mut path = Vec::new();
        if numbers[start] == 0 {
            path.push((start, 0));
        }
        while let Some((at, taken)) = path.last_mut() {
            let at = *at;
            if numbers[at] == 0 {
                count += 1;
                numbers[at] = count;
                lows[at] = count;
            }
            if let Some(next) = steps[at].get(*taken).copied() {
                *taken += 1;
                if numbers[next] == 0 {
                    path.push((next, 0));
                } else {
                    lows[at] = lows[at].min(lows[next]);
                }
                continue;
            }
            path.pop();
            open.push(at);
            if lows[at] == numbers[at] {
                let before = open.iter().rposition(|node| numbers[*node] < numbers[at]);
                let group = open.split_off(before.map_or(0, |before| before + 1));
                for node in &group {
                    lows[*node] = usize::MAX;
                }
                groups.push(group);
            }
            if let Some((parent, _)) = path.last() {
                lows[*parent] = lows[*parent].min(lows[at]);
            }
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn finds_the_nodes_of_each_cycle() {
        assert_eq!(groups(&[vec![1, 2], vec![2], vec![], vec![3]]), [vec![2], vec![1], vec![0], vec![3]]);
        assert_eq!(groups(&[vec![1], vec![0, 2], vec![3], vec![2, 2]]), [vec![3, 2], vec![1, 0]]);
        // Node 2 follows node 1, although both close a cycle.
        assert_eq!(groups(&[vec![1, 2], vec![0], vec![1]]), [vec![1, 2, 0]]);
        assert_eq!(groups(&[]), [vec![0; 0]; 0]);
    }

    #[test]
    fn long_paths_do_not_overflow_the_stack() {
        let ring: Vec<Vec<usize>> = (0..200_000).map(|node| vec![(node + 1) % 200_000]).collect();
        assert_eq!(groups(&ring).concat().first(), Some(&199_999));
    }
}
