use serde_json::json;
use uavspec_check::{Coverage, JsonSummary, Share, Summary, Unit};
use uavspec_model::{Extent, Level};
use uavspec_px4::json::Dialects;
use uavspec_rules::RULES;

use super::*;
use crate::{About, CaseVerdict, RuleVerdict, Settings, Subject, Verdict};

/// The settings of a run without options.
fn default() -> Settings {
    Settings::default()
}

/// The coverage of a capture with one record for each topic.
fn coverage(checked: u64, total: u64) -> Coverage {
    let share = Share::of(checked, total);
    Coverage { unit: Unit::Topic, units: share, records: share, values: share, ..Coverage::default() }
}

/// A capture with this coverage and these verdicts.
fn capture(coverage: Coverage, verdicts: &[Verdict], settings: &Settings) -> Subject {
    let rule = |(verdict, rule): (&Verdict, &&'static uavspec_model::Rule)| RuleVerdict {
        id: rule.id,
        level: if *verdict == Verdict::Warn { Level::Should } else { Level::Must },
        verdict: *verdict,
        covered: 1,
        findings: 1,
    };
    let json = JsonSummary {
        lines: 1,
        types: 1,
        skipped: 0,
        releases: Vec::new(),
        undefined: std::collections::BTreeSet::new(),
        dialects: Dialects::default(),
        has_objects: true,
    };
    let mut subject = Subject {
        path: "a.jsonl".to_owned(),
        about: About::Capture(Summary::Json(json)),
        records: coverage.records.total.unwrap_or_default(),
        checked: coverage.records.checked,
        duration_us: 0,
        outcome: Outcome::new(OutcomeKind::Nothing, ""),
        rules: verdicts.iter().zip(&RULES).map(rule).collect(),
        findings: Vec::new(),
        more_findings: 0,
        corruption: Vec::new(),
        more_corruption: 0,
        extent: Extent::Whole,
        coverage,
        event_metadata: None,
        incomplete: Vec::new(),
        cut_short: Vec::new(),
        notes: Vec::new(),
        requests: Vec::new(),
        is_readable_again: true,
        start_utc: None,
        elapsed: 0,
    };
    subject.set_outcome(settings);
    subject
}

/// A fully checked capture with these verdicts.
fn full(verdicts: &[Verdict]) -> Subject {
    capture(coverage(1, 1), verdicts, &default())
}

/// A capture that was read to this extent.
fn read(extent: Extent, verdict: Verdict) -> Subject {
    let mut capture = full(&[verdict]);
    capture.extent = extent;
    capture.set_outcome(&default());
    capture
}

fn run(subjects: &[Subject]) -> Outcome {
    Outcome::for_run(Action::Check, &Totals::of(subjects), &[], Vec::new())
}

fn outcome_of(subjects: &[Subject]) -> (u8, String) {
    let outcome = run(subjects);
    assert_eq!(outcome.status, outcome.kind.status());
    (outcome.status, outcome.text)
}

#[test]
fn the_worst_rule_decides_the_outcome() {
    let outcome = |verdicts: &[Verdict]| outcome_of(&[full(verdicts)]);
    assert_eq!(outcome(&[Verdict::Pass, Verdict::Shown]), (0, "Conforms".to_owned()));
    assert_eq!(outcome(&[Verdict::Warn]), (0, "Conforms, with 1 warning".to_owned()));
    assert_eq!(outcome(&[Verdict::Warn, Verdict::Warn]), (0, "Conforms, with 2 warnings".to_owned()));
    let violated = [Verdict::Fail, Verdict::Fail, Verdict::Warn];
    assert_eq!(outcome(&violated), (1, "Does not conform: 2 MUST, 1 SHOULD".to_owned()));
}

