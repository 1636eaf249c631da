//! The limits on what this crate reads and stores. They bound the time and the memory that hostile input takes.

// Sessions.

/// The size limit of each list of remembered entries, in bytes.
pub(crate) const MAX_REMEMBERED: usize = 8 << 20;

/// The maximum length of a stored id, in bytes. Message ids have at most 36 characters, and object ids at most 64. Each
/// character has up to four bytes.
pub const MAX_ID: usize = 256;

/// The maximum length of the stored reason for a failure, in characters.
pub(crate) const MAX_FAILURE: usize = 200;

/// The maximum number of stored ids that are not strings, for each connection.
pub(crate) const MAX_ODD_IDS: usize = 64;

/// The maximum number of receipts in a message.
pub(crate) const MAX_RECEIPTS: usize = 10_000;

/// The maximum number of ids in a request. Longer lists are ignored.
pub(crate) const MAX_REQUEST_IDS: usize = 10_000;

// Message bodies.

/// The maximum number of deviations in a body. Hostile input may contain any number.
pub(crate) const MAX_DEVIATIONS: usize = 10_000;

/// The maximum number of values to visit in a body. A body has at most a million values, but nested alternatives can
/// cause each value to be visited many times.
pub(crate) const MAX_VISITS: usize = 1 << 21;

/// The maximum number of elements that are compared by their text in a list of unique elements.
pub(crate) const MAX_COMPARED: usize = 10_000;

// Transports.

/// The maximum number of Socket.IO packets received before the namespace is joined. Some servers send messages early.
pub(crate) const EARLY_LIMIT: usize = 1000;

/// The maximum number of redirects of an HTTP request.
pub(crate) const REDIRECT_LIMIT: usize = 5;

/// The maximum number of packets in a payload of long polling. Servers and clients send far fewer. Without a limit, a payload
/// of empty packets would use much more memory than its length.
pub(crate) const PACKET_LIMIT: usize = 1000;

/// The maximum size of the head of an HTTP request, in bytes. Browsers send one or two kilobytes.
pub(crate) const HEAD_LIMIT: usize = 32 << 10;

/// The maximum number of header lines in HTTP.
pub(crate) const HEADER_LIMIT: usize = 100;
