//! Temporary recordings. They are removed even if the process exits while a thread still writes one.

use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use tempfile::TempPath;

/// The temporary recordings of this process.
static PATHS: Paths = Paths(Mutex::new(BTreeSet::new()));

struct Paths(Mutex<BTreeSet<PathBuf>>);

/// A temporary recording, which is removed when it is dropped.
pub(super) struct Temporary(TempPath);

impl Temporary {
    /// Creates an empty file.
    pub(super) fn create() -> io::Result<Self> {
        let file = tempfile::Builder::new().prefix("uavspec-").suffix(".mcap").tempfile()?.into_temp_path();
        PATHS.lock().insert(file.to_path_buf());
        Ok(Self(file))
    }

    /// The path of the file.
    pub(super) fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        PATHS.lock().remove(self.path());
    }
}

/// Removes all temporary recordings. Must be called before the process exits without waiting for its threads.
pub fn remove_recordings() {
    PATHS.remove();
}

impl Paths {
    fn lock(&self) -> MutexGuard<'_, BTreeSet<PathBuf>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn remove(&self) {
        for path in std::mem::take(&mut *self.lock()) {
            // The file may be gone already, and nobody can react to an error.
            let _ = std::fs::remove_file(path);
        }
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
        let paths = Paths(Mutex::new([first.clone(), second].into()));
        paths.remove();
        assert!(!first.exists());
        assert!(paths.lock().is_empty());
    }

    #[test]
    fn forgets_files_that_were_dropped() {
        let temporary = Temporary::create().expect("a file");
        let path = temporary.path().to_owned();
        assert!(path.exists() && PATHS.lock().contains(&path));
        drop(temporary);
        assert!(!path.exists() && !PATHS.lock().contains(&path));
    }
}
