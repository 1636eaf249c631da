//! Finds captures for other programs.

use std::path::PathBuf;

use arrow_array::RecordBatch;

use super::Origin;
use super::checker::Problem;
use super::column::{Column, Table};
use crate::capture::input::{self, Input};
#[cfg(feature = "stores")]
use crate::capture::store;
use crate::text::{shown_url, terminal};

static TABLE: Table<(String, Origin)> = Table {
    name: "found",
    description: "A capture that was found.",
    columns: &[
        Column::text("capture", "The path or URL.", |(name, _)| Some(name)),
        Column::count("size", "The size before decompression.", |(_, origin): &(String, Origin)| origin.size)
            .in_unit("B"),
        Column::text("etag", "The version that the object store states.", |(_, origin)| {
            origin.etag.as_deref()
        }),
    ],
};

/// Finds the captures that files, folders, patterns and URLs denote, like `uavspec check`. The table has the columns
/// `capture`, `size` and `etag`, which are those of the table `captures`.
///
/// # Errors
/// Fails if a folder or link can't be read, or if an input yields no captures.
pub fn find(inputs: &[PathBuf]) -> Result<RecordBatch, Problem> {
    let mut rows = Vec::new();
    for input in inputs {
        let problem = |reason: String| Problem::of(&shown_url(&input.to_string_lossy()), reason);
        let found = captures(input).map_err(problem)?;
        rows.extend(found.iter().map(|capture| (capture.name(), Origin::of(capture))));
    }
    TABLE.batch(&rows).map_err(|error| Problem::new(error.to_string()))
}

/// The captures that an input denotes, or the reason why there are none.
fn captures(input: &PathBuf) -> Result<Vec<Input>, String> {
    #[cfg(feature = "stores")]
    if let Some(url) = input.to_str().filter(|_| store::is_url(input)) {
        let captures = store::list(url)?.captures;
        if captures.is_empty() {
            return Err(store::NOTHING.to_owned());
        }
        return Ok(captures.into_iter().map(Input::Object).collect());
    }
    let files = input::files(std::slice::from_ref(input)).map_err(|(_, reason)| reason)?;
    match files.unreadable.into_iter().chain(files.empty).next() {
        Some((path, reason)) if path == *input => Err(reason),
        Some((path, reason)) => Err(format!("{}: {reason}", terminal::path(&path))),
        None => Ok(files.captures.into_iter().map(Input::Path).collect()),
    }
}
