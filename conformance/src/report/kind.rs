//! The kinds of reports.

use clap::ValueEnum;

use super::{Report, html, json, junit, markdown, sarif, text};

/// A kind of report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// For people, at a terminal.
    Text,
    /// For programs: everything.
    Json,
    /// Results of tests as XML, for CI systems that show them.
    Junit,
    /// SARIF 2.1.0, for editors and code scanning.
    Sarif,
    /// For people: one page that needs nothing else.
    Html,
    /// For pull requests and summaries of CI.
    Markdown,
}

impl Report {
    /// The report as text of a kind. That for terminals has colours, which streams drop where they would not be
    /// shown.
    pub fn to_text(&self, kind: Kind) -> String {
        match kind {
            Kind::Text => text::write(self),
            Kind::Json => json::write(self),
            Kind::Junit => junit::write(self),
            Kind::Sarif => sarif::write(self),
            Kind::Html => html::write(self),
            Kind::Markdown => markdown::write(self),
        }
    }
}
