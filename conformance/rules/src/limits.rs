//! The limits on what this crate reads and stores. They bound the time and the memory that hostile input takes.

// Flockwave sessions.

/// The maximum size of a message in several lines or pieces, in bytes. A longer text is not treated as a message.
pub const MAX_INCOMPLETE: usize = 1 << 20;

/// The maximum number of lines in a message.
pub(crate) const MAX_LINES: usize = 10_000;

/// The maximum number of connections for which incomplete messages, or the state of a rule, are stored. If there are
/// more connections, the connections with the lowest indices are dropped.
pub const MAX_CONNECTIONS: usize = 16;

/// The maximum size of a stored list, in bytes. The ids of ten thousand UAVs fit.
pub(crate) const MAX_LISTED: usize = 1 << 19;

/// The maximum number of stored open operations per connection.
pub(crate) const MAX_OPEN: usize = 1_000;

/// The maximum number of stored cancelled operations per connection.
pub(crate) const MAX_CANCELLED: usize = 1_000;

/// The maximum number of stored answered requests.
pub(crate) const MAX_ANSWERED: usize = 1_000;

/// The maximum number of stored objects from filtered lists.
pub(crate) const MAX_OBJECTS: usize = 10_000;

/// The maximum number of stored unknown UAVs per connection.
pub(crate) const MAX_UNKNOWN: usize = 1_000;

/// The maximum number of UAVs per connection.
pub(crate) const MAX_UAVS: usize = 1_000;

// Vehicles.

/// The maximum number of endpoints of a topic that are compared.
pub(crate) const MAX_PER_TOPIC: usize = 256;

/// The maximum number of topics.
pub(crate) const MAX_TOPICS: usize = 10_000;

/// The maximum number of compared pairs.
pub(crate) const MAX_PAIRS: usize = 10_000;

/// The maximum number of types, of topics, and of differences.
pub(crate) const MAX_ITEMS: usize = 10_000;

// Definitions.

/// The maximum number of loaded definitions that stay in memory. Each contains releases, and messages of other
/// releases.
pub(crate) const MAX_STORED: usize = 8;

/// The maximum number of logs' formats for which definitions keep plans, and the maximum number of fields of a plan that is
/// kept.
pub(crate) const MAX_PLANS: usize = 2;
pub(crate) const MAX_SHARED_FIELDS: usize = 1 << 10;

/// The maximum size of the schemas in bags that stay in memory, in bytes, and their maximum number. The bags of a vehicle
/// have up to about a hundred. Types take up to fifty times as much memory as their text.
pub(crate) const MAX_SHARED_SCHEMA: usize = 16 << 10;
pub(crate) const MAX_SHARED_SCHEMAS: usize = 128;

/// The maximum number of captured event metadata that stay in memory.
pub(crate) const MAX_SHARED_EVENTS: usize = 8;
