//! The outcome of a run: a kind, a sentence and an exit status.

use serde::Serialize;

use super::{Action, Subject, Unreadable, Verdict};
use crate::model::Extent;

/// The outcome of a run or a subject.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Outcome {
    /// The kind.
    #[serde(rename = "outcome")]
    pub kind: OutcomeKind,
    /// The exit status.
    pub status: u8,
    /// The outcome as a sentence.
    pub text: String,
    /// Further remarks.
    pub remarks: Vec<String>,
}

/// A kind of outcome. The values are in ascending precedence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum OutcomeKind {
    /// No rule of level MUST is violated.
    Conforms,
    /// Nothing was checked.
    #[serde(rename = "nothing was checked")]
    Nothing,
    /// An entry in a list of known failures no longer applies.
    #[serde(rename = "stale list")]
    Stale,
    /// A rule of level MUST is violated.
    #[serde(rename = "does not conform")]
    DoesNotConform,
    /// A file can't be read, or a testee or server failed.
    #[serde(rename = "broken")]
    Incomplete,
}

impl OutcomeKind {
    /// The exit status.
    pub const fn status(self) -> u8 {
        match self {
            Self::Conforms => 0,
            Self::DoesNotConform => 1,
            Self::Incomplete => 3,
            Self::Stale => 4,
            Self::Nothing => 5,
        }
    }
}

impl Outcome {
    /// Creates an outcome without remarks.
    pub(crate) fn new(kind: OutcomeKind, text: impl Into<String>) -> Self {
        Self { kind, status: kind.status(), text: text.into(), remarks: Vec::new() }
    }

    /// The outcome for a capture. `noun` is the word for this kind of capture, such as `log`.
    pub(super) fn for_capture(counts: CaptureCounts, extent: Extent, noun: &str) -> Self {
        let (kind, text) = (counts.kind(), counts.text());
        let (kind, text) = match extent {
            Extent::Whole if counts.corrupt == 0 => (kind, text),
            Extent::Whole => (kind, format!("{text}; the {noun} has errors")),
            Extent::EndsEarly => (kind, format!("{text}; the {noun} is truncated")),
            Extent::WithGaps => (kind, format!("{text}; parts of the {noun} are unreadable")),
            Extent::Unreadable => {
                let subject = if kind == OutcomeKind::Nothing { "" } else { "its readable part " };
                let text = format!("incomplete: the {noun} can't be read completely; {subject}{text}");
                (OutcomeKind::Incomplete, text)
            }
        };
        let remarks = match counts.corrupt {
            0 => Vec::new(),
            1 => vec![format!("1 part of the {noun} is corrupt or unreadable")],
            count => vec![format!("{count} parts of the {noun} are corrupt or unreadable")],
        };
        Self { remarks, ..Self::new(kind, capitalized(&text)) }
    }

    /// The outcome for a testee, based on its passed cases, failed cases and protocol violations.
    pub(super) fn for_testee(passed: u64, failed: u64, violations: usize, gave_up: Option<&str>) -> Self {
        let requested = passed + failed;
        match gave_up {
            Some(reason) => Self::new(OutcomeKind::Incomplete, format!("Incomplete: {reason}")),
            None if failed > 0 => Self::new(
                OutcomeKind::DoesNotConform,
                format!("Does not conform: {failed} of {requested} cases failed"),
            ),
            None if violations > 0 => {
                Self::new(OutcomeKind::DoesNotConform, "Does not conform: violates the test protocol")
            }
            None if passed == 0 => Self::new(OutcomeKind::Nothing, "Nothing was checked"),
            None => Self::new(OutcomeKind::Conforms, "Conforms"),
        }
    }

    /// The last line of a terminal report: the outcome's text, starting with a lower-case letter.
    pub(super) fn last_line(&self) -> String {
        let mut characters = self.text.chars();
        let first = characters.next().map(|first| first.to_ascii_lowercase());
        first.into_iter().chain(characters).collect()
    }

