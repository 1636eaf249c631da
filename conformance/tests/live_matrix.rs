//! The reference server, probed: without a bug nothing is found, and with each bug the rule that it breaks.

use std::collections::BTreeSet;

use uavspec_conformance::definitions::Definitions;
use uavspec_conformance::matrix::live::{Row, cases, live};

#[test]
fn each_bug_is_found_and_nothing_else() {
    let definitions = Definitions::built_in();
    let wanted = std::env::var("UAVSPEC_BUGS").unwrap_or_default();
    let mut cases = cases();
    cases.retain(|case| {
        wanted.is_empty() || case.bug.is_some_and(|bug| wanted.split(',').any(|id| id == bug.rule))
    });
    let mut rows: Vec<Row> = Vec::new();
    live(&cases, &definitions, |row| rows.push(row.expect("a server")));
    assert_eq!(rows.len(), cases.len());
    let wrong: Vec<String> = rows
        .iter()
        .filter(|row| !row.is_right())
        .map(|row| {
            let list = |rules: &BTreeSet<&str>| rules.iter().copied().collect::<Vec<_>>().join(", ");
            let (expected, found) = (list(&row.expected()), list(&row.broken));
            let replayed = if row.replayed == row.broken {
                String::new()
            } else {
                format!(", recorded {}", list(&row.replayed))
            };
            format!("{}: expected {expected}, found {found}{replayed} {:?}", row.case.name(), row.failure)
        })
        .collect();
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), rows.len(), wrong.join("\n"));
}
