//! Atomic changes to user files: either all files are written or none.
//!
//! ```
//! use uavspec_schema::rewrite::{Change, write};
//!
//! let folder = tempfile::tempdir()?;
//! let path = folder.path().join("Wind.msg");
//! std::fs::write(&path, "float32  speed\n")?;
//! let [old, new] = ["float32  speed\n", "float32 speed\n"].map(str::to_owned);
//! write(&[Change { path: path.clone(), shown: "Wind.msg".to_owned(), old, new: new.clone() }])?;
//! assert_eq!(std::fs::read_to_string(&path)?, new);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use tempfile::TempPath;

use crate::failure::Failure;
use crate::stage::Stage;

/// A change to a file.
#[derive(Debug)]
pub struct Change {
    /// The file, with symbolic links resolved.
    pub path: PathBuf,
    /// The displayed path.
    pub shown: String,
    /// The current content.
    pub old: String,
    /// The new content.
    pub new: String,
}

/// Replaces the files. All changes are staged first, so nothing changes if the disk is full.
pub fn write(changes: &[Change]) -> Result<(), Failure> {
    let mut stages = BTreeMap::new();
    let mut files = Vec::with_capacity(changes.len());
    for change in changes {
        files.push(stage(change, &mut stages).map_err(|error| unwritable(change, &error))?);
    }
    for (change, file) in changes.iter().zip(files) {
        file.persist(&change.path).map_err(|error| unwritable(change, &error.error))?;
    }
    Ok(())
}

/// Writes the new content to a temporary folder next to the changed file, with the same permissions.
fn stage<'c>(change: &'c Change, stages: &mut BTreeMap<&'c Path, Stage>) -> io::Result<TempPath> {
    let permissions = fs::metadata(&change.path)?.permissions();
    if permissions.readonly() {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
    }
    let folder = change.path.parent().unwrap_or(Path::new(""));
    let stage = match stages.entry(folder) {
        Entry::Occupied(stage) => stage.into_mut(),
        Entry::Vacant(entry) => entry.insert(Stage::new(folder)?),
    };
    let mut file = stage.file(Some(permissions))?;
    file.write_all(change.new.as_bytes())?;
    Ok(file.into_temp_path())
}

fn unwritable(change: &Change, error: &io::Error) -> Failure {
    Failure::new(format!("{}: {error}", change.shown))
        .with_hint("check that the file and its folder are writable")
}
