//! Limits on the input and the stored data, which bound the time and the memory that hostile input takes.

// Files.

/// The maximum length of a source, in bytes. The longest known definition is shorter than 60 kB.
pub(crate) const MAX_SOURCE_LEN: usize = 4 << 20;

/// The maximum number of symbolic links to follow, as on Linux.
pub(crate) const MAX_LINKS: usize = 40;

// `.msg` files.

/// The maximum length of an array or string. The size of the whole message is checked later.
pub(crate) const MAX_ARRAY: u32 = 16 << 20;

/// The maximum number of invalid lines in a file. A file with more invalid lines is not a definition.
pub(crate) const MAX_BAD_LINES: usize = 1_000;

/// The maximum length of a unit; longer text in brackets is prose.
pub(crate) const MAX_UNIT_LEN: usize = 20;

/// The maximum length of an annotation. The limit makes the search for `]` linear.
pub(crate) const MAX_ANNOTATION_LEN: usize = 400;

/// The maximum length of a file name, in bytes. All common file systems accept this length.
pub(crate) const MAX_NAME_LEN: usize = 255;

/// The maximum size of a message. No PX4 or ROS 2 transport carries larger messages.
pub const MAX_MESSAGE_SIZE: u64 = 16 << 20;

/// The maximum number of fields of a message, including nested fields. Hashing visits each field.
pub const MAX_NESTED_FIELDS: u64 = 1 << 20;

/// The maximum number of levels below a message. Emitters recurse once per level, so this limit bounds the stack. Real
/// messages nest up to seven levels deep.
pub(crate) const MAX_NESTING: u64 = 1_000;

/// The maximum total number of fields in all messages, including nested fields. The limit exists because computing the
/// hashes visits each field. The largest PX4 release has a few thousand fields.
pub(crate) const MAX_NESTED_FIELDS_IN_ALL: u64 = 1 << 22;

/// The maximum total number of enum members.
pub(crate) const MAX_MEMBERS: usize = 1 << 20;

// Event metadata.

/// The maximum length of event metadata, in bytes. The longest known file has 160 kB.
pub const MAX_EVENTS_LEN: usize = 1 << 20;

/// The maximum number of values in event metadata. The largest known file has 4,000 values. A value of a few bytes
/// takes up to 500 bytes when it is parsed.
pub(crate) const MAX_EVENT_VALUES: usize = 1 << 16;

/// The maximum memory that xz may reserve, in KiB. PX4's build uses a dictionary of 64 MiB. Decompression uses no more
/// of the dictionary than the length of the file.
pub(crate) const MAX_XZ_MEMORY: u32 = 66 << 10;

/// The maximum number of mistakes that are reported for a file, and for a package.
pub(crate) const MAX_MISTAKES: usize = 1_000;

/// The maximum number of names that are compared to suggest a name for an unknown type.
pub(crate) const MAX_COMPARED_NAMES: usize = 10_000;

/// The maximum length of a text of an event, in bytes. Reading a hostile text takes time proportional to the square of its
/// length.
pub(crate) const MAX_EVENT_TEXT: usize = 4 << 10;

// Tables.

/// The maximum nesting depth of a type in a table.
pub(crate) const MAX_TYPE_DEPTH: usize = 16;

/// The maximum number of alternatives in a type. A limit is needed because each alternative is compared with all
/// others.
pub(crate) const MAX_ALTERNATIVES: usize = 32;

/// The maximum number of JSON types on a path of references. Emitters recurse once per type, so this limit bounds the stack.
pub(crate) const MAX_JSON_DEPTH: usize = 1_000;

/// The maximum number of alternatives of an alias or union, including the alternatives of referenced types.
pub(crate) const MAX_JSON_ALTERNATIVES: usize = 256;
