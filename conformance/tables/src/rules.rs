//! The rules, with their coverage in each capture.

use uavspec_report::Subject;

use super::column::{Column, Table};

pub(super) static TABLE: Table<RuleRow> = Table {
    name: "rules",
    description: "A rule that applies to the kind of a capture.",
    columns: &[
        Column::text("rule", "The id.", |row| Some(row.rule)),
        Column::text("capture", "The path or URL.", |row| Some(&row.capture)),
        Column::text("level", "The level: `MUST`, `SHOULD` or `INFO`.", |row| Some(row.level)),
        Column::text("verdict", "The verdict, such as `pass`, `fail` or `not covered`.", |row| {
            Some(row.verdict)
        }),
        Column::count("covered", "The number of times that the rule was checked.", |row| Some(row.covered)),
        Column::count("findings", "The number of findings.", |row| Some(row.findings)),
    ],
};

/// A rule in a capture.
#[derive(Debug)]
pub(super) struct RuleRow {
    rule: &'static str,
    capture: String,
    level: &'static str,
    verdict: &'static str,
    covered: u64,
    findings: u64,
}

impl RuleRow {
    pub(super) fn of(subject: &Subject) -> impl Iterator<Item = Self> {
        subject.rules.iter().map(|rule| Self {
            rule: rule.id,
            capture: subject.path.clone(),
            level: rule.level.name(),
            verdict: rule.verdict.name(),
            covered: rule.covered,
            findings: rule.findings,
        })
    }

    /// The sort key: queries select rules by id.
    pub(super) fn key(&self) -> (&str, &str) {
        (self.rule, &self.capture)
    }
}
