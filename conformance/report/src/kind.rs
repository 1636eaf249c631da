//! The formats of reports.

use std::io::{self, BufRead, Write};

use clap::ValueEnum;

use super::codequality::CodeQuality;
use super::html::Html;
use super::json::Json;
use super::junit::Junit;
use super::markdown::Markdown;
use super::sarif::Sarif;
use super::short::Short;
use super::text::Text;
use super::{Action, Report, Subject};

/// The report parts of all added subjects, one after the other.
pub(super) type Parts<'p> = &'p mut dyn BufRead;

/// A report in one format, under construction.
pub(super) trait Format {
    /// Adds a subject. Returns the part of the report about this subject. The part is empty if the format keeps it
    /// until the end.
    fn add(&mut self, subject: &Subject) -> String;

    /// Writes the whole report. `report` may contain no subjects, but its totals include all subjects that were added.
    fn finish(self: Box<Self>, report: &Report, parts: Parts<'_>, to: &mut dyn Write) -> io::Result<()>;
}

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
    /// Starts a report of a command. `command` is the command line that reproduces the report.
    ///
    /// The formats escape all text of the input. A guard escapes any hidden characters that a format misses. In JSON,
    /// the escapes lose nothing. The guard for the terminal also recognizes colours, so it handles text.
    pub(super) fn format(self, action: Action, command: &str) -> Box<dyn Format> {
        match self {
            Self::Text => Box::new(Text),
            Self::Short => Box::new(Short),
            Self::Json => Box::new(Json),
            Self::Junit => Box::<Junit>::default(),
            Self::Sarif => Box::<Sarif>::default(),
            Self::Codequality => Box::<CodeQuality>::default(),
            Self::Html => Box::new(Html::new(action, command)),
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

    /// The name on the command line, which is also the extension of the files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Arrow => "arrow",
        }
    }
}
