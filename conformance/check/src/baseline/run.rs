//! Converts a capture's findings to results that list entries can match, and marks excused findings.

use uavspec_model::{Findings, Rule};
use uavspec_rules::RULES;

use super::{Checked, Lists, Name, Outcome};

/// The results of the rules for a file. A few representative messages describe each group of findings.
pub fn rule_outcomes<'r>(file: &'r str, findings: &'r Findings) -> impl Iterator<Item = Checked<'r>> {
    let rules = RULES.iter().map(move |rule| {
        let outcome = if findings.covered(rule) > 0 { Outcome::Passed } else { Outcome::Idle };
        Checked { name: Name::Rule { rule, subject: "".into(), file }, outcome }
    });
    let groups = findings.groups().map(move |group| {
        let name = Name::Rule { rule: group.rule, subject: group.name(), file };
        Checked { name, outcome: Outcome::Failed(group.messages()) }
    });
    rules.chain(groups)
}

/// The results for a file that couldn't be read: no rule was run.
pub fn unread_outcome(file: &str) -> impl Iterator<Item = Checked<'_>> {
    let unread = move |rule: &&'static Rule| Checked {
        name: Name::Rule { rule, subject: "".into(), file },
        outcome: Outcome::NotRun,
    };
    RULES.iter().map(unread)
}

/// Marks the findings in a file as known if an entry excuses them.
pub fn excuse_findings(lists: &Lists, file: &str, findings: &mut Findings) {
    findings.excuse(|group| {
        let name = Name::Rule { rule: group.rule, subject: group.name(), file };
        lists.excuse(name, &group.messages()).cloned()
    });
}
