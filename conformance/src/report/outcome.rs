//! What a run comes to, in a word, a sentence and an exit status.

use serde::Serialize;

use super::{Action, Subject, Unreadable, Verdict};
use crate::model::Extent;

/// What something comes to.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub struct Outcome {
    /// In a word.
    #[serde(rename = "outcome")]
    pub kind: OutcomeKind,
    /// The exit status that says so.
    pub status: u8,
    /// In a sentence.
    pub text: String,
    /// What else has to do with it.
    pub remarks: Vec<String>,
}

/// What something comes to; in the order of how much each weighs where there are several.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum OutcomeKind {
    /// Nothing breaks a rule that binds.
    Conforms,
    /// Nothing was there to judge.
    #[serde(rename = "nothing was checked")]
    Nothing,
    /// The list of known failures isn't true any more.
    #[serde(rename = "stale list")]
    Stale,
    /// Something breaks a rule that binds.
    #[serde(rename = "does not conform")]
    DoesNotConform,
    /// A file can't be read, or the testee broke.
    #[serde(rename = "broken")]
    Incomplete,
}

impl OutcomeKind {
    /// The exit status that says so.
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
    /// One without remarks.
    pub(crate) fn new(kind: OutcomeKind, text: impl Into<String>) -> Self {
        Self { kind, status: kind.status(), text: text.into(), remarks: Vec::new() }
    }

    /// Of a source, by how many of its rules are broken and warned of.
    pub(super) fn for_capture(checked: u64, failed: usize, warned: usize, remarks: Vec<String>) -> Self {
        let outcome = match (failed, warned) {
            (0, _) if checked == 0 => Self::new(OutcomeKind::Nothing, "Nothing was judged"),
            (0, 0) => Self::new(OutcomeKind::Conforms, "Conforms"),
            (0, _) => Self::new(OutcomeKind::Conforms, format!("Conforms, with {}", to_look_at(warned))),
            _ => Self::new(OutcomeKind::DoesNotConform, format!("Does not conform: {}", violated(failed))),
        };
        Self { remarks, ..outcome }
    }

    /// The same of a source of which only so much could be read.
    #[must_use]
    pub(super) fn with_extent(self, extent: Extent) -> Self {
        match extent {
            Extent::Whole => self,
            Extent::EndsEarly | Extent::WithGaps => {
                Self { text: format!("{}, as far as it can be read", self.text), ..self }
            }
            Extent::Unreadable => {
                let mut remarks = self.remarks;
                remarks.insert(0, format!("{}, as far as it can be read", self.text));
                Self { remarks, ..Self::new(OutcomeKind::Incomplete, "Could not be read to its end") }
            }
        }
    }

    /// Of a testee, by how many of its cases failed and passed.
    pub(super) fn for_testee(passed: u64, failed: u64, remarks: usize, gave_up: Option<&str>) -> Self {
        let requested = passed + failed;
        match gave_up {
            Some(why) => Self::new(OutcomeKind::Incomplete, format!("The testee broke: {why}")),
            None if failed > 0 => Self::new(
                OutcomeKind::DoesNotConform,
                format!("Does not conform: {failed} of {requested} cases failed"),
            ),
            None if remarks > 0 => Self::new(OutcomeKind::DoesNotConform, "Does not keep to the protocol"),
            None if passed == 0 => Self::new(OutcomeKind::Nothing, "Nothing was checked"),
            None => Self::new(OutcomeKind::Conforms, "Conforms"),
        }
    }

    /// Of a whole run.
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
                (Action::Probe, _) => "The server could not be asked everything".to_owned(),
                (_, 1) => "One file could not be read".to_owned(),
                (_, count) => format!("{count} files could not be read"),
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
        let mut expected = Vec::new();
        for subject in subjects {
            expected
                .extend(subject.outcome.remarks.iter().map(|remark| format!("{}: {remark}", subject.path)));
        }
        let outcomes = subjects.iter().map(|subject| subject.outcome.kind);
        // That one of several has nothing to judge says nothing of the others.
        let worst = outcomes.clone().filter(|outcome| *outcome != OutcomeKind::Nothing).max();
        let Some(worst) = worst else { return Self::new(OutcomeKind::Nothing, "Nothing was judged") };
        let of = |verdict: Verdict| {
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
        let text = match (worst, of(Verdict::Warn)) {
            (OutcomeKind::Conforms | OutcomeKind::Nothing, 0) => "Conforms".to_owned(),
            (OutcomeKind::Conforms | OutcomeKind::Nothing, warned) => {
                format!("Conforms, with {}", to_look_at(warned))
            }
            (OutcomeKind::Stale, _) => "The list of known failures is stale".to_owned(),
            (OutcomeKind::DoesNotConform, _) if is_testee => "Does not conform".to_owned(),
            (OutcomeKind::DoesNotConform, _) => {
                let count = outcomes.filter(|outcome| *outcome == OutcomeKind::DoesNotConform).count();
                let (violated, all) = (violated(of(Verdict::Fail)), subjects.len());
                format!("Does not conform: {violated}, in {count} of {all} files")
            }
            (OutcomeKind::Incomplete, _) if is_testee => "A testee broke".to_owned(),
            (OutcomeKind::Incomplete, _) => {
                let count = outcomes.filter(|outcome| *outcome == OutcomeKind::Incomplete).count();
                format!("{count} of {} files could not be read to their ends", subjects.len())
            }
        };
        Self { remarks: expected, ..Self::new(worst, text) }
    }
}

