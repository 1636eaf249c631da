//! Tests that probe the reference server: without a bug, there are no findings. Each bug violates its rule.

use std::collections::BTreeSet;

use uavspec_probe::self_test::live::{Case, Row, cases, live};
use uavspec_rules::definitions::Definitions;
use uavspec_rules::flockwave::Needs;
use uavspec_rules::{RULES, flockwave};
use uavspec_serve::Transport;
use uavspec_test_support::extent;

/// True if the probe needs no socket, so it takes no real time.
fn is_simulated(case: &Case) -> bool {
    case.transport == Transport::Tcp && case.bug.is_some_and(|entry| entry.bug.needs != Needs::Tcp)
}

#[test]
fn each_bug_violates_only_its_rule() {
    let definitions = Definitions::built_in();
    let wanted = std::env::var("UAVSPEC_BUGS").unwrap_or_default();
    let mut cases = cases();
    cases.retain(|case| {
        wanted.is_empty() || case.bug.is_some_and(|bug| wanted.split(',').any(|id| id == bug.rule.id))
    });
    let is_whole = !wanted.is_empty() || extent(true, false);
    if !is_whole {
        cases.retain(is_simulated);
        cases = cases.into_iter().step_by(43).collect();
    }
    let mut rows: Vec<Row> = Vec::new();
    live(&cases, &definitions, |row| rows.push(row.expect("a server")));
    assert_eq!(rows.len(), cases.len());
    let wrong = rows.iter().filter(|row| !row.is_right());
    let wrong: Vec<String> =
        wrong.map(|row| format!("{}: {}", row.case.name(), row.mismatch_text())).collect();
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), rows.len(), wrong.join("\n"));
    if !is_whole {
        return;
    }
    // This server can't test rules that have no bug.
    let covered: BTreeSet<&str> = rows.iter().flat_map(|row| row.found.covered.iter().copied()).collect();
    let idle = RULES.iter().filter(|rule| rule.is_on_flockwave() && !covered.contains(rule.id));
    assert_eq!(idle.map(|rule| rule.id).collect::<Vec<_>>(), Vec::<&str>::new());
}

#[test]
fn each_server_rule_has_a_bug() {
    let on_servers: Vec<&str> =
        RULES.iter().filter(|rule| rule.is_on_flockwave()).map(|rule| rule.id).collect();
    let with_bug = flockwave::RULES.iter().filter(|rule| !rule.bug.description.is_empty());
    assert_eq!(with_bug.map(|rule| rule.rule.id).collect::<Vec<_>>(), on_servers);
}
