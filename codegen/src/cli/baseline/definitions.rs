//! Compares the findings of `lint` and `breaking` with baselines. A finding is recognised by its rule and subject, so it
//! stays known if its line moves.

use std::collections::{BTreeMap, BTreeSet};

use uavspec_dynamic::breaking;
use uavspec_lint::baseline::{Name, Outcome};
use uavspec_schema::failure::Failure;
use uavspec_schema::finding::Finding;

use super::{BaselineArgs, Subjects};

/// Removes the known findings, and prints the entries that no longer apply. Only entries of rules for which `is_applied`
/// is true can be outdated. Returns the number of known findings, and true if a baseline is out of date.
pub(in crate::cli) fn compare(
    args: &BaselineArgs,
    findings: &mut Vec<Finding>,
    mut subjects: Subjects<'_>,
    is_applied: &dyn Fn(&str) -> bool,
) -> Result<(usize, bool), Failure> {
    if args.baseline.is_empty() && args.write_baseline.is_none() {
        return Ok((0, false));
    }
    let mut baselines = args.read(&[])?;
    // The first finding of each change, by subject and rule. Parser errors are never known.
    let mut groups: BTreeMap<(String, &'static str), Vec<usize>> = BTreeMap::new();
    let mut changes = Vec::with_capacity(findings.len());
    for same in findings.chunk_by(Finding::is_same_change) {
        let (first, rule) = (changes.len(), same[0].rule);
        changes.extend(same.iter().map(|_| first));
        if uavspec_lint::rule(rule).is_some() || breaking::rule(rule).is_some() {
            groups.entry((subjects.of(&same[0]), rule)).or_default().push(first);
        }
    }
    let results = groups.iter().map(|((subject, rule), group)| {
        let file = subjects.sources.path(subjects.sources.source_of(findings[group[0]].span));
        let messages: Vec<String> = group.iter().map(|first| findings[*first].message.clone()).collect();
        (Name { rule: Some(*rule), forms: vec![subject.into()], file }, messages, group)
    });
    let results: Vec<_> = results.collect();
    let scope = |rule: Option<&str>| rule.is_some_and(is_applied);
    let is_outdated = baselines.compare(&scope, |lists, sums| {
        for (name, messages, _) in &results {
            lists.count(sums, name, &Outcome::Failed(messages.clone()));
        }
    })?;
    let mut known = BTreeSet::new();
    for (name, messages, group) in &results {
        if baselines.lists.find_or_add(name, messages, Some(group.len())).is_some() {
            known.extend(group.iter().copied());
        }
    }
    baselines.write()?;
    let mut changes = changes.iter();
    findings.retain(|_| changes.next().is_none_or(|change| !known.contains(change)));
    Ok((known.len(), is_outdated))
}
