//! The formats of reports.

use clap::ValueEnum;
use uavspec_codegen::terminal::guarded;

use super::{Report, html, json, junit, markdown, sarif, short, text};

/// A format of a report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Kind {
    /// Text for a terminal.
    Text,
    /// One line for each finding, for editors and grep.
    Short,
    /// JSON with all details.
    Json,
    /// `JUnit` XML for CI systems.
    Junit,
    /// SARIF 2.1.0 for editors and code scanning.
    Sarif,
    /// A self-contained HTML page.
    Html,
    /// Markdown for pull requests and CI summaries.
    Markdown,
}

impl Report {
    /// Renders the report. [`Kind::Text`] contains terminal colours, which `anstream` can remove.
    ///
    /// The formats escape all text of the input. The guard escapes hidden characters that a format misses.
    pub fn to_text(&self, kind: Kind) -> String {
        let text = match kind {
            // The guard of the terminal knows colours.
            Kind::Text => return text::write(self),
            // JSON escapes hidden characters without loss.
            Kind::Json => return json::write(self),
            Kind::Sarif => return sarif::write(self),
            Kind::Short => short::write(self),
            Kind::Junit => junit::write(self),
            Kind::Html => html::write(self),
            Kind::Markdown => markdown::write(self),
        };
        guarded(&text).into_owned()
    }
}