    /// The outcome for a whole run.
    pub(super) fn for_run(
        action: Action,
        subjects: &[Subject],
        unreadable: &[Unreadable],
        remarks: Vec<String>,
    ) -> Self {
        let mut outcome = Self::for_subjects(subjects);
        if !remarks.is_empty() && outcome.kind < OutcomeKind::DoesNotConform {
            outcome = Self::new(OutcomeKind::DoesNotConform, "Does not conform");
        }
        if !unreadable.is_empty() {
            let text = match (action, unreadable.len()) {
                (Action::Probe, _) => "Incomplete: the server did not complete the probe".to_owned(),
                (_, 1) => "Incomplete: 1 file can't be read".to_owned(),
                (_, count) => format!("Incomplete: {count} files can't be read"),
            };
            let rest = if subjects.is_empty() { Vec::new() } else { vec![outcome.text] };
            outcome = Self { remarks: rest, ..Self::new(OutcomeKind::Incomplete, text) };
        }
        outcome.remarks.extend(remarks);
        outcome
    }

    fn for_subjects(subjects: &[Subject]) -> Self {
        if let [only] = subjects {
            return only.outcome.clone();
        }
        let mut remarks = Vec::new();
        for subject in subjects {
            remarks
                .extend(subject.outcome.remarks.iter().map(|remark| format!("{}: {remark}", subject.path)));
        }
        let outcomes = subjects.iter().map(|subject| subject.outcome.kind);
        // A subject with nothing to check doesn't affect the others.
        let worst = outcomes.clone().filter(|outcome| *outcome != OutcomeKind::Nothing).max();
        let Some(worst) = worst else { return Self::new(OutcomeKind::Nothing, "Nothing was checked") };
        let count = |verdict: Verdict| {
            let mut ids: Vec<&str> = subjects
                .iter()
                .flat_map(|subject| &subject.rules)
                .filter(|rule| rule.verdict == verdict)
                .map(|rule| rule.id)
                .collect();
            ids.sort_unstable();
            ids.dedup();
            ids.len()
        };
        let is_testee = subjects.iter().any(Subject::is_testee);
        let (warned, all) = (count(Verdict::Warn), subjects.len());
        let with_worst = outcomes.filter(|outcome| *outcome == worst).count();
        let text = match worst {
            OutcomeKind::Conforms | OutcomeKind::Nothing if warned == 0 => "Conforms".to_owned(),
            OutcomeKind::Conforms | OutcomeKind::Nothing => {
                format!("Conforms, with {}", plural(warned, "warning"))
            }
            OutcomeKind::Stale => "A list of known failures is out of date".to_owned(),
            OutcomeKind::DoesNotConform if is_testee => "Does not conform".to_owned(),
            OutcomeKind::DoesNotConform => {
                let failed = count(Verdict::Fail);
                format!("Does not conform: {failed} MUST, {warned} SHOULD ({with_worst} of {all} files)")
            }
            OutcomeKind::Incomplete if is_testee => "Incomplete: a testee failed".to_owned(),
            OutcomeKind::Incomplete => {
                format!("Incomplete: {with_worst} of {all} files can't be read completely")
            }
        };
        Self { remarks, ..Self::new(worst, text) }
    }
}

/// The counts that determine the outcome for a capture.
#[derive(Clone, Copy, Debug)]
pub(super) struct CaptureCounts {
    /// Messages that were checked.
    pub(super) checked: u64,
    /// Rules that fail.
    pub(super) failed: usize,
    /// Rules that warn.
    pub(super) warned: usize,
    /// Findings in a list of known failures.
    pub(super) known: usize,
    /// Corrupt or unreadable parts.
    pub(super) corrupt: u64,
}

