//! The limits on what this crate reads and stores. They bound the time and the memory that hostile input takes.

/// The maximum size of an answer, in bytes. Ranges of objects are smaller, and so are the parts of lists.
pub(crate) const MAX_ANSWER: usize = 32 << 20;

/// The maximum number of requests for a list. Stores send 1,000 objects in each part.
pub(crate) const MAX_REQUESTS: u64 = 10_000;

/// The maximum number of redirects of a request.
pub(crate) const MAX_REDIRECTS: usize = 5;

/// The maximum size of a list of URLs, in bytes. The limit also applies to the URLs of the objects in a folder.
pub(crate) const MAX_LIST: u64 = 32 << 20;

/// The maximum number of servers and buckets in a list.
pub(crate) const MAX_SERVERS: usize = 100;

/// The maximum size of an object, in bytes.
pub(crate) const MAX_OBJECT: u64 = 1 << 40;
