//! Output of findings, to the terminal or to another program.

use std::io::{self, Write as _};

use clap::{Args, ValueEnum};

use super::print::print_rendered;
use crate::diagnostic::Level;
use crate::finding::Finding;
use crate::render;
use crate::report::{Entry, Format, Report, RuleInfo};
use crate::source::SourceMap;

/// The report format, and the lowest level of finding that makes a command fail.
#[derive(Args, Clone, Copy, Debug)]
pub(super) struct ReportArgs {
    /// Fail if a finding is at this level or above
    #[arg(long, value_name = "LEVEL", default_value = "error")]
    deny: Denied,
    /// Report format; text goes to standard error, other formats to standard output
    #[arg(long, default_value = "text")]
    format: FormatName,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Denied {
    /// All findings
    Note,
    /// Warnings and errors
    Warning,
    /// Errors only
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
    /// Readable text that quotes the line of each finding
    Text,
    /// A JSON list
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

impl ReportArgs {
    /// Prints the findings of `command`, which applied `rules`. Returns true if the command succeeds.
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
                // It is not an error if the reader closes the pipe early.
                let _ = io::stdout().write_all(text.as_bytes());
            }
        }
        findings.iter().all(|finding| finding.level < self.deny.level())
    }
}