#[test]
fn only_full_coverage_conforms() {
    let outcome = |checked, total, verdicts: &[Verdict]| {
        outcome_of(&[capture(coverage(checked, total), verdicts, &default())])
    };
    let partial = "partial coverage: 1 of 41 topics fully checked";
    assert_eq!(outcome(41, 41, &[Verdict::Pass]), (0, "Conforms".to_owned()));
    assert_eq!(outcome(1, 41, &[Verdict::Pass]), (0, format!("No violations found, {partial}")));
    assert_eq!(outcome(1, 41, &[Verdict::Warn]), (0, format!("1 warning, {partial}")));
    assert_eq!(outcome(1, 41, &[Verdict::Fail]).0, 1);
    assert_eq!(outcome(0, 41, &[Verdict::Pass]), (6, "Incomplete: no topic was checked".to_owned()));
    assert_eq!(outcome(0, 0, &[]), (6, "Incomplete: the file contains no messages".to_owned()));
    // Some values of a topic with a different format are checked.
    let some = Coverage { values: Share::of(3, 9), ..coverage(0, 41) };
    let outcome = outcome_of(&[capture(some, &[Verdict::Pass], &default())]);
    assert_eq!(outcome.1, "No violations found, partial coverage: 0 of 41 topics fully checked");
}

#[test]
fn a_minimum_coverage_makes_partial_coverage_incomplete() {
    let outcome = |checked, total, min| {
        let settings = Settings { min_coverage: Some(min), ..default() };
        outcome_of(&[capture(coverage(checked, total), &[Verdict::Pass], &settings)])
    };
    assert_eq!(outcome(9, 10, 90.0).0, 0);
    assert_eq!(
        outcome(8, 10, 90.5),
        (6, "Incomplete: 8 of 10 topics fully checked (80 %), less than 90.5 %".to_owned())
    );
    assert_eq!(outcome(10, 10, 100.0), (0, "Conforms".to_owned()));
}

#[test]
fn an_allowed_incomplete_outcome_keeps_its_kind_and_reasons() {
    let settings = Settings { allows_incomplete: true, ..default() };
    let allowed = |extent, verdict| {
        let mut capture = full(&[verdict]);
        capture.extent = extent;
        capture.set_outcome(&settings);
        run(&[capture.clone(), capture])
    };
    let outcome = allowed(Extent::EndsEarly, Verdict::Pass);
    assert_eq!((outcome.kind, outcome.status), (OutcomeKind::Incomplete, 0));
    assert_eq!(outcome.remarks, ["a.jsonl: the file is truncated"; 2]);
    assert_eq!(allowed(Extent::EndsEarly, Verdict::Fail).status, 1);
}

#[test]
fn several_captures_count_each_rule_once() {
    let (good, bad, empty) =
        (full(&[Verdict::Pass]), full(&[Verdict::Fail]), capture(coverage(0, 0), &[], &default()));
    let part = capture(coverage(1, 2), &[Verdict::Pass], &default());
    let all = [good.clone(), bad.clone(), bad.clone(), empty.clone(), part.clone()];
    assert_eq!(outcome_of(&all), (1, "Does not conform: 1 MUST, 0 SHOULD (2 of 5 files)".to_owned()));
    assert_eq!(outcome_of(&[good.clone(), empty.clone()]), (6, "Incomplete: 1 of 2 files".to_owned()));
    let warned = full(&[Verdict::Warn]);
    assert_eq!(
        outcome_of(&[good.clone(), warned.clone(), warned]),
        (0, "Conforms, with 1 warning".to_owned())
    );
    let text = "No violations found, partial coverage of 1 of 2 files";
    assert_eq!(outcome_of(&[good.clone(), part]), (0, text.to_owned()));
    assert_eq!(outcome_of(&[empty.clone(), empty]), (6, "Incomplete: 2 of 2 files".to_owned()));
    assert_eq!(outcome_of(&[]), (5, "Nothing was checked".to_owned()));
    assert_eq!(outcome_of(&[good, bad]).0, 1);
}

#[test]
fn unread_data_makes_the_outcome_incomplete() {
    for (extent, reason) in [
        (Extent::EndsEarly, "the file is truncated"),
        (Extent::WithGaps, "parts of the file are corrupt"),
        (Extent::Unreadable, "the file can't be read completely"),
    ] {
        let outcome = run(&[read(extent, Verdict::Pass)]);
        assert_eq!((outcome.status, outcome.text), (6, format!("Incomplete: {reason}")));
        assert_eq!(outcome.remarks, ["no violations found in the part that was checked"]);
        let outcome = run(&[read(extent, Verdict::Fail)]);
        assert_eq!((outcome.status, outcome.text.as_str()), (1, "Does not conform: 1 MUST, 0 SHOULD"));
        assert_eq!(outcome.remarks, [reason]);
    }
    let all = [read(Extent::Unreadable, Verdict::Pass), full(&[Verdict::Fail])];
    let outcome = run(&all);
    assert_eq!(outcome.text, "Does not conform: 1 MUST, 0 SHOULD (1 of 2 files)");
    assert_eq!(outcome.remarks, ["a.jsonl: the file can't be read completely"]);
}

