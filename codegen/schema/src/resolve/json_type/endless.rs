//! Detects infinitely nested types.

use crate::diagnostic::{Diagnostic, Problem};
use crate::graph::{groups, successors_first};
use crate::json_type::{Definition, Expression, JsonType, JsonTypeId, Member};
use crate::limits::{MAX_JSON_ALTERNATIVES, MAX_JSON_DEPTH};

/// The maximum number of reported cycles.
const MAX_REPORTED: usize = 20;

/// The number of names at each end of a displayed path; the middle of longer paths is omitted.
const MAX_PATH_END: usize = 8;

/// Reports types without finite values, and names defined in terms of themselves. `first` is the id of the first type.
pub(super) fn check(types: &[JsonType], first: u32) -> Vec<Diagnostic> {
    let mut diagnostics = cycles(types, first, |definition| match definition {
        Definition::Named(found) => needed(&found.ty),
        _ => needed_by_members(definition.members()),
    });
    if diagnostics.is_empty() {
        // A type `A` defined as `null or A` has finite values, but its definition is recursive.
        diagnostics = cycles(types, first, alternatives);
    }
    if diagnostics.is_empty() {
        diagnostics = check_size(types, first);
    }
    if diagnostics.is_empty() {
        diagnostics = check_depth(types, first);
    }
    diagnostics
}

/// Reports types at the start of a path of references that is too long. Types that refer to each other in a cycle are
/// all on one path.
fn check_depth(types: &[JsonType], first: u32) -> Vec<Diagnostic> {
    let steps = steps(types, first, references);
    let depths = depths(&steps);
    let is_too_deep = |at: &usize| depths[*at] > MAX_JSON_DEPTH;
    // Don't report the types that refer to a reported type.
    let is_first = |at: &usize| !steps[*at].iter().any(&is_too_deep);
    let all = || (0..types.len()).filter(is_too_deep);
    // If all these types are in a cycle, report one of them.
    let reported = all().filter(is_first).chain(all()).take(1);
    let diagnostic = |at: usize| {
        let (name, what) = (types[at].name.clone(), "levels of nested types");
        let problem = Problem::TooMuchNesting { name, max: MAX_JSON_DEPTH as u64, what };
        Diagnostic::new(problem, types[at].span)
    };
    reported.map(diagnostic).collect()
}

/// An upper bound of the number of types on any path from each type, without repetitions. All types that lie on cycles
/// with each other count as if they were on one path.
fn depths(steps: &[Vec<usize>]) -> Vec<usize> {
    let mut depths = vec![0_usize; steps.len()];
    for group in groups(steps) {
        // The depths of this group are still 0, and the depths of all successors are known.
        let below = group.iter().flat_map(|at| &steps[*at]).map(|next| depths[*next]).max();
        let depth = group.len().saturating_add(below.unwrap_or(0));
        for at in group {
            depths[at] = depth;
        }
    }
    depths
}

/// The indices of the types that each type refers to. `references` returns the types that a definition refers to.
fn steps(
    types: &[JsonType],
    first: u32,
    references: impl Fn(&Definition) -> Vec<JsonTypeId>,
) -> Vec<Vec<usize>> {
    let index = |id: JsonTypeId| (id.0 - first) as usize;
    types.iter().map(|found| references(&found.definition).into_iter().map(index).collect()).collect()
}

/// The types that an alias or union refers to directly.
fn alternatives(definition: &Definition) -> Vec<JsonTypeId> {
    if let Definition::Named(found) = definition { found.ty.alternatives() } else { Vec::new() }
}

/// The types that a definition refers to.
fn references(definition: &Definition) -> Vec<JsonTypeId> {
    let mut found = Vec::new();
    for typed in definition.typed() {
        typed.ty.walk(&mut |inner| {
            if let Expression::Named(id) = inner {
                found.push(*id);
            }
        });
    }
    found
}

