//! The limits on what this crate reads and stores. They bound the time and the memory that hostile input takes.

/// The maximum length of a path or subject in a plan, in characters. Each field of each entry has both, and names in
/// captures can have any length.
pub(crate) const MAX_PATH: usize = 256;

/// The number of findings in a payload that are reported separately. A small compressed payload can contain millions.
pub(crate) const MAX_REPORTED: usize = 10_000;

/// The maximum number of chunks of a health and arming report. PX4 sends one.
pub(crate) const MAX_CHUNKS: usize = 16;

/// The maximum number of problems in a report. PX4's buffer has room for fewer.
pub(crate) const MAX_PROBLEMS: usize = 64;
