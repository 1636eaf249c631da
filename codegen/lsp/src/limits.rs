//! Limits on the input and the stored data, which bound the time and the memory that hostile input takes.

/// The maximum number of files and folders that are searched. PX4 with all submodules has about 60,000.
pub(crate) const MAX_ENTRIES: usize = 200_000;

/// The maximum length of a message in bytes. The longest messages contain the text of a document.
pub(crate) const MAX_MESSAGE: u64 = 64 << 20;

/// The maximum length of a header line in bytes.
pub(crate) const MAX_HEADER: u64 = 4 << 10;

/// The maximum number of waiting messages. The server handles them together, so definitions are read once when an
/// editor opens many files.
pub(crate) const MAX_WAITING: usize = 256;
