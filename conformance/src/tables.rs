//! The results of checks as tables, for SQL and dataframes.
//!
//! ```text
//!  Subject ──row──▶ captures, topics, findings, rules ──batch──▶ Parquet or Arrow files
//! ```
//!
//! Other programs check captures with a [`Checker`], and receive the tables in memory.
//!
//! A table states each column once: its name, type, unit and meaning, and the value of a row. The schema in the files, the
//! batches and the documentation follow from this.

#[cfg(not(feature = "tables"))]
mod absent;
#[cfg(feature = "tables")]
mod captures;
#[cfg(feature = "tables")]
mod checker;
#[cfg(feature = "tables")]
mod column;
#[cfg(feature = "tables")]
mod dataset;
#[cfg(feature = "tables")]
mod done;
#[cfg(feature = "tables")]
mod failures;
#[cfg(feature = "tables")]
mod find;
#[cfg(feature = "tables")]
mod findings;
#[cfg(feature = "tables")]
mod messages;
#[cfg(feature = "tables")]
mod rows;
#[cfg(feature = "tables")]
mod rules;
#[cfg(all(test, feature = "tables"))]
mod tests;
#[cfg(feature = "tables")]
mod timeline;
#[cfg(feature = "tables")]
mod topics;

use crate::capture::input::Input;

#[cfg(not(feature = "tables"))]
pub(crate) use self::absent::{Dataset, Done};
#[cfg(feature = "tables")]
pub use self::checker::{Capture, Checked, Checker, Options, Problem, Story, Tables};
#[cfg(feature = "tables")]
pub(crate) use self::dataset::Dataset;
#[cfg(feature = "tables")]
pub(crate) use self::done::Done;
#[cfg(feature = "tables")]
pub use self::find::find;
#[cfg(feature = "tables")]
pub use self::messages::Messages;

/// A format of files with tables.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum TableFormat {
    Parquet,
    /// The file format of Arrow IPC.
    Arrow,
}

impl TableFormat {
    pub(crate) const ALL: [Self; 2] = [Self::Parquet, Self::Arrow];

    /// The name on the command line, and the extension of the files.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Parquet => "parquet",
            Self::Arrow => "arrow",
        }
    }
}

/// The facts about the origin of a capture that a report doesn't contain.
#[derive(Clone, Debug, Default)]
#[cfg_attr(not(feature = "tables"), allow(dead_code, reason = "the tables contain them"))]
pub(crate) struct Origin {
    /// The size in bytes, before decompression.
    pub(crate) size: Option<u64>,
    /// The version that an object store states.
    pub(crate) etag: Option<String>,
}

impl Origin {
    /// The facts about an input.
    pub(crate) fn of(input: &Input) -> Self {
        Self { size: input.size(), etag: input.etag().map(str::to_owned) }
    }
}
