//! The identity of files: several paths, symbolic links and hard links may lead to the same file.
//!
//! ```
//! use uavspec_schema::identity::Identity;
//!
//! let folder = tempfile::tempdir()?;
//! let identity = |name| Identity::of(&folder.path().join(name)).expect("a file");
//! assert!(identity("report").is_same(&identity("./report")));
//! assert!(!identity("report").is_same(&identity("other")));
//! # Ok::<(), std::io::Error>(())
//! ```

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::{env, io};

use same_file::Handle;

use crate::limits::MAX_LINKS;

/// The identity of a file that may not exist. Pipes and devices have none, because writing to them replaces nothing.
#[derive(Debug)]
pub struct Identity {
    /// The path with all links resolved.
    path: PathBuf,
    /// The file, if it exists.
    handle: Option<Handle>,
}

impl Identity {
    /// The file with this path; `None` for pipes, devices and folders.
    pub fn of(path: &Path) -> Option<Self> {
        // Don't open a pipe, because this would take data from its reader.
        let is_file = fs::metadata(path).map_or(true, |metadata| metadata.is_file());
        is_file.then(|| Self { path: real_path(path), handle: Handle::from_path(path).ok() })
    }

    /// The file to which standard output is redirected.
    pub fn standard_output() -> Option<Self> {
        Self::of_stream(Handle::stdout())
    }

    /// The file from which standard input is redirected.
    pub fn standard_input() -> Option<Self> {
        Self::of_stream(Handle::stdin())
    }

    fn of_stream(handle: io::Result<Handle>) -> Option<Self> {
        let handle = handle.ok().filter(|handle| is_file(handle.as_file()))?;
        Some(Self { path: PathBuf::new(), handle: Some(handle) })
    }

    /// True if both are the same file.
    pub fn is_same(&self, other: &Self) -> bool {
        match (&self.handle, &other.handle) {
            (Some(handle), Some(other)) => handle == other,
            _ => is_same_path(&self.path, &other.path),
        }
    }
}

fn is_file(file: &File) -> bool {
    file.metadata().is_ok_and(|metadata| metadata.is_file())
}

/// True if the real paths of two files that don't exist yet are equal.
fn is_same_path(left: &Path, right: &Path) -> bool {
    if cfg!(any(windows, target_os = "macos")) {
        // Ignore case, as the file systems of these platforms usually do.
        return left.to_string_lossy().to_lowercase() == right.to_string_lossy().to_lowercase();
    }
    left == right
}

/// The path of a file, with all links resolved. The file may be absent.
fn real_path(path: &Path) -> PathBuf {
    let mut path = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        let Ok(target) = fs::read_link(&path) else { break };
        path = path.parent().map_or_else(|| target.clone(), |parent| parent.join(&target));
    }
    fs::canonicalize(&path).or_else(|_| real_path_of_absent(&path)).unwrap_or(path)
}

fn real_path_of_absent(path: &Path) -> io::Result<PathBuf> {
    let absolute = env::current_dir()?.join(path);
    let (Some(parent), Some(name)) = (absolute.parent(), absolute.file_name()) else { return Ok(absolute) };
    Ok(fs::canonicalize(parent)?.join(name))
}
