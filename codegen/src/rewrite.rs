//! Atomic changes to user files: either all files are written or none.
//!
//! ```
//! use uavspec_codegen::rewrite::{Change, write};
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
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

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
    for (index, change) in changes.iter().enumerate() {
        files.push(stage(change, index, &mut stages).map_err(|error| unwritable(change, &error))?);
    }
    for (change, file) in changes.iter().zip(files) {
        fs::rename(file, &change.path).map_err(|error| unwritable(change, &error))?;
    }
    Ok(())
}

/// Writes the new content to a temporary folder in the same folder, with the same permissions.
fn stage<'c>(
    change: &'c Change,
    index: usize,
    stages: &mut BTreeMap<&'c Path, Stage>,
) -> io::Result<PathBuf> {
    let permissions = fs::metadata(&change.path)?.permissions();
    if permissions.readonly() {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
    }
    let folder = change.path.parent().unwrap_or(Path::new(""));
    if !stages.contains_key(folder) {
        stages.insert(folder, Stage::new(folder)?);
    }
    let file = stages.get(folder).map(|stage| stage.path().join(index.to_string())).unwrap_or_default();
    fs::write(&file, &change.new)?;
    fs::set_permissions(&file, permissions)?;
    Ok(file)
}

fn unwritable(change: &Change, error: &io::Error) -> Failure {
    Failure::new(format!("{}: {error}", change.shown))
        .with_hint("check that the file and its folder are writable")
}
