//! Finds captures for other programs.

use std::path::PathBuf;

use arrow_array::RecordBatch;
use uavspec_capture::input::{self, Input};
use uavspec_model::text::{is_object_url, shown_url, terminal};
use uavspec_report::Origin;

use super::checker::Problem;
use super::column::{Column, Table};

static TABLE: Table<(String, Origin)> = Table {
    name: "found",
    description: "A capture that was found.",
    columns: &[
        Column::text("capture", "The path or URL.", |(name, _)| Some(name)),
        Column::count("size", "The size before decompression.", |(_, origin): &(String, Origin)| origin.size)
            .in_unit("B"),
        Column::text("etag", "The version in the object store.", |(_, origin)| origin.etag.as_deref()),
    ],
};

/// Finds the captures that files, folders, patterns and URLs denote, like `uavspec check`. The resulting table has the
/// columns `capture`, `size` and `etag` of the table `captures`.
///
/// # Errors
/// Fails if a folder or a link can't be read, or if an input contains no captures.
pub fn find(inputs: &[PathBuf]) -> Result<RecordBatch, Problem> {
    let mut rows = Vec::new();
    for input in inputs {
        let problem = |reason: String| Problem::of(&shown_url(&input.to_string_lossy()), reason);
        let found = captures(input).map_err(problem)?;
        rows.extend(found.iter().map(|capture| (capture.name(), Origin::of(capture))));
    }
    TABLE.batch(&rows).map_err(|error| Problem::new(error.to_string()))
}

/// Finds the capture with this path or URL.
///
/// # Errors
/// Fails if a URL doesn't denote exactly one object.
pub(super) fn named(name: &str) -> Result<Input, String> {
    if !is_object_url(name) {
        return Ok(Input::Path(name.into()));
    }
    let captures = list(name)?;
    let [capture] = <[Input; 1]>::try_from(captures)
        .map_err(|captures| format!("expected one capture, found {}", captures.len()))?;
    Ok(capture)
}

/// The captures that an input denotes. The error is the reason why there are none.
fn captures(input: &PathBuf) -> Result<Vec<Input>, String> {
    if let Some(url) = input.to_str().filter(|text| is_object_url(text)) {
        return list(url);
    }
    let files = input::files(std::slice::from_ref(input)).map_err(|(_, reason)| reason)?;
    match files.unreadable.into_iter().chain(files.empty).next() {
        Some((path, reason)) if path == *input => Err(reason),
        Some((path, reason)) => Err(format!("{}: {reason}", terminal::path(&path))),
        None => Ok(files.captures.into_iter().map(Input::Path).collect()),
    }
}

/// The captures that a URL denotes.
#[cfg(feature = "stores")]
fn list(url: &str) -> Result<Vec<Input>, String> {
    let captures = uavspec_stores::list(url)?.captures;
    if captures.is_empty() { Err(input::Listed::NOTHING.to_owned()) } else { Ok(captures) }
}

#[cfg(not(feature = "stores"))]
fn list(_: &str) -> Result<Vec<Input>, String> {
    Err("this crate was built without the feature `stores`".to_owned())
}
