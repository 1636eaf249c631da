//! The limits on the amount of data that this crate reads and stores. They bound the time and the memory that hostile
//! input can use.

// Recordings.

/// The maximum size of a recording, in bytes. A server can send any amount of data.
pub(crate) const MAX_RECORDED: u64 = 1 << 30;

/// The maximum size of the lines that are buffered until a Flockwave message arrives, in bytes.
pub(crate) const MAX_KEPT: usize = 4 << 20;

// Servers.

/// The maximum number of unanswered requests whose ids are stored.
pub(crate) const MAX_WAITING: usize = 1_000;

/// The maximum number of late messages to read at a time. The limit gives other connections their turn.
pub(crate) const MAX_LATE: usize = 1_000;

/// The maximum number of objects to request in detail.
pub(crate) const MAX_OBJECTS: usize = 50;

/// The maximum number of notes.
pub(crate) const MAX_NOTES: usize = 50;

// Testees.

/// The default maximum length of a line from a testee, in bytes.
pub const LINE_LIMIT: usize = 16 << 20;

/// The maximum number of bytes that are kept from the end of standard error.
pub(crate) const MAX_STDERR: usize = 8 << 10;

/// The maximum number of consecutive cases that crash the testee. A slow testee takes half a second to restart.
pub(crate) const MAX_CRASHES: u32 = 100;
