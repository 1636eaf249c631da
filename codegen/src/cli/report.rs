//! Output of findings, to the terminal, to files or to another program.

mod target;

use std::collections::BTreeSet;
use std::path::Path;

use clap::Args;
use clap::builder::PossibleValuesParser;
use uavspec_lint::report::{Entry, Report, RuleInfo, Totals};
use uavspec_schema::diagnostic::Level;
use uavspec_schema::failure::Failure;
use uavspec_schema::finding::Finding;
use uavspec_schema::render;
use uavspec_schema::source::{SourceId, SourceMap};
use uavspec_schema::terminal::{self, guarded};

use self::target::{FormatName, Target};
use super::print::{print_report, print_results, protect_inputs};

/// The reports, and the lowest level of finding that makes a command fail.
#[derive(Args, Clone, Debug)]
pub(super) struct ReportArgs {
    /// Print only the totals for each rule; requires --format text, json or github
    #[arg(long)]
    summary: bool,
    /// Exit with status 1 if there is a finding of this level or a more severe one
    #[arg(long, value_name = "LEVEL", default_value = "error")]
    deny: Level,
    /// Report format
    #[arg(long, default_value = "text")]
    format: FormatName,
    /// Also write a report to a file, such as sarif=lint.sarif (repeatable)
    #[arg(long, value_name = "FORMAT=PATH", value_delimiter = ',')]
    report: Vec<Target>,
}

/// Accepts the ids of rules. For other values, clap reports the known ids and a similar id.
pub(super) fn rule_ids(ids: impl IntoIterator<Item = &'static str>) -> PossibleValuesParser {
    PossibleValuesParser::new(ids)
}

/// The findings to report. Parser errors are always reported, because they make the other findings incomplete.
#[derive(Clone, Debug, Default)]
pub(super) struct Selection {
    /// The selected rules; empty for all rules.
    pub(super) rules: Vec<String>,
    /// The selected categories; empty for all categories.
    pub(super) categories: BTreeSet<&'static str>,
    /// The lowest level.
    pub(super) level: Option<Level>,
    /// The selected files; `None` for all files.
    pub(super) files: Option<BTreeSet<SourceId>>,
}

impl Selection {
    /// True if the findings of a rule are selected.
    pub(super) fn has_rule(&self, rule: &str) -> bool {
        self.rules.is_empty() || self.rules.iter().any(|selected| selected == rule)
    }

    /// Removes the findings that are not selected. Returns the number of removed findings.
    pub(super) fn apply(
        &self,
        is_rule: impl Fn(&str) -> bool,
        sources: &SourceMap,
        findings: &mut Vec<Finding>,
    ) -> usize {
        let count = |findings: &[Finding]| findings.chunk_by(Finding::is_same_change).count();
        let before = count(findings);
        findings.retain(|finding| {
            let has_category = finding.category.is_none_or(|category| self.categories.contains(category));
            !is_rule(finding.rule)
                || self.has_rule(finding.rule)
                    && (self.categories.is_empty() || has_category)
                    && self
                        .files
                        .as_ref()
                        .is_none_or(|files| files.contains(&sources.source_of(finding.span)))
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

impl Results<'_> {
    fn to_text(&self, format: FormatName, sources: &SourceMap) -> String {
        let Some(format) = format.format() else {
            return self.rendered(sources, false);
        };
        let entries = self.findings.iter().map(|finding| Entry::of(finding, sources)).collect();
        let report = Report { command: self.totals.command, rules: self.rules.clone(), entries };
        report.to_text_with_totals(format, self.totals)
    }

    /// The results as text for a terminal.
    fn rendered(&self, sources: &SourceMap, styled: bool) -> String {
        let mut text = render::findings(self.findings, sources, styled);
        text += if self.findings.is_empty() { "" } else { "\n" };
        // For a single rule, omit the table, which would repeat the last line.
        match self.totals.rules.len() {
            0 | 1 => text + &self.totals.headline() + "\n",
            _ => text + &self.totals.to_text(),
        }
    }

    fn to_summary(&self, format: FormatName) -> String {
        match format.format() {
            Some(format) => self.totals.to_summary(format).unwrap_or_default(),
            None => self.totals.to_text(),
        }
    }
}

impl ReportArgs {
    /// Checks that the options can be combined.
    pub(super) fn check(&self) -> Result<(), Failure> {
        let has_totals = matches!(self.format, FormatName::Text | FormatName::Json | FormatName::Github);
        if self.summary && !has_totals {
            // Code scanning would close the alert of each finding that is not in the report.
            let message = "a report in this format without findings would look like a successful run";
            return Err(Failure::new(message)
                .with_hint("use --summary with --format text, json or github, or remove --summary"));
        }
        target::check_distinct(&self.report)
    }

    /// Fails if a report, or standard output, would change an input.
    pub(super) fn protect<'i>(&self, inputs: impl Iterator<Item = &'i Path>) -> Result<(), Failure> {
        let inputs: Vec<&Path> = inputs.collect();
        protect_inputs(inputs.iter().copied())?;
        inputs.iter().try_for_each(|input| self.report.iter().try_for_each(|target| target.protect(input)))
    }

    /// Prints the results to standard output, and writes the report files.
    pub(super) fn show(&self, results: &Results<'_>, sources: &SourceMap) -> Result<(), Failure> {
        match self.format {
            format @ FormatName::Text if self.summary => {
                terminal::print(format_args!("{}", results.to_summary(format)));
            }
            FormatName::Text => print_results(|styled| results.rendered(sources, styled)),
            format if self.summary => print_report(&results.to_summary(format)),
            format => print_report(&results.to_text(format, sources)),
        }
        self.report.iter().try_for_each(|target| {
            let text = results.to_text(target.format, sources);
            match target.format {
                FormatName::Text => target.write(&guarded(&text)),
                _ => target.write(&text),
            }
        })
    }

    /// True if no finding is at the denied level or above.
    pub(super) fn is_success(&self, findings: &[Finding]) -> bool {
        findings.iter().all(|finding| finding.level < self.deny)
    }
}
