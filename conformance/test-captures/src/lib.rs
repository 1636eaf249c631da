//! Captures for tests: parts of logs, and writers of MCAP and `SQLite` bags, valid and invalid.

#![allow(clippy::missing_panics_doc, reason = "a panic is the failure of a test")]

pub mod mcap;
pub mod rosbag;

use uavspec_capture::ulog::Reader;

/// The messages of a log that begin within this size.
pub fn head_of_log(bytes: &[u8], size: usize) -> &[u8] {
    let mut reader = Reader::new(bytes);
    while let Some(item) = reader.next().expect("a slice") {
        if item.offset > size as u64 {
            return &bytes[..usize::try_from(item.offset).expect("an offset")];
        }
    }
    bytes
}