fn violated(rules: usize) -> String {
    format!("{rules} MUST {} broken", if rules == 1 { "rule" } else { "rules" })
}

fn to_look_at(rules: usize) -> String {
    format!("{rules} SHOULD {} to look at", if rules == 1 { "rule" } else { "rules" })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check::{JsonSummary, Summary};
    use crate::px4::json::Dialects;
    use crate::report::{About, RuleVerdict};
    use crate::rules::RULES;

    /// A source of which rules came to these verdicts, and how much of it was judged.
    fn source(checked: u64, verdicts: &[Verdict]) -> Subject {
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
    fn a_source_is_as_good_as_its_worst_rule() {
        let expected = |checked, verdicts: &[Verdict]| outcome_of(&[source(checked, verdicts)]);
        assert_eq!(expected(1, &[Verdict::Pass, Verdict::Shown]), (0, "Conforms".to_owned()));
        assert_eq!(expected(1, &[Verdict::Warn]), (0, "Conforms, with 1 SHOULD rule to look at".to_owned()));
        let violated = [Verdict::Fail, Verdict::Fail, Verdict::Warn];
        assert_eq!(expected(1, &violated), (1, "Does not conform: 2 MUST rules broken".to_owned()));
        assert_eq!(expected(0, &[Verdict::NotCovered]), (5, "Nothing was judged".to_owned()));
    }

    #[test]
    fn several_sources_count_each_rule_once() {
        let (good, bad, empty) = (source(1, &[Verdict::Pass]), source(1, &[Verdict::Fail]), source(0, &[]));
        let all = [good.clone(), bad.clone(), bad.clone(), empty.clone()];
        assert_eq!(outcome_of(&all), (1, "Does not conform: 1 MUST rule broken, in 2 of 4 files".to_owned()));
        assert_eq!(outcome_of(&[good.clone(), empty.clone()]), (0, "Conforms".to_owned()));
        assert_eq!(outcome_of(&[empty.clone(), empty]), (5, "Nothing was judged".to_owned()));
        assert_eq!(outcome_of(&[]), (5, "Nothing was judged".to_owned()));
        assert_eq!(outcome_of(&[good, bad]).0, 1);
    }

    #[test]
    fn unread_data_is_reported_and_may_change_the_outcome() {
        let read = |extent, verdict| {
            let mut source = source(1, &[verdict]);
            source.extent = extent;
            source.set_outcome();
            source
        };
        let expected = |extent, verdict| outcome_of(&[read(extent, verdict)]);
        for extent in [Extent::EndsEarly, Extent::WithGaps] {
            let text = "Conforms, as far as it can be read";
            assert_eq!(expected(extent, Verdict::Pass), (0, text.to_owned()));
            assert_eq!(expected(extent, Verdict::Fail).0, 1);
        }
        for verdict in [Verdict::Pass, Verdict::Fail] {
            let text = "Could not be read to its end";
            assert_eq!(expected(Extent::Unreadable, verdict), (3, text.to_owned()));
        }
        let violated = read(Extent::Unreadable, Verdict::Pass);
        assert_eq!(violated.outcome.remarks, ["Conforms, as far as it can be read"]);
        let all = [violated, source(1, &[Verdict::Fail])];
        assert_eq!(outcome_of(&all), (3, "1 of 2 files could not be read to their ends".to_owned()));
    }

    #[test]
    fn what_is_no_finding_counts_too() {
        let good = [source(1, &[Verdict::Pass])];
        let required = Outcome::for_run(Action::Check, &good, &[], vec!["a rule was required".to_owned()]);
        assert_eq!((required.status, required.text.as_str()), (1, "Does not conform"));
        assert_eq!(required.remarks, ["a rule was required"]);
        let gone = Unreadable { path: "gone".to_owned(), message: "absent".to_owned() };
        let unreadable = Outcome::for_run(Action::Check, &good, &[gone.clone(), gone], Vec::new());
        assert_eq!((unreadable.status, unreadable.text.as_str()), (3, "2 files could not be read"));
        assert_eq!(unreadable.remarks, ["Conforms"], "what could be read is told, too");
    }

    #[test]
    fn a_testee_fails_by_its_answers_its_manners_or_its_end() {
        let expected = |passed, failed, remarks, gave_up| {
            let outcome = Outcome::for_testee(passed, failed, remarks, gave_up);
            (outcome.status, outcome.text)
        };
        assert_eq!(expected(9, 0, 0, None), (0, "Conforms".to_owned()));
        assert_eq!(expected(9, 1, 2, None), (1, "Does not conform: 1 of 10 cases failed".to_owned()));
        assert_eq!(expected(9, 0, 2, None), (1, "Does not keep to the protocol".to_owned()));
        assert_eq!(expected(0, 0, 0, None), (5, "Nothing was checked".to_owned()));
        assert_eq!(expected(9, 1, 0, Some("it ended")), (3, "The testee broke: it ended".to_owned()));
    }
}
