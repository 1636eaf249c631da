//! Temporary recordings. They are removed even if the process exits while a thread still writes to one of them.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempPath;

/// The temporary recordings of this process.
static PATHS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn paths() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    PATHS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A temporary recording, which is removed when it is dropped.
pub(super) struct Temporary(TempPath);

impl Temporary {
    /// Creates an empty file.
    pub(super) fn create() -> io::Result<Self> {
        let file = tempfile::Builder::new().prefix("uavspec-").suffix(".mcap").tempfile()?.into_temp_path();
        paths().insert(file.to_path_buf());
        Ok(Self(file))
    }

    /// The path of the file.
    pub(super) fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        paths().remove(self.path());
    }
}

/// Removes all temporary recordings. Must be called before the process exits without waiting for its threads.
pub fn remove_recordings() {
    remove(std::mem::take(&mut *paths()));
}

fn remove(paths: BTreeSet<PathBuf>) {
    for path in paths {
        // The file may already be gone, and nobody could react to an error.
        let _ = std::fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn removes_files_before_the_process_exits() {
        let folder = tempfile::tempdir().expect("a folder");
        let [first, second] = ["a", "b"].map(|name| folder.path().join(name));
        std::fs::write(&first, "data").expect("a file");
        remove([first.clone(), second].into());
        assert!(!first.exists());
    }

    #[test]
    fn forgets_files_that_were_dropped() {
        let temporary = Temporary::create().expect("a file");
        let path = temporary.path().to_owned();
        assert!(path.exists() && paths().contains(&path));
        drop(temporary);
        assert!(!path.exists() && !paths().contains(&path));
    }
}
