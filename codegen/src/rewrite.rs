//! Files of the user that a command changes: all of them or none.
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

use std::fs::{self, Permissions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::failure::Failure;

/// A file and what it should hold.
#[derive(Debug)]
pub struct Change {
    /// The file itself: no link leads on from here.
    pub path: PathBuf,
    /// Its path as it is shown.
    pub shown: String,
    /// What it holds.
    pub old: String,
    /// What it should hold.
    pub new: String,
}

/// Replaces the files. All is staged before any is put in place, so that a full disk leaves all as it was.
pub fn write(changes: &[Change]) -> Result<(), Failure> {
    let mut staged = Vec::with_capacity(changes.len());
    for change in changes {
        staged.push(stage(change).map_err(|error| unwritable(change, &error))?);
    }
    for (change, file) in changes.iter().zip(staged) {
        file.persist(&change.path).map_err(|error| unwritable(change, &error.error))?;
    }
    Ok(())
}

/// The new text in a file beside the old one, with the same permissions.
fn stage(change: &Change) -> io::Result<NamedTempFile> {
    let permissions: Permissions = fs::metadata(&change.path)?.permissions();
    if permissions.readonly() {
        return Err(io::Error::new(io::ErrorKind::PermissionDenied, "the file is read-only"));
    }
    let folder = change.path.parent().unwrap_or(Path::new(""));
    let mut file = tempfile::Builder::new().prefix(".uavspec-").tempfile_in(folder)?;
    file.write_all(change.new.as_bytes())?;
    file.as_file().set_permissions(permissions)?;
    Ok(file)
}

fn unwritable(change: &Change, error: &io::Error) -> Failure {
    Failure::new(format!("{}: {error}", change.shown))
        .with_hint("check that the file and its folder can be written")
}
