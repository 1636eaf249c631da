//! The formats of reports.

use clap::ValueEnum;

use super::codequality::CodeQuality;
use super::format::Format;
use super::html::Html;
use super::json::Json;
use super::junit::Junit;
use super::markdown::Markdown;
use super::sarif::Sarif;
use super::short::Short;
use super::spool::Spool;
use super::text::Text;

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
    /// Code Quality report of GitLab.
    Codequality,
    /// A self-contained HTML page.
    Html,
    /// Markdown for pull requests and CI summaries.
    Markdown,
}

impl Kind {
    /// Starts a report. Formats that can only write subjects at the end of the run store them in `spool`.
    ///
    /// The formats escape all text of the input. A guard escapes hidden characters that a format misses. JSON escapes
    /// hidden characters without loss. The guard of the terminal handles text, because it knows colours.
    pub(super) fn format(self, spool: Spool) -> Box<dyn Format> {
        match self {
            Self::Text => Box::new(Text(spool)),
            Self::Short => Box::new(Short(spool)),
            Self::Json => Box::new(Json::new(spool)),
            Self::Junit => Box::new(Junit::new(spool)),
            Self::Sarif => Box::new(Sarif::new(spool)),
            Self::Codequality => Box::new(CodeQuality::new(spool)),
            Self::Html => Box::<Html>::default(),
            Self::Markdown => Box::<Markdown>::default(),
        }
    }
}

/// A format of files with tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// Parquet files.
    Parquet,
    /// The file format of Arrow IPC.
    Arrow,
}

impl TableFormat {
    /// All formats.
    pub const ALL: [Self; 2] = [Self::Parquet, Self::Arrow];

    /// The name on the command line, and the extension of the files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Arrow => "arrow",
        }
    }
}
