//! The limits on what this crate reads and stores. They bound the time and the memory that hostile input takes.

// Compressed files and links.

/// The maximum number of links to folders that a search follows. Folders that link to each other in several ways could
/// yield any number of paths.
pub(crate) const MAX_LINKS: usize = 10_000;

// MCAP.

/// The maximum length of a buffered record of an MCAP file, and of a message in a `SQLite` file, in bytes: twice the size of a
/// large image.
pub const MAX_RECORD: u64 = 64 << 20;

/// The maximum size of a compressed chunk, in bytes.
pub(crate) const MAX_PACKED: u64 = 256 << 20;

/// The maximum plausible length of a compression name, in bytes.
pub(crate) const MAX_PACKING: usize = 64;

/// The maximum number of bytes after the known fields of a fixed-size record, of a chunk, or of an attachment. Later
/// versions of the format may add fields at the end of all records except messages.
pub(crate) const MAX_ADDED: u64 = 4_096;

// rosbag2.

/// The maximum size of a `metadata.yaml`, in bytes. The topics of a large robot take up a tenth of this space.
pub(crate) const MAX_METADATA: usize = 4 << 20;

/// The maximum number of files in a bag.
pub(crate) const MAX_BAG_FILES: usize = 10_000;

/// The maximum number of topics in a bag.
pub(crate) const MAX_BAG_TOPICS: usize = 1 << 16;

/// The maximum number of nested lists and mappings in a `metadata.yaml`. rosbag2 nests at most nine.
pub(crate) const MAX_METADATA_DEPTH: usize = 32;

/// The maximum number of topics, and of message definitions, in a `SQLite` file.
pub(crate) const MAX_ROWS: usize = 10_000;

/// The maximum number of characters of a name that are read from a `SQLite` file. Longer names are rejected later.
pub(crate) const MAX_NAME: usize = 300;

/// The maximum memory of all databases that are open at the same time, in bytes. Payloads don't count.
pub(crate) const MAX_HEAP: i64 = 96 << 20;

// ULog.

/// The maximum number of formats. PX4 has 261 messages. A log could use 65,536 ids, but no real log does.
pub(crate) const MAX_FORMATS: usize = 8_192;

/// The maximum total size of formats and topics, in bytes. The formats of real logs take 22 to 32 kB. Types take up to
/// fifty times as much memory as their text, so a malicious log uses at most about 50 MB of memory.
pub(crate) const MAX_FORMAT_TEXT: usize = 1 << 20;

/// The maximum size of formats that logs share, in bytes, and the maximum number of logs whose formats are stored.
pub(crate) const MAX_SHARED_TEXT: usize = 1 << 17;
pub(crate) const MAX_SHARED: usize = 8;

/// The maximum total size of compiled formats, in bytes. A format counts each time it is compiled. The limit is
/// sufficient for a log that writes each of PX4's 261 formats just before the first data of its topic. Because of the
/// limit, a malicious log can cause at most two seconds of work.
pub(crate) const MAX_COMPILED: usize = 16 << 20;
