//! Searches folders for files. Follows symbolic links, and never opens a file.

use std::fs::{self, FileType};
use std::io;
use std::path::{Path, PathBuf};

use walkdir::WalkDir;

use crate::limits::MAX_LINKS;

/// The reason for skipping a link to one of the folders that contain it.
pub(super) const CYCLE: &str = "a link to a folder that contains it";

/// The reason for skipping a link without a target.
pub(super) const DANGLING: &str = "a link whose target doesn't exist";

/// Something that a search has found.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// A file, or a link to a file.
    File(PathBuf),
    /// A link without a target.
    Dangling(PathBuf),
    /// An entry that has no content or was found before, with the reason for skipping it.
    Skipped(PathBuf, &'static str),
    /// A folder or link that can't be read, and the reason.
    Unreadable(PathBuf, String),
}

/// Passes the entries of a folder and its subfolders to `take`, sorted by path, but not the subfolders themselves.
/// Unreadable subfolders don't end the search.
pub(super) fn search(folder: &Path, max_depth: usize, mut take: impl FnMut(Found)) {
    let mut links = 0;
    let walk = WalkDir::new(folder).follow_links(true).max_depth(max_depth).sort_by_file_name();
    let mut entries = walk.into_iter();
    while let Some(entry) = entries.next() {
        let found = match entry {
            Err(error) => failed(folder, &error),
            Ok(entry) if entry.file_type().is_file() => Found::File(path_of(entry.path())),
            Ok(entry) if !entry.file_type().is_dir() => {
                Found::Skipped(path_of(entry.path()), kind(entry.file_type()))
            }
            Ok(entry) => {
                links += usize::from(entry.depth() > 0 && entry.path_is_symlink());
                if links <= MAX_LINKS {
                    continue;
                }
                links = MAX_LINKS;
                entries.skip_current_dir();
                let reason = format!("not searched: there are more than {MAX_LINKS} links to folders");
                Found::Unreadable(path_of(entry.path()), reason)
            }
        };
        take(found);
    }
}

/// The result for something that can't be read.
fn failed(folder: &Path, error: &walkdir::Error) -> Found {
    let path = path_of(error.path().unwrap_or(folder));
    if error.loop_ancestor().is_some() {
        return Found::Skipped(path, CYCLE);
    }
    let is_link = fs::symlink_metadata(&path).is_ok_and(|metadata| metadata.is_symlink());
    match error.io_error() {
        // The other errors concern links that lead nowhere, such as links to themselves.
        Some(error) if is_link && error.kind() != io::ErrorKind::PermissionDenied => Found::Dangling(path),
        Some(error) => Found::Unreadable(path, error.to_string()),
        None => Found::Unreadable(path, error.to_string()),
    }
}

/// A path as users write it. Paths found in `.` start with `./`, but users omit this prefix in patterns.
fn path_of(path: &Path) -> PathBuf {
    path.strip_prefix(".").unwrap_or(path).to_owned()
}

/// The kind of something that is neither a file nor a folder. Opening it could block or affect a device.
#[cfg(unix)]
fn kind(of: FileType) -> &'static str {
    use std::os::unix::fs::FileTypeExt as _;

    if of.is_fifo() {
        "a named pipe"
    } else if of.is_socket() {
        "a socket"
    } else if of.is_block_device() || of.is_char_device() {
        "a device"
    } else {
        "not a file"
    }
}

#[cfg(not(unix))]
fn kind(_: FileType) -> &'static str {
    "not a file"
}
