//! Renders reports as SARIF.

use std::collections::BTreeSet;
use std::io::{self, Write};

use uavspec_lint::report::sarif::{Results, write_log};
use uavspec_lint::report::{Entry, RuleInfo};
use uavspec_schema::diagnostic::Level;

use super::entries::{OTHERS, failed_cases, of_run, of_subject};
use super::format::{Format, Run};
use super::spool::Spool;
use super::{About, Action, Report, RuleReport, Subject};

/// A report under construction.
#[derive(Debug)]
pub(super) struct Sarif {
    results: Results,
    /// The results as lines of JSON.
    lines: Spool,
    /// The ids other than rules that have results.
    others: BTreeSet<&'static str>,
    /// The operations of the failed cases, in the order of appearance.
    operations: Vec<String>,
}

impl Sarif {
    pub(super) fn new(lines: Spool) -> Self {
        Self { results: Results::default(), lines, others: BTreeSet::new(), operations: Vec::new() }
    }

    fn push(&mut self, entry: &Entry) -> io::Result<()> {
        self.others.extend(OTHERS.iter().map(|(id, ..)| *id).filter(|id| entry.rule == *id));
        self.lines.write_all(self.results.line(entry).as_bytes())
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
    fn add(&mut self, subject: &Subject, _: Run<'_>) -> io::Result<()> {
        if let About::Testee(testee) = &subject.about {
            for case in failed_cases(testee) {
                if !self.operations.contains(&case.op) {
                    self.operations.push(case.op.clone());
                }
            }
        }
        of_subject(subject).iter().try_for_each(|entry| self.push(entry))
    }

    fn finish(mut self: Box<Self>, report: &Report, to: &mut dyn Write) -> io::Result<()> {
        of_run(report).iter().try_for_each(|entry| self.push(entry))?;
        let command = match report.action {
            Action::Check => "check",
            Action::Test => "test",
            Action::Probe => "probe",
        };
        let rules = self.rules(report);
        write_log(command, &rules, None, self.lines.into_reader()?, to)
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
