//! The limits on the amount of data that this crate reads and stores. They bound the time and the memory that hostile
//! input can use.

// Bags.

/// The maximum number of fields in the types of all channels, including the fields of each nested message. A thousand
/// PX4 topics have a quarter of this number.
pub(crate) const MAX_BAG_FIELDS: usize = 1 << 18;

/// The maximum number of channels in a bag.
pub(crate) const MAX_BAG_CHANNELS: usize = 1 << 16;

/// The maximum number of types that are compared to find the release.
pub(crate) const MAX_TYPES: usize = 10_000;

/// The maximum length of a metadata record that is read to find the distribution, in bytes.
pub(crate) const MAX_METADATA: u64 = 4 << 20;

/// The maximum depth of compared objects in a JSON Schema. Definitions don't nest more deeply than this.
pub(crate) const MAX_SCHEMA_DEPTH: usize = 32;

/// The maximum number of consecutive references to follow in a JSON Schema.
pub(crate) const MAX_REFERENCES: usize = 8;

/// The maximum number of topics whose publishers and subscribers are listed.
pub(crate) const MAX_TOPICS: usize = 10_000;

/// The maximum number of publishers, and of subscribers, that are listed for a topic.
pub(crate) const MAX_ENDPOINTS: usize = 100;

/// The maximum total size of stored schemas, in bytes. Five hundred ROS 2 types with their nested types use half of it.
pub(crate) const MAX_SCHEMAS: usize = 8 << 20;

/// The maximum size of a stored schema, in bytes.
pub const MAX_SCHEMA: usize = 1 << 20;

/// The maximum size of a decompressed `SQLite` file, in bytes.
pub(crate) const MAX_UNPACKED: u64 = 16 << 30;

/// The maximum number of files of a bag that are read to find its release.
pub(crate) const MAX_FILES: usize = 16;

// Logs.

/// The maximum number of fields in the formats whose values are checked, including the fields of each nested message.
/// Real logs have a few thousand. Without a limit, nested arrays could multiply the fields indefinitely.
pub(crate) const MAX_LOG_FIELDS: usize = 1 << 16;

// JSON messages.

/// The maximum number of topics and types. Hostile input may contain arbitrarily many.
pub(crate) const MAX_CHANNELS: usize = 10_000;

/// The maximum number of bytes that are read to find the release.
pub(crate) const MAX_CLUE_BYTES: u64 = 1 << 20;

/// The maximum total length of the messages that are stored to find the release, in bytes.
pub(crate) const MAX_CLUE_TEXT: usize = 4 << 20;

// Flockwave sessions.

/// The maximum number of connections. Hostile input may contain arbitrarily many.
pub(crate) const MAX_CONNECTIONS: usize = 10_000;

/// The maximum length of a connection name, in bytes.
pub(crate) const MAX_CONNECTION_NAME: usize = 128;

/// The maximum number of unknown types that are counted by name. Hostile input may contain arbitrarily many.
pub(crate) const MAX_UNKNOWN_TYPES: usize = 1_000;

/// The maximum length of an unknown type's name, in bytes.
pub(crate) const MAX_TYPE_NAME: usize = 128;

/// The maximum number of pieces of a text. The limit matters because the whole text is parsed again for each piece.
pub(crate) const MAX_PIECES: usize = 1_000;

/// The maximum number of messages that are read from one line.
pub(crate) const MAX_MESSAGES: usize = 10_000;

/// The maximum number of versions in status reports, and also of kinds of states. Hostile input may contain arbitrarily
/// many of both.
pub(crate) const MAX_KNOWN: usize = 256;

/// The maximum length, in bytes, of stored versions and stored lists of error codes.
pub(crate) const MAX_KNOWN_TEXT: usize = 256;

// Results.

/// The maximum number of topics or types that are listed by name. Hostile input may contain arbitrarily many.
pub(crate) const MAX_PARTS: usize = 10_000;

/// The maximum number of distinct corrupt parts to report.
pub(crate) const MAX_CORRUPT_PARTS: usize = 100;

/// The maximum number of notes.
pub(crate) const MAX_NOTES: usize = 100;

// Timelines.

/// The maximum number of lanes.
pub(crate) const MAX_LANES: usize = 2_000;

/// The maximum number of changes that a lane contains. Further changes are only counted.
pub const MAX_CHANGES: usize = 500;

/// The maximum number of changes in all lanes together. Further changes are only counted.
pub const MAX_ALL_CHANGES: usize = 10_000;

/// The maximum number of distinct values in a lane, not counting the value that represents all others.
pub(crate) const MAX_VALUES: usize = 500;

/// The maximum length of the name of a lane, in characters.
pub(crate) const MAX_LANE_NAME: usize = 160;

/// The maximum number of PX4 events that are stored, in addition to the changes of their lane.
pub(crate) const MAX_EVENTS: usize = 100_000;

/// The maximum number of components whose names are stored. PX4 supports far fewer components.
pub(crate) const MAX_COMPONENTS: usize = 256;

/// The maximum number of UAVs in a timeline. Further UAVs are ignored.
pub(crate) const MAX_UAVS: usize = 1_000;

/// The maximum length of an id of a UAV or a connection, in bytes.
pub(crate) const MAX_ID: usize = 128;

/// The maximum number of error codes in one status.
pub(crate) const MAX_CODES: usize = 256;

// Conversions.

/// The maximum total size of the schemas and channels in a file, in bytes. This includes the names of attachments and
/// metadata records, because the index of the output contains them. The limit also applies to the schemas in the
/// output.
pub(crate) const MAX_CONVERTED_SCHEMAS: usize = 64 << 20;

/// The maximum size of an attachment that is kept in memory, in bytes. A larger attachment is stored in a temporary
/// file until it is complete.
pub(crate) const MAX_ATTACHMENT: usize = 16 << 20;

/// The maximum total size of the JSON messages that wait for a decision about their type, in bytes. The channel that
/// exceeds the limit is copied.
pub(crate) const MAX_WAITING: usize = 16 << 20;

/// The maximum number of topics of a converted log. A log has at most 8,192 formats, but hostile logs may subscribe to more
/// topics.
pub(crate) const MAX_LOG_TOPICS: usize = 10_000;

/// The maximum number of parameters in a message of the output. PX4 has fewer than two thousand.
pub(crate) const MAX_PARAMETERS: usize = 5_000;

/// The maximum size of a message with texts or parameters of ROS 2, in bytes. A message with [`MAX_PARAMETERS`] has half of it.
pub(crate) const MAX_ROS_MESSAGE: usize = 1 << 20;

/// The maximum size of data that waits in memory, in bytes. More data waits in a temporary file.
pub(crate) const MAX_IN_MEMORY: usize = 4 << 20;

/// The maximum total size of a log's information and default parameters, in bytes.
pub(crate) const MAX_INFORMATION: usize = 4 << 20;

/// The maximum number of flights in a capture, and the maximum number of takeoffs and of landings in a flight.
pub(crate) const MAX_FLIGHTS: usize = 100;

/// The maximum number of refusals: periods in which a vehicle can't arm in a mode.
pub(crate) const MAX_REFUSALS: usize = 1_000;
