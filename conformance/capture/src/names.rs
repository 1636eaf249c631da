//! The names of captures.

use std::path::{Path, PathBuf};

/// The file extensions that identify captures in a folder. A compression extension may follow.
pub(super) const EXTENSIONS: [&str; 7] = ["ulg", "ulge", "mcap", "db3", "json", "jsonl", "ndjson"];

/// The file extension of ROS 1 bags.
pub(super) const ROS1_EXTENSION: &str = "bag";

/// The extensions of compressed files. rosbag2 uses `zstd`.
const PACKED: [&str; 3] = ["gz", "zst", "zstd"];

/// The reason for skipping a file that has no capture extension.
pub const NOT_A_CAPTURE: &str = "no capture has this extension";

/// The file extensions of bags.
const BAG_EXTENSIONS: [&str; 2] = ["mcap", "db3"];

/// True if the file name has a capture extension.
pub fn is_capture(path: &Path) -> bool {
    has_extension(&unpacked(path), &EXTENSIONS)
}

/// True if the file name has the extension of a bag.
pub(super) fn is_bag(path: &Path) -> bool {
    has_extension(&unpacked(path), &BAG_EXTENSIONS)
}

/// The path without the extension of a compression.
fn unpacked(path: &Path) -> PathBuf {
    if has_extension(path, &PACKED) { path.with_extension("") } else { path.to_path_buf() }
}

/// True if the file name has one of these extensions.
pub(super) fn has_extension(path: &Path, extensions: &[&str]) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    extension.is_some_and(|found| extensions.iter().any(|known| found.eq_ignore_ascii_case(known)))
}