#[test]
fn a_session_that_was_cut_short_is_incomplete() {
    let mut session = full(&[Verdict::Pass]);
    session.cut_short = vec!["the server closed the connection".to_owned()];
    session.set_outcome(&default());
    let outcome = run(std::slice::from_ref(&session));
    assert_eq!((outcome.status, outcome.text.as_str()), (6, "Incomplete: the server closed the connection"));
    session.set_outcome(&default());
    assert_eq!(session.incomplete, session.cut_short, "a reason is listed once");
}

#[test]
fn required_rules_and_unreadable_files_change_the_outcome() {
    let good = Totals::of(&[full(&[Verdict::Pass])]);
    let required = Outcome::for_run(Action::Check, &good, &[], vec!["a rule was required".to_owned()]);
    assert_eq!((required.status, required.text.as_str()), (1, "Does not conform"));
    assert_eq!(required.remarks, ["a rule was required"]);
    assert_eq!(required.last_line(), "does not conform");
    let truncated = [read(Extent::EndsEarly, Verdict::Pass), full(&[Verdict::Pass])];
    let remarks = vec!["a rule was required".to_owned()];
    let required = Outcome::for_run(Action::Check, &Totals::of(&truncated), &[], remarks);
    assert_eq!(required.remarks, ["a.jsonl: the file is truncated", "a rule was required"]);
    let gone = Unreadable { path: "gone".to_owned(), message: "absent".to_owned() };
    let unreadable = Outcome::for_run(Action::Check, &good, &[gone.clone(), gone], Vec::new());
    assert_eq!((unreadable.status, unreadable.text.as_str()), (3, "Failed: 2 files can't be opened"));
    assert_eq!(unreadable.remarks, ["Conforms"], "the outcome of the other files is a remark");
}

#[test]
fn a_testee_fails_if_a_case_fails_or_it_violates_the_protocol_or_stops() {
    let outcome = |passed, failed, unsupported, violations, gave_up| {
        let counts = Counts { passed, failed, unsupported, ..Counts::default() };
        let outcome = Outcome::for_testee(counts, violations, gave_up);
        (outcome.status, outcome.text)
    };
    assert_eq!(outcome(9, 0, 0, 0, None), (0, "Conforms".to_owned()));
    let partial = "No violations found, partial coverage: 9 of 12 cases checked";
    assert_eq!(outcome(9, 0, 3, 0, None), (0, partial.to_owned()));
    assert_eq!(outcome(9, 1, 3, 2, None), (1, "Does not conform: 1 of 10 cases failed".to_owned()));
    assert_eq!(outcome(9, 0, 0, 2, None), (1, "Does not conform: violates the test protocol".to_owned()));
    assert_eq!(outcome(0, 0, 3, 0, None), (5, "Nothing was checked".to_owned()));
    assert_eq!(outcome(9, 1, 0, 0, Some("it ended")), (3, "Failed: it ended".to_owned()));
}

#[test]
fn json_reports_contain_the_names_of_the_other_reports() {
    for kind in OutcomeKind::ALL {
        assert_eq!(json!(kind), kind.name());
    }
    for verdict in [
        Verdict::NotCovered,
        Verdict::Unsupported,
        Verdict::Pass,
        Verdict::Shown,
        Verdict::Known,
        Verdict::Inconclusive,
        Verdict::Warn,
        Verdict::Fail,
    ] {
        assert_eq!(json!(verdict), verdict.name());
    }
    for verdict in [
        CaseVerdict::Pass,
        CaseVerdict::Fail,
        CaseVerdict::Unsupported,
        CaseVerdict::Crashed,
        CaseVerdict::TimedOut,
        CaseVerdict::NotRun,
    ] {
        assert_eq!(json!(verdict), verdict.name());
    }
}
