//! The reference server, probed: without a bug nothing is found, and with each bug the rule that it breaks.

use std::collections::BTreeSet;

use crate::definitions::Definitions;
use crate::matrix::live::{Row, cases, live};
use crate::rules::{RULES, flockwave};

#[test]
fn each_bug_is_found_and_nothing_else() {
    let definitions = Definitions::built_in();
    let wanted = std::env::var("UAVSPEC_BUGS").unwrap_or_default();
    let mut cases = cases();
    cases.retain(|case| {
        wanted.is_empty() || case.bug.is_some_and(|bug| wanted.split(',').any(|id| id == bug.rule.id))
    });
    let mut rows: Vec<Row> = Vec::new();
    live(&cases, &definitions, |row| rows.push(row.expect("a server")));
    assert_eq!(rows.len(), cases.len());
    let wrong = rows.iter().filter(|row| !row.is_right());
    let wrong: Vec<String> =
        wrong.map(|row| format!("{}: {}", row.case.name(), row.mismatch_text())).collect();
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), rows.len(), wrong.join("\n"));
    // What no bug breaks can't be tried on this server.
    let covered: BTreeSet<&str> = rows.iter().flat_map(|row| row.covered.iter().copied()).collect();
    let idle = RULES.iter().filter(|rule| rule.is_on_flockwave() && !covered.contains(rule.id));
    assert_eq!(idle.map(|rule| rule.id).collect::<Vec<_>>(), Vec::<&str>::new());
}

#[test]
fn each_rule_on_servers_has_a_bug() {
    let on_servers: Vec<&str> =
        RULES.iter().filter(|rule| rule.is_on_flockwave()).map(|rule| rule.id).collect();
    let with_bug = flockwave::RULES.iter().filter(|of| !of.bug.description.is_empty());
    assert_eq!(with_bug.map(|of| of.rule.id).collect::<Vec<_>>(), on_servers);
}
