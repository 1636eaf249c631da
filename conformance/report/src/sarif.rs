//! Renders reports as SARIF.

use std::collections::BTreeSet;
use std::io::{self, Read as _, Write};

use uavspec_lint::report::sarif::{Results, write_log};
use uavspec_lint::report::{Entry, RuleInfo};
use uavspec_schema::diagnostic::Level;

use super::entries::{OTHERS, failed_cases, of_run, of_subject};
use super::kind::{Format, Parts};
use super::{About, Action, Report, RuleReport, Subject};

/// A report under construction.
#[derive(Debug, Default)]
pub(super) struct Sarif {
    results: Results,
    /// The ids with results that aren't rules.
    others: BTreeSet<&'static str>,
    /// The operations of failed cases, in the order of appearance.
    operations: Vec<String>,
}

impl Sarif {
    /// The results as lines of JSON.
    fn lines(&mut self, entries: &[Entry]) -> String {
        let others = OTHERS.iter().map(|(id, ..)| *id);
        self.others.extend(others.filter(|id| entries.iter().any(|entry| entry.rule == *id)));
        entries.iter().map(|entry| self.results.line(entry)).collect()
    }

    /// The rules, and the other ids that have results.
    fn rules(&self, report: &Report) -> Vec<RuleInfo> {
        let mut rules: Vec<RuleInfo> = report.rules.iter().map(rule).collect();
        for (id, purpose, level) in OTHERS.iter().filter(|(id, ..)| self.others.contains(id)) {
            let (id, purpose) = ((*id).into(), (*purpose).into());
            rules.push(RuleInfo { id, purpose, level: *level, url: String::new() });
        }
        rules.extend(self.operations.iter().map(|operation| RuleInfo {
            id: operation.clone().into(),
            purpose: format!("Responses to `{operation}` are correct.").into(),
            level: Level::Error,
            url: String::new(),
        }));
        rules
    }
}

impl Format for Sarif {
    fn add(&mut self, subject: &Subject) -> String {
        if let About::Testee(testee) = &subject.about {
            for case in failed_cases(testee) {
                if !self.operations.contains(&case.op) {
                    self.operations.push(case.op.clone());
                }
            }
        }
        self.lines(&of_subject(subject))
    }

    fn finish(mut self: Box<Self>, report: &Report, parts: Parts<'_>, to: &mut dyn Write) -> io::Result<()> {
        let rest = self.lines(&of_run(report));
        let command = match report.action {
            Action::Check => "check",
            Action::Test => "test",
            Action::Probe => "probe",
        };
        write_log(command, &self.rules(report), None, parts.chain(rest.as_bytes()), to)
    }
}

pub(crate) fn rule(rule: &RuleReport) -> RuleInfo {
    let level = match rule.level {
        uavspec_model::Level::Must => Level::Error,
        uavspec_model::Level::Should => Level::Warning,
        uavspec_model::Level::Info => Level::Note,
    };
    RuleInfo { id: rule.id.into(), purpose: rule.statement.into(), level, url: rule.url.clone() }
}