/// Reports types with too many alternatives, including the alternatives of referenced types. There are no cycles at
/// this point.
fn check_size(types: &[JsonType], first: u32) -> Vec<Diagnostic> {
    let mut diagnostics = Vec::new();
    let steps = steps(types, first, alternatives);
    // The number of alternatives of each type.
    let mut sizes = vec![0_usize; types.len()];
    for at in successors_first(&steps) {
        sizes[at] = steps[at].iter().map(|step| sizes[*step]).fold(1, usize::saturating_add);
        if sizes[at] > MAX_JSON_ALTERNATIVES {
            let problem = Problem::TooManyParts {
                name: types[at].name.clone(),
                what: "alternatives, including the alternatives of referenced types",
                max: MAX_JSON_ALTERNATIVES,
            };
            diagnostics.push(Diagnostic::new(problem, types[at].span));
            // Don't report the types that refer to this one.
            sizes[at] = 1;
        }
    }
    diagnostics
}

fn needed_by_members(members: &[Member]) -> Vec<JsonTypeId> {
    members.iter().filter(|member| member.is_required).flat_map(|member| needed(&member.typed.ty)).collect()
}

/// The types that are part of every value of the expression.
fn needed(expression: &Expression) -> Vec<JsonTypeId> {
    match expression {
        Expression::Named(id) => vec![*id],
        Expression::Either(alternatives) => {
            let all: Vec<Vec<JsonTypeId>> = alternatives.iter().map(needed).collect();
            if all.iter().any(Vec::is_empty) { Vec::new() } else { all.concat() }
        }
        _ => Vec::new(),
    }
}

/// Reports each cycle of references. `references` returns the types that a definition refers to.
fn cycles(
    types: &[JsonType],
    first: u32,
    references: impl Fn(&Definition) -> Vec<JsonTypeId>,
) -> Vec<Diagnostic> {
    let steps = steps(types, first, references);
    let mut diagnostics = Vec::new();
    let mut is_done = vec![false; types.len()];
    let mut is_open = vec![false; types.len()];
    for start in 0..types.len() {
        // The types from `start` to the current one, each with the number of visited successors.
        let mut path: Vec<(usize, usize)> = Vec::new();
        if !is_done[start] {
            path.push((start, 0));
            is_open[start] = true;
        }
        while let Some((at, taken)) = path.last_mut() {
            let Some(next) = steps[*at].get(*taken).copied() else {
                is_done[*at] = true;
                is_open[*at] = false;
                path.pop();
                continue;
            };
            *taken += 1;
            if is_open[next] && diagnostics.len() >= MAX_REPORTED {
                return diagnostics;
            }
            if is_open[next] {
                let from = path.iter().position(|(index, _)| *index == next).unwrap_or(0);
                diagnostics.push(report(types, path[from..].iter().map(|(index, _)| *index)));
            } else if !is_done[next] {
                is_open[next] = true;
                path.push((next, 0));
            }
        }
    }
    diagnostics
}

fn report(types: &[JsonType], cycle: impl Iterator<Item = usize>) -> Diagnostic {
    let found: Vec<&JsonType> = cycle.map(|index| &types[index]).collect();
    let mut names: Vec<&str> = found.iter().chain(&found[..1]).map(|found| found.name.as_str()).collect();
    if names.len() > 2 * MAX_PATH_END {
        names.splice(MAX_PATH_END..names.len() - MAX_PATH_END, ["…"]);
    }
    let mut diagnostic = Diagnostic::new(Problem::EndlessType { path: names.join(" → ") }, found[0].span);
    for other in found.iter().skip(1).take(MAX_PATH_END) {
        diagnostic = diagnostic.with_related(other.span, "through this type");
    }
    diagnostic
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_the_types_on_the_longest_path() {
        assert_eq!(depths(&[vec![1, 2], vec![2], vec![], vec![3]]), [3, 2, 1, 1]);
        // 0 → 1 ⇄ 2 → 3, and 4 → 0.
        assert_eq!(depths(&[vec![1], vec![2], vec![1, 3], vec![], vec![0, 3]]), [4, 3, 3, 1, 5]);
        let ring: Vec<Vec<usize>> = (0..5).map(|at| vec![(at + 1) % 5]).collect();
        assert_eq!(depths(&ring), [5; 5]);
    }
}
