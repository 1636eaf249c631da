//! Compares the findings in captures with baselines. See [`uavspec_lint::baseline`].
//!
//! In entries, `file` is compared with the path that was passed to the run. `subject` is compared with the name in
//! reports, and also with the name without the instance and the namespace of the topic.

use uavspec_lint::baseline::{Entry, Lists, Name, Outcome};
use uavspec_model::{Excuse, ExcuseKind, Findings, Level, Rule, SubjectName};
use uavspec_rules::RULES;

use crate::topic::topic_of;

/// The ids of all rules.
pub fn rule_ids() -> Vec<&'static str> {
    RULES.iter().map(|rule| rule.id).collect()
}

/// True if the id is the id of a rule that applies to captures.
pub fn is_rule(id: Option<&str>) -> bool {
    id.is_some_and(|id| uavspec_rules::rule(id).is_some())
}

/// The name of a finding.
pub fn finding_name<'r>(rule: &'static Rule, subject: SubjectName<'r>, file: &'r str) -> Name<'r> {
    let topic = (!rule.is_on_flockwave()).then(|| without_namespace(subject.name).into());
    let forms = [subject.to_string().into(), subject.name.into()].into_iter().chain(topic);
    Name { forms: forms.collect(), ..Name::rule(rule.id, file) }
}

/// The name of a topic or field without the namespace of the topic, such as `locked.data` for
/// `/kite/winch/locked.data`.
fn without_namespace(name: &str) -> String {
    let last = name.rfind('/').map_or(0, |at| at + 1);
    let end = name[last..].find('.').map_or(name.len(), |at| last + at);
    let (topic, field) = name.split_at(end);
    format!("{}{field}", topic_of(topic))
}

/// The results of the rules for a file, for comparison with baselines. Each group of findings is represented by a few
/// messages.
pub fn rule_outcomes<'r>(file: &'r str, findings: &'r Findings) -> impl Iterator<Item = (Name<'r>, Outcome)> {
    let rules = RULES.iter().map(move |rule| {
        let outcome = if findings.covered(rule) > 0 { Outcome::Passed } else { Outcome::Idle };
        (Name::rule(rule.id, file), outcome)
    });
    let groups = findings
        .groups()
        .map(move |group| (finding_name(group.rule, group.name(), file), Outcome::Failed(group.messages())));
    rules.chain(groups)
}

/// The results for a file that couldn't be read: no rule was run.
pub fn unread_outcome(file: &str) -> impl Iterator<Item = (Name<'_>, Outcome)> {
    RULES.iter().map(move |rule| (Name::rule(rule.id, file), Outcome::NotRun))
}

/// Marks the findings in a file as known if a baseline entry covers them. New entries are added for violations and
/// warnings only.
pub fn excuse_findings(lists: &mut Lists, file: &str, findings: &mut Findings) {
    findings.excuse(|group| {
        let (name, messages) = (finding_name(group.rule, group.name(), file), group.messages());
        let entry = match group.rule.level {
            Level::Info => lists.find(&name, &messages),
            Level::Must | Level::Should => lists.find_or_add(&name, &messages, None),
        };
        entry.map(excuse)
    });
}

/// The excuse of an entry.
pub fn excuse(entry: &Entry) -> Excuse {
    Excuse {
        kind: if entry.is_flaky { ExcuseKind::Flaky } else { ExcuseKind::Known },
        reason: entry.reason.clone(),
        link: entry.link.clone(),
        expires: entry.expires,
    }
}