impl CaptureCounts {
    fn kind(self) -> OutcomeKind {
        match self.failed {
            0 if self.checked == 0 => OutcomeKind::Nothing,
            0 => OutcomeKind::Conforms,
            _ => OutcomeKind::DoesNotConform,
        }
    }

    /// The outcome as a predicate, such as `conforms, with 1 warning`.
    fn text(self) -> String {
        let Self { failed, warned, known, .. } = self;
        let plurals = [(warned, "warning"), (known, "known failure")];
        let listed: Vec<String> = plurals
            .iter()
            .filter(|(count, _)| *count > 0)
            .map(|(count, noun)| plural(*count, noun))
            .collect();
        match self.kind() {
            OutcomeKind::Nothing => "nothing was checked".to_owned(),
            OutcomeKind::DoesNotConform if known > 0 => {
                format!("does not conform: {failed} MUST, {warned} SHOULD, {known} known")
            }
            OutcomeKind::DoesNotConform => format!("does not conform: {failed} MUST, {warned} SHOULD"),
            _ if listed.is_empty() => "conforms".to_owned(),
            _ => format!("conforms, with {}", listed.join(" and ")),
        }
    }
}

fn plural(count: usize, noun: &str) -> String {
    uavspec_codegen::emit::docs::markdown::plural(count as u64, noun)
}

