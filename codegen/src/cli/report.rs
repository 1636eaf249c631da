//! Output of findings, to the terminal or to another program.

use std::collections::BTreeSet;

use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};

use super::print::{print_report, print_results};
use crate::diagnostic::Level;
use crate::failure::Failure;
use crate::finding::Finding;
use crate::render;
use crate::report::{Entry, Format, Report, RuleInfo, Totals};
use crate::source::SourceMap;

/// The report format, and the lowest level of finding that makes a command fail.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct ReportArgs {
    /// Print only the totals for each rule; requires --format text, json or github
    #[arg(long)]
    summary: bool,
    /// Fail if a finding is at this level or above
    #[arg(long, value_name = "LEVEL", default_value = "error")]
    deny: LevelName,
    /// Report format
    #[arg(long, default_value = "text")]
    format: FormatName,
}

/// A level of findings.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub(super) enum LevelName {
    /// All findings
    Note,
    /// Warnings and errors
    Warning,
    /// Errors only
    Error,
}

impl LevelName {
    pub(super) fn level(self) -> Level {
        match self {
            Self::Note => Level::Note,
            Self::Warning => Level::Warning,
            Self::Error => Level::Error,
        }
    }
}

/// A format of reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum FormatName {
    /// Readable text that quotes the line of each finding
    Text,
    /// A JSON list; with --summary, a JSON object
    Json,
    /// GitHub workflow annotations
    Github,
    /// SARIF 2.1.0, for code scanning
    Sarif,
    /// Test results as XML, for CI systems
    Junit,
}

impl FormatName {
    /// The machine-readable format, or `None` for text.
    fn format(self) -> Option<Format> {
        match self {
            Self::Text => None,
            Self::Json => Some(Format::Json),
            Self::Github => Some(Format::Github),
            Self::Sarif => Some(Format::Sarif),
            Self::Junit => Some(Format::Junit),
        }
    }
}

/// Accepts the ids of rules. For other values, clap reports the known ids and a similar one.
pub(super) fn rule_ids(ids: impl IntoIterator<Item = &'static str>) -> PossibleValuesParser {
    PossibleValuesParser::new(ids)
}

/// The findings to report. Parser errors are always reported, because the other findings are incomplete then.
#[derive(Clone, Debug, Default)]
pub(super) struct Selection {
    /// The selected rules; empty for all rules.
    pub(super) rules: Vec<String>,
    /// The selected categories; empty for all categories.
    pub(super) categories: BTreeSet<&'static str>,
    /// The lowest level.
    pub(super) level: Option<Level>,
}

impl Selection {
    /// True if the findings of a rule are selected.
    pub(super) fn has_rule(&self, rule: &str) -> bool {
        self.rules.is_empty() || self.rules.iter().any(|selected| selected == rule)
    }

    /// Removes the findings that are not selected. Returns the number of removed findings.
    pub(super) fn apply(&self, is_rule: impl Fn(&str) -> bool, findings: &mut Vec<Finding>) -> usize {
        let count = |findings: &[Finding]| findings.chunk_by(Finding::is_same_change).count();
        let before = count(findings);
        findings.retain(|finding| {
            let has_category = finding.category.is_none_or(|category| self.categories.contains(category));
            !is_rule(finding.rule)
                || self.has_rule(finding.rule)
                    && (self.categories.is_empty() || has_category)
                    && self.level.is_none_or(|level| finding.level >= level)
        });
        before - count(findings)
    }
}

/// The results of a command.
pub(super) struct Results<'r> {
    /// The applied rules.
    pub(super) rules: Vec<RuleInfo>,
    pub(super) findings: &'r [Finding],
    pub(super) totals: &'r Totals,
}

impl ReportArgs {
    /// Checks that the options can be combined.
    pub(super) fn check(self) -> Result<(), Failure> {
        let has_totals = matches!(self.format, FormatName::Text | FormatName::Json | FormatName::Github);
        if self.summary && !has_totals {
            // Code scanning would close the alert of each finding that is not in the report.
            let message = "a SARIF or JUnit report without findings would look like a successful run";
            return Err(Failure::new(message)
                .with_hint("use --summary with --format text, json or github, or remove --summary"));
        }
        Ok(())
    }

    /// Prints the results to standard output.
    pub(super) fn show(self, results: Results<'_>, sources: &SourceMap) {
        let Results { rules, findings, totals } = results;
        let Some(format) = self.format.format() else {
            return print_results(|styled| {
                if self.summary {
                    return totals.to_text();
                }
                let text = render::findings(findings, sources, styled);
                let gap = if text.is_empty() { "" } else { "\n" };
                match totals.rules.len() {
                    // The table would repeat the last line.
                    0 | 1 => format!("{text}{gap}{}\n", totals.headline()),
                    _ => format!("{text}{gap}{}", totals.to_text()),
                }
            });
        };
        let text = if self.summary {
            totals.to_summary(format).unwrap_or_default()
        } else {
            let entries = findings.iter().map(|finding| Entry::of(finding, sources)).collect();
            Report { command: totals.command, rules, entries }.to_text_with_totals(format, totals)
        };
        print_report(&text);
    }

    /// True if no finding is at the denied level or above.
    pub(super) fn is_success(self, findings: &[Finding]) -> bool {
        findings.iter().all(|finding| finding.level < self.deny.level())
    }
}
