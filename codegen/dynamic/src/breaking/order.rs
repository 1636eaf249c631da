//! Comparison of sequences: moved items and matched items.

/// Marks as few items of `positions` as possible, so that the remaining items are in ascending order.
pub(super) fn moved(positions: &[usize]) -> Vec<bool> {
    // Entry n is the lowest item that ends an ascending sequence of n + 1 items.
    let mut ends: Vec<usize> = Vec::new();
    let mut before: Vec<Option<usize>> = vec![None; positions.len()];
    for (at, position) in positions.iter().enumerate() {
        let length = ends.partition_point(|end| positions[*end] < *position);
        before[at] = length.checked_sub(1).map(|shorter| ends[shorter]);
        if length == ends.len() {
            ends.push(at);
        } else {
            ends[length] = at;
        }
    }
    let mut moved = vec![true; positions.len()];
    let mut kept = ends.last().copied();
    while let Some(at) = kept {
        moved[at] = false;
        kept = before[at];
    }
    moved
}

/// Matches two sequences without crossing pairs. Maximizes the number of pairs that satisfy `can_match`, and then their
/// total similarity. The returned pairs of indices are in ascending order. `budget` is the number of remaining
/// comparisons.
pub(super) fn align(
    old: usize,
    new: usize,
    budget: &mut usize,
    can_match: impl Fn(usize, usize) -> bool,
    likeness: impl Fn(usize, usize) -> f64,
) -> Vec<(usize, usize)> {
    let comparisons = old.saturating_mul(new);
    if comparisons == 0 || comparisons > *budget {
        return (0..old.min(new))
            .map(|at| (at, at))
            .filter(|(left, right)| can_match(*left, *right))
            .collect();
    }
    *budget -= comparisons;
    // best[i][j] is the number of pairs, and their total similarity, for the tails that start at i and j.
    let mut best = vec![vec![(0_usize, 0.0_f64); new + 1]; old + 1];
    let matched = |best: &[Vec<(usize, f64)>], left: usize, right: usize| {
        let (count, sum) = best[left + 1][right + 1];
        (count + 1, sum + likeness(left, right))
    };
    let greater = |one: (usize, f64), other: (usize, f64)| {
        if (one.0, one.1) >= (other.0, other.1) { one } else { other }
    };
    for left in (0..old).rev() {
        for right in (0..new).rev() {
            let mut found = greater(best[left + 1][right], best[left][right + 1]);
            if can_match(left, right) {
                found = greater(matched(&best, left, right), found);
            }
            best[left][right] = found;
        }
    }
    let (mut left, mut right) = (0, 0);
    let mut pairs = Vec::new();
    while left < old && right < new {
        if can_match(left, right) && best[left][right] == matched(&best, left, right) {
            pairs.push((left, right));
            left += 1;
            right += 1;
        } else if best[left][right] == best[left + 1][right] {
            left += 1;
        } else {
            right += 1;
        }
    }
    pairs
}

/// The maximum length of names that are compared letter by letter.
const MAX_NAME_LEN: usize = 100;

/// The similarity of two names, from 0 to 1, by edit distance. The similarity is 1 if the longer name ends with all
/// words of the shorter name, as in `wind_speed` and `speed`.
pub(super) fn likeness(left: &str, right: &str) -> f64 {
    if left.len() > MAX_NAME_LEN || right.len() > MAX_NAME_LEN {
        return 0.0;
    }
    let (long, short) = if left.len() < right.len() { (right, left) } else { (left, right) };
    if long.strip_suffix(short).is_some_and(|rest| rest.is_empty() || rest.ends_with('_')) {
        return 1.0;
    }
    strsim::normalized_damerau_levenshtein(left, right)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_as_few_items_as_possible() {
        assert_eq!(moved(&[0, 1, 2]), [false; 3]);
        assert_eq!(moved(&[2, 0, 1]), [true, false, false]);
        assert_eq!(moved(&[0, 3, 1, 2, 4]), [false, true, false, false, false]);
        assert_eq!(moved(&[]), [false; 0]);
    }

    #[test]
    fn matches_most_pairs_and_most_similar_names() {
        let old = ["speed", "course"];
        let new = ["altitude", "speed_ground", "course_ground"];
        let similarity = |left: usize, right: usize| likeness(old[left], new[right]);
        assert_eq!(align(2, 3, &mut 100, |_, _| true, similarity), [(0, 1), (1, 2)]);
        assert_eq!(align(2, 3, &mut 100, |left, right| left == 1 && right == 0, similarity), [(1, 0)]);
        assert_eq!(align(0, 3, &mut 100, |_, _| true, similarity), []);
    }
}
