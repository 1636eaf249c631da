//! What came of a run, as lists see it, and the findings and cases that a list excuses.

use std::collections::BTreeMap;
use std::ptr;

use super::{Checked, Lists, Name, Outcome};
use crate::finding::Findings;
use crate::rule::{RULES, Rule};
use crate::testee::case::Case;
use crate::testee::outcome::{Outcome as Answers, Verdict};

/// What came of the rules in a file. Of equal findings, messages are looked at that stand for all.
pub fn of_findings<'r>(file: &'r str, findings: &'r Findings) -> impl Iterator<Item = Checked<'r>> {
    let rules = RULES.iter().map(move |rule| {
        let outcome = if findings.exercised(rule) > 0 { Outcome::Passed } else { Outcome::Idle };
        Checked { name: Name::Rule { rule, subject: "", file }, outcome }
    });
    let groups = findings.groups().map(move |group| {
        let name = Name::Rule { rule: group.rule, subject: &group.subject, file };
        Checked { name, outcome: Outcome::Failed(group.messages()) }
    });
    rules.chain(groups)
}

/// A file that couldn't be read: whatever an entry says of it may hold.
pub fn of_unread(file: &str) -> impl Iterator<Item = Checked<'_>> {
    let unread = move |rule: &&'static Rule| Checked {
        name: Name::Rule { rule, subject: "", file },
        outcome: Outcome::NotRun,
    };
    RULES.iter().map(unread)
}

/// Notes at each finding of a file the entry that excuses it.
pub fn excuse_findings(lists: &Lists, file: &str, findings: &mut Findings) {
    findings.excuse(|group| {
        let name = Name::Rule { rule: group.rule, subject: &group.subject, file };
        lists.excuse(name, &group.messages()).cloned()
    });
}

/// What came of cases: of those that were asked, as `answers` says, and of all others, which were not. `names` are
/// the names of all cases.
pub fn of_cases<'r>(names: &'r [(&'r Case, String)], answers: &Answers<'r>) -> Vec<Checked<'r>> {
    let asked: BTreeMap<*const Case, &Verdict> =
        answers.verdicts.iter().map(|(case, verdict)| (ptr::from_ref(*case), verdict)).collect();
    let checked = names.iter().map(|(case, name)| {
        let outcome = match asked.get(&ptr::from_ref(*case)) {
            Some(Verdict::Pass) => Outcome::Passed,
            Some(Verdict::Unsupported) => Outcome::Idle,
            None | Some(Verdict::NotRun) => Outcome::NotRun,
            Some(failure) => Outcome::Failed(vec![failure.to_string()]),
        };
        Checked { name: Name::Case(name), outcome }
    });
    checked.collect()
}

/// Makes each failure that an entry excuses a known one.
pub fn excuse_cases(lists: &Lists, answers: &mut Answers<'_>) {
    for (case, verdict) in answers.verdicts.iter_mut().filter(|(_, verdict)| verdict.is_failure()) {
        let messages = [verdict.to_string()];
        if let Some(excuse) = lists.excuse(Name::Case(&case.name()), &messages) {
            let failure = std::mem::replace(verdict, Verdict::NotRun);
            *verdict = Verdict::Known { failure: Box::new(failure), excuse: excuse.clone() };
        }
    }
}
