//! Paths of the repository.

use std::path::{Path, PathBuf};
use std::{env, fs};

/// The folder of this repository.
pub(crate) fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap_or(Path::new("."))
}

/// A path for display. A path inside the current folder is shown relative to that folder.
pub(crate) fn shown(path: &Path) -> PathBuf {
    let here = env::current_dir().and_then(fs::canonicalize).unwrap_or_default();
    // A path that doesn't exist has no canonical form.
    let whole = fs::canonicalize(path).or_else(|_| std::path::absolute(path));
    let whole = whole.unwrap_or_else(|_| path.to_path_buf());
    whole.strip_prefix(&here).map_or_else(|_| path.to_path_buf(), Path::to_path_buf)
}
