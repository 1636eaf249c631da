//! Folders of packages, and folders without definitions.

use std::fs;
use std::path::Path;

use uavspec_schema::name::package_problem;
use walkdir::DirEntry;

/// The manifest of a ROS package.
pub(super) const MANIFEST: &str = "package.xml";

/// The files that mark folders with build output: of colcon, of `CMake`, and of Cargo and other tools.
const MARKERS: [&str; 3] = ["COLCON_IGNORE", "CMakeCache.txt", "CACHEDIR.TAG"];

/// True for hidden folders, and for folders with build output.
pub(super) fn is_skipped(entry: &DirEntry) -> bool {
    let name = entry.file_name().to_string_lossy();
    let is_output = || MARKERS.iter().any(|marker| entry.path().join(marker).exists());
    entry.file_type().is_dir() && (name.starts_with('.') || name == "node_modules" || is_output())
}

/// The name in the manifest of a ROS package.
pub fn manifest_name(root: &Path) -> Option<String> {
    let text = fs::read_to_string(root.join(MANIFEST)).ok()?;
    let (_, rest) = text.split_once("<name>")?;
    let (name, _) = rest.split_once("</name>")?;
    let name = name.trim();
    package_problem(name).is_none().then(|| name.to_owned())
}
