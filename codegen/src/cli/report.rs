//! Findings to the terminal, or to another program.

use std::io::{self, Write as _};

use clap::{Args, ValueEnum};

use super::print::print_rendered;
use crate::diagnostic::Level;
use crate::finding::Finding;
use crate::render;
use crate::report::{Entry, Format, Report, RuleInfo};
use crate::source::SourceMap;

/// How to report, and what makes a command fail.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct ReportArgs {
    /// The least level that makes the command fail.
    #[arg(long, value_name = "LEVEL", default_value = "error")]
    deny: Denied,
    /// How to report: text goes to standard error, all else to standard output.
    #[arg(long, default_value = "text")]
    format: FormatName,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Denied {
    /// Anything.
    Note,
    /// Warnings and errors.
    Warning,
    /// Errors.
    Error,
}

impl Denied {
    fn level(self) -> Level {
        match self {
            Self::Note => Level::Note,
            Self::Warning => Level::Warning,
            Self::Error => Level::Error,
        }
    }
}

/// A format of reports.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum FormatName {
    /// For people: each finding with its line.
    Text,
    /// A JSON list.
    Json,
    /// Annotations of a workflow on GitHub.
    Github,
    /// SARIF 2.1.0, for code scanning.
    Sarif,
    /// Results of tests as XML, for CI systems that show them.
    Junit,
}

impl FormatName {
    /// The format of the report; none for people.
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

impl ReportArgs {
    /// Prints findings of `command`, whose `rules` were applied; whether none is denied.
    pub(super) fn show(
        self,
        command: &'static str,
        rules: Vec<RuleInfo>,
        findings: &[Finding],
        sources: &SourceMap,
    ) -> bool {
        match self.format.format() {
            None => print_rendered(|styled| render::findings(findings, sources, styled)),
            Some(format) => {
                let entries = findings.iter().map(|finding| Entry::of(finding, sources)).collect();
                let text = Report { command, rules, entries }.to_text(format);
                // A reader that has seen enough closes the pipe: that is no failure.
                let _ = io::stdout().write_all(text.as_bytes());
            }
        }
        findings.iter().all(|finding| finding.level < self.deny.level())
    }
}
