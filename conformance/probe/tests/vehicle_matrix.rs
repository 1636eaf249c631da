//! Tests that probe the reference autopilot and the reference component: without a bug, there are no findings. Each bug
//! violates its rule, live and in the recording.

use uavspec_probe::self_test::vehicle::{cases, pairs};
use uavspec_rules::px4::RULES;
use uavspec_test_support::extent;

#[test]
fn each_bug_of_a_participant_violates_only_its_rule() {
    let wanted = std::env::var("UAVSPEC_BUGS").unwrap_or_default();
    let mut cases = cases();
    cases.retain(|case| wanted.is_empty() || wanted.split(',').any(|name| name == case.name()));
    if wanted.is_empty() {
        cases = cases.into_iter().step_by(extent(1, 6)).collect();
    }
    let mut rows = Vec::new();
    pairs(&cases, &[], |row| rows.push(row.expect("a probe")));
    assert_eq!(rows.len(), cases.len());
    let wrong = rows.iter().filter(|row| !row.is_right());
    let wrong: Vec<String> =
        wrong.map(|row| format!("{}: {}", row.case.name(), row.mismatch_text())).collect();
    assert!(wrong.is_empty(), "{} of {}\n{}", wrong.len(), rows.len(), wrong.join("\n"));
}

#[test]
fn rules_on_participants_have_a_bug() {
    let is_on_participants =
        |id: &str| ["PX-EXT-", "PX-QOS-", "PX-TYPE-"].iter().any(|prefix| id.starts_with(prefix));
    let without = RULES.iter().filter(|entry| is_on_participants(entry.rule.id) && entry.bug.is_none());
    assert_eq!(without.map(|entry| entry.rule.id).collect::<Vec<_>>(), Vec::<&str>::new());
}
