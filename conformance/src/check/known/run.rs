//! The results of a capture, as lists see them, and the findings that a list excuses.

use super::{Checked, Lists, Name, Outcome};

use crate::model::{Findings, Rule};
use crate::rules::RULES;

/// What came of the rules in a file. Of equal findings, messages are looked at that stand for all.
pub(crate) fn rule_outcomes<'r>(file: &'r str, findings: &'r Findings) -> impl Iterator<Item = Checked<'r>> {
    let rules = RULES.iter().map(move |rule| {
        let outcome = if findings.covered(rule) > 0 { Outcome::Passed } else { Outcome::Idle };
        Checked { name: Name::Rule { rule, subject: "", file }, outcome }
    });
    let groups = findings.groups().map(move |group| {
        let name = Name::Rule { rule: group.rule, subject: &group.subject, file };
        Checked { name, outcome: Outcome::Failed(group.messages()) }
    });
    rules.chain(groups)
}

/// A file that couldn't be read: whatever an entry says of it may hold.
pub(crate) fn unread_outcome(file: &str) -> impl Iterator<Item = Checked<'_>> {
    let unread = move |rule: &&'static Rule| Checked {
        name: Name::Rule { rule, subject: "", file },
        outcome: Outcome::NotRun,
    };
    RULES.iter().map(unread)
}

/// Notes at each finding of a file the entry that excuses it.
pub(crate) fn excuse_findings(lists: &Lists, file: &str, findings: &mut Findings) {
    findings.excuse(|group| {
        let name = Name::Rule { rule: group.rule, subject: &group.subject, file };
        lists.excuse(name, &group.messages()).cloned()
    });
}