/// A text with a capital first letter.
fn capitalized(text: &str) -> String {
    let mut characters = text.chars();
    let first = characters.next().map(|first| first.to_ascii_uppercase());
    first.into_iter().chain(characters).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{JsonSummary, Summary};
    use crate::px4::json::Dialects;
    use crate::report::{About, RuleVerdict};
    use crate::rules::RULES;

    /// A capture of which this number of messages was checked, with these verdicts.
    fn capture(checked: u64, verdicts: &[Verdict]) -> Subject {
        let rule = |(verdict, rule): (&Verdict, &&'static crate::model::Rule)| RuleVerdict {
            id: rule.id,
            level: rule.level,
            verdict: *verdict,
            covered: 1,
            findings: 1,
        };
        let json = JsonSummary {
            lines: 1,
            types: 1,
            skipped: 0,
            undefined: std::collections::BTreeSet::new(),
            dialects: Dialects::default(),
        };
        let mut subject = Subject {
            path: "a.jsonl".to_owned(),
            about: About::Capture(Summary::Json(json)),
            records: checked,
            checked,
            duration_us: 0,
            outcome: Outcome::new(OutcomeKind::Nothing, ""),
            rules: verdicts.iter().zip(&RULES).map(rule).collect(),
            findings: Vec::new(),
            more_findings: 0,
            corruption: Vec::new(),
            more_corruption: 0,
            extent: Extent::Whole,
            notes: Vec::new(),
            elapsed: 0,
        };
        subject.set_outcome();
        subject
    }

    fn outcome_of(subjects: &[Subject]) -> (u8, String) {
        let outcome = Outcome::for_run(Action::Check, subjects, &[], Vec::new());
        assert_eq!(outcome.status, outcome.kind.status());
        (outcome.status, outcome.text)
    }

    #[test]
    fn the_worst_rule_decides_the_outcome() {
        let outcome = |checked, verdicts: &[Verdict]| outcome_of(&[capture(checked, verdicts)]);
        assert_eq!(outcome(1, &[Verdict::Pass, Verdict::Shown]), (0, "Conforms".to_owned()));
        assert_eq!(outcome(1, &[Verdict::Warn]), (0, "Conforms, with 1 warning".to_owned()));
        assert_eq!(outcome(1, &[Verdict::Warn, Verdict::Warn]), (0, "Conforms, with 2 warnings".to_owned()));
        let violated = [Verdict::Fail, Verdict::Fail, Verdict::Warn];
        assert_eq!(outcome(1, &violated), (1, "Does not conform: 2 MUST, 1 SHOULD".to_owned()));
        assert_eq!(outcome(0, &[Verdict::NotCovered]), (5, "Nothing was checked".to_owned()));
    }

    #[test]
    fn several_captures_count_each_rule_once() {
        let (good, bad, empty) =
            (capture(1, &[Verdict::Pass]), capture(1, &[Verdict::Fail]), capture(0, &[]));
        let all = [good.clone(), bad.clone(), bad.clone(), empty.clone()];
        assert_eq!(outcome_of(&all), (1, "Does not conform: 1 MUST, 0 SHOULD (2 of 4 files)".to_owned()));
        assert_eq!(outcome_of(&[good.clone(), empty.clone()]), (0, "Conforms".to_owned()));
        assert_eq!(outcome_of(&[empty.clone(), empty]), (5, "Nothing was checked".to_owned()));
        assert_eq!(outcome_of(&[]), (5, "Nothing was checked".to_owned()));
        assert_eq!(outcome_of(&[good, bad]).0, 1);
    }

    #[test]
    fn unread_data_is_reported_and_may_change_the_outcome() {
        let read = |extent, verdict| {
            let mut capture = capture(1, &[verdict]);
            capture.extent = extent;
            capture.set_outcome();
            capture
        };
        let outcome = |extent, verdict| outcome_of(&[read(extent, verdict)]);
        for (extent, text) in [
            (Extent::EndsEarly, "Conforms; the file is truncated"),
            (Extent::WithGaps, "Conforms; parts of the file are unreadable"),
        ] {
            assert_eq!(outcome(extent, Verdict::Pass), (0, text.to_owned()));
            assert_eq!(outcome(extent, Verdict::Fail).0, 1);
        }
        for (verdict, readable) in [
            (Verdict::Pass, "its readable part conforms"),
            (Verdict::Fail, "its readable part does not conform: 1 MUST, 0 SHOULD"),
        ] {
            let text = format!("Incomplete: the file can't be read completely; {readable}");
            assert_eq!(outcome(Extent::Unreadable, verdict), (3, text));
        }
        let all = [read(Extent::Unreadable, Verdict::Pass), capture(1, &[Verdict::Fail])];
        assert_eq!(outcome_of(&all), (3, "Incomplete: 1 of 2 files can't be read completely".to_owned()));
    }

    #[test]
    fn required_rules_and_unreadable_files_change_the_outcome() {
        let good = [capture(1, &[Verdict::Pass])];
        let required = Outcome::for_run(Action::Check, &good, &[], vec!["a rule was required".to_owned()]);
        assert_eq!((required.status, required.text.as_str()), (1, "Does not conform"));
        assert_eq!(required.remarks, ["a rule was required"]);
        let gone = Unreadable { path: "gone".to_owned(), message: "absent".to_owned() };
        let unreadable = Outcome::for_run(Action::Check, &good, &[gone.clone(), gone], Vec::new());
        assert_eq!((unreadable.status, unreadable.text.as_str()), (3, "Incomplete: 2 files can't be read"));
        assert_eq!(unreadable.remarks, ["Conforms"], "the outcome of the other files is a remark");
    }

    #[test]
    fn a_testee_fails_if_a_case_fails_or_it_violates_the_protocol_or_stops() {
        let outcome = |passed, failed, violations, gave_up| {
            let outcome = Outcome::for_testee(passed, failed, violations, gave_up);
            (outcome.status, outcome.text)
        };
        assert_eq!(outcome(9, 0, 0, None), (0, "Conforms".to_owned()));
        assert_eq!(outcome(9, 1, 2, None), (1, "Does not conform: 1 of 10 cases failed".to_owned()));
        assert_eq!(outcome(9, 0, 2, None), (1, "Does not conform: violates the test protocol".to_owned()));
        assert_eq!(outcome(0, 0, 0, None), (5, "Nothing was checked".to_owned()));
        assert_eq!(outcome(9, 1, 0, Some("it ended")), (3, "Incomplete: it ended".to_owned()));
    }
}
